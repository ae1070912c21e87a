//! Triangles against exact shapes and numbers that are known.

use super::super::*;
use crate::build::{SceneBuilder, at};
use crate::scenes;
use glam::{Mat4, Vec2, Vec3};
use manypass_scene::{
    AlphaMode, Image, ImageSource, Material, MorphTarget, Node, PixelFormat, Pixels, Projection, Scene, ShadingModel,
    Skin, Texture, TextureRef, TextureTransform, primitives,
};

#[test]
fn meshes_look_like_the_shapes_that_they_stand_for() {
    for test in scenes::all() {
        let options = Options { shadows: true, ..Options::default() };
        let exact = test.world.render(64, 48, options);
        let world = World::of_scene(&test.scene, test.world.camera);
        for (found, exact) in world.lights.iter().zip(&test.world.lights) {
            // Rotations of nodes are `f32`.
            assert!(found.direction_world.distance(exact.direction_world) < 1e-6, "{}", test.name);
            assert_eq!(&Light { direction_world: exact.direction_world, ..found.clone() }, exact, "{}", test.name);
        }
        let found = world.render(64, 48, options);
        let mean = exact.radiance.iter().flatten().sum::<f32>() / (3 * exact.radiance.len()) as f32;
        let near = |a: &[f32; 3], b: &[f32; 3]| (0..3).all(|c| (a[c] - b[c]).abs() <= 0.01 * a[c].max(0.1 * mean));
        let good = exact.radiance.iter().zip(&found.radiance).filter(|(a, b)| near(a, b)).count();
        // Others are the rims of spheres and of their shadows.
        assert!(good as f64 > 0.96 * exact.radiance.len() as f64, "{}: {good} pixels agree", test.name);
        let seen = |frame: &Frame| frame.object_id.iter().filter(|id| **id > 0).count();
        assert!(seen(&exact).abs_diff(seen(&found)) < 40);
    }
}

/// What a camera above the origin sees straight below, in parallel rays, in the middle of the picture.
fn seen_from_above(builder: SceneBuilder) -> [f32; 3] {
    let scene = builder.finish();
    let world = World::of_scene(&scene, Camera::of_scene(&scene).unwrap());
    let frame = world.render(3, 3, Options::default());
    frame.radiance[4]
}

fn above() -> SceneBuilder {
    let projection = Projection::Orthographic { height_m: 0.3, near_m: 0.1, far_m: 100.0 };
    SceneBuilder::new(10.0 * Vec3::Y, Vec3::ZERO, projection)
}

/// A surface that shows a colour whatever light there is.
fn glowing(red: f32, green: f32, blue: f32, alpha: f32) -> Material {
    Material {
        base_color_factor: glam::Vec4::new(red, green, blue, alpha),
        shading_model: ShadingModel::Unlit,
        ..Material::default()
    }
}

fn upside_down(y: f32) -> Node {
    Node { rotation: glam::Quat::from_rotation_x(std::f32::consts::PI), ..at(Vec3::Y * y) }
}

#[test]
fn backs_are_seen_of_double_sided_surfaces_alone() {
    let mut builder = above();
    builder.put(primitives::plane(1.0), glowing(0.0, 0.0, 1.0, 1.0), at(Vec3::ZERO));
    builder.put(primitives::plane(1.0), glowing(1.0, 0.0, 0.0, 1.0), upside_down(1.0));
    assert_eq!(seen_from_above(builder.clone()), [0.0, 0.0, 1.0]);
    let double_sided = Material { double_sided: true, ..glowing(1.0, 0.0, 0.0, 1.0) };
    builder.put(primitives::plane(1.0), double_sided, upside_down(0.5));
    assert_eq!(seen_from_above(builder.clone()), [1.0, 0.0, 0.0]);
    // A mirrored node keeps its front where its normals are.
    let mirrored = Node { scale: Vec3::new(-1.0, 1.0, 1.0), ..at(2.0 * Vec3::Y) };
    let id = builder.put(primitives::plane(1.0), glowing(0.0, 1.0, 0.0, 1.0), mirrored);
    assert_eq!(seen_from_above(builder.clone()), [0.0, 1.0, 0.0]);
    builder.scene.node_mut(id).is_visible = false;
    assert_eq!(seen_from_above(builder), [1.0, 0.0, 0.0]);
}

#[test]
fn alpha_covers_once_even_along_the_edge_of_two_triangles() {
    let mut builder = above();
    builder.put(primitives::plane(1.0), glowing(0.0, 0.0, 1.0, 1.0), at(Vec3::ZERO));
    let blended = |red, green, alpha| Material { alpha_mode: AlphaMode::Blend, ..glowing(red, green, 0.0, alpha) };
    builder.put(primitives::plane(1.0), blended(1.0, 0.0, 0.5), at(0.2 * Vec3::Y));
    builder.put(primitives::plane(1.0), blended(0.0, 1.0, 0.25), at(0.1 * Vec3::Y));
    // The ray goes through the middle of all squares, where their diagonals are.
    assert_eq!(seen_from_above(builder), [0.5, 0.125, 0.375]);
}

#[test]
fn textures_color_and_cut_surfaces() {
    let mut builder = above();
    let data = vec![255, 255, 255, 255, 255, 255, 255, 0];
    let pixels = Pixels { width: 2, height: 1, format: PixelFormat::Rgba8, data };
    builder.scene.images.push(Image { name: String::new(), source: ImageSource::Pixels(pixels.into()) });
    let sampler = manypass_scene::Sampler { mag_linear: false, ..Default::default() };
    builder.scene.textures.push(Texture { image: 0, sampler });
    let transform = TextureTransform { offset: Vec2::new(-0.1, 0.0), ..TextureTransform::default() };
    let base_color_texture = Some(TextureRef { texture: 0, uv_set: 0, transform });
    let alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
    let masked = Material { base_color_texture, alpha_mode, ..glowing(1.0, 0.5, 0.25, 1.0) };
    builder.put(primitives::plane(1.0), glowing(0.0, 0.0, 1.0, 1.0), at(Vec3::ZERO));
    let id = builder.put(primitives::plane(1.0), masked, at(Vec3::Y));
    // The middle has u = 0.5, which the transform makes 0.4.
    assert_eq!(seen_from_above(builder.clone()), [1.0, 0.5, 0.25]);
    builder.scene.node_mut(id).translation.x = -0.2;
    assert_eq!(seen_from_above(builder), [0.0, 0.0, 1.0]);
}

#[test]
fn meshes_are_posed_by_weights_and_joints() {
    let mut plane = primitives::plane(1.0);
    let count = plane.positions.len();
    plane.morph_targets.push(MorphTarget { positions: vec![[0.0, 2.0, 0.0]; count], ..MorphTarget::default() });
    plane.joints = vec![[0, 1, 0, 0]; count];
    plane.weights = vec![[0.25, 0.75, 0.0, 0.0]; count];
    let mut builder = above();
    let node = Node { morph_weights: vec![0.5], ..at(Vec3::X * 50.0) };
    let id = builder.put(plane, glowing(1.0, 1.0, 1.0, 1.0), node);
    let joints = [0.0, 4.0].map(|y| builder.scene.add_node(None, at(Vec3::Y * y))).to_vec();
    let down = Mat4::from_translation(Vec3::NEG_Y * 0.25);
    builder.scene.skins.push(Skin { joints, inverse_bind_matrices: vec![down; 2] });
    builder.scene.node_mut(id).skin = Some(0);
    let scene = builder.finish();
    let world = World::of_scene(&scene, Camera::of_scene(&scene).unwrap());
    let frame = world.render(3, 3, Options::default());
    // Morphed by 0.5 · 2, moved by the joints' 0.75 · 4 and their bind pose; the node's own place does not count.
    assert!((frame.position_world[4].y - (1.0 + 3.0 - 0.25)).abs() < 1e-6, "{}", frame.position_world[4]);
    assert_eq!(frame.object_id[4], id.0 + 1);
}

#[test]
fn an_empty_scene_is_black() {
    let camera = Camera {
        position_world: DVec3::ZERO,
        world_from_view: glam::DQuat::IDENTITY,
        lens: Lens::Perspective { fov_y_rad: 1.0 },
    };
    let frame =
        World::of_scene(&Scene::default(), camera).render(4, 4, Options { shadows: true, ..Options::default() });
    assert!(
        frame.radiance.iter().all(|pixel| *pixel == [0.0; 3])
            && frame.depth_view_m.iter().all(|depth| depth.is_infinite())
    );
}
