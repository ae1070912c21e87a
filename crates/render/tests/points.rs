//! Points are discs that face the eye, of 1/200 of the picture's height and at least two pixels, in every pass.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{floats, ids, plain_request, renderer};
use glam::{Mat4, Quat, Vec3};
use manypass::{Aov, Averaging, FrameRequest, Path, Pose, Renderer, View};
use manypass_scene::{Camera, Material, Mesh, MorphTarget, Node, Primitive, Projection, Scene, ShadingModel, Topology};
use std::sync::Arc;

/// A narrow picture, so tall that a disc is 6 pixels wide.
const SIZE: (u32, u32) = (48, 1200);
const DIAMETER_PX: f32 = 6.0;

/// Bright points seen along −Z by a camera 5 m away whose picture is `height_m` high.
fn scene(height_m: f32, primitives: Vec<Primitive>) -> Scene {
    let mut scene = Scene::default();
    let projection = Projection::Orthographic { height_m, near_m: 0.1, far_m: 10.0 };
    scene.cameras.push(Camera { name: "camera".into(), projection, aspect: None });
    scene.add_node(None, Node { translation: Vec3::Z * 5.0, camera: Some(0), ..Node::default() });
    let mut material = Material { shading_model: ShadingModel::Unlit, ..Material::default() };
    material.base_color_factor = Vec3::ONE.extend(1.0);
    scene.materials.push(material);
    let primitives = primitives.into_iter().map(|primitive| Primitive {
        topology: Topology::Points,
        material: Some(0),
        bounds: manypass_scene::Aabb { min: Vec3::splat(-1.0), max: Vec3::splat(1.0) },
        ..primitive
    });
    scene.meshes.push(Mesh { primitives: primitives.collect(), ..Mesh::default() }.into());
    // A mirrored and turned object has the same points, not other discs.
    let rotation = Quat::from_rotation_y(2.0);
    let node = Node { mesh: Some(0), rotation, scale: Vec3::new(-1.0, 1.0, 1.0), ..Node::default() };
    scene.add_node(None, node);
    scene.update_transforms();
    scene
}

fn one_point(normals: Vec<[f32; 3]>) -> Primitive {
    Primitive { positions: vec![[0.0; 3]], normals, ..Primitive::default() }
}

/// The pixels that show the points, which are the second node.
fn covered(ids: &[u32], width: u32) -> Vec<(f32, f32)> {
    let shown = ids.iter().enumerate().filter(|(_, id)| **id == 2);
    shown.map(|(at, _)| ((at as u32 % width) as f32 + 0.5, (at as u32 / width) as f32 + 0.5)).collect()
}

fn request(scene: &Scene, size: (u32, u32), aovs: &[Aov]) -> FrameRequest {
    let mut request = plain_request(scene, size);
    request.want_aovs = aovs.to_vec();
    request
}

#[test]
fn a_point_is_a_disc_that_faces_the_eye() {
    let scene = scene(2.0, vec![one_point(Vec::new())]);
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let mut request = request(&scene, SIZE, &[Aov::ObjectId, Aov::Normal, Aov::Depth, Aov::Position]);
    renderer.render(&scene, &request).unwrap();
    let found = covered(&ids(renderer.read_aov(Aov::ObjectId).unwrap()), SIZE.0);
    let area = std::f32::consts::PI * (0.5 * DIAMETER_PX).powi(2);
    assert!((found.len() as f32 - area).abs() < 6.0, "{} pixels, not {area}", found.len());
    let middle = (SIZE.0 as f32 * 0.5, SIZE.1 as f32 * 0.5);
    let farthest = found.iter().map(|(x, y)| (x - middle.0).hypot(y - middle.1)).fold(0.0, f32::max);
    assert!(farthest <= 0.5 * DIAMETER_PX, "a square's corner would be 3.5 pixels off; found {farthest}");
    let (normal, depth) = (renderer.read_aov(Aov::Normal).unwrap(), renderer.read_aov(Aov::Depth).unwrap());
    let (normal, depth) = (floats(normal), floats(depth));
    for (x, y) in &found {
        let at = *y as usize * SIZE.0 as usize + *x as usize;
        assert!(normal[at * 3 + 2] > 0.999, "the normal faces the camera: {:?}", &normal[at * 3..at * 3 + 3]);
        assert!((depth[at] - 5.0).abs() < 1e-3, "{}", depth[at]);
    }
    let deferred = renderer.read_radiance().unwrap();
    assert_eq!(deferred.chunks(4).filter(|pixel| pixel[0] > 0.9).count(), found.len());
    request.settings.render.path = Path::Forward;
    request.want_aovs.clear();
    renderer.render(&scene, &request).unwrap();
    assert!(renderer.read_radiance().unwrap() == deferred, "forward draws the same discs");
}

#[test]
fn small_pictures_have_discs_of_two_pixels_and_indices_choose_points() {
    let mut morph = MorphTarget { positions: vec![[0.0, 4.0, 0.0]; 4], ..MorphTarget::default() };
    morph.positions[3] = [0.0, -4.0, 0.0];
    // In pixels of a picture of 64, each in the middle of four pixels; drawn are the second and the fourth, with
    // colours.
    let cloud = Primitive {
        positions: [-20.0, -10.0, 10.0, 20.0].map(|y: f32| [0.0, y, 0.0]).to_vec(),
        colors: [0.1, 0.2, 0.3, 0.4].map(|gray: f32| [gray, gray, gray, 1.0]).to_vec(),
        morph_targets: vec![morph],
        indices: vec![1, 3],
        ..Primitive::default()
    };
    let mut scene = scene(64.0, vec![cloud, one_point(vec![[0.0, 0.0, -1.0]])]);
    Arc::make_mut(&mut scene.meshes[0]).default_morph_weights = vec![1.0];
    // An object before them in the list of instances must not turn the corners of discs around.
    let corners = vec![[-30.0, -30.0, 0.0], [-20.0, -30.0, 0.0], [-30.0, -20.0, 0.0]];
    let bounds = manypass_scene::Aabb { min: Vec3::new(-30.0, -30.0, 0.0), max: Vec3::new(-20.0, -20.0, 0.0) };
    let triangle = Primitive { positions: corners, material: Some(0), bounds, ..Primitive::default() };
    scene.meshes.insert(0, Mesh { primitives: vec![triangle], ..Mesh::default() }.into());
    scene.nodes[1].mesh = Some(1);
    scene.add_node(None, Node { mesh: Some(0), ..Node::default() });
    scene.update_transforms();
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let request = request(&scene, (64, 64), &[Aov::ObjectId, Aov::Normal]);
    renderer.render(&scene, &request).unwrap();
    let mut rows: Vec<_> = covered(&ids(renderer.read_aov(Aov::ObjectId).unwrap()), 64);
    rows.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.total_cmp(&b.0)));
    let block = |y: f32| [(31.5, y - 0.5), (32.5, y - 0.5), (31.5, y + 0.5), (32.5, y + 0.5)];
    assert_eq!(rows, [block(16.0), block(32.0), block(38.0)].concat());
    assert_eq!(renderer.stats().triangles, 1, "the triangle is drawn");
    let radiance = renderer.read_radiance().unwrap();
    let gray = |y: usize| radiance[(y * 64 + 32) * 4];
    assert!((gray(16) - 0.4).abs() < 0.01 && (gray(38) - 0.2).abs() < 0.01 && gray(32) > 0.9);
    // A normal that points away is turned towards the camera.
    let normal = floats(renderer.read_aov(Aov::Normal).unwrap());
    assert!(normal[(32 * 64 + 32) * 3 + 2] > 0.4, "{:?}", &normal[(32 * 64 + 32) * 3..][..3]);
}

#[test]
fn the_motion_of_a_disc_is_that_of_its_surface() {
    let mut scene = scene(2.0, vec![one_point(Vec::new())]);
    let projection = Projection::Perspective { fov_y_rad: 0.4, near_m: 0.1, far_m: None };
    scene.cameras[0].projection = projection;
    let mut request = request(&scene, SIZE, &[Aov::ObjectId, Aov::Motion, Aov::Position]);
    let now = request.camera;
    let before = View {
        world_from_view: Mat4::from_rotation_translation(Quat::from_rotation_y(0.01), Vec3::new(0.04, 0.05, 4.0)),
        projection,
    };
    request.previous = Some(Arc::new(Pose::capture(&scene, before)));
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    renderer.render(&scene, &request).unwrap();
    let motion = floats(renderer.read_aov(Aov::Motion).unwrap());
    let position = floats(renderer.read_aov(Aov::Position).unwrap());
    let pixel_of = |view: &View, point: Vec3| {
        let p = view.world_from_view.inverse().transform_point3(point);
        let scale = 0.5 * SIZE.1 as f32 / (0.2f32.tan() * -p.z);
        (SIZE.0 as f32 * 0.5 + p.x * scale, SIZE.1 as f32 * 0.5 - p.y * scale)
    };
    let found = covered(&ids(renderer.read_aov(Aov::ObjectId).unwrap()), SIZE.0);
    assert!(found.len() > 20);
    for (x, y) in found {
        let at = y as usize * SIZE.0 as usize + x as usize;
        let point = Vec3::new(position[at * 3], position[at * 3 + 1], position[at * 3 + 2]);
        let (from, to) = (pixel_of(&before, point), pixel_of(&now, point));
        let error = (to.0 - from.0 - motion[at * 2]).hypot(to.1 - from.1 - motion[at * 2 + 1]);
        assert!(error < 0.02, "at {x}, {y}: {from:?} to {to:?}, motion {:?}", &motion[at * 2..at * 2 + 2]);
    }
}

/// The points of a wall.
const WALL_POINTS: u32 = 20_000;

/// A wall of 1.6 m by 1.2 m that is turned away a little, with colours that hardly change, of points in an order that
/// goes all over it (Roberts 2018, the R2 sequence); in primitives of so many.
fn wall(height_m: f32, of_primitive: usize) -> Scene {
    let places = (0..WALL_POINTS).map(|i| {
        let [x, y] = [0.754_877_666_2, 0.569_840_291].map(|step: f64| ((f64::from(i) * step).fract() - 0.5) as f32);
        [1.6 * x, 1.2 * y, 0.9 * x]
    });
    let positions: Vec<[f32; 3]> = places.collect();
    let primitives = positions.chunks(of_primitive).map(|positions| Primitive {
        positions: positions.to_vec(),
        colors: positions.iter().map(|[x, ..]| [0.4 + 0.1 * x, 0.4, 0.4, 1.0]).collect(),
        ..Primitive::default()
    });
    let mut scene = scene(height_m, primitives.collect());
    scene.nodes[1].rotation = Quat::IDENTITY;
    scene.update_transforms();
    scene
}

/// The picture, how many samples its pixels have on average, and how many points the last of them drew.
fn still(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> (Vec<u8>, f64, u64) {
    for sample_index in 0..request.sample_count {
        let request = FrameRequest { sample_index, ..request.clone() };
        if sample_index + 1 < request.sample_count {
            renderer.accumulate(scene, &request).unwrap();
        } else {
            renderer.render(scene, &request).unwrap();
        }
    }
    let points = renderer.stats().points;
    (renderer.read_display().unwrap(), renderer.read_samples_mean().unwrap(), points)
}

#[test]
fn points_on_settled_tiles_are_left_out_and_not_missed() {
    let scene = wall(2.0, WALL_POINTS as usize);
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let averaging = Averaging::Display;
    let request = FrameRequest { averaging, sample_count: 16, ..plain_request(&scene, (160, 120)) };
    let (picture, mean, points) = still(&mut renderer, &scene, &request);
    // A live view does not wait to find out which tiles are settled: it draws all points, and depth hides them there.
    let live = FrameRequest { goes_on: true, ..request.clone() };
    let (of_live, mean_of_live, points_of_live) = still(&mut renderer, &scene, &live);
    println!("{mean} samples, {points} points of {points_of_live}");
    assert!(picture == of_live && mean == mean_of_live && mean < 8.0, "{mean}, {mean_of_live}");
    assert_eq!(points_of_live, u64::from(WALL_POINTS));
    assert!(points > 0 && points < points_of_live * 3 / 4, "{points}");
    // Of a picture whose tiles all get all samples, none is left out.
    let whole = request.with(|settings| settings.adaptive.threshold = 0.0);
    assert_eq!(still(&mut renderer, &scene, &whole).2, u64::from(WALL_POINTS));
}

#[test]
fn points_beside_the_picture_are_left_out_of_clouds() {
    let pictures = [WALL_POINTS as usize, 2000].map(|of_primitive| {
        let scene = wall(0.4, of_primitive);
        let mut renderer = renderer();
        renderer.load(&scene).unwrap();
        renderer.render(&scene, &plain_request(&scene, (160, 120))).unwrap();
        (renderer.read_display().unwrap(), renderer.stats().points)
    });
    let [(cloud, points), (apart, points_apart)] = pictures;
    // Where discs lie at one distance, the last of them is seen, and the order is another.
    assert!(cloud.iter().zip(&apart).all(|(a, b)| a.abs_diff(*b) <= 1));
    assert!(cloud.chunks(4).any(|pixel| pixel[0] > 100) && cloud.chunks(4).any(|pixel| pixel[0] == 0));
    assert_eq!(points_apart, u64::from(WALL_POINTS));
    assert!(points < points_apart * 3 / 4, "{points}");
}
