//! Lights that are seen so small that they lose their range (`lights.min_px`), on every path.
//!
//! These need an adapter; the software one will do.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{plain_request, renderer};
use glam::{Mat4, Vec3};
use manypass::{FrameRequest, FrameStats, LightCulling, Path, Renderer};
use manypass_scene::{Light, LightKind, Projection, Scene, primitives};
use manypass_testkit::build::{SceneBuilder, at, grey};
use manypass_testkit::compare::{Picture, Tolerance, assert_same};
use manypass_testkit::scenes;

/// Lights above a long floor, of four kinds by turns: points and spots, with shadows and without.
const LIGHT_COUNT: u16 = 2000;

/// The least size of the tests, in pixels: those of 1.5 m have all of their range up to about 16 m, and none beyond 30 m.
const MIN_PX: f32 = 8.0;

fn perspective() -> Projection {
    Projection::Perspective { fov_y_rad: 0.785, near_m: 0.1, far_m: None }
}

fn light(i: u16) -> Light {
    let kind = if i.is_multiple_of(2) {
        LightKind::Point
    } else {
        LightKind::Spot { inner_cone_rad: 0.5, outer_cone_rad: 0.9 }
    };
    Light { kind, intensity: 1.0, range_m: Some(1.5), casts_shadows: i % 4 < 2, ..Light::default() }
}

/// A floor of 400 m that the eye looks along, with a light on every 2 m of it.
fn field() -> Scene {
    let mut builder = SceneBuilder::new(Vec3::new(0.0, 3.0, 4.0), Vec3::new(0.0, 0.0, -12.0), perspective());
    builder.put(primitives::plane(800.0), grey(0.5), at(Vec3::ZERO));
    for i in 0..LIGHT_COUNT {
        let place = Vec3::new(2.0 * f32::from(i % 10) - 9.0, 0.7, -2.0 * f32::from(i / 10));
        builder.light(light(i), place, Vec3::NEG_Y);
    }
    builder.finish()
}

/// A floor under one light, so far before an eye that stands at a height of a metre.
fn at_distance(distance_m: f32) -> Scene {
    let mut builder = SceneBuilder::new(Vec3::Y, Vec3::new(0.0, 1.0, -1.0), perspective());
    builder.put(primitives::plane(800.0), grey(0.5), at(Vec3::ZERO));
    builder.light(light(0), Vec3::new(0.0, 0.7, -distance_m), Vec3::NEG_Y);
    builder.finish()
}

fn radiance(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> (Vec<f32>, FrameStats) {
    renderer.render(scene, request).unwrap();
    (renderer.read_radiance().unwrap(), renderer.stats())
}

fn limited(request: &FrameRequest, min_px: f32) -> FrameRequest {
    request.with(|settings| settings.lights.min_px = min_px)
}

#[test]
fn small_lights_cost_nothing_in_every_way_and_the_picture_is_that_of_brute_force() {
    let scene = field();
    let request = plain_request(&scene, (96, 64));
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let mut of_way = |path, culling, min_px: f32| {
        let request = limited(&request, min_px)
            .with(|settings| (settings.render.path, settings.lights.culling) = (path, culling));
        renderer.render(&scene, &request).unwrap();
        let picture = Picture::from_rgba8(96, 64, &renderer.read_display().unwrap());
        let stats = renderer.stats();
        let expected = if min_px > 0.0 { 1700..1999 } else { 0..1 };
        assert!(expected.contains(&stats.lights_too_small), "{} lights are too small", stats.lights_too_small);
        assert_eq!(stats.lights, u32::from(LIGHT_COUNT), "those that are left out count as the scene's, too");
        (picture, renderer.count_pairs(&scene, &request).unwrap())
    };
    let (truth, _) = of_way(Path::Forward, LightCulling::None, MIN_PX);
    let mut ways = LightCulling::NAMES
        .iter()
        .filter_map(|name| Some((Path::Deferred, LightCulling::named(name)?)))
        .collect::<Vec<_>>();
    ways.extend([Path::Forward, Path::ForwardBatched].map(|path| (path, LightCulling::Clustered)));
    for (path, culling) in ways {
        let (whole, all) = of_way(path, culling, 0.0);
        let (picture, fewer) = of_way(path, culling, MIN_PX);
        println!("{} {}: {all:?}, {fewer:?}", path.name(), culling.name());
        assert_same(&truth, &picture, Tolerance::default());
        assert!(whole != picture, "all of the lights are there");
        // Where volumes are marked hardly a pair is visited that is not shaded; lists visit many for each of those.
        let tenths = match (path, culling) {
            (Path::Deferred, LightCulling::VolumesStencil) => 9,
            (Path::Deferred, LightCulling::Volumes) => 7,
            _ => 5,
        };
        assert!(fewer.pairs_visited * 10 < all.pairs_visited * tenths, "{all:?}, {fewer:?}");
        assert!(fewer.pairs_shaded < all.pairs_shaded, "{all:?}, {fewer:?}");
    }
    // Light of vertices, which are few, is another picture.
    let [all, fewer] = [0.0, MIN_PX].map(|min_px| of_way(Path::Gouraud, LightCulling::Clustered, min_px).1);
    assert!(fewer.pairs_visited < all.pairs_visited, "{all:?}, {fewer:?}");
}

#[test]
fn lights_that_are_near_stay_as_they_are_to_the_byte() {
    let near = scenes::many_points(250).scene;
    let request = plain_request(&near, (96, 64));
    let mut renderer = renderer();
    renderer.load(&near).unwrap();
    let (all, _) = radiance(&mut renderer, &near, &request);
    let (same, stats) = radiance(&mut renderer, &near, &limited(&request, 6.0));
    assert_eq!((stats.lights_too_small, stats.lights), (0, 250));
    assert!(same == all, "lights that are seen large changed");
    assert!(radiance(&mut renderer, &near, &limited(&request, 24.0)).0 != all, "the setting does nothing");
    // Nor does it matter to one that is near how many there are far away, which pixels of the near part do not see.
    let field = field();
    renderer.load(&field).unwrap();
    let request = plain_request(&field, (96, 64));
    let (all, _) = radiance(&mut renderer, &field, &request);
    let (limited, stats) = radiance(&mut renderer, &field, &limited(&request, MIN_PX));
    assert!(stats.lights_too_small > 1700);
    let below = 4 * 96 * 48;
    assert!(all[below..] == limited[below..] && all[..below] != limited[..below]);
    assert!(all[below..].iter().any(|value| *value > 0.01 && *value != 1.0), "nothing is lit");
    let green = |pixels: &[f32]| pixels.chunks_exact(4).map(|pixel| f64::from(pixel[1])).sum::<f64>();
    let kept = green(&limited) / green(&all);
    println!("{} of 2,000 lights are left out, and {kept:.3} of all light is kept", stats.lights_too_small);
    assert!((0.7..1.0).contains(&kept), "{kept}");
}

#[test]
fn a_light_that_goes_away_goes_gradually() {
    let mut renderer = renderer();
    let mut sum = |distance_m: f32, min_px: f32| -> f64 {
        let scene = at_distance(distance_m);
        renderer.load(&scene).unwrap();
        // A long lens, so that it covers enough pixels to be measured.
        let mut request = limited(&plain_request(&scene, (120, 120)), min_px);
        request.camera.projection = Projection::Perspective { fov_y_rad: 0.06, near_m: 0.1, far_m: None };
        request.camera.world_from_view *= Mat4::from_rotation_x(-0.5 / distance_m);
        radiance(&mut renderer, &scene, &request).0.chunks_exact(4).map(|pixel| f64::from(pixel[1])).sum()
    };
    // 3 m at 28.5 to 61.5 m less 1.5 m: 120 / (2 tan 0.03) = 2,000 pixels a metre at a metre.
    let shares: Vec<f64> = (0..=44u8)
        .map(|step| {
            let distance_m = 28.5 + 0.75 * f32::from(step);
            sum(distance_m, 100.0) / sum(distance_m, 0.0)
        })
        .collect();
    println!("{shares:.3?}");
    assert_eq!((shares[0], shares[shares.len() - 1]), (1.0, 0.0), "{shares:?}");
    assert!(shares.is_sorted_by(|near, far| *near >= *far - 0.03), "{shares:?}");
    let jump = shares.windows(2).map(|pair| pair[0] - pair[1]).fold(0.0, f64::max);
    assert!(jump < 0.2, "{jump} of its light goes within 0.75 m: {shares:?}");
}

#[test]
fn shadow_maps_of_small_lights_go_with_them_and_views_that_see_them_large_keep_them() {
    let mut builder = SceneBuilder::new(Vec3::new(0.0, 3.0, 4.0), Vec3::new(0.0, 0.0, -12.0), perspective());
    builder.put(primitives::plane(800.0), grey(0.5), at(Vec3::ZERO));
    let pole = primitives::cube(Vec3::new(0.2, 1.4, 0.2));
    for i in 0..40u16 {
        let place = Vec3::new(0.0, 0.7, -2.0 * f32::from(i));
        builder.put(pole.clone(), grey(0.5), at(place + Vec3::X * 0.5));
        builder.light(Light { casts_shadows: true, ..light(1) }, place, Vec3::NEG_Y);
    }
    let scene = builder.finish();
    let request = plain_request(&scene, (96, 64)).with(|settings| settings.shadows.enabled = true);
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let (_, all) = radiance(&mut renderer, &scene, &request);
    let (_, fewer) = radiance(&mut renderer, &scene, &limited(&request, MIN_PX));
    println!("{} of {} lights with shadows", fewer.shadowed_lights, all.shadowed_lights);
    assert!(fewer.lights_too_small > 20 && fewer.shadowed_lights <= 40 - fewer.lights_too_small);
    assert!(all.shadowed_lights >= fewer.shadowed_lights + fewer.lights_too_small - 2, "{all:?}");
    // Maps of lights whose range shrinks are those of all of it, and stay where they are.
    assert_eq!(fewer.shadow_tiles_drawn, 0, "a map was drawn again because its light is seen small");
}
