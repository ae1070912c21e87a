//! Fisheye pictures against the closed forms of their maps, and against pictures with perspective.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{plain_request, renderer};
use glam::{Mat3, Quat, Vec2, Vec3};
use manypass::{Aov, Averaging, Background, Fisheye, FisheyeFrame, FrameRequest, LightCulling, RenderError, Renderer};
use manypass::{WgslEffect, effect::Effect};
use manypass_scene::{Light, Material, Projection, Scene, primitives};
use manypass_testkit::build::{SceneBuilder, at, grey};
use std::f32::consts::{PI, TAU};
use std::sync::Arc;

const EYE: Vec3 = Vec3::new(3.0, -2.0, 5.0);
const AHEAD: Vec3 = Vec3::new(-0.48, 0.36, 0.8);
const CAMERA: Projection = Projection::Perspective { fov_y_rad: 0.7, near_m: 0.1, far_m: None };
const MAPS: [Fisheye; 3] = [Fisheye::Equidistant, Fisheye::Equisolid, Fisheye::Stereographic];

fn request(scene: &Scene, size: (u32, u32), map: Fisheye, fov_deg: f32) -> FrameRequest {
    plain_request(scene, size).with(|settings| {
        (settings.camera.fisheye, settings.camera.fisheye_fov_deg) = (map, fov_deg);
        settings.background.source = Background::Transparent;
    })
}

fn draw(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) {
    for sample_index in 0..request.sample_count {
        let request = FrameRequest { sample_index, ..request.clone() };
        if sample_index + 1 < request.sample_count {
            renderer.accumulate(scene, &request).unwrap();
        } else {
            renderer.render(scene, &request).unwrap();
        }
    }
}

/// Mean radiance with alpha, and the picture.
fn still(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> (Vec<[f32; 4]>, Vec<u8>) {
    draw(renderer, scene, request);
    let radiance = renderer.read_radiance().unwrap();
    let pixels = radiance.chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect();
    (pixels, renderer.read_display().unwrap())
}

/// How far from the middle a map shows an angle, the rim being 1.
fn distance(map: Fisheye, angle_rad: f32, half_rad: f32) -> f32 {
    match map {
        Fisheye::None => f32::NAN,
        Fisheye::Equidistant => angle_rad / half_rad,
        Fisheye::Equisolid => (0.5 * angle_rad).sin() / (0.5 * half_rad).sin(),
        Fisheye::Stereographic => (0.5 * angle_rad).tan() / (0.5 * half_rad).tan(),
    }
}

/// The angle that a map shows at a distance from the middle.
fn angle(map: Fisheye, distance: f32, half_rad: f32) -> f32 {
    match map {
        Fisheye::None => f32::NAN,
        Fisheye::Equidistant => distance * half_rad,
        Fisheye::Equisolid => 2.0 * (distance * (0.5 * half_rad).sin()).asin(),
        Fisheye::Stereographic => 2.0 * (distance * (0.5 * half_rad).tan()).atan(),
    }
}

/// A direction in world space at an angle from the axis, and around it from the right, upwards.
fn direction(scene: &Scene, angle_rad: f32, around_rad: f32) -> Vec3 {
    let axes = Mat3::from_mat4(scene.nodes[0].world_from_object);
    axes * (Vec2::from_angle(around_rad) * angle_rad.sin()).extend(-angle_rad.cos())
}

#[test]
fn circles_of_latitude_lie_where_the_maps_say() {
    let (size, mut renderer) = ((402u32, 301u32), renderer());
    let half_rad = 105f32.to_radians();
    let empty = SceneBuilder::new(EYE, EYE + AHEAD, CAMERA).finish();
    // Along the axes, along corners of the cube, and between.
    let places: Vec<(f32, f32)> = [(12.0f32, 4), (38.0, 8), (46.5, 8), (70.0, 12), (88.0, 12), (101.0, 16)]
        .into_iter()
        .flat_map(|(deg, count)| (0..count).map(move |at| (deg, TAU * at as f32 / count as f32 + 0.1 * deg % 0.4)))
        .map(|(deg, around_rad)| (deg.to_radians(), around_rad))
        .collect();
    let mut builder = SceneBuilder::new(EYE, EYE + AHEAD, CAMERA);
    for (angle_rad, around_rad) in &places {
        let material = Material { emissive_factor: Vec3::splat(4.0), ..grey(0.0) };
        let place = EYE + 20.0 * direction(&empty, *angle_rad, *around_rad);
        builder.put(primitives::uv_sphere(0.4, 12, 8), material, at(place));
    }
    let scene = builder.finish();
    renderer.load(&scene).unwrap();
    for map in MAPS {
        let of_map = FrameRequest { sample_count: 16, ..request(&scene, size, map, 210.0) };
        let (pixels, _) = still(&mut renderer, &scene, &of_map);
        let (mut worst, mut found_light) = (0.0f32, 0.0);
        for (angle_rad, around_rad) in &places {
            let radius_px = 0.5 * size.1 as f32 * distance(map, *angle_rad, half_rad);
            let expected =
                Vec2::new(0.5 * size.0 as f32, 0.5 * size.1 as f32) + Vec2::from_angle(-around_rad) * radius_px;
            let (mut sum, mut light) = (Vec2::ZERO, 0.0);
            for (index, pixel) in pixels.iter().enumerate() {
                let place = Vec2::new((index as u32 % size.0) as f32, (index as u32 / size.0) as f32) + 0.5;
                if place.distance(expected) < 6.0 {
                    sum += place * pixel[0];
                    light += pixel[0];
                }
            }
            assert!(light > 2.0, "{map:?} {} deg: nothing at {expected}", angle_rad.to_degrees());
            worst = worst.max((sum / light).distance(expected));
            found_light += light;
        }
        let all_light: f32 = pixels.iter().map(|pixel| pixel[0]).sum();
        println!("{map:?}: off by {worst:.3} px at most, {found_light:.0} of {all_light:.0}");
        assert!(worst < 0.25, "{map:?}: {worst}");
        assert!(found_light > 0.999 * all_light, "{map:?}: {found_light} of {all_light}");
    }
}

/// A room without edges that are seen, under lights with ranges and shadows.
fn room() -> Scene {
    let mut builder = SceneBuilder::new(EYE, EYE + AHEAD, CAMERA);
    let wall = Material { double_sided: true, ..grey(0.6) };
    builder.put(primitives::uv_sphere(9.0, 96, 64), wall, at(EYE));
    for at in 0..40 {
        let around = Quat::from_rotation_y(2.4 * at as f32) * Quat::from_rotation_x(1.1 * at as f32);
        let color_linear = Vec3::new(1.0, 0.4 + 0.015 * at as f32, 1.0 - 0.02 * at as f32);
        let light = Light { color_linear, intensity: 30.0, range_m: Some(7.0), ..Light::default() };
        builder.light(light, EYE + around * Vec3::new(0.0, 0.0, 5.5), Vec3::NEG_Y);
    }
    builder.finish()
}

#[test]
fn borders_between_views_do_not_show() {
    let (scene, mut renderer) = (room(), renderer());
    renderer.load(&scene).unwrap();
    let (size, half_rad) = (240u32, 110f32.to_radians());
    for (map, culling) in
        [(Fisheye::Equidistant, LightCulling::Clustered), (Fisheye::Stereographic, LightCulling::Volumes)]
    {
        let of_fisheye = request(&scene, (size, size), map, 220.0).with(|settings| settings.lights.culling = culling);
        let (picture, _) = still(&mut renderer, &scene, &of_fisheye);
        // Through the middle of borders and through a corner of the cube, and two views without any.
        for (yaw_deg, pitch_deg) in
            [(45.0f32, 0.0f32), (-45.0, 8.0), (10.0, 45.0), (0.0, -45.0), (45.0, -35.3), (-45.0, 35.3)]
        {
            const SIDE: u32 = 160;
            let fov_y_rad = 0.9f32;
            let rotation = Quat::from_rotation_y(-yaw_deg.to_radians()) * Quat::from_rotation_x(pitch_deg.to_radians());
            let mut flat = plain_request(&scene, (SIDE, SIDE)).with(|settings| settings.lights.culling = culling);
            flat.camera.world_from_view *= glam::Mat4::from_quat(rotation);
            flat.camera.projection = Projection::Perspective { fov_y_rad, near_m: 0.1, far_m: None };
            let (expected, _) = still(&mut renderer, &scene, &flat);
            let (mut compared, mut worst) = (0, 0.0f32);
            for (index, found) in picture.iter().enumerate() {
                let place = Vec2::new((index as u32 % size) as f32 + 0.5, (index as u32 / size) as f32 + 0.5);
                let across = (place / (0.5 * size as f32) - 1.0) * Vec2::new(1.0, -1.0);
                if across.length() > 0.99 {
                    continue;
                }
                let angle_rad = angle(map, across.length(), half_rad);
                let direction = (across.normalize_or_zero() * angle_rad.sin()).extend(-angle_rad.cos());
                let seen = rotation.inverse() * direction;
                let slope = seen.truncate() / (-seen.z * (0.5 * fov_y_rad).tan());
                if seen.z > -0.1 || slope.abs().max_element() > 0.97 {
                    continue;
                }
                let at = (slope * Vec2::new(0.5, -0.5) + 0.5) * SIDE as f32 - 0.5;
                let (low, between) = (at.floor(), at - at.floor());
                let texel = |x: u32, y: u32| expected[((low.y as u32 + y) * SIDE + low.x as u32 + x) as usize];
                for (channel, found) in found.iter().take(3).enumerate() {
                    let row = |y| texel(0, y)[channel] * (1.0 - between.x) + texel(1, y)[channel] * between.x;
                    let expected = row(0) * (1.0 - between.y) + row(1) * between.y;
                    worst = worst.max((found - expected).abs() / (expected + 0.02));
                }
                assert!((found[3] - 1.0).abs() < 1e-3, "a hole at {place}: {}", found[3]);
                compared += 1;
            }
            println!("{map:?} {yaw_deg} {pitch_deg}: {compared} pixels, off by {:.2} % at most", 100.0 * worst);
            assert!(compared > 800, "{compared}");
            assert!(worst < 0.03, "{map:?} {yaw_deg} {pitch_deg}: {worst}");
        }
    }
}

/// A ball that glows around the axis; of half an angle.
fn disc(half_rad: f32) -> Scene {
    let mut builder = SceneBuilder::new(EYE, EYE + AHEAD, CAMERA);
    let material = Material { emissive_factor: Vec3::ONE, ..grey(0.0) };
    builder.put(primitives::uv_sphere(10.0 * half_rad.sin(), 256, 128), material, at(EYE + 10.0 * AHEAD));
    builder.finish()
}

#[test]
fn samples_smooth_edges_and_the_same_is_drawn_again() {
    let (scene, mut renderer) = (disc(0.6), renderer());
    renderer.load(&scene).unwrap();
    let (size, fov_deg) = ((121u32, 121u32), 190.0f32);
    let radius_px = 60.5 * 0.6 / (0.5 * fov_deg.to_radians());
    let of = |sample_count| FrameRequest { sample_count, ..request(&scene, size, Fisheye::Equidistant, fov_deg) };
    let mut edge_errors = Vec::new();
    for (sample_count, error_max) in [(1, 0.02), (16, 0.006)] {
        let (pixels, display) = still(&mut renderer, &scene, &of(sample_count));
        let (again, display_again) = still(&mut renderer, &scene, &of(sample_count));
        assert!(pixels == again && display == display_again, "the same again");
        let area: f32 = pixels.iter().map(|pixel| pixel[0]).sum();
        let expected = PI * radius_px * radius_px;
        println!("{sample_count} samples: {area:.1} of {expected:.1} pixels");
        assert!((area / expected - 1.0).abs() < error_max, "{area} {expected}");
        // How much of each pixel is within the circle, by 8 × 8 points.
        let mut errors = [0.0f32; 2];
        for (index, pixel) in pixels.iter().enumerate() {
            let corner = Vec2::new((index as u32 % size.0) as f32, (index as u32 / size.0) as f32) - 60.5;
            let points = (0..64).map(|at| corner + (Vec2::new((at % 8) as f32, (at / 8) as f32) + 0.5) / 8.0);
            let covered = points.filter(|point| point.length() < radius_px).count() as f32 / 64.0;
            let error = (pixel[0] - covered).abs();
            errors = [errors[0] + error / (TAU * radius_px), errors[1].max(error)];
        }
        edge_errors.push(errors);
    }
    println!("error of the edge, mean and largest: {edge_errors:.3?}");
    assert!(edge_errors[1][0] < 0.11 && edge_errors[1][1] < 0.2, "{edge_errors:?}");
    assert!(edge_errors[1][1] < 0.8 * edge_errors[0][1], "{edge_errors:?}");
}

#[test]
fn any_size_and_angle_is_drawn_and_nothing_outside_of_the_circle() {
    let (scene, mut renderer) = (room(), renderer());
    renderer.load(&scene).unwrap();
    for (size, fov_deg) in
        [((1, 1), 180.0), ((1, 1), 1.0), ((1, 37), 220.0), ((1, 4096), 220.0), ((57, 23), 220.0), ((40, 41), 1.0)]
    {
        for map in MAPS {
            let of_fisheye = request(&scene, size, map, fov_deg);
            let (pixels, display) = still(&mut renderer, &scene, &of_fisheye);
            let middle = Vec2::new(0.5 * size.0 as f32, 0.5 * size.1 as f32);
            for (index, pixel) in pixels.iter().enumerate() {
                let place = Vec2::new((index as u32 % size.0) as f32, (index as u32 / size.0) as f32) + 0.5;
                let distance = place.distance(middle) / middle.min_element();
                let is_inside = (distance + 0.75 / middle.min_element()) < 1.0;
                let is_outside = (distance - 0.75 / middle.min_element()) > 1.0;
                assert!(pixel.iter().all(|value| value.is_finite()), "{size:?} {fov_deg} {pixel:?}");
                assert!(!is_inside || pixel[3] > 0.999 && pixel[0] > 0.0, "{size:?} {fov_deg} {place}: {pixel:?}");
                assert!(!is_outside || *pixel == [0.0; 4], "{size:?} {fov_deg} {place}: {pixel:?}");
                assert!(!is_outside || display[4 * index + 3] == 0);
            }
            let full = of_fisheye.with(|settings| settings.camera.fisheye_frame = FisheyeFrame::Full);
            let (pixels, _) = still(&mut renderer, &scene, &full);
            let holes = pixels.iter().filter(|pixel| pixel[3] < 0.7).count();
            assert_eq!(holes, 0, "{size:?} {fov_deg}: a full frame has no holes");
        }
    }
    for (key, value) in [
        ("camera.fisheye_fov_deg", "0.5"),
        ("camera.fisheye_fov_deg", "221"),
        ("camera.fisheye_fov_deg", "NaN"),
        ("camera.fisheye", "orthographic"),
    ] {
        let mut settings = request(&scene, (8, 8), MAPS[0], 180.0).settings;
        assert!(settings.set(key, value).is_err(), "{key} {value}");
    }
}

#[test]
fn what_a_fisheye_does_without_is_refused() {
    let (mut scene, mut renderer) = (room(), renderer());
    renderer.load(&scene).unwrap();
    let plain = request(&scene, (16, 16), Fisheye::Equisolid, 180.0);
    for (key, value) in [
        ("occlusion.enabled", "true"),
        ("reflections.enabled", "true"),
        ("camera.f_stop", "2"),
        ("debug.view", "lights"),
    ] {
        let refused = plain.with(|settings| settings.set(key, value).unwrap());
        let refused = renderer.render(&scene, &refused).unwrap_err().to_string();
        assert!(refused.contains("camera.fisheye=equisolid") && refused.contains(key), "{refused}");
    }
    let variables = FrameRequest { want_aovs: vec![Aov::Depth], ..plain.clone() };
    let refused = renderer.render(&scene, &variables).unwrap_err();
    assert!(matches!(refused, RenderError::Fisheye(_)) && refused.to_string().contains("no variables"), "{refused}");
    let reads_normal = "//! effect shown\n\
        @fragment fn fs_shown(@builtin(position) p: vec4f) -> @location(0) vec4f {\n\
        return vec4f(vec2f(textureLoad(normal, vec2i(p.xy), 0).rg), 0.0, 1.0); }\n";
    let effect = Arc::new(WgslEffect::new(renderer.gpu(), "shown.wgsl", reads_normal).unwrap());
    let with_effect = FrameRequest { effects: vec![effect as Arc<dyn Effect>], ..plain.clone() };
    let refused = renderer.render(&scene, &with_effect).unwrap_err().to_string();
    assert!(refused.contains("`normal`") && refused.contains("camera.fisheye=none"), "{refused}");
    scene.cameras[0].projection = Projection::Orthographic { height_m: 2.0, near_m: 0.1, far_m: 9.0 };
    let parallel = request(&scene, (16, 16), Fisheye::Equisolid, 180.0);
    let refused = renderer.render(&scene, &parallel).unwrap_err();
    assert!(refused.to_string().contains("parallel rays"), "{refused}");
    // Nothing of it is left behind.
    draw(&mut renderer, &scene, &plain);
}

#[test]
fn effects_see_the_whole_picture_and_one_exposure_does_for_all_views() {
    let (scene, mut renderer) = (room(), renderer());
    renderer.load(&scene).unwrap();
    // What lies 20 pixels to the right, which is in another view along borders.
    let shifts = "//! effect shifted\n\
        @fragment fn fs_shifted(@builtin(position) p: vec4f) -> @location(0) vec4f {\n\
        return radiance_at(vec2i(p.xy) + vec2i(20, 0)); }\n";
    let effect = Arc::new(WgslEffect::new(renderer.gpu(), "shifted.wgsl", shifts).unwrap());
    let plain = request(&scene, (90, 90), Fisheye::Equidistant, 200.0);
    let (without, _) = still(&mut renderer, &scene, &plain);
    let (with, _) = still(&mut renderer, &scene, &FrameRequest { effects: vec![effect], ..plain.clone() });
    let is_moved = |index: usize| with[index] == without[index + 20];
    assert!((0..90).all(|y| (0..70).all(|x| is_moved(90 * y + x))));
    // Metered: what is around, not only what is ahead; and as a plan it has the views that it needs.
    let metered = renderer.meter(&scene, &plain).unwrap();
    assert!((metered.surface_share - 0.785).abs() < 0.02, "the circle of a square: {}", metered.surface_share);
    let names = |request: &FrameRequest, renderer: &mut Renderer| -> Vec<String> {
        let plan = renderer.plan(&scene, request).unwrap();
        plan.passes.iter().map(|pass| pass.name.to_string()).filter(|name| name.ends_with("geometry")).collect()
    };
    let all = ["front", "right", "left", "up", "down"].map(|side| format!("fisheye/{side}/geometry"));
    assert_eq!(names(&plain, &mut renderer), all);
    let narrow = request(&scene, (90, 90), Fisheye::Equidistant, 60.0);
    assert_eq!(names(&narrow, &mut renderer), all[..1]);
    // Wide pictures that the circle fills see less of what is above.
    let mut wide = request(&scene, (160, 60), Fisheye::Equidistant, 180.0);
    wide.settings.camera.fisheye_frame = FisheyeFrame::Full;
    assert_eq!(names(&wide, &mut renderer), all[..3]);
    let info = renderer.fisheye(&wide).unwrap();
    assert!(info.views.len() == 3 && info.ray_px <= 1.5 && info.ray_px > 1.0, "{info:?}");
    // Pairs are counted in all views.
    let pairs = renderer.count_pairs(&scene, &plain).unwrap();
    assert!(pairs.pairs_shaded > 0 && pairs.pairs_visited >= pairs.pairs_shaded, "{pairs:?}");
    let averaging = Averaging::Display;
    draw(&mut renderer, &scene, &FrameRequest { averaging, sample_count: 8, ..plain });
    assert_eq!(renderer.read_samples_mean().unwrap(), 8.0);
}
