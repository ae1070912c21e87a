//! Light in fog against closed forms, and against quadrature where there is none.

use super::super::*;
use crate::build::{SceneBuilder, at, grey};
use glam::Vec3;
use manypass_scene::{AlphaMode, LightKind, Material, Projection, primitives};

const UP: (DVec3, DVec3) = (DVec3::ZERO, DVec3::Y);

fn camera() -> Camera {
    let lens = Lens::Orthographic { height_m: 0.1 };
    Camera { position_world: DVec3::ZERO, world_from_view: glam::DQuat::IDENTITY, lens }
}

/// Along −Z from the origin.
fn seen(world: &World, steps: u32) -> f64 {
    f64::from(world.render(1, 1, Options { shadows: true, medium_steps: steps, ..Options::default() }).radiance[0][0])
}

fn close(found: f64, expected: f64, within: f64) {
    assert!((found - expected).abs() <= within * expected.abs(), "{found} against {expected}");
}

#[test]
fn the_phase_function_scatters_all_light_with_the_stated_mean_cosine() {
    for anisotropy in [-0.6, 0.0, 0.4, 0.85] {
        let medium = Medium { anisotropy, ..Medium::default() };
        let (mut sum, mut mean) = (0.0, 0.0);
        let cells = 20_000;
        for cell in 0..cells {
            let cos = 2.0 * (f64::from(cell) + 0.5) / f64::from(cells) - 1.0;
            let share = medium.phase(cos) * 2.0 * PI * 2.0 / f64::from(cells);
            sum += share;
            mean += share * cos;
        }
        assert!((sum - 1.0).abs() < 1e-4 && (mean - anisotropy).abs() < 1e-4, "{anisotropy}: {sum}, {mean}");
    }
}

#[test]
fn optical_depth_is_the_integral_of_density() {
    for scale_height_m in [f64::INFINITY, 3.0, -3.0, 1e12] {
        let medium = Medium { density_per_m: 0.2, base_height_m: 1.0, scale_height_m, ..Medium::default() };
        for direction in [DVec3::X, DVec3::Y, DVec3::new(0.6, -0.8, 0.0)] {
            let origin = DVec3::new(0.0, 2.0, 0.0);
            let cells = 100_000;
            let step_m = 7.0 / f64::from(cells);
            let depth: f64 = (0..cells)
                .map(|cell| origin.y + direction.y * step_m * (f64::from(cell) + 0.5))
                .map(|y| 0.2 * (-(y - 1.0) / scale_height_m).exp() * step_m)
                .sum();
            close(medium.transmittance(origin, direction, 7.0), (-depth).exp(), 1e-8);
        }
    }
    // Upwards through fog that thins out there is an end: 0.2 · 3 / e^(1/3).
    let medium = Medium { density_per_m: 0.2, base_height_m: 0.0, scale_height_m: 3.0, ..Medium::default() };
    close(medium.transmittance(UP.0, UP.1, f64::INFINITY), (-0.6_f64).exp(), 1e-12);
}

#[test]
fn parallel_light_in_uniform_fog_is_the_closed_form() {
    let mut world = World::new(camera());
    world.lights.push(Light { emission: Emission::Directional, intensity: DVec3::splat(3.0), ..Light::default() });
    let medium = Medium { density_per_m: 0.05, albedo: DVec3::splat(0.8), far_m: 30.0, ..Medium::default() };
    world.medium = Some(medium);
    // albedo · E / 4π · (1 − exp(−σ s)), whatever the number of steps, as they are equal by transmittance.
    let expected = 0.8 * 3.0 / (4.0 * PI) * (1.0 - (-1.5_f64).exp());
    close(seen(&world, 1), expected, 1e-6);
    close(seen(&world, 50), expected, 1e-6);
    // Light that comes along the ray towards the eye is scattered forwards.
    world.medium = Some(Medium { anisotropy: 0.5, ..medium });
    world.lights[0].direction_world = DVec3::Z;
    close(seen(&world, 8), expected * 0.75 / 0.5_f64.powi(3), 1e-6);
}

#[test]
fn height_fog_is_the_quadrature() {
    let mut world = World::new(camera());
    world.camera.world_from_view = glam::DQuat::from_rotation_x(0.4);
    world.lights.push(Light {
        emission: Emission::Directional,
        direction_world: DVec3::new(0.6, -0.8, 0.0),
        ..Light::default()
    });
    for dims_light in [false, true] {
        let medium = Medium {
            density_per_m: 0.3,
            base_height_m: 0.5,
            scale_height_m: 2.0,
            far_m: 40.0,
            dims_light,
            ..Medium::default()
        };
        world.medium = Some(medium);
        let rise = 0.4_f64.sin();
        let density = |y: f64| 0.3 * (-(y - 0.5) / 2.0).exp();
        let cells = 200_000;
        let step_m = 40.0 / f64::from(cells);
        let (mut depth, mut expected) = (0.0, 0.0);
        for cell in 0..cells {
            let y = rise * (f64::from(cell) + 0.5) * step_m;
            let middle = depth + 0.5 * density(y) * step_m;
            // All fog above y, along the light's slant of 0.8: density(y) · 2 m / 0.8.
            let dimming = if dims_light { (-density(y) * 2.0 / 0.8).exp() } else { 1.0 };
            expected += density(y) / (4.0 * PI) * (-middle).exp() * dimming * step_m;
            depth += density(y) * step_m;
        }
        close(seen(&world, 400), expected, 2e-4);
    }
}

#[test]
fn a_lamp_in_fog_is_the_quadrature_of_its_airlight() {
    let mut world = World::new(camera());
    let position_world = DVec3::new(0.3, -0.4, -2.0);
    for (dims_light, range_m, scale_height_m) in
        [(false, None, f64::INFINITY), (true, None, 4.0), (true, Some(3.0), f64::INFINITY)]
    {
        world.lights = vec![Light { position_world, range_m, intensity: DVec3::splat(5.0), ..Light::default() }];
        let medium = Medium {
            density_per_m: 0.2,
            far_m: 10.0,
            anisotropy: 0.3,
            scale_height_m,
            dims_light,
            ..Medium::default()
        };
        world.medium = Some(medium);
        let cells = 400_000;
        let step_m = 10.0 / f64::from(cells);
        let mut expected = 0.0;
        for cell in 0..cells {
            let t = (f64::from(cell) + 0.5) * step_m;
            let offset = position_world - DVec3::NEG_Z * t;
            let distance = offset.length();
            let window = range_m.map_or(1.0, |range: f64| (1.0 - (distance / range).powi(4)).max(0.0));
            let phase = 0.91 / (4.0 * PI * (1.09 + 0.6 * offset.z / distance).powf(1.5));
            // Fog thickens downwards to where the lamp is.
            let mean_density = match scale_height_m.is_finite() {
                true => 0.2 * (4.0 / 0.4) * ((0.4_f64 / 4.0).exp() - 1.0),
                false => 0.2,
            };
            let dimming = if dims_light { (-mean_density * distance).exp() } else { 1.0 };
            expected += 0.2 * (-0.2 * t).exp() * phase * 5.0 * window * dimming / (distance * distance) * step_m;
        }
        close(seen(&world, 2000), expected, 2e-4);
        // Few steps are right in the mean: they are spread evenly by angle.
        close(seen(&world, 8), expected, 0.05);
    }
}

/// A floor, and above it a wall with a window through which the sun shines aslant; seen along −Z.
fn shaft(pane_alpha: f32) -> World {
    let projection = Projection::Orthographic { height_m: 0.1, near_m: 0.1, far_m: 100.0 };
    let mut builder = SceneBuilder::new(Vec3::ZERO, Vec3::NEG_Z, projection);
    // The window is z from −6 to −4.
    let opaque = || grey(0.5);
    builder.put(primitives::plane(4.0), opaque(), at(Vec3::new(0.0, 1.0, -2.0)));
    builder.put(primitives::plane(40.0), opaque(), at(Vec3::new(0.0, 1.0, -26.0)));
    let pane = Material {
        alpha_mode: AlphaMode::Blend,
        base_color_factor: glam::Vec4::new(0.0, 0.0, 0.0, pane_alpha),
        ..opaque()
    };
    let turned = glam::Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    builder.put(primitives::plane(1.0), pane, manypass_scene::Node { rotation: turned, ..at(Vec3::NEG_Z * 5.0) });
    let sun = manypass_scene::Light { kind: LightKind::Directional, intensity: 2.0, ..Default::default() };
    builder.light(sun, Vec3::ZERO, Vec3::NEG_Y);
    let scene = builder.finish();
    let mut world = World::of_scene(&scene, Camera::of_scene(&scene).unwrap());
    world.medium = Some(Medium { density_per_m: 0.1, far_m: 20.0, ..Medium::default() });
    world
}

#[test]
fn shafts_are_lit_where_light_comes_through_and_panes_cover_what_lies_behind() {
    let from_to = |start: f64, end: f64| 2.0 / (4.0 * PI) * ((-0.1 * start).exp() - (-0.1 * end).exp());
    // The edge between light and shadow falls into one of the steps.
    close(seen(&shaft(0.0), 4000), from_to(4.0, 6.0), 2e-3);
    close(seen(&shaft(0.75), 4000), from_to(4.0, 5.0) + 0.25 * from_to(5.0, 6.0), 3e-3);
}
