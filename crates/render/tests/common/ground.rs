//! What tests of the ground share: a body over it, a product shot, and levels of the display.

use glam::{Mat4, Vec3};
use manypass::{Background, FrameRequest, View};
use manypass_scene::framing::{Framing, orbit_rotation};
use manypass_scene::{Material, Mesh, Node, Primitive, Projection, Scene};

/// A body whose middle is so high.
pub fn scene_of(shape: Primitive, middle_m: f32) -> Scene {
    let mut scene = Scene::default();
    scene.materials.push(Material::default());
    let shape = Primitive { material: Some(0), ..shape };
    scene.meshes.push(Mesh { primitives: vec![shape], ..Mesh::default() }.into());
    scene.add_node(None, Node { mesh: Some(0), translation: Vec3::new(0.0, middle_m, 0.0), ..Node::default() });
    scene.update_transforms();
    scene
}

/// The request of a product shot on white: all of the scene, from a yaw and a pitch in degrees, by a camera that stands
/// where the automatic one would.
pub fn product_shot(scene: &Scene, (width, height): (u32, u32), [yaw_deg, pitch_deg]: [f32; 2]) -> FrameRequest {
    let framing = Framing::of_scene(scene);
    let rotation = orbit_rotation(yaw_deg, pitch_deg, Vec3::Y);
    let lens = Projection::Perspective { fov_y_rad: std::f32::consts::FRAC_PI_4, near_m: 0.01, far_m: None };
    let fit = framing.turning(framing.center_world(), Vec3::Y);
    let eye = fit.eye(rotation, lens.half_extent(width as f32 / height as f32));
    let mut request = FrameRequest::of_scene(scene, width, height);
    request.camera = View { world_from_view: Mat4::from_rotation_translation(rotation, eye), projection: lens };
    request.settings.background.source = Background::Color([1.0; 3]);
    request
}

/// The linear value of a byte of the display.
pub fn linear(byte: u8) -> f32 {
    let c = f32::from(byte) / 255.0;
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

/// The level of the display, up to 255 and not rounded, of a linear value.
pub fn encoded(linear: f32) -> f32 {
    255.0 * if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}
