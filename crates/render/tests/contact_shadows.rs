//! Shadows of the picture where maps miss them: gaps against the ray caster, surfaces that they have to leave alone, and
//! values that nobody means.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

mod common;

use common::inner_pixels;
use common::shadows::{SIZE, SPOT, light, perspective, radiance, shared, surfaces, unshadowed, world_of};
use glam::{DVec3, Quat, Vec3};
use manypass::{FrameRequest, LightCulling, Path, Renderer, View};
use manypass_scene::{Light, LightKind, Node, Projection, Scene, primitives};
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
struct Wrong {
    shadowed: usize,
    leaks: usize,
    lit: usize,
    dark: usize,
}

fn compare(world: &World, found: &[Option<f32>]) -> Wrong {
    let frame = surfaces(world);
    let hard = Options { light_samples_per_axis: 0, ..Options::default() };
    let is_lit = |position: DVec3| world.visibility_at(0, position, hard) > 0.5;
    let mut wrong = Wrong::default();
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
        ("from before", light(LightKind::Directional, 3.0), Vec3::new(0.8, 1.6, 1.2)),
        ("spot", light(SPOT, 30.0), Vec3::new(-1.6, 1.8, -1.2)),
        ("point", light(LightKind::Point, 30.0), Vec3::new(-1.6, 1.8, -1.2)),
    ] {
        let scene = boxes(lamp, place);
        let world = world_of(&scene);
        load(&mut renderer, &scene);
        let without = compare(&world, &shares(&mut renderer, &scene, &request(&scene, 0.0), 16));
        let with = compare(&world, &shares(&mut renderer, &scene, &request(&scene, 0.3), 16));
        println!("{name}: {without:?} without, {with:?} with");
    }
}
