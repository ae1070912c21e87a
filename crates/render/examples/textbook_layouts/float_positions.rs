//! Positions and normals as floats, which a volume for every light adds its light from.
//!
//! Source: "A deferred renderer in TypeScript and WebGL 2.0", whose table of targets this is: position with specular
//! intensity, normal with specular power, diffuse colour, depth with stencil, and accumulation in the format of the
//! diffuse colour, which the geometry pass starts with ambient light and emission. Differences: diffuse colour and
//! accumulation are encoded as sRGB, so that 8 bits do; three 8-bit channels are four, because WebGPU draws to no
//! others. Two targets of RGBA32F are 32 bytes a sample already, which is all that WebGPU and WebGL 2 promise: there
//! colours have a second geometry pass.

use crate::content::Content;
use crate::device::{Buffers, DISPLAY, PassGeometry, Step, added_to, bind, bind_group, overwritten};
use crate::layout::Layout;
use manypass::graph::{ColorLoad, DepthLoad, Export, Graph, PassContext, ReadKey, TextureDesc};

const VECTOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
const DEPTH_STENCIL: wgpu::TextureFormat = wgpu::TextureFormat::Depth24PlusStencil8;

/// What WebGPU counts for all four targets together: 16 + 16 + 8 + 8, because RGBA8 counts 8.
pub const ONE_PASS_BYTES_PER_SAMPLE: u32 = 48;

pub struct FloatPositions {
    buffers: Buffers,
    /// All four targets; none where two passes draw two each.
    geometry: Option<wgpu::RenderPipeline>,
    vectors: wgpu::RenderPipeline,
    colours: wgpu::RenderPipeline,
    mark: wgpu::RenderPipeline,
    volume: wgpu::RenderPipeline,
    composite: wgpu::RenderPipeline,
}

impl FloatPositions {
    pub fn new(device: &wgpu::Device, content: &Content, aspect: f32, is_one_pass: bool) -> Self {
        let text = concat!(include_str!("common.wgsl"), include_str!("float_positions.wgsl"));
        let source = wgpu::ShaderSource::Wgsl(text.into());
        let label = Some("float_positions");
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label, source });
        let (less, equal) = (wgpu::CompareFunction::Less, wgpu::CompareFunction::Equal);
        let [vector, color] = [overwritten(VECTOR), overwritten(DISPLAY)];
        let geometry = |fragment, targets: &[wgpu::ColorTargetState], depth_compare| {
            let step = Step {
                drawn: PassGeometry::Surfaces,
                vertex: "vs_geometry",
                fragment,
                targets,
                cull_mode: Some(wgpu::Face::Back),
                depth_stencil: Some(wgpu::DepthStencilState {
                    depth_write_enabled: Some(depth_compare == less),
                    ..depth_stencil(depth_compare, Default::default(), 0)
                }),
            };
            step.pipeline(device, &module)
        };
        let all = [vector.clone(), vector.clone(), color.clone(), color.clone()];
        let composite = Step {
            drawn: PassGeometry::Fullscreen,
            vertex: "vs_composite",
            fragment: "fs_composite",
            targets: &all[3..],
            cull_mode: None,
            depth_stencil: None,
        };
        Self {
            buffers: Buffers::new(device, content, aspect),
            geometry: is_one_pass.then(|| geometry("fs_all", &all, less)),
            vectors: geometry("fs_vectors", &all[..2], less),
            colours: geometry("fs_colours", &all[2..], equal),
            mark: mark(device, &module),
            volume: volume(device, &module),
            composite: composite.pipeline(device, &module),
        }
    }
}

fn depth_stencil(
    depth_compare: wgpu::CompareFunction,
    face: wgpu::StencilFaceState,
    mask: u32,
) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: DEPTH_STENCIL,
        depth_write_enabled: Some(false),
        depth_compare: Some(depth_compare),
        stencil: wgpu::StencilState { front: face, back: face, read_mask: mask, write_mask: mask },
        bias: Default::default(),
    }
}

/// Inverts a bit of the stencil for the front and for the back of a volume where they lie behind the surface, so that
/// it is set where the surface lies between them.
fn mark(device: &wgpu::Device, module: &wgpu::ShaderModule) -> wgpu::RenderPipeline {
    let (keep, invert) = (wgpu::StencilOperation::Keep, wgpu::StencilOperation::Invert);
    let compare = wgpu::CompareFunction::Always;
    let face = wgpu::StencilFaceState { compare, fail_op: keep, depth_fail_op: invert, pass_op: keep };
    let nothing = wgpu::ColorTargetState { write_mask: wgpu::ColorWrites::empty(), ..overwritten(DISPLAY) };
    let step = Step {
        drawn: PassGeometry::Volumes,
        vertex: "vs_volume",
        fragment: "fs_mark",
        targets: &[nothing],
        cull_mode: None,
        depth_stencil: Some(depth_stencil(wgpu::CompareFunction::LessEqual, face, 1)),
    };
    step.pipeline(device, module)
}

/// Adds the light of a volume by its back faces where the bit is set, and clears it for the next.
fn volume(device: &wgpu::Device, module: &wgpu::ShaderModule) -> wgpu::RenderPipeline {
    let (keep, zero) = (wgpu::StencilOperation::Keep, wgpu::StencilOperation::Zero);
    let compare = wgpu::CompareFunction::Equal;
    let face = wgpu::StencilFaceState { compare, fail_op: keep, depth_fail_op: keep, pass_op: zero };
    let step = Step {
        drawn: PassGeometry::Volumes,
        vertex: "vs_volume",
        fragment: "fs_volume",
        targets: &[added_to(DISPLAY)],
        cull_mode: Some(wgpu::Face::Front),
        depth_stencil: Some(depth_stencil(wgpu::CompareFunction::Always, face, 1)),
    };
    step.pipeline(device, module)
}

impl Layout for FloatPositions {
    fn declare<'f>(&'f self, graph: &mut Graph<'f>, (width, height): (u32, u32)) -> Export {
        let desc = |format| TextureDesc::new_2d(width, height, format);
        let clear = ColorLoad::Clear(wgpu::Color::TRANSPARENT);
        let vectors = ["position", "normal"].map(|name| graph.texture(name, desc(VECTOR)));
        let colours = ["diffuse", "accumulation"].map(|name| graph.texture(name, desc(DISPLAY)));
        let depth = graph.texture("depth", desc(DEPTH_STENCIL));
        let geometry = self.geometry.as_ref();
        let mut pass = graph.pass(if geometry.is_some() { "geometry" } else { "geometry.vectors" });
        let [position, normal] = vectors.map(|target| pass.color(target, clear));
        let depth = pass.depth_stencil(depth, DepthLoad::Clear { depth: 1.0, stencil: 0 });
        let [diffuse, accumulation] = if let Some(pipeline) = geometry {
            let colours = colours.map(|target| pass.color(target, clear));
            pass.draw(|context| self.draw_surfaces(context, pipeline));
            colours
        } else {
            pass.draw(|context| self.draw_surfaces(context, &self.vectors));
            let mut pass = graph.pass("geometry.colours");
            pass.depth_stencil_read_only(&depth);
            let colours = colours.map(|target| pass.color(target, clear));
            pass.draw(|context| self.draw_surfaces(context, &self.colours));
            colours
        };

        let mut pass = graph.pass("light.volumes");
        let textures = [(1, pass.read(&position)), (2, pass.read(&normal)), (3, pass.read(&diffuse))];
        let accumulation = pass.color(accumulation, ColorLoad::Keep);
        pass.depth_stencil(depth, DepthLoad::Keep);
        pass.draw(move |context| self.draw_volumes(context, &textures));

        let display = graph.texture("display", desc(DISPLAY));
        let mut pass = graph.pass("composite");
        let accumulation = pass.read(&accumulation);
        let display = pass.color(display, ColorLoad::Discard);
        pass.draw(move |context| {
            bind(context, &self.composite, None, &[(4, accumulation)]);
            self.buffers.draw_fullscreen(context.render_pass, 0);
        });
        graph.export(display)
    }
}

impl FloatPositions {
    fn draw_surfaces(&self, context: &mut PassContext<'_, '_>, pipeline: &wgpu::RenderPipeline) {
        bind(context, pipeline, Some(&self.buffers.frame), &[]);
        self.buffers.draw_surfaces(context.render_pass, 0);
    }

    fn draw_volumes(&self, context: &mut PassContext<'_, '_>, textures: &[(u32, ReadKey)]) {
        let mark = bind_group(context, &self.mark, Some(&self.buffers.frame), &[]);
        let volume = bind_group(context, &self.volume, Some(&self.buffers.frame), textures);
        context.render_pass.set_stencil_reference(1);
        for light in 0..self.buffers.light_count {
            for (pipeline, group) in [(&self.mark, &mark), (&self.volume, &volume)] {
                context.render_pass.set_pipeline(pipeline);
                context.render_pass.set_bind_group(0, group, &[]);
                self.buffers.draw_volume(context.render_pass, light);
            }
        }
    }
}
