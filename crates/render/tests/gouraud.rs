//! Light computed at vertices converges to light computed at pixels as meshes are refined.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{plain_request, renderer};
use glam::{Quat, Vec3};
use manypass::{FrameRequest, PairCounts, Path, Renderer};
use manypass_scene::{Aabb, AlphaMode, Camera, Light, LightKind, Material, Mesh, Node, Primitive, Projection, Scene};

const SIZE: (u32, u32) = (96, 72);

/// A wavy floor of `cells` × `cells` squares under a point light, a spot and a sun.
fn scene(cells: u16) -> Scene {
    let mut floor = Primitive { material: Some(0), ..Primitive::default() };
    for i in 0..=cells {
        for j in 0..=cells {
            let [x, z] = [j, i].map(|k| 8.0 * f32::from(k) / f32::from(cells) - 4.0);
            floor.positions.push([x, 0.15 * x.sin(), z]);
            floor.normals.push(Vec3::new(-0.15 * x.cos(), 1.0, 0.0).normalize().to_array());
            floor.uv0.push([x, z]);
        }
    }
    let row = u32::from(cells) + 1;
    for cell in 0..u32::from(cells) * u32::from(cells) {
        let a = cell / u32::from(cells) * row + cell % u32::from(cells);
        floor.indices.extend([a, a + row, a + 1, a + 1, a + row, a + row + 1]);
    }
    floor.bounds = Aabb::from_points(floor.positions.iter().copied().map(Vec3::from));
    let mut scene = Scene::default();
    scene.materials.push(Material {
        base_color_factor: Vec3::new(0.8, 0.5, 0.3).extend(1.0),
        metallic_factor: 0.3,
        roughness_factor: 0.6,
        ..Material::default()
    });
    scene.meshes.push(Mesh { primitives: vec![floor], ..Mesh::default() }.into());
    scene.add_node(None, Node { mesh: Some(0), ..Node::default() });
    let projection = Projection::Perspective { fov_y_rad: 0.8, near_m: 0.1, far_m: None };
    scene.cameras.push(Camera { name: "camera".into(), projection, aspect: None });
    let (translation, rotation) = (Vec3::new(0.0, 5.0, 6.0), Quat::from_rotation_x(-0.7));
    scene.add_node(None, Node { translation, rotation, camera: Some(0), ..Node::default() });
    let spot = LightKind::Spot { inner_cone_rad: 0.2, outer_cone_rad: 0.7 };
    let down = Quat::from_rotation_x(-1.3);
    for (kind, place, range_m, intensity) in [
        (LightKind::Point, Vec3::new(-1.5, 1.5, 0.0), Some(6.0), 12.0),
        (spot, Vec3::new(1.5, 2.5, 0.5), Some(5.0), 30.0),
        (LightKind::Directional, Vec3::ZERO, None, 0.5),
    ] {
        scene.lights.push(Light {
            kind,
            range_m,
            intensity,
            color_linear: Vec3::new(1.0, 0.9, 0.7),
            ..Light::default()
        });
        let light = Some(scene.lights.len() - 1);
        scene.add_node(None, Node { translation: place, rotation: down, light, ..Node::default() });
    }
    scene.update_transforms();
    scene
}

fn radiance(renderer: &mut Renderer, scene: &Scene, path: Path) -> Vec<f32> {
    let request = plain_request(scene, SIZE).with(|settings| settings.render.path = path);
    renderer.render(scene, &request).unwrap();
    renderer.read_radiance().unwrap()
}

/// The mean difference between both ways, as a share of the mean.
fn error(renderer: &mut Renderer, scene: &Scene) -> f32 {
    renderer.load(scene).unwrap();
    let [truth, found] = [Path::Forward, Path::Gouraud].map(|path| radiance(renderer, scene, path));
    let difference: f32 = truth.iter().zip(&found).map(|(a, b)| (a - b).abs()).sum();
    difference / truth.iter().sum::<f32>()
}

#[test]
fn light_at_vertices_converges_to_light_at_pixels() {
    let mut renderer = renderer();
    let errors = [6, 24, 96].map(|cells| error(&mut renderer, &scene(cells)));
    println!("{errors:?}");
    // Interpolation errs by the square of the distance between vertices: a sixteenth for a quarter, but for the edges
    // of cones.
    assert!(errors[0] > 0.02, "a coarse mesh looks like a fine one: {errors:?}");
    assert!(errors[1] < errors[0] / 6.0 && errors[2] < errors[1] / 6.0, "{errors:?}");
    // What is blended is lit in the same way.
    let mut blended = scene(96);
    blended.materials[0].alpha_mode = AlphaMode::Blend;
    assert!(error(&mut renderer, &blended) < 1.5 * errors[2]);
}

/// Pairs of light and vertex by their definition. The spot's cone is part of its reach, and the sun's has no end.
fn pairs_of_vertices(scene: &Scene) -> PairCounts {
    let mut counts = PairCounts::default();
    let primitives = scene.nodes.iter().filter_map(|node| Some((node, &scene.meshes[node.mesh?].primitives[0])));
    for (node, primitive) in primitives {
        for (position, normal) in primitive.positions.iter().zip(&primitive.normals) {
            let place = node.world_from_object.transform_point3(Vec3::from(*position));
            let normal = node.world_from_object.transform_vector3(Vec3::from(*normal));
            for lamp in scene.nodes.iter().filter(|node| node.light.is_some()) {
                let light = &scene.lights[lamp.light.unwrap()];
                let towards = lamp.world_from_object.w_axis.truncate() - place;
                let is_in_cone = match light.kind {
                    LightKind::Spot { outer_cone_rad, .. } => {
                        let axis = lamp.world_from_object.transform_vector3(Vec3::NEG_Z);
                        axis.angle_between(-towards) < outer_cone_rad
                    }
                    _ => true,
                };
                let is_sun = light.kind == LightKind::Directional;
                let is_reached = is_sun || towards.length() <= light.range_m.unwrap() && is_in_cone;
                counts.pairs_visited += 1;
                counts.pairs_in_range += u64::from(is_reached);
                counts.pairs_shaded += u64::from(is_reached && (is_sun || normal.dot(towards) > 0.0));
            }
        }
    }
    counts
}

#[test]
fn pairs_are_counted_at_every_vertex() {
    let mut renderer = renderer();
    let of = |scene: &Scene| plain_request(scene, SIZE).with(|settings| settings.render.path = Path::Gouraud);
    let count = |renderer: &mut Renderer, scene: &Scene, request: &FrameRequest| {
        renderer.load(scene).unwrap();
        renderer.count_pairs(scene, request).unwrap()
    };
    // A pixel takes many vertices of a fine mesh.
    for cells in [6, 160] {
        let scene = scene(cells);
        assert_eq!(count(&mut renderer, &scene, &of(&scene)), pairs_of_vertices(&scene), "{cells}");
    }
    let mut several = scene(24);
    let floor = several.nodes.iter().position(|node| node.mesh.is_some()).unwrap();
    several.meshes[0] =
        Mesh { primitives: vec![Primitive { indices: Vec::new(), ..corners_of(&several) }], ..Mesh::default() }.into();
    several.add_node(None, Node { translation: Vec3::new(0.3, 0.4, 0.0), ..several.nodes[floor].clone() });
    several.update_transforms();
    assert_eq!(count(&mut renderer, &several, &of(&several)), pairs_of_vertices(&several), "twice, without indices");
    // Both sides of what is blended are drawn for themselves, and lit each.
    several.materials[0].alpha_mode = AlphaMode::Blend;
    several.materials[0].double_sided = true;
    let [once, blended] = [pairs_of_vertices(&several), count(&mut renderer, &several, &of(&several))];
    assert_eq!(blended.pairs_visited, 2 * once.pairs_visited);
}

/// The first primitive with a vertex for every corner of a triangle.
fn corners_of(scene: &Scene) -> Primitive {
    let floor = &scene.meshes[0].primitives[0];
    let corner = |values: &[[f32; 3]]| floor.indices.iter().map(|index| values[*index as usize]).collect::<Vec<_>>();
    Primitive {
        positions: corner(&floor.positions),
        normals: corner(&floor.normals),
        uv0: floor.indices.iter().map(|index| floor.uv0[*index as usize]).collect(),
        ..floor.clone()
    }
}
