//! Flat things before walls, seen along parallel rays, and frames of them that follow each other.

use super::plain_request;
use glam::{Quat, Vec3};
use manypass::{Averaging, Background, FrameRequest, Renderer, UpscaleMethod};
use manypass_scene::{Material, Node, NodeId, Primitive, Projection, Scene, ShadingModel, primitives};
use manypass_testkit::build::{SceneBuilder, at, grey};

/// Of all pictures.
pub const SIZE: (u32, u32) = (96, 64);

/// Of one colour whatever the light.
pub fn flat(albedo: f32) -> Material {
    Material { shading_model: ShadingModel::Unlit, ..grey(albedo) }
}

/// Parallel rays along −z, 24 pixels a metre in a picture of 64 rows.
pub fn flat_scene() -> SceneBuilder {
    let projection = Projection::Orthographic { height_m: 64.0 / 24.0, near_m: 0.1, far_m: 20.0 };
    SceneBuilder::new(Vec3::Z * 5.0, Vec3::ZERO, projection)
}

pub fn bar(width_m: f32, height_m: f32) -> Primitive {
    primitives::cube(Vec3::new(width_m, height_m, 0.02))
}

/// Bars narrower than a pixel and wider ones, each turned a little, before nothing and before a wall.
pub fn fence() -> Scene {
    bars(0.012)
}

/// Bars from this width on.
pub fn bars(width_m: f32) -> Scene {
    let mut builder = flat_scene();
    builder.put(bar(2.0, 4.0), flat(0.05), at(Vec3::new(1.0, 0.0, -1.0)));
    for index in 0..17 {
        let across = index as f32 / 16.0 - 0.5;
        let node = Node { rotation: Quat::from_rotation_z(0.25 * across), ..at(Vec3::X * 3.7 * across) };
        builder.put(bar(width_m + 0.003 * index as f32, 4.0), flat(0.7), node);
    }
    builder.put(bar(4.0, 0.02), flat(0.5), Node { rotation: Quat::from_rotation_z(0.03), ..at(Vec3::Z * 0.1) });
    builder.finish()
}

/// The next of frames that follow each other.
pub fn live(scene: &Scene) -> FrameRequest {
    let request = plain_request(scene, SIZE).with(|settings| {
        settings.taa.enabled = true;
        settings.background.source = Background::Color([0.03; 3]);
    });
    FrameRequest { goes_on: true, averaging: Averaging::Display, ..request }
}

/// A view of its own has no frames before.
pub fn begin(renderer: &mut Renderer, scene: &Scene) {
    renderer.cut();
    renderer.load(scene).unwrap();
}

pub fn picture(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<u8> {
    renderer.render(scene, request).unwrap();
    renderer.read_display().unwrap()
}

/// The picture of 64 samples, all of them everywhere.
pub fn still(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<u8> {
    still_of(renderer, scene, request, 64)
}

/// The picture of so many samples, all of them everywhere.
pub fn still_of(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest, sample_count: u32) -> Vec<u8> {
    let request = request.with(|settings| settings.adaptive.threshold = 0.0);
    for sample_index in 0..sample_count {
        let sample = FrameRequest { sample_index, sample_count, goes_on: false, ..request.clone() };
        renderer.render(scene, &sample).unwrap();
    }
    renderer.read_display().unwrap()
}

/// The mean difference of channels, of 255, and the largest.
pub fn difference(a: &[u8], b: &[u8]) -> (f64, u8) {
    let of = |(a, b): (&u8, &u8)| a.abs_diff(*b);
    let sum: f64 = a.iter().zip(b).map(|pair| f64::from(of(pair))).sum();
    (sum / a.len() as f64, a.iter().zip(b).map(of).max().unwrap())
}

pub fn squared(a: &[u8], b: &[u8]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(a.abs_diff(*b)).powi(2)).sum::<f64>() / a.len() as f64
}

/// A bright body that moves by 8 pixels a frame over a dark wall, so far before it.
pub fn body_before_wall(distance_m: f32) -> (Scene, NodeId) {
    let mut builder = flat_scene();
    builder.put(bar(9.0, 9.0), flat(0.02), at(Vec3::Z * -0.02));
    let body = builder.put(bar(0.5, 1.5), flat(0.7), at(Vec3::new(-1.5, 0.0, distance_m)));
    (builder.finish(), body)
}

/// Of each pixel whether it is bright.
pub fn is_bright(picture: &[u8]) -> Vec<bool> {
    picture.chunks_exact(4).map(|pixel| pixel[1] > 100).collect()
}

/// The brightest that what moves leaves where it was in the frame before the last one, and not since; `scenes` are of
/// frames that follow each other.
pub fn ghost(renderer: &mut Renderer, scenes: &[Scene], request: &FrameRequest) -> u8 {
    begin(renderer, &scenes[0]);
    let bare = request.with(|settings| {
        settings.taa.enabled = false;
        settings.upscale.method = UpscaleMethod::Bilinear;
    });
    let mut was: Vec<Vec<bool>> = Vec::new();
    let mut brightest = 0;
    for (frame, scene) in scenes.iter().enumerate() {
        let shown = picture(renderer, scene, request);
        // A picture without it leaves alone what frames keep.
        was.push(is_bright(&picture(renderer, scene, &bare)));
        // Frames look at most half a pixel beside the middle, and boxes are of the pixels around.
        let near = |mask: &[bool], at: usize| {
            let (x, y) = ((at % 96) as i32, (at / 96) as i32);
            let inside = |x: i32, y: i32| (0..96).contains(&x) && (0..64).contains(&y);
            (-2..=2).any(|dy| (-2..=2).any(|dx| inside(x + dx, y + dy) && mask[((y + dy) * 96 + x + dx) as usize]))
        };
        if frame >= 2 {
            let left =
                (0..96 * 64).filter(|at| was[frame - 2][*at] && !near(&was[frame - 1], *at) && !near(&was[frame], *at));
            let found: Vec<u8> = left.map(|at| shown[4 * at + 1]).collect();
            assert!(found.len() > 10, "frame {frame}: the test looks at {} pixels", found.len());
            brightest = found.into_iter().chain([brightest]).max().unwrap();
        }
    }
    brightest
}
