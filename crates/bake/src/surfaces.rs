//! The surfaces of a scene that stay where they are, in world space.

use crate::apply::textures;
use crate::materials::{Shade, Surfacing};
use glam::{Vec2, Vec3, Vec4};
use manypass_scene::animation::Property;
use manypass_scene::{Node, NodeId, Primitive, Scene, ShadingModel, Topology};
use std::collections::BTreeSet;
use std::hash::{Hash as _, Hasher};

/// A primitive of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Place {
    /// The node.
    pub node: NodeId,
    /// Which primitive of its mesh.
    pub primitive: usize,
}

/// A primitive where a node has it.
#[derive(Debug)]
pub(crate) struct WorldPrimitive {
    pub place: Place,
    pub material: Option<usize>,
    /// Whether light maps are made of it: it is opaque and lit.
    pub receives: bool,
    /// Whether it keeps light of lamps, and what is chosen by chance, from what lies behind.
    pub casts_shadow: bool,
    /// The layers of its node.
    pub layers: u32,
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub uv: [Vec<Vec2>; 2],
    pub colors: Vec<Vec4>,
    /// Three a triangle.
    pub indices: Vec<u32>,
    /// The number of its first triangle among all.
    pub first_triangle: u32,
}

/// The surfaces of a scene that stay where they are.
///
/// Left out is what moves: nodes that an animation moves or that hang below such nodes, skins, and morph targets. So are
/// hidden nodes, points and lines. Blended surfaces and glass let light through as if they were not there.
#[derive(Debug)]
pub struct Surfaces {
    pub(crate) placed: Vec<WorldPrimitive>,
    /// Which of `placed` a triangle is of.
    pub(crate) owners: Vec<u32>,
    pub(crate) surfacing: Surfacing,
    /// The names of materials with occlusion on the second UV set.
    pub(crate) own_occlusion: BTreeSet<String>,
    warnings: Vec<String>,
}

/// Where on a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spot {
    pub triangle: u32,
    /// The shares of its second and third corner.
    pub shares: Vec2,
}

impl Spot {
    fn mix<T: Copy + std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>>(self, corners: [T; 3]) -> T {
        let [a, b, c] = corners;
        a * (1.0 - self.shares.x - self.shares.y) + b * self.shares.x + c * self.shares.y
    }
}

fn finite(value: Vec3) -> Vec3 {
    if value.is_finite() { value } else { Vec3::ZERO }
}

/// The nodes that an animation moves or hides, or whose light it changes, and all below them.
pub(crate) fn moving(scene: &Scene) -> Vec<bool> {
    let mut moves = vec![false; scene.nodes.len()];
    let channels = scene.animations.iter().flat_map(|animation| &animation.channels);
    for channel in channels {
        if let Some(moves) = moves.get_mut(channel.node.0 as usize) {
            *moves = true;
        }
    }
    let properties = scene.animations.iter().flat_map(|animation| &animation.properties);
    for channel in properties {
        match channel.property {
            Property::Visible(node) => moves.get_mut(node.0 as usize).into_iter().for_each(|moves| *moves = true),
            Property::Light(light, _) => {
                let holders = scene.nodes.iter().zip(&mut moves).filter(|(node, _)| node.light == Some(light));
                holders.for_each(|(_, moves)| *moves = true);
            }
            Property::Material(..) | Property::TextureTransform(..) | Property::Camera(..) => {}
        }
    }
    // Parents come before their children.
    for id in scene.visible_nodes() {
        let parent = scene.node(id).parent;
        if parent.is_some_and(|parent| moves.get(parent.0 as usize).copied().unwrap_or(false)) {
            moves[id.0 as usize] = true;
        }
    }
    moves
}

fn place(node: &Node, id: NodeId, index: usize, primitive: &Primitive) -> WorldPrimitive {
    let world_from_object = node.world_from_object;
    let normal_matrix = glam::Mat3::from_mat4(world_from_object).inverse().transpose();
    let is_mirrored = world_from_object.determinant() < 0.0;
    let mut indices = if primitive.indices.is_empty() {
        (0..primitive.positions.len() as u32).collect()
    } else {
        primitive.indices.clone()
    };
    indices.truncate(indices.len() / 3 * 3);
    if is_mirrored {
        indices.chunks_exact_mut(3).for_each(|corners| corners.swap(1, 2));
    }
    let positions: Vec<Vec3> = primitive
        .positions
        .iter()
        .map(|position| finite(world_from_object.transform_point3(Vec3::from(*position))))
        .collect();
    let normals = (primitive.normals.len() == positions.len()).then_some(&primitive.normals);
    let normals = normals.into_iter().flatten().map(|normal| normal_matrix * Vec3::from(*normal));
    let uv_of = |set: &[[f32; 2]]| set.iter().map(|uv| Vec2::from(*uv)).collect();
    WorldPrimitive {
        place: Place { node: id, primitive: index },
        material: primitive.material,
        receives: true,
        casts_shadow: node.casts_shadow,
        layers: node.layers,
        normals: normals.map(|normal| finite(normal.normalize_or_zero())).collect(),
        positions,
        uv: [uv_of(&primitive.uv0), uv_of(&primitive.uv1)],
        colors: primitive.colors.iter().map(|color| Vec4::from(*color)).collect(),
        indices,
        first_triangle: 0,
    }
}

impl Surfaces {
    /// Of a scene as it stands, after [`Scene::update_transforms`].
    pub fn new(scene: &Scene) -> Self {
        let mut warnings = Vec::new();
        let surfacing = Surfacing::new(scene, &mut warnings);
        let moves = moving(scene);
        let (mut refused, mut own_occlusion) = (BTreeSet::new(), BTreeSet::new());
        let (mut placed, mut owners) = (Vec::new(), Vec::new());
        for id in scene.visible_nodes() {
            let node = scene.node(id);
            let Some(mesh) = node.mesh.and_then(|mesh| scene.meshes.get(mesh)) else { continue };
            if moves[id.0 as usize] || node.skin.is_some() || !node.world_from_object.is_finite() {
                continue;
            }
            for (index, primitive) in mesh.primitives.iter().enumerate() {
                let surface = surfacing.surface(primitive.material);
                let is_still = primitive.topology == Topology::Triangles && primitive.morph_targets.is_empty();
                if !is_still || surface.is_clear {
                    continue;
                }
                let mut of_node = place(node, id, index, primitive);
                of_node.casts_shadow &= surface.casts_shadow;
                let material = primitive.material.and_then(|material| scene.materials.get(material));
                if let Some(material) = material {
                    let is_free = textures(material).all(|texture| texture.uv_set == 0);
                    if !is_free && refused.insert(material.name.clone()) {
                        let name = &material.name;
                        warnings.push(format!("material `{name}` has maps on its second UV set, and so no light map"));
                    }
                    if material.occlusion_texture.is_some_and(|texture| texture.uv_set == 1)
                        && material.light_map.is_none()
                    {
                        own_occlusion.insert(material.name.clone());
                    }
                    of_node.receives = is_free && material.shading_model == ShadingModel::Standard;
                }
                of_node.first_triangle = owners.len() as u32;
                owners.extend(std::iter::repeat_n(placed.len() as u32, of_node.indices.len() / 3));
                placed.push(of_node);
            }
        }
        Self { placed, owners, surfacing, own_occlusion, warnings }
    }

    /// Hashes all that light depends on.
    pub(crate) fn hash_into(&self, hasher: &mut impl Hasher) {
        hasher.write(self.surfacing.describe().as_bytes());
        for placed in &self.placed {
            (placed.place, placed.material, placed.receives, placed.casts_shadow, placed.layers).hash(hasher);
            hasher.write(bytemuck::cast_slice(&placed.positions));
            hasher.write(bytemuck::cast_slice(&placed.normals));
            placed.uv.iter().for_each(|uv| hasher.write(bytemuck::cast_slice(uv)));
            hasher.write(bytemuck::cast_slice(&placed.colors));
            hasher.write(bytemuck::cast_slice(&placed.indices));
        }
    }

    /// How many triangles they have.
    pub fn triangle_count(&self) -> usize {
        self.owners.len()
    }

    /// What was odd, one line each.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Whose a triangle is, and its corners in that.
    pub(crate) fn triangle(&self, triangle: u32) -> (&WorldPrimitive, [usize; 3]) {
        let placed = &self.placed[self.owners[triangle as usize] as usize];
        let first = 3 * (triangle - placed.first_triangle) as usize;
        (placed, [0, 1, 2].map(|corner| placed.indices[first + corner] as usize))
    }

    /// The corners of a triangle.
    pub(crate) fn corners(&self, triangle: u32) -> [Vec3; 3] {
        let (placed, corners) = self.triangle(triangle);
        corners.map(|corner| placed.positions[corner])
    }

    /// The position of a spot, the normal of its triangle and the normal that is shaded.
    pub(crate) fn geometry(&self, spot: Spot) -> (Vec3, Vec3, Vec3) {
        let (placed, corners) = self.triangle(spot.triangle);
        let positions = corners.map(|corner| placed.positions[corner]);
        let facet = (positions[1] - positions[0]).cross(positions[2] - positions[0]).normalize_or_zero();
        let normals = corners.map(|corner| placed.normals.get(corner).copied().unwrap_or(facet));
        let normal = spot.mix(normals).normalize_or(facet);
        // A normal that points behind its triangle says nothing.
        let normal = if normal.dot(facet) > 1e-3 { normal } else { facet };
        (spot.mix(positions), facet, normal)
    }

    fn uv(&self, spot: Spot) -> [Vec2; 2] {
        let (placed, corners) = self.triangle(spot.triangle);
        [0, 1].map(|set| spot.mix(corners.map(|corner| placed.uv[set].get(corner).copied().unwrap_or_default())))
    }

    fn color(&self, spot: Spot) -> Vec4 {
        let (placed, corners) = self.triangle(spot.triangle);
        spot.mix(corners.map(|corner| placed.colors.get(corner).copied().unwrap_or(Vec4::ONE)))
    }

    /// What a spot does with light.
    pub(crate) fn shade(&self, spot: Spot) -> Shade {
        let (placed, _) = self.triangle(spot.triangle);
        let surface = self.surfacing.surface(placed.material);
        self.surfacing.shade(surface, self.uv(spot), self.color(spot).truncate())
    }

    /// Whether there is anything at a spot.
    pub(crate) fn is_there(&self, spot: Spot) -> bool {
        let (placed, _) = self.triangle(spot.triangle);
        let surface = self.surfacing.surface(placed.material);
        self.surfacing.is_there(surface, self.uv(spot), self.color(spot).w)
    }
}
