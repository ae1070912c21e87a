//! Phong's and Blinn–Phong's reflectance against their formulas, written again in f64, and their energy.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{plain_request, renderer};
use manypass::{Path, ReflectanceModel};
use manypass_testkit::scenes;
use std::f64::consts::{FRAC_PI_2, PI};

const SIDE: u32 = 64;

/// The lobe at a roughness, for the cosine between light and normal, where the eye looks along the normal.
fn lobe(model: ReflectanceModel, roughness: f64, n_dot_l: f64) -> f64 {
    let alpha = roughness * roughness;
    let exponent = 2.0 / (alpha * alpha) - 2.0;
    match model {
        // The reflection leaves as the light came in.
        ReflectanceModel::Phong => (exponent / 4.0 + 2.0) / (2.0 * PI) * n_dot_l.powf(exponent / 4.0),
        // Half of the angle to the eye, which is that to the normal.
        _ => {
            let norm = (exponent + 2.0) * (exponent + 4.0) / (8.0 * PI * (2.0f64.powf(-exponent / 2.0) + exponent));
            norm * (0.5 * n_dot_l.acos()).cos().powf(exponent)
        }
    }
}

#[test]
fn lobes_reflect_all_that_comes_from_above() {
    for model in [ReflectanceModel::Phong, ReflectanceModel::BlinnPhong] {
        for roughness in [0.1, 0.3, 0.6, 1.0] {
            let steps = 200_000;
            let step = FRAC_PI_2 / f64::from(steps);
            let over = |i| {
                let angle = (f64::from(i) + 0.5) * step;
                lobe(model, roughness, angle.cos()) * angle.cos() * angle.sin() * 2.0 * PI * step
            };
            let energy: f64 = (0..steps).map(over).sum();
            assert!((energy - 1.0).abs() < 1e-3, "{model:?} at {roughness}: {energy}");
        }
    }
}

#[test]
fn one_light_on_one_plane_is_as_the_formulas_say() {
    let mut renderer = renderer();
    for (metallic, roughness) in [(0.0, 0.5), (1.0, 0.5), (1.0, 0.9), (0.3, 0.25)] {
        let mut scene = scenes::one_light_on_one_plane().scene;
        scene.materials[0].metallic_factor = metallic;
        scene.materials[0].roughness_factor = roughness;
        renderer.load(&scene).unwrap();
        let shot = |renderer: &mut manypass::Renderer, model, path| {
            let request = plain_request(&scene, (SIDE, SIDE)).with(|settings| {
                settings.shading.model = model;
                settings.render.path = path;
            });
            renderer.render(&scene, &request).unwrap();
            renderer.read_radiance().unwrap()
        };
        let pbr = shot(&mut renderer, ReflectanceModel::Pbr, Path::Forward);
        for model in [ReflectanceModel::Phong, ReflectanceModel::BlinnPhong] {
            // The G-buffer has roughness in 8 bits: half a step is 0.8 % of 0.25, which the power of four of an
            // exponent makes 3 %, and more in the dark at the foot of a lobe.
            for (path, tolerance, floor) in [(Path::Forward, 0.01, 1e-3), (Path::Deferred, 0.04, 0.02)] {
                let found = shot(&mut renderer, model, path);
                let (metallic, roughness) = (f64::from(metallic), f64::from(roughness));
                let f0 = 0.04 + (1.0 - 0.04) * metallic;
                for y in 0..SIDE {
                    for x in 0..SIDE {
                        let [x_m, z_m] = [x, y].map(|k| 4.0 * (f64::from(k) + 0.5) / f64::from(SIDE) - 2.0);
                        let distance_squared = x_m * x_m + z_m * z_m + 1.0;
                        let n_dot_l = distance_squared.sqrt().recip();
                        let diffuse = (1.0 - f0) * (1.0 - metallic) / PI;
                        let expected = (diffuse + f0 * lobe(model, roughness, n_dot_l)) * n_dot_l / distance_squared;
                        let value = f64::from(found[((y * SIDE + x) * 4) as usize]);
                        let error = (value - expected).abs() / expected.max(floor);
                        assert!(error < tolerance, "{model:?}, {path:?}, {roughness}: {value}, expected {expected}");
                    }
                }
                let differs = found.iter().zip(&pbr).filter(|(a, b)| (**a - **b).abs() > 0.02 * b.abs()).count();
                assert!(differs > 300, "{model:?} looks like pbr: {differs}");
            }
        }
    }
}
