//! The layers of materials on spheres before a chequered wall.

use crate::material::{
    Anisotropy, Clearcoat, DiffuseTransmission, Iridescence, Sheen, Specular, TexturedFactor, Volume,
};
use crate::{Aabb, Camera, Material, Mesh, Node, Primitive, Projection, Scene, primitives};
use glam::{Quat, Vec3, Vec4};

const RADIUS_M: f32 = 0.45;

/// Spheres of ten materials: paint under a clear coat, brushed metal, velvet, an oil film on metal, a waxy leaf; clear
/// glass, coloured glass, frosted glass, a crystal that disperses, and porcelain. A wall and a floor of squares show
/// what is seen through them.
pub fn materials() -> Scene {
    let mut scene = Scene::default();
    let ball = |scene: &mut Scene, place: (usize, usize), material: Material| {
        let sphere = primitives::uv_sphere(RADIUS_M, 96, 48);
        let translation = Vec3::new(1.05 * (place.0 as f32 - 2.0), 1.6 - 1.1 * place.1 as f32, 0.0);
        put(scene, sphere, material, Node { translation, rotation: Quat::from_rotation_z(0.3), ..Node::default() });
    };
    for (at, material) in all().into_iter().enumerate() {
        ball(&mut scene, (at % 5, at / 5), material);
    }
    chequer(&mut scene);
    let projection = Projection::Perspective { fov_y_rad: 0.5, near_m: 0.1, far_m: None };
    scene.cameras.push(Camera { name: "front".into(), projection, aspect: None });
    let eye = Vec3::new(0.0, 1.75, 6.2);
    let rotation = Quat::from_rotation_arc(Vec3::NEG_Z, (Vec3::new(0.0, 1.02, 0.0) - eye).normalize());
    scene.add_node(None, Node { translation: eye, rotation, camera: Some(0), ..Node::default() });
    scene.update_transforms();
    scene
}

fn all() -> [Material; 10] {
    let of = |color: [f32; 3], metallic: f32, roughness: f32| Material {
        base_color_factor: Vec3::from(color).extend(1.0),
        metallic_factor: metallic,
        roughness_factor: roughness,
        ..Material::default()
    };
    let coat = Clearcoat {
        weight: TexturedFactor::new(1.0),
        roughness: TexturedFactor::new(0.03),
        normal_texture: None,
        normal_scale: 1.0,
    };
    let glass = |color: [f32; 3], roughness: f32, ior: f32| Material {
        transmission: Some(TexturedFactor::new(1.0)),
        ior,
        volume: Some(Volume {
            thickness: TexturedFactor::new(RADIUS_M),
            attenuation_distance_m: 0.35,
            attenuation_color: Vec3::from(color),
        }),
        ..of([1.0; 3], 0.0, roughness)
    };
    let velvet = Sheen { color: TexturedFactor::new(Vec3::new(0.9, 0.35, 0.5)), roughness: TexturedFactor::new(0.45) };
    let film = Iridescence { weight: TexturedFactor::new(1.0), thickness_max_nm: 420.0, ..Iridescence::default() };
    let leaf =
        DiffuseTransmission { weight: TexturedFactor::new(0.6), color: TexturedFactor::new(Vec3::new(0.5, 0.9, 0.15)) };
    let glaze = Specular { color: TexturedFactor::new(Vec3::new(1.0, 1.6, 2.6)), ..Specular::default() };
    [
        Material { name: "clear coat".into(), clearcoat: Some(coat), ..of([0.45, 0.02, 0.03], 0.6, 0.5) },
        Material {
            name: "brushed metal".into(),
            anisotropy: Some(Anisotropy { strength: 0.85, ..Anisotropy::default() }),
            ..of([0.9, 0.75, 0.55], 1.0, 0.35)
        },
        Material { name: "velvet".into(), sheen: Some(velvet), ..of([0.18, 0.01, 0.05], 0.0, 0.9) },
        Material { name: "oil film".into(), iridescence: Some(film), ..of([0.45, 0.45, 0.45], 1.0, 0.15) },
        Material { name: "leaf".into(), diffuse_transmission: Some(leaf), ..of([0.12, 0.3, 0.04], 0.0, 0.45) },
        Material { name: "glass".into(), ..glass([1.0; 3], 0.0, 1.5) },
        Material { name: "coloured glass".into(), ..glass([0.08, 0.45, 0.85], 0.0, 1.5) },
        Material { name: "frosted glass".into(), ..glass([0.75, 0.95, 0.85], 0.35, 1.45) },
        Material { name: "crystal".into(), dispersion: 4.0, ..glass([1.0; 3], 0.0, 1.9) },
        Material { name: "porcelain".into(), specular: Some(glaze), ..of([0.75, 0.74, 0.7], 0.0, 0.12) },
    ]
}

fn put(scene: &mut Scene, primitive: Primitive, material: Material, node: Node) {
    let primitive = Primitive { material: Some(scene.materials.len()), ..primitive };
    scene.materials.push(material);
    let mesh = Some(scene.meshes.len());
    scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() }.into());
    scene.add_node(None, Node { mesh, ..node });
}

/// A wall behind the spheres and a floor below them: every other square dark.
fn chequer(scene: &mut Scene) {
    const SIDE_M: f32 = 0.25;
    let grey = |level: f32| Material {
        base_color_factor: Vec4::new(level, level, level, 1.0),
        metallic_factor: 0.0,
        roughness_factor: 0.8,
        ..Material::default()
    };
    for (level, odd) in [(0.72, 0), (0.16, 1)] {
        let mut squares = Primitive::default();
        for (across, along) in (0..24).flat_map(|across| (0..18).map(move |along| (across, along))) {
            if (across + along) % 2 != odd {
                continue;
            }
            let corner = |right: i32, on: i32| {
                let x = (across + right) as f32 * SIDE_M - 12.0 * SIDE_M;
                let on = (along + on) as f32;
                // The floor first, then up the wall.
                if on <= 8.0 { [x, 0.0, 1.2 - on * SIDE_M] } else { [x, (on - 8.0) * SIDE_M, 1.2 - 8.0 * SIDE_M] }
            };
            let first = squares.positions.len() as u32;
            squares.positions.extend([corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)]);
            let normal = if along < 8 { Vec3::Y } else { Vec3::Z };
            squares.normals.extend([normal.to_array(); 4]);
            squares.indices.extend([0, 1, 2, 0, 2, 3].map(|index| first + index));
        }
        squares.bounds = Aabb::from_points(squares.positions.iter().map(|position| Vec3::from(*position)));
        put(scene, squares, grey(level), Node::default());
    }
}
