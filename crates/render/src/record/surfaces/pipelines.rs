//! The pipelines of programs that draw surfaces.

use crate::draws::{AXES, Axes, BINDING_AXES, DEFORMED, FADES, Faces, MASKED};
use crate::record::decal_marks::DECAL_BIT;
use crate::resources::{ATTRIBUTES, ATTRIBUTES_WITHOUT_SKINS, STRIDES};
use crate::shader::program::{Constant, ProgramError};
use crate::shader::{Pipeline, Program, Shaders, compose};
use manypass_scene::Topology;
use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::Arc;

/// Which targets a program draws into, and how.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Targets {
    /// The colour targets; without one no fragment is shaded.
    pub colors: Vec<wgpu::TextureFormat>,
    /// The same blend state for all, because the floor has one.
    pub blend: Option<wgpu::BlendState>,
    /// The format of depth.
    pub depth: wgpu::TextureFormat,
    /// Samples a texel, of all of them.
    pub samples: u32,
    /// Whether depth is written.
    pub depth_write: bool,
    /// The `override` constants of the shader that are not as declared.
    pub constants: Vec<(&'static str, u32)>,
    /// Whether vertices are drawn in place of what they form.
    pub vertices_alone: bool,
    /// Whether pixels alone are drawn that are marked for decals.
    pub marked: bool,
    /// Whether the sides are drawn that are turned away, in place of those that are seen.
    pub backs: bool,
}

/// The constant of `mask.wgsl` by which alpha says how many samples of a pixel a mask covers.
pub(super) const ALPHA_TO_COVERAGE: Constant = ("alpha_to_coverage", 1);

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Key {
    pub program: &'static str,
    pub axes: Axes,
    /// Axes that are on for all of a pass, or constants that are 1.
    pub pass_axes: Vec<&'static str>,
    pub targets: Targets,
    pub topology: Topology,
    pub faces: Faces,
    pub mirrored: bool,
}

/// A pipeline with its program.
#[derive(Debug)]
pub(crate) struct SurfacePipeline {
    pub program: Arc<Program>,
    pub pipeline: Pipeline,
}

impl PartialEq for SurfacePipeline {
    fn eq(&self, other: &Self) -> bool {
        self.pipeline == other.pipeline
    }
}

/// Every pipeline that draws surfaces made so far.
#[derive(Debug, Default)]
pub(crate) struct SurfacePipelines {
    pipelines: RefCell<HashMap<Key, Arc<SurfacePipeline>>>,
}

impl SurfacePipelines {
    pub(super) fn get(
        &self,
        shaders: &Shaders,
        device: &wgpu::Device,
        key: Key,
    ) -> Result<Arc<SurfacePipeline>, ProgramError> {
        if let Some(pipeline) = self.pipelines.borrow().get(&key) {
            return Ok(pipeline.clone());
        }
        let (mut axes, mut constants) = compose::axes_and_constants(key.program, &key.pass_axes);
        let binds = BINDING_AXES.iter().filter(|(axis, of)| key.axes & of != 0 && compose::has_axis(key.program, axis));
        axes.extend(binds.map(|(axis, _)| *axis));
        // The discs of points are cut out in any case, so that their masks, whose cutoff is 0 where there is none, are
        // on.
        let of_shape = key.axes | if key.topology == Topology::Points { MASKED } else { 0 };
        constants.extend(AXES.iter().enumerate().map(|(bit, axis)| (*axis, of_shape >> bit & 1)));
        constants.extend(&key.targets.constants);
        let program = shaders.program(key.program, &axes)?;
        let known = if key.axes & DEFORMED == 0 { ATTRIBUTES_WITHOUT_SKINS } else { ATTRIBUTES };
        let attributes = program.attributes(&known, STRIDES.len())?;
        let (device, made_of, of) = (device.clone(), program.clone(), key.clone());
        let pipeline = shaders.pipeline(move || create(&device, &made_of, &of, &attributes, &constants));
        let pipeline = Arc::new(SurfacePipeline { pipeline, program });
        self.pipelines.borrow_mut().insert(key, pipeline.clone());
        Ok(pipeline)
    }
}

/// Draws where the bit is set: another one than that of the reference, 0.
fn marked_for_decals() -> wgpu::StencilState {
    let compare = wgpu::CompareFunction::NotEqual;
    let face = wgpu::StencilFaceState { compare, ..wgpu::StencilFaceState::IGNORE };
    wgpu::StencilState { front: face, back: face, read_mask: DECAL_BIT, write_mask: 0 }
}

fn create(
    device: &wgpu::Device,
    program: &Program,
    key: &Key,
    attributes: &[Vec<wgpu::VertexAttribute>],
    constants: &[Constant],
) -> wgpu::RenderPipeline {
    let buffers: Vec<_> = attributes
        .iter()
        .zip(STRIDES)
        .enumerate()
        .filter(|(_, (attributes, _))| !attributes.is_empty())
        .map(|(index, (attributes, array_stride))| {
            Some(wgpu::VertexBufferLayout {
                array_stride,
                step_mode: if index == 2 { wgpu::VertexStepMode::Instance } else { wgpu::VertexStepMode::Vertex },
                attributes,
            })
        })
        .collect();
    let targets: Vec<_> = key
        .targets
        .colors
        .iter()
        .map(|format| {
            Some(wgpu::ColorTargetState {
                format: *format,
                blend: key.targets.blend,
                write_mask: wgpu::ColorWrites::ALL,
            })
        })
        .collect();
    let specialised = program.specialised(constants);
    // Without a colour target fragments are shaded to be dropped, if at all.
    let fades = key.targets.constants.contains(&(FADES, 1));
    let drops_fragments = key.axes & MASKED != 0 || fades || key.topology == Topology::Points;
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(key.program),
        layout: Some(&program.layout),
        vertex: wgpu::VertexState {
            module: &specialised.module,
            entry_point: None,
            compilation_options: specialised.options(),
            buffers: &buffers,
        },
        primitive: wgpu::PrimitiveState {
            topology: match key.topology {
                _ if key.targets.vertices_alone => wgpu::PrimitiveTopology::PointList,
                Topology::Lines => wgpu::PrimitiveTopology::LineList,
                Topology::Points | Topology::Triangles => wgpu::PrimitiveTopology::TriangleList,
            },
            front_face: if key.mirrored { wgpu::FrontFace::Cw } else { wgpu::FrontFace::Ccw },
            cull_mode: match key.faces {
                Faces::Both | Faces::Front if key.targets.backs => Some(wgpu::Face::Front),
                Faces::Back if key.targets.backs => Some(wgpu::Face::Back),
                Faces::Both => None,
                Faces::Front => Some(wgpu::Face::Back),
                Faces::Back => Some(wgpu::Face::Front),
            },
            ..Default::default()
        },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: key.targets.depth,
            depth_write_enabled: Some(key.targets.depth_write),
            // Depth is reversed: nearer is greater.
            depth_compare: Some(wgpu::CompareFunction::GreaterEqual),
            stencil: if key.targets.marked { marked_for_decals() } else { Default::default() },
            bias: Default::default(),
        }),
        multisample: wgpu::MultisampleState {
            count: key.targets.samples,
            alpha_to_coverage_enabled: key.targets.constants.contains(&ALPHA_TO_COVERAGE),
            ..Default::default()
        },
        fragment: (!targets.is_empty() || drops_fragments).then(|| wgpu::FragmentState {
            module: &specialised.module,
            entry_point: None,
            compilation_options: specialised.options(),
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}
