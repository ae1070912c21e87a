//! Settings that hold a value of a textbook's formula have the effect that the formula says.
//!
//! These need an adapter; the software one will do.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::shadows::{perspective, radiance, shared};
use crate::common::{floats, plain_request};
use glam::{Quat, Vec3};
use image::{GrayImage, ImageFormat, Luma};
use manypass::{
    Aov, Environment, FrameRequest, OcclusionMethod, Path, ReflectanceModel, Renderer, Resolution, Settings,
};
use manypass_scene::material::{HeightMap, HeightMethod};
use manypass_scene::{
    Image, ImageSource, Material, Node, Projection, Sampler, Scene, ShadingModel, Texture, TextureRef,
    TextureTransform, primitives,
};
use manypass_testkit::build::{SceneBuilder, at, grey};
use manypass_testkit::scenes;
use std::f32::consts::FRAC_PI_2;
use std::f64::consts::PI;
use std::io::Cursor;

/// Of pictures of surfaces that occlude each other.
const SIZE: (u32, u32) = (64, 48);
/// How far they do.
const RADIUS_M: f32 = 1.0;

/// The radiance of one sample, green alone; the scenes are grey.
fn drawn(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<f64> {
    renderer.unload();
    renderer.load(scene).unwrap();
    radiance(renderer, scene, request, 1).into_iter().map(|pixel| f64::from(pixel[1])).collect()
}

/// A picture of 64 pixels a side of a floor of 4 m from above, under a lamp 1 m over its middle. Of each pixel the
/// cosine between normal and light, which comes from 1 / cosine metres; and what is seen.
fn lit_floor(material: &Material, change: impl Fn(&mut Settings)) -> Vec<(f64, f64)> {
    const SIDE: u32 = 64;
    let mut scene = scenes::one_light_on_one_plane().scene;
    scene.materials[0].metallic_factor = material.metallic_factor;
    scene.materials[0].roughness_factor = material.roughness_factor;
    let request = plain_request(&scene, (SIDE, SIDE)).with(change);
    let found = drawn(&mut shared(), &scene, &request);
    let cosine = |pixel: u32| {
        let [x_m, z_m] = [pixel % SIDE, pixel / SIDE].map(|at| 4.0 * (f64::from(at) + 0.5) / f64::from(SIDE) - 2.0);
        (x_m * x_m + z_m * z_m + 1.0).sqrt().recip()
    };
    (0..SIDE * SIDE).map(cosine).zip(found).collect()
}

/// The power of the cosine that a lobe has where the eye looks along the normal, with the factor that makes it reflect
/// all light there. Phong's angle is that to the light; Blinn's, to the half vector, is half of it.
fn lobe(model: ReflectanceModel, shininess: f64, n_dot_l: f64) -> f64 {
    match model {
        ReflectanceModel::Phong => (shininess + 2.0) / (2.0 * PI) * n_dot_l.powf(shininess),
        _ => {
            let norm = (shininess + 2.0) * (shininess + 4.0);
            let norm = norm / (8.0 * PI * (2.0f64.powf(-0.5 * shininess) + shininess));
            norm * (0.5 * n_dot_l.acos()).cos().powf(shininess)
        }
    }
}

#[test]
fn a_highlight_is_the_cosine_to_the_power_of_the_shininess() {
    // White metal has no diffuse light, and reflects all of the lobe.
    let metal = Material { metallic_factor: 1.0, roughness_factor: 0.9, ..Material::default() };
    for (model, shininess, path, tolerance) in [
        (ReflectanceModel::Phong, 16, Path::Forward, 0.01),
        (ReflectanceModel::Phong, 120, Path::Deferred, 0.02),
        (ReflectanceModel::BlinnPhong, 2, Path::Forward, 0.01),
        (ReflectanceModel::BlinnPhong, 120, Path::Forward, 0.01),
        (ReflectanceModel::BlinnPhong, 120, Path::Deferred, 0.02),
    ] {
        let case = format!("{model:?} to the power of {shininess}, {path:?}");
        let floor = lit_floor(&metal, |settings| {
            settings.shading.model = model;
            settings.shading.shininess = shininess;
            settings.render.path = path;
        });
        for (n_dot_l, found) in floor {
            let expected = lobe(model, f64::from(shininess), n_dot_l) * n_dot_l.powi(3);
            let error = (found - expected).abs() / expected.max(1e-2);
            assert!(error < tolerance, "{case}: {found} where the cosine is {n_dot_l}, expected {expected}");
        }
    }
}

#[test]
fn the_specular_strength_multiplies_the_highlight_alone() {
    let material = Material { metallic_factor: 0.3, roughness_factor: 0.9, ..Material::default() };
    let f0 = 0.04 * 0.7 + 0.3;
    for (model, strength) in [
        (ReflectanceModel::Phong, 0.0),
        (ReflectanceModel::Phong, 2.5),
        (ReflectanceModel::BlinnPhong, 0.5),
        (ReflectanceModel::BlinnPhong, 1.0),
    ] {
        let floor = lit_floor(&material, |settings| {
            settings.shading.model = model;
            settings.shading.shininess = 60;
            settings.shading.specular_strength = strength;
            settings.render.path = Path::Forward;
        });
        for (n_dot_l, found) in floor {
            let diffuse = (1.0 - f0) * 0.7 / PI;
            let specular = f64::from(strength) * f0 * lobe(model, 60.0, n_dot_l);
            let expected = (diffuse + specular) * n_dot_l.powi(3);
            let error = (found / expected - 1.0).abs();
            assert!(error < 0.01, "{model:?} times {strength}: {found}, expected {expected}");
        }
    }
}

#[test]
fn lamps_are_reflected_evenly_from_a_distance_on() {
    const LIGHTING_M: f32 = 3.3;
    // White metal: all that it mirrors becomes diffuse light.
    let metal = Material { metallic_factor: 1.0, roughness_factor: 0.5, ..Material::default() };
    for path in [Path::Forward, Path::Deferred] {
        let whole = lit_floor(&metal, |settings| settings.render.path = path);
        let reduced = lit_floor(&metal, |settings| {
            settings.render.path = path;
            settings.lod.lighting_m = LIGHTING_M;
        });
        let (mut far, mut near, mut changed) = (0, 0, 0);
        for ((n_dot_l, found), (_, before)) in reduced.into_iter().zip(whole) {
            // The eye is 3 m over the middle of the floor.
            let distance_m = (9.0 + n_dot_l.powi(-2) - 1.0).sqrt();
            let lambert = n_dot_l.powi(3) / PI;
            if distance_m > f64::from(LIGHTING_M) + 0.01 {
                far += 1;
                changed += usize::from((before / lambert - 1.0).abs() > 0.1);
                assert!((found / lambert - 1.0).abs() < 0.01, "{path:?}, {distance_m} m: {found} for {lambert}");
            } else if distance_m < f64::from(LIGHTING_M) - 0.01 {
                near += 1;
                assert!((found / before - 1.0).abs() < 2e-3, "{path:?}, {distance_m} m: {found} for {before}");
            }
        }
        assert!(far > 1000 && near > 1000 && changed > 1000, "{far} {near} {changed}");
    }
}

/// The mean radiance of a floor that is seen from above in an even light from everywhere.
fn under_even_light(material: Material, path: Path, reflectivity: f32) -> f64 {
    let projection = Projection::Orthographic { height_m: 2.0, near_m: 0.1, far_m: 10.0 };
    let mut builder = SceneBuilder::new(Vec3::Y * 3.0, Vec3::ZERO, projection);
    builder.put(primitives::plane(8.0), material, Node::default());
    let scene = builder.finish();
    let request = plain_request(&scene, (16, 16)).with(|settings| {
        settings.environment.source = Environment::Color([1.0; 3]);
        settings.render.path = path;
        settings.shading.reflectivity = reflectivity;
    });
    let found = drawn(&mut shared(), &scene, &request);
    found.iter().sum::<f64>() / found.len() as f64
}

#[test]
fn the_reflectivity_is_the_share_of_mirrored_light() {
    let black = Material { roughness_factor: 0.3, ..grey(0.0) };
    let white = Material { roughness_factor: 0.3, ..grey(1.0) };
    let metal = Material { metallic_factor: 1.0, roughness_factor: 0.3, ..grey(0.5) };
    for path in [Path::Deferred, Path::Forward] {
        // These have no diffuse light: what is seen is mirrored.
        for (material, least) in [(&black, 0.03), (&metal, 0.4)] {
            let whole = under_even_light(material.clone(), path, 1.0);
            assert!(whole > least && whole < 1.0, "{path:?}: {whole}");
            for share in [0.0, 0.5] {
                let ratio = under_even_light(material.clone(), path, share) / whole;
                assert!((ratio - f64::from(share)).abs() < 2e-3, "{path:?}, {share}: {ratio}");
            }
        }
        // White loses nothing, whatever the share.
        for share in [0.0, 0.5, 1.0] {
            let found = under_even_light(white.clone(), path, share);
            assert!((found - 1.0).abs() < 0.01, "{path:?}, {share}: {found}");
        }
    }
}

/// A mirror below a cube of an even radiance, and nothing else.
fn mirrored_cube() -> Scene {
    let mut builder = SceneBuilder::new(Vec3::new(0.0, 1.2, 4.0), Vec3::new(0.0, 0.4, 0.0), perspective());
    let mirror = Material { metallic_factor: 1.0, roughness_factor: 0.0, ..grey(1.0) };
    builder.put(primitives::plane(40.0), mirror, Node::default());
    let glowing = Material { shading_model: ShadingModel::Unlit, ..grey(0.8) };
    builder.put(primitives::cube(Vec3::splat(0.8)), glowing, at(Vec3::Y * 0.6));
    builder.finish()
}

#[test]
fn the_reflectivity_is_that_of_what_the_picture_shows_as_well() {
    let scene = mirrored_cube();
    let mut renderer = shared();
    let mut seen = |reflectivity: f32| {
        let request = plain_request(&scene, SIZE).with(|settings| {
            settings.environment.source = Environment::Color([0.0; 3]);
            settings.reflections.enabled = true.into();
            settings.reflections.resolution = Resolution::Full;
            settings.shading.reflectivity = reflectivity;
        });
        drawn(&mut renderer, &scene, &request)
    };
    let [none, half, whole] = [0.0, 0.5, 1.0].map(&mut seen);
    // What still shines is the cube itself.
    let (mut mirror, mut cube) = (0, 0);
    for ((none, half), whole) in none.iter().zip(&half).zip(&whole) {
        if *none > 1e-3 {
            cube += 1;
            assert!((none - 0.8).abs() < 0.01 && (whole - 0.8).abs() < 0.01, "the cube: {none}, {whole}");
        } else {
            mirror += usize::from(*whole > 0.3);
            assert!((half - 0.5 * whole).abs() < 5e-3, "{half} is not half of {whole}");
        }
    }
    assert!(mirror > 60 && cube > 60, "{mirror} pixels of the mirror show {cube} of the cube");
}

fn rough() -> Material {
    Material { roughness_factor: 1.0, ..grey(0.5) }
}

/// A floor and a wall that meet along the x-axis, so that all of a row of the picture is equally far from the other.
fn corner() -> Scene {
    let mut builder = SceneBuilder::new(Vec3::new(0.0, 2.5, 4.5), Vec3::new(0.0, 0.4, 0.4), perspective());
    builder.put(primitives::plane(40.0), rough(), Node::default());
    let rotation = Quat::from_rotation_x(FRAC_PI_2);
    builder.put(primitives::plane(40.0), rough(), Node { rotation, ..Node::default() });
    builder.finish()
}

/// At full size, as one sample finds it.
fn occluded(scene: &Scene, method: OcclusionMethod) -> FrameRequest {
    plain_request(scene, SIZE).with(|settings| {
        settings.environment.source = Environment::Color([1.0; 3]);
        settings.occlusion.enabled = true.into();
        settings.occlusion.method = method;
        settings.occlusion.resolution = Resolution::Full;
        settings.occlusion.radius_m = RADIUS_M;
        settings.occlusion.multi_bounce = false;
        settings.occlusion.blur = false;
    })
}

/// Of each pixel the share of light that is left.
fn visibility(scene: &Scene, request: &FrameRequest) -> Vec<f64> {
    let mut renderer = shared();
    let open = drawn(&mut renderer, scene, &request.with(|settings| settings.occlusion.enabled = false.into()));
    let found = drawn(&mut renderer, scene, request);
    found.iter().zip(&open).map(|(found, open)| found / open).collect()
}

/// The root mean square of what neighbours in a row differ by, and the mean; where all around is in the picture.
fn grain_and_mean(picture: &[f64]) -> (f64, f64) {
    let (mut squares, mut sum, mut count) = (0.0, 0.0, 0.0);
    for row in picture.chunks_exact(SIZE.0 as usize) {
        for pair in row[20..44].windows(2) {
            squares += (pair[1] - pair[0]).powi(2);
            sum += pair[0];
            count += 1.0;
        }
    }
    ((squares / f64::max(count, 1.0)).sqrt(), sum / f64::max(count, 1.0))
}

#[test]
fn the_kernel_of_points_is_the_number_of_looks() {
    let scene = corner();
    let of_points = occluded(&scene, OcclusionMethod::Ssao);
    let with = |kernel: u32| of_points.with(|settings| settings.occlusion.kernel = kernel);
    let (few, many) = (visibility(&scene, &with(4)), visibility(&scene, &with(64)));
    let ((of_few, _), (of_many, _)) = (grain_and_mean(&few), grain_and_mean(&many));
    println!("4 points have a grain of {of_few:.4}, 64 one of {of_many:.4}");
    // The deviation of a mean of sixteen times as many is at most a fourth; what pixels hide of it is left.
    assert!(of_few > 0.03 && of_few > 2.5 * of_many, "{of_few} {of_many}");
    // A share of four points is a number of fourths, where all of them lie well within the radius.
    let fourths = few.iter().filter(|share| (4.0 * **share - (4.0 * **share).round()).abs() < 0.02).count();
    assert!(fourths > few.len() * 9 / 10, "{fourths} of {}", few.len());
    // 0 takes as many as the other method looks at.
    let looks = 2 * of_points.settings.occlusion.slices * of_points.settings.occlusion.steps;
    assert!(visibility(&scene, &with(0)) == visibility(&scene, &with(looks)), "not {looks} points");
    assert!(visibility(&scene, &with(0)) != few, "0 takes four points");
}

#[test]
fn what_rises_less_than_the_bias_occludes_nothing() {
    const HEIGHT_M: f32 = 0.15;
    let projection = Projection::Orthographic { height_m: 3.0, near_m: 0.1, far_m: 10.0 };
    let mut builder = SceneBuilder::new(Vec3::Y * 4.0, Vec3::ZERO, projection);
    builder.put(primitives::plane(20.0), rough(), Node::default());
    builder.put(primitives::cube(Vec3::new(1.0, HEIGHT_M, 1.0)), rough(), at(Vec3::Y * 0.5 * HEIGHT_M));
    let scene = builder.finish();
    let of_points = occluded(&scene, OcclusionMethod::Ssao);
    let with =
        |height_m: f32| visibility(&scene, &of_points.with(|settings| settings.occlusion.bias = height_m / RADIUS_M));
    let [low, just_below, just_above] = [0.2 * HEIGHT_M, 0.95 * HEIGHT_M, 1.05 * HEIGHT_M].map(with);
    let dark = low.iter().filter(|share| **share < 0.97).count();
    assert!(dark > 60, "a step of {HEIGHT_M} m darkens {dark} pixels");
    assert!(low == just_below, "what rises more than the bias counts in full");
    assert!(just_above.iter().all(|share| (share - 1.0).abs() < 2e-3), "a step below the bias is dark");
}

#[test]
fn without_noise_all_pixels_look_in_the_same_directions() {
    let scene = corner();
    for method in [OcclusionMethod::Gtao, OcclusionMethod::Ssao] {
        let with = |noise: bool| {
            let request = occluded(&scene, method).with(|settings| settings.occlusion.noise = noise);
            grain_and_mean(&visibility(&scene, &request))
        };
        let ((noisy, mean), (plain, _)) = (with(true), with(false));
        println!("{method:?}: a grain of {noisy:.4} with noise, {plain:.4} without");
        assert!(mean < 0.99 && noisy > 0.01, "{method:?}: there is something to see: {mean}, {noisy}");
        assert!(plain < 0.2 * noisy, "{method:?}: {plain} without noise, {noisy} with it");
    }
}

#[test]
fn the_blur_takes_the_grain_and_leaves_the_mean() {
    let scene = corner();
    for method in [OcclusionMethod::Gtao, OcclusionMethod::Ssao] {
        let with = |blur: bool| {
            let request = occluded(&scene, method).with(|settings| settings.occlusion.blur = blur);
            grain_and_mean(&visibility(&scene, &request))
        };
        let ((sharp, mean), (blurred, mean_blurred)) = (with(false), with(true));
        println!(
            "{method:?}: a grain of {sharp:.4} and the mean {mean:.4}, blurred {blurred:.4} and {mean_blurred:.4}"
        );
        assert!(sharp > 0.01 && sharp > 2.5 * blurred, "{method:?}: {sharp} is blurred to {blurred}");
        assert!((mean - mean_blurred).abs() < 0.02, "{method:?}: {mean} becomes {mean_blurred}");
    }
}

/// A square of 1 m whose heights are 76 / 255 everywhere, so that all of it lies 0.702 of 20 cm below; stepped through
/// in layers.
fn sunken(eye: Vec3) -> Scene {
    let projection = Projection::Orthographic { height_m: 0.5, near_m: 0.1, far_m: 10.0 };
    let mut builder = SceneBuilder::new(eye, Vec3::ZERO, projection);
    let mut png = Vec::new();
    GrayImage::from_pixel(256, 256, Luma([76])).write_to(&mut Cursor::new(&mut png), ImageFormat::Png).unwrap();
    builder.scene.images.push(Image { name: String::new(), source: ImageSource::Encoded(png.into()) });
    builder.scene.textures.push(Texture { image: 0, sampler: Sampler::default() });
    let texture = TextureRef { texture: 0, uv_set: 0, transform: TextureTransform::default() };
    let height = HeightMap { texture, depth_m: 0.2, method: HeightMethod::Steep, self_shadow: false };
    builder.put(primitives::plane(1.0), Material { height: Some(height), ..rough() }, Node::default());
    builder.finish()
}

/// The share of the depth at which the middle of the picture lies.
fn share_of_depth(eye: Vec3, (steps_min, steps_max): (u32, u32)) -> f32 {
    let scene = sunken(eye);
    let request = plain_request(&scene, SIZE).with(|settings| {
        (settings.relief.steps_min, settings.relief.steps_max) = (steps_min, steps_max);
    });
    let request = FrameRequest { want_aovs: vec![Aov::Position], ..request };
    let mut renderer = shared();
    renderer.unload();
    renderer.load(&scene).unwrap();
    renderer.render(&scene, &request).unwrap();
    let positions = floats(renderer.read_aov(Aov::Position).unwrap());
    let middle = (SIZE.1 / 2 * SIZE.0 + SIZE.0 / 2) as usize;
    -positions[3 * middle + 1] / 0.2
}

/// What is seen is the last layer above the heights.
#[test]
fn layers_of_parallax_are_as_many_as_the_steps_of_relief() {
    let default = Settings::default().relief;
    let above = Vec3::Y * 3.0;
    for (steps, layer) in [(4, 2.0), (default.steps_min, 5.0), (16, 11.0)] {
        let (found, expected) = (share_of_depth(above, (steps, default.steps_max)), layer / steps as f32);
        assert!((found - expected).abs() < 2e-3, "{steps} layers: {found}, expected {expected}");
    }
    // Aslant a line of sight passes over nineteen pixels, which ask for more layers than are allowed.
    let aslant = Vec3::new(0.0, 2.0, 2.0);
    for (most, expected) in [(4, 2.0 / 4.0), (3, 2.0 / 4.0)] {
        let found = share_of_depth(aslant, (1, most));
        assert!((found - expected).abs() < 2e-3, "at most {most} layers: {found}, expected {expected}");
    }
    let free = share_of_depth(aslant, (1, default.steps_max));
    assert!(free > 0.55 && free < 0.702, "as many layers as texels ask for: {free}");
}

/// Keys with values.
type KeyValues = &'static [(&'static str, &'static str)];

/// Lengths of loops, the most that each may be, and what they do nothing without.
const LENGTHS: [(&str, u32, KeyValues); 9] = [
    ("occlusion.slices", 16, &[("occlusion.enabled", "true")]),
    ("occlusion.steps", 32, &[("occlusion.enabled", "true")]),
    ("occlusion.kernel", 256, &[("occlusion.enabled", "true"), ("occlusion.method", "ssao")]),
    ("gi.slices", 16, &[("gi.enabled", "true")]),
    ("gi.steps", 64, &[("gi.enabled", "true")]),
    ("reflections.steps", 1024, &[("reflections.enabled", "true")]),
    ("shadows.contact_steps", 64, &[("shadows.enabled", "true"), ("shadows.contact_m", "0.1")]),
    ("relief.steps_min", 256, &[]),
    ("relief.steps_max", 1024, &[]),
];

/// The lengths that the documentation of a setting says it is rounded up to.
fn documented_lengths(key: &str) -> Vec<u32> {
    let info = Settings::declared().iter().find(|info| info.key == key).unwrap();
    let (_, rounded) = info.doc.split_once("ounded up to ").unwrap_or_else(|| panic!("{key}: {}", info.doc));
    let (lengths, _) = rounded.split_once(", to limit the number of pipelines").unwrap();
    lengths.split(|c: char| !c.is_ascii_digit()).filter_map(|length| length.parse().ok()).collect()
}

#[test]
fn a_slider_of_a_loops_length_makes_at_most_eight_pipelines() {
    let [sunlit, sunken] = [scenes::sun().scene, sunken(Vec3::new(0.0, 2.0, 2.0))];
    let mut renderer = shared();
    for (key, most, needs) in LENGTHS {
        let scene = if key.starts_with("relief.") { &sunken } else { &sunlit };
        renderer.unload();
        renderer.load(scene).unwrap();
        let request = plain_request(scene, (32, 24)).with(|settings| {
            needs.iter().for_each(|(key, value)| settings.set(key, value).unwrap());
        });
        let mut made_by = |length: u32| {
            let request = request.with(|settings| settings.set(key, &length.to_string()).unwrap());
            renderer.render(scene, &request).unwrap();
            renderer.stats().pipelines_made
        };
        let lengths = documented_lengths(key);
        assert_eq!(lengths.last(), Some(&most), "{key}");
        let default =
            Settings::declared().iter().find(|info| info.key == key).unwrap().default.as_ref().unwrap().to_string();
        assert!(default == "0" || lengths.iter().any(|length| length.to_string() == default), "{key}: {default}");
        // All other pipelines of the frame, and those of one length.
        made_by(most);
        let made: u64 = lengths.iter().map(|length| made_by(*length)).sum();
        println!("{key}: {made} pipelines of {lengths:?}");
        assert!(made <= 7, "{key}: {made} pipelines beside that of the greatest length");
        let others: u64 = (0..32).map(|step| made_by(1 + step * (most - 1) / 31)).sum();
        assert_eq!(others, 0, "{key}: lengths beside {lengths:?}");
    }
}
