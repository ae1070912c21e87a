//! What is found in the picture of surfaces, for the passes that take light of the environment with it.

use crate::occlusion::Occlusion;
use crate::record::{Fullscreen, SurfacePass};
use manypass_graph::Handle;

/// What rays brought, with how much of it is to be trusted.
#[derive(Debug)]
pub struct Reflections {
    /// Radiance times that share, and the share.
    pub texture: Handle,
    /// Pixels along a texel's side.
    pub side_px: u32,
    /// The roughest surfaces that show it.
    pub roughness_max: f32,
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

/// Where surfaces with layers have what was found of each pixel in their shaders.
const FOUND_WITH_LAYERS: &str = "behind";

/// Light that surfaces of the picture send to the others, for those that are shaded where they are drawn.
#[derive(Debug)]
pub struct ScreenSpaceLight {
    /// Of each pixel its radiance times the share of directions from which it comes, and that share.
    pub texture: Handle,
    /// Whether it takes the place of the environment's, which no occlusion takes away.
    pub takes_environment: bool,
}

impl ScreenSpaceLight {
    /// Declares that a pass which draws surfaces with layers reads it.
    pub fn bind(&self, pass: &mut SurfacePass<'_, '_>) {
        Occlusion::bind(None, pass);
        pass.constant("takes_environment", u32::from(self.takes_environment));
        pass.read(FOUND_WITH_LAYERS, &self.texture);
    }
}

/// What is known before surfaces get light of the environment.
#[derive(Clone, Copy, Debug, Default)]
pub struct ScreenSpaceEffects<'h> {
    /// What they hide of it from each other.
    pub occlusion: Option<&'h Occlusion>,
    /// What they reflect in its place, if an earlier sample of a still found that.
    pub reflections: Option<&'h Reflections>,
}

impl ScreenSpaceEffects<'_> {
    /// The same of a pass that draws opaque surfaces, and of reflections whose texels are those of pixels. Only those
    /// with layers reflect, and find it in the texture in which glass has what is seen through it: WebGL 2 has no more.
    pub fn bind(self, pass: &mut SurfacePass<'_, '_>) {
        Occlusion::bind(self.occlusion, pass);
        let Some(found) = self.reflections else { return pass.stand_in(FOUND_WITH_LAYERS) };
        pass.constant("takes_found", 1);
        pass.constant("reflected_roughness_max", found.roughness_max.to_bits());
        pass.read(FOUND_WITH_LAYERS, &found.texture);
    }

    /// Declares that `step` reads it.
    pub fn read_by<'r, 'f>(self, step: Fullscreen<'r, 'f>) -> Fullscreen<'r, 'f> {
        Reflections::read_by(self.reflections, Occlusion::read_by(self.occlusion, step))
    }
}
