//! How surfaces are drawn: their order where they are blended, which side of them is the front, and what lights them.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{floats, ids, plain_request, renderer};
use glam::{Mat4, Quat, Vec3};
use manypass::{Aov, Environment, FrameRequest, Path, Renderer};
use manypass_scene::{
    Aabb, AlphaMode, Camera, Image, ImageSource, Light, LightKind, Material, Mesh, Node, NodeId, PixelFormat, Pixels,
    Primitive, Projection, Sampler, Scene, ShadingModel, Skin, Texture, TextureRef, TextureTransform, Topology,
    primitives,
};

const SIZE: (u32, u32) = (16, 16);

const PARALLEL: Projection = Projection::Orthographic { height_m: 2.0, near_m: 0.1, far_m: 20.0 };
const PERSPECTIVE: Projection = Projection::Perspective { fov_y_rad: 0.4, near_m: 0.1, far_m: None };

/// A scene with a camera at +Z that looks along −Z from 5 m.
fn scene(projection: Projection) -> Scene {
    let mut scene = Scene::default();
    scene.cameras.push(Camera { name: "camera".into(), projection, aspect: None });
    scene.add_node(None, Node { translation: Vec3::Z * 5.0, camera: Some(0), ..Node::default() });
    scene
}

fn put(scene: &mut Scene, mut primitive: Primitive, material: Material, node: Node) -> NodeId {
    primitive.material = Some(scene.materials.len());
    primitive.bounds = Aabb::from_points(primitive.positions.iter().copied().map(Vec3::from));
    scene.materials.push(material);
    scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() }.into());
    scene.add_node(None, Node { mesh: Some(scene.meshes.len() - 1), ..node })
}

fn unlit() -> Material {
    Material { shading_model: ShadingModel::Unlit, ..Material::default() }
}

/// A square of 1 m across the view axis at a height z, of one colour, that faces +Z or −Z.
fn square(z: f32, color: [f32; 3], faces_eye: bool) -> Primitive {
    let corner = |x: f32, y: f32| [x, y, z];
    let [r, g, b] = color;
    Primitive {
        positions: vec![corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.5, 0.5), corner(-0.5, 0.5)],
        normals: vec![[0.0, 0.0, if faces_eye { 1.0 } else { -1.0 }]; 4],
        colors: vec![[r, g, b, 0.5]; 4],
        indices: if faces_eye { vec![0, 1, 2, 0, 2, 3] } else { vec![0, 2, 1, 0, 3, 2] },
        ..Primitive::default()
    }
}

fn joined(mut first: Primitive, second: Primitive) -> Primitive {
    let offset = first.positions.len() as u32;
    first.positions.extend(second.positions);
    first.normals.extend(second.normals);
    first.colors.extend(second.colors);
    first.indices.extend(second.indices.into_iter().map(|index| index + offset));
    first
}

/// Radiance of one pixel.
fn pixel(renderer: &mut Renderer, x: u32, y: u32) -> [f32; 4] {
    let at = ((y * SIZE.0 + x) * 4) as usize;
    renderer.read_radiance().unwrap()[at..at + 4].try_into().unwrap()
}

fn middle(scene: &mut Scene, change: impl Fn(&mut FrameRequest)) -> [f32; 4] {
    scene.update_transforms();
    let mut renderer = renderer();
    renderer.load(scene).unwrap();
    let mut request = plain_request(scene, SIZE);
    change(&mut request);
    renderer.render(scene, &request).unwrap();
    pixel(&mut renderer, SIZE.0 / 2, SIZE.1 / 2)
}

fn assert_near(found: [f32; 4], expected: [f32; 3]) {
    let is_near = (0..3).all(|c| (found[c] - expected[c]).abs() < 0.004);
    assert!(is_near, "{found:?}, expected {expected:?}");
}

const RED: [f32; 3] = [1.0, 0.0, 0.0];
const GREEN: [f32; 3] = [0.0, 1.0, 0.0];
/// Half red over half green over black.
const RED_OVER_GREEN: [f32; 3] = [0.5, 0.25, 0.0];

fn blended() -> Material {
    Material { alpha_mode: AlphaMode::Blend, ..unlit() }
}

#[test]
fn blended_surfaces_are_sorted_under_parallel_rays_too() {
    for projection in [PERSPECTIVE, PARALLEL] {
        let panes = [square(1.0, RED, true), square(-1.0, GREEN, true)];
        for order in [[0, 1], [1, 0]] {
            let mut scene = scene(projection);
            for index in order {
                put(&mut scene, panes[index].clone(), blended(), Node::default());
            }
            assert_near(middle(&mut scene, |_| ()), RED_OVER_GREEN);
        }
    }
}

#[test]
fn skinned_surfaces_are_blended_in_the_order_of_their_poses() {
    // The node of a skinned mesh places nothing, nor does the place of its vertices before the pose.
    let mut scene = scene(PERSPECTIVE);
    let mut pane = square(-3.0, RED, true);
    (pane.joints, pane.weights) = (vec![[0; 4]; 4], vec![[1.0, 0.0, 0.0, 0.0]; 4]);
    let joint = scene.add_node(None, Node { translation: Vec3::Z * 4.0, ..Node::default() });
    scene.skins.push(Skin { joints: vec![joint], inverse_bind_matrices: vec![Mat4::IDENTITY] });
    put(&mut scene, pane, blended(), Node { skin: Some(0), ..Node::default() });
    put(&mut scene, square(-1.0, GREEN, true), blended(), Node::default());
    assert_near(middle(&mut scene, |_| ()), RED_OVER_GREEN);
}

#[test]
fn back_faces_of_double_sided_blended_surfaces_lie_behind_front_faces() {
    let double_sided = Material { double_sided: true, ..blended() };
    for scale in [Vec3::ONE, Vec3::new(-1.0, 1.0, 1.0)] {
        // The nearer square comes first in the order of indices. A solid's front faces are those nearer to the eye.
        let solid = joined(square(0.4, RED, true), square(-0.4, GREEN, false));
        let mut scene = scene(PARALLEL);
        put(&mut scene, solid.clone(), double_sided.clone(), Node { scale, ..Node::default() });
        assert_near(middle(&mut scene, |_| ()), RED_OVER_GREEN);
        // Seen from behind the faces change their places.
        let rotation = Quat::from_rotation_y(std::f32::consts::PI);
        let node = scene.roots[1];
        scene.node_mut(node).rotation = rotation;
        assert_near(middle(&mut scene, |_| ()), [0.25, 0.5, 0.0]);
    }
}

#[test]
fn mirrored_joints_turn_no_skin_inside_out() {
    let mut renderer = renderer();
    let mut normals_of = |node_scale: Vec3, joint_scale: Vec3, is_skinned: bool| {
        let mut scene = scene(PERSPECTIVE);
        let joint = scene.add_node(None, Node { scale: joint_scale, ..Node::default() });
        scene.skins.push(Skin { joints: vec![joint], inverse_bind_matrices: vec![Mat4::IDENTITY] });
        let mut ball = primitives::uv_sphere(0.6, 24, 12);
        let count = ball.positions.len();
        (ball.joints, ball.weights) = (vec![[0; 4]; count], vec![[1.0, 0.0, 0.0, 0.0]; count]);
        let node = Node { skin: is_skinned.then_some(0), scale: node_scale, ..Node::default() };
        put(&mut scene, ball, Material::default(), node);
        scene.update_transforms();
        renderer.load(&scene).unwrap();
        let mut request = plain_request(&scene, SIZE);
        request.want_aovs = vec![Aov::Normal, Aov::Depth];
        renderer.render(&scene, &request).unwrap();
        let at = (SIZE.1 / 2 * SIZE.0 + SIZE.0 / 2) as usize;
        let depth_m = floats(renderer.read_aov(Aov::Depth).unwrap())[at];
        (depth_m, floats(renderer.read_aov(Aov::Normal).unwrap())[at * 3 + 2])
    };
    let mirror = Vec3::new(-1.0, 1.0, 1.0);
    for (node_scale, joint_scale, is_skinned) in
        [(Vec3::ONE, Vec3::ONE, true), (mirror, Vec3::ONE, false), (Vec3::ONE, mirror, true), (mirror, Vec3::ONE, true)]
    {
        let (depth_m, normal_z) = normals_of(node_scale, joint_scale, is_skinned);
        // The near side of the ball, 4.4 m away; inside out it would be the far side, at 5.6 m.
        assert!(
            (depth_m - 4.4).abs() < 0.05,
            "node {node_scale}, joint {joint_scale}, skinned {is_skinned}: {depth_m}"
        );
        assert!(normal_z > 0.9, "node {node_scale}, joint {joint_scale}, skinned {is_skinned}: {normal_z}");
    }
}

/// A bundle of lines, or a cloud of points, that covers the middle of the picture, at a distance of 5 m.
fn bundle(topology: Topology) -> Primitive {
    let step = 2.0 / SIZE.1 as f32;
    let rows = (0..SIZE.1).map(|row| (row as f32 + 0.5) * step - 1.0);
    let positions = match topology {
        Topology::Points => {
            rows.flat_map(|y| (0..SIZE.0).map(move |column| [(column as f32 + 0.5) * step - 1.0, y, 0.0])).collect()
        }
        _ => rows.flat_map(|y| [[-1.0, y, 0.0], [1.0, y, 0.0]]).collect(),
    };
    Primitive { topology, positions, ..Primitive::default() }
}

#[test]
fn points_and_lines_without_normals_show_base_color_and_emission_and_take_no_light() {
    let base_color = Vec3::new(0.5, 0.25, 0.125);
    let emissive_factor = Vec3::new(0.0, 0.25, 0.5);
    for topology in [Topology::Points, Topology::Lines] {
        for path in [Path::Deferred, Path::Forward] {
            for has_normals in [false, true] {
                let mut bundle = bundle(topology);
                if has_normals {
                    bundle.normals = vec![[0.0, 0.0, 1.0]; bundle.positions.len()];
                }
                let material = Material { base_color_factor: base_color.extend(1.0), emissive_factor, ..unlit() };
                let lit = Material { shading_model: ShadingModel::Standard, metallic_factor: 0.0, ..material };
                let mut scene = scene(PARALLEL);
                put(&mut scene, bundle, lit, Node::default());
                let kind = LightKind::Directional;
                scene.lights.push(Light {
                    color_linear: Vec3::ONE,
                    intensity: 9.0,
                    range_m: None,
                    kind,
                    ..Light::default()
                });
                scene.add_node(None, Node { light: Some(0), ..Node::default() });
                let found = middle(&mut scene, |request| {
                    request.settings.render.path = path;
                    request.settings.environment.source = Environment::Studio;
                });
                if has_normals {
                    assert!(found[0] > 1.0, "{topology:?}, {path:?}: with normals light falls on it: {found:?}");
                } else {
                    println!("{topology:?}, {path:?}");
                    assert_near(found, (base_color + emissive_factor).to_array());
                }
            }
        }
    }
}

#[test]
fn what_has_no_normals_is_known_by_its_ids() {
    let mut scene = scene(PARALLEL);
    put(&mut scene, bundle(Topology::Lines), Material::default(), Node::default());
    scene.update_transforms();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let request = FrameRequest { want_aovs: vec![Aov::ObjectId], ..plain_request(&scene, SIZE) };
    renderer.render(&scene, &request).unwrap();
    assert_eq!(ids(renderer.read_aov(Aov::ObjectId).unwrap())[(SIZE.1 / 2 * SIZE.0 + SIZE.0 / 2) as usize], 2);
}

#[test]
fn a_normal_map_without_tangents_does_nothing() {
    let mut scene = scene(PARALLEL);
    let pixels = Pixels { width: 1, height: 1, format: PixelFormat::Rgba8, data: vec![230, 60, 200, 255] };
    scene.images.push(Image { name: String::new(), source: ImageSource::Pixels(pixels.into()) });
    scene.textures.push(Texture { image: 0, sampler: Sampler::default() });
    let normal_texture = Some(TextureRef { texture: 0, uv_set: 0, transform: TextureTransform::default() });
    let material = Material { normal_texture, ..Material::default() };
    put(&mut scene, square(0.0, [1.0; 3], true), material, Node::default());
    scene.update_transforms();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let mut request = plain_request(&scene, SIZE);
    request.want_aovs = vec![Aov::Normal];
    renderer.render(&scene, &request).unwrap();
    let normals = floats(renderer.read_aov(Aov::Normal).unwrap());
    let at = (8 * SIZE.0 as usize + 8) * 3;
    let found = Vec3::from_slice(&normals[at..at + 3]);
    assert!(found.abs_diff_eq(Vec3::Z, 1e-3), "{found}");
}
