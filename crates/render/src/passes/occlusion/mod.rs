//! occlusion: what opaque surfaces hide of the environment from each other, as far as the picture shows it.
//!
//! Sources: horizons (Jimenez et al. 2016, "Practical Realtime Strategies for Accurate Indirect Occlusion"), or points
//! in a hemisphere (Mittring 2007, "Finding Next Gen: CryEngine 2"); what differs from them stands in `gtao.wgsl` and
//! `ssao.wgsl`. Each sample of a still has other noise, so that their mean converges; that of few samples is a pattern
//! of 4 × 4 texels, which `occlusion.blur` takes out. `occlusion.upsample` brings a smaller picture to the full size.
//! Reads: normal, linear_depth. Writes: occlusion, the share of diffuse light of the environment that reaches a
//! surface, and where it is asked for its mean direction.

mod settings;

pub use settings::{OcclusionMethod, OcclusionSettings};

use crate::occlusion::Occlusion;
use crate::record::{Fullscreen, PicturePart, Recorder};
use crate::resolution::Resolution;
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle};
use manypass_scene::Aabb;

/// The share of light that is left, which may lie outside of 0 to 1 where a sample looks in few directions.
const VISIBILITY: wgpu::TextureFormat = wgpu::TextureFormat::R16Float;

/// The same, and the mean direction of that light.
const BENT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// Where there is no surface.
const OPEN: ColorLoad = ColorLoad::Clear(wgpu::Color { r: 1.0, g: 0.0, b: 0.0, a: 0.0 });

/// The radius, where the settings leave it open, as a share of the diagonal of all that is drawn.
const RADIUS_SHARE: f32 = 0.05;

/// The uniform of `taps.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct OcclusionUniform {
    radius_m: f32,
    /// 1 / the length over which occlusion fades out before the radius ends.
    fade_per_m: f32,
    thinness: f32,
    intensity: f32,
}

impl OcclusionUniform {
    fn new(settings: &OcclusionSettings, bounds_world: &Aabb) -> Self {
        let auto_m =
            if bounds_world.is_empty() { 1.0 } else { RADIUS_SHARE * bounds_world.min.distance(bounds_world.max) };
        let radius_m = if settings.radius_m > 0.0 { settings.radius_m } else { auto_m };
        let radius_m = if radius_m.is_finite() { radius_m.clamp(1e-6, 1e6) } else { 1.0 };
        let fade_per_m = 1.0 / (radius_m * settings.falloff.max(1e-4));
        Self { radius_m, fade_per_m, thinness: settings.thinness, intensity: settings.intensity }
    }
}

/// What is known of the surfaces in the picture.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'h> {
    /// World normal, as the G-buffer has it.
    pub normal: &'h Handle,
    /// Metres along the view axis.
    pub linear_depth: &'h Handle,
    /// Depth, with one sample a pixel.
    pub depth: &'h Handle,
}

/// Whether the settings ask for it and there is light to be hidden, or whether it `is_read` by an effect.
pub fn is_needed(r: &Recorder<'_, '_>, settings: &OcclusionSettings, is_read: bool) -> bool {
    settings.enabled && (is_read || !r.view.is_environment_dark) && !r.view.counts_pairs()
}

/// Records the passes, if the settings ask for them and there is light to be hidden, or if it `is_read` by an effect.
///
/// # Errors
/// A program that does not compile.
pub fn record(
    r: &mut Recorder<'_, '_>,
    settings: &OcclusionSettings,
    is_read: bool,
    seen: Seen<'_>,
) -> Result<Option<Occlusion>, ProgramError> {
    if !is_needed(r, settings, is_read) {
        return Ok(None);
    }
    let depth = seen.depth;
    let program = match settings.method {
        OcclusionMethod::Gtao => "occlusion_gtao",
        OcclusionMethod::Ssao => "occlusion_ssao",
    };
    let is_filtered = r.view.shows_few_samples();
    let of_few = settings.resolution != Resolution::Full;
    let constants = [("side", settings.resolution.side_px()), ("patterned", u32::from(is_filtered))];
    let uniform = OcclusionUniform::new(settings, &r.frame.world.bounds_world);
    let format = if settings.bent_normals { BENT } else { VISIBILITY };
    let desc = settings.resolution.desc(r.view, format);

    let target = r.texture_of("occlusion", desc);
    let step = r.fullscreen("occlusion", program, &[]).constants(&constants);
    let step = step.constants(&[
        ("slices", settings.slices),
        ("steps", settings.steps),
        ("bends", u32::from(settings.bent_normals)),
    ]);
    let step = surfaces_of(step, seen, &uniform);
    let step = if of_few { step } else { step.over(PicturePart::Surfaces, depth) };
    let mut texture = step.draw_into(target, OPEN)?;
    if is_filtered {
        let target = r.texture_of("occlusion.blur", desc);
        let step = r.fullscreen("occlusion.blur", "occlusion_blur", &[]).constants(&constants[..1]);
        let step = surfaces_of(step, seen, &uniform).read("noisy_occlusion", &texture);
        let step = if of_few { step } else { step.over(PicturePart::Surfaces, depth) };
        texture = step.draw_into(target, OPEN)?;
    }
    if of_few {
        let target = r.texture("occlusion.upsample", format);
        let step = r.fullscreen("occlusion.upsample", "occlusion_upsample", &[]).constants(&constants);
        let step = surfaces_of(step, seen, &uniform).read("coarse_occlusion", &texture);
        texture = step.over(PicturePart::Surfaces, depth).draw_into(target, OPEN)?;
    }
    Ok(Some(Occlusion { texture, is_multi_bounce: settings.multi_bounce, is_bent: settings.bent_normals }))
}

/// What all steps read.
fn surfaces_of<'r, 'f>(step: Fullscreen<'r, 'f>, seen: Seen<'_>, uniform: &OcclusionUniform) -> Fullscreen<'r, 'f> {
    step.uniform("occlusion", uniform).read("normal", seen.normal).read("linear_depth", seen.linear_depth)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;
    use glam::Vec3;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!(
            "occlusion_gtao",
            "Occlusion",
            OcclusionUniform,
            [radius_m, fade_per_m, thinness, intensity]
        );
    }

    #[test]
    fn the_radius_is_that_of_the_settings_or_of_the_scene() {
        let of = |settings: &OcclusionSettings, bounds: &Aabb| OcclusionUniform::new(settings, bounds);
        let auto = OcclusionSettings::default();
        let bounds = Aabb { min: Vec3::ZERO, max: Vec3::new(3.0, 0.0, 4.0) };
        assert_eq!(of(&auto, &bounds).radius_m, 0.25);
        assert_eq!(of(&OcclusionSettings { radius_m: 2.0, ..auto.clone() }, &bounds).radius_m, 2.0);
        let far = Aabb { min: Vec3::splat(-3e38), max: Vec3::splat(3e38) };
        let point = Aabb { min: Vec3::ONE, max: Vec3::ONE };
        for bounds in [far, point, Aabb::EMPTY] {
            let hard = of(&OcclusionSettings { falloff: 0.0, ..auto.clone() }, &bounds);
            assert!(hard.radius_m > 0.0 && hard.fade_per_m.is_finite(), "{hard:?}");
        }
    }
}
