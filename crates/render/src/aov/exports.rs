//! The textures that variables are made of: out of the frame, and into memory.

use super::GbufferPixels;
use crate::frame::ViewOutputs;
use crate::gpu::{Gpu, readback};
use crate::request::RenderError;
use crate::view::ViewUniform;
use manypass_graph::{Graph, Handle, Run};

/// The names of the exported textures; none where the frame has no such target.
#[derive(Debug, Default)]
pub(crate) struct AovExports {
    /// Base colour, normal, material and linear depth.
    gbuffer: Option<[String; 4]>,
    emission: Option<String>,
    ids: Option<String>,
    motion: Option<String>,
}

impl AovExports {
    /// Exports every target of `outputs` that a variable is made of.
    pub fn new(graph: &mut Graph<'_>, outputs: ViewOutputs) -> Self {
        let mut export = |handle: Handle| {
            let name = handle.name().to_owned();
            graph.export(handle);
            name
        };
        Self {
            emission: outputs.emission.map(&mut export),
            ids: outputs.ids.map(&mut export),
            motion: outputs.motion.map(&mut export),
            gbuffer: outputs.gbuffer.map(|gbuffer| {
                [gbuffer.base_color, gbuffer.normal, gbuffer.material, gbuffer.linear_depth].map(export)
            }),
        }
    }

    /// Reads what [`Self::new`] exported, after `run` was submitted; none on the forward path. `view` is the view whose
    /// targets they are.
    ///
    /// # Errors
    /// The device was lost.
    pub async fn read(&self, gpu: &Gpu, run: &Run, view: ViewUniform) -> Result<Option<GbufferPixels>, RenderError> {
        let Some([base_color, normal, material, linear_depth]) = &self.gbuffer else { return Ok(None) };
        Ok(Some(GbufferPixels {
            view,
            base_color: read(gpu, run, base_color).await?,
            normal: read(gpu, run, normal).await?,
            material: read(gpu, run, material).await?,
            linear_depth: read(gpu, run, linear_depth).await?,
            emission: read_optional(gpu, run, self.emission.as_deref()).await?,
            ids: read_optional(gpu, run, self.ids.as_deref()).await?,
            motion: read_optional(gpu, run, self.motion.as_deref()).await?,
        }))
    }
}

async fn read_optional(gpu: &Gpu, run: &Run, name: Option<&str>) -> Result<Option<Vec<u8>>, RenderError> {
    match name {
        Some(name) => read(gpu, run, name).await.map(Some),
        None => Ok(None),
    }
}

async fn read(gpu: &Gpu, run: &Run, name: &str) -> Result<Vec<u8>, RenderError> {
    let texture = run.exported(name).ok_or(RenderError::Missing("an exported texture is missing"))?;
    Ok(readback::read_texture(gpu, texture).await?)
}
