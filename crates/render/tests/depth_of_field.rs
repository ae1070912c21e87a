//! The effect `dof` against a thin lens: the light of a small lamp that is not in focus lies on a disk, none is lost.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{built_in_with as with, plain_request, renderer};
use glam::{Quat, Vec3};
use manypass::Effect;
use manypass_scene::{Material, Node, Projection, Scene, ShadingModel, primitives};
use manypass_testkit::build::SceneBuilder;
use std::sync::Arc;

const SIDE_PX: usize = 128;
const FOV_Y_DEG: f64 = 45.0;
const SAMPLES: u32 = 8;
const WALL_RADIANCE: f32 = 0.01;
const LAMP_RADIANCE: f32 = 400.0;

/// A square lamp before a wall, seen from the origin along −Z; its side and its place from the middle in pixels.
fn lamp(lamp_m: f32, wall_m: f32, side_px: f32, (x_px, y_px): (f32, f32)) -> Scene {
    let projection = Projection::Perspective { fov_y_rad: FOV_Y_DEG.to_radians() as f32, near_m: 0.01, far_m: None };
    let mut builder = SceneBuilder::new(Vec3::ZERO, Vec3::NEG_Z, projection);
    let mut square = |side_m: f32, translation: Vec3, radiance: f32| {
        let material = Material {
            shading_model: ShadingModel::Unlit,
            base_color_factor: Vec3::splat(radiance.min(1.0)).extend(1.0),
            ..Material::default()
        };
        // What is brighter than white glows.
        let glowing = Material { emissive_factor: Vec3::splat(radiance), ..Material::default() };
        let material = if radiance > 1.0 { glowing } else { material };
        let rotation = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
        builder.put(primitives::plane(side_m), material, Node { translation, rotation, ..Node::default() });
    };
    let pixel_m = 2.0 * lamp_m * (0.5 * FOV_Y_DEG.to_radians() as f32).tan() / SIDE_PX as f32;
    square(4.0 * wall_m, Vec3::NEG_Z * wall_m, WALL_RADIANCE);
    square(side_px * pixel_m, Vec3::new(x_px * pixel_m, y_px * pixel_m, -lamp_m), LAMP_RADIANCE);
    builder.finish()
}

/// The radius of the circle of confusion in pixels with an aperture of f/1, by similar triangles behind a lens whose sensor
/// is 24 mm high.
fn radius_px_of_f1(distance_m: f64, focus_m: f64) -> f64 {
    let focal_m = 0.012 / (0.5 * FOV_Y_DEG.to_radians()).tan();
    let image = |m: f64| 1.0 / (1.0 / focal_m - 1.0 / m);
    let (sharp, here) = (image(focus_m), image(distance_m));
    0.5 * focal_m * (here - sharp).abs() / here / 0.024 * SIDE_PX as f64
}

/// What a picture's light beside that of the wall does: its sum, the radius of a disk with its second moment, and which share
/// lies within 0.7 of `radius_px`.
fn spread(picture: &[f64], wall: f64, radius_px: f64) -> (f64, f64, f64) {
    let place = |at: usize| ((at % SIDE_PX) as f64 + 0.5, (at / SIDE_PX) as f64 + 0.5);
    let mean = |of: &dyn Fn(f64, f64) -> f64| {
        let weighted = picture.iter().enumerate().map(|(at, value)| (value - wall) * of(place(at).0, place(at).1));
        weighted.sum::<f64>()
    };
    let sum = mean(&|_, _| 1.0);
    let (x, y) = (mean(&|x, _| x) / sum, mean(&|_, y| y) / sum);
    let square = mean(&|px, py| (px - x).powi(2) + (py - y).powi(2)) / sum;
    let inner = mean(&|px, py| f64::from(u8::from((px - x).hypot(py - y) < 0.7 * radius_px))) / sum;
    (sum, (2.0 * square).max(0.0).sqrt(), inner)
}

#[test]
fn a_lamp_out_of_focus_keeps_its_light_on_a_disk_wherever_it_is_and_whatever_is_behind_it() {
    let mut renderer = renderer();
    let mut off = Vec::new();
    // The lamp in front of what is sharp, before a wall in focus and before one that is not; both behind it; and the lamp on
    // the wall.
    for (lamp_m, wall_m, focus_m, radii_px) in [
        (2.0, 8.0, 8.0, &[3.0, 6.0, 12.0, 30.0, 44.0][..]),
        (2.0, 3.0, 8.0, &[3.0, 12.0][..]),
        (8.0, 200.0, 2.0, &[3.0, 12.0, 20.0][..]),
        (8.0, 8.001, 2.0, &[3.0, 12.0, 30.0][..]),
    ] {
        for (at, radius_px) in radii_px.iter().copied().enumerate() {
            for side_px in [1.0, 2.0] {
                // Somewhere else in its pixel, and in the four pixels of half the size, every time.
                let offset = ([0.3, 0.9, 1.6][at % 3], [0.6, 1.3, 0.1][at % 3]);
                let scene = lamp(lamp_m, wall_m, side_px, offset);
                renderer.load(&scene).unwrap();
                let mut request = plain_request(&scene, (SIDE_PX as u32, SIDE_PX as u32));
                let f_stop = radius_px_of_f1(f64::from(lamp_m), focus_m) / radius_px;
                let dof = with(&renderer, "dof", &[&format!("focus_m={focus_m}"), &format!("f_stop={f_stop}")]);
                let mut picture = |effects: Vec<Arc<dyn Effect>>| {
                    request.effects = effects;
                    // Chance decides where a sample looks into a disk.
                    request.sample_count = SAMPLES;
                    let mut sum = vec![0.0; SIDE_PX * SIDE_PX];
                    for sample_index in 0..SAMPLES {
                        request.sample_index = sample_index;
                        renderer.render(&scene, &request).unwrap();
                        let radiance = renderer.read_radiance().unwrap();
                        for (sum, pixel) in sum.iter_mut().zip(radiance.chunks_exact(4)) {
                            *sum += f64::from(pixel[0]) / f64::from(SAMPLES);
                        }
                    }
                    sum
                };
                let (before, after) = (picture(Vec::new()), picture(vec![dof]));
                let ratio = after.iter().sum::<f64>() / before.iter().sum::<f64>();
                let (_, lamp_px, _) = spread(&before, before[0], radius_px);
                let (_, found_px, inner) = spread(&after, after[0], radius_px);
                let disk_px = (found_px * found_px - lamp_px * lamp_px).max(0.0).sqrt();
                let what = format!(
                    "{lamp_m} m before {wall_m} m, focus {focus_m} m, {side_px} px wide: {ratio:.3} of the light, \
                     radius {disk_px:.2} of {radius_px} px, {inner:.2} within 0.7 of it"
                );
                println!("{what}");
                // What is nearly sharp is a mixture of two pictures, whose form is not that of a disk. Of a disk 0.49 lie
                // within 0.7 of its radius.
                let is_disk =
                    radius_px < 6.0 || ((disk_px / radius_px - 1.0).abs() < 0.12 && (inner - 0.49).abs() < 0.15);
                // At half the size the disks of what is nearly sharp are a texel or two wide.
                let within = if radius_px < 6.0 { 0.3 } else { 0.15 };
                if (ratio - 1.0).abs() > within || !is_disk {
                    off.push(what);
                }
            }
        }
    }
    assert!(off.is_empty(), "{off:#?}");
}
