//! From any scene to what rays meet.

use super::bvh::Bounds;
use super::camera::as_f64;
use super::materials::Material;
use super::meshes::{MeshPart, Meshes, Vertex};
use super::textures::Images;
use super::{Camera, Emission, Light, World};
use glam::{DMat3, DMat4, DVec2, DVec3, DVec4, Vec3};
use manypass_scene::{LightKind, Mesh, Node, NodeId, Primitive, Scene, Topology};

impl World {
    /// The scene as of its last [`Scene::update_transforms`], seen from `camera`: all visible triangles, posed by morph
    /// targets and skins, with their materials and textures, and all visible lights. Points, lines and occlusion
    /// textures, which direct light does not know, are left out. In [`super::Frame::object_id`] stand indices of nodes
    /// plus 1.
    pub fn of_scene(scene: &Scene, camera: Camera) -> Self {
        let mut images = Images::default();
        let default = manypass_scene::Material::default();
        let materials = scene.materials.iter().chain([&default]);
        let mut meshes = Meshes::default();
        meshes.materials = materials.map(|material| Material::new(scene, material, &mut images)).collect();
        let nodes = scene.visible_nodes();
        for id in &nodes {
            if let Some(mesh) = scene.node(*id).mesh.and_then(|mesh| scene.meshes.get(mesh)) {
                add_mesh(&mut meshes, scene, *id, mesh);
            }
        }
        meshes.finish();
        let lights = nodes.iter().filter_map(|id| light(scene, scene.node(*id), &meshes)).collect();
        Self { lights, meshes, ..Self::new(camera) }
    }
}

fn light(scene: &Scene, node: &Node, meshes: &Meshes) -> Option<Light> {
    let light = scene.lights.get(node.light?)?;
    let world_from_object = as_f64(&node.world_from_object);
    let position_world = world_from_object.w_axis.truncate();
    let emission = match light.kind {
        LightKind::Directional => Emission::Directional,
        LightKind::Point => Emission::Point,
        LightKind::Spot { inner_cone_rad, outer_cone_rad } => {
            Emission::Spot { inner_cone_rad: inner_cone_rad.into(), outer_cone_rad: outer_cone_rad.into() }
        }
    };
    let glows_around = match emission {
        Emission::Directional => Vec::new(),
        Emission::Point | Emission::Spot { .. } => meshes.glowing_around(position_world),
    };
    Some(Light {
        emission,
        position_world,
        direction_world: (-world_from_object.z_axis.truncate()).normalize_or(DVec3::NEG_Z),
        intensity: light.color_linear.as_dvec3() * f64::from(light.intensity),
        range_m: light.range_m.filter(|range_m| *range_m > 0.0 && range_m.is_finite()).map(f64::from),
        radius_m: light.radius_m.into(),
        casts_shadows: light.casts_shadows,
        glows_around,
    })
}

fn add_mesh(meshes: &mut Meshes, scene: &Scene, id: NodeId, mesh: &Mesh) {
    let node = scene.node(id);
    let weights = if node.morph_weights.is_empty() { &mesh.default_morph_weights } else { &node.morph_weights };
    let joints: Vec<DMat4> =
        node.skin.map(|skin| scene.joint_matrices(skin)).unwrap_or_default().iter().map(as_f64).collect();
    let default_material = meshes.materials.len() - 1;
    for primitive in mesh.primitives.iter().filter(|primitive| primitive.topology == Topology::Triangles) {
        let posed =
            PosedPrimitive { primitive, weights, joints: &joints, world_from_object: as_f64(&node.world_from_object) };
        let part = meshes.parts.len() as u32;
        let first = meshes.vertices.len() as u32;
        meshes.vertices.extend((0..primitive.positions.len()).map(|index| posed.vertex(index)));
        let is_mirrored = posed.world_from_mesh(0).determinant() < 0.0;
        for [a, b, c] in triangles(primitive) {
            meshes.triangles.push(if is_mirrored { [a, c, b] } else { [a, b, c] }.map(|index| first + index));
            meshes.part_of.push(part);
        }
        meshes.parts.push(MeshPart {
            node: id.0 as usize,
            material: primitive.material.unwrap_or(default_material).min(default_material),
            casts_shadow: node.casts_shadow,
            bounds_world: posed.bounds_world(&meshes.vertices[first as usize..]),
        });
    }
}

/// Triples of indices, all of which have a vertex.
fn triangles(primitive: &Primitive) -> Vec<[u32; 3]> {
    let count = primitive.positions.len() as u32;
    let all: Vec<u32> = match primitive.indices.is_empty() {
        true => (0..count).collect(),
        false => primitive.indices.clone(),
    };
    let triples = all.chunks_exact(3).map(|corners| [corners[0], corners[1], corners[2]]);
    triples.filter(|corners| corners.iter().all(|index| *index < count)).collect()
}

/// A primitive in its pose.
struct PosedPrimitive<'p> {
    primitive: &'p Primitive,
    weights: &'p [f32],
    /// Of the skin; empty without one.
    joints: &'p [DMat4],
    world_from_object: DMat4,
}

impl PosedPrimitive<'_> {
    fn is_deformed(&self) -> bool {
        self.is_skinned() || !self.primitive.morph_targets.is_empty()
    }

    fn is_skinned(&self) -> bool {
        !self.joints.is_empty() && !self.primitive.joints.is_empty()
    }

    /// The transform of a vertex: that of the node, or the weighted sum of its joints'.
    fn world_from_mesh(&self, index: usize) -> DMat4 {
        let (joints, weights) = (self.primitive.joints.get(index), self.primitive.weights.get(index));
        let Some((joints, weights)) = joints.zip(weights).filter(|_| self.is_skinned()) else {
            return self.world_from_object;
        };
        let matrix = |joint: u16| self.joints.get(usize::from(joint)).copied().unwrap_or(DMat4::IDENTITY);
        joints.iter().zip(weights).fold(DMat4::ZERO, |sum, (joint, weight)| sum + matrix(*joint) * f64::from(*weight))
    }

    fn vertex(&self, index: usize) -> Vertex {
        let primitive = self.primitive;
        let at = |values: &[[f32; 3]]| values.get(index).map_or(DVec3::ZERO, |value| Vec3::from(*value).as_dvec3());
        let mut position = at(&primitive.positions);
        let mut normal = at(&primitive.normals);
        let tangent =
            primitive.tangents.get(index).map_or(DVec4::ZERO, |tangent| glam::Vec4::from(*tangent).as_dvec4());
        let mut direction = tangent.truncate();
        for (target, weight) in primitive.morph_targets.iter().zip(self.weights) {
            let weight = f64::from(*weight);
            position += weight * at(&target.positions);
            normal += weight * at(&target.normals);
            direction += weight * at(&target.tangents);
        }
        let world_from_mesh = self.world_from_mesh(index);
        let linear = DMat3::from_mat4(world_from_mesh);
        let uv = |set: &[[f32; 2]]| set.get(index).map_or(DVec2::ZERO, |uv| glam::Vec2::from(*uv).as_dvec2());
        Vertex {
            position_world: world_from_mesh.transform_point3(position),
            normal_world: (linear.inverse().transpose() * normal).normalize_or_zero(),
            tangent_world: (linear * direction).normalize_or_zero().extend(tangent.w * linear.determinant().signum()),
            uvs: [uv(&primitive.uv0), uv(&primitive.uv1)],
            color: primitive.colors.get(index).map_or(DVec4::ONE, |color| glam::Vec4::from(*color).as_dvec4()),
        }
    }

    /// The box around the posed vertices, or, of what is not deformed, around its turned box.
    fn bounds_world(&self, vertices: &[Vertex]) -> Bounds {
        let all = Bounds::of(vertices.iter().map(|vertex| vertex.position_world));
        if self.is_deformed() {
            return all;
        }
        let own = Bounds::of(self.primitive.positions.iter().map(|position| Vec3::from(*position).as_dvec3()));
        let corner = |i: u32| {
            let pick = |bit: u32, low: f64, high: f64| if i & bit == 0 { low } else { high };
            let corner =
                DVec3::new(pick(1, own.min.x, own.max.x), pick(2, own.min.y, own.max.y), pick(4, own.min.z, own.max.z));
            self.world_from_object.transform_point3(corner)
        };
        Bounds::of((0..8).map(corner)).union(&all)
    }
}
