//! What is found in the picture of surfaces, for the passes that take light of the environment with it.

use crate::occlusion::Occlusion;
use crate::record::Fullscreen;
use manypass_graph::Handle;

/// What rays brought, with how much of it is to be trusted.
#[derive(Debug)]
pub struct Reflections {
    /// Radiance times that share, and the share.
    pub texture: Handle,
    /// Pixels along a texel's side.
    pub side_px: u32,
}

impl Reflections {
    /// Declares that `step` reads them, if there are any, under the names of `shaders/coarse_reflections.wgsl`.
    pub fn read_by<'r, 'f>(found: Option<&Self>, step: Fullscreen<'r, 'f>) -> Fullscreen<'r, 'f> {
        let Some(found) = found else {
            return step.stand_in("found_reflections");
        };
        step.constant("reflections_side", found.side_px).read("found_reflections", &found.texture)
    }
}

/// What is known before surfaces get light of the environment.
#[derive(Clone, Copy, Debug, Default)]
pub struct InPicture<'h> {
    /// What they hide of it from each other.
    pub occlusion: Option<&'h Occlusion>,
    /// What they reflect in its place, if an earlier sample of a still found that.
    pub reflections: Option<&'h Reflections>,
}

impl InPicture<'_> {
    /// Declares that `step` reads it.
    pub fn read_by<'r, 'f>(self, step: Fullscreen<'r, 'f>) -> Fullscreen<'r, 'f> {
        Reflections::read_by(self.reflections, Occlusion::read_by(self.occlusion, step))
    }
}
