//! Shadows of the picture where maps miss them: gaps against the ray caster, surfaces that they have to leave alone, and
//! values that nobody means.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common;
use crate::common::shadows::{SIZE, SPOT, light, perspective, radiance, shared, surfaces, unshadowed, world_of};
use crate::common::{floats, inner_pixels};
use glam::{DVec3, Quat, Vec3};
use manypass::{Aov, Averaging, FrameRequest, LightCulling, Path, Renderer};
use manypass_scene::{
    Image, ImageSource, Light, LightKind, Material, Node, PixelFormat, Pixels, Projection, Sampler, Scene, Texture,
    TextureRef, primitives,
};
use manypass_testkit::build::{SceneBuilder, at, grey};
use manypass_testkit::raycast::{Options, World};

/// With shadow maps as coarse and as far from what casts as they can be, and a search of the picture `contact_m` far.
fn request(scene: &Scene, contact_m: f32) -> FrameRequest {
    common::shadows::request(scene).with(|settings| {
        settings.shadows.atlas_px = 256;
        settings.shadows.bias_texels = 16.0;
        settings.shadows.contact_m = contact_m;
        settings.shadows.contact_steps = 16;
    })
}

fn load(renderer: &mut Renderer, scene: &Scene) {
    renderer.unload();
    renderer.load(scene).unwrap();
}

/// Of each pixel the share of its light that is left; none where there is none.
fn shares(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest, samples: u32) -> Vec<Option<f32>> {
    let lit = radiance(renderer, scene, &unshadowed(request), samples);
    let found = radiance(renderer, scene, request, samples);
    lit.iter().zip(&found).map(|(lit, found)| (lit[1] > 1e-4).then(|| found[1] / lit[1])).collect()
}

/// Small boxes on a floor, and some that hover so low that maps miss the gap.
fn boxes(lamp: Light, place: Vec3) -> Scene {
    let mut builder = SceneBuilder::new(Vec3::new(0.2, 1.3, 1.9), Vec3::new(0.0, 0.0, 0.0), perspective());
    builder.put(primitives::plane(8.0), grey(0.5), at(Vec3::ZERO));
    for i in 0..9u8 {
        let [x, z] = [i % 3, i / 3].map(|n| 0.55 * f32::from(n) - 0.55);
        let turned = Quat::from_rotation_y(0.4 * f32::from(i));
        let height_m = 0.06 + 0.02 * f32::from(i % 2);
        let gap_m = 0.02 * f32::from(i % 3);
        let node = Node { rotation: turned, ..at(Vec3::new(x, gap_m + 0.5 * height_m, z)) };
        builder.put(primitives::cube(Vec3::new(0.2, height_m, 0.12)), grey(0.5), node);
    }
    builder.light(lamp, place, -place);
    builder.finish()
}

/// Of the floor's pixels, how many are lit where the ray caster has shadow (leaks), and how many are dark where it has
/// none (false), beside how many it has of both.
#[derive(Debug, Default)]
struct WrongPixels {
    shadowed: usize,
    leaks: usize,
    lit: usize,
    dark: usize,
}

fn compare(world: &World, found: &[Option<f32>]) -> WrongPixels {
    let frame = surfaces(world);
    let hard = Options { light_samples_per_axis: 0, ..Options::default() };
    let is_lit = |position: DVec3| world.visibility_at(0, position, hard) > 0.5;
    let mut wrong = WrongPixels::default();
    for pixel in inner_pixels(&frame.object_id, (frame.width, frame.height)) {
        let position = frame.position_world[pixel];
        let Some(share) = found[pixel] else { continue };
        if frame.object_id[pixel] != 2 {
            continue;
        }
        // A pixel's width away from the edge.
        let around = [DVec3::X, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]);
        let expected = is_lit(position);
        if around.into_iter().any(|step| is_lit(position + 0.02 * step) != expected) {
            continue;
        }
        if expected {
            wrong.lit += 1;
            wrong.dark += usize::from(share < 0.5);
        } else {
            wrong.shadowed += 1;
            wrong.leaks += usize::from(share > 0.5);
        }
    }
    wrong
}

#[test]
fn gaps_that_maps_miss_are_dark() {
    let mut renderer = shared();
    for (name, lamp, place) in [
        ("from behind", light(LightKind::Directional, 3.0), Vec3::new(-1.0, 1.1, -1.2)),
        ("from the side", light(LightKind::Directional, 3.0), Vec3::new(-1.6, 1.2, 0.2)),
        ("spot", light(SPOT, 30.0), Vec3::new(-1.6, 1.8, -1.2)),
        ("point", light(LightKind::Point, 30.0), Vec3::new(-1.6, 1.8, -1.2)),
    ] {
        let scene = boxes(lamp, place);
        let world = world_of(&scene);
        load(&mut renderer, &scene);
        let without = compare(&world, &shares(&mut renderer, &scene, &request(&scene, 0.0), 16));
        let with = compare(&world, &shares(&mut renderer, &scene, &request(&scene, 0.3), 16));
        println!("{name}: {without:?} without, {with:?} with");
        assert!(without.shadowed > 150 && without.leaks * 2 > without.shadowed, "{name}: nothing to look at");
        assert!(with.leaks * 10 < with.shadowed && with.dark * 200 < with.lit, "{name}: {with:?}");
    }
}

/// The least and the greatest ratio of light with the search to that without it, and of how many pixels.
fn ratios(renderer: &mut Renderer, scene: &Scene, with: &FrameRequest, samples: u32) -> (f32, f32, usize) {
    load(renderer, scene);
    let without = radiance(renderer, scene, &with.with(|settings| settings.shadows.contact_m = 0.0), samples);
    let found = radiance(renderer, scene, with, samples);
    let lit = without.iter().zip(&found).filter(|(without, _)| without[1] > 1e-4);
    let all: Vec<f32> = lit.map(|(without, found)| found[1] / without[1]).collect();
    let of = |start: f32, choose: fn(f32, f32) -> f32| all.iter().copied().fold(start, choose);
    (of(f32::MAX, f32::min), of(0.0, f32::max), all.len())
}

#[test]
fn surfaces_do_not_shadow_themselves() {
    let mut renderer = shared();
    let parallel = Projection::Orthographic { height_m: 3.0, near_m: 0.1, far_m: 100.0 };
    for (eye, projection) in [
        (Vec3::new(0.0, 3.0, 5.0), perspective()),
        (Vec3::new(0.0, 0.1, 4.0), perspective()),
        (Vec3::new(0.3, 6.0, 0.1), perspective()),
        (Vec3::new(1.0, 0.3, 4.0), parallel),
    ] {
        for kind in [LightKind::Directional, LightKind::Point, SPOT] {
            for angle_deg in [1.0_f32, 4.0, 20.0, 70.0] {
                let mut builder = SceneBuilder::new(eye, Vec3::ZERO, projection);
                let rotation = Quat::from_rotation_y(0.4);
                builder.put(primitives::plane(20.0), grey(0.5), Node { rotation, ..at(Vec3::ZERO) });
                let (sin, cos) = angle_deg.to_radians().sin_cos();
                let to_light = Vec3::new(0.8 * cos, sin, 0.6 * cos);
                builder.light(light(kind, 100.0), 5.0 * to_light, -to_light);
                let scene = builder.finish();
                let (least, most, count) = ratios(&mut renderer, &scene, &request(&scene, 0.5), 2);
                println!("{kind:?} at {angle_deg}° from {eye}: {least} to {most} of {count} pixels");
                assert!(count > 200 && least == 1.0 && most == 1.0, "{kind:?} at {angle_deg}° from {eye}: {least}");
            }
        }
    }
}

#[test]
fn a_plane_whose_map_bends_its_normals_does_not_shadow_itself() {
    let mut renderer = shared();
    for eye in [Vec3::new(0.0, 1.0, 3.0), Vec3::new(0.0, 0.2, 4.0)] {
        let mut builder = SceneBuilder::new(eye, Vec3::ZERO, perspective());
        let data = (0..64u32).flat_map(|i| [100 + (i * 37 % 56) as u8, 100 + (i * 53 % 56) as u8, 220, 255]).collect();
        let pixels = Pixels { width: 8, height: 8, format: PixelFormat::Rgba8, data };
        builder.scene.images.push(Image { name: String::new(), source: ImageSource::Pixels(pixels.into()) });
        builder.scene.textures.push(Texture { image: 0, sampler: Sampler::default() });
        let normal_texture = Some(TextureRef { texture: 0, uv_set: 0, transform: Default::default() });
        let plane = primitives::plane(6.0);
        builder.put(plane, Material { normal_texture, normal_scale: 2.0, ..grey(0.5) }, at(Vec3::ZERO));
        let down = Vec3::new(-0.7, -0.1, 0.7);
        builder.light(light(LightKind::Directional, 3.0), Vec3::ZERO, down);
        let scene = builder.finish();
        let (least, _, count) = ratios(&mut renderer, &scene, &request(&scene, 0.5), 4);
        println!("at least {least} of {count} pixels");
        assert!(count > 2000 && least > 0.99, "{least}");
    }
}

#[test]
fn balls_and_walls_beside_a_ray_stay_lit() {
    let mut renderer = shared();
    let lamp = || light(LightKind::Directional, 3.0);
    let of = |build: &dyn Fn(&mut SceneBuilder), eye: Vec3, down: Vec3| {
        let mut builder = SceneBuilder::new(eye, Vec3::ZERO, perspective());
        build(&mut builder);
        builder.light(lamp(), Vec3::ZERO, down);
        builder.finish()
    };
    let ball = |builder: &mut SceneBuilder| {
        builder.put(primitives::uv_sphere(1.0, 192, 96), grey(0.5), at(Vec3::ZERO));
    };
    // Rays along the wall at x = 0, which the eye sees from the side, do not meet it.
    let walls = |builder: &mut SceneBuilder| {
        builder.put(primitives::plane(20.0), grey(0.5), at(Vec3::ZERO));
        let rotation = Quat::from_rotation_z(-std::f32::consts::FRAC_PI_2);
        builder.put(primitives::plane(20.0), grey(0.5), Node { rotation, ..at(Vec3::ZERO) });
    };
    for (name, scene) in [
        ("ball", of(&ball, Vec3::new(0.5, 1.0, 3.0), Vec3::new(-0.8, -0.4, 0.2))),
        ("wall", of(&walls, Vec3::new(0.1, 1.0, 3.0), Vec3::new(-0.02, -0.5, 0.8))),
        ("wall, from before", of(&walls, Vec3::new(0.3, 0.5, 3.0), Vec3::new(-0.05, -0.5, -0.8))),
    ] {
        let (least, _, count) = ratios(&mut renderer, &scene, &request(&scene, 0.5), 8);
        println!("{name}: at least {least} of {count} pixels");
        assert!(count > 2000 && least > 0.99, "{name}: {least}");
    }
}

#[test]
fn what_lies_far_behind_and_at_the_end_of_a_ray_counts_less() {
    let mut renderer = shared();
    // A thin rod far above the floor, and before it in the picture.
    let mut builder = SceneBuilder::new(Vec3::new(0.0, 1.0, 3.0), Vec3::ZERO, perspective());
    builder.put(primitives::plane(8.0), grey(0.5), at(Vec3::ZERO));
    builder.put(primitives::cube(Vec3::new(2.0, 0.02, 0.02)), grey(0.5), at(Vec3::new(0.0, 0.3, 0.8)));
    let down = Vec3::new(0.0, -0.3, 1.0);
    builder.light(light(LightKind::Directional, 3.0), Vec3::ZERO, down);
    let scene = builder.finish();
    load(&mut renderer, &scene);
    let mean = |renderer: &mut Renderer, contact_m: f32, thickness_m: f32| {
        let request = request(&scene, contact_m).with(|settings| settings.shadows.contact_thickness_m = thickness_m);
        let found = radiance(renderer, &scene, &request, 16);
        found.iter().map(|pixel| f64::from(pixel[1])).sum::<f64>() / found.len() as f64
    };
    let open = mean(&mut renderer, 0.0, 0.0);
    let means = [0.02, 0.1, 1.0, 10.0].map(|thickness_m| mean(&mut renderer, 2.0, thickness_m) / open);
    println!("by thickness {means:?}");
    assert!(means[0] > 0.97 && means.is_sorted_by(|a, b| a >= b) && means[3] < means[0] - 0.02, "{means:?}");
    let means = [0.01, 0.2, 0.8, 3.0].map(|contact_m| mean(&mut renderer, contact_m, 0.1) / open);
    println!("by length {means:?}");
    assert!(means[0] > 0.99 && means[3] < means[0], "{means:?}");
}

#[test]
fn every_way_of_culling_gives_the_same_picture() {
    let mut renderer = shared();
    let mut scene = boxes(light(LightKind::Directional, 1.0), Vec3::new(-1.0, 1.1, -1.2));
    for (kind, x) in [(LightKind::Point, -1.0), (SPOT, 1.0)] {
        let mut lamp = light(kind, 6.0);
        lamp.range_m = Some(5.0);
        scene.lights.push(lamp);
        let rotation = manypass_testkit::build::rotation_along(Vec3::new(-x, -1.0, 0.0));
        let light = Some(scene.lights.len() - 1);
        scene.add_node(None, Node { translation: Vec3::new(x, 1.0, -0.6), rotation, light, ..Node::default() });
    }
    scene.update_transforms();
    load(&mut renderer, &scene);
    let of = |renderer: &mut Renderer, culling, contact_m| {
        let request = request(&scene, contact_m).with(|settings| settings.lights.culling = culling);
        radiance(renderer, &scene, &request, 1)
    };
    let clustered = of(&mut renderer, LightCulling::Clustered, 0.3);
    let without = of(&mut renderer, LightCulling::Clustered, 0.0);
    let apart = |a: &[[f32; 3]], b: &[[f32; 3]]| {
        let largest = a.iter().zip(b).map(|(a, b)| (a[1] - b[1]).abs() / b[1].max(0.1)).fold(0.0, f32::max);
        println!("{largest} apart");
        largest
    };
    assert!(apart(&clustered, &without) > 0.3, "there is something to look at");
    for culling in [LightCulling::None, LightCulling::Tiled, LightCulling::Volumes, LightCulling::VolumesStencil] {
        assert!(apart(&of(&mut renderer, culling, 0.3), &clustered) < 2e-3, "{culling:?}");
    }
}

#[test]
fn what_is_off_changes_nothing() {
    let mut renderer = shared();
    let scene = boxes(light(LightKind::Directional, 3.0), Vec3::new(-1.0, 1.1, -1.2));
    load(&mut renderer, &scene);
    let with = request(&scene, 0.3);
    let found = radiance(&mut renderer, &scene, &with, 1);
    let without = radiance(&mut renderer, &scene, &request(&scene, 0.0), 1);
    assert_ne!(found, without);
    let off = with.with(|settings| settings.effects.enabled = false);
    assert_eq!(radiance(&mut renderer, &scene, &off, 1), without, "without effects");
    let unlit = unshadowed(&with);
    let bare = unlit.with(|settings| settings.shadows.contact_m = 0.0);
    assert_eq!(
        radiance(&mut renderer, &scene, &unlit, 1),
        radiance(&mut renderer, &scene, &bare, 1),
        "without shadows"
    );
    // Lights that cast no shadows have none of these.
    let mut quiet = scene.clone();
    quiet.lights[0].casts_shadows = false;
    // One that does keeps the view one that has shadows.
    quiet.lights.push(Light { intensity: 0.0, ..light(LightKind::Point, 0.0) });
    let lamp = Some(quiet.lights.len() - 1);
    quiet.add_node(None, Node { light: lamp, ..at(Vec3::Y) });
    quiet.update_transforms();
    let (least, most, count) = ratios(&mut renderer, &quiet, &with, 1);
    assert!(count > 10_000 && least == 1.0 && most == 1.0, "{least} to {most} of {count}");
}

#[test]
fn extreme_values_give_finite_pictures() {
    let mut renderer = shared();
    let scene = boxes(light(LightKind::Directional, 3.0), Vec3::new(-1.0, 1.1, -1.2));
    load(&mut renderer, &scene);
    for (contact_m, thickness_m, steps) in
        [(1e-30, 0.0, 8), (1e6, 0.0, 64), (1e6, 1e6, 1), (0.1, 1e-30, 1), (1e6, 1e-30, 8), (f32::MIN_POSITIVE, 1e6, 1)]
    {
        let request = request(&scene, contact_m).with(|settings| {
            settings.shadows.contact_thickness_m = thickness_m;
            settings.shadows.contact_steps = steps;
        });
        for (width, height) in [SIZE, (1, 1), (1, 4096), (4096, 1)] {
            let request = FrameRequest { width, height, ..request.clone() };
            renderer.render(&scene, &request).unwrap();
            let found = renderer.read_radiance().unwrap();
            let bound = found.iter().all(|value| value.is_finite() && (0.0..100.0).contains(value));
            assert!(bound, "{contact_m} m, {thickness_m} m, {steps} steps, {width} × {height}");
        }
    }
    let mut settings = manypass::Settings::default();
    for (key, value) in [
        ("shadows.contact_m", "-1"),
        ("shadows.contact_m", "nan"),
        ("shadows.contact_m", "inf"),
        ("shadows.contact_m", "1e30"),
        ("shadows.contact_steps", "0"),
        ("shadows.contact_steps", "65"),
        ("shadows.contact_thickness_m", "-0.1"),
    ] {
        let error = settings.set(key, value).unwrap_err().to_string();
        assert!(error.contains(key), "{error}");
    }
}

#[test]
fn paths_and_lenses_without_it_are_refused() {
    let mut renderer = shared();
    let scene = boxes(light(LightKind::Directional, 3.0), Vec3::new(-1.0, 1.1, -1.2));
    load(&mut renderer, &scene);
    for path in [Path::Forward, Path::ForwardBatched, Path::Gouraud] {
        let request = request(&scene, 0.25).with(|settings| settings.render.path = path);
        let error = renderer.render(&scene, &request).unwrap_err().to_string();
        let expected = format!("`shadows.contact_m=0.25` needs `render.path=deferred`, which is `{}`", path.name());
        assert_eq!(error, expected);
    }
    let fisheye = request(&scene, 0.25).with(|settings| settings.set("camera.fisheye", "equidistant").unwrap());
    let error = renderer.render(&scene, &fisheye).unwrap_err().to_string();
    assert_eq!(error, "`camera.fisheye=equidistant` needs `shadows.contact_m=0`, which is `above 0`");
}

/// Nothing is set: occlusion is there, and the box does not float.
#[test]
fn a_box_on_a_floor_is_darkest_at_its_foot_by_default() {
    let mut builder = SceneBuilder::new(Vec3::new(0.0, 1.6, 3.5), Vec3::new(0.0, 0.3, 0.0), perspective());
    builder.put(primitives::plane(4.0), grey(0.5), at(Vec3::ZERO));
    builder.put(primitives::cube(Vec3::ONE), grey(0.5), at(Vec3::new(0.0, 0.5, 0.0)));
    let scene = builder.finish();
    let by_default = FrameRequest {
        want_aovs: vec![Aov::Position],
        averaging: Averaging::Both,
        ..FrameRequest::of_scene(&scene, SIZE.0, SIZE.1)
    };
    let mut renderer = shared();
    load(&mut renderer, &scene);
    // The light of the floor before the box, by the distance from it, and of the wall that faces it, by the height.
    let mut lit = |request: &FrameRequest| {
        renderer.render(&scene, request).unwrap();
        let radiance = renderer.read_radiance().unwrap();
        let places = floats(renderer.read_aov(Aov::Position).unwrap());
        let mean = |is_floor: bool, range: [f32; 2]| {
            let [mut sum, mut count] = [0.0f32; 2];
            for (place, light) in places.chunks_exact(3).zip(radiance.chunks_exact(4)) {
                let [height_m, away_m] = [place[1], place[2] - 0.5];
                let [across_m, along_m] = if is_floor { [height_m, away_m] } else { [away_m, height_m] };
                if place[0].abs() < 0.4 && across_m.abs() < 1e-3 && along_m > range[0] && along_m < range[1] {
                    (sum, count) = (sum + light[1], count + 1.0);
                }
            }
            assert!(count > 10.0, "{count} pixels, {is_floor}, {range:?}");
            sum / count
        };
        let of_floor = [[1e-3, 0.06], [0.06, 0.15], [0.15, 0.3], [0.3, 0.8]].map(|range| mean(true, range));
        let of_wall = [[1e-3, 0.06], [0.06, 0.12], [0.12, 0.3], [0.3, 0.5]].map(|range| mean(false, range));
        [of_floor, of_wall]
    };
    for [foot, near, beside, open] in lit(&by_default) {
        assert!(foot < near && near < beside && beside < open, "{foot} {near} {beside} {open}");
        assert!(foot < 0.96 * open, "{foot} of {open}");
    }
    // The test can fail.
    let without = by_default.with(|settings| settings.occlusion.enabled = false.into());
    assert!(lit(&without).iter().all(|[foot, .., open]| *foot > 0.98 * open));
}
