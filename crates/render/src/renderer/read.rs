//! What is read of a frame that was submitted.

use super::Renderer;
use super::ask::ViewRequest;
use super::output::UnsettledRegion;
use super::purpose::Purpose;
use super::submit::SubmittedFrame;
use crate::aov::PassPicture;
use crate::draws::UnsettledTiles;
use crate::environment::stored;
use crate::gpu::readback;
use crate::passes::adaptive;
use crate::request::RenderError;
use manypass_graph::{PassTime, Plan};
use manypass_scene::Scene;

/// What was read of a frame.
#[cfg_attr(target_arch = "wasm32", allow(dead_code, reason = "a browser cannot wait for what the others read"))]
pub(super) struct FrameReadings {
    pub plan: Plan,
    /// In how many rounds lights take turns in the atlas of shadow maps.
    pub light_rounds: u32,
    /// What the passes exported that the purpose asks for.
    pub exports: Vec<TextureBytes>,
    /// The targets of all passes, if they are read.
    pub pictures: Vec<PassPicture>,
    /// The times of all passes, if they are timed.
    pub times: Vec<PassTime>,
}

/// The texels of a texture.
pub(super) struct TextureBytes {
    #[cfg_attr(target_arch = "wasm32", allow(dead_code, reason = "a browser reads 32-bit floats alone"))]
    pub format: wgpu::TextureFormat,
    pub bytes: Vec<u8>,
}

impl TextureBytes {
    /// Its channels, if they are 32-bit floats.
    pub fn floats(&self) -> impl Iterator<Item = f32> {
        self.bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
    }
}

impl Renderer {
    /// Reads what the purpose of a frame of `requests` is for. Of a picture it also finds converged tiles.
    pub(super) async fn read(
        &mut self,
        scene: &Scene,
        requests: &[ViewRequest],
        submitted: SubmittedFrame,
        purpose: &Purpose<'_>,
    ) -> Result<FrameReadings, RenderError> {
        if submitted.run.is_none() {
            return self.fetch(submitted, purpose).await;
        }
        self.forget_gone_views(scene, requests);
        let readings = self.fetch(submitted, purpose).await?;
        self.keep_environment().await?;
        if purpose.is_picture {
            self.find_unsettled(requests).await?;
        }
        Ok(readings)
    }

    /// Fetches what passes exported, and what was measured of them.
    #[cfg_attr(target_arch = "wasm32", allow(unused_variables, reason = "a browser reads no pictures of passes"))]
    async fn fetch(&self, submitted: SubmittedFrame, purpose: &Purpose<'_>) -> Result<FrameReadings, RenderError> {
        let SubmittedFrame { plan, run, exports, legends, light_rounds } = submitted;
        let mut readings =
            FrameReadings { plan, light_rounds, exports: Vec::new(), pictures: Vec::new(), times: Vec::new() };
        let Some(run) = run else { return Ok(readings) };
        for export in exports {
            let texture = run.exported(export).ok_or(RenderError::Internal("an exported texture is missing"))?;
            let bytes = readback::read_texture(&self.gpu, texture).await?;
            readings.exports.push(TextureBytes { format: texture.format(), bytes });
        }
        #[cfg(not(target_arch = "wasm32"))]
        if purpose.reads_passes || purpose.times_passes {
            let report = run.read(&self.gpu.device);
            let picture = |tap| {
                let picture = crate::aov::tap_picture(tap, legends.texels.of(&tap.texture))?;
                Some(PassPicture { legend: legends.of(&tap.pass), ..picture })
            };
            readings.pictures = report.taps.iter().filter_map(picture).collect();
            readings.times = report.passes;
        }
        Ok(readings)
    }

    /// Finds the parts of pictures that later samples of stills are added to, after tiles were looked for that are
    /// settled. A live view does not wait for that: there depth alone leaves them out.
    async fn find_unsettled(&mut self, requests: &[ViewRequest]) -> Result<(), RenderError> {
        let has_looked = |asked: &&ViewRequest| matches!(asked.adaptive_step(), adaptive::Step::Settle { .. });
        for asked in requests.iter().filter(has_looked).filter(|asked| !asked.request.goes_on) {
            let Some(state) = self.views.get_mut(&asked.name) else { continue };
            let Some(settled) = state.settled_texture() else { continue };
            let texels = readback::read_texture(&self.gpu, settled).await?;
            state.unsettled = Some(UnsettledRegion {
                rectangles: adaptive::unsettled_rectangles(&texels, asked.output_size).into(),
                tiles: UnsettledTiles::new(&texels, asked.output_size).into(),
            });
        }
        Ok(())
    }

    /// Puts tiles that were drawn into the cache that lacks them.
    async fn keep_environment(&mut self) -> Result<(), RenderError> {
        let Some(cache) = &self.cache else { return Ok(()) };
        for tiles in &mut self.resources.environments {
            if let Some(name) = tiles.take_missing() {
                let texels = readback::read_texture(&self.gpu, tiles.view.texture()).await?;
                cache.put(&name, &stored::entry(&tiles.suns, &texels));
            }
        }
        Ok(())
    }
}
