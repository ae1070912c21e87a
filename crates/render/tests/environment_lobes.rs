//! What rough surfaces reflect of pictures of the environment, direction by direction, against integrals over all of
//! their texels.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common;
use crate::common::skies::{SIDE, Surroundings, maps, place, radiance, request, scene, turns};
use crate::common::{inner_pixels, plain_request, renderer};
use glam::{DVec3, Mat4, Quat, Vec3, Vec4};
use manypass::{Background, Environment};
use manypass_scene::environment::equirectangular_direction;
use manypass_scene::material::Anisotropy;
use manypass_scene::{EnvironmentMap, Light, LightKind, Material, Mesh, Node, Projection, Scene, primitives};
use manypass_testkit::raycast::Options;
use manypass_testkit::scenes;
use std::f32::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

/// How far what is reflected may be off, as shares of its own brightness in a direction or of the environment's mean,
/// whichever is more.
struct Bounds {
    roughness: f64,
    /// The root of the mean square, and the most in any direction.
    mean_square: f64,
    worst: f64,
    /// The most in a square of 17 degrees, or 0.3 radians, about the brightest place: a sun, which is a disc here and
    /// has whatever shape there.
    by_the_brightest: f64,
}

/// Lobes are narrower than texels of the picture at the first of them (the half width of its peak is 0.2 degrees, a
/// texel 0.35), so that it is tiles' resolution that edges of lamps are off by; from 0.2 on it is the number of
/// samples, at lamps of 5 degrees and less.
const BOUNDS: [Bounds; 8] = [
    Bounds { roughness: 0.05, mean_square: 0.015, worst: 0.18, by_the_brightest: 0.25 },
    Bounds { roughness: 0.1, mean_square: 0.008, worst: 0.06, by_the_brightest: 0.05 },
    Bounds { roughness: 0.15, mean_square: 0.004, worst: 0.04, by_the_brightest: 0.12 },
    Bounds { roughness: 0.2, mean_square: 0.004, worst: 0.025, by_the_brightest: 0.04 },
    Bounds { roughness: 0.3, mean_square: 0.008, worst: 0.04, by_the_brightest: 0.02 },
    Bounds { roughness: 0.5, mean_square: 0.004, worst: 0.02, by_the_brightest: 0.02 },
    Bounds { roughness: 0.7, mean_square: 0.004, worst: 0.012, by_the_brightest: 0.012 },
    Bounds { roughness: 1.0, mean_square: 0.005, worst: 0.015, by_the_brightest: 0.01 },
];

/// What the camera sees of a blurred environment is what a surface of that roughness reflects along its normal; of
/// roughness 1 it is irradiance.
#[test]
fn reflections_are_integrals_over_the_lobe() {
    let mut renderer = renderer();
    let mut faults = Vec::new();
    for map in maps() {
        let (name, sky) = (map.name.clone(), Surroundings::of(&map));
        let fov_of = |fov_y_rad: f32| Projection::Perspective { fov_y_rad, near_m: 0.1, far_m: None };
        let brightest = Quat::from_rotation_arc(Vec3::NEG_Z, sky.brightest().as_vec3());
        let scene = scene(map, fov_of(FRAC_PI_2));
        renderer.load(&scene).unwrap();
        let mean = sky.mean();
        for bounds in BOUNDS {
            let mut errors_of = |turn: Quat, fov_y_rad: f32| -> Vec<[f64; 2]> {
                let mut request = request(&scene, turn, 0.0);
                request.camera.projection = fov_of(fov_y_rad);
                request.settings.background.source = Background::Environment;
                request.settings.background.blur = bounds.roughness as f32;
                let found = radiance(&mut renderer, &scene, &request);
                let half = f64::from(0.5 * fov_y_rad).tan();
                let errors = (0..found.len()).step_by(61).map(|at| {
                    let (x, y) = place(at);
                    let to = turn.as_dquat() * DVec3::new(x * half, y * half, -1.0).normalize();
                    let truth = sky.reflection(to, bounds.roughness);
                    let of_all = 3.0 * mean.max(truth.element_sum() / 3.0);
                    [found[at], found[found.len() - 1 - at]].map(|found| (found - truth).abs().element_sum() / of_all)
                });
                errors.collect()
            };
            let all: Vec<[f64; 2]> = turns().flat_map(|turn| errors_of(turn, FRAC_PI_2)).collect();
            let by_the_brightest = errors_of(brightest, 0.3);
            let mean_square =
                |of: usize| (all.iter().map(|error| error[of].powi(2)).sum::<f64>() / all.len() as f64).sqrt();
            let worst = |errors: &[[f64; 2]]| errors.iter().map(|error| error[0]).fold(0.0, f64::max);
            let found = [mean_square(0), worst(&all), worst(&by_the_brightest)];
            println!("{name} at {}: {found:.4?}", bounds.roughness);
            let allowed = [bounds.mean_square, bounds.worst, bounds.by_the_brightest];
            let is_within = found.iter().zip(allowed).all(|(found, allowed)| *found <= allowed);
            if !is_within {
                faults.push(format!("{name} at {}: {found:.4?}, allowed {allowed:?}", bounds.roughness));
            }
            assert!(mean_square(1) > 5.0 * found[0], "the test cannot tell up from down");
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

/// Pixels that are brighter than all of their eight neighbours by more than a share of the brightest of these.
fn sparks(pixels: &[usize], width: usize, luminance: &[f64], more: f64) -> Vec<usize> {
    let brightest_about = |at: usize| {
        let rows = [at - width, at, at + width];
        rows.into_iter()
            .flat_map(|row| row - 1..=row + 1)
            .filter(|other| *other != at)
            .map(|other| luminance[other])
            .fold(0.0, f64::max)
    };
    pixels.iter().copied().filter(|at| luminance[*at] > (1.0 + more) * brightest_about(*at)).collect()
}

/// The radiance of the sky of [`small_sun`] and of its sun, and the sun's first texel.
const SKY: Vec3 = Vec3::splat(0.3);
const SUN_RADIANCE: f32 = 50_000.0;
const SUN_PLACE: (u32, u32) = (640, 150);

/// A grey sky with a sun of so many texels squared.
fn small_sun(texels: u32) -> EnvironmentMap {
    let mut map = EnvironmentMap::from_fn("small sun", 1024, 512, |_| SKY);
    for i in 0..texels * texels {
        let (x, y) = (SUN_PLACE.0 + i % texels, SUN_PLACE.1 + i / texels);
        map.texels[(y * map.width + x) as usize] = [half::f16::from_f32(SUN_RADIANCE); 4];
    }
    map
}

#[test]
fn one_small_sun_does_not_sparkle() {
    const SIZE: (u32, u32) = (320, 132);
    const ROUGHNESS: [f32; 5] = [0.15, 0.25, 0.4, 0.6, 0.9];
    let mut renderer = renderer();
    let spheres = scenes::furnace(0, [0.5, 0.9]);
    let truth = spheres.world.render(SIZE.0 as usize, SIZE.1 as usize, Options::default());
    let inner: Vec<usize> = inner_pixels(&truth.object_id, (SIZE.0 as usize, SIZE.1 as usize));
    let inner: Vec<usize> = inner.into_iter().filter(|at| truth.object_id[*at] != 0).collect();
    for texels in [2, 4] {
        let map = small_sun(texels);
        let sun = Surroundings::of(&map).brightest();
        // Spheres with one highlight each.
        let mut lit = spheres.scene.clone();
        for (at, material) in lit.materials.iter_mut().enumerate() {
            material.roughness_factor = ROUGHNESS[at / 2];
        }
        lit.environment = Some(Arc::new(map));
        let mut request = plain_request(&lit, SIZE);
        request.settings.environment.source = Environment::File;
        renderer.load(&lit).unwrap();
        let found = radiance(&mut renderer, &lit, &request);
        let mut luminance: Vec<f64> = found.iter().map(|value| value.element_sum() / 3.0).collect();
        for sphere in 1..=10 {
            let of_sphere: Vec<usize> = inner.iter().copied().filter(|at| truth.object_id[*at] == sphere).collect();
            let highest = of_sphere.iter().map(|at| luminance[*at]).fold(0.0, f64::max);
            let least = of_sphere.iter().map(|at| luminance[*at]).fold(f64::MAX, f64::min);
            assert!(highest > 1.3 * least, "sphere {sphere} has no highlight: {least} to {highest}");
            let of_highlight = |at: &usize| luminance[*at] == highest;
            let sparks: Vec<usize> = sparks(&of_sphere, SIZE.0 as usize, &luminance, 0.01);
            assert!(
                sparks.iter().all(of_highlight),
                "sphere {sphere} with a sun of {texels} texels sparkles at {sparks:?}"
            );
        }
        // What shines by itself is found.
        luminance[inner[inner.len() / 2]] *= 1.5;
        assert!(sparks(&inner, SIZE.0 as usize, &luminance, 0.01).contains(&inner[inner.len() / 2]));

        // What is reflected in all directions, away from the sun.
        let side = SIDE as usize;
        let inside: Vec<usize> = (side..side * (side - 1)).filter(|at| (1..side - 1).contains(&(at % side))).collect();
        for (turn, blur) in turns().flat_map(|turn| [0.05, 0.1, 0.3, 0.7].map(|blur| (turn, blur))) {
            let mut request = common::skies::request(&lit, turn, 0.0);
            request.camera.projection = Projection::Perspective { fov_y_rad: FRAC_PI_2, near_m: 10.0, far_m: None };
            request.settings.background.source = Background::Environment;
            request.settings.background.blur = blur;
            let found = radiance(&mut renderer, &lit, &request);
            let luminance: Vec<f64> = found.iter().map(|value| value.element_sum() / 3.0).collect();
            let away = |at: &usize| {
                let (x, y) = place(*at);
                (turn.as_dquat() * DVec3::new(x, y, -1.0).normalize()).dot(sun) < 0.97
            };
            let away: Vec<usize> = inside.iter().copied().filter(away).collect();
            assert!(sparks(&away, side, &luminance, 0.005).is_empty(), "blur {blur}, a sun of {texels} texels");
        }
    }
}

/// The streak of a sun on brushed metal is brightest in its middle, falls off to both sides, and is as bright
/// everywhere as that of many lights which lie where the sun is.
#[test]
fn a_streak_is_brightest_in_its_middle() {
    const SIZE: (u32, u32) = (129, 33);
    const MIDDLE: usize = SIZE.0 as usize / 2;
    /// Lights along the side of a texel: closer to each other than the narrowest lobe is wide.
    const PARTS: u32 = 4;
    let mut renderer = renderer();
    let map = small_sun(3);
    let [(left, top), size] = [SUN_PLACE, (map.width, map.height)];
    // The camera is above the plane, and both lie along the sun's direction.
    let turn = Quat::from_rotation_arc(Vec3::Y, equirectangular_direction((left + 1, top + 1), size));
    let view = Mat4::from_quat(turn * Quat::from_rotation_x(-FRAC_PI_2)) * Mat4::from_translation(Vec3::Z * 2.0);
    let mut by_sun = scene(map, Projection::Perspective { fov_y_rad: 0.6, near_m: 0.1, far_m: None });
    let mut plane = primitives::plane(20.0);
    plane.material = Some(0);
    by_sun.meshes.push(Mesh { primitives: vec![plane], ..Mesh::default() }.into());
    by_sun.add_node(None, Node { mesh: Some(0), rotation: turn, ..Node::default() });
    let mut by_lights = by_sun.clone();
    by_lights.environment = Some(Arc::new(EnvironmentMap::from_fn("no sun", 64, 32, |_| SKY)));
    let fine = (size.0 * PARTS, size.1 * PARTS);
    for i in 0..9 * PARTS * PARTS {
        let place = (left * PARTS + i % (3 * PARTS), top * PARTS + i / (3 * PARTS));
        let towards = equirectangular_direction(place, fine);
        let solid_angle = TAU / fine.0 as f32 * PI / fine.1 as f32 * (1.0 - towards.y * towards.y).sqrt();
        let rotation = Quat::from_rotation_arc(Vec3::Z, towards);
        by_lights.add_node(None, Node { light: Some(i as usize), rotation, ..Node::default() });
        let intensity = SUN_RADIANCE * solid_angle;
        by_lights.lights.push(Light { intensity, kind: LightKind::Directional, ..Light::default() });
    }
    for (strength, roughness) in [(0.5f32, 0.05f32), (0.9, 0.05), (0.5, 0.2), (0.9, 0.2)] {
        let mut row = |lit: &mut Scene| -> Vec<f64> {
            lit.update_transforms();
            lit.materials = vec![Material {
                base_color_factor: Vec4::ONE,
                metallic_factor: 1.0,
                roughness_factor: roughness,
                anisotropy: Some(Anisotropy { strength, ..Anisotropy::default() }),
                ..Material::default()
            }];
            let mut request = plain_request(lit, SIZE);
            request.camera.world_from_view = view;
            request.settings.environment.source = Environment::File;
            renderer.load(lit).unwrap();
            let first = (SIZE.1 / 2 * SIZE.0) as usize;
            let all = radiance(&mut renderer, lit, &request);
            all[first..][..SIZE.0 as usize].iter().map(|value| value.x).collect()
        };
        let [found, truth] = [row(&mut by_sun), row(&mut by_lights)];
        let (left, right) = found.split_at(MIDDLE);
        // Those of more roughness are even over the whole picture.
        let is_narrow = roughness < 0.1;
        assert!(
            !is_narrow || (left.is_sorted() && right.is_sorted_by(|a, b| a >= b)),
            "{strength}, {roughness}: {found:.3?}"
        );
        let ratios = found.iter().zip(&truth).map(|(found, truth)| found / truth);
        let [least, most] = [f64::min, f64::max].map(|pick| ratios.clone().reduce(pick).unwrap());
        println!("{strength}, {roughness}: {least:.3} to {most:.3} of the lights', {:.1} in the middle", found[MIDDLE]);
        // The sun is a rectangle, and taken for a disc.
        assert!(least > 0.92 && most < 1.04, "{strength}, {roughness}: {found:.2?}, by lights {truth:.2?}");
    }
}
