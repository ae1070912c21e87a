//! Variables that have passes of their own: ids and motion against the ray caster and closed forms, emission against
//! known values.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{floats, ids, inner_pixels, plain_request, renderer};
use glam::{DVec2, DVec3, Mat4, Quat, Vec3, Vec4};
use manypass::{Aov, Averaging, Exposure, FrameRequest, Path, Pose, Renderer, View, WgslEffect};
use manypass_scene::material::TexturedFactor;
use manypass_scene::{
    AlphaMode, Camera, Material, Mesh, MorphTarget, Node, NodeId, Primitive, Projection, Scene, ShadingModel, Skin,
    primitives,
};
use manypass_testkit::raycast::Options;
use manypass_testkit::scenes;
use std::sync::Arc;

const SIZE: (u32, u32) = (128, 96);

/// Renders one frame with the given variables.
fn rendered(scene: &Scene, request: &FrameRequest) -> Renderer {
    let mut renderer = renderer();
    renderer.load(scene).unwrap();
    renderer.render(scene, request).unwrap();
    renderer
}

/// Where `view` sees a point, in pixels from the top left corner.
fn pixel_of(view: &View, position_world: DVec3, size: (u32, u32)) -> DVec2 {
    let p = view.world_from_view.as_dmat4().inverse().transform_point3(position_world);
    let (half_height, distance) = match view.projection {
        Projection::Perspective { fov_y_rad, .. } => ((0.5 * f64::from(fov_y_rad)).tan(), -p.z),
        Projection::Orthographic { height_m, .. } => (0.5 * f64::from(height_m), 1.0),
    };
    let half_px = DVec2::new(f64::from(size.0), f64::from(size.1)) * 0.5;
    half_px + DVec2::new(p.x, -p.y) / (distance * half_height) * half_px.y
}

fn center_of(at: usize) -> DVec2 {
    DVec2::new((at % SIZE.0 as usize) as f64 + 0.5, (at / SIZE.0 as usize) as f64 + 0.5)
}

fn vector(motion: &[f32], at: usize) -> DVec2 {
    DVec2::new(motion[at * 2].into(), motion[at * 2 + 1].into())
}

#[test]
fn ids_are_the_ray_casters() {
    for test in scenes::all() {
        let mut request = plain_request(&test.scene, SIZE);
        request.want_aovs = vec![Aov::ObjectId, Aov::MaterialId, Aov::Depth];
        let mut renderer = rendered(&test.scene, &request);
        let objects = ids(renderer.read_aov(Aov::ObjectId).unwrap());
        let materials = ids(renderer.read_aov(Aov::MaterialId).unwrap());
        let depth = floats(renderer.read_aov(Aov::Depth).unwrap());
        // Surfaces drawn again have exactly the depth of the first time, at edges too.
        assert!((0..depth.len()).all(|at| (objects[at] != 0) == depth[at].is_finite()), "{}", test.name);
        assert!((0..depth.len()).all(|at| (materials[at] != 0) == depth[at].is_finite()), "{}", test.name);
        let truth = test.world.render(SIZE.0 as usize, SIZE.1 as usize, Options::default()).object_id;
        let inner = inner_pixels(&truth, (SIZE.0 as usize, SIZE.1 as usize));
        assert!(inner.len() > depth.len() / 2);
        for at in inner {
            // The scenes have one mesh and one material for every object of the ray caster.
            let mesh = objects[at].checked_sub(1).and_then(|node| test.scene.nodes[node as usize].mesh);
            assert_eq!(mesh.map_or(0, |mesh| mesh as u32 + 1), truth[at], "{}: object at {at}", test.name);
            assert_eq!(materials[at], truth[at], "{}: material at {at}", test.name);
        }
    }
}

#[test]
fn motion_of_camera_and_object_is_the_closed_form() {
    let test = scenes::rows_of_spheres();
    let mut request = plain_request(&test.scene, SIZE);
    request.want_aovs = vec![Aov::Motion];
    let camera = request.camera;
    let sphere = test.scene.nodes.iter().position(|node| node.mesh.is_some()).unwrap();
    let truth = test.world.render(SIZE.0 as usize, SIZE.1 as usize, Options::default());
    let rotation = Mat4::from_quat(Quat::from_euler(glam::EulerRot::YXZ, 0.03, -0.02, 0.05));
    let shift = Mat4::from_translation(Vec3::new(-0.3, 0.12, 0.25));
    for (name, world_from_view, object_offset) in [
        ("nothing", camera.world_from_view, Vec3::ZERO),
        ("a shifted camera", shift * camera.world_from_view, Vec3::ZERO),
        ("a turned camera", camera.world_from_view * rotation, Vec3::ZERO),
        ("an object", camera.world_from_view, Vec3::new(0.2, -0.1, -0.3)),
        ("all of it", shift * camera.world_from_view * rotation, Vec3::new(0.2, -0.1, -0.3)),
    ] {
        let mut earlier = test.scene.clone();
        earlier.nodes[sphere].translation = object_offset;
        earlier.update_transforms();
        let earlier_view = View { world_from_view, ..camera };
        request.previous = Some(Arc::new(Pose::capture(&earlier, earlier_view)));
        let motion = floats(rendered(&test.scene, &request).read_aov(Aov::Motion).unwrap());
        if name == "nothing" {
            assert!(motion.iter().all(|value| *value == 0.0), "what stands still has no motion at all");
            continue;
        }
        let (mut worst, mut largest) = (0.0f64, 0.0f64);
        for at in inner_pixels(&truth.object_id, (SIZE.0 as usize, SIZE.1 as usize)) {
            let point = match truth.object_id[at] {
                // What lies infinitely far away: a point on the pixel's ray, ten thousand kilometres off.
                0 => {
                    let ndc =
                        (center_of(at) / DVec2::new(SIZE.0.into(), SIZE.1.into()) * 2.0 - 1.0) * DVec2::new(1.0, -1.0);
                    let plane = ndc * camera.half_extent(SIZE.0 as f32 / SIZE.1 as f32).as_dvec2();
                    camera.world_from_view.as_dmat4().transform_point3(plane.extend(-1.0) * 1e7)
                }
                1 => truth.position_world[at] + object_offset.as_dvec3(),
                _ => truth.position_world[at],
            };
            let expected = center_of(at) - pixel_of(&earlier_view, point, SIZE);
            worst = worst.max((vector(&motion, at) - expected).length());
            largest = largest.max(expected.length());
        }
        println!("{name}: off by at most {worst:.4} px of motions up to {largest:.2} px");
        assert!(worst < 0.05, "{name}: off by {worst} px");
        assert!(largest > 2.0, "{name}: the test cannot fail");
    }
    request.previous = None;
    let motion = floats(rendered(&test.scene, &request).read_aov(Aov::Motion).unwrap());
    assert!(motion.len() == 2 * (SIZE.0 * SIZE.1) as usize && motion.iter().all(|value| *value == 0.0));
}

/// A square of 1 m that faces +Z, in `mesh` of a new node.
fn add_square(scene: &mut Scene, change: impl FnOnce(&mut Primitive)) -> NodeId {
    let mut square = primitives::plane(1.0);
    // From the plane y = 0 to z = 0.
    let turned = |[x, y, z]: [f32; 3]| [x, -z, y];
    square.positions.iter_mut().chain(&mut square.normals).for_each(|v| *v = turned(*v));
    square.bounds = manypass_scene::Aabb::from_points(square.positions.iter().copied().map(Vec3::from));
    change(&mut square);
    let mesh = scene.meshes.len();
    scene.meshes.push(Mesh { primitives: vec![square], ..Mesh::default() }.into());
    scene.add_node(None, Node { mesh: Some(mesh), ..Node::default() })
}

/// A camera with parallel rays that sees 4 m of the plane z = 0 from top to bottom: 24 pixels a metre.
fn flat_scene() -> Scene {
    let mut scene = Scene::default();
    let projection = Projection::Orthographic { height_m: 4.0, near_m: 0.1, far_m: 10.0 };
    scene.cameras.push(Camera { name: "flat".into(), projection, aspect: None });
    scene.add_node(None, Node { camera: Some(0), translation: Vec3::Z * 5.0, ..Node::default() });
    scene
}

#[test]
fn motion_of_skins_and_morph_targets_is_the_closed_form() {
    let mut scene = flat_scene();
    let skinned = add_square(&mut scene, |square| {
        let count = square.positions.len();
        square.joints = vec![[0, 1, 0, 0]; count];
        square.weights = vec![[0.25, 0.75, 0.0, 0.0]; count];
    });
    let still_joint = scene.add_node(None, Node { translation: Vec3::NEG_X, ..Node::default() });
    let joint = scene.add_node(None, Node { translation: Vec3::NEG_X, ..Node::default() });
    scene.skins.push(Skin { joints: vec![still_joint, joint], inverse_bind_matrices: Vec::new() });
    scene.node_mut(skinned).skin = Some(0);
    let morphed = add_square(&mut scene, |square| {
        let positions = vec![[0.5, 0.25, 0.0]; square.positions.len()];
        square.morph_targets = vec![MorphTarget { positions, ..MorphTarget::default() }];
    });
    scene.node_mut(morphed).translation = Vec3::X * 0.75;
    scene.node_mut(morphed).morph_weights = vec![0.5];
    scene.update_transforms();

    let mut earlier = scene.clone();
    earlier.node_mut(joint).translation = Vec3::new(-1.5, 0.25, 0.0);
    earlier.node_mut(morphed).morph_weights = vec![0.1];
    earlier.update_transforms();
    for scale in [1.0, 0.5] {
        let mut request = plain_request(&scene, SIZE);
        request.settings.render.scale = scale;
        request.want_aovs = vec![Aov::Motion, Aov::ObjectId];
        request.previous = Some(Arc::new(Pose::capture(&earlier, request.camera)));
        let mut renderer = rendered(&scene, &request);
        let motion = floats(renderer.read_aov(Aov::Motion).unwrap());
        let objects = ids(renderer.read_aov(Aov::ObjectId).unwrap());
        // Three quarters of the joint's way, and 0.4 of the displacement; y counts downwards.
        let expected = [(skinned, DVec2::new(0.5, 0.25) * 0.75 * 24.0), (morphed, DVec2::new(0.5, -0.25) * 0.4 * 24.0)];
        for (node, expected) in expected {
            let pixels: Vec<usize> = (0..objects.len()).filter(|at| objects[*at] == node.0 + 1).collect();
            // A square metre, less where a silhouette runs through pixels.
            assert!((500..=640).contains(&pixels.len()), "{} pixels", pixels.len());
            let error = |at: &usize| (vector(&motion, *at) - expected).length();
            let worst = pixels.iter().map(error).fold(0.0, f64::max);
            assert!(worst < 0.01, "node {node:?} at {scale}: off by {worst} px of {expected}");
        }
        assert!((0..objects.len()).all(|at| objects[at] != 0 || vector(&motion, at) == DVec2::ZERO));
    }
}

#[test]
fn masked_surfaces_drop_the_same_fragments_again() {
    let mut scene = flat_scene();
    scene.materials.push(Material { double_sided: true, ..Material::default() });
    let alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
    scene.materials.push(Material { alpha_mode, double_sided: true, ..Material::default() });
    let behind = add_square(&mut scene, |square| square.material = Some(0));
    scene.node_mut(behind).translation = Vec3::NEG_Z;
    scene.node_mut(behind).scale = Vec3::splat(3.0);
    let masked = add_square(&mut scene, |square| {
        square.material = Some(1);
        // Alpha falls from 1 on the left to 0 on the right.
        square.colors = square.positions.iter().map(|p| [1.0, 1.0, 1.0, 0.5 - p[0]]).collect();
    });
    scene.node_mut(masked).scale = Vec3::splat(2.0);
    scene.update_transforms();
    let mut earlier = scene.clone();
    earlier.node_mut(masked).translation = Vec3::new(-0.5, 0.0, 0.0);
    earlier.update_transforms();
    let mut request = plain_request(&scene, SIZE);
    request.want_aovs = vec![Aov::ObjectId, Aov::Depth, Aov::Motion];
    request.previous = Some(Arc::new(Pose::capture(&earlier, request.camera)));
    let mut renderer = rendered(&scene, &request);
    let objects = ids(renderer.read_aov(Aov::ObjectId).unwrap());
    let depth = floats(renderer.read_aov(Aov::Depth).unwrap());
    let motion = floats(renderer.read_aov(Aov::Motion).unwrap());
    let mut counts = [0; 3];
    for at in 0..objects.len() {
        // The masked square lies 5 m from the camera, the one behind it 6 m.
        let (kind, node, moved) = match depth[at] {
            depth if depth < 5.5 => (0, masked.0 + 1, 12.0),
            depth if depth < 6.5 => (1, behind.0 + 1, 0.0),
            _ => (2, 0, 0.0),
        };
        counts[kind] += 1;
        assert_eq!(objects[at], node, "pixel {at}");
        assert!((vector(&motion, at) - DVec2::new(moved, 0.0)).length() < 0.01, "pixel {at}");
    }
    // Half of 2 × 2 m at 24 pixels a metre.
    assert!((1000..1300).contains(&counts[0]) && counts[1] > 3000 && counts[2] > 3000, "{counts:?}");
}

#[test]
fn emission_and_radiance_are_what_they_should_be() {
    let mut scene = flat_scene();
    let emissive_factor = Vec3::new(0.25, 2.0, 11.0);
    scene.materials.push(Material { emissive_factor, ..Material::default() });
    scene.materials.push(Material {
        shading_model: ShadingModel::Unlit,
        base_color_factor: Vec4::new(0.5, 0.25, 0.75, 1.0),
        ..Material::default()
    });
    for (material, x) in [(0, -1.0), (1, 1.0)] {
        let node = add_square(&mut scene, |square| square.material = Some(material));
        scene.node_mut(node).translation = Vec3::X * x;
    }
    scene.update_transforms();
    let mut request = plain_request(&scene, SIZE);
    request.settings.exposure.stops = Exposure::Stops(2.5);
    request.want_aovs = vec![Aov::Emission, Aov::MaterialId, Aov::Radiance];
    let mut renderer = rendered(&scene, &request);
    let emission = floats(renderer.read_aov(Aov::Emission).unwrap());
    let materials = ids(renderer.read_aov(Aov::MaterialId).unwrap());
    let radiance = floats(renderer.read_aov(Aov::Radiance).unwrap());
    assert_eq!(radiance, renderer.read_radiance().unwrap());
    for (at, material) in materials.iter().enumerate() {
        let expected = [Vec3::ZERO, emissive_factor, Vec3::new(0.5, 0.25, 0.75)][*material as usize];
        let found = Vec3::from_slice(&emission[at * 3..]);
        // Half floats have 11 bits.
        assert!((found - expected).abs().cmple(expected * 5e-4).all(), "pixel {at}: {found}");
        // There is no other light.
        assert!((Vec3::from_slice(&radiance[at * 4..]) - expected).abs().cmple(expected * 5e-4).all(), "pixel {at}");
    }
    assert!([0, 1, 2].map(|id| materials.iter().filter(|material| **material == id).count()).iter().all(|n| *n > 500));
}

#[test]
fn passes_for_variables_run_only_for_them() {
    let test = scenes::sun();
    let mut renderer = renderer();
    renderer.load(&test.scene).unwrap();
    let mut request = plain_request(&test.scene, SIZE);
    let names = |renderer: &mut Renderer, request: &FrameRequest| -> Vec<String> {
        renderer.plan(&test.scene, request).unwrap().passes.iter().map(|pass| pass.name.to_string()).collect()
    };
    // Those of a still of several samples have a view of their own.
    let has = |names: &[String], name: &str| names.iter().any(|known| known.trim_start_matches("aov/") == name);
    let plain = names(&mut renderer, &request);
    assert!(!["ids", "motion", "motion.background", "emission"].iter().any(|name| has(&plain, name)), "{plain:?}");
    assert!(renderer.read_aov(Aov::Depth).is_err() && renderer.read_aov(Aov::Radiance).is_err());
    request.want_aovs = vec![Aov::MaterialId, Aov::Radiance];
    let with_ids = names(&mut renderer, &request);
    assert!(has(&with_ids, "ids") && !has(&with_ids, "motion") && !has(&with_ids, "emission"), "{with_ids:?}");
    assert!(renderer.read_aov(Aov::ObjectId).is_err(), "to plan renders nothing");
    request.sample_count = 2;
    renderer.render(&test.scene, &request).unwrap();
    assert!(renderer.read_aov(Aov::ObjectId).is_ok() && renderer.read_aov(Aov::Motion).is_err());
    // Later samples leave the first one's alone, and so do plans.
    request.sample_index = 1;
    assert!(!has(&names(&mut renderer, &request), "ids"));
    renderer.render(&test.scene, &request).unwrap();
    let anew = FrameRequest { width: 20, height: 30, sample_index: 0, ..request.clone() };
    let mean = renderer.read_radiance().unwrap();
    assert!(has(&names(&mut renderer, &anew), "ids"));
    assert_eq!(renderer.read_radiance().unwrap(), mean);
    assert!(renderer.read_aov(Aov::ObjectId).is_ok());
    request.settings.render.path = Path::Forward;
    request.sample_index = 0;
    renderer.render(&test.scene, &request).unwrap();
    assert!(renderer.read_aov(Aov::ObjectId).is_err());
}

/// What it makes depends on every frame that it saw.
const ECHO: &str = "@fragment fn fs(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    return radiance_at(pixel) + 0.5 * previous_at(pixel);
}";

#[test]
fn variables_beside_the_picture_leave_it_as_it_is() {
    let test = scenes::rows_of_spheres();
    let mut renderer = renderer();
    renderer.load(&test.scene).unwrap();
    let mut request = plain_request(&test.scene, SIZE);
    (request.sample_count, request.averaging, request.goes_on) = (3, Averaging::Both, true);
    let mut earlier = request.camera;
    earlier.world_from_view *= Mat4::from_rotation_y(0.05);
    let wanted = [Aov::Depth, Aov::Normal, Aov::ObjectId, Aov::Motion, Aov::Emission, Aov::BaseColor];
    let previous = Some(Arc::new(Pose::capture(&test.scene, earlier)));
    let variables = FrameRequest { want_aovs: wanted.to_vec(), previous, ..request.clone() };
    let read = |renderer: &mut Renderer| wanted.map(|aov| renderer.read_aov(aov).unwrap());
    renderer.render(&test.scene, &variables).unwrap();
    let of_the_frame = read(&mut renderer);
    for (path, scale) in [(Path::Deferred, 1.0), (Path::Forward, 1.0), (Path::Deferred, 0.5)] {
        let mut pictures = |is_asked: bool| {
            let effect = Arc::new(WgslEffect::new(renderer.gpu(), &format!("{path:?}{is_asked}"), ECHO).unwrap());
            let change = |request: &FrameRequest, sample_index| {
                let mut request = request.with(|settings| {
                    (settings.render.path, settings.render.scale) = (path, scale);
                });
                request.sample_index = sample_index;
                request.effects = vec![effect.clone()];
                request
            };
            // The mean goes on after the variables, and so does the echo in a picture that begins anew.
            let frames = [0, 1, 2, 0].map(|sample_index| {
                renderer.render(&test.scene, &change(&request, sample_index)).unwrap();
                if is_asked {
                    renderer.draw_variables(&test.scene, &change(&variables, sample_index)).unwrap();
                    assert!(read(&mut renderer) == of_the_frame, "{path:?} {scale}: sample {sample_index}");
                }
                (renderer.read_display().unwrap(), renderer.read_radiance().unwrap())
            });
            frames.to_vec()
        };
        let alone = pictures(false);
        assert!(alone[0].1 != alone[3].1, "nothing is kept that could be spoilt");
        assert!(pictures(true) == alone, "{path:?} {scale}: variables change the picture");
    }
}

#[test]
fn a_pose_of_another_scene_does_no_harm() {
    let test = scenes::sun();
    let mut request = plain_request(&test.scene, SIZE);
    request.want_aovs = vec![Aov::Motion];
    request.previous = Some(Arc::new(Pose::capture(&flat_scene(), request.camera)));
    let motion = floats(rendered(&test.scene, &request).read_aov(Aov::Motion).unwrap());
    assert!(motion.iter().all(|value| value.is_finite()));
}

#[test]
fn variables_show_what_is_met_first_where_that_is_asked_for() {
    let mut scene = flat_scene();
    let of = |alpha_mode| Material { alpha_mode, double_sided: true, ..Material::default() };
    let transmission = Some(TexturedFactor::new(1.0));
    scene.materials =
        vec![of(AlphaMode::Opaque), of(AlphaMode::Blend), Material { transmission, ..of(AlphaMode::Opaque) }];
    let behind = add_square(&mut scene, |square| square.material = Some(0));
    scene.node_mut(behind).translation = Vec3::NEG_Z;
    scene.node_mut(behind).scale = Vec3::splat(3.0);
    let pane = add_square(&mut scene, |square| {
        square.material = Some(1);
        // Alpha falls to 0 at three quarters, and is nothing further on the right.
        square.colors = square.positions.iter().map(|p| [1.0, 1.0, 1.0, 0.25 - p[0]]).collect();
    });
    let glass = add_square(&mut scene, |square| square.material = Some(2));
    scene.node_mut(glass).translation = Vec3::new(-1.0, 1.0, 1.0);
    scene.update_transforms();
    let mut radiance = Vec::new();
    for first_surface in [false, true] {
        let mut request = plain_request(&scene, SIZE);
        request.settings.aov.first_surface = first_surface;
        request.averaging = Averaging::Both;
        request.want_aovs = vec![Aov::ObjectId, Aov::MaterialId, Aov::Depth, Aov::Normal, Aov::Radiance];
        let mut renderer = rendered(&scene, &request);
        let objects = ids(renderer.read_aov(Aov::ObjectId).unwrap());
        let materials = ids(renderer.read_aov(Aov::MaterialId).unwrap());
        let depth = floats(renderer.read_aov(Aov::Depth).unwrap());
        let normals = floats(renderer.read_aov(Aov::Normal).unwrap());
        radiance.push(floats(renderer.read_aov(Aov::Radiance).unwrap()));
        let mut counts = [0; 4];
        for at in 0..objects.len() {
            let place = match objects[at] {
                0 => 0,
                id if id == behind.0 + 1 => 1,
                id if id == pane.0 + 1 => 2,
                id => 3 * usize::from(id == glass.0 + 1),
            };
            counts[place] += 1;
            let depth_m = [f32::INFINITY, 6.0, 5.0, 4.0][place];
            assert!(depth[at] == depth_m || (depth[at] - depth_m).abs() < 1e-3, "pixel {at}: {}", depth[at]);
            assert_eq!(materials[at], [0, 1, 2, 3][place], "pixel {at}");
            let normal = Vec3::from_slice(&normals[3 * at..]);
            assert!((normal - if place == 0 { Vec3::ZERO } else { Vec3::Z }).length() < 0.01, "pixel {at}: {normal}");
        }
        // At 24 pixels a metre the pane is there on 0.75 m of its 1 m, less a texel of alpha below 1/255.
        let expected = if first_surface { [428..=436, 570..=582] } else { [0..=0, 0..=0] };
        assert!(expected[0].contains(&counts[2]) && expected[1].contains(&counts[3]), "{counts:?}");
    }
    assert_eq!(radiance[0], radiance[1]);
}
