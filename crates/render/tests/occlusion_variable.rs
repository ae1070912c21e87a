//! Screen-space occlusion as a variable, and in the pictures of passes, which show it as the variable has it.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::shadows::perspective;
use crate::common::{floats, plain_request, renderer};
use glam::{Quat, Vec3};
use manypass::{Aov, Environment, FrameRequest, PassPicture, Path, Resolution, Switch};
use manypass_scene::{Material, Node, Scene, primitives};
use manypass_testkit::build::{SceneBuilder, grey};
use std::collections::BTreeSet;
use std::f32::consts::FRAC_PI_2;

const SIZE: (u32, u32) = (96, 64);

/// A floor and a wall that meet at a right angle, with the background beside them.
fn corner() -> Scene {
    let mut builder = SceneBuilder::new(Vec3::new(0.5, 1.5, 4.0), Vec3::new(0.0, 0.6, 0.0), perspective());
    let matte = || Material { roughness_factor: 1.0, ..grey(0.5) };
    builder.put(primitives::plane(4.0), matte(), Node::default());
    let rotation = Quat::from_rotation_x(FRAC_PI_2);
    builder.put(primitives::plane(2.0), matte(), Node { rotation, ..Node::default() });
    builder.finish()
}

/// White light from everywhere, which occlusion takes from.
fn request(scene: &Scene, resolution: Resolution) -> FrameRequest {
    plain_request(scene, SIZE).with(|settings| {
        settings.environment.source = Environment::Color([1.0; 3]);
        settings.occlusion.enabled = Switch::On;
        settings.occlusion.resolution = resolution;
        settings.occlusion.radius_m = 1.0;
    })
}

/// The first bytes of the pixels of the target `name`.
fn shown(pictures: &[PassPicture], name: &str) -> Vec<u8> {
    let picture = pictures.iter().find(|picture| picture.name == name).unwrap_or_else(|| panic!("no {name}"));
    let is_grey = |pixel: &[u8]| pixel[0] == pixel[1] && pixel[1] == pixel[2];
    assert!(picture.rgba8.chunks_exact(4).all(is_grey), "{name} has one channel");
    picture.rgba8.chunks_exact(4).map(|pixel| pixel[0]).collect()
}

fn levels(bytes: &[u8]) -> usize {
    bytes.iter().collect::<BTreeSet<_>>().len()
}

#[test]
fn pictures_of_passes_show_occlusion_as_the_variable_has_it() {
    let scene = corner();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    for (resolution, whole) in [(Resolution::Full, "occlusion.blur"), (Resolution::Half, "occlusion.upsample")] {
        let mut request = request(&scene, resolution);
        let pictures = renderer.passes(&scene, &request).unwrap();
        request.want_aovs = vec![Aov::OcclusionScreen, Aov::Depth];
        renderer.render(&scene, &request).unwrap();
        let variable = floats(renderer.read_aov(Aov::OcclusionScreen).unwrap());
        let depth_m = floats(renderer.read_aov(Aov::Depth).unwrap());
        assert_eq!(variable.len(), (SIZE.0 * SIZE.1) as usize);
        let background = || (0..depth_m.len()).filter(|at| depth_m[*at].is_infinite());
        assert!(background().count() > 100 && background().all(|at| variable[at] == 1.0), "{resolution:?}");
        assert!(variable.iter().any(|share| *share < 0.8), "{resolution:?}: a corner hides light");
        let dumped = shown(&pictures, whole);
        assert!(levels(&dumped) > 32, "{resolution:?}: {} levels of grey", levels(&dumped));
        for (at, (byte, share)) in dumped.iter().zip(&variable).enumerate() {
            let off = (f32::from(*byte) / 255.0 - share).abs();
            assert!(off <= 1.0 / 255.0, "{resolution:?}: pixel {at} is {byte}, the variable {share}");
        }
        // What is beside a distance, and what has noise, is grey as well.
        for name in ["occlusion", "occlusion.blur"] {
            assert!(levels(&shown(&pictures, name)) > 8, "{resolution:?}: {name}");
        }
    }
}

#[test]
fn the_variable_is_there_without_occlusion_in_the_picture() {
    let scene = corner();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let on = request(&scene, Resolution::Half);
    let off = on.with(|settings| settings.occlusion.enabled = Switch::Off);
    let wanted = |request: &FrameRequest| FrameRequest { want_aovs: vec![Aov::OcclusionScreen], ..request.clone() };
    let mut variables = Vec::new();
    for request in [&on, &off] {
        renderer.render(&scene, request).unwrap();
        let alone = renderer.read_display().unwrap();
        renderer.render(&scene, &wanted(request)).unwrap();
        assert!(alone == renderer.read_display().unwrap(), "the variable leaves the picture as it is");
        variables.push(floats(renderer.read_aov(Aov::OcclusionScreen).unwrap()));
    }
    // On the forward path variables are drawn by themselves.
    let forward = off.with(|settings| settings.render.path = Path::Forward);
    renderer.render(&scene, &forward).unwrap();
    renderer.draw_variables(&scene, &wanted(&forward)).unwrap();
    variables.push(floats(renderer.read_aov(Aov::OcclusionScreen).unwrap()));
    assert!(
        variables.iter().all(|variable| variable == &variables[0]) && variables[0].iter().any(|share| *share < 0.8)
    );
}

#[test]
fn every_target_of_a_frame_has_a_picture() {
    let scene = corner();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let request = request(&scene, Resolution::Full);
    let names: Vec<String> = renderer.passes(&scene, &request).unwrap().into_iter().map(|of| of.name).collect();
    // At the full size occlusion is a single half float.
    for name in ["geometry.normal", "linear_depth", "occlusion", "occlusion.blur"] {
        assert!(names.iter().any(|known| known == name), "{name} is not among {names:?}");
    }
}
