//! Reflections that the first samples of a still found, for the later ones.

use super::{ReflectionSettings, is_needed};
use crate::gbuffer::RADIANCE;
use crate::record::Recorder;
use crate::screen_space::Reflections;
use manypass_graph::History;

/// What a sample of a still has of earlier ones, which alone follow rays where later ones skip converged tiles.
pub struct CachedReflections {
    pub(super) state: CacheState,
    is_dark: bool,
}

/// What of the first samples is there.
pub(super) enum CacheState {
    /// Nothing: each sample follows its own rays.
    Unused,
    /// The mean of the first samples, which are so many, and to which this one is added.
    Growing(History, u32),
    /// The mean of them all.
    Complete(Reflections),
}

impl CachedReflections {
    /// What there is of earlier samples.
    pub fn new(r: &mut Recorder<'_, '_>, settings: &ReflectionSettings) -> Self {
        let roughness_max = settings.roughness_max;
        let state = match r.view.whole_samples.filter(|_| is_needed(r, settings)) {
            None => CacheState::Unused,
            Some(whole) => {
                let mean = r.history("reflections.mean", r.view.desc(RADIANCE));
                if !mean.is_first && r.view.uniform.sample_index >= whole {
                    CacheState::Complete(Reflections { texture: mean.previous, side_px: 1, roughness_max })
                } else {
                    CacheState::Growing(mean, whole)
                }
            }
        };
        Self { state, is_dark: r.view.is_environment_dark }
    }

    /// What light of the environment is taken with: then there is nothing to [`super::record`]. In the dark no pass takes any.
    pub fn reflections(&self) -> Option<&Reflections> {
        match &self.state {
            CacheState::Complete(reflections) if !self.is_dark => Some(reflections),
            _ => None,
        }
    }
}
