//! Settings of ambient occlusion.

use crate::resolution::Resolution;
use crate::setting::{Switch, choices, rounded_up, settings};

choices! {
    /// How what opaque surfaces hide of the environment from each other is found.
    pub enum OcclusionMethod {
        /// How high what the picture shows rises around a surface (Jimenez et al. 2016).
        #[default]
        Gtao = "gtao",
        /// Points in the hemisphere above a surface that lie behind what the picture shows (Mittring 2007).
        Ssao = "ssao",
    }
}

settings! {
    /// Settings of ambient occlusion.
    pub struct OcclusionSettings {
        /// Whether opaque surfaces hide the environment's light from each other, as far as the picture shows them.
        /// Direct light and glass stay what they are; on the forward paths, and with `occlusion.bent_normals`, stills
        /// draw all samples of all pixels. Not with `render.path=gouraud`.
        enabled: Switch = Switch::Auto;
        /// How it is found: by horizons (`gtao`) or by points in a hemisphere (`ssao`).
        method: OcclusionMethod = OcclusionMethod::Gtao, needs "occlusion.enabled=true";
        /// How far surfaces occlude each other; 0 for a twentieth of the extent of what is seen.
        radius_m: f32 = 0.0, in 0.0..=1e6, unit "m", needs "occlusion.enabled=true";
        /// Over which last share of the radius occlusion fades out; 0 for none of it, which shows the radius as an
        /// edge.
        falloff: f32 = 0.5, in 0.0..=1.0, unit "share", needs "occlusion.enabled=true";
        /// What is lost of the light is multiplied by this: 1 is what is right, 0 leaves all light there.
        intensity: f32 = 1.0, in 0.0..=4.0, unit "factor", needs "occlusion.enabled=true";
        /// The size at which it is found; it is brought to the picture's by what lies on the same surface.
        resolution: Resolution = Resolution::Half, needs "occlusion.enabled=true";
        /// How soon light comes past behind what rises before a surface: 0 takes everything to go on behind what is
        /// seen of it, 1 takes it to be as thin as a sheet.
        thinness: f32 = 0.1, in 0.0..=1.0, unit "share", needs "occlusion.enabled=true", needs "occlusion.method=gtao";
        /// Directions in the picture in which horizons are looked for, each to both sides; rounded up to 1, 2, 3, 4, 6,
        /// 8, 12 or 16, so that a slider makes few pipelines.
        slices: u32 = 1, in 1..=16, needs "occlusion.enabled=true";
        /// Texels that are looked at along each side of a direction; rounded up to 1, 2, 4, 8, 12, 16, 24 or 32, so that
        /// a slider makes few pipelines.
        steps: u32 = 8, in 1..=32, needs "occlusion.enabled=true";
        /// The kernel of `ssao`: in so many points of the hemisphere it looks; 0 for as many texels as `gtao` looks at.
        /// Others are rounded up to 4, 8, 16, 32, 64, 128 or 256, so that a slider makes few pipelines.
        kernel: u32 = 0, in 0..=256, needs "occlusion.enabled=true", needs "occlusion.method=ssao";
        /// What rises less than this over the plane of a surface occludes nothing, as a share of the radius; 0 lets planes
        /// occlude themselves by rounding.
        bias: f32 = 0.02, in 0.0..=1.0, unit "share", needs "occlusion.enabled=true", needs "occlusion.method=ssao";
        /// Whether each texel and each sample looks in other directions, whose mean has no bands; otherwise all look in the
        /// same ones.
        noise: bool = true, needs "occlusion.enabled=true";
        /// Whether the noise of few samples is taken out, by the mean of 4 × 4 texels of the same surface.
        blur: bool = true, needs "occlusion.enabled=true";
        /// Whether bright surfaces are occluded less, by the light that they reflect to each other.
        multi_bounce: bool = true, needs "occlusion.enabled=true";
        /// Whether diffuse light is that around the mean direction from which it still comes, in place of that around
        /// the normal.
        bent_normals: bool = false, needs "occlusion.enabled=true";
    }
}

impl OcclusionSettings {
    /// How many slices and steps shaders have.
    pub(super) fn lengths(&self) -> [u32; 2] {
        let slices = rounded_up(self.slices, &[1, 2, 3, 4, 6, 8, 12, 16]);
        [slices, rounded_up(self.steps, &[1, 2, 4, 8, 12, 16, 24, 32])]
    }

    /// How many points `ssao` has.
    pub(super) fn points(&self) -> u32 {
        let [slices, steps] = self.lengths();
        match self.kernel {
            0 => 2 * slices * steps,
            points => rounded_up(points, &[4, 8, 16, 32, 64, 128, 256]),
        }
    }
}
