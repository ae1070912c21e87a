//! gi: opaque surfaces light each other diffusely as far as the picture shows them, once.
//!
//! Sources: light of the picture's pixels (Ritschel, Grosch & Seidel 2009, "Approximating Dynamic Global Illumination in
//! Image Space"), by horizons (Mayaux 2018, "Horizon-Based Indirect Lighting"); what differs from them stands in
//! `gather.wgsl`. Each sample of a still looks in other directions, so that their mean converges; the noise of less
//! than 64 is a pattern of 4 × 4 texels, which `gi.filter` takes out. `gi.compose` adds what surfaces reflect of it, in
//! place of the environment's light from the same directions, which occlusion took away where there is one; surfaces
//! that are shaded where they are drawn do that themselves.
//! Reads: G-buffer, linear_depth, radiance. Writes: radiance.

mod settings;

pub use settings::GiSettings;

use crate::constants::RADIANCE_MAX;
use crate::gbuffer::{Gbuffer, RADIANCE};
use crate::occlusion::Occlusion;
use crate::pass_info::{PassInfo, Reach};
use crate::record::{ADD, Fullscreen, PicturePart, Recorder};
use crate::resolution::Resolution;
use crate::screen_space::ScreenSpaceLight;
use crate::shader::program::{Constant, ProgramError};
use manypass_graph::{ColorLoad, Handle};

/// What lists of passes say of this one.
pub const PASS: PassInfo =
    PassInfo { off: Some("gi.enabled=false"), in_fisheye: false, tiers: &[], ..PassInfo::deferred("gi") };

/// How far it looks; none if settings switch it off.
pub fn reach(settings: &GiSettings) -> Option<Reach> {
    settings.enabled.then_some(Reach::EverySample)
}

/// Where nothing is found.
const NOTHING: ColorLoad = ColorLoad::Clear(wgpu::Color::TRANSPARENT);

/// The radius, where the settings leave it open, as a share of the extent of what is seen.
const RADIUS_SHARE: f32 = 0.25;

/// The share of the radius over which light fades out.
const FADE_SHARE: f32 = 0.25;

/// The noise of so many samples averages out by itself. It is more than that of occlusion, because small lamps are
/// brighter than what is around them.
const UNFILTERED_SAMPLES: u32 = 64;

/// The uniform of `gathered.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct GiUniform {
    radius_m: f32,
    /// 1 / the length over which light fades out before the radius ends.
    fade_per_m: f32,
    thinness: f32,
    /// Pre-exposed.
    radiance_max: f32,
}

impl GiUniform {
    /// `exposure` is from pre-exposed radiance to what the tone curve takes.
    fn new(settings: &GiSettings, extent_m: f32, exposure: f32) -> Self {
        let radius_m = if settings.radius_m > 0.0 { settings.radius_m } else { RADIUS_SHARE * extent_m };
        let radius_m = if radius_m.is_finite() { radius_m.clamp(1e-6, 1e6) } else { 1e6 };
        let radiance_max = settings.brightness_max / exposure.max(1e-6);
        let radiance_max = if radiance_max > 0.0 { radiance_max.min(RADIANCE_MAX) } else { RADIANCE_MAX };
        Self { radius_m, fade_per_m: 1.0 / (FADE_SHARE * radius_m), thinness: settings.thinness, radiance_max }
    }
}

/// What the light passes are told of `occlusion` where these passes bring what surfaces reflect to each other: it must
/// not be guessed as well.
pub fn without_bounces(settings: &GiSettings, occlusion: Occlusion) -> Occlusion {
    let is_multi_bounce = occlusion.is_multi_bounce && !settings.enabled;
    Occlusion { is_multi_bounce, ..occlusion }
}

/// Records the passes, if the settings ask for them. `is_occluded` says whether the environment's light is taken away
/// where surfaces hide it from each other. Also gives what was found of each pixel, if the picture shows surfaces that
/// are shaded where they are drawn, to which it is still to be added.
///
/// # Errors
/// A program that does not compile.
pub fn record(
    r: &mut Recorder<'_, '_>,
    settings: &GiSettings,
    gbuffer: &Gbuffer,
    is_occluded: bool,
    depth: &Handle,
    radiance: Handle,
) -> Result<(Handle, Option<ScreenSpaceLight>), ProgramError> {
    if !settings.enabled || r.view.counts_pairs() {
        return Ok((radiance, None));
    }
    let is_filtered = r.view.shows_few_samples() || r.view.sample_count < UNFILTERED_SAMPLES;
    let of_few = settings.resolution != Resolution::Full;
    let side_px = settings.resolution.side_px();
    let constants = [("side", side_px), ("patterned", u32::from(is_filtered))];
    let uniform = GiUniform::new(settings, r.extent_m(), r.view.display_exposure);
    let desc = settings.resolution.desc(r.view, RADIANCE);

    let target = r.texture_of("gi", desc);
    let step = r.fullscreen("gi", "gi_gather", &[]).constants(&constants);
    let step = step.constants(&settings.constants()).uniform("gi", &uniform);
    let step = step.read("normal", &gbuffer.normal).read("linear_depth", &gbuffer.linear_depth);
    let step = step.read("scene_radiance", &radiance);
    let step = if of_few { step.within_surfaces(side_px) } else { step.over(PicturePart::Lit, depth) };
    let mut found = step.draw_into(target, NOTHING)?;
    if is_filtered {
        let target = r.texture_of("gi.filter", desc);
        let step = r.fullscreen("gi.filter", "gi_filter", &[]).constants(&constants[..1]).uniform("gi", &uniform);
        let step = step.read("normal", &gbuffer.normal).read("linear_depth", &gbuffer.linear_depth);
        let step = step.read("noisy_light", &found);
        let step = if of_few { step.within_surfaces(side_px) } else { step.over(PicturePart::Lit, depth) };
        found = step.draw_into(target, NOTHING)?;
    }
    let takes_environment = !is_occluded && !r.view.is_environment_dark;
    let constants = [constants[0], constants[1], ("takes_environment", u32::from(takes_environment))];
    let composing = ComposeStep { gbuffer, found: &found, depth, constants, uniform };
    let radiance = composing.step(r, "gi.compose").blend(ADD).draw_into(radiance, ColorLoad::Keep)?;
    if !r.shows_shaded_where_drawn() {
        return Ok((radiance, None));
    }
    let texture = if of_few || is_filtered {
        let target = r.texture("gi.upsample", RADIANCE);
        composing.step(r, "gi.upsample").constant("only_found", 1).draw_into(target, NOTHING)?
    } else {
        found
    };
    Ok((radiance, Some(ScreenSpaceLight { texture, takes_environment })))
}

/// What `gi_compose` is drawn with.
struct ComposeStep<'h> {
    gbuffer: &'h Gbuffer,
    found: &'h Handle,
    depth: &'h Handle,
    constants: [Constant; 3],
    uniform: GiUniform,
}

impl ComposeStep<'_> {
    /// It under the name `name`.
    fn step<'r, 'f>(&self, r: &'r mut Recorder<'_, 'f>, name: &'static str) -> Fullscreen<'r, 'f> {
        let step = self.gbuffer.read_by(r.fullscreen(name, "gi_compose", &[]));
        let step = step.constants(&self.constants).uniform("gi", &self.uniform).read("found_light", self.found);
        step.over(PicturePart::Lit, self.depth)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!("gi_gather", "Gi", GiUniform, [radius_m, fade_per_m, thinness, radiance_max]);
    }

    #[test]
    fn the_radius_is_that_of_the_settings_or_of_what_is_seen() {
        let of = |settings: &GiSettings, extent_m: f32| GiUniform::new(settings, extent_m, 2.0);
        let auto = GiSettings::default();
        let found = of(&auto, 5.0);
        assert_eq!((found.radius_m, found.radiance_max), (1.25, 1.0));
        assert_eq!(of(&GiSettings { radius_m: 2.0, ..auto.clone() }, 5.0).radius_m, 2.0);
        for extent_m in [f32::INFINITY, 0.0, 1.0] {
            let found = of(&GiSettings { brightness_max: 0.0, ..auto.clone() }, extent_m);
            assert!(found.radius_m > 0.0 && found.fade_per_m.is_finite(), "{found:?}");
            assert_eq!(found.radiance_max, RADIANCE_MAX);
        }
    }
}
