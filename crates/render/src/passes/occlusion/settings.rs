//! Settings of ambient occlusion.

use crate::resolution::Resolution;
use crate::setting::{Switch, choices, rounded_up, settings};

choices! {
    /// The method of ambient occlusion.
    pub enum OcclusionMethod {
        /// Horizons around a surface in the depth of the picture (Jimenez et al. 2016).
        #[default]
        Gtao = "gtao",
        /// Points in the hemisphere above a surface, compared with the depth of the picture (Mittring 2007).
        Ssao = "ssao",
    }
}

settings! {
    /// Settings of ambient occlusion.
    pub struct OcclusionSettings {
        /// Ambient occlusion (screen space): opaque surfaces hide the environment's light from each other. Direct light
        /// and transmissive surfaces do not change. On the forward paths, and with `occlusion.bent_normals`, stills
        /// draw all samples of all pixels. Not with `render.path=gouraud`.
        enabled: Switch = Switch::Auto;
        /// The method: horizons (`gtao`) or points in a hemisphere (`ssao`).
        method: OcclusionMethod = OcclusionMethod::Gtao, needs "occlusion.enabled=true";
        /// The distance over which surfaces occlude each other; 0 for a twentieth of the visible extent.
        radius_m: f32 = 0.0, in 0.0..=1e6, unit "m", needs "occlusion.enabled=true";
        /// The last share of the radius over which occlusion fades out; 0 for no fade, which shows the radius as an
        /// edge.
        falloff: f32 = 0.5, in 0.0..=1.0, unit "share", needs "occlusion.enabled=true";
        /// Multiplies the share of light that is occluded: 1 is right, 0 occludes nothing.
        intensity: f32 = 1.0, in 0.0..=4.0, unit "factor", needs "occlusion.enabled=true";
        /// The size of the pass. The result is upsampled from texels of the same surface.
        resolution: Resolution = Resolution::Half, needs "occlusion.enabled=true";
        /// The thickness model of occluders: 0 extends them without end behind their visible front, 1 makes them thin
        /// sheets.
        thinness: f32 = 0.1, in 0.0..=1.0, unit "share", needs "occlusion.enabled=true", needs "occlusion.method=gtao";
        /// The number of directions in the picture that are searched for horizons, each to both sides. Rounded up to 1,
        /// 2, 3, 4, 6, 8, 12 or 16, to limit the number of pipelines.
        slices: u32 = 1, in 1..=16, needs "occlusion.enabled=true";
        /// The number of texels that are read along each side of a direction. Rounded up to 1, 2, 4, 8, 12, 16, 24 or
        /// 32, to limit the number of pipelines.
        steps: u32 = 8, in 1..=32, needs "occlusion.enabled=true";
        /// The number of points in the hemisphere of `ssao`; 0 for as many as `gtao` reads texels. Other numbers are
        /// rounded up to 4, 8, 16, 32, 64, 128 or 256, to limit the number of pipelines.
        kernel: u32 = 0, in 0..=256, needs "occlusion.enabled=true", needs "occlusion.method=ssao";
        /// The height above a surface's plane below which nothing occludes it, as a share of the radius. With 0 planes
        /// occlude themselves by rounding.
        bias: f32 = 0.02, in 0.0..=1.0, unit "share", needs "occlusion.enabled=true", needs "occlusion.method=ssao";
        /// Whether directions differ between texels and between samples, so that their mean has no bands. Otherwise all
        /// directions are the same.
        noise: bool = true, needs "occlusion.enabled=true";
        /// Whether the noise of few samples is removed, by the mean of 4 × 4 texels of the same surface.
        blur: bool = true, needs "occlusion.enabled=true";
        /// Whether bright surfaces are occluded less, by the light that they reflect to each other.
        multi_bounce: bool = true, needs "occlusion.enabled=true";
        /// Whether diffuse light comes from around the bent normal, the mean unoccluded direction, in place of the
        /// normal.
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
