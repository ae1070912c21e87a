//! The noise of the shadow on the ground, of several bodies.

#![allow(clippy::unwrap_used, reason = "tests panic where they expect something")]

use crate::common::ground::{encoded, product_shot, scene_of};
use crate::common::renderer;
use glam::Vec3;
use manypass::{Averaging, Background, FrameRequest, Ground, Renderer};
use manypass_scene::{Scene, primitives};

/// The side of the squares that are fitted, in pixels.
const WINDOW_PX: usize = 5;

/// What is left of a shadow beside the smooth surfaces through its pixels and those around them, in levels of 255.
struct Noise {
    /// How many pixels are looked at.
    count: usize,
    /// From the least to the most.
    spread: f32,
    /// What 999 of 1,000 pixels are within, up or down.
    usual: f32,
}

/// The pixels of a square picture from which all pixels up to `margin` away, in rows and columns, are in `mask`.
fn eroded(mask: &[bool], side: usize, margin: usize) -> Vec<bool> {
    let along = |mask: &[bool], step: usize| -> Vec<bool> {
        let is_within = |at: usize| {
            let place = (at / step) % side;
            place >= margin && place + margin < side && (0..=2 * margin).all(|i| mask[at + i * step - margin * step])
        };
        (0..mask.len()).map(is_within).collect()
    };
    along(&along(mask, 1), side)
}

/// The smooth surface of the second degree through the 5 × 5 pixels around one (Savitzky and Golay 1964).
fn smooth(levels: &[f32], side: usize, at: usize) -> f32 {
    let corner = at - WINDOW_PX / 2 * (side + 1);
    let weighed = |index: u8| {
        let [i, j] = [index % 5, index / 5];
        let [across, down] = [i, j].map(|step| f32::from(step) - 2.0);
        let weight = (27.0 - 5.0 * (across * across + down * down)) / 175.0;
        weight * levels[corner + usize::from(j) * side + usize::from(i)]
    };
    (0..25u8).map(weighed).sum()
}

/// The noise of the shadow over white, in one sample, from a fortieth of the picture away from the body on: where the
/// shadow touches that, it bends within few pixels.
fn noise(renderer: &mut Renderer, scene: &Scene, side: usize) -> Noise {
    let shot = product_shot(scene, (side as u32, side as u32), [30.0, 28.0]).with(|settings| {
        settings.background.source = Background::Transparent;
        settings.ground.mode = Ground::Shadow;
    });
    renderer.render(scene, &FrameRequest { averaging: Averaging::Both, ..shot }).unwrap();
    let radiance = renderer.read_radiance().unwrap();
    let levels: Vec<f32> = radiance.chunks_exact(4).map(|pixel| encoded(1.0 - pixel[3])).collect();
    let is_ground = |pixel: &[f32]| pixel[..3].iter().all(|value| *value < 1e-4) && pixel[3] < 0.95;
    let ground: Vec<bool> = radiance.chunks_exact(4).map(is_ground).collect();
    let away = eroded(&ground, side, (side / 40).max(WINDOW_PX / 2));
    let in_penumbra = |at: &usize| away[*at] && (220.0..254.9).contains(&levels[*at]);
    let mut left: Vec<f32> =
        (0..levels.len()).filter(in_penumbra).map(|at| levels[at] - smooth(&levels, side, at)).collect();
    left.sort_by(f32::total_cmp);
    let spread = left.last().zip(left.first()).map_or(0.0, |(most, least)| most - least);
    let mut sizes: Vec<f32> = left.iter().map(|off| off.abs()).collect();
    sizes.sort_by(f32::total_cmp);
    let usual = sizes.get(sizes.len() * 999 / 1000).copied().unwrap_or(0.0);
    Noise { count: left.len(), spread, usual }
}

#[test]
fn the_noise_of_a_shadow_is_less_than_a_level() {
    let mut renderer = renderer();
    // Bodies, the most levels from the least to the most at 240 and 320 pixels, and within what 999 of 1,000 are. Found
    // were 0.18 and 0.14, 0.28 and 0.25, 0.23 and 0.19, 0.75 and 0.48, 0.17 and 0.19. A surface of the second degree
    // misses the bends of narrow shadows, too: all but 0.22 of the ring's 0.75 are in the mean of 16 samples as well.
    let bodies = [
        ("box", primitives::cube(Vec3::splat(2.0)), [0.3, 0.25], 0.15),
        ("ball", primitives::uv_sphere(1.0, 48, 24), [0.35, 0.3], 0.2),
        ("post", primitives::cube(Vec3::new(0.1, 2.0, 0.1)), [0.3, 0.3], 0.15),
        ("ring", primitives::torus(0.8, 0.2, 48, 24), [1.0, 0.7], 0.35),
        ("high body", primitives::cube(Vec3::new(1.0, 10.0, 1.0)), [0.3, 0.3], 0.15),
    ];
    for (name, body, spreads, most_usual) in bodies {
        let scene = scene_of(body, 1.0);
        for (side, most_spread) in [240, 320].into_iter().zip(spreads) {
            let Noise { count, spread, usual } = noise(&mut renderer, &scene, side);
            println!("{name}, {side} pixels: {spread:.3} levels from least to most, 999 of 1,000 within {usual:.3}");
            assert!(count > 3000, "{name}, {side} pixels: {count} to look at");
            assert!(spread <= most_spread && usual <= most_usual, "{name}, {side} pixels: {spread}, {usual}");
        }
    }
}
