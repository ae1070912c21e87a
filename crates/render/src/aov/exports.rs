//! The textures that variables are made of: out of the frame, and into memory.

use super::GbufferPixels;
use crate::frame::ViewOutputs;
use crate::gpu::{Gpu, readback};
use crate::request::RenderError;
use crate::view::ViewUniform;
use manypass_graph::{Export, Graph, Run};

/// The exported textures; none where the frame has no such target.
#[derive(Debug, Default)]
pub(crate) struct AovExports {
    /// Base colour, normal, material and linear depth.
    gbuffer: Option<[Export; 4]>,
    emission: Option<Export>,
    ids: Option<Export>,
    motion: Option<Export>,
}

impl AovExports {
    /// Exports every target of `outputs` that a variable is made of.
    pub fn new(graph: &mut Graph<'_>, outputs: ViewOutputs) -> Self {
        Self {
            emission: outputs.emission.map(|handle| graph.export(handle)),
            ids: outputs.ids.map(|handle| graph.export(handle)),
            motion: outputs.motion.map(|handle| graph.export(handle)),
            gbuffer: outputs.gbuffer.map(|gbuffer| {
                [gbuffer.base_color, gbuffer.normal, gbuffer.material, gbuffer.linear_depth]
                    .map(|handle| graph.export(handle))
            }),
        }
    }

    /// Reads what [`Self::new`] exported, after `run` was submitted; none on the forward path. `output_size` is the
    /// picture's width and height.
    ///
    /// # Errors
    /// The device was lost.
    pub async fn read(
        &self,
        gpu: &Gpu,
        run: &Run,
        view: ViewUniform,
        output_size: (u32, u32),
    ) -> Result<Option<GbufferPixels>, RenderError> {
        let Some([base_color, normal, material, linear_depth]) = self.gbuffer else { return Ok(None) };
        Ok(Some(GbufferPixels {
            view,
            output_size,
            base_color: read(gpu, run, base_color).await?,
            normal: read(gpu, run, normal).await?,
            material: read(gpu, run, material).await?,
            linear_depth: read(gpu, run, linear_depth).await?,
            emission: read_optional(gpu, run, self.emission).await?,
            ids: read_optional(gpu, run, self.ids).await?,
            motion: read_optional(gpu, run, self.motion).await?,
        }))
    }
}

async fn read_optional(gpu: &Gpu, run: &Run, export: Option<Export>) -> Result<Option<Vec<u8>>, RenderError> {
    match export {
        Some(export) => read(gpu, run, export).await.map(Some),
        None => Ok(None),
    }
}

async fn read(gpu: &Gpu, run: &Run, export: Export) -> Result<Vec<u8>, RenderError> {
    let texture = run.exported(export).ok_or(RenderError::Missing("an exported texture is missing"))?;
    Ok(readback::read_texture(gpu, texture).await?)
}
