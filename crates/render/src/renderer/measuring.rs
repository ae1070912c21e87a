//! Frames that are measured, counted or planned, and show no picture. In browsers nothing waits for them.

use super::Renderer;
use super::counts::sum_pairs;
use super::purpose::Purpose;
use super::read::{FrameReadings, TextureBytes};
use crate::aov::PassPicture;
use crate::request::{FrameRequest, PairCounts, RenderError};
use manypass_graph::{PassTime, Plan};
use manypass_scene::Scene;

impl Renderer {
    /// Renders one frame and returns the picture of every target of every pass.
    ///
    /// # Errors
    /// As [`Self::render_async`].
    pub fn passes(&mut self, scene: &Scene, request: &FrameRequest) -> Result<Vec<PassPicture>, RenderError> {
        let purpose = Purpose { reads_passes: true, ..Purpose::BESIDE };
        Ok(self.measure(scene, request, &purpose)?.pictures)
    }

    /// Counts pairs of a light and what it may reach (a pixel, a fragment or a vertex) in a frame of its own.
    ///
    /// # Errors
    /// As [`Self::render_async`].
    pub fn count_pairs(&mut self, scene: &Scene, request: &FrameRequest) -> Result<PairCounts, RenderError> {
        let purpose = Purpose {
            draws_captures: false,
            draws_picture: false,
            shows_picture: false,
            counts_pairs: true,
            ..Purpose::BESIDE
        };
        let mut counts = PairCounts::default();
        for pairs in self.measure(scene, request, &purpose)?.exports {
            counts += sum_pairs(&pairs.bytes, pairs.format);
        }
        Ok(counts)
    }

    /// Counts the pixels that effects leave as no number, or infinite, in a frame of its own: those that are scrubbed before
    /// an effect that looks beside them, and those that are when all are drawn. A frame without effects has none: what
    /// comes of surfaces is in [`Self::clamped_pixels`].
    ///
    /// # Errors
    /// As [`Self::render_async`].
    pub fn count_scrubbed(&mut self, scene: &Scene, request: &FrameRequest) -> Result<u64, RenderError> {
        let purpose = Purpose { counts_scrubbed: true, ..Purpose::BESIDE };
        let exports = self.measure(scene, request, &purpose)?.exports;
        Ok(exports.iter().flat_map(TextureBytes::floats).filter(|value| *value > 0.5).count() as u64)
    }

    /// Renders one frame and measures its passes: the time to record each, and where the adapter has timestamps the
    /// time to execute it. No passes are merged for it.
    ///
    /// # Errors
    /// As [`Self::render_async`].
    pub fn pass_times(&mut self, scene: &Scene, request: &FrameRequest) -> Result<Vec<PassTime>, RenderError> {
        let purpose = Purpose { times_passes: true, ..Purpose::BESIDE };
        Ok(self.measure(scene, request, &purpose)?.times)
    }

    /// In how many rounds the lights of `scene` have to share the atlas of shadow maps so that every light casts its
    /// shadow in the picture that `request` asks for: what to give as [`FrameRequest::light_rounds`]. 1 where all have
    /// room at once; none where none casts shadows, or maps are not to be spread
    /// (`shadows.spread_over_samples`). It renders nothing.
    ///
    /// # Errors
    /// As [`Self::render_async`].
    pub fn light_rounds(&mut self, scene: &Scene, request: &FrameRequest) -> Result<Option<u32>, RenderError> {
        let settings = &request.settings.shadows;
        if !settings.enabled || !settings.spread_over_samples {
            return Ok(None);
        }
        let purpose = Purpose { is_run: false, ends_at_shadows: true, ..Purpose::BESIDE };
        let request = FrameRequest { light_rounds: Some(0), sample_index: 0, ..request.clone() };
        Ok(Some(self.measure(scene, &request, &purpose)?.light_rounds))
    }

    /// The plan of the frame that `request` asks for. It renders nothing, and disturbs no picture that is being
    /// accumulated.
    ///
    /// # Errors
    /// As [`Self::render_async`].
    pub fn plan(&mut self, scene: &Scene, request: &FrameRequest) -> Result<Plan, RenderError> {
        Ok(self.measure(scene, request, &Purpose { is_run: false, ..Purpose::BESIDE })?.plan)
    }

    /// Runs a frame of one view, and waits for what is read of it.
    fn measure(
        &mut self,
        scene: &Scene,
        request: &FrameRequest,
        purpose: &Purpose<'_>,
    ) -> Result<FrameReadings, RenderError> {
        pollster::block_on(self.run(scene, &[("", request)], purpose))
    }
}
