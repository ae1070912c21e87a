//! A floor with spheres under 1,000 lights that circle over it.

use manypass::glam::{Vec3, Vec4};
use manypass::scene::{Light, Material, Node, NodeId, Primitive, Scene, primitives};
use std::f32::consts::TAU;

const LAMPS: usize = 1000;
const NAME: &str = "moving lamp";

/// The scene as it is in the first frame.
pub fn scene() -> Scene {
    let mut scene = Scene::default();
    let grey = |roughness_factor: f32| Material {
        base_color_factor: Vec4::new(0.5, 0.5, 0.5, 1.0),
        metallic_factor: 0.0,
        roughness_factor,
        ..Material::default()
    };
    let (floor, sphere) = (scene.add_material(grey(0.7)), scene.add_material(grey(0.3)));
    let floor = scene.add_mesh(Primitive { material: Some(floor), ..primitives::plane(24.0) });
    let sphere = scene.add_mesh(Primitive { material: Some(sphere), ..primitives::uv_sphere(0.6, 48, 24) });
    scene.add_node(None, Node { mesh: Some(floor), ..Node::default() });
    for i in 0..25 {
        let translation = Vec3::new((i % 5) as f32 * 4.0 - 8.0, 0.6, (i / 5) as f32 * 4.0 - 8.0);
        scene.add_node(None, Node { mesh: Some(sphere), translation, ..Node::default() });
    }
    for i in 0..LAMPS {
        let hue = TAU * i as f32 / 7.0;
        let color_linear = Vec3::new(hue.cos(), (hue - TAU / 3.0).cos(), (hue + TAU / 3.0).cos()) * 0.5 + 0.5;
        let light =
            Light { color_linear, intensity: 0.4, range_m: Some(1.5), casts_shadows: false, ..Light::default() };
        scene.add_light(light, Node { name: NAME.into(), ..Node::default() });
    }
    move_all(&mut scene, 0);
    scene
}

/// Moves the lamps, if the scene is that of [`scene`], to their places in a frame.
pub fn move_all(scene: &mut Scene, frame: u32) {
    let lamps: Vec<NodeId> = scene.roots.iter().copied().filter(|id| scene.node(*id).name == NAME).collect();
    for (i, lamp) in lamps.into_iter().enumerate() {
        // The golden angle spreads them evenly over the disc; the inner ones are the faster ones.
        let share = (i as f32 + 0.5) / LAMPS as f32;
        let angle_rad = 2.399_963 * i as f32 + 0.01 * frame as f32 / (0.2 + share);
        let (radius_m, height_m) = (12.0 * share.sqrt(), 0.35 + 0.2 * (3.0 * angle_rad).sin());
        scene.node_mut(lamp).translation = Vec3::new(radius_m * angle_rad.cos(), height_m, radius_m * angle_rad.sin());
    }
    scene.update_transforms();
}
