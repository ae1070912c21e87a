//! Vertices as the device reads them.

use super::clouds::neighbours_first;
use crate::constants::POINT_CORNERS;
use crate::shader::program::Attribute;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use half::f16;
use manypass_scene::{MorphTarget, Primitive, Topology};
use std::borrow::Cow;

/// One vertex of the first stream, 52 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct Vertex {
    position: [f32; 3],
    /// The fourth is 1 where the normal that was given is no number, else 0.
    normal: [i16; 4],
    tangent: [i16; 4],
    uv0: [f32; 2],
    uv1: [f32; 2],
    color: [f16; 4],
}

/// One vertex of the stream of skins.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(super) struct SkinVertex {
    joints: [u16; 4],
    weights: [f32; 4],
}

/// One drawn instance of a primitive.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Instance {
    /// The first three rows of `world_from_object`.
    pub world_from_object: [[f32; 4]; 3],
    /// Object id and [`crate::constants::WITHOUT_NORMALS`], first joint (all ones: not skinned), first morph weight,
    /// number of morph targets.
    pub ids: [u32; 4],
    /// First displacement texel of the primitive, number of vertices.
    pub morph: [u32; 2],
}

/// The stride of each stream: vertices, skins, instances.
pub const STRIDES: [u64; 3] =
    [size_of::<Vertex>() as u64, size_of::<SkinVertex>() as u64, size_of::<Instance>() as u64];

const fn attribute(name: &'static str, format: wgpu::VertexFormat, offset: usize, buffer: usize) -> Attribute {
    Attribute { name, format, offset: offset as u64, buffer }
}

/// Everything that a vertex shader can read of a surface, by its WGSL name.
pub const ATTRIBUTES: [Attribute; 13] = [
    attribute("position", wgpu::VertexFormat::Float32x3, std::mem::offset_of!(Vertex, position), 0),
    attribute("normal", wgpu::VertexFormat::Snorm16x4, std::mem::offset_of!(Vertex, normal), 0),
    attribute("tangent", wgpu::VertexFormat::Snorm16x4, std::mem::offset_of!(Vertex, tangent), 0),
    attribute("uv0", wgpu::VertexFormat::Float32x2, std::mem::offset_of!(Vertex, uv0), 0),
    attribute("uv1", wgpu::VertexFormat::Float32x2, std::mem::offset_of!(Vertex, uv1), 0),
    attribute("color", wgpu::VertexFormat::Float16x4, std::mem::offset_of!(Vertex, color), 0),
    attribute("joints", wgpu::VertexFormat::Uint16x4, std::mem::offset_of!(SkinVertex, joints), 1),
    attribute("weights", wgpu::VertexFormat::Float32x4, std::mem::offset_of!(SkinVertex, weights), 1),
    attribute("world_from_object_row0", wgpu::VertexFormat::Float32x4, 0, 2),
    attribute("world_from_object_row1", wgpu::VertexFormat::Float32x4, 16, 2),
    attribute("world_from_object_row2", wgpu::VertexFormat::Float32x4, 32, 2),
    attribute("instance", wgpu::VertexFormat::Uint32x4, std::mem::offset_of!(Instance, ids), 2),
    attribute("morph", wgpu::VertexFormat::Uint32x2, std::mem::offset_of!(Instance, morph), 2),
];

/// As [`ATTRIBUTES`] where there is no stream of skins: shaders that declare it, and do not look at it, are given other
/// bytes.
pub const ATTRIBUTES_WITHOUT_SKINS: [Attribute; 13] = {
    let mut attributes = ATTRIBUTES;
    let mut index = 0;
    while index < attributes.len() {
        if attributes[index].buffer == 1 {
            (attributes[index].buffer, attributes[index].offset) = (0, 0);
        }
        index += 1;
    }
    attributes
};

/// How many vertices on the device each vertex of a file has. One instance for each point would be a third of the memory,
/// and took a million of them 1.4 times as long: on llvmpipe the whole still, on an H100 the geometry pass.
pub(crate) const fn copies(topology: Topology) -> u32 {
    if matches!(topology, Topology::Points) { POINT_CORNERS } else { 1 }
}

/// The vertices of a primitive that is [`in_drawing_order`].
pub(super) fn vertices(primitive: &Primitive) -> impl Iterator<Item = Vertex> {
    // A point without a normal faces the eye; zero says so to `surface_vertex.wgsl`.
    let no_normal = if primitive.topology == Topology::Points { [0.0; 3] } else { [0.0, 0.0, 1.0] };
    // Without tangents nobody knows where a normal map points; zero leaves the normal as it is.
    let no_tangent = [0.0, 0.0, 0.0, 1.0];
    // Callers may have lengths and colours that a file cannot; what is endless would be no number in the picture.
    let color = |color: &[f32; 4]| color.map(|part| f16::from_f32(part.clamp(f16::MIN.to_f32(), f16::MAX.to_f32())));
    let vertex = move |i: usize| {
        let normal = Vec3::from(primitive.normals.get(i).copied().unwrap_or(no_normal));
        let [x, y, z] = normal.normalize_or_zero().to_array();
        let is_wrong = f32::from(u8::from(!normal.is_finite()));
        Vertex {
            position: primitive.positions[i],
            normal: [x, y, z, is_wrong].map(snorm16),
            tangent: primitive.tangents.get(i).copied().unwrap_or(no_tangent).map(snorm16),
            uv0: primitive.uv0.get(i).copied().unwrap_or_default(),
            uv1: primitive.uv1.get(i).copied().unwrap_or_default(),
            color: primitive.colors.get(i).map_or([f16::ONE; 4], color),
        }
    };
    let copies = copies(primitive.topology) as usize;
    (0..primitive.positions.len()).flat_map(move |i| std::iter::repeat_n(vertex(i), copies))
}

/// Whether skins or morph targets move the vertices of a primitive.
pub(super) fn is_deformed(primitive: &Primitive) -> bool {
    !primitive.joints.is_empty() || !primitive.morph_targets.is_empty()
}

/// The stream of skins of a primitive that is deformed.
pub(super) fn skins(primitive: &Primitive) -> impl Iterator<Item = SkinVertex> {
    let skin = |i: usize| SkinVertex {
        joints: primitive.joints.get(i).copied().unwrap_or_default(),
        weights: primitive.weights.get(i).copied().unwrap_or_default(),
    };
    let copies = copies(primitive.topology) as usize;
    (0..primitive.positions.len()).flat_map(move |i| std::iter::repeat_n(skin(i), copies))
}

/// Displacements of positions, normals and tangents, vertex by vertex, target by target.
pub(super) fn displacements(primitive: &Primitive) -> Vec<[f32; 4]> {
    let count = primitive.positions.len();
    let mut displacements = Vec::with_capacity(primitive.morph_targets.len() * count * 3);
    for target in &primitive.morph_targets {
        for i in 0..count {
            for displacement in [&target.positions, &target.normals, &target.tangents] {
                let [x, y, z] = displacement.get(i).copied().unwrap_or_default();
                displacements.push([x, y, z, 0.0]);
            }
        }
    }
    displacements
}

/// How many vertices a primitive has on the device.
pub(super) fn drawn_vertices(primitive: &Primitive) -> usize {
    let count = if are_gathered(primitive) { primitive.indices.len() } else { primitive.positions.len() };
    count * copies(primitive.topology) as usize
}

fn are_gathered(primitive: &Primitive) -> bool {
    primitive.topology == Topology::Points && !primitive.indices.is_empty()
}

/// Points in the order of their indices, without indices: the corners of their discs are counted. Of many, neighbours
/// follow each other.
pub(super) fn in_drawing_order(primitive: &Primitive) -> Cow<'_, Primitive> {
    let primitive = match are_gathered(primitive) {
        true => Cow::Owned(gathered(primitive, &primitive.indices)),
        false => Cow::Borrowed(primitive),
    };
    match neighbours_first(&primitive) {
        Some(order) => Cow::Owned(gathered(&primitive, &order)),
        None => primitive,
    }
}

/// The vertices at `indices`, in their order.
fn gathered(primitive: &Primitive, indices: &[u32]) -> Primitive {
    fn gather<T: Copy>(indices: &[u32], values: &[T]) -> Vec<T> {
        indices.iter().filter_map(|index| values.get(*index as usize).copied()).collect()
    }
    let morph_targets = primitive.morph_targets.iter().map(|target| MorphTarget {
        positions: gather(indices, &target.positions),
        normals: gather(indices, &target.normals),
        tangents: gather(indices, &target.tangents),
    });
    Primitive {
        positions: gather(indices, &primitive.positions),
        normals: gather(indices, &primitive.normals),
        tangents: gather(indices, &primitive.tangents),
        uv0: gather(indices, &primitive.uv0),
        uv1: gather(indices, &primitive.uv1),
        colors: gather(indices, &primitive.colors),
        joints: gather(indices, &primitive.joints),
        weights: gather(indices, &primitive.weights),
        indices: Vec::new(),
        morph_targets: morph_targets.collect(),
        variant_materials: primitive.variant_materials.clone(),
        levels: Vec::new(),
        ..*primitive
    }
}

fn snorm16(value: f32) -> i16 {
    (value.clamp(-1.0, 1.0) * 32767.0).round() as i16
}
