//! What a frame leaves for the next one. The renderer has it only once the frame is submitted.

use super::Renderer;
use super::captures::CaptureState;
use super::purpose::Purpose;
use super::surroundings::SurroundingsState;
use crate::ground::GroundMap;
use crate::request::{FrameStats, RenderError};
use crate::shadows::Shadows;
use manypass_scene::NodeId;

/// What the next frame is to find. It is a copy of what the renderer knows, and preparing a frame changes the copy
/// alone. [`Self::commit`] stores it. A frame that fails drops it, and so does one that is only planned.
///
/// A texture of the renderer that gives way to one of another size goes at once, so that memory never holds both. The
/// renderer then forgets what it knew of its texels.
pub(super) struct NextState {
    /// Whether the frame is run. If not, no texel is written for it, and missing textures have stand-ins. Buffers and
    /// tables that mirror the scene are written for a plan, too.
    pub is_run: bool,
    /// When monitors were drawn.
    pub captures: CaptureState,
    /// What of surroundings and probes is on the device.
    pub surroundings: SurroundingsState,
    /// What the tiles of shadow maps were drawn from.
    pub shadows: Shadows,
    /// The lights without room for shadow maps, and those whose maps are too coarse, if lights cast shadows.
    pub unshadowed: Option<[Vec<NodeId>; 2]>,
    /// What the map of the ground was drawn from.
    pub ground: Option<(GroundMap, u64)>,
    /// Environments, by their numbers, whose tiles are drawn.
    pub environments: Vec<usize>,
    /// The numbers of the frame.
    pub stats: FrameStats,
}

impl NextState {
    /// As the renderer has it before a frame.
    pub fn of(renderer: &Renderer, purpose: &Purpose<'_>) -> Self {
        let is_run = purpose.is_run;
        Self {
            is_run,
            captures: renderer.captures.clone(),
            surroundings: renderer.surroundings.clone(),
            // A plan has the passes of all maps.
            shadows: if is_run { renderer.shadows.tiles.clone() } else { Shadows::default() },
            unshadowed: None,
            ground: renderer.ground.drawn,
            environments: Vec::new(),
            stats: FrameStats::default(),
        }
    }

    /// Stores it, after the frame was submitted.
    pub fn commit(self, renderer: &mut Renderer) {
        let Self { captures, surroundings, shadows, unshadowed, ground, environments, stats, is_run: _ } = self;
        renderer.stats = stats;
        renderer.captures = captures;
        renderer.surroundings = surroundings;
        renderer.shadows.tiles = shadows;
        if let Some([beyond, starved]) = unshadowed {
            (renderer.shadows.beyond, renderer.shadows.starved) = (beyond, starved);
        }
        renderer.ground.drawn = ground;
        for at in environments {
            if let Some(tiles) = renderer.resources.environments.get_mut(at) {
                tiles.finish();
            }
        }
    }
}

impl Renderer {
    /// Asks whether the device drew what was submitted. If not, nobody knows what of it was drawn: nothing that textures
    /// hold from earlier frames is used from then on.
    ///
    /// # Errors
    /// It did not.
    pub(super) fn check_drawn(&mut self) -> Result<(), RenderError> {
        let checked = self.gpu.check();
        if checked.is_err() {
            self.captures.clear();
            self.surroundings.clear();
            self.shadows.tiles = Shadows::default();
            self.ground.drawn = None;
        }
        Ok(checked?)
    }
}
