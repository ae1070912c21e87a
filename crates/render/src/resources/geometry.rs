//! Vertices and indices of all meshes, in one buffer each.

use crate::gpu::Gpu;
use crate::gpu::data_texture::DataTexture;
use crate::shader::program::Attribute;
use bytemuck::{Pod, Zeroable};
use manypass_scene::{Aabb, MorphTarget, Primitive, Scene, Topology};
use std::ops::Range;

/// One vertex of the first stream, 64 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Vertex {
    position: [f32; 3],
    normal: [f32; 3],
    tangent: [i16; 4],
    uv0: [f32; 2],
    uv1: [f32; 2],
    color: [f32; 4],
}

/// One vertex of the stream of skins.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct SkinVertex {
    joints: [u16; 4],
    weights: [f32; 4],
}

/// One drawn instance of a primitive.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Instance {
    /// The first three rows of `world_from_object`.
    pub world_from_object: [[f32; 4]; 3],
    /// Object id and [`crate::constants::WITHOUT_NORMALS`], first joint (all ones: not skinned), first morph weight, number of morph targets.
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
    attribute("normal", wgpu::VertexFormat::Float32x3, std::mem::offset_of!(Vertex, normal), 0),
    attribute("tangent", wgpu::VertexFormat::Snorm16x4, std::mem::offset_of!(Vertex, tangent), 0),
    attribute("uv0", wgpu::VertexFormat::Float32x2, std::mem::offset_of!(Vertex, uv0), 0),
    attribute("uv1", wgpu::VertexFormat::Float32x2, std::mem::offset_of!(Vertex, uv1), 0),
    attribute("color", wgpu::VertexFormat::Float32x4, std::mem::offset_of!(Vertex, color), 0),
    attribute("joints", wgpu::VertexFormat::Uint16x4, std::mem::offset_of!(SkinVertex, joints), 1),
    attribute("weights", wgpu::VertexFormat::Float32x4, std::mem::offset_of!(SkinVertex, weights), 1),
    attribute("world_from_object_row0", wgpu::VertexFormat::Float32x4, 0, 2),
    attribute("world_from_object_row1", wgpu::VertexFormat::Float32x4, 16, 2),
    attribute("world_from_object_row2", wgpu::VertexFormat::Float32x4, 32, 2),
    attribute("instance", wgpu::VertexFormat::Uint32x4, std::mem::offset_of!(Instance, ids), 2),
    attribute("morph", wgpu::VertexFormat::Uint32x2, std::mem::offset_of!(Instance, morph), 2),
];

/// A primitive on the device.
#[derive(Clone, Debug)]
pub struct GpuPrimitive {
    /// Its bytes in the buffer of vertices.
    pub vertices: Range<u64>,
    /// Its bytes in the buffer of skins, if it is skinned or morphed.
    pub skin: Option<Range<u64>>,
    /// Its bytes in the buffer of indices, if it is indexed.
    pub indices: Option<Range<u64>>,
    /// The number of vertices.
    pub vertex_count: u32,
    /// The number of indices, or of vertices if it is not indexed.
    pub count: u32,
    /// What they form.
    pub topology: Topology,
    /// Index into the scene's materials.
    pub material: Option<usize>,
    /// The first displacement of its morph targets.
    pub morph_first: u32,
    /// The number of its morph targets.
    pub morph_count: u32,
    /// Whether it takes no light: points and lines whose file gives no normals show base colour and emission (glTF 2.0, on the
    /// materials of points and lines).
    pub without_normals: bool,
    /// The box in object space.
    pub bounds: Aabb,
}

/// All meshes of a scene.
#[derive(Debug)]
pub struct Geometry {
    /// Vertices of all primitives.
    pub vertices: wgpu::Buffer,
    /// Joints and weights of those that are deformed.
    pub skins: wgpu::Buffer,
    /// Indices, 32 bits each.
    pub indices: wgpu::Buffer,
    /// The primitives of every mesh.
    pub meshes: Vec<Vec<GpuPrimitive>>,
}

impl Geometry {
    /// Uploads all meshes of `scene`.
    pub fn new(gpu: &Gpu, scene: &Scene, morphs: &mut DataTexture, warnings: &mut Vec<String>) -> Self {
        let mut vertices = Vec::new();
        let mut skins: Vec<SkinVertex> = Vec::new();
        let mut indices: Vec<u32> = Vec::new();
        let mut displacements: Vec<[f32; 4]> = Vec::new();
        let mut meshes: Vec<Vec<GpuPrimitive>> = scene
            .meshes
            .iter()
            .map(|mesh| {
                let primitives = mesh.primitives.iter().filter(|primitive| !primitive.positions.is_empty());
                primitives.map(|p| append(p, &mut vertices, &mut skins, &mut indices, &mut displacements)).collect()
            })
            .collect();
        let largest = gpu.device.limits().max_buffer_size;
        if size_of_val(vertices.as_slice()) as u64 > largest || size_of_val(indices.as_slice()) as u64 > largest {
            warnings.push(format!(
                "the scene's {} vertices do not fit a buffer of {largest} bytes of this adapter; no mesh is drawn",
                vertices.len()
            ));
            meshes.iter_mut().for_each(Vec::clear);
            (vertices, skins, indices) = Default::default();
        }
        if !displacements.is_empty() && morphs.fill(&gpu.device, &gpu.queue, &displacements).is_none() {
            warnings.push("the morph targets do not fit a texture of this adapter; meshes are drawn unmorphed".into());
            meshes.iter_mut().flatten().for_each(|primitive| primitive.morph_count = 0);
        }
        Self {
            vertices: upload(gpu, "vertices", &vertices, wgpu::BufferUsages::VERTEX),
            skins: upload(gpu, "skins", &skins, wgpu::BufferUsages::VERTEX),
            indices: upload(gpu, "indices", &indices, wgpu::BufferUsages::INDEX),
            meshes,
        }
    }
}

fn append(
    primitive: &Primitive,
    vertices: &mut Vec<Vertex>,
    skins: &mut Vec<SkinVertex>,
    indices: &mut Vec<u32>,
    displacements: &mut Vec<[f32; 4]>,
) -> GpuPrimitive {
    if primitive.topology == Topology::Points && !primitive.indices.is_empty() {
        return append(&gathered(primitive), vertices, skins, indices, displacements);
    }
    // A point without a normal faces the eye; zero says so to `surface_vertex.wgsl`.
    let no_normal = if primitive.topology == Topology::Points { [0.0; 3] } else { [0.0, 0.0, 1.0] };
    // Without tangents nobody knows where a normal map points; zero leaves the normal as it is.
    let no_tangent = [0.0, 0.0, 0.0, 1.0];
    let count = primitive.positions.len();
    let bytes = |start: usize, end: usize, stride: usize| (start * stride) as u64..(end * stride) as u64;
    let first_vertex = vertices.len();
    vertices.extend((0..count).map(|i| Vertex {
        position: primitive.positions[i],
        normal: primitive.normals.get(i).copied().unwrap_or(no_normal),
        tangent: primitive.tangents.get(i).copied().unwrap_or(no_tangent).map(snorm16),
        uv0: primitive.uv0.get(i).copied().unwrap_or_default(),
        uv1: primitive.uv1.get(i).copied().unwrap_or_default(),
        color: primitive.colors.get(i).copied().unwrap_or([1.0; 4]),
    }));
    let is_deformed = !primitive.joints.is_empty() || !primitive.morph_targets.is_empty();
    let skin = is_deformed.then(|| {
        let first = skins.len();
        skins.extend((0..count).map(|i| SkinVertex {
            joints: primitive.joints.get(i).copied().unwrap_or_default(),
            weights: primitive.weights.get(i).copied().unwrap_or_default(),
        }));
        bytes(first, skins.len(), size_of::<SkinVertex>())
    });
    let index_range = (!primitive.indices.is_empty()).then(|| {
        let first = indices.len();
        indices.extend_from_slice(&primitive.indices);
        bytes(first, indices.len(), 4)
    });
    let morph_first = displacements.len() as u32;
    for target in &primitive.morph_targets {
        for i in 0..count {
            for displacement in [&target.positions, &target.normals, &target.tangents] {
                let [x, y, z] = displacement.get(i).copied().unwrap_or_default();
                displacements.push([x, y, z, 0.0]);
            }
        }
    }
    GpuPrimitive {
        vertices: bytes(first_vertex, vertices.len(), size_of::<Vertex>()),
        skin,
        vertex_count: count as u32,
        count: if primitive.indices.is_empty() { count } else { primitive.indices.len() } as u32,
        indices: index_range,
        topology: primitive.topology,
        material: primitive.material,
        morph_first,
        morph_count: primitive.morph_targets.len() as u32,
        without_normals: primitive.topology != Topology::Triangles && primitive.normals.is_empty(),
        bounds: primitive.bounds,
    }
}

/// The vertices in the order of the indices, without indices: points are drawn as instances, which have none.
fn gathered(primitive: &Primitive) -> Primitive {
    fn gather<T: Copy>(indices: &[u32], values: &[T]) -> Vec<T> {
        indices.iter().filter_map(|index| values.get(*index as usize).copied()).collect()
    }
    let indices = &primitive.indices;
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
        ..*primitive
    }
}

fn snorm16(value: f32) -> i16 {
    (value.clamp(-1.0, 1.0) * 32767.0).round() as i16
}

fn upload<T: Pod>(gpu: &Gpu, label: &str, data: &[T], usage: wgpu::BufferUsages) -> wgpu::Buffer {
    let bytes: &[u8] = bytemuck::cast_slice(data);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        // An empty buffer cannot be bound.
        size: (bytes.len() as u64).next_multiple_of(4).max(64),
        usage: usage | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    if !bytes.is_empty() {
        gpu.queue.write_buffer(&buffer, 0, bytes);
    }
    buffer
}
