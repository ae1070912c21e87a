//! Passes over surfaces draw nothing beside the rectangle that these lie in, and the picture is the same.
//!
//! These need an adapter; the software one will do.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::plain_request;
use crate::common::reflected::{bulb, metal};
use crate::common::shadows::{perspective, radiance, shared};
use glam::Vec3;
use manypass::{Environment, FrameRequest, OcclusionMethod, Path, Resolution};
use manypass_scene::{Node, Scene, primitives};
use manypass_testkit::build::{SceneBuilder, at, grey};

/// Odd, so that the last texels of smaller pictures have fewer pixels.
const SIZE: (u32, u32) = (161, 119);

/// A few things in the middle of the picture. With `is_wide` there are more beside it, in a layer that is not seen, at the
/// same distances: they widen the rectangle to the whole picture, and change nothing else.
fn scene(is_wide: bool) -> Scene {
    let mut builder = SceneBuilder::new(Vec3::new(0.0, 0.0, 6.0), Vec3::ZERO, perspective());
    builder.put(primitives::cube(Vec3::new(1.6, 0.2, 1.6)), metal(0.0), at(Vec3::new(0.2, -0.7, 0.0)));
    builder.put(primitives::uv_sphere(0.6, 32, 16), metal(0.3), at(Vec3::new(-0.3, 0.0, 0.0)));
    builder.put(primitives::uv_sphere(0.3, 32, 16), bulb(2.0), at(Vec3::new(0.6, -0.3, 0.3)));
    builder.put(primitives::cube(Vec3::splat(0.4)), grey(0.7), at(Vec3::new(0.5, 0.2, -0.4)));
    for side in [-1.0, 1.0].into_iter().filter(|_| is_wide) {
        let node = Node { layers: 2, ..at(Vec3::new(4.5 * side, 3.5 * side, 0.0)) };
        builder.put(primitives::cube(Vec3::splat(0.1)), grey(0.7), node);
    }
    builder.finish()
}

/// All lengths are given, because those that are left open go with the extent of what is drawn.
fn request(scene: &Scene, resolution: Resolution) -> FrameRequest {
    let request = plain_request(scene, SIZE).with(|settings| {
        settings.environment.source = Environment::Color([1.0, 0.8, 0.6]);
        settings.occlusion.enabled = true.into();
        settings.occlusion.resolution = resolution;
        settings.occlusion.radius_m = 0.6;
        settings.gi.enabled = true;
        settings.gi.resolution = resolution;
        settings.gi.radius_m = 1.0;
        settings.reflections.enabled = true.into();
        settings.reflections.resolution = resolution;
        settings.reflections.roughness_max = 1.0;
        settings.reflections.distance_m = 4.0;
        settings.reflections.thickness_m = 0.2;
    });
    FrameRequest { layers: 1, ..request }
}

#[test]
fn the_rectangle_around_surfaces_changes_no_picture() {
    let (narrow, wide) = (scene(false), scene(true));
    let mut renderer = shared();
    let mut shown = |scene: &Scene, request: &FrameRequest, samples: u32| {
        renderer.unload();
        renderer.load(scene).unwrap();
        radiance(&mut renderer, scene, request, samples)
    };
    for resolution in [Resolution::Half, Resolution::Quarter] {
        let whole = request(&narrow, resolution);
        let variants = [
            whole.clone(),
            whole.with(|settings| settings.occlusion.method = OcclusionMethod::Ssao),
            whole.with(|settings| settings.occlusion.bent_normals = true),
            whole.with(|settings| settings.occlusion.blur = false),
        ];
        for (variant, request) in variants.iter().enumerate() {
            for samples in [1, 4] {
                let within = shown(&narrow, request, samples);
                let truth = shown(&wide, request, samples);
                assert!(within == truth, "{resolution:?}, variant {variant}, {samples} samples");
            }
        }
        let off = whole.with(|settings| {
            settings.occlusion.enabled = false.into();
            settings.gi.enabled = false;
            settings.reflections.enabled = false.into();
        });
        assert!(shown(&narrow, &off, 1) != shown(&narrow, &whole, 1), "there is something to be found");
    }
    let forward = request(&narrow, Resolution::Half).with(|settings| {
        settings.gi.enabled = false;
        settings.render.path = Path::Forward;
    });
    assert!(shown(&narrow, &forward, 1) == shown(&wide, &forward, 1), "forward");
}
