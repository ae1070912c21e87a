//! Primitives of nodes with all that poses them: what becomes an item and an instance.

use super::leveled::ItemLevels;
use super::world::{Extent, Item};
use super::{Axes, Faces, NORMAL_MAP};
use crate::constants::{
    LAYER_LIGHT_MAP, LAYER_STEPS, LAYER_TRANSMISSION, LAYER_VOLUME, SHARP_ROUGHNESS, WITHOUT_NORMALS,
};
use crate::levels::{SurfaceForm, SurfaceForms};
use crate::pose::Joints;
use crate::resources::layers::SEEN_LARGE;
use crate::resources::{GpuMaterial, GpuPrimitive, Instance, ReducedMaterials, copies};
use manypass_scene::{Node, NodeId, Topology};

/// Where the joints and weights of a node are.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct NodeDeformation {
    pub joints: Option<Joints>,
    pub first_weight: Option<u32>,
}

/// A primitive of a node with all that poses it.
pub(super) struct PosedPrimitive<'d> {
    pub node: &'d Node,
    pub primitive: &'d GpuPrimitive,
    pub properties: &'d GpuMaterial,
    pub deformed: NodeDeformation,
    pub reduced: &'d ReducedMaterials,
    pub layers_deform: bool,
}

impl PosedPrimitive<'_> {
    pub fn is_deformed(&self) -> bool {
        self.deformed.joints.is_some() || self.deformed.first_weight.is_some()
    }

    pub fn instance(&self, id: NodeId) -> Instance {
        let (primitive, matrix) = (self.primitive, &self.node.world_from_object);
        let without_normals = if primitive.without_normals { WITHOUT_NORMALS } else { 0 };
        let first_joint = self.deformed.joints.map_or(u32::MAX, |joints| joints.first);
        let first_weight = self.deformed.first_weight.unwrap_or(0);
        Instance {
            world_from_object: [matrix.row(0), matrix.row(1), matrix.row(2)].map(|row| row.to_array()),
            ids: [(id.0 + 1) | without_normals, first_joint, first_weight, primitive.morph_count],
            morph: [primitive.morph.start, primitive.vertex_count / copies(primitive.topology)],
        }
    }

    /// All but what its place tells.
    pub fn item(&self) -> Item {
        let Self { node, primitive, properties, deformed, .. } = self;
        let has_sides = primitive.topology == Topology::Triangles && !properties.double_sided;
        let extent = self.extent();
        // Points have no layers, nor has what is deformed where there are too few textures.
        let has_room = primitive.topology != Topology::Points && (self.layers_deform || !self.is_deformed());
        let layers = properties.layers.as_ref().filter(|_| has_room);
        let layers = layers.map_or(0, |layers| layers.bits);
        // A skin's joints place the mesh; the node's own transform does not.
        let center = match deformed.joints {
            Some(_) => node.bounds_world.center(),
            None => node.world_from_object.transform_point3(primitive.bounds.center()),
        };
        Item {
            mesh: 0,
            primitive: 0,
            material: 0,
            group: 0,
            instance: 0,
            elements: match &primitive.indices {
                Some(indices) => indices.units.clone(),
                None if primitive.is_bound_apart() => 0..primitive.count,
                None => primitive.vertices.units.clone(),
            },
            index_page: primitive.indices.as_ref().map(|indices| indices.page as u32),
            vertex_page: (!primitive.is_bound_apart()).then_some(primitive.vertices.page as u32),
            topology: primitive.topology,
            axes: axes(primitive, properties),
            masked: properties.masked,
            mirrored: match deformed.joints {
                Some(joints) => joints.mirrored,
                None => node.world_from_object.determinant() < 0.0,
            },
            faces: if has_sides { Faces::Front } else { Faces::Both },
            bounds_world: extent.as_ref().map_or(node.bounds_world, |extent| extent.around(center)),
            relief_m: 0.0,
            parts: primitive.parts.clone(),
            cloud: primitive.cloud.clone(),
            layers,
            has_light_directions: properties.layers.as_ref().is_some_and(|layers| layers.has_light_directions),
            transmissive: layers & LAYER_TRANSMISSION != 0,
            bends_twice: layers & LAYER_TRANSMISSION != 0 && self.thickness_m() > 0.0,
            casts_shadow: node.casts_shadow && properties.casts_shadow,
            view_layers: node.layers,
            emits: properties.emits,
            glows: properties.emits || properties.is_baked || properties.unlit || primitive.without_normals,
            may_be_smooth: properties.may_be_smooth(SHARP_ROUGHNESS),
            extent,
            center,
            levels: ItemLevels::default(),
            forms: SurfaceForms::default(),
        }
    }

    /// What its surface may be drawn as where it is seen small. What light comes through stays as it is, and what drops
    /// fragments or blends keeps its textures.
    pub fn forms(&self, item: &Item) -> SurfaceForms {
        let Self { properties, reduced, .. } = self;
        if item.transmissive {
            return SurfaceForms::default();
        }
        let has_plain = item.layers & !SEEN_LARGE & !LAYER_LIGHT_MAP != 0 && reduced.has_plain(item.material);
        let left = if has_plain { item.layers & LAYER_LIGHT_MAP } else { item.layers & !SEEN_LARGE };
        let is_solid = left == 0 && !properties.masked && !properties.blended;
        SurfaceForms::of(|form| match form {
            SurfaceForm::Whole => false,
            SurfaceForm::Smooth => item.axes & NORMAL_MAP != 0 || item.layers & SEEN_LARGE != 0,
            SurfaceForm::Plain => has_plain,
            SurfaceForm::Untextured => is_solid && reduced.has_untextured(item.material, (item.mesh, item.primitive)),
        })
    }

    /// The greatest thickness of its volume; 0 if it has none.
    fn thickness_m(&self) -> f32 {
        let layers = self.properties.layers.as_ref().filter(|layers| layers.bits & LAYER_VOLUME != 0);
        layers.map_or(0.0, |layers| layers.factors.volume.w)
    }

    /// How far its relief lies below its triangles; 0 if it has none.
    pub fn relief_m(&self, item: &Item) -> f32 {
        let layers = self.properties.layers.as_ref().filter(|_| item.layers & LAYER_STEPS != 0);
        layers.map_or(0.0, |layers| layers.factors.detail.x * self.node.scale_max())
    }

    fn extent(&self) -> Option<Extent> {
        if self.is_deformed() {
            return None;
        }
        let bounds = &self.primitive.bounds;
        let half = 0.5 * (bounds.max - bounds.min);
        let matrix = &self.node.world_from_object;
        let axes = [matrix.x_axis * half.x, matrix.y_axis * half.y, matrix.z_axis * half.z];
        Some(Extent(axes.map(|axis| axis.truncate())))
    }
}

fn axes(primitive: &GpuPrimitive, material: &GpuMaterial) -> Axes {
    let axes = [
        material.textured,
        material.occlusion_apart,
        material.normal_map,
        material.masked,
        primitive.skin.is_some(),
        material.places_uvs,
    ];
    axes.iter().enumerate().fold(0, |axes, (bit, on)| axes | Axes::from(*on) << bit)
}

/// Materials of the same program lie together.
pub(super) fn program_key(material: &GpuMaterial, is_deformed: bool) -> u32 {
    let axes = [
        material.layers.is_some(),
        material.masked,
        material.double_sided,
        material.textured,
        material.normal_map,
        is_deformed,
        material.occlusion_apart,
        material.places_uvs,
    ];
    axes.iter().fold(0, |key, bit| key * 2 + u32::from(*bit))
}
