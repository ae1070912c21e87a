//! Which lights have shadow maps, and which of them a frame draws.
//!
//! These need an adapter; the software one will do.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::shadows::{SIZE, SPOT, light, perspective, radiance, request, shared, shares};
use crate::common::{self, renderer};
use glam::{Quat, Vec3};
use manypass::{FrameRequest, FrameStats, Renderer, View};
use manypass_scene::{Light, LightKind, Node, NodeId, Projection, Scene, primitives};
use manypass_testkit::build::{SceneBuilder, at, grey};

/// A floor with boxes on it, and 64 lights above them.
fn many_lights() -> SceneBuilder {
    let mut builder = SceneBuilder::new(Vec3::new(0.0, 5.0, 9.0), Vec3::ZERO, perspective());
    builder.put(primitives::plane(10.0), grey(0.5), at(Vec3::ZERO));
    for i in 0..64_u8 {
        let place = Vec3::new(f32::from(i % 8) - 3.5, 0.0, f32::from(i / 8) - 3.5);
        builder.put(primitives::cube(Vec3::splat(0.3)), grey(0.5), at(place + Vec3::Y * 0.15));
        let kind = if i % 2 == 0 { SPOT } else { LightKind::Point };
        builder.light(Light { range_m: Some(2.5), ..light(kind, 1.0) }, place + Vec3::new(0.2, 1.2, 0.3), Vec3::NEG_Y);
    }
    builder
}

fn render(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> FrameStats {
    renderer.render(scene, request).unwrap();
    renderer.stats()
}

#[test]
fn a_static_scene_with_64_shadowed_lights_draws_each_map_once() {
    let mut builder = many_lights();
    builder.light(light(LightKind::Directional, 1.0), Vec3::ZERO, Vec3::new(0.4, -1.0, 0.2));
    let scene = builder.finish();
    let request = request(&scene).with(|settings| settings.shadows.atlas_px = 4096);
    let mut renderer = shared();
    renderer.load(&scene).unwrap();
    let first = render(&mut renderer, &scene, &request);
    assert_eq!((first.shadowed_lights, first.lights_beyond_atlas, first.light_rounds), (65, 0, 1));
    // A spot has one map, a point light six, of which those that look up have nothing to show, the sun at least one.
    assert!(first.shadow_tiles_drawn > 32 + 3 * 32, "{} maps", first.shadow_tiles_drawn);
    let picture = radiance(&mut renderer, &scene, &request, 1);
    let second = render(&mut renderer, &scene, &request);
    assert_eq!((second.shadow_tiles_drawn, second.shadow_tiles_kept), (0, first.shadow_tiles_drawn));
    assert!(radiance(&mut renderer, &scene, &request, 1) == picture, "kept maps give another picture");
}

#[test]
fn a_frame_that_stands_for_itself_has_so_many_maps_and_a_still_has_all() {
    let scene = many_lights().finish();
    let request = request(&scene).with(|settings| settings.shadows.maps = 60);
    let mut renderer = shared();
    renderer.load(&scene).unwrap();
    let live = render(&mut renderer, &scene, &request);
    assert!((50..=60).contains(&live.shadow_tiles_drawn), "{} maps", live.shadow_tiles_drawn);
    assert_eq!(live.shadowed_lights + live.lights_beyond_atlas, 64);
    assert_eq!(renderer.lights_without_shadows().len(), live.lights_beyond_atlas as usize);
    let light_rounds = renderer.light_rounds(&scene, &request).unwrap();
    let still = render(&mut renderer, &scene, &FrameRequest { light_rounds, ..request });
    assert_eq!((still.shadowed_lights, still.lights_beyond_atlas), (64, 0));
}

#[test]
fn lights_that_are_seen_too_small_have_no_maps() {
    let scene = many_lights().finish();
    let all = request(&scene);
    let mut renderer = shared();
    renderer.load(&scene).unwrap();
    let shadowed = |renderer: &mut Renderer, min_px: f32| {
        let stats = render(renderer, &scene, &all.with(|settings| settings.shadows.min_px = min_px));
        // They are not counted among those for which there was no room.
        assert_eq!(stats.lights_beyond_atlas, 0, "{min_px}");
        stats.shadowed_lights
    };
    let counts = [0.0, 1.0, 16.0, 40.0, 60.0, 16384.0].map(|min_px| shadowed(&mut renderer, min_px));
    assert_eq!((counts[0], counts[1], counts[5]), (64, 64, 0), "{counts:?}");
    assert!(counts.is_sorted_by(|a, b| a >= b) && counts.iter().any(|count| (1..64).contains(count)), "{counts:?}");
}

#[test]
fn a_turning_camera_draws_no_map_of_local_lights_again() {
    let scene = many_lights().finish();
    let request = request(&scene).with(|settings| settings.shadows.atlas_px = 4096);
    let mut renderer = shared();
    renderer.load(&scene).unwrap();
    let mut turn = |step: i32| {
        let camera = View {
            world_from_view: request.camera.world_from_view * glam::Mat4::from_rotation_y(0.04 * step as f32),
            ..request.camera
        };
        render(&mut renderer, &scene, &FrameRequest { camera, ..request.clone() })
    };
    // There and back again: on the way back every map has been drawn.
    let there: Vec<_> = (0..20).map(&mut turn).collect();
    let back: Vec<_> = (0..20).rev().map(&mut turn).collect();
    let counts = |frames: &[FrameStats]| -> Vec<(u32, u32)> {
        frames.iter().map(|stats| (stats.shadow_tiles_drawn, stats.shadow_tiles_kept)).collect()
    };
    println!("{:?} {:?}", counts(&there), counts(&back));
    assert!(back.iter().all(|stats| stats.shadow_tiles_drawn == 0), "{:?}", counts(&back));
    assert!(back.last().unwrap().shadow_tiles_kept > 100, "{:?}", counts(&back));
    assert!(there.iter().map(|stats| stats.shadow_tiles_drawn).sum::<u32>() > 100);
}

#[test]
fn a_caster_that_moves_redraws_the_maps_that_it_is_in() {
    let mut builder = SceneBuilder::new(Vec3::new(0.0, 8.0, 10.0), Vec3::ZERO, perspective());
    builder.put(primitives::plane(20.0), grey(0.5), at(Vec3::ZERO));
    let mut boxes: Vec<NodeId> = Vec::new();
    for i in 0..8_u8 {
        let place = Vec3::new(1.5 * (f32::from(i) - 3.5), 0.0, 0.0);
        boxes.push(builder.put(primitives::cube(Vec3::splat(0.4)), grey(0.5), at(place + Vec3::Y * 0.2)));
        let narrow = LightKind::Spot { inner_cone_rad: 0.2, outer_cone_rad: 0.3 };
        builder.light(Light { range_m: Some(3.0), ..light(narrow, 10.0) }, place + Vec3::Y * 2.0, Vec3::NEG_Y);
    }
    let mut scene = builder.finish();
    let request = request(&scene);
    let mut renderer = shared();
    renderer.load(&scene).unwrap();
    let before = radiance(&mut renderer, &scene, &request, 1);
    scene.node_mut(boxes[3]).translation.x += 0.1;
    scene.update_transforms();
    let stats = render(&mut renderer, &scene, &request);
    assert_eq!((stats.shadow_tiles_drawn, stats.shadow_tiles_kept), (1, 7));
    let after = radiance(&mut renderer, &scene, &request, 1);
    assert!(after != before, "nothing moved");
    renderer.load(&scene).unwrap();
    assert!(radiance(&mut renderer, &scene, &request, 1) == after, "the picture is not that of the moved scene");
}

#[test]
fn lights_beyond_the_atlas_are_counted_or_take_turns() {
    let mut builder = SceneBuilder::new(Vec3::new(0.0, 5.0, 9.0), Vec3::ZERO, perspective());
    builder.put(primitives::plane(10.0), grey(0.5), at(Vec3::ZERO));
    for i in 0..300_u16 {
        let place = Vec3::new(f32::from(i % 20) * 0.4 - 4.0, 1.0, f32::from(i / 20) * 0.4 - 3.0);
        builder.light(Light { range_m: Some(2.0), ..light(SPOT, 0.1) }, place, Vec3::NEG_Y);
    }
    let scene = builder.finish();
    // 16 times 16 of the smallest maps.
    let request = request(&scene).with(|settings| settings.shadows.atlas_px = 256);
    let mut renderer = shared();
    renderer.load(&scene).unwrap();
    let stats = render(&mut renderer, &scene, &request);
    assert_eq!((stats.shadowed_lights, stats.lights_beyond_atlas, stats.lights_dealt), (256, 44, 0));
    let sample_count = renderer.light_rounds(&scene, &request).unwrap().unwrap_or(1);
    assert!(sample_count > 1, "{sample_count} rounds");
    let light_rounds = Some(sample_count);
    let stats = render(&mut renderer, &scene, &FrameRequest { light_rounds, sample_count, ..request });
    assert_eq!(stats.lights_beyond_atlas, 0);
    assert!(stats.lights_dealt > 44, "{} lights take turns", stats.lights_dealt);
}

#[test]
fn ten_thousand_shadowed_lights_shine() {
    // More than 65,536 lights and maps. The wall behind them is in five faces of the cube around each, and keeps no
    // light off.
    let mut builder = SceneBuilder::new(Vec3::new(0.0, 0.0, 9.0), Vec3::ZERO, perspective());
    let turned = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    builder.put(primitives::plane(10.0), grey(0.5), manypass_scene::Node { rotation: turned, ..at(Vec3::ZERO) });
    for i in 0..10_000_u16 {
        let place = Vec3::new(f32::from(i % 100) * 0.06 - 3.0, f32::from(i / 100) * 0.06 - 3.0, 0.1);
        builder.light(Light { range_m: Some(0.3), ..light(LightKind::Point, 0.01) }, place, Vec3::NEG_Y);
    }
    let scene = builder.finish();
    let request = request(&scene).with(|settings| settings.shadows.atlas_px = 4096);
    let mut renderer = shared();
    renderer.load(&scene).unwrap();
    let total = |pixels: &[[f32; 3]]| pixels.iter().flatten().map(|v| f64::from(*v)).sum::<f64>();
    let lit = total(&radiance(&mut renderer, &scene, &common::shadows::unshadowed(&request), 1));
    let shadowed = total(&radiance(&mut renderer, &scene, &request, 1));
    let stats = renderer.stats();
    assert_eq!((stats.shadowed_lights, stats.shadow_tiles_drawn + stats.shadow_tiles_kept), (10_000, 50_000));
    assert!((shadowed / lit - 1.0).abs() < 1e-4, "{shadowed} of {lit}");
}

#[test]
fn the_atlas_is_as_large_as_its_lights_want() {
    let mut builder = SceneBuilder::new(Vec3::new(0.0, 5.0, 9.0), Vec3::ZERO, perspective());
    builder.put(primitives::plane(10.0), grey(0.5), at(Vec3::ZERO));
    builder.put(primitives::cube(Vec3::ONE), grey(0.5), at(Vec3::Y));
    builder.light(light(LightKind::Directional, 1.0), Vec3::ZERO, Vec3::new(0.4, -1.0, 0.2));
    let one = builder.finish();
    let many = many_lights().finish();
    let request = request(&one).with(|settings| settings.shadows.cascades = 1);
    let drawn = |renderer: &mut Renderer, scene: &Scene| {
        renderer.load(scene).unwrap();
        let picture = radiance(renderer, scene, &request, 1);
        (picture, render(renderer, scene, &request).texture_bytes_of_shadows)
    };
    let mut renderer_of_all = renderer();
    let (picture_of_one, of_one) = drawn(&mut renderer_of_all, &one);
    // A map of a light from far away has twice the texels of the picture's longer side.
    let side = 2 * u64::from(request.width.max(request.height)).next_power_of_two();
    assert_eq!(of_one, 4 * side * side, "one map of {side}² texels");
    let (picture_of_many, of_many) = drawn(&mut renderer_of_all, &many);
    assert!(of_many > of_one, "{of_many} bytes for 64 lights");
    assert!(picture_of_many == drawn(&mut renderer(), &many).0, "an atlas that has grown gives another picture");
    let (picture, bytes) = drawn(&mut renderer_of_all, &one);
    assert_eq!(bytes, of_many, "what is there is used again");
    // Places in a larger texture are rounded otherwise, by which edges of shadows differ a little.
    let differs = |(a, b): &(&[f32; 3], &[f32; 3])| (a[0] - b[0]).abs() > 0.01 * b[0].max(0.01);
    let differing = picture.iter().zip(&picture_of_one).filter(differs).count();
    println!("{differing} of {} pixels differ", picture.len());
    assert!(100 * differing < picture.len(), "a larger atlas gives another picture: {differing} pixels");
}

/// By how much the values lie off a straight line through them, root mean square.
fn off_line(values: &[f32]) -> f32 {
    let count = values.len() as f32;
    let mean = values.iter().sum::<f32>() / count;
    let places = || values.iter().enumerate().map(|(at, value)| (at as f32 - 0.5 * (count - 1.0), value - mean));
    let slope = places().map(|(at, value)| at * value).sum::<f32>() / places().map(|(at, _)| at * at).sum::<f32>();
    (places().map(|(at, value)| (value - slope * at).powi(2)).sum::<f32>() / count).sqrt()
}

/// By how many pixels the edge of a box's shadow lies off a straight line, in the mean of so many samples. Seen from
/// above it runs down the picture, and crosses the rows of the lamp's map at a small angle.
fn edge_off_line_px(samples: u32) -> f32 {
    let projection = Projection::Orthographic { height_m: 1.2, near_m: 0.1, far_m: 100.0 };
    let mut builder = SceneBuilder::new(Vec3::new(0.0, 5.0, 0.5), Vec3::ZERO, projection);
    builder.put(primitives::plane(8.0), grey(0.5), at(Vec3::ZERO));
    let turned = Node { rotation: Quat::from_rotation_y(0.1), ..at(Vec3::new(-0.6, 0.3, 0.0)) };
    builder.put(primitives::cube(Vec3::new(1.0, 0.6, 3.0)), grey(0.5), turned);
    builder.light(light(SPOT, 30.0), Vec3::new(-0.9, 3.0, 0.0), Vec3::NEG_Y);
    let scene = builder.finish();
    let share = shares(&scene, &request(&scene), samples);
    // From where it is dark in all rows to where it is lit in all.
    let lit_px = |y: usize| (78..115).map(|x| share[y * SIZE.0 as usize + x].unwrap_or(1.0).min(1.0)).sum::<f32>();
    let lit: Vec<f32> = (10..SIZE.1 as usize - 10).map(lit_px).collect();
    assert!(lit.iter().all(|lit| (12.0..35.0).contains(lit)), "nothing to look at: {lit:?}");
    off_line(&lit)
}

#[test]
fn a_lone_lamp_has_the_room_of_the_atlas() {
    // Teeth of a map half as fine as the atlas has room for: 0.46 of a pixel.
    let off = edge_off_line_px(1);
    assert!(off < 0.33, "{off} of a pixel");
}

#[test]
fn edges_of_shadows_of_few_lamps_are_straight_in_stills() {
    let (one, still) = (edge_off_line_px(1), edge_off_line_px(16));
    println!("{one} of a pixel off a line, {still} in the mean of 16 samples");
    assert!(still < 0.25 * one, "{still} of a pixel, {one} in one sample");
}
