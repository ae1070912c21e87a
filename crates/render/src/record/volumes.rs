//! Passes that draw the volumes which lights reach, as instances of one mesh for each shape.

use super::PreparedView;
use super::fullscreen::{Fullscreen, Shading, Slot};
use super::view::SHADOWED;
use crate::lights::{CASTING_LIGHTS, CONE_CORNER, CONE_SIDES, LIGHT_CLASSES, VolumeDraw, VolumeShape, VolumeStep};
use crate::shader::program::{Constant, ProgramError};
use crate::shader::{Pipeline, Program, Shaders, compose};
use glam::Vec3;
use manypass_graph::{ColorLoad, DepthLoad, Handle};
use std::cell::RefCell;
use std::collections::HashMap;
use std::f32::consts::TAU;
use std::ops::Range;
use std::sync::Arc;

/// The meshes of volumes, and the pipelines that draw them.
#[derive(Debug)]
pub(crate) struct Volumes {
    corners: wgpu::Buffer,
    indices: wgpu::Buffer,
    /// The indices of the ball and of the cone.
    elements: [Range<u32>; 2],
    pipelines: RefCell<HashMap<Key, Arc<VolumePipeline>>>,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Key {
    program: &'static str,
    axes: Vec<&'static str>,
    color: wgpu::TextureFormat,
    depth: wgpu::TextureFormat,
    step: VolumeStep,
    is_reflected: bool,
    constants: Vec<Constant>,
}

impl Key {
    /// The pipeline that draws one class of lights with a program and its axes.
    fn of(
        draw: &VolumeDraw,
        (program, axes): (&'static str, &[&'static str]),
        (color, depth): (wgpu::TextureFormat, wgpu::TextureFormat),
        view: &PreparedView,
    ) -> Self {
        let is_needed = |axis: &&'static str| *axis != SHADOWED || draw.classes & CASTING_LIGHTS != 0;
        let of_shape = (draw.shape == VolumeShape::Cone).then_some("cones");
        let constants = view.constants.iter().copied().filter(|(name, _)| *name != LIGHT_CLASSES);
        Self {
            program,
            axes: axes.iter().copied().filter(is_needed).chain(of_shape).collect(),
            color,
            depth,
            step: draw.step,
            is_reflected: view.is_reflected(),
            // What marks is the same for all classes.
            constants: match draw.step {
                VolumeStep::Mark => Vec::new(),
                _ => constants.chain([(LIGHT_CLASSES, draw.classes)]).collect(),
            },
        }
    }
}

#[derive(Debug)]
struct VolumePipeline {
    program: Arc<Program>,
    pipeline: Pipeline,
}

impl Volumes {
    pub fn new(device: &wgpu::Device) -> Self {
        let (mut corners, ball) = ball();
        let (cone_corners, cone) = cone();
        let first = corners.len() as u16;
        corners.extend(cone_corners);
        let indices: Vec<u16> = ball.iter().copied().chain(cone.iter().map(|index| index + first)).collect();
        let corners: Vec<[f32; 3]> = corners.iter().map(Vec3::to_array).collect();
        let end = indices.len() as u32;
        let elements = [0..ball.len() as u32, ball.len() as u32..end];
        let vertex = wgpu::BufferUsages::VERTEX;
        Self {
            corners: filled(device, "volumes.corners", vertex, bytemuck::cast_slice(&corners)),
            indices: filled(device, "volumes.indices", wgpu::BufferUsages::INDEX, bytemuck::cast_slice(&indices)),
            elements,
            pipelines: RefCell::default(),
        }
    }

    fn pipeline(
        &self,
        shaders: &Shaders,
        device: &wgpu::Device,
        key: Key,
    ) -> Result<Arc<VolumePipeline>, ProgramError> {
        if let Some(pipeline) = self.pipelines.borrow().get(&key) {
            return Ok(pipeline.clone());
        }
        let (axes, on) = compose::axes_and_constants(key.program, &key.axes);
        let program = shaders.program(key.program, &axes)?;
        let constants = [&key.constants[..], &on].concat();
        let (device, made_of, of) = (device.clone(), program.clone(), key.clone());
        let pipeline = shaders.pipeline(move || create(&device, &made_of, &of, &constants));
        let pipeline = Arc::new(VolumePipeline { program, pipeline });
        self.pipelines.borrow_mut().insert(key, pipeline.clone());
        Ok(pipeline)
    }
}

fn filled(device: &wgpu::Device, label: &str, usage: wgpu::BufferUsages, bytes: &[u8]) -> wgpu::Buffer {
    let size = bytes.len().next_multiple_of(4) as u64;
    let buffer =
        device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: true });
    // A device that was lost maps nothing; it has nothing to draw either.
    if let Ok(mut mapped) = buffer.slice(..bytes.len() as u64).get_mapped_range_mut() {
        mapped.copy_from_slice(bytes);
    }
    buffer.unmap();
    buffer
}

/// How the pixels of a step are chosen. Meshes are closed and convex, so that of each a pixel has one back and at most
/// one front: to invert the bit for each of both that lies behind the surface leaves it set where the surface lies
/// between them, and where the eye is inside as well, because there is no front.
fn depth_stencil(key: &Key) -> wgpu::DepthStencilState {
    let keep = wgpu::StencilOperation::Keep;
    let (compare, face, mask) = match key.step {
        // Depth is reversed: what lies behind the surface is less.
        VolumeStep::Shade => (wgpu::CompareFunction::LessEqual, wgpu::StencilFaceState::IGNORE, 0),
        VolumeStep::Mark => {
            let invert = wgpu::StencilOperation::Invert;
            let compare = wgpu::CompareFunction::Always;
            let face = wgpu::StencilFaceState { compare, fail_op: keep, depth_fail_op: invert, pass_op: keep };
            (wgpu::CompareFunction::GreaterEqual, face, 1)
        }
        VolumeStep::ShadeMarked => {
            let zero = wgpu::StencilOperation::Zero;
            let compare = wgpu::CompareFunction::Equal;
            let face = wgpu::StencilFaceState { compare, fail_op: keep, depth_fail_op: keep, pass_op: zero };
            (wgpu::CompareFunction::Always, face, 1)
        }
    };
    wgpu::DepthStencilState {
        format: key.depth,
        depth_write_enabled: Some(false),
        depth_compare: Some(compare),
        stencil: wgpu::StencilState { front: face, back: face, read_mask: mask, write_mask: mask },
        bias: Default::default(),
    }
}

fn create(device: &wgpu::Device, program: &Program, key: &Key, constants: &[Constant]) -> wgpu::RenderPipeline {
    let is_marking = matches!(key.step, VolumeStep::Mark);
    let specialised = program.specialised(constants);
    let corner = wgpu::VertexAttribute { format: wgpu::VertexFormat::Float32x3, offset: 0, shader_location: 0 };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(key.program),
        layout: Some(&program.layout),
        vertex: wgpu::VertexState {
            module: &specialised.module,
            entry_point: None,
            compilation_options: specialised.options(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: 12,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &[corner],
            })],
        },
        primitive: wgpu::PrimitiveState {
            front_face: if key.is_reflected { wgpu::FrontFace::Cw } else { wgpu::FrontFace::Ccw },
            cull_mode: (!is_marking).then_some(wgpu::Face::Front),
            ..Default::default()
        },
        depth_stencil: Some(depth_stencil(key)),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &specialised.module,
            entry_point: None,
            compilation_options: specialised.options(),
            targets: &[Some(wgpu::ColorTargetState {
                format: key.color,
                blend: Some(super::ADD),
                write_mask: if is_marking { wgpu::ColorWrites::empty() } else { wgpu::ColorWrites::ALL },
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}

impl Fullscreen<'_, '_> {
    /// Declares the pass, which adds to `target` what the program gives for the pixels of volumes, as `draws` say. The
    /// program has an axis or a constant `cones`; another, called like it with `_mark` behind, marks. Returns the
    /// versions of `target` and `depth` that hold the result; depth itself stays what it is, and its stencil is 0
    /// again.
    ///
    /// # Errors
    /// A program that does not compile, or declares what nobody binds.
    pub(crate) fn draw_volumes(
        self,
        target: Handle,
        depth: Handle,
        mark: &'static str,
        draws: &[VolumeDraw],
    ) -> Result<(Handle, Handle), ProgramError> {
        let Shading::Program(name, axes) = &self.shading else { return Ok((target, depth)) };
        let formats = (target.desc().format, depth.desc().format);
        let mut steps: Vec<(Arc<VolumePipeline>, Vec<Slot>, VolumeDraw)> = Vec::with_capacity(draws.len());
        for draw in draws {
            let program = if draw.step == VolumeStep::Mark { (mark, &[][..]) } else { (*name, &axes[..]) };
            let key = Key::of(draw, program, formats, self.view);
            let pipeline = self.frame.volumes.pipeline(self.frame.shaders, &self.frame.gpu.device, key)?;
            let slots = self.slots(&pipeline.program)?;
            steps.push((pipeline, slots, draw.clone()));
        }
        let Self { mut pass, frame, view, .. } = self;
        let target = pass.color(target, ColorLoad::Keep);
        let has_marks = draws.iter().any(|draw| draw.step != VolumeStep::Shade);
        let depth = if has_marks {
            pass.depth_stencil(depth, DepthLoad::Keep)
        } else {
            pass.depth_stencil_read_only(&depth);
            depth
        };
        pass.count_draws(steps.len());
        pass.draw(move |context| {
            let groups: Option<Vec<_>> = steps
                .into_iter()
                .map(|(pipeline, slots, draw)| {
                    let resources: Option<Vec<_>> = slots.into_iter().map(|slot| slot.resource(context)).collect();
                    let group = frame.bind_groups.of_program(context.device, &pipeline.program, 1, resources?);
                    Some((pipeline, group, draw))
                })
                .collect();
            let Some(groups) = groups else { return };
            let render_pass = &mut *context.render_pass;
            let Volumes { corners, indices, elements, .. } = frame.volumes;
            render_pass.set_bind_group(0, &view.group, &[]);
            render_pass.set_vertex_buffer(0, corners.slice(..));
            render_pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint16);
            render_pass.set_stencil_reference(1);
            for (pipeline, group, draw) in &groups {
                render_pass.set_pipeline(&pipeline.pipeline);
                if let Some(group) = group {
                    render_pass.set_bind_group(1, group, &[]);
                }
                let [of_ball, of_cone] = elements.clone();
                let elements = if draw.shape == VolumeShape::Ball { of_ball } else { of_cone };
                render_pass.draw_indexed(elements, 0, draw.instances.clone());
            }
        });
        Ok((target, depth))
    }
}

/// The corners and triangles of an icosahedron whose faces are cut in four, all around a ball of radius 1.
fn ball() -> (Vec<Vec3>, Vec<u16>) {
    // Three rectangles whose sides are in the golden ratio.
    const LONG: f32 = 1.618_034;
    let mut corners = Vec::new();
    for (a, b) in [(1.0, LONG), (1.0, -LONG), (-1.0, LONG), (-1.0, -LONG)] {
        corners.extend([Vec3::new(0.0, a, b), Vec3::new(a, b, 0.0), Vec3::new(b, 0.0, a)].map(Vec3::normalize));
    }
    let is_edge = |a: usize, b: usize| corners[a].dot(corners[b]) > 0.4;
    let mut faces = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            faces.extend((b + 1..12).filter(|c| is_edge(a, b) && is_edge(b, *c) && is_edge(a, *c)).map(|c| [a, b, c]));
        }
    }
    let mut indices: Vec<u16> = Vec::new();
    for [a, b, c] in faces {
        let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(a, b)| {
            let middle = (corners[a] + corners[b]).normalize();
            corners.iter().position(|corner| corner.distance(middle) < 1e-3).unwrap_or_else(|| {
                corners.push(middle);
                corners.len() - 1
            })
        });
        let cut = [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]];
        indices.extend(cut.into_iter().flatten().map(|index| index as u16));
    }
    turn_outwards(&corners, Vec3::ZERO, &mut indices);
    let scale = nearest_face(&corners, &indices).recip();
    corners.iter_mut().for_each(|corner| *corner *= scale);
    (corners, indices)
}

/// How near to the origin the plane of a face lies.
fn nearest_face(corners: &[Vec3], indices: &[u16]) -> f32 {
    let plane = |face: &[u16]| {
        let [a, b, c] = [0, 1, 2].map(|i| corners[usize::from(face[i])]);
        (b - a).cross(c - a).normalize().dot(a)
    };
    indices.chunks_exact(3).map(plane).fold(f32::INFINITY, f32::min)
}

/// The corners and triangles of a cone. Of a corner, x says which ring it is of (0 the tip, 1 the rim, 2 the end, 3 its
/// middle), y and z where on a circle around the axis; `volume_vertex.wgsl` knows how far along and how wide the rings
/// are.
fn cone() -> (Vec<Vec3>, Vec<u16>) {
    let around = |i: u32| {
        let (sin, cos) = (TAU * i as f32 / CONE_SIDES as f32).sin_cos();
        (cos * CONE_CORNER, sin * CONE_CORNER)
    };
    let ring = |ring: f32| (0..CONE_SIDES).map(around).map(move |(y, z)| Vec3::new(ring, y, z));
    let mut corners = vec![Vec3::ZERO];
    corners.extend(ring(1.0).chain(ring(2.0)));
    corners.push(Vec3::new(3.0, 0.0, 0.0));
    let sides = CONE_SIDES as u16;
    let end = 2 * sides + 1;
    let mut indices = Vec::new();
    for i in 0..sides {
        let next = (i + 1) % sides;
        let ([a, b], [c, d]) = ([i + 1, next + 1], [i + 1 + sides, next + 1 + sides]);
        indices.extend([0, a, b, a, c, b, b, c, d, c, end, d]);
    }
    // Along the axis, which is the cross product of the directions of y and z.
    let shown: Vec<Vec3> = corners.iter().map(|corner| placed(*corner)).collect();
    turn_outwards(&shown, Vec3::new(0.0, 0.0, 0.6), &mut indices);
    (corners, indices)
}

/// A corner of a cone of 45° and length 1 whose axis is +Z, as `volume_vertex.wgsl` places it.
fn placed(corner: Vec3) -> Vec3 {
    let ring = corner.x as usize;
    let (along, wide) = ([0.0, 0.707, 1.0, 1.0][ring], [0.0, 0.707, 0.414, 0.0][ring]);
    Vec3::new(corner.y * wide, corner.z * wide, along)
}

/// Turns triangles so that they show their front to the outside, away from `middle`.
fn turn_outwards(corners: &[Vec3], middle: Vec3, indices: &mut [u16]) {
    for face in indices.chunks_exact_mut(3) {
        let [a, b, c] = [0, 1, 2].map(|i| corners[usize::from(face[i])]);
        if (b - a).cross(c - a).dot(a - middle) < 0.0 {
            face.swap(1, 2);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lights::BALL_CORNER;

    /// Every edge belongs to two triangles, once in each direction.
    fn assert_closed(indices: &[u16]) {
        let edges = |face: &[u16]| [[face[0], face[1]], [face[1], face[2]], [face[2], face[0]]];
        let edges: Vec<[u16; 2]> = indices.chunks_exact(3).flat_map(edges).collect();
        for [a, b] in &edges {
            assert_eq!(edges.iter().filter(|edge| **edge == [*b, *a]).count(), 1, "{a} {b}");
        }
    }

    #[test]
    fn a_ball_is_enclosed() {
        let (corners, indices) = ball();
        assert_eq!((corners.len(), indices.len()), (42, 240));
        assert_closed(&indices);
        assert!((nearest_face(&corners, &indices) - 1.0).abs() < 1e-5);
        let farthest = corners.iter().map(|corner| corner.length()).fold(0.0, f32::max);
        assert!(farthest <= BALL_CORNER && farthest > 0.99 * BALL_CORNER, "{farthest}");
    }

    #[test]
    fn a_cone_is_enclosed() {
        let (corners, indices) = cone();
        assert_closed(&indices);
        let corners: Vec<Vec3> = corners.iter().map(|corner| placed(*corner)).collect();
        for face in indices.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|i| corners[usize::from(face[i])]);
            let normal = (b - a).cross(c - a).normalize();
            for i in 0..=20u8 {
                for turn in 0..40u8 {
                    let angle_rad = std::f32::consts::FRAC_PI_4 * f32::from(i) / 20.0;
                    let across =
                        Vec3::new((TAU * f32::from(turn) / 40.0).cos(), (TAU * f32::from(turn) / 40.0).sin(), 0.0);
                    let point = across * angle_rad.sin() + Vec3::Z * angle_rad.cos();
                    assert!(normal.dot(point - a) < 2e-3, "{point} lies outside of {a} {b} {c}");
                }
            }
        }
    }
}
