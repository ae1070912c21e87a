//! What rough surfaces reflect of pictures of the environment, direction by direction, against integrals over all of their texels.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

mod common;

use common::renderer;
use common::skies::{Surroundings, maps, place, radiance, request, scene, turns};
use glam::{DVec3, Quat, Vec3};
use manypass::Background;
use manypass_scene::Projection;
use std::f32::consts::FRAC_PI_2;

/// How far what is reflected may be off, as shares of its own brightness in a direction or of the environment's mean, whichever is more.
struct Bounds {
    roughness: f64,
    /// The root of the mean square, and the most in any direction.
    mean_square: f64,
    worst: f64,
    /// The most within 12 degrees of the brightest place: a sun, which is a disc here and has whatever shape there.
    by_the_brightest: f64,
}

/// Lobes are narrower than texels of the picture at the first of them (the half width of its peak is 0.2 degrees, a texel 0.35), so that it
/// is tiles' resolution that edges of lamps are off by; from 0.2 on it is the number of samples, at lamps of 5 degrees and less.
const BOUNDS: [Bounds; 8] = [
    Bounds { roughness: 0.05, mean_square: 0.015, worst: 0.18, by_the_brightest: 0.25 },
    Bounds { roughness: 0.1, mean_square: 0.006, worst: 0.05, by_the_brightest: 0.05 },
    Bounds { roughness: 0.15, mean_square: 0.004, worst: 0.04, by_the_brightest: 0.11 },
    Bounds { roughness: 0.2, mean_square: 0.004, worst: 0.025, by_the_brightest: 0.04 },
    Bounds { roughness: 0.3, mean_square: 0.008, worst: 0.03, by_the_brightest: 0.02 },
    Bounds { roughness: 0.5, mean_square: 0.004, worst: 0.02, by_the_brightest: 0.02 },
    Bounds { roughness: 0.7, mean_square: 0.004, worst: 0.012, by_the_brightest: 0.012 },
    Bounds { roughness: 1.0, mean_square: 0.005, worst: 0.015, by_the_brightest: 0.01 },
];

/// What the camera sees of a blurred environment is what a surface of that roughness reflects along its normal; of roughness 1 it
/// is irradiance.
#[test]
fn reflections_are_integrals_over_the_lobe() {
    let mut renderer = renderer();
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
            assert!(is_within, "{name} at {}: {found:.4?}, allowed {allowed:?}", bounds.roughness);
            assert!(mean_square(1) > 5.0 * found[0], "the test cannot tell up from down");
        }
    }
}
