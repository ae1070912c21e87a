//! What one view draws: instances of primitives, culled by the frustum, grouped and sorted.

use crate::constants::WITHOUT_NORMALS;
use crate::resources::SceneResources;
use crate::resources::geometry::{GpuPrimitive, Instance};
use crate::view::ViewUniform;
use bytemuck::Zeroable;
use glam::{Mat4, Vec4};
use manypass_scene::{Aabb, NodeId, Scene, Topology};
use std::collections::HashMap;
use std::ops::Range;

/// The corners of the square around the disc of a point.
const DISC_CORNERS: usize = 4;

/// Which sides of triangles are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Faces {
    /// Both, in the order of the indices.
    Both,
    /// Those that turn their front to the eye.
    Front,
    /// Those that turn their back to the eye.
    Back,
}

/// One draw call: a primitive, and which of the view's instances.
#[derive(Clone, Debug)]
pub struct Draw {
    /// Index of the mesh.
    pub mesh: usize,
    /// Index of the primitive in the mesh.
    pub primitive: usize,
    /// Index of the material.
    pub material: usize,
    /// Whether the transform turns the triangles around.
    pub mirrored: bool,
    /// Which sides of its triangles.
    pub faces: Faces,
    /// Which instances; of points, one for every corner of a disc.
    pub instances: Range<u32>,
    distance_m: f32,
}

/// The draws of one view.
#[derive(Debug, Default)]
pub struct DrawList {
    /// Opaque and masked surfaces, by program and material, nearer ones first.
    pub opaque: Vec<Draw>,
    /// Blended surfaces, farther ones first; of those with two sides the back faces before the front faces.
    pub blended: Vec<Draw>,
    /// The instances that the draws refer to.
    pub instances: Vec<Instance>,
    /// Triangles of all draws.
    pub triangles: u64,
}

/// Transforms of skins and weights of morph targets of all nodes, the same for all views of a frame.
#[derive(Debug, Default)]
pub struct Deformation {
    /// Rows of `world_from_mesh`, three a joint.
    pub joint_rows: Vec<[f32; 4]>,
    /// Weights.
    pub morph_weights: Vec<f32>,
    /// Where those of a node lie.
    nodes: HashMap<NodeId, Deformed>,
}

/// Where a node finds its joints and weights.
#[derive(Clone, Copy, Debug, Default)]
struct Deformed {
    joints: Option<Joints>,
    first_weight: Option<u32>,
}

impl Deformation {
    /// Of all `nodes` of `scene` that draw something deformed.
    pub fn new(scene: &Scene, resources: &SceneResources, nodes: &[NodeId]) -> Self {
        let mut deformation = Self::default();
        for id in nodes {
            let node = scene.node(*id);
            let Some(mesh) = node.mesh else { continue };
            let (Some(primitives), Some(source)) = (resources.geometry.meshes.get(mesh), scene.meshes.get(mesh)) else {
                continue;
            };
            let mut of_node = Deformed::default();
            for primitive in primitives {
                if let (Some(skin), true, None) = (node.skin, primitive.skin.is_some(), of_node.joints) {
                    of_node.joints = Some(Joints::append(scene, skin, &mut deformation));
                }
                if primitive.morph_count > 0 && of_node.first_weight.is_none() {
                    let weights =
                        if node.morph_weights.is_empty() { &source.default_morph_weights } else { &node.morph_weights };
                    of_node.first_weight = Some(append_weights(weights, primitive.morph_count, &mut deformation));
                }
            }
            if of_node.joints.is_some() || of_node.first_weight.is_some() {
                deformation.nodes.insert(*id, of_node);
            }
        }
        deformation
    }
}

struct Candidate<'a> {
    draw: Draw,
    instance: Instance,
    primitive: &'a GpuPrimitive,
    blended: bool,
    /// Draws with an equal key are one draw.
    key: (u32, usize, usize, usize, bool),
}

impl DrawList {
    /// Everything of the visible `nodes` of `scene` that `view` may show.
    pub fn new(
        scene: &Scene,
        resources: &SceneResources,
        nodes: &[NodeId],
        deformation: &Deformation,
        view: &ViewUniform,
    ) -> Self {
        let mut candidates = Vec::new();
        for id in nodes {
            collect(scene, resources, view, *id, deformation, &mut candidates);
        }
        let (mut blended, mut opaque): (Vec<_>, Vec<_>) =
            candidates.into_iter().partition(|candidate| candidate.blended);
        opaque.sort_by(|a, b| a.key.cmp(&b.key).then(a.draw.distance_m.total_cmp(&b.draw.distance_m)));
        blended.sort_by(|a, b| b.draw.distance_m.total_cmp(&a.draw.distance_m));
        let mut list = Self::default();
        list.append(opaque, true);
        list.append(blended, false);
        list
    }

    fn append(&mut self, candidates: Vec<Candidate<'_>>, is_opaque: bool) {
        let mut last_key = None;
        for candidate in candidates {
            // The corners of a point's disc read the object as vertices do, from a multiple of their number.
            let is_points = candidate.primitive.topology == Topology::Points;
            let copies = if is_points { DISC_CORNERS } else { 1 };
            let at = self.instances.len().next_multiple_of(copies);
            self.instances.resize(at, Instance::zeroed());
            self.instances.extend(std::iter::repeat_n(candidate.instance, copies));
            let range = at as u32..(at + copies) as u32;
            let is_triangles = candidate.primitive.topology == Topology::Triangles;
            if is_triangles {
                self.triangles += u64::from(candidate.primitive.count) / 3;
            }
            let draws = if is_opaque { &mut self.opaque } else { &mut self.blended };
            let draw = Draw { instances: range, ..candidate.draw };
            match draws.last_mut() {
                Some(last) if is_opaque && !is_points && last_key == Some(candidate.key) => {
                    last.instances.end = draw.instances.end;
                }
                _ if !is_opaque && draw.faces == Faces::Both && is_triangles => {
                    // What a solid's back faces let through lies behind what its front faces let through.
                    draws.extend([Faces::Back, Faces::Front].map(|faces| Draw { faces, ..draw.clone() }));
                }
                _ => draws.push(draw),
            }
            last_key = Some(candidate.key);
        }
    }
}

fn collect<'a>(
    scene: &Scene,
    resources: &'a SceneResources,
    view: &ViewUniform,
    id: NodeId,
    deformation: &Deformation,
    candidates: &mut Vec<Candidate<'a>>,
) {
    let node = scene.node(id);
    let Some(mesh) = node.mesh else { return };
    let Some(primitives) = resources.geometry.meshes.get(mesh) else { return };
    let deformed = deformation.nodes.get(&id).copied().unwrap_or_default();
    for (index, primitive) in primitives.iter().enumerate() {
        let is_skinned = node.skin.is_some() && primitive.skin.is_some();
        let is_deformed = is_skinned || primitive.morph_count > 0;
        if !is_deformed && !may_be_visible(&primitive.bounds, &(view.clip_from_world * node.world_from_object)) {
            continue;
        }
        let matrix = node.world_from_object;
        let mut instance = Instance::zeroed();
        instance.world_from_object = [matrix.row(0), matrix.row(1), matrix.row(2)].map(|row| row.to_array());
        let without_normals = if primitive.without_normals { WITHOUT_NORMALS } else { 0 };
        instance.ids = [(id.0 + 1) | without_normals, u32::MAX, 0, primitive.morph_count];
        instance.morph = [primitive.morph_first, primitive.vertex_count];
        let mut mirrored = matrix.determinant() < 0.0;
        if let (true, Some(joints)) = (is_skinned, deformed.joints) {
            (instance.ids[1], mirrored) = (joints.first, joints.mirrored);
        }
        if let (true, Some(first_weight)) = (primitive.morph_count > 0, deformed.first_weight) {
            instance.ids[2] = first_weight;
        }
        let (material, properties) = resources.material_of(primitive);
        // A skin's joints place the mesh; the node's own transform does not.
        let center = if is_skinned {
            node.bounds_world.center()
        } else {
            node.world_from_object.transform_point3(primitive.bounds.center())
        };
        let distance_m = -view.view_from_world.transform_point3(center).z;
        let has_sides = primitive.topology == Topology::Triangles && !properties.double_sided;
        let faces = if has_sides { Faces::Front } else { Faces::Both };
        candidates.push(Candidate {
            draw: Draw { mesh, primitive: index, material, mirrored, faces, instances: 0..0, distance_m },
            instance,
            primitive,
            blended: properties.blended,
            key: (program_key(resources, material, is_deformed), material, mesh, index, mirrored),
        });
    }
}

/// Materials of the same program lie together.
fn program_key(resources: &SceneResources, material: usize, is_deformed: bool) -> u32 {
    let material = &resources.materials[material];
    let axes = [
        material.masked,
        material.double_sided,
        material.textured,
        material.normal_map,
        is_deformed,
        material.occlusion_apart,
    ];
    axes.iter().fold(0, |key, bit| key * 2 + u32::from(*bit))
}

/// The joints of a skin in the table.
#[derive(Clone, Copy, Debug)]
struct Joints {
    first: u32,
    /// Whether most of them turn triangles around; a mesh has one winding, so the others have to do with it.
    mirrored: bool,
}

impl Joints {
    fn append(scene: &Scene, skin: usize, deformation: &mut Deformation) -> Self {
        let first = (deformation.joint_rows.len() / 3) as u32;
        let mut balance = 0;
        for matrix in scene.joint_matrices(skin) {
            deformation.joint_rows.extend([0, 1, 2].map(|row| matrix.row(row).to_array()));
            let determinant = matrix.determinant();
            balance += i32::from(determinant > 0.0) - i32::from(determinant < 0.0);
        }
        Self { first, mirrored: balance < 0 }
    }
}

fn append_weights(weights: &[f32], count: u32, deformation: &mut Deformation) -> u32 {
    let first = deformation.morph_weights.len() as u32;
    deformation.morph_weights.extend((0..count as usize).map(|i| weights.get(i).copied().unwrap_or(0.0)));
    first
}

/// False only if all corners lie outside one plane of the frustum.
fn may_be_visible(bounds: &Aabb, clip_from_object: &Mat4) -> bool {
    if bounds.is_empty() {
        return false;
    }
    let corners = bounds.corners().map(|corner| *clip_from_object * corner.extend(1.0));
    let is_outside = |plane: &dyn Fn(Vec4) -> f32| corners.iter().all(|corner| plane(*corner) < 0.0);
    !(is_outside(&|c| c.w + c.x)
        || is_outside(&|c| c.w - c.x)
        || is_outside(&|c| c.w + c.y)
        || is_outside(&|c| c.w - c.y)
        || is_outside(&|c| c.w - c.z)
        || is_outside(&|c| c.z))
}
