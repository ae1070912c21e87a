//! What opaque surfaces hide of the environment from each other, as the passes read it that add its light.

use crate::record::{Fullscreen, SurfacePass};
use crate::shader::program::Constant;
use crate::transparency::GLASS_DISTANCES;
use manypass_graph::Handle;

/// The texture in shaders.
const NAME: &str = "screen_occlusion";

/// Where those with layers find it: WebGL 2 has no more textures, and no opaque surface needs what else lies there.
const NAME_WITH_LAYERS: &str = GLASS_DISTANCES;

/// The uniform of `shaders/coarse_occlusion.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
struct CoarseOcclusion {
    reach_m: f32,
    padding_0: f32,
    padding_1: f32,
    padding_2: f32,
}

impl CoarseOcclusion {
    /// Of what was found, with the constant that says how large its texels are.
    fn of(found: Option<&Occlusion>) -> (Self, Constant) {
        let before = found.and_then(|found| found.cache);
        let uniform = Self { reach_m: before.map_or(1.0, |before| before.reach_m), ..Self::default() };
        (uniform, ("occlusion_side", before.map_or(0, |before| before.side_px)))
    }
}

/// What an earlier sample of a still found for all.
#[derive(Clone, Copy, Debug)]
pub struct OcclusionCache {
    /// Pixels along a texel's side.
    pub side_px: u32,
    /// How far from the tangent plane another surface begins.
    pub reach_m: f32,
}

/// What a pass found of it.
#[derive(Debug)]
pub struct Occlusion {
    /// If an earlier sample found it: its texels are of squares of pixels, and say how far away surfaces were.
    pub cache: Option<OcclusionCache>,
    /// Of each pixel the share of diffuse light that reaches it, and in the other channels its mean direction, if it is
    /// bent.
    pub texture: Handle,
    /// Whether bright surfaces are occluded less.
    pub is_multi_bounce: bool,
    /// Whether diffuse light is that around its mean direction.
    pub is_bent: bool,
}

impl Occlusion {
    /// Declares that `step` reads it, if there is any, under the names of `shaders/occlusion.wgsl`.
    pub fn read_by<'r, 'f>(found: Option<&Self>, step: Fullscreen<'r, 'f>) -> Fullscreen<'r, 'f> {
        let (uniform, side) = CoarseOcclusion::of(found);
        let step = step.uniform("coarse_occlusion", &uniform).constant(side.0, side.1);
        match found {
            None => step.stand_in(NAME),
            Some(found) => step.constants(&found.constants()).read(NAME, &found.texture),
        }
    }

    /// The same of a pass that draws opaque surfaces.
    pub fn bind(found: Option<&Self>, pass: &mut SurfacePass<'_, '_>) {
        let (uniform, side) = CoarseOcclusion::of(found);
        pass.uniform("coarse_occlusion", &uniform);
        pass.constant(side.0, side.1);
        let Some(found) = found else {
            return [NAME, NAME_WITH_LAYERS].into_iter().for_each(|name| pass.stand_in(name));
        };
        found.constants().into_iter().for_each(|(name, value)| pass.constant(name, value));
        pass.read_under(&[NAME, NAME_WITH_LAYERS], &found.texture);
    }

    /// The same of a pass that draws surfaces which are not occluded, and that binds what else lies in that place.
    pub fn bind_none(pass: &mut SurfacePass<'_, '_>) {
        pass.uniform("coarse_occlusion", &CoarseOcclusion::of(None).0);
        pass.stand_in(NAME);
    }

    fn constants(&self) -> [Constant; 3] {
        let Self { is_multi_bounce, is_bent, .. } = self;
        [("occluded", 1), ("multi_bounce", u32::from(*is_multi_bounce)), ("bent_normals", u32::from(*is_bent))]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!("direct", "CoarseOcclusion", CoarseOcclusion, [reach_m, padding_0, padding_1, padding_2]);
    }
}
