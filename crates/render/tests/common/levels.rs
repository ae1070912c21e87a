//! What the tests of levels of detail share.

use glam::{Mat4, Vec3};
use manypass::{Background, Environment, FrameRequest, Ground, Renderer, View};
use manypass_scene::{Light, LightKind, Material, Mesh, Node, Primitive, Projection, Scene};
use manypass_testkit::compare::Picture;

/// Of both sides of a picture.
pub const SIDE: u32 = 256;

/// A mesh of a material of its own.
pub fn put(scene: &mut Scene, primitive: Primitive, color: Vec3) -> Node {
    scene.materials.push(Material {
        base_color_factor: color.extend(1.0),
        metallic_factor: 0.0,
        roughness_factor: 0.4,
        ..Material::default()
    });
    let material = Some(scene.materials.len() - 1);
    scene.meshes.push(Mesh { primitives: vec![Primitive { material, ..primitive }], ..Mesh::default() }.into());
    Node { mesh: Some(scene.meshes.len() - 1), ..Node::default() }
}

/// A sun, and nothing else.
pub fn lit() -> Scene {
    let mut scene = Scene::default();
    let kind = LightKind::Directional;
    scene.lights.push(Light { intensity: 3.0, kind, ..Light::default() });
    let rotation = glam::Quat::from_rotation_y(0.6) * glam::Quat::from_rotation_x(-0.5);
    scene.add_node(None, Node { rotation, light: Some(0), ..Node::default() });
    scene
}

/// Seen from the front, with a field of view of 30 degrees, at a distance.
pub fn request(distance_m: f32) -> FrameRequest {
    let projection = Projection::Perspective { fov_y_rad: std::f32::consts::FRAC_PI_6, near_m: 0.1, far_m: None };
    let camera = View { world_from_view: Mat4::from_translation(Vec3::Z * distance_m), projection };
    FrameRequest::new(SIDE, SIDE, camera).with(|settings| {
        settings.environment.source = Environment::Studio;
        settings.effects.enabled = false;
        settings.background.source = Background::Color([0.2; 3]);
        settings.tone_map.dither = 0.0;
        settings.lod.fade = 0.0;
        settings.ground.mode = Ground::None;
    })
}

/// The display colours.
pub fn picture(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Picture {
    renderer.render(scene, request).unwrap();
    Picture::from_rgba8(request.width as usize, request.height as usize, &renderer.read_display().unwrap())
}

/// Where a ball of 1 m covers that share of the picture.
pub fn distance_m(coverage: f32) -> f32 {
    outline_distance_m(coverage, SIDE * SIDE, SIDE, std::f32::consts::FRAC_PI_6)
}

/// How far from the eye a ball of 1 m covers a share of a picture of so many pixels: the half angle of the cone around
/// it has a tangent of as many pixels as its disc's radius, and a sine of one divided by the distance.
pub fn outline_distance_m(coverage: f32, pixels: u32, height_px: u32, fov_y_rad: f32) -> f32 {
    let radius_px = (coverage * pixels as f32 / std::f32::consts::PI).sqrt();
    let tangent = radius_px * 2.0 * (0.5 * fov_y_rad).tan() / height_px as f32;
    1.0 / tangent.atan().sin()
}
