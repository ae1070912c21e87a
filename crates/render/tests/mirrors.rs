//! Flat mirrors: the picture of the mirrored camera, mirrors within mirrors, rough ones against rays, and what is not
//! drawn.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{plain_request, renderer};
use glam::{Mat4, Quat, Vec3, Vec4};
use manypass::{Averaging, FrameRequest, Path, Renderer, View};
use manypass_scene::capture::Mirror;
use manypass_scene::framing::look_along;
use manypass_scene::primitives::{plane, uv_sphere};
use manypass_scene::{Camera, Material, Mesh, Node, NodeId, Primitive, Projection, Scene, ShadingModel};
use manypass_testkit::scenes;
use std::f32::consts::TAU;

const SIZE: (u32, u32) = (96, 72);

fn polished(roughness: f32) -> Material {
    Material { base_color_factor: Vec4::ONE, metallic_factor: 1.0, roughness_factor: roughness, ..Material::default() }
}

/// Adds a square mirror of a size around a place, which faces along a direction.
fn add_mirror(
    scene: &mut Scene,
    name: &str,
    (center, facing, size_m): (Vec3, Vec3, f32),
    material: Material,
) -> NodeId {
    scene.materials.push(material);
    let square = Primitive { material: Some(scene.materials.len() - 1), ..plane(1.0) };
    scene.meshes.push(Mesh { primitives: vec![square], ..Mesh::default() }.into());
    let rotation = Quat::from_rotation_arc(Vec3::Y, facing.normalize());
    let node = Node {
        name: name.into(),
        mesh: Some(scene.meshes.len() - 1),
        translation: center,
        rotation,
        scale: Vec3::splat(size_m),
        ..Node::default()
    };
    let id = scene.add_node(None, node);
    scene.mirrors.push(Mirror::new(name, id));
    scene.update_transforms();
    id
}

/// The camera mirrored in the plane of a mirror.
fn mirrored(view: View, (center, facing): (Vec3, Vec3)) -> (View, Vec4) {
    let normal = facing.normalize();
    let plane = normal.extend(-normal.dot(center));
    let across = |axis: Vec3| (axis - 2.0 * normal.dot(axis) * normal).extend(0.0);
    let matrix =
        Mat4::from_cols(across(Vec3::X), across(Vec3::Y), across(Vec3::Z), (-2.0 * plane.w * normal).extend(1.0));
    (View { world_from_view: matrix * view.world_from_view, ..view }, plane)
}

fn radiance(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<f32> {
    for sample_index in 0..request.sample_count {
        renderer.render(scene, &FrameRequest { sample_index, ..request.clone() }).unwrap();
    }
    renderer.read_radiance().unwrap()
}

/// A scene with a large mirror behind it.
fn scene_with_mirror() -> (Scene, FrameRequest, (Vec3, Vec3)) {
    let mut scene = scenes::rows_of_spheres().scene;
    let request = plain_request(&scene, SIZE);
    let View { world_from_view, .. } = request.camera;
    let back = world_from_view.z_axis.truncate();
    let right = world_from_view.x_axis.truncate();
    let (center, facing) = (Vec3::new(0.0, 1.2, -1.5), (back + 0.2 * right).normalize());
    add_mirror(&mut scene, "mirror", (center, facing, 40.0), polished(0.0));
    (scene, request, (center, facing))
}

#[test]
fn a_flat_mirror_shows_what_the_mirrored_camera_sees() {
    let (scene, request, place) = scene_with_mirror();
    let mut renderer = renderer();
    for path in [Path::Deferred, Path::Forward, Path::ForwardBatched] {
        for (sample_count, f_stop) in [(1, 0.0), (4, 0.0), (4, 0.25)] {
            let request = FrameRequest {
                sample_count,
                averaging: Averaging::Both,
                ..request.with(|settings| {
                    settings.render.path = path;
                    settings.camera.f_stop = f_stop;
                    settings.camera.focus_m = 7.0;
                })
            };
            let shown = radiance(&mut renderer, &scene, &request);
            assert_eq!((renderer.stats().captures, renderer.stats().captures_left_out), (1, 0));
            let off = request.with(|settings| settings.captures.enabled = false);
            let without = radiance(&mut renderer, &scene, &off);
            assert_eq!(renderer.stats().captures, 0);
            // Where the mirror is seen.
            let mut glowing = scene.clone();
            glowing.materials.last_mut().unwrap().emissive_factor = Vec3::splat(1000.0);
            let mask = radiance(&mut renderer, &glowing, &off);
            // What the mirrored camera sees before the mirror's plane, at the same places of its picture.
            let (camera, plane) = mirrored(request.camera, place);
            let clip_plane_world = Some(plane - Vec4::W * 4e-3);
            let truth = radiance(&mut renderer, &scene, &FrameRequest { camera, clip_plane_world, ..off.clone() });
            let (mut count, mut off_by, mut lit) = (0, 0, 0);
            for at in 0..(SIZE.0 * SIZE.1) as usize {
                let [shown, without, truth, mask] = [&shown, &without, &truth, &mask].map(|of| &of[4 * at..4 * at + 3]);
                if mask[0] > 999.0 {
                    count += 1;
                    // Lamps themselves have no images; their highlights are on the mirror, as they are without.
                    let expected = truth.iter().zip(without).map(|(a, b)| a + b);
                    let difference = shown.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                    off_by += usize::from(difference > 1.0 / 255.0 * shown.iter().fold(1.0f32, |a, b| a.max(*b)));
                    lit += usize::from(truth.iter().any(|value| *value > 0.02));
                } else if mask[0] < 10.0 && shown.iter().zip(without).any(|(a, b)| (a - b).abs() > 0.01) {
                    off_by += 1;
                }
            }
            assert!(count > 1500 && lit > 200, "{path:?}: {count} pixels of the mirror, {lit} lit");
            assert!(off_by * 100 <= count, "{path:?}, {sample_count} samples, {f_stop}: {off_by} of {count} are off");
        }
    }
    // Gouraud shading has none.
    radiance(&mut renderer, &scene, &request.with(|settings| settings.render.path = Path::Gouraud));
    assert_eq!((renderer.stats().captures, renderer.stats().captures_left_out), (0, 1));
}

#[test]
fn mirrors_that_are_not_seen_cost_nothing() {
    let (mut scene, request, (center, facing)) = scene_with_mirror();
    let mut renderer = renderer();
    let captures = |renderer: &mut Renderer, scene: &Scene, request: &FrameRequest| {
        radiance(renderer, scene, request);
        (renderer.stats().captures, renderer.stats().captures_left_out)
    };
    let away = View {
        world_from_view: request.camera.world_from_view * Mat4::from_rotation_y(std::f32::consts::PI),
        ..request.camera
    };
    assert_eq!(captures(&mut renderer, &scene, &FrameRequest { camera: away, ..request.clone() }), (0, 1));
    // From behind; and in its plane.
    let from = |eye: Vec3, target: Vec3| View {
        world_from_view: Mat4::from_rotation_translation(look_along(target - eye, Vec3::Y).unwrap(), eye),
        ..request.camera
    };
    let behind = from(center - 5.0 * facing, center);
    assert_eq!(captures(&mut renderer, &scene, &FrameRequest { camera: behind, ..request.clone() }), (0, 1));
    let edge_on = from(center + 25.0 * facing.cross(Vec3::Y).normalize(), center);
    assert_eq!(captures(&mut renderer, &scene, &FrameRequest { camera: edge_on, ..request.clone() }), (0, 1));
    scene.materials.last_mut().unwrap().double_sided = true;
    assert_eq!(captures(&mut renderer, &scene, &FrameRequest { camera: behind, ..request.clone() }), (1, 0));
    let node = scene.mirrors[0].node;
    scene.node_mut(node).is_visible = false;
    assert_eq!(captures(&mut renderer, &scene, &request).0, 0);
}

/// The connected parts of a picture that are bright.
fn blobs(radiance: &[f32], (width, height): (u32, u32)) -> usize {
    let mut left: Vec<bool> = radiance.chunks_exact(4).map(|pixel| pixel[0] > 0.3).collect();
    let mut count = 0;
    while let Some(start) = left.iter().position(|is_left| *is_left) {
        count += 1;
        let mut open = vec![start];
        while let Some(at) = open.pop() {
            if !std::mem::take(&mut left[at]) {
                continue;
            }
            let (x, y) = (at as i64 % i64::from(width), at as i64 / i64::from(width));
            for (dx, dy) in [(-1, 0), (1, 0), (0, -1), (0, 1)] {
                let (x, y) = (x + dx, y + dy);
                if x >= 0
                    && y >= 0
                    && x < i64::from(width)
                    && y < i64::from(height)
                    && left[(y * i64::from(width) + x) as usize]
                {
                    open.push((y * i64::from(width) + x) as usize);
                }
            }
        }
    }
    count
}

#[test]
fn mirrors_in_mirrors_end_at_the_stated_depth() {
    let mut scene = Scene::default();
    scene.materials.push(Material {
        emissive_factor: Vec3::ONE,
        base_color_factor: Vec3::ZERO.extend(1.0),
        ..Material::default()
    });
    let ball = Primitive { material: Some(0), ..uv_sphere(0.06, 24, 12) };
    scene.meshes.push(Mesh { primitives: vec![ball], ..Mesh::default() }.into());
    scene.add_node(None, Node { mesh: Some(0), translation: Vec3::new(0.0, -0.5, -1.0), ..Node::default() });
    scene.cameras.push(Camera {
        name: String::new(),
        projection: Projection::Perspective { fov_y_rad: 1.2, near_m: 0.01, far_m: None },
        aspect: None,
    });
    // Between two mirrors that face each other, from above, so that images rise towards the horizon.
    let rotation = Quat::from_rotation_x(-0.25);
    scene.add_node(None, Node { camera: Some(0), translation: Vec3::new(0.0, 0.6, 1.2), rotation, ..Node::default() });
    add_mirror(&mut scene, "front", (Vec3::new(0.0, 0.0, -2.0), Vec3::Z, 6.0), polished(0.0));
    add_mirror(&mut scene, "back", (Vec3::new(0.0, 0.0, 2.0), Vec3::NEG_Z, 6.0), polished(0.0));
    let mut request = plain_request(&scene, (480, 360));
    let mut renderer = renderer();
    for depth in 1..=4 {
        request.settings.captures.depth = depth;
        let picture = radiance(&mut renderer, &scene, &request);
        // The ball, and an image for each mirror on the way.
        assert_eq!(blobs(&picture, (480, 360)) as u32, 1 + depth, "depth {depth}");
        assert_eq!(renderer.stats().captures, depth);
        let names: Vec<String> =
            renderer.plan(&scene, &request).unwrap().passes.iter().map(|pass| pass.name.to_string()).collect();
        let deepest =
            ["mirror/front", "mirror/back"].iter().cycle().take(depth as usize).copied().collect::<Vec<_>>().join("/");
        assert!(names.contains(&format!("{deepest}/geometry")), "{deepest}: {names:?}");
        assert_eq!(radiance(&mut renderer, &scene, &request), picture, "the same again is another picture");
    }
}

/// Black, and white where squares of a chequer are.
fn chequer_at(x: f32, y: f32) -> f32 {
    let square = |at: f32| (at / 0.25).floor() as i64;
    if (square(x) + square(y)).rem_euclid(2) == 0 { 1.0 } else { 0.05 }
}

/// A mirror in the plane z = 0 over a chequered floor that touches it, before a chequered wall 2 m away from it.
fn before_chequers(roughness: f32) -> Scene {
    let mut scene = Scene::default();
    for level in [1.0, 0.05] {
        scene.materials.push(Material {
            base_color_factor: Vec3::splat(level).extend(1.0),
            shading_model: ShadingModel::Unlit,
            double_sided: true,
            ..Material::default()
        });
    }
    let mut squares = [Primitive::default(), Primitive::default()];
    let mut add = |white: bool, corners: [Vec3; 4]| {
        let primitive = &mut squares[usize::from(!white)];
        let first = primitive.positions.len() as u32;
        primitive.positions.extend(corners.map(|corner| corner.to_array()));
        primitive.normals.extend([[0.0, 1.0, 0.0]; 4]);
        primitive.indices.extend([0, 1, 2, 2, 3, 0].map(|index| first + index));
    };
    for i in -40..40 {
        for j in 0..40 {
            let (x, y) = (i as f32 * 0.25, j as f32 * 0.25);
            let white = chequer_at(x + 0.1, y + 0.1) > 0.5;
            if j < 8 {
                let floor = [(0.0, 0.0), (0.25, 0.0), (0.25, 0.25), (0.0, 0.25)];
                add(white, floor.map(|(s, t)| Vec3::new(x + s, 0.0, y + t)));
            }
            let wall = [(0.0, 0.0), (0.25, 0.0), (0.25, 0.25), (0.0, 0.25)];
            add(white, wall.map(|(s, t)| Vec3::new(x + s, y + t, 2.0)));
        }
    }
    for (material, mut primitive) in squares.into_iter().enumerate() {
        primitive.material = Some(material);
        primitive.bounds = manypass_scene::Aabb::from_points(primitive.positions.iter().copied().map(Vec3::from));
        scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() }.into());
        scene.add_node(None, Node { mesh: Some(material), ..Node::default() });
    }
    add_mirror(&mut scene, "mirror", (Vec3::new(0.0, 2.0, 0.0), Vec3::Z, 4.0), polished(roughness));
    scene.cameras.push(Camera {
        name: String::new(),
        projection: Projection::Perspective { fov_y_rad: 0.8, near_m: 0.01, far_m: None },
        aspect: None,
    });
    let rotation = look_along(Vec3::new(0.15, 0.55, 0.0) - Vec3::new(0.3, 0.9, 1.6), Vec3::Y).unwrap();
    scene.add_node(None, Node { camera: Some(0), translation: Vec3::new(0.3, 0.9, 1.6), rotation, ..Node::default() });
    scene.update_transforms();
    scene
}

/// What a pixel of that mirror reflects, by many rays to visible normals of GGX, weighted by how much of each gets out.
fn by_rays(point: Vec3, to_eye: Vec3, roughness: f32, count: u32) -> f32 {
    let alpha = roughness * roughness;
    let a2 = alpha * alpha;
    let stretched = Vec3::new(alpha * to_eye.x, alpha * to_eye.y, to_eye.z).normalize();
    let (mut sum, mut weights) = (0.0, 0.0);
    for ray in 0..count {
        let (u, v) = ((0.5 + ray as f32 * 0.754_877_7).fract(), (ray as f32 + 0.5) / count as f32);
        let (sin, cos) = (TAU * u).sin_cos();
        let height = 1.0 - v * (1.0 + stretched.z);
        let across = (1.0 - height * height).max(0.0).sqrt();
        let cap = Vec3::new(across * cos, across * sin, height) + stretched;
        let normal = Vec3::new(alpha * cap.x, alpha * cap.y, cap.z.max(1e-6)).normalize();
        let ray = 2.0 * normal.dot(to_eye) * normal - to_eye;
        if ray.z <= 0.0 {
            continue;
        }
        let smith = |cos: f32| (a2 / (cos * cos) + 1.0 - a2).sqrt();
        let weight = (1.0 + smith(to_eye.z)) / (smith(to_eye.z) + smith(ray.z));
        let to_wall = (2.0 - point.z) / ray.z;
        let to_floor = if ray.y < 0.0 { -point.y / ray.y } else { f32::INFINITY };
        let light = if to_floor < to_wall {
            let at = point + ray * to_floor;
            chequer_at(at.x, at.z)
        } else {
            let at = point + ray * to_wall;
            // The wall has an upper end.
            if at.y < 10.0 && at.x.abs() < 10.0 { chequer_at(at.x, at.y) } else { 0.0 }
        };
        sum += weight * light;
        weights += weight;
    }
    sum / weights
}

#[test]
fn rough_mirrors_reflect_what_rays_find() {
    const SIZE: (u32, u32) = (320, 240);
    let mut renderer = renderer();
    // The root of the mean square of the difference, as a share of the mean, and what it may be.
    for (roughness, most) in [(0.1, 0.05), (0.2, 0.05), (0.4, 0.05)] {
        let scene = before_chequers(roughness);
        let request = FrameRequest { sample_count: 64, ..plain_request(&scene, SIZE) };
        let shown = radiance(&mut renderer, &scene, &request);
        let View { world_from_view, projection } = request.camera;
        let eye = world_from_view.w_axis.truncate();
        let half = projection.half_extent(SIZE.0 as f32 / SIZE.1 as f32);
        let (mut squares, mut sum, mut count, mut near) = (0.0, 0.0, 0, (0.0, 0.0, 0));
        for y in (0..SIZE.1).step_by(4) {
            for x in (0..SIZE.0).step_by(4) {
                // The mean over the pixel, as the still has it.
                let mut truth = 0.0;
                let mut height_m = 0.0;
                for (s, t) in [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)] {
                    let ndc = glam::Vec2::new(
                        (x as f32 + s) / SIZE.0 as f32 * 2.0 - 1.0,
                        1.0 - (y as f32 + t) / SIZE.1 as f32 * 2.0,
                    );
                    let direction = world_from_view.transform_vector3((ndc * half).extend(-1.0)).normalize();
                    let point = eye + direction * (-eye.z / direction.z);
                    height_m = if point.y > 0.02 && direction.z < 0.0 { point.y } else { -1.0 };
                    if height_m < 0.0 {
                        break;
                    }
                    truth += 0.25 * by_rays(point, -direction, roughness, 1024);
                }
                if height_m < 0.0 {
                    continue;
                }
                let found = shown[((y * SIZE.0 + x) * 4) as usize];
                squares += f64::from((found - truth).powi(2));
                sum += f64::from(truth);
                count += 1;
                if height_m < 0.3 {
                    near = (near.0 + f64::from((found - truth).powi(2)), near.1 + f64::from(truth), near.2 + 1);
                }
            }
        }
        let error = (squares / f64::from(count)).sqrt() / (sum / f64::from(count));
        let near_error = (near.0 / f64::from(near.2)).sqrt() / (near.1 / f64::from(near.2));
        println!("roughness {roughness}: {error:.4} of the mean, {near_error:.4} near the floor, {count} pixels");
        assert!(count > 3000 && error < most, "roughness {roughness}: {error}");
    }
}

#[test]
fn odd_mirrors_are_no_mirrors() {
    let mut scene = scenes::rows_of_spheres().scene;
    let request = plain_request(&scene, SIZE);
    let mut renderer = renderer();
    let before = radiance(&mut renderer, &scene, &request);
    let ball = scene.nodes.iter().position(|node| node.mesh.is_some()).unwrap();
    let empty = scene.add_node(None, Node::default());
    // A ball, nothing, a node that is not there, one twice.
    for node in [NodeId(ball as u32), empty, NodeId(1_000_000)] {
        scene.mirrors.push(Mirror::new("odd", node));
    }
    renderer.load(&scene).unwrap();
    let warnings = renderer.warnings();
    for what in ["is not flat", "has no mesh", "is not there"] {
        let is_said = |warning: &String| warning.contains("mirror `odd` is not drawn") && warning.ends_with(what);
        assert!(warnings.iter().any(is_said), "{what}: {warnings:?}");
    }
    assert_eq!(radiance(&mut renderer, &scene, &request), before);
    assert_eq!(renderer.stats().captures, 0);
    let (mut scene, request, _) = scene_with_mirror();
    let node = scene.mirrors[0].node;
    for scale in [Vec3::ZERO, Vec3::splat(f32::NAN), Vec3::splat(1e30), Vec3::new(40.0, 0.0, 40.0)] {
        scene.node_mut(node).scale = scale;
        scene.update_transforms();
        let picture = radiance(&mut renderer, &scene, &request);
        assert!(picture.iter().all(|value| value.is_finite()), "{scale}");
    }
    scene.node_mut(node).scale = Vec3::splat(40.0);
    scene.update_transforms();
    // As large a picture as the adapter draws: a rough mirror draws no larger one.
    let limit = renderer.gpu().capabilities.max_texture_size;
    scene.materials.last_mut().unwrap().roughness_factor = 0.3;
    let wide = FrameRequest { width: limit, height: 2, averaging: Averaging::Display, ..request.clone() };
    renderer.render(&scene, &wide).unwrap();
    assert_eq!(renderer.stats().captures, 1);
    scene.materials.last_mut().unwrap().roughness_factor = 0.0;
    let truth = radiance(&mut renderer, &scene, &request);
    for scale in [0.5, 0.001, f32::NAN, -1.0, f32::INFINITY] {
        scene.mirrors[0].scale = scale;
        let picture = radiance(&mut renderer, &scene, &request);
        let difference = picture.iter().zip(&truth).map(|(a, b)| (a - b).abs()).sum::<f32>() / truth.len() as f32;
        assert!(difference < 0.2, "{scale}: {difference}");
    }
}
