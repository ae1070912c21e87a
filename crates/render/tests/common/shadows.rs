//! What the tests of shadows share.

use super::{plain_request, renderer};
use manypass::{FrameRequest, Renderer};
use manypass_scene::{Light, LightKind, Projection, Scene};
use manypass_testkit::raycast::{Camera, Frame, Options, World};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};

/// Of all pictures.
pub const SIZE: (u32, u32) = (160, 120);
/// So small that its texels are larger than pixels: what they miss shows.
pub const ATLAS_PX: u32 = 1024;

/// One device for all tests.
pub fn shared() -> MutexGuard<'static, Renderer> {
    static RENDERER: LazyLock<Mutex<Renderer>> = LazyLock::new(|| Mutex::new(renderer()));
    RENDERER.lock().unwrap_or_else(PoisonError::into_inner)
}

/// With shadows.
pub fn request(scene: &Scene) -> FrameRequest {
    plain_request(scene, SIZE).with(|settings| {
        settings.shadows.enabled = true;
        settings.shadows.atlas_px = ATLAS_PX;
    })
}

/// The same without.
pub fn unshadowed(request: &FrameRequest) -> FrameRequest {
    request.with(|settings| settings.shadows.enabled = false)
}

/// The mean radiance of so many samples, in which every light casts its shadow.
pub fn radiance(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest, samples: u32) -> Vec<[f32; 3]> {
    let light_rounds = renderer.light_rounds(scene, request).unwrap();
    let frames_per_sample = light_rounds.unwrap_or(1).div_ceil(samples);
    let sample_count = samples * frames_per_sample;
    for sample_index in 0..sample_count {
        let request = FrameRequest { sample_index, sample_count, frames_per_sample, light_rounds, ..request.clone() };
        renderer.render(scene, &request).unwrap();
    }
    renderer.read_radiance().unwrap().chunks_exact(4).map(|p| [p[0], p[1], p[2]]).collect()
}

/// Of each pixel, the share of light that its shadows leave; none where there is no light at all.
pub fn shares(scene: &Scene, request: &FrameRequest, samples: u32) -> Vec<Option<f32>> {
    let mut renderer = shared();
    // Maps keep their sizes while lights change little, whichever scene they are of.
    renderer.unload();
    renderer.load(scene).unwrap();
    let lit = radiance(&mut renderer, scene, &unshadowed(request), samples);
    let shadowed = radiance(&mut renderer, scene, request, samples);
    let share = |(lit, shadowed): (&[f32; 3], &[f32; 3])| (lit[1] > 1e-4).then(|| shadowed[1] / lit[1]);
    lit.iter().zip(&shadowed).map(share).collect()
}

/// What the ray caster sees.
pub fn world_of(scene: &Scene) -> World {
    World::of_scene(scene, Camera::of_scene(scene).unwrap())
}

/// The surfaces of a picture without any light.
pub fn surfaces(world: &World) -> Frame {
    let unlit = World { lights: Vec::new(), ..world.clone() };
    unlit.render(SIZE.0 as usize, SIZE.1 as usize, Options { multiple_scattering: false, ..Options::default() })
}

/// A camera.
pub fn perspective() -> Projection {
    Projection::Perspective { fov_y_rad: 0.8, near_m: 0.1, far_m: Some(100.0) }
}

/// A white light.
pub fn light(kind: LightKind, intensity: f32) -> Light {
    Light { kind, intensity, ..Light::default() }
}

/// A spot.
pub const SPOT: LightKind = LightKind::Spot { inner_cone_rad: 0.5, outer_cone_rad: 0.7 };
