//! Finds the light of live probes for a picture, and says how far that is.

use super::batch::{Batch, counting_bar, failed};
use crate::failure::Failure;
use crate::interrupt;
use manypass::FrameRequest;
use manypass_scene::Scene;
use std::io::IsTerminal;
use std::sync::atomic::Ordering;

impl Batch<'_> {
    /// Finds the light of live probes of a scene for a picture, if it has any.
    ///
    /// # Errors
    /// The renderer failed, or the user said stop.
    pub(super) fn find_probe_light(&mut self, scene: &Scene, request: &FrameRequest) -> Result<(), Failure> {
        if scene.probes.iter().all(|grid| grid.live.is_none()) {
            return Ok(());
        }
        let is_shown = !self.args.quiet && std::io::stderr().is_terminal();
        let mut bar = None;
        let mut progress = |done: usize, all: usize| {
            if is_shown {
                let bar = bar.get_or_insert_with(|| counting_bar(all as u64));
                bar.set_message("looks around probes");
                bar.set_position(done as u64);
            }
            !interrupt::STOP.load(Ordering::SeqCst)
        };
        let result = self.renderer.find_probe_light(scene, request, &mut progress);
        if let Some(bar) = bar {
            bar.finish_and_clear();
        }
        interrupt::check()?;
        result.map_err(failed)
    }
}
