//! Ambient occlusion of surfaces whose radius is few pixels wide: it takes fewer steps and points, and loses nothing by
//! that.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::plain_request;
use crate::common::shadows::{perspective, radiance, shared};
use glam::{Quat, Vec3};
use manypass::{Environment, FrameRequest, OcclusionMethod, Renderer, Resolution};
use manypass_scene::{Material, Node, Scene, primitives};
use manypass_testkit::build::{SceneBuilder, grey};
use std::f32::consts::FRAC_PI_2;
use std::f64::consts::PI;

const SIZE: (u32, u32) = (120, 80);

/// A floor and a wall that meet along the x-axis, seen so that both are as steep.
fn corner(distance_m: f32) -> Scene {
    let eye = Vec3::new(0.0, 1.0, 1.0).normalize() * distance_m;
    let mut builder = SceneBuilder::new(eye, Vec3::ZERO, perspective());
    let rough = || Material { roughness_factor: 1.0, ..grey(0.5) };
    builder.put(primitives::plane(200.0), rough(), Node::default());
    let rotation = Quat::from_rotation_x(FRAC_PI_2);
    builder.put(primitives::plane(200.0), rough(), Node { rotation, ..Node::default() });
    builder.finish()
}

fn request(scene: &Scene, size: (u32, u32), method: OcclusionMethod, radius_m: f32) -> FrameRequest {
    plain_request(scene, size).with(|settings| {
        settings.environment.source = Environment::Color([1.0; 3]);
        settings.occlusion.enabled = true.into();
        settings.occlusion.method = method;
        settings.occlusion.resolution = Resolution::Full;
        settings.occlusion.radius_m = radius_m;
        settings.occlusion.multi_bounce = false;
    })
}

/// The most that `occlusion.steps` may be.
const STEPS_MAX: u32 = 32;

fn drawn(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest, steps: u32) -> Vec<[f32; 3]> {
    radiance(renderer, scene, &request.with(|settings| settings.occlusion.steps = steps), 1)
}

#[test]
fn a_slice_takes_as_many_steps_as_its_way_has_pixels() {
    let mut renderer = shared();
    let scene = corner(5.0);
    renderer.unload();
    renderer.load(&scene).unwrap();
    // Ways are cut off at half the height, 6.5 pixels, though walls rise higher there.
    let request = request(&scene, (40, 13), OcclusionMethod::Gtao, 100.0);
    let [fewer, all, more, most] = [4, 8, 12, STEPS_MAX].map(|steps| drawn(&mut renderer, &scene, &request, steps));
    assert!(all == more && all == most);
    assert!(all != fewer);
}

#[test]
fn there_are_as_many_points_as_pixels_within_the_radius() {
    let mut renderer = shared();
    let scene = corner(20.0);
    renderer.unload();
    renderer.load(&scene).unwrap();
    // 1.4 pixels, of which up to 12 lie within the radius: as many points as 6 steps to both sides are.
    let request = request(&scene, SIZE, OcclusionMethod::Ssao, 0.3);
    let [fewer, more, most] = [4, 8, STEPS_MAX].map(|steps| drawn(&mut renderer, &scene, &request, steps));
    assert!(more == most);
    assert!(fewer != more);
}

/// The share of light that a wall takes from a floor at so many of its radii: a segment of the disc which the hemisphere
/// is from above (Nusselt's analogy).
fn lost_beside_wall(distance: f64) -> f64 {
    if distance < 1.0 { (distance.acos() - distance * (1.0 - distance * distance).sqrt()) / PI } else { 0.0 }
}

/// What is lost from the wall to the end of the radius, in radii; of points it is the mean over their distances.
fn lost_in_all(method: OcclusionMethod) -> f64 {
    let mean = |of: &dyn Fn(f64) -> f64| (0..512).map(|i| of((f64::from(i) + 0.5) / 512.0)).sum::<f64>() / 512.0;
    let of_radius = |radius: f64| radius * mean(&lost_beside_wall);
    match method {
        OcclusionMethod::Gtao => of_radius(1.0),
        OcclusionMethod::Ssao => mean(&|place| of_radius(0.1 + 0.9 * place * place)),
    }
}

#[test]
fn what_is_seen_small_is_as_dark_in_all() {
    let mut renderer = shared();
    for method in [OcclusionMethod::Gtao, OcclusionMethod::Ssao] {
        // Few texels seldom show the highest, and next to an edge they show none of it: the less the fewer they are. Points
        // are spread by the radius, whatever it is wide.
        let least_of_distances = match method {
            OcclusionMethod::Gtao => [0.95, 0.95, 0.83, 0.67],
            OcclusionMethod::Ssao => [1.0, 1.0, 0.95, 0.87],
        };
        for (distance_m, least) in [8.0, 16.0, 32.0, 64.0].into_iter().zip(least_of_distances) {
            let scene = corner(distance_m);
            renderer.unload();
            renderer.load(&scene).unwrap();
            let request = request(&scene, SIZE, method, 1.0).with(|settings| settings.occlusion.falloff = 0.0);
            let open = request.with(|settings| settings.occlusion.enabled = false.into());
            let open = radiance(&mut renderer, &scene, &open, 1);
            let radius_px = f64::from(SIZE.1) * 0.5 / (0.4f64.tan() * f64::from(distance_m));
            // Of the middle columns, in pixels; the floor and the wall are seen at an angle of 45 degrees.
            let columns = SIZE.0 as usize / 2 - 20..SIZE.0 as usize / 2 + 20;
            let expected = 2.0 * lost_in_all(method) * radius_px * 0.5f64.sqrt();
            for steps in [8, STEPS_MAX] {
                let request = request.with(|settings| settings.occlusion.steps = steps);
                let found = radiance(&mut renderer, &scene, &request, 64);
                let lost = |pixel: usize| 1.0 - f64::from(found[pixel][1]) / f64::from(open[pixel][1]);
                let of_column = |x: usize| (0..SIZE.1 as usize).map(|y| lost(y * SIZE.0 as usize + x)).sum::<f64>();
                let mean = columns.clone().map(of_column).sum::<f64>() / columns.len() as f64;
                let ratio = mean / expected;
                println!("{method:?}, {radius_px:.2} pixels, {steps} steps: {ratio:.4} of the closed form");
                assert!(ratio > least && ratio < 1.07, "{method:?}, {radius_px:.2} pixels, {steps} steps: {ratio}");
            }
        }
    }
}
