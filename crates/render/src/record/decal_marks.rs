//! The pass that marks the pixels which decals may change, by their boxes.

use super::{PreparedView, Recorder};
use crate::shader::program::ProgramError;
use crate::shader::{Pipeline, Program, Shaders};
use manypass_graph::{DepthLoad, Handle};
use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::Arc;

/// The bit of the stencil that is set where decals may change surfaces. Light volumes and settled tiles have others.
pub(crate) const DECAL_BIT: u32 = 4;

/// Corners of the strip of triangles that is a box.
const STRIP: u32 = 14;

/// The pipelines that mark pixels.
#[derive(Debug, Default)]
pub(crate) struct DecalMarks {
    pipelines: RefCell<HashMap<Key, Arc<MarkPipeline>>>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Key {
    depth: wgpu::TextureFormat,
    /// Whether the near plane cuts the boxes.
    is_around: bool,
    is_reflected: bool,
}

#[derive(Debug)]
struct MarkPipeline {
    pipeline: Pipeline,
}

impl DecalMarks {
    fn pipeline(&self, shaders: &Shaders, device: &wgpu::Device, key: Key) -> Result<Arc<MarkPipeline>, ProgramError> {
        if let Some(pipeline) = self.pipelines.borrow().get(&key) {
            return Ok(pipeline.clone());
        }
        let program = shaders.program("decals_mark", &[])?;
        let (device, made_of) = (device.clone(), program.clone());
        let pipeline = shaders.pipeline(move || create(&device, &made_of, key));
        let pipeline = Arc::new(MarkPipeline { pipeline });
        self.pipelines.borrow_mut().insert(key, pipeline.clone());
        Ok(pipeline)
    }
}

fn create(device: &wgpu::Device, program: &Program, key: Key) -> wgpu::RenderPipeline {
    let specialised = program.specialised(&[("around", u32::from(key.is_around))]);
    let keep = wgpu::StencilOperation::Keep;
    let face = wgpu::StencilFaceState {
        compare: wgpu::CompareFunction::Always,
        fail_op: keep,
        depth_fail_op: keep,
        pass_op: wgpu::StencilOperation::Replace,
    };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("decals_mark"),
        layout: Some(&program.layout),
        vertex: wgpu::VertexState {
            module: &specialised.module,
            entry_point: None,
            compilation_options: specialised.options(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState {
            topology: wgpu::PrimitiveTopology::TriangleStrip,
            front_face: if key.is_reflected { wgpu::FrontFace::Cw } else { wgpu::FrontFace::Ccw },
            cull_mode: Some(if key.is_around { wgpu::Face::Front } else { wgpu::Face::Back }),
            ..Default::default()
        },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: key.depth,
            depth_write_enabled: Some(false),
            // Depth is reversed: a surface within the box lies behind its front. Where that is cut open it may lie anywhere.
            depth_compare: Some(match key.is_around {
                true => wgpu::CompareFunction::Always,
                false => wgpu::CompareFunction::GreaterEqual,
            }),
            stencil: wgpu::StencilState { front: face, back: face, read_mask: DECAL_BIT, write_mask: DECAL_BIT },
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: None,
        multiview_mask: None,
        cache: None,
    })
}

impl Recorder<'_, '_> {
    /// Declares the pass `name`, which marks in the stencil of `depth` where surfaces may lie within boxes of decals.
    /// Returns the version that holds the result.
    ///
    /// # Errors
    /// A program that does not compile.
    pub fn mark_decals(&mut self, name: &'static str, depth: Handle) -> Result<Handle, ProgramError> {
        let (frame, view) = (self.frame, self.view);
        let PreparedView { decal_draws, .. } = view;
        let mut steps = Vec::new();
        for (is_around, ranges) in [(false, &decal_draws.before), (true, &decal_draws.around)] {
            if !ranges.is_empty() {
                let key = Key { depth: depth.desc().format, is_around, is_reflected: view.is_reflected() };
                steps.push((frame.decal_marks.pipeline(frame.shaders, &frame.gpu.device, key)?, ranges));
            }
        }
        let mut pass = self.graph.pass(name);
        let depth = pass.depth_stencil(depth, DepthLoad::Keep);
        pass.count_draws(steps.iter().map(|(_, ranges)| ranges.len()).sum());
        pass.draw(move |context| {
            let render_pass = &mut *context.render_pass;
            render_pass.set_bind_group(0, &view.group, &[]);
            render_pass.set_stencil_reference(DECAL_BIT);
            for (MarkPipeline { pipeline, .. }, ranges) in steps.iter().map(|(pipeline, ranges)| (&**pipeline, ranges))
            {
                render_pass.set_pipeline(pipeline);
                ranges.iter().for_each(|range| render_pass.draw(0..STRIP, range.clone()));
            }
        });
        Ok(depth)
    }
}
