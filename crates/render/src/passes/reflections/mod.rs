//! reflections: opaque surfaces reflect each other as far as the picture shows them, in place of the environment.
//!
//! Sources: rays in the picture (McGuire & Mara 2014, "Efficient GPU Screen-Space Ray Tracing") over a pyramid of least
//! distances (Uludag 2014, "Hi-Z Screen-Space Cone-Traced Reflections"), to visible normals of GGX (Heitz 2018); what
//! differs from them stands in `trace.wgsl`. Each sample of a still has another ray, so that their mean converges; that
//! of few samples is a pattern of 4 × 4 texels, which `reflections.filter` takes out. Where rays are of half the size,
//! `reflections.smooth` follows those of each pixel of flat smooth surfaces, and `reflections.sharpen` puts both
//! together. `reflections.compose` puts what was found in the place of the environment's specular light, of the same
//! surface and with the same shares; surfaces that are shaded where they are drawn do that themselves.
//! `reflections.cells` and `reflections.tiles` find the tiles in which rays brought anything; `reflections.filter`,
//! `reflections.sharpen` and `reflections.compose` draw within these alone.
//! Reads: G-buffer, linear_depth, occlusion, radiance. Writes: radiance.

mod cache;
mod inputs;
mod settings;
mod tiles;

pub use cache::CachedReflections;
pub use settings::ReflectionSettings;

use crate::constants::RADIANCE_MAX;
use crate::gbuffer::{Gbuffer, RADIANCE};
use crate::occlusion::Occlusion;
use crate::pass_info::{PassInfo, Reach};
use crate::record::{ADD, Fullscreen, PicturePart, Recorder};
use crate::render_settings::Path;
use crate::resolution::Resolution;
use crate::screen_space::Reflections;
use crate::shader::program::ProgramError;
use cache::CacheState;
use inputs::{RayInputs, record_backs, record_coarse_radiance, record_pyramid};
use manypass_graph::{ColorLoad, Handle, History, TextureDesc};
use manypass_scene::Aabb;
use tiles::Tiles;

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo {
    off: Some("reflections.enabled=false"),
    paths: &[Path::Deferred, Path::Forward, Path::ForwardBatched],
    in_fisheye: false,
    tiers: &["medium", "high", "ultra"],
    ..PassInfo::new("reflections")
};

/// How far it looks; none if settings switch it off.
pub fn reach(settings: &ReflectionSettings) -> Option<Reach> {
    settings.enabled.is_on().then_some(Reach::FirstSamples)
}

/// Where nothing is reflected.
const NOTHING: ColorLoad = ColorLoad::Clear(wgpu::Color::TRANSPARENT);

/// The thickness, where the settings leave it open, as a share of the extent of what is seen.
const THICKNESS_SHARE: f32 = 0.004;

/// The same of the most that a body is taken to be thick, whose back is drawn: what is farther behind is another's.
const THICKNESS_MAX_SHARE: f32 = 0.2;

/// The share of the distance over which reflections fade out.
const FADE_SHARE: f32 = 0.25;

/// Stills of so many samples are not filtered where all of them follow rays: the noise averages out by itself, where rays
/// meet small lamps, too.
const UNFILTERED_RAYS: u32 = 64;

/// The same where only the first samples follow rays, a quarter of the still's, and the others show their mean: so many of
/// those, which are many where the still is to be clean.
const UNFILTERED_MEAN: u32 = 256;

/// The rays of a square whose mean the filter takes.
const FILTERED_RAYS: u32 = 16;

/// Texels along a side of the pattern of rays of a filtered picture. Each sample moves it, and in sixteen of them each
/// texel has had each ray.
const PATTERN_SIDE: f32 = 4.0;

/// The uniform of `rays.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct ReflectionsUniform {
    distance_m: f32,
    /// 1 / the length over which reflections fade out before the distance ends; 0 where they do not.
    fade_per_m: f32,
    thickness_m: f32,
    roughness_max: f32,
    /// Pre-exposed; rays of a roughness have this divided by its square.
    radiance_max: f32,
    /// 1 / the number of rays of which a pixel shows the mean.
    share_of_ray: f32,
    /// The most that a body may be thick whose back is drawn.
    thickness_max_m: f32,
    /// Half of how far apart texels lie whose rays are alike, in pixels, counting those of all samples; 0 where every
    /// texel has a ray of its own.
    spacing_px: f32,
}

impl ReflectionsUniform {
    /// `exposure` is from pre-exposed radiance to what the tone curve takes; a pixel shows the mean of so many samples, and
    /// of so many rays in all. Rays go as far as anything is drawn, because a lake shows mountains; how thick what they
    /// meet is goes with the extent of what is seen.
    fn new(
        settings: &ReflectionSettings,
        (bounds_world, extent_m): (&Aabb, f32),
        exposure: f32,
        (samples, rays): (u32, u32),
    ) -> Self {
        let diagonal_m = if bounds_world.is_empty() { 1.0 } else { bounds_world.min.distance(bounds_world.max) };
        let diagonal_m = if diagonal_m.is_finite() { diagonal_m.clamp(1e-6, 1e6) } else { 1e6 };
        let extent_m = if extent_m.is_finite() { extent_m.clamp(1e-6, 1e6) } else { 1e6 };
        let of = |given_m: f32, auto_m: f32| if given_m > 0.0 { given_m.max(1e-6) } else { auto_m };
        let distance_m = of(settings.distance_m, diagonal_m);
        let fade_per_m = if settings.distance_m > 0.0 { 1.0 / (FADE_SHARE * distance_m) } else { 0.0 };
        let thickness_m = of(settings.thickness_m, THICKNESS_SHARE * extent_m);
        let thickness_max_m = THICKNESS_MAX_SHARE * extent_m;
        // The noise of a mean falls by the square root of the number of samples: by so much more may a ray bring, so that
        // the more the picture averages the less is cut, and in the end nothing is.
        let noise_gain = (samples.max(1) as f32).sqrt();
        let radiance_max = settings.brightness_max * noise_gain / exposure.max(1e-6);
        let radiance_max = if radiance_max > 0.0 { radiance_max.min(RADIANCE_MAX) } else { RADIANCE_MAX };
        Self {
            distance_m,
            fade_per_m,
            thickness_m,
            roughness_max: settings.roughness_max,
            radiance_max,
            share_of_ray: 1.0 / rays.max(1) as f32,
            thickness_max_m,
            spacing_px: 0.0,
        }
    }
}

/// What the passes read of the picture so far.
#[derive(Clone, Copy, Debug)]
pub struct ScreenInputs<'h> {
    /// What is known of its surfaces.
    pub gbuffer: &'h Gbuffer,
    /// What they hide from each other of the environment, which radiance has less of.
    pub occlusion: Option<&'h Occlusion>,
    /// Depth, with as many samples a pixel as the radiance that is added to.
    pub depth: &'h Handle,
    /// What rays meet, with one sample a pixel; none if that is what is added to.
    pub radiance: Option<&'h Handle>,
    /// What mirrors reflect, whose pixels follow no rays.
    pub mirrored: Option<&'h Handle>,
}

/// Whether the settings ask for it.
pub fn is_needed(r: &Recorder<'_, '_>, settings: &ReflectionSettings) -> bool {
    settings.enabled.is_on() && settings.roughness_max > 0.0 && !r.view.counts_pairs()
}

/// Records the passes, if the settings ask for them. `radiance` is what is added to. Also gives what was found of each
/// pixel, if the picture shows surfaces that are shaded where they are drawn, to which it is still to be added.
///
/// # Errors
/// A program that does not compile.
pub fn record(
    r: &mut Recorder<'_, '_>,
    settings: &ReflectionSettings,
    (screen, cached): (ScreenInputs<'_>, CachedReflections),
    radiance: Handle,
) -> Result<(Handle, Option<Reflections>), ProgramError> {
    if !is_needed(r, settings) || cached.reflections().is_some() {
        return Ok((radiance, None));
    }
    let met = screen.radiance.unwrap_or(&radiance);
    let (found, tiles) = match cached.state {
        CacheState::Unused => {
            RayPasses::new(r, settings, (r.view.sample_count, UNFILTERED_RAYS)).record(r, screen, met)?
        }
        CacheState::Growing(mean, whole) => record_mean(r, settings, (screen, met), (mean, whole))?,
        CacheState::Complete(reflections) => (reflections, None),
    };
    let radiance = record_composed(r, "reflections.compose", screen, (&found, tiles.as_ref()), radiance)?;
    let of_pixels = r.shows_shaded_where_drawn().then(|| record_upsampled(r, screen, found)).transpose()?;
    Ok((radiance, of_pixels))
}

/// What was found of each pixel.
fn record_upsampled(
    r: &mut Recorder<'_, '_>,
    screen: ScreenInputs<'_>,
    found: Reflections,
) -> Result<Reflections, ProgramError> {
    if found.side_px == 1 {
        return Ok(found);
    }
    let target = r.texture("reflections.upsample", RADIANCE);
    let step = screen.gbuffer.read_by(r.fullscreen("reflections.upsample", "reflections_keep", &[]));
    let step = Reflections::read_by(Some(&found), step).constant("takes_mean", 0).stand_in("previous_reflections");
    let texture = step.within_surfaces(1).draw_into(target, NOTHING)?;
    Ok(Reflections { texture, side_px: 1, ..found })
}

/// Puts what was found, which is within `tiles`, in the place of the environment's specular light, under the name `name`.
///
/// # Errors
/// A program that does not compile.
pub fn record_composed(
    r: &mut Recorder<'_, '_>,
    name: &'static str,
    screen: ScreenInputs<'_>,
    (found, tiles): (&Reflections, Option<&Tiles>),
    radiance: Handle,
) -> Result<Handle, ProgramError> {
    let step = screen.gbuffer.read_by(r.fullscreen(name, "reflections_compose", &[]));
    let step = Occlusion::read_by(screen.occlusion, Reflections::read_by(Some(found), step));
    Tiles::limit(tiles, 1, step).over(PicturePart::Lit, screen.depth).blend(ADD).draw_into(radiance, ColorLoad::Keep)
}

/// Of a still whose later samples leave tiles out: the mean of what each of its first `whole` samples finds, which draw
/// all that is reflected, and are as many as take the noise out.
fn record_mean(
    r: &mut Recorder<'_, '_>,
    settings: &ReflectionSettings,
    (screen, met): (ScreenInputs<'_>, &Handle),
    (mean, whole): (History, u32),
) -> Result<(Reflections, Option<Tiles>), ProgramError> {
    let (found, tiles) = RayPasses::new(r, settings, (whole, UNFILTERED_MEAN)).record(r, screen, met)?;
    let step = screen.gbuffer.read_by(r.fullscreen("reflections.mean", "reflections_keep", &[]));
    let step = Reflections::read_by(Some(&found), step).read("previous_reflections", &mean.previous);
    step.draw_into(mean.next, ColorLoad::Discard)?;
    Ok((found, tiles))
}

/// Half of how far apart, in pixels, texels of `side_px` lie whose rays are alike, in the mean of so many samples.
fn half_spacing_px(side_px: u32, samples: u32) -> f32 {
    let moved = samples.clamp(1, FILTERED_RAYS) as f32;
    0.5 * PATTERN_SIDE * side_px as f32 / moved.sqrt()
}

/// How rays are followed, and into what.
struct RayPasses<'s> {
    settings: &'s ReflectionSettings,
    uniform: ReflectionsUniform,
    desc: TextureDesc,
    side_px: u32,
    /// Whether its noise is a pattern, which is taken out.
    is_filtered: bool,
    /// Whether flat smooth surfaces alone follow rays.
    smooth_only: bool,
}

impl<'s> RayPasses<'s> {
    /// Of so many samples of which the picture shows the mean, and whose noise is filtered if they are fewer than that.
    fn new(r: &Recorder<'_, '_>, settings: &'s ReflectionSettings, (samples, unfiltered): (u32, u32)) -> Self {
        let is_filtered = samples < unfiltered || r.view.shows_few_samples();
        let samples = if r.view.shows_few_samples() { 1 } else { samples };
        let lengths = (&r.frame.world.bounds_world, r.extent_m());
        let rays = if is_filtered { samples.saturating_mul(FILTERED_RAYS) } else { samples };
        let side_px = settings.resolution.side_px();
        let uniform = ReflectionsUniform::new(settings, lengths, r.view.display_exposure, (samples, rays));
        let spacing_px = if is_filtered { half_spacing_px(side_px, samples) } else { 0.0 };
        Self {
            settings,
            uniform: ReflectionsUniform { spacing_px, ..uniform },
            desc: settings.resolution.desc(r.view, RADIANCE),
            side_px,
            is_filtered,
            smooth_only: false,
        }
    }

    /// Follows rays, and draws what they bring. Also gives the tiles in which that is.
    fn record(
        &self,
        r: &mut Recorder<'_, '_>,
        screen: ScreenInputs<'_>,
        met: &Handle,
    ) -> Result<(Reflections, Option<Tiles>), ProgramError> {
        let inputs = RayInputs {
            screen,
            met,
            pyramid: record_pyramid(r, &screen.gbuffer.linear_depth)?,
            coarse_radiance: record_coarse_radiance(r, met)?,
            backs: if self.settings.thickness_m > 0.0 { None } else { Some(record_backs(r)?) },
        };
        let rays = self.record_rays(r, "reflections", &inputs, None)?;
        let tiles = Tiles::record(r, &rays, self.side_px)?;
        let filtered = self
            .is_filtered
            .then(|| self.record_filter(r, "reflections.filter", screen, (&rays, None, &tiles)))
            .transpose()?;
        let sharp = self.sharp(r);
        let sharp_rays =
            sharp.as_ref().map(|sharp| sharp.record_rays(r, "reflections.smooth", &inputs, Some(&rays))).transpose()?;
        let texture = filtered.unwrap_or(rays);
        let coarse = Reflections { texture, side_px: self.side_px, roughness_max: self.settings.roughness_max };
        let (Some(sharp), Some(sharp_rays)) = (sharp, sharp_rays) else { return Ok((coarse, Some(tiles))) };
        let texture = sharp.record_filter(r, "reflections.sharpen", screen, (&sharp_rays, Some(&coarse), &tiles))?;
        Ok((Reflections { texture, side_px: 1, ..coarse }, Some(tiles)))
    }

    /// The same for each pixel of flat smooth surfaces, if there may be any: edges in mirrors are as sharp as others. At
    /// a quarter of the size they are not, because then speed is asked for.
    fn sharp(&self, r: &Recorder<'_, '_>) -> Option<Self> {
        let is_asked = self.settings.resolution == Resolution::Half && r.frame.world.may_be_smooth;
        is_asked.then(|| Self {
            uniform: ReflectionsUniform { spacing_px: 0.5 * self.uniform.spacing_px, ..self.uniform },
            desc: r.view.desc(RADIANCE),
            side_px: 1,
            smooth_only: true,
            ..*self
        })
    }

    /// Follows rays; where flat smooth surfaces alone do, those near `coarse` ones that met something.
    fn record_rays(
        &self,
        r: &mut Recorder<'_, '_>,
        name: &'static str,
        inputs: &RayInputs<'_>,
        coarse: Option<&Handle>,
    ) -> Result<Handle, ProgramError> {
        let RayInputs { screen, met, pyramid, coarse_radiance, backs } = inputs;
        let target = r.texture_of(name, self.desc);
        let step = screen.gbuffer.read_by(r.fullscreen(name, "reflections_trace", &[]));
        let step = step.constants(&[("steps", self.settings.length()), ("smooth_only", u32::from(self.smooth_only))]);
        let step = step.read("nearest_distances", pyramid).read("scene_radiance", met);
        let step = step.read("coarse_radiance", coarse_radiance);
        let step = match backs {
            Some(backs) => step.constant("has_backs", 1).read("back_distances", backs),
            None => step.stand_in("back_distances"),
        };
        let step = match coarse {
            Some(rays) => step.read("coarse_reflections", rays),
            None => step.stand_in("coarse_reflections"),
        };
        let step = match screen.mirrored {
            Some(mirrored) => step.constant("has_mirrors", 1).read("mirrored", mirrored),
            None => step.stand_in("mirrored"),
        };
        self.draw_lit(step, *screen, target)
    }

    /// Takes noise and dots out of `noisy`, and puts what is of smooth surfaces over `coarse`.
    fn record_filter(
        &self,
        r: &mut Recorder<'_, '_>,
        name: &'static str,
        screen: ScreenInputs<'_>,
        (noisy, coarse, tiles): (&Handle, Option<&Reflections>, &Tiles),
    ) -> Result<Handle, ProgramError> {
        let target = r.texture_of(name, self.desc);
        let step = screen.gbuffer.read_by(r.fullscreen(name, "reflections_filter", &[]));
        let step = Reflections::read_by(coarse, step).read("noisy_reflections", noisy);
        // Rays have no slot left for the tiles: WebGL 2 has sixteen textures.
        self.draw_lit(Tiles::limit(Some(tiles), self.side_px, step), screen, target)
    }

    fn draw_lit(
        &self,
        step: Fullscreen<'_, '_>,
        screen: ScreenInputs<'_>,
        target: Handle,
    ) -> Result<Handle, ProgramError> {
        let constants = [("side", self.side_px), ("patterned", u32::from(self.is_filtered))];
        let step = step.constants(&constants).uniform("reflections", &self.uniform);
        let is_tested = self.side_px == 1 && screen.depth.desc().samples == 1;
        let step =
            if is_tested { step.over(PicturePart::Lit, screen.depth) } else { step.within_surfaces(self.side_px) };
        step.draw_into(target, NOTHING)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;
    use glam::Vec3;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!(
            "reflections_trace",
            "Reflections",
            ReflectionsUniform,
            [
                distance_m,
                fade_per_m,
                thickness_m,
                roughness_max,
                radiance_max,
                share_of_ray,
                thickness_max_m,
                spacing_px
            ]
        );
    }

    #[test]
    fn moved_patterns_lie_closer() {
        let found = [(2, 1), (2, 4), (1, 16), (4, 64)].map(|(side_px, samples)| half_spacing_px(side_px, samples));
        assert_eq!(found, [4.0, 2.0, 0.5, 2.0]);
    }

    #[test]
    fn lengths_are_those_of_the_settings_or_of_the_scene() {
        let of = |settings: &ReflectionSettings, bounds: &Aabb, extent_m: f32| {
            ReflectionsUniform::new(settings, (bounds, extent_m), 2.0, (1, 16))
        };
        let auto = ReflectionSettings::default();
        let bounds = Aabb { min: Vec3::ZERO, max: Vec3::new(3.0, 0.0, 4.0) };
        let found = of(&auto, &bounds, 2.5);
        assert_eq!((found.distance_m, found.fade_per_m, found.thickness_m), (5.0, 0.0, THICKNESS_SHARE * 2.5));
        assert_eq!(found.thickness_max_m, THICKNESS_MAX_SHARE * 2.5);
        assert_eq!(found.radiance_max, 0.25);
        let given = ReflectionSettings { distance_m: 2.0, thickness_m: 0.5, ..auto.clone() };
        let found = of(&given, &bounds, 2.5);
        assert_eq!((found.distance_m, found.fade_per_m, found.thickness_m), (2.0, 2.0, 0.5));
        let far = Aabb { min: Vec3::splat(-3e38), max: Vec3::splat(3e38) };
        let point = Aabb { min: Vec3::ONE, max: Vec3::ONE };
        for (bounds, extent_m) in [(far, f32::INFINITY), (point, 0.0), (Aabb::EMPTY, 1.0)] {
            let found = of(&auto, &bounds, extent_m);
            assert!(found.distance_m > 0.0 && found.distance_m.is_finite() && found.thickness_m > 0.0, "{found:?}");
        }
    }
}
