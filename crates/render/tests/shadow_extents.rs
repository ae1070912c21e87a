//! What is beside the eye looks the same whatever the scene's extent: shadows, against the ray caster, occlusion,
//! reflections, fog and decals.
//!
//! These need an adapter; the software one will do.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::shadows::{SIZE, light, radiance, request, shared, shares, surfaces, world_of};
use crate::common::{inner_pixels, plain_request};
use glam::{Quat, Vec3};
use manypass::{Environment, FogMode, Resolution, Settings};
use manypass_scene::decal::{Decal, DecalLook};
use manypass_scene::{LightKind, Material, Node, Projection, Scene, ShadingModel, primitives};
use manypass_testkit::build::{SceneBuilder, at, grey};
use manypass_testkit::raycast::Options;
use std::f32::consts::FRAC_PI_2;

/// Posts of 2 m in a row, seen from a man's height, on a ground of half the side `half_m`; all of it times `scale`.
fn posts(half_m: f32, scale: f32) -> Scene {
    let at_scale = |place: Vec3| at(scale * place);
    let lens = Projection::Perspective { fov_y_rad: 0.8, near_m: 0.05 * scale, far_m: None };
    let mut builder = SceneBuilder::new(scale * Vec3::new(0.0, 1.7, 3.0), scale * Vec3::new(0.0, 0.9, -3.0), lens);
    builder.put(primitives::plane(2.0 * half_m * scale), grey(0.5), at(Vec3::ZERO));
    for away_m in [0.0, -3.0, -6.0, -12.0] {
        let post = primitives::cube(scale * Vec3::new(0.25, 2.0, 0.25));
        builder.put(post, grey(0.5), at_scale(Vec3::new(-1.0, 1.0, away_m)));
    }
    builder.light(light(LightKind::Directional, 3.0), Vec3::ZERO, Vec3::new(1.0, -0.9, 0.15));
    builder.finish()
}

/// Of the pixels well within the shadows of the posts the share that is dark, and of those well outside the share that
/// is lit.
fn dark_and_lit(half_m: f32, scale: f32, change: impl Fn(&mut manypass::Settings)) -> (f64, f64) {
    let scene = posts(half_m, scale);
    let world = world_of(&scene);
    let frame = surfaces(&world);
    let size = (frame.width, frame.height);
    let found = shares(&scene, &request(&scene).with(change), 1);
    let hard = Options { light_samples_per_axis: 0, ..Options::default() };
    let is_ground = |pixel: usize| frame.object_id[pixel] == 2;
    let is_lit = |pixel: usize| is_ground(pixel) && world.visibility_at(0, frame.position_world[pixel], hard) > 0.5;
    let (mut dark, mut shadowed, mut bright, mut lit) = (0u32, 0u32, 0u32, 0u32);
    for pixel in inner_pixels(&frame.object_id, size) {
        let around = [pixel, pixel - 1, pixel + 1, pixel - size.0, pixel + size.0];
        let (Some(share), true) = (found[pixel], around.iter().all(|at| is_ground(*at))) else { continue };
        if around.iter().all(|at| !is_lit(*at)) {
            shadowed += 1;
            dark += u32::from(share < 0.5);
        } else if around.iter().all(|at| is_lit(*at)) {
            lit += 1;
            bright += u32::from(share > 0.9);
        }
    }
    assert!(shadowed > 60 && lit > 1000, "{shadowed} in shadow, {lit} lit: nothing to look at");
    (f64::from(dark) / f64::from(shadowed), f64::from(bright) / f64::from(lit))
}

#[test]
fn shadows_beside_the_eye_do_not_depend_on_the_extent_of_the_scene() {
    // Of 20 m to 200 km of ground, and all of it a thousandth and a thousand times as large.
    for (half_m, scale) in [(10.0, 1.0), (500.0, 1.0), (2_000.0, 1.0), (1e5, 1.0), (2_000.0, 1e-3), (500.0, 1e3)] {
        let (dark, lit) = dark_and_lit(half_m, scale, |_| ());
        println!("{half_m} m times {scale}: {dark:.3} of the shadow is dark, {lit:.4} of the rest is lit");
        assert!(dark >= 0.9 && lit >= 0.995, "{half_m} m times {scale}: {dark} dark, {lit} lit");
    }
    // The test can fail: a single map of the whole ground shows nothing of the posts.
    let (dark, _) = dark_and_lit(2_000.0, 1.0, |settings| settings.shadows.cascades = 1);
    assert!(dark < 0.5, "one map of 4 km has {dark} of the shadows");
}

#[test]
fn shadows_end_at_a_distance_that_settings_give() {
    let (near, _) = dark_and_lit(2_000.0, 1.0, |settings| {
        settings.shadows.cascades = 2;
        settings.shadows.distance_m = 25.0;
    });
    assert!(near >= 0.9, "{near}");
    let (none, lit) = dark_and_lit(2_000.0, 1.0, |settings| settings.shadows.distance_m = 0.5);
    assert!(none < 0.05 && lit >= 0.999, "shadows beyond half a metre: {none}, {lit}");
}

/// A floor of 12 m from above, along parallel rays, 15 pixels a metre; and two plates over it, whose shadows a sun at
/// 45° moves to the right by their heights of 0.5 m and 3 m.
fn plates() -> Scene {
    let lens = Projection::Orthographic { height_m: 8.0, near_m: 0.1, far_m: 20.0 };
    let mut builder = SceneBuilder::new(Vec3::Y * 6.0, Vec3::ZERO, lens);
    builder.put(primitives::plane(12.0), grey(0.5), at(Vec3::ZERO));
    for place in [Vec3::new(-1.0, 0.5, -1.5), Vec3::new(-1.0, 3.0, 1.5)] {
        builder.put(primitives::plane(0.8), grey(0.5), at(place));
    }
    builder.light(light(LightKind::Directional, 3.0), Vec3::ZERO, Vec3::new(1.0, -1.0, 0.0));
    builder.finish()
}

/// Whether the low plate and the high one cast their shadows.
fn cast(change: impl Fn(&mut manypass::Settings)) -> [bool; 2] {
    let scene = plates();
    let found = shares(&scene, &request(&scene).with(change), 1);
    // Right of the low plate's own picture, and the middle of the high one's shadow.
    [(-0.3, -1.5), (2.0, 1.5)].map(|(x_m, z_m): (f32, f32)| {
        let (column, row) = (80.0 + 15.0 * x_m, 60.0 + 15.0 * z_m);
        found[row as usize * SIZE.0 as usize + column as usize].unwrap() < 0.5
    })
}

/// The rays of the sun enter the ball around all at 8.6 m from its middle, 6.9 m before the high plate and 8.6 m before
/// the low one: z in light space is (y − x) / √2, that of the middle is 1.06 m.
#[test]
fn what_casts_lies_between_the_planes_that_settings_give() {
    assert_eq!(cast(|_| ()), [true, true]);
    assert_eq!(cast(|settings| settings.shadows.near_m = 7.7), [true, false]);
    assert_eq!(cast(|settings| settings.shadows.far_m = 7.7), [false, true]);
    let both = |settings: &mut manypass::Settings| (settings.shadows.near_m, settings.shadows.far_m) = (6.0, 9.5);
    assert_eq!(cast(both), [true, true]);
}

/// Both shadows lie 1.5 m from the middle, across the sun's rays and at right angles to the other side of its square.
#[test]
fn shadows_lie_within_the_extent_that_settings_give() {
    assert_eq!(cast(|settings| settings.shadows.extent_m = 4.0), [true, true]);
    assert_eq!(cast(|settings| settings.shadows.extent_m = 2.6), [false, false]);
}

/// A camera before a box of 1 m, on a ground of half the side `half_m`; all of it times `scale`.
fn box_on_ground(half_m: f32, scale: f32) -> SceneBuilder {
    let lens = Projection::Perspective { fov_y_rad: 0.8, near_m: 0.05 * scale, far_m: None };
    let mut builder = SceneBuilder::new(scale * Vec3::new(1.5, 1.6, 3.0), scale * Vec3::new(0.0, 0.3, 0.0), lens);
    builder.put(primitives::plane(2.0 * half_m * scale), grey(0.5), at(Vec3::ZERO));
    builder.put(primitives::cube(Vec3::splat(scale)), grey(0.5), at(scale * Vec3::new(0.0, 0.5, 0.0)));
    builder
}

fn picture(scene: &Scene, change: impl Fn(&mut Settings)) -> Vec<[f32; 3]> {
    let mut renderer = shared();
    renderer.unload();
    renderer.load(scene).unwrap();
    radiance(&mut renderer, scene, &plain_request(scene, SIZE).with(change), 1)
}

/// How many pixels differ by more than `most` in any channel.
fn count_apart(a: &[[f32; 3]], b: &[[f32; 3]], most: f32) -> usize {
    a.iter().zip(b).filter(|(a, b)| (Vec3::from(**a) - Vec3::from(**b)).abs().max_element() > most).count()
}

/// The mean difference below the horizon.
fn mean_apart(a: &[[f32; 3]], b: &[[f32; 3]]) -> f32 {
    let below = a.len() / 2;
    a.iter().zip(b).skip(below).map(|(a, b)| (a[1] - b[1]).abs()).sum::<f32>() / (a.len() - below) as f32
}

#[test]
fn occlusion_beside_a_box_does_not_depend_on_the_extent_of_the_scene() {
    let seen = |half_m: f32, radius_m: f32| {
        picture(&box_on_ground(half_m, 1.0).finish(), |settings| {
            settings.environment.source = Environment::Color([1.0; 3]);
            settings.occlusion.enabled = true.into();
            settings.occlusion.radius_m = radius_m;
        })
    };
    let small = seen(20.0, 0.0);
    for half_m in [1e3, 5e4] {
        let apart = mean_apart(&small, &seen(half_m, 0.0));
        assert!(apart < 1e-3, "{half_m} m: {apart}");
    }
    // The test can fail: the radius as a share of the diagonal.
    let apart = mean_apart(&small, &seen(5e4, 7e3));
    assert!(apart > 4e-3, "{apart}");
}

/// A sheet and a box that glow, over a mirror: rays that pass behind the sheet do not meet it.
#[test]
fn mirrors_do_not_depend_on_the_extent_of_the_scene() {
    let glowing = |color: Vec3| Material {
        base_color_factor: color.extend(1.0),
        shading_model: ShadingModel::Unlit,
        ..Material::default()
    };
    let seen = |half_m: f32| {
        let lens = Projection::Perspective { fov_y_rad: 0.8, near_m: 0.05, far_m: None };
        let mut builder = SceneBuilder::new(Vec3::new(0.5, 1.2, 3.0), Vec3::new(0.0, 0.3, 0.0), lens);
        let mirror = Material { metallic_factor: 1.0, roughness_factor: 0.0, ..grey(0.9) };
        builder.put(primitives::plane(2.0 * half_m), mirror, at(Vec3::ZERO));
        let rotation = Quat::from_rotation_x(FRAC_PI_2);
        let sheet = Node { rotation, ..at(Vec3::new(-0.4, 0.7, 0.0)) };
        builder.put(primitives::plane(1.0), glowing(Vec3::X), sheet);
        let green = glowing(Vec3::Y);
        builder.put(primitives::cube(Vec3::new(1.0, 0.5, 1.0)), green, at(Vec3::new(0.3, 0.25, -1.5)));
        picture(&builder.finish(), |settings| {
            settings.environment.source = Environment::Color([0.0; 3]);
            settings.reflections.enabled = true.into();
            settings.reflections.resolution = Resolution::Full;
        })
    };
    let small = seen(20.0);
    assert!(small.iter().filter(|pixel| pixel[0] > 0.1).count() > 2500, "nothing to look at");
    for half_m in [1e3, 5e4] {
        // A thickness of a share of the diagonal makes over 500 pixels wrong.
        let apart = count_apart(&small, &seen(half_m), 0.1);
        assert!(apart < 60, "{half_m} m: {apart}");
    }
}

/// The box with a decal before it in the sun, all of it times `scale`; in fog of the same look.
fn decal_in_fog(half_m: f32, scale: f32, change: impl Fn(&mut Settings)) -> Vec<[f32; 3]> {
    let mut builder = box_on_ground(half_m, scale);
    builder.light(light(LightKind::Directional, 3.0), Vec3::ZERO, Vec3::new(1.0, -0.9, 0.15));
    let mut scene = builder.finish();
    let look = DecalLook { color: Vec3::new(0.9, 0.1, 0.1), ..DecalLook::default() };
    let mut decal = Decal::new("of a test", look);
    decal.place(scale * Vec3::new(0.3, 0.0, 0.6), Vec3::NEG_Y, Vec3::NEG_Z, scale * Vec3::new(1.0, 1.0, 0.4));
    scene.decals.push(decal);
    picture(&scene, |settings| {
        settings.fog.mode = FogMode::Exponential;
        settings.fog.density_per_m = 0.2 / scale;
        settings.fog.scale_height_m = 0.7 * scale;
        settings.fog.scattering = 0.6;
        change(settings);
    })
}

#[test]
fn fog_and_decals_are_those_of_the_scene_at_every_scale() {
    let seen = |scale: f32, is_foggy: bool| {
        decal_in_fog(15.0, scale, |settings| {
            settings.fog.mode = if is_foggy { FogMode::Exponential } else { FogMode::None };
            settings.fog.far_m = 40.0 * scale;
        })
    };
    let plain = seen(1.0, true);
    let red = seen(1.0, false).iter().filter(|pixel| pixel[0] > 2.0 * pixel[1]).count();
    assert!(red > 400 && mean_apart(&plain, &seen(1.0, false)) > 0.02, "{red}: nothing to look at");
    for scale in [1e-3, 1e3] {
        let apart = count_apart(&plain, &seen(scale, true), 0.01);
        assert!(apart < 12, "× {scale}: {apart} pixels");
    }
}

/// The lower half of the picture ends some metres away; `fog.far_m` is at its default.
#[test]
fn fog_and_decals_beside_a_box_do_not_depend_on_the_extent_of_the_scene() {
    let small = decal_in_fog(20.0, 1.0, |_| ());
    let near = small.len() / 2;
    for half_m in [1e3, 5e4] {
        let large = decal_in_fog(half_m, 1.0, |_| ());
        // 1.7e-4 and 6 pixels of 9,600, at edges of the box, on 100 km; next to nothing on 2 km.
        let (apart, count) = (mean_apart(&small, &large), count_apart(&small[near..], &large[near..], 0.01));
        assert!(apart < 1e-3 && count < 25, "{half_m} m: {apart}, {count} pixels");
    }
    // The test can fail: fog that is looked for over a part of its way.
    let apart = mean_apart(&small, &decal_in_fog(5e4, 1.0, |settings| settings.fog.far_m = 0.5));
    assert!(apart > 0.01, "{apart}");
}
