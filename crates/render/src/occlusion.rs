//! What opaque surfaces hide of the environment from each other, as the passes read it that add its light.

use crate::record::Fullscreen;
use manypass_graph::Handle;

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
            None => step.stand_in("screen_occlusion"),
            Some(Self { texture, is_multi_bounce, is_bent }) => step
                .constants(&[
                    ("occluded", 1),
                    ("multi_bounce", u32::from(*is_multi_bounce)),
                    ("bent_normals", u32::from(*is_bent)),
                ])
                .read("screen_occlusion", texture),
        }
    }
}
