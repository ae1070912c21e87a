//! The textures that variables are made of: out of the frame, and into memory.

use super::{Aov, AovPixels, GbufferPixels};
use crate::gbuffer::ViewOutputs;
use crate::gpu::{Gpu, GpuError, readback};
use crate::view::ViewUniform;
use glam::Vec3;
use manypass_graph::{Export, Graph, Run};
use std::ops::Range;

/// The exported textures; none where the frame has no such target.
#[derive(Debug, Default)]
pub(crate) struct AovExports {
    /// Base colour, normal, material and linear depth.
    gbuffer: Option<[Export; 4]>,
    emission: Option<Export>,
    ids: Option<Export>,
    motion: Option<Export>,
    occlusion_screen: Option<Export>,
}

/// An exported texture is not there.
#[derive(Debug)]
pub(crate) struct MissingExport;

impl AovExports {
    /// Exports every target of `outputs` that a variable is made of.
    pub fn new(graph: &mut Graph<'_>, outputs: ViewOutputs) -> Self {
        Self {
            emission: outputs.emission.map(|handle| graph.export(handle)),
            ids: outputs.ids.map(|handle| graph.export(handle)),
            motion: outputs.motion.map(|handle| graph.export(handle)),
            occlusion_screen: outputs.occlusion_screen.map(|handle| graph.export(handle)),
            gbuffer: outputs.gbuffer.map(|gbuffer| {
                [gbuffer.base_color, gbuffer.normal, gbuffer.material, gbuffer.linear_depth]
                    .map(|handle| graph.export(handle))
            }),
        }
    }

    /// What [`Self::new`] exported, out of `run`; none on the forward path. `view` is the view whose targets they are,
    /// and `origin_m` is added to positions.
    ///
    /// # Errors
    /// An exported texture is not there.
    pub fn textures(&self, run: &Run, view: ViewUniform, origin_m: Vec3) -> Result<Option<AovTextures>, MissingExport> {
        let Some([base_color, normal, material, linear_depth]) = self.gbuffer else { return Ok(None) };
        let exported = |export: Export| run.exported(export).cloned().ok_or(MissingExport);
        Ok(Some(AovTextures {
            view,
            origin_m,
            base_color: exported(base_color)?,
            normal: exported(normal)?,
            material: exported(material)?,
            linear_depth: exported(linear_depth)?,
            emission: self.emission.map(exported).transpose()?,
            ids: self.ids.map(exported).transpose()?,
            motion: self.motion.map(exported).transpose()?,
            occlusion_screen: self.occlusion_screen.map(exported).transpose()?,
        }))
    }
}

/// The targets of the first, unjittered frame on the device; those are read that a variable needs, and only its rows.
#[derive(Debug)]
pub(crate) struct AovTextures {
    view: ViewUniform,
    origin_m: Vec3,
    base_color: wgpu::Texture,
    normal: wgpu::Texture,
    material: wgpu::Texture,
    linear_depth: wgpu::Texture,
    emission: Option<wgpu::Texture>,
    ids: Option<wgpu::Texture>,
    motion: Option<wgpu::Texture>,
    occlusion_screen: Option<wgpu::Texture>,
}

impl AovTextures {
    /// All of them.
    pub fn all(&self) -> impl Iterator<Item = &wgpu::Texture> {
        let of_gbuffer = [&self.base_color, &self.normal, &self.material, &self.linear_depth];
        let others = [&self.emission, &self.ids, &self.motion, &self.occlusion_screen];
        of_gbuffer.into_iter().chain(others.into_iter().flatten())
    }

    /// Some rows of the picture of a variable; none if the frame did not record it.
    ///
    /// # Errors
    /// The device was lost.
    pub async fn read(&self, gpu: &Gpu, aov: Aov, rows: Range<u32>) -> Result<Option<AovPixels>, GpuError> {
        let height = self.linear_depth.height();
        let rows = rows.start.min(height)..rows.end.min(height);
        let mut pixels = GbufferPixels::of_rows(self.view, self.origin_m, rows.clone());
        let read = async |texture: &wgpu::Texture| readback::read_rows(gpu, texture, rows.clone()).await;
        match aov {
            Aov::BaseColor | Aov::Occlusion => pixels.base_color = read(&self.base_color).await?,
            Aov::Metallic | Aov::Roughness => pixels.material = read(&self.material).await?,
            Aov::Depth | Aov::Position => pixels.linear_depth = read(&self.linear_depth).await?,
            Aov::Normal | Aov::NormalView => {
                pixels.normal = read(&self.normal).await?;
                pixels.linear_depth = read(&self.linear_depth).await?;
            }
            Aov::Emission | Aov::Motion | Aov::OcclusionScreen | Aov::ObjectId | Aov::MaterialId | Aov::Radiance => {
                let (texture, slot) = match aov {
                    Aov::Emission => (&self.emission, &mut pixels.emission),
                    Aov::Motion => (&self.motion, &mut pixels.motion),
                    Aov::OcclusionScreen => (&self.occlusion_screen, &mut pixels.occlusion_screen),
                    _ => (&self.ids, &mut pixels.ids),
                };
                if let Some(texture) = texture {
                    *slot = Some(read(texture).await?);
                }
            }
        }
        pixels.read(aov)
    }
}
