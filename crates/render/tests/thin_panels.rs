//! What is thinner than a pixel, in the few samples of a quick picture.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{plain_request, renderer};
use glam::{Quat, Vec3, Vec4};
use manypass::{Averaging, Exposure, FrameRequest};
use manypass_scene::{Material, Node, Projection, Scene, ShadingModel, primitives};
use manypass_testkit::build::{SceneBuilder, at};
use std::f32::consts::FRAC_PI_2;

const SIDE: u32 = 64;
/// What the picture shows of the world, in metres.
const HEIGHT_M: f32 = 2.0;
/// A panel falls so many pixels a pixel, so that it lies everywhere between two rows somewhere.
const SLOPE: f32 = 1.0 / 40.0;

/// A white panel through the middle of the picture, beyond its sides.
fn panel(width_px: f32, turn_rad: f32) -> Scene {
    let projection = Projection::Orthographic { height_m: HEIGHT_M, near_m: 0.1, far_m: 10.0 };
    let mut builder = SceneBuilder::new(Vec3::Z * 2.0, Vec3::ZERO, projection);
    let unlit = Material { shading_model: ShadingModel::Unlit, base_color_factor: Vec4::ONE, ..Material::default() };
    let size_m = Vec3::new(2.0 * HEIGHT_M, width_px * HEIGHT_M / SIDE as f32, 0.01);
    let rotation = Quat::from_rotation_z(turn_rad);
    builder.put(primitives::cube(size_m), unlit, Node { rotation, ..at(Vec3::ZERO) });
    builder.finish()
}

/// Four samples tell widths to a quarter of a pixel. They lie beside each other, too: there the panel is up to three
/// quarters of the slope higher.
#[test]
fn four_samples_cover_a_thin_panel_within_a_quarter_of_a_pixel() {
    const MOST_PX: f32 = 0.25 + 0.75 * SLOPE + 0.01;
    let (mut renderer, side) = (renderer(), SIDE as usize);
    for width_px in [0.2, 0.4, 0.7, 0.9] {
        for (is_upright, turn_rad) in [(false, SLOPE.atan()), (true, SLOPE.atan() + FRAC_PI_2)] {
            let scene = panel(width_px, turn_rad);
            renderer.load(&scene).unwrap();
            let mut request =
                plain_request(&scene, (SIDE, SIDE)).with(|settings| settings.exposure.stops = Exposure::Stops(0.0));
            (request.averaging, request.sample_count) = (Averaging::Radiance, 4);
            for sample_index in 0..4 {
                renderer.render(&scene, &FrameRequest { sample_index, ..request.clone() }).unwrap();
            }
            let radiance = renderer.read_radiance().unwrap();
            let truth_px = width_px * 1.0_f32.hypot(SLOPE);
            for line in 0..side {
                let red =
                    |across: usize| radiance[4 * if is_upright { line * side + across } else { across * side + line }];
                let covered_px = (0..side).map(red).sum::<f32>();
                let off_px = (covered_px - truth_px).abs();
                assert!(off_px <= MOST_PX, "upright {is_upright}, line {line}: {covered_px} of {truth_px} pixels");
            }
        }
    }
}
