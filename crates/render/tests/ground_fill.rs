//! The ground before the faint studio, which stands beside lamps of a scene.

#![allow(clippy::unwrap_used, reason = "tests panic where they expect something")]

use crate::common::renderer;
use glam::Vec3;
use manypass::{Background, Environment, Exposure, FrameRequest, Ground, Renderer};
use manypass_scene::{Light, Material, Mesh, Node, Scene, primitives};

/// A sphere that stands on the ground.
fn sphere() -> Scene {
    let mut scene = Scene::default();
    scene.materials.push(Material::default());
    let mut shape = primitives::uv_sphere(1.0, 48, 24);
    shape.material = Some(0);
    scene.meshes.push(Mesh { primitives: vec![shape], ..Mesh::default() }.into());
    scene.add_node(None, Node { mesh: Some(0), ..Node::default() });
    scene.update_transforms();
    scene
}

fn with_lamp(mut scene: Scene) -> Scene {
    scene.lights.push(Light { intensity: 20.0, ..Light::default() });
    scene.add_node(None, Node { light: Some(0), translation: Vec3::new(0.5, 1.5, 2.5), ..Node::default() });
    scene.update_transforms();
    scene
}

/// The mean of what the shadow takes of white, in levels, in the environment that nobody states.
fn shade(renderer: &mut Renderer, scene: &Scene) -> (f64, Environment) {
    renderer.load(scene).unwrap();
    let [(shaded, source), (plain, _)] = [Ground::Auto, Ground::None].map(|ground| {
        let mut request = FrameRequest::of_scene(scene, 96, 64).with(|settings| {
            settings.background.source = Background::Color([1.0; 3]);
            settings.ground.mode = ground;
        });
        renderer.expose(scene, &mut request, Exposure::Scene).unwrap();
        renderer.render(scene, &request).unwrap();
        (renderer.read_display().unwrap(), request.settings.environment.source)
    });
    let takes = plain.iter().zip(shaded.iter()).map(|(plain, shaded)| f64::from(plain.saturating_sub(*shaded)));
    (takes.sum::<f64>() / plain.len() as f64, source)
}

#[test]
fn beside_lamps_the_shadow_is_about_that_of_the_studio() {
    let mut renderer = renderer();
    let (studio, source) = shade(&mut renderer, &sphere());
    assert_eq!(source, Environment::Studio);
    let (beside_lamp, source) = shade(&mut renderer, &with_lamp(sphere()));
    assert_eq!(source, Environment::Fill);
    assert!((0.75..1.35).contains(&(beside_lamp / studio)), "{beside_lamp}, in the studio {studio}");
}
