//! Light that surfaces send each other as far as the picture shows them: against form factors, and what it must leave
//! alone.
//!
//! Surfaces are as rough as can be and dielectrics, whose share of mirrored light is known from the environment's.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::shadows::{light, perspective, radiance, shared};
use crate::common::{floats, plain_request};
use glam::{Quat, Vec3};
use manypass::{Aov, Environment, FrameRequest, Path, Renderer, Resolution};
use manypass_scene::{LightKind, Material, Node, Scene, ShadingModel, primitives};
use manypass_testkit::build::{SceneBuilder, at, grey};
use std::f32::consts::{FRAC_PI_2, PI};

const SIZE: (u32, u32) = (120, 80);

fn rough(color: [f32; 3]) -> Material {
    Material { base_color_factor: Vec3::from(color).extend(1.0), roughness_factor: 1.0, ..grey(1.0) }
}

/// Of the same radiance from everywhere.
fn glowing(color: [f32; 3]) -> Material {
    Material { shading_model: ShadingModel::Unlit, ..rough(color) }
}

/// A floor at y = 0, and at z = 0 a wall, 20 m each.
fn corner(eye: Vec3, target: Vec3, floor: Material, wall: Material) -> SceneBuilder {
    let mut builder = SceneBuilder::new(eye, target, perspective());
    builder.put(primitives::plane(20.0), floor, Node::default());
    let rotation = Quat::from_rotation_x(FRAC_PI_2);
    builder.put(primitives::plane(20.0), wall, Node { rotation, ..Node::default() });
    builder
}

/// At full size, of light from up to 1 m, of which none fades out but in the last quarter.
fn request(scene: &Scene, radius_m: f32) -> FrameRequest {
    plain_request(scene, SIZE).with(|settings| {
        settings.gi.enabled = true;
        settings.gi.radius_m = radius_m;
        settings.gi.resolution = Resolution::Full;
        settings.gi.brightness_max = 0.0;
        settings.gi.steps = 32;
    })
}

fn without(request: &FrameRequest) -> FrameRequest {
    request.with(|settings| settings.gi.enabled = false)
}

fn load(renderer: &mut Renderer, scene: &Scene) {
    renderer.unload();
    renderer.load(scene).unwrap();
}

/// Of each pixel where its surface is, and its normal.
fn places(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<(Vec3, Vec3)> {
    let request = FrameRequest { want_aovs: vec![Aov::Position, Aov::Normal], ..request.clone() };
    renderer.render(scene, &request).unwrap();
    let [positions, normals] = [Aov::Position, Aov::Normal].map(|aov| floats(renderer.read_aov(aov).unwrap()));
    let both = positions.chunks_exact(3).zip(normals.chunks_exact(3));
    both.map(|(position, normal)| (Vec3::from_slice(position), Vec3::from_slice(normal))).collect()
}

/// The share of light, by the cosine, that a floor gets so far from a wall, of what lies within `radius_m` and fades out
/// over the last quarter of that: by Nusselt's analogy for each distance, the segment of a disc beyond a chord.
fn wall_share(distance_m: f32, radius_m: f32) -> f32 {
    let segment = |radius: f32| {
        let c = (distance_m / radius).min(1.0);
        (c.acos() - c * (1.0 - c * c).sqrt()) / PI
    };
    (0..64u8).map(|i| segment(radius_m * (0.75 + 0.25 * (f32::from(i) + 0.5) / 64.0)) / 64.0).sum()
}

#[test]
fn a_wall_that_glows_lights_the_floor_as_its_form_factor_says() {
    let mut renderer = shared();
    const COLOR: [f32; 3] = [0.8, 0.4, 0.1];
    let mut checked = 0;
    for (eye, target) in [
        (Vec3::new(0.0, 2.5, 4.5), Vec3::new(0.0, 0.4, 0.4)),
        (Vec3::new(2.6, 2.0, 4.5), Vec3::new(0.0, 0.4, 0.4)),
        (Vec3::new(0.5, 4.5, 2.0), Vec3::new(0.0, 0.4, 0.4)),
    ] {
        let scene = corner(eye, target, rough([0.5; 3]), glowing(COLOR)).finish();
        load(&mut renderer, &scene);
        let with = request(&scene, 1.0);
        let places = places(&mut renderer, &scene, &without(&with));
        // What the floor reflects of even light of 1, without what it mirrors of it: all else is diffuse.
        let of_even = |renderer: &mut Renderer, color: f32| {
            let mut even = scene.clone();
            even.materials[0].base_color_factor = Vec3::splat(color).extend(1.0);
            load(renderer, &even);
            let request = without(&with).with(|settings| settings.environment.source = Environment::Color([1.0; 3]));
            radiance(renderer, &even, &request, 1)
        };
        let [grey, black] = [0.5, 0.0].map(|color| of_even(&mut renderer, color));
        load(&mut renderer, &scene);
        let found = radiance(&mut renderer, &scene, &with, 64);
        for from_m in [0.1, 0.2, 0.35, 0.5, 0.7] {
            let near = (0..found.len()).filter(|pixel| {
                let (position, normal) = places[*pixel];
                normal.y > 0.9 && (position.z - from_m).abs() < 0.03 && position.x.abs() < 1.0
            });
            let ratios: Vec<f32> = near
                .map(|pixel| {
                    let expected = wall_share(places[pixel].0.z, 1.0) * (grey[pixel][1] - black[pixel][1]);
                    found[pixel][1] / (COLOR[1] * expected)
                })
                .collect();
            if ratios.len() < 10 {
                continue;
            }
            let mean = ratios.iter().sum::<f32>() / ratios.len() as f32;
            println!("{eye}, {from_m} m: {mean:.3} of the closed form, {} pixels", ratios.len());
            checked += 1;
            // Where most of what is near fades out, a step is too coarse for the end of the radius.
            let tolerance = if from_m < 0.5 { 0.06 } else { 0.2 };
            assert!((mean - 1.0).abs() < tolerance, "{eye}, {from_m} m: {mean}");
        }
        // In the colour of the wall.
        for pixel in found.iter().zip(&places).filter(|(found, place)| place.1.y > 0.9 && found[0] > 0.02) {
            let [red, green, blue] = *pixel.0;
            assert!((green / red - 0.5).abs() < 0.01 && (blue / red - 0.125).abs() < 0.01, "{red} {green} {blue}");
        }
    }
    assert!(checked > 8, "{checked}");
}

/// Light of 1 from everywhere: from the environment, and from a wall that glows as bright.
#[test]
fn what_is_found_takes_the_place_of_the_environment() {
    let mut renderer = shared();
    let eye = Vec3::new(2.0, 2.5, 4.5);
    let scene = corner(eye, Vec3::new(0.0, 0.4, 0.4), rough([0.5; 3]), glowing([1.0; 3])).finish();
    load(&mut renderer, &scene);
    let even = request(&scene, 1.0).with(|settings| settings.environment.source = Environment::Color([1.0; 3]));
    let open = radiance(&mut renderer, &scene, &without(&even), 1);
    let places = places(&mut renderer, &scene, &without(&even));
    let with_occlusion = even.with(|settings| {
        settings.occlusion.enabled = true.into();
        settings.occlusion.radius_m = 1.0;
        settings.occlusion.falloff = 0.25;
        settings.occlusion.slices = 2;
        settings.occlusion.steps = 32;
        settings.occlusion.resolution = Resolution::Full;
    });
    for (name, request, tolerance) in [("alone", &even, 0.005), ("beside occlusion", &with_occlusion, 0.06)] {
        // The filter of few samples takes the foot of the wall for the floor.
        for (samples, more) in [(1, 0.03), (64, 0.0)] {
            let tolerance = tolerance + more;
            let found = radiance(&mut renderer, &scene, request, samples);
            // Not where samples of a pixel meet the wall.
            let is_floor = |pixel: usize| places.get(pixel).is_none_or(|place| place.1.y > 0.9);
            let width = SIZE.0 as usize;
            let floor = (width..found.len()).filter(|pixel| {
                (-1..=1)
                    .all(|dy: isize| (-1..=1).all(|dx| is_floor(pixel.wrapping_add_signed(dy * width as isize + dx))))
            });
            let ratios: Vec<f32> = floor.map(|pixel| found[pixel][1] / open[pixel][1]).collect();
            let [least, most] = [f32::min, f32::max].map(|of| ratios.iter().copied().fold(1.0, of));
            println!("{name}, {samples} samples: {least:.4} to {most:.4} of {} pixels", ratios.len());
            assert!(ratios.len() > 1000 && least > 1.0 - tolerance && most < 1.0 + tolerance, "{name}: {least} {most}");
        }
    }
}

/// A room of four walls, a floor and two boxes, which all reflect `albedo`, under a lamp.
fn room(albedo: f32, intensity: f32) -> Scene {
    let mut builder = SceneBuilder::new(Vec3::new(0.0, 1.0, 4.4), Vec3::new(0.0, 1.0, 0.0), perspective());
    builder.put(primitives::plane(2.0), rough([albedo; 3]), Node::default());
    let turned = |rotation, place| Node { rotation, ..at(place) };
    let upright = Quat::from_rotation_x(FRAC_PI_2);
    builder.put(primitives::plane(2.0), rough([albedo; 3]), turned(upright, Vec3::new(0.0, 1.0, -1.0)));
    let ceiling = turned(Quat::from_rotation_x(PI), Vec3::Y * 2.0);
    builder.put(primitives::plane(2.0), rough([albedo; 3]), ceiling);
    for (side, color) in [(-1.0f32, [albedo, 0.1 * albedo, 0.1 * albedo]), (1.0, [0.1 * albedo, albedo, 0.1 * albedo])]
    {
        let rotation = Quat::from_rotation_z(side * FRAC_PI_2);
        builder.put(primitives::plane(2.0), rough(color), turned(rotation, Vec3::new(side, 1.0, 0.0)));
    }
    let tall = turned(Quat::from_rotation_y(0.3), Vec3::new(-0.35, 0.6, -0.3));
    builder.put(primitives::cube(Vec3::new(0.6, 1.2, 0.6)), rough([albedo; 3]), tall);
    let low = turned(Quat::from_rotation_y(-0.3), Vec3::new(0.35, 0.3, 0.3));
    builder.put(primitives::cube(Vec3::splat(0.6)), rough([albedo; 3]), low);
    builder.light(light(LightKind::Point, intensity), Vec3::new(0.0, 1.8, 0.2), Vec3::NEG_Y);
    builder.finish()
}

#[test]
fn energy_is_never_made() {
    let mut renderer = shared();
    // In the dark nothing is found, whatever is there; and what is black sends and reflects nothing.
    for scene in [room(0.9, 0.0), room(0.0, 5.0)] {
        load(&mut renderer, &scene);
        let with = request(&scene, 0.0);
        let found = radiance(&mut renderer, &scene, &with, 2);
        assert_eq!(found, radiance(&mut renderer, &scene, &without(&with), 2));
    }
    // What is added is at most the albedo times the brightest that is seen.
    let scene = room(0.8, 5.0);
    load(&mut renderer, &scene);
    for (resolution, samples) in
        [(Resolution::Full, 1), (Resolution::Full, 16), (Resolution::Half, 1), (Resolution::Quarter, 16)]
    {
        let with = request(&scene, 4.0).with(|settings| settings.gi.resolution = resolution);
        let direct = radiance(&mut renderer, &scene, &without(&with), samples);
        let found = radiance(&mut renderer, &scene, &with, samples);
        let brightest = direct.iter().flatten().copied().fold(0.0, f32::max);
        let added: Vec<f32> = found.iter().zip(&direct).map(|(found, direct)| found[1] - direct[1]).collect();
        let [least, most] = [f32::min, f32::max].map(|of| added.iter().copied().fold(0.0, of));
        println!("{resolution:?}, {samples} samples: {least} to {most}, brightest {brightest}");
        assert!(least > -1e-3 && most < 0.8 * brightest && most > 0.01 * brightest, "{least} {most}");
        // The left of the floor is reddish, and the right is greenish.
        let bottom = &found[(SIZE.0 * (SIZE.1 * 5 / 6)) as usize..];
        let redness = |from: u32, to: u32| {
            let pixels = bottom.chunks(SIZE.0 as usize).flat_map(|row| row[from as usize..to as usize].to_vec());
            let sums = pixels.fold([0.0; 2], |sum, pixel| [sum[0] + pixel[0], sum[1] + pixel[1]]);
            sums[0] / sums[1]
        };
        let (left, right) = (redness(36, 48), redness(72, 84));
        println!("redness {left} {right}");
        assert!(left > 1.05 && right < 0.95, "{left} {right}");
    }
}

#[test]
fn what_is_off_changes_nothing_and_other_paths_are_refused() {
    let mut renderer = shared();
    let scene = room(0.8, 5.0);
    load(&mut renderer, &scene);
    let with = request(&scene, 0.0);
    let found = radiance(&mut renderer, &scene, &with, 1);
    let off = radiance(&mut renderer, &scene, &without(&with), 1);
    assert_ne!(found, off);
    let no_effects = with.with(|settings| settings.effects.enabled = false);
    assert_eq!(radiance(&mut renderer, &scene, &no_effects, 1), off);
    for path in [Path::Forward, Path::ForwardBatched, Path::Gouraud] {
        let request = with.with(|settings| settings.render.path = path);
        let error = renderer.render(&scene, &request).unwrap_err().to_string();
        assert_eq!(error, format!("`gi.enabled=true` needs `render.path=deferred`, which is `{}`", path.name()));
    }
    let fisheye = with.with(|settings| settings.set("camera.fisheye", "equidistant").unwrap());
    let error = renderer.render(&scene, &fisheye).unwrap_err().to_string();
    assert_eq!(error, "`camera.fisheye=equidistant` needs `gi.enabled=false`, which is `true`");
}

#[test]
fn extreme_values_give_finite_pictures() {
    let mut renderer = shared();
    let scene = room(0.8, 5.0);
    load(&mut renderer, &scene);
    for (radius_m, thinness, steps, slices, resolution) in [
        (1e-30, 0.0, 1, 1, Resolution::Full),
        (1e6, 1.0, 64, 2, Resolution::Quarter),
        (1e6, 0.0, 4, 16, Resolution::Half),
        (0.0, 1.0, 1, 1, Resolution::Quarter),
    ] {
        let request = request(&scene, radius_m).with(|settings| {
            settings.gi.thinness = thinness;
            settings.gi.steps = steps;
            settings.gi.slices = slices;
            settings.gi.resolution = resolution;
            settings.environment.source = Environment::Color([1.0; 3]);
        });
        for (width, height) in [SIZE, (1, 1), (1, 4096), (4096, 1)] {
            let request = FrameRequest { width, height, ..request.clone() };
            renderer.render(&scene, &request).unwrap();
            let found = renderer.read_radiance().unwrap();
            let bound = found.iter().all(|value| value.is_finite() && (0.0..1e4).contains(value));
            assert!(bound, "{radius_m} m, {thinness}, {steps} steps, {width} × {height}");
        }
    }
    let mut settings = manypass::Settings::default();
    for (key, value) in [
        ("gi.radius_m", "-1"),
        ("gi.radius_m", "nan"),
        ("gi.thinness", "2"),
        ("gi.brightness_max", "inf"),
        ("gi.steps", "0"),
        ("gi.slices", "17"),
        ("gi.resolution", "tiny"),
    ] {
        let error = settings.set(key, value).unwrap_err().to_string();
        assert!(error.contains(key), "{error}");
    }
}

#[test]
fn a_slice_takes_as_many_steps_as_its_way_has_pixels() {
    let mut renderer = shared();
    let eye = Vec3::new(0.0, 3.5, 3.5);
    let scene = corner(eye, Vec3::ZERO, rough([0.5; 3]), glowing([1.0; 3])).finish();
    load(&mut renderer, &scene);
    // Ways are cut off at half the height, 6.5 pixels, though the wall goes on there.
    let small = FrameRequest { width: 40, height: 13, ..request(&scene, 100.0) };
    let [fewer, all, more, most] = [4, 8, 12, 64]
        .map(|steps| radiance(&mut renderer, &scene, &small.with(|settings| settings.gi.steps = steps), 1));
    assert!(all == more && all == most);
    assert!(all != fewer);
}
