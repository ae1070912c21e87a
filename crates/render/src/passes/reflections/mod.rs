//! reflections: opaque surfaces reflect each other as far as the picture shows them, in place of the environment.
//!
//! Sources: rays in the picture (McGuire & Mara 2014, "Efficient GPU Screen-Space Ray Tracing") over a pyramid of least
//! distances (Uludag 2014, "Hi-Z Screen-Space Cone-Traced Reflections"), to visible normals of GGX (Heitz 2018); what
//! differs from them stands in `trace.wgsl`. Each sample of a still has another ray, so that their mean converges; that
//! of few samples is a pattern of 4 × 4 texels, which `reflections.filter` takes out. `reflections.compose` puts what
//! was found in the place of the environment's specular light, of the same surface and with the same shares.
//! Reads: G-buffer, linear_depth, occlusion, radiance. Writes: radiance.

mod settings;

pub use settings::ReflectionSettings;

use crate::constants::{RADIANCE_MAX, REFLECTION_LEVELS};
use crate::gbuffer::{Gbuffer, LINEAR_DEPTH, RADIANCE};
use crate::occlusion::Occlusion;
use crate::record::{ADD, PicturePart, Recorder};
use crate::resolution::Resolution;
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle, TextureDesc};
use manypass_scene::Aabb;

/// Where nothing is reflected.
const NOTHING: ColorLoad = ColorLoad::Clear(wgpu::Color::TRANSPARENT);

/// The thickness, where the settings leave it open, as a share of the diagonal of all that is drawn.
const THICKNESS_SHARE: f32 = 0.004;

/// The share of the distance over which reflections fade out.
const FADE_SHARE: f32 = 0.25;

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
    padding_0: f32,
    padding_1: f32,
    padding_2: f32,
}

impl ReflectionsUniform {
    /// `exposure` is from pre-exposed radiance to what the tone curve takes.
    fn new(settings: &ReflectionSettings, bounds_world: &Aabb, exposure: f32) -> Self {
        let diagonal_m = if bounds_world.is_empty() { 1.0 } else { bounds_world.min.distance(bounds_world.max) };
        let diagonal_m = if diagonal_m.is_finite() { diagonal_m.clamp(1e-6, 1e6) } else { 1e6 };
        let of = |given_m: f32, auto_m: f32| if given_m > 0.0 { given_m.max(1e-6) } else { auto_m };
        let distance_m = of(settings.distance_m, diagonal_m);
        let fade_per_m = if settings.distance_m > 0.0 { 1.0 / (FADE_SHARE * distance_m) } else { 0.0 };
        let thickness_m = of(settings.thickness_m, THICKNESS_SHARE * diagonal_m);
        let radiance_max = settings.brightness_max / exposure.max(1e-6);
        let radiance_max = if radiance_max > 0.0 { radiance_max.min(RADIANCE_MAX) } else { RADIANCE_MAX };
        let roughness_max = settings.roughness_max;
        Self {
            distance_m,
            fade_per_m,
            thickness_m,
            roughness_max,
            radiance_max,
            padding_0: 0.0,
            padding_1: 0.0,
            padding_2: 0.0,
        }
    }
}

/// Records the passes, if the settings ask for them.
///
/// # Errors
/// A program that does not compile.
pub fn record(
    r: &mut Recorder<'_, '_>,
    settings: &ReflectionSettings,
    gbuffer: &Gbuffer,
    occlusion: Option<&Occlusion>,
    depth: &Handle,
    radiance: Handle,
) -> Result<Handle, ProgramError> {
    if !settings.enabled || settings.roughness_max <= 0.0 || r.view.counts_pairs() {
        return Ok(radiance);
    }
    let is_filtered = r.view.shows_few_samples();
    let of_few = settings.resolution != Resolution::Full;
    let side = ("side", settings.resolution.side_px());
    let uniform = ReflectionsUniform::new(settings, &r.frame.world.bounds_world, r.view.display_exposure);
    let desc = settings.resolution.desc(r.view, RADIANCE);
    let pyramid = record_pyramid(r, &gbuffer.linear_depth)?;

    let target = r.texture_of("reflections", desc);
    let step = gbuffer.read_by(r.fullscreen("reflections", "reflections_trace", &[])).constant(side.0, side.1);
    let step = step.constants(&[("patterned", u32::from(is_filtered)), ("steps", settings.steps)]);
    let step = step.uniform("reflections", &uniform).read("nearest_distances", &pyramid);
    let step = step.read("scene_radiance", &radiance);
    let step = if of_few { step } else { step.over(PicturePart::Lit, depth) };
    let mut found = step.draw_into(target, NOTHING)?;
    if is_filtered {
        let target = r.texture_of("reflections.filter", desc);
        let step = gbuffer.read_by(r.fullscreen("reflections.filter", "reflections_filter", &[]));
        let step = step.constant(side.0, side.1).uniform("reflections", &uniform).read("noisy_reflections", &found);
        let step = if of_few { step } else { step.over(PicturePart::Lit, depth) };
        found = step.draw_into(target, NOTHING)?;
    }
    let step = gbuffer.read_by(r.fullscreen("reflections.compose", "reflections_compose", &[]));
    let step = Occlusion::read_by(occlusion, step).constant(side.0, side.1).uniform("reflections", &uniform);
    let step = step.read("found_reflections", &found).over(PicturePart::Lit, depth);
    step.blend(ADD).draw_into(radiance, ColorLoad::Keep)
}

/// The least distances of pixels, and of squares of 2 × 2, 4 × 4, … of them.
fn record_pyramid(r: &mut Recorder<'_, '_>, linear_depth: &Handle) -> Result<Handle, ProgramError> {
    let largest = 1 << (REFLECTION_LEVELS - 1);
    let [width, height] = [r.view.size.0, r.view.size.1].map(|side| side.next_multiple_of(largest));
    let desc = TextureDesc { mips: REFLECTION_LEVELS, ..TextureDesc::new_2d(width, height, LINEAR_DEPTH) };
    let pyramid = r.texture_of("reflections.pyramid", desc);
    for level in 0..REFLECTION_LEVELS {
        let target = r.graph.subview(&pyramid, level, 0);
        let finer = (level > 0).then(|| r.graph.subview(&pyramid, level - 1, 0));
        let name = format!("reflections.pyramid.{level}");
        let step = r.fullscreen(name, "reflections_pyramid", &[]).constant("begins", u32::from(level == 0));
        step.read("finer", finer.as_ref().unwrap_or(linear_depth)).draw_into(target, ColorLoad::Discard)?;
    }
    Ok(pyramid)
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
            [distance_m, fade_per_m, thickness_m, roughness_max, radiance_max, padding_0, padding_1, padding_2]
        );
    }

    #[test]
    fn lengths_are_those_of_the_settings_or_of_the_scene() {
        let of = |settings: &ReflectionSettings, bounds: &Aabb| ReflectionsUniform::new(settings, bounds, 2.0);
        let auto = ReflectionSettings::default();
        let bounds = Aabb { min: Vec3::ZERO, max: Vec3::new(3.0, 0.0, 4.0) };
        let found = of(&auto, &bounds);
        assert_eq!((found.distance_m, found.fade_per_m, found.thickness_m), (5.0, 0.0, THICKNESS_SHARE * 5.0));
        assert_eq!(found.radiance_max, 0.25);
        let given = ReflectionSettings { distance_m: 2.0, thickness_m: 0.5, ..auto.clone() };
        let found = of(&given, &bounds);
        assert_eq!((found.distance_m, found.fade_per_m, found.thickness_m), (2.0, 2.0, 0.5));
        let far = Aabb { min: Vec3::splat(-3e38), max: Vec3::splat(3e38) };
        let point = Aabb { min: Vec3::ONE, max: Vec3::ONE };
        for bounds in [far, point, Aabb::EMPTY] {
            let found = of(&auto, &bounds);
            assert!(found.distance_m > 0.0 && found.distance_m.is_finite() && found.thickness_m > 0.0, "{found:?}");
        }
    }
}
