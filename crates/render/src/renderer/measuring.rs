//! Frames that are measured, counted or planned, and show no picture. In browsers nothing waits for them.

use super::{Purpose, Renderer};
use crate::request::{FrameRequest, PairCounts, PassPicture, RenderError};
use manypass_graph::{PassTime, Plan};
use manypass_scene::Scene;

impl Renderer {
    /// Renders one frame and returns the picture of every target of every pass.
    ///
    /// # Errors
    /// As [`Self::render_async`].
    pub fn passes(&mut self, scene: &Scene, request: &FrameRequest) -> Result<Vec<PassPicture>, RenderError> {
        let mut purpose = Purpose::Pictures(Vec::new());
        pollster::block_on(self.run(scene, &[("", request)], &mut purpose))?;
        Ok(if let Purpose::Pictures(pictures) = purpose { pictures } else { Vec::new() })
    }

    /// Counts pairs of a light and what it may reach (a pixel, a fragment or a vertex) in a frame of its own.
    ///
    /// # Errors
    /// As [`Self::render_async`].
    pub fn count_pairs(&mut self, scene: &Scene, request: &FrameRequest) -> Result<PairCounts, RenderError> {
        let mut purpose = Purpose::Pairs(PairCounts::default());
        pollster::block_on(self.run(scene, &[("", request)], &mut purpose))?;
        Ok(if let Purpose::Pairs(pairs) = purpose { pairs } else { PairCounts::default() })
    }

    /// Counts the pixels that effects leave as no number, or infinite, in a frame of its own: those that are scrubbed before
    /// an effect that looks beside them, and those that are when all are drawn. A frame without effects has none: what
    /// comes of surfaces is in [`Self::clamped_pixels`].
    ///
    /// # Errors
    /// As [`Self::render_async`].
    pub fn count_scrubbed(&mut self, scene: &Scene, request: &FrameRequest) -> Result<u64, RenderError> {
        let mut purpose = Purpose::Scrubbed(0);
        pollster::block_on(self.run(scene, &[("", request)], &mut purpose))?;
        Ok(if let Purpose::Scrubbed(count) = purpose { count } else { 0 })
    }

    /// Renders one frame and measures its passes: the time to record each, and where the adapter has timestamps the
    /// time to execute it. No passes are merged for it.
    ///
    /// # Errors
    /// As [`Self::render_async`].
    pub fn pass_times(&mut self, scene: &Scene, request: &FrameRequest) -> Result<Vec<PassTime>, RenderError> {
        let mut purpose = Purpose::Times(Vec::new());
        pollster::block_on(self.run(scene, &[("", request)], &mut purpose))?;
        Ok(if let Purpose::Times(times) = purpose { times } else { Vec::new() })
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
        let mut purpose = Purpose::Rounds(1);
        let request = FrameRequest { light_rounds: Some(0), sample_index: 0, ..request.clone() };
        pollster::block_on(self.run(scene, &[("", &request)], &mut purpose))?;
        Ok(if let Purpose::Rounds(rounds) = purpose { Some(rounds) } else { None })
    }

    /// The plan of the frame that `request` asks for. It renders nothing, and disturbs no picture that is being
    /// accumulated.
    ///
    /// # Errors
    /// As [`Self::render_async`].
    pub fn plan(&mut self, scene: &Scene, request: &FrameRequest) -> Result<Plan, RenderError> {
        pollster::block_on(self.run(scene, &[("", request)], &mut Purpose::Plan))
    }
}
