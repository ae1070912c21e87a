//! What opaque surfaces hide of the environment from each other, as the passes read it that add its light.

use crate::record::{Fullscreen, SurfacePass};
use crate::shader::program::Constant;
use manypass_graph::Handle;

/// The texture in shaders.
const NAME: &str = "screen_occlusion";

/// What a pass found of it.
#[derive(Debug)]
pub struct Occlusion {
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
        match found {
            None => step.stand_in(NAME),
            Some(found) => step.constants(&found.constants()).read(NAME, &found.texture),
        }
    }

    /// The same of a pass that draws surfaces.
    pub fn bind(found: Option<&Self>, pass: &mut SurfacePass<'_, '_>) {
        let Some(found) = found else { return pass.stand_in(NAME) };
        found.constants().into_iter().for_each(|(name, value)| pass.constant(name, value));
        pass.read(NAME, &found.texture);
    }

    fn constants(&self) -> [Constant; 3] {
        let Self { is_multi_bounce, is_bent, .. } = self;
        [("occluded", 1), ("multi_bounce", u32::from(*is_multi_bounce)), ("bent_normals", u32::from(*is_bent))]
    }
}
