//! Energy: what is lit evenly from everywhere. Under an even environment the table of directional albedo cancels for a
//! white metal, whatever it holds; under suns from all sides it is judged by an integral that does not know it.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{plain_request, radiance};
use manypass::{Background, Environment, Path};
use manypass_testkit::raycast::{Frame, Options};
use manypass_testkit::scenes::{self, FURNACE_ROUGHNESS};

const SIZE: (u32, u32) = (128, 52);
/// The gaps between so many move the mean of a band by at most 0.6 %.
const SUNS: u16 = 3072;
/// Bands of N·V. Nearer to the edge the chords of a sphere's mesh are visible.
const BANDS: [(f64, f64); 4] = [(0.2, 0.4), (0.4, 0.6), (0.6, 0.8), (0.8, 1.01)];

/// The mean radiance of a band of a sphere.
#[derive(Clone, Debug)]
struct Band {
    /// Which sphere, for messages.
    name: String,
    is_metal: bool,
    mean: f64,
}

/// The mean over every band of every sphere. `truth` says where they are.
fn bands(truth: &Frame, radiance: &[[f32; 3]]) -> Vec<Band> {
    let mut bands = Vec::new();
    for object in 0..10 {
        let (is_metal, roughness) = (object % 2 == 1, FURNACE_ROUGHNESS[object / 2]);
        for (low, high) in BANDS {
            let is_inside = |at: &usize| {
                // The view is along −Z.
                let n_dot_v = truth.normal_world[*at].z;
                truth.object_id[*at] == object as u32 + 1 && (low..high).contains(&n_dot_v)
            };
            let inside: Vec<f64> = (0..radiance.len()).filter(is_inside).map(|at| f64::from(radiance[at][0])).collect();
            assert!(inside.len() > 30, "{} pixels", inside.len());
            let what = if is_metal { "metal" } else { "dielectric" };
            let name = format!("{what} of roughness {roughness}, N·V from {low}");
            bands.push(Band { name, is_metal, mean: inside.iter().sum::<f64>() / inside.len() as f64 });
        }
    }
    bands
}

/// The bands that are off by more than one per cent.
fn faults(found: &[Band], expected: impl Fn(usize) -> f64) -> Vec<String> {
    let is_off = |(i, band): &(usize, &Band)| (band.mean / expected(*i) - 1.0).abs() > 0.01;
    found
        .iter()
        .enumerate()
        .filter(is_off)
        .map(|(i, band)| format!("{}: {:.4} instead of {:.4}", band.name, band.mean, expected(i)))
        .collect()
}

#[test]
fn white_under_suns_from_everywhere_loses_nothing() {
    let test = scenes::furnace(SUNS, [1.0, 1.0]);
    let truth = test.world.render(SIZE.0 as usize, SIZE.1 as usize, Options::default());
    let expected = bands(&truth, &truth.radiance);
    // Metal reflects all of it. A white dielectric does so within a few per cent only and more at grazing angles,
    // because glTF's BRDF (appendix B) takes Fresnel at the half vector for what enters the surface; the ray caster
    // says how much.
    let energy = |i: usize| if expected[i].is_metal { 1.0 } else { expected[i].mean };
    for path in [Path::Forward, Path::Deferred] {
        let request = plain_request(&test.scene, SIZE).with(|settings| settings.render.path = path);
        let found = bands(&truth, &radiance(&test.scene, &request));
        let wrong = faults(&found, energy);
        assert!(wrong.is_empty(), "{path:?}: {wrong:#?}");
        // The test can fail: the radiance of a white metal is the albedo of its lobe divided by the table's, so that a
        // table that is 2 % too low or too high at any place makes this place 2 % too bright or too dark.
        for at in (0..found.len()).filter(|at| found[*at].is_metal) {
            for factor in [0.98, 1.02] {
                let mut spoilt = found.clone();
                spoilt[at].mean *= factor;
                assert_eq!(faults(&spoilt, energy).len(), 1, "{} times {factor}", spoilt[at].name);
            }
        }
    }
}

#[test]
fn an_even_environment_is_suns_from_everywhere() {
    // A grey metal and what a black dielectric reflects take the table's two terms in other parts than white does.
    let test = scenes::furnace(SUNS, [0.0, 0.5]);
    let truth = test.world.render(SIZE.0 as usize, SIZE.1 as usize, Options::default());
    let expected = bands(&truth, &truth.radiance);
    let mut scene = test.scene.clone();
    scene.lights.clear();
    scene.nodes.iter_mut().for_each(|node| node.light = None);
    // Not the deferred path, whose base colours have eight bits.
    let request = plain_request(&scene, SIZE).with(|settings| {
        settings.render.path = Path::Forward;
        settings.environment.source = Environment::Color([1.0; 3]);
    });
    let found = bands(&truth, &radiance(&scene, &request));
    let wrong = faults(&found, |i| expected[i].mean);
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn a_white_metal_vanishes_in_an_even_environment() {
    // Whatever the table holds: this judges the environment, its backdrop and that both meet.
    let mut test = scenes::rows_of_spheres();
    test.scene.lights.clear();
    test.scene.nodes.iter_mut().for_each(|node| node.light = None);
    for material in &mut test.scene.materials {
        material.base_color_factor = glam::Vec4::ONE;
        material.metallic_factor = 1.0;
    }
    let mut request = plain_request(&test.scene, SIZE);
    request.settings.environment.source = Environment::Color([1.0; 3]);
    request.settings.background.source = Background::Environment;
    let pixels = radiance(&test.scene, &request);
    let worst = pixels.iter().flatten().fold(0.0f32, |worst, v| worst.max((v - 1.0).abs()));
    assert!(worst < 0.01, "the furnace is off by {worst}");
}
