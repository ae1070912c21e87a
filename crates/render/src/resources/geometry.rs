//! Meshes on the device: vertices, skins and indices in pages, morph targets in a table.

use super::clouds::Cloud;
use super::pages::{Pages, Place};
use super::vertices::{self, SkinVertex, Vertex, drawn_vertices, in_drawing_order, is_deformed};
use crate::constants::DATA_WIDTH;
use crate::gpu::Gpu;
use crate::gpu::data_texture::DataTexture;
use glam::Vec3;
use manypass_scene::turns::{Turns, at_once, give_turn};
use manypass_scene::variants::material_in;
use manypass_scene::{Aabb, Mesh, Primitive, Topology};
use range_alloc::RangeAllocator;
use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::sync::{Arc, Weak};

/// Other triangles between the vertices of a primitive.
#[derive(Clone, Debug)]
pub(crate) struct GpuLevel {
    /// Where its indices lie.
    pub(crate) indices: Place,
    /// How far it is from the primitive, in metres of object space.
    pub error_m: f32,
}

/// A primitive on the device.
#[derive(Clone, Debug)]
pub(crate) struct GpuPrimitive {
    /// Where its vertices lie.
    pub(crate) vertices: Place,
    /// Where its joints and weights lie, if it is skinned or morphed. Then its indices count from its own first vertex,
    /// and else from the page's, so that what is not deformed is drawn without binding anything in between.
    pub(crate) skin: Option<Place>,
    /// Where its indices lie, if it is indexed.
    pub(crate) indices: Option<Place>,
    /// Coarser forms of it, finer ones first.
    pub levels: Vec<GpuLevel>,
    /// The number of vertices on the device.
    pub vertex_count: u32,
    /// The number of indices, or of vertices if it is not indexed.
    pub count: u32,
    /// What they form.
    pub topology: Topology,
    /// Index into the scene's materials.
    pub material: Option<usize>,
    /// What takes its place in variants of the scene.
    pub variant_materials: Vec<(usize, usize)>,
    /// Texels of its displacements.
    pub(crate) morph: Range<u32>,
    /// The number of its morph targets.
    pub morph_count: u32,
    /// Whether it takes no light: points and lines whose file gives no normals show base colour and emission (glTF 2.0,
    /// on the materials of points and lines).
    pub without_normals: bool,
    /// The box in object space.
    pub bounds: Aabb,
    /// How far its farthest vertex lies from the middle of that box, in metres of object space; not deformed.
    pub radius_m: f32,
    /// The boxes around its parts in object space, where it has many triangles and is not deformed.
    pub parts: Option<Arc<[Aabb]>>,
    /// The boxes around its points, where it has many and is not deformed.
    pub cloud: Option<Arc<Cloud>>,
}

impl GpuPrimitive {
    /// The index of its material in a variant of the scene.
    pub(crate) fn material_in(&self, variant: Option<usize>) -> Option<usize> {
        material_in(self.material, &self.variant_materials, variant)
    }

    /// Whether its vertices are bound from its own first on, not from their page's.
    pub(crate) fn is_bound_apart(&self) -> bool {
        self.skin.is_some() || self.topology == Topology::Points
    }
}

/// The fewest triangles of a part, and the most parts.
const PART_TRIANGLES: usize = 128;
const PARTS_MAX: usize = 512;

/// The boxes around successive triangles of a primitive, which mostly lie beside each other; none if it has few.
fn parts_of(primitive: &Primitive) -> Option<Arc<[Aabb]>> {
    let corners = if primitive.indices.is_empty() { primitive.positions.len() } else { primitive.indices.len() };
    let triangles = corners / 3;
    if primitive.topology != Topology::Triangles || triangles <= PART_TRIANGLES {
        return None;
    }
    let of_part = 3 * triangles.div_ceil(PARTS_MAX).max(PART_TRIANGLES);
    let position = |index: usize| primitive.positions.get(index).copied().map(Vec3::from_array);
    let part = |first: usize| {
        let corners = first..(first + of_part).min(corners);
        let index = |corner: usize| primitive.indices.get(corner).map_or(corner, |index| *index as usize);
        Aabb::from_points(corners.filter_map(|corner| position(index(corner))))
    };
    Some((0..corners).step_by(of_part).map(part).collect())
}

/// What [`GpuMesh::rigid`] is of a mesh.
fn rigid_of(mesh: &Mesh) -> Option<(Aabb, f32)> {
    if mesh.primitives.iter().any(is_deformed) {
        return None;
    }
    let bounds = mesh.primitives.iter().fold(Aabb::EMPTY, |bounds, primitive| bounds.union(&primitive.bounds));
    let center = bounds.center();
    let reaches_m = mesh.primitives.iter().map(|primitive| primitive.reach_m(center));
    Some((bounds, reaches_m.fold(0.0, f32::max)))
}

/// A mesh on the device.
#[derive(Debug)]
pub(crate) struct GpuMesh {
    /// What it was made from. As long as this is there, no other mesh takes its place in memory.
    source: Weak<Mesh>,
    pub primitives: Vec<GpuPrimitive>,
    /// The box around all of it in object space, and how far its farthest vertex lies from the middle of that; none if
    /// any of it is deformed.
    rigid: Option<(Aabb, f32)>,
    warnings: Vec<String>,
}

/// The displacements of all morph targets.
#[derive(Debug)]
struct Morphs {
    texture: DataTexture,
    free: RangeAllocator<u32>,
}

/// All meshes of a scene.
#[derive(Debug)]
pub(crate) struct Geometry {
    pub(crate) vertices: Pages,
    pub(crate) skins: Pages,
    pub(crate) indices: Pages,
    morphs: Morphs,
    meshes: Vec<Arc<GpuMesh>>,
    /// The primitives of all meshes, in their order, and where those of each begin and end: every frame walks through
    /// them.
    primitives: Vec<GpuPrimitive>,
    of_mesh: Vec<Range<u32>>,
}

/// What the meshes that are yet to be placed need.
#[derive(Clone, Copy, Debug, Default)]
struct GeometryDemand {
    vertices: u64,
    skins: u64,
    indices: u64,
    displacements: u64,
}

impl GeometryDemand {
    fn of(mesh: &Mesh) -> Self {
        let of_primitive = |primitive: &Primitive| {
            let count = drawn_vertices(primitive) as u64;
            let targets = primitive.morph_targets.len() as u64;
            Self {
                vertices: count,
                skins: if is_deformed(primitive) { count } else { 0 },
                indices: index_count(primitive),
                displacements: 3 * count * targets,
            }
        };
        mesh.primitives.iter().map(of_primitive).sum()
    }
}

/// Indices of a primitive and of its levels.
pub(super) fn index_count(primitive: &Primitive) -> u64 {
    let of_levels = primitive.levels.iter().map(|level| level.indices.len() as u64);
    primitive.indices.len() as u64 + of_levels.sum::<u64>()
}

impl std::iter::Sum for GeometryDemand {
    fn sum<I: Iterator<Item = Self>>(parts: I) -> Self {
        parts.fold(Self::default(), |sum, part| Self {
            vertices: sum.vertices + part.vertices,
            skins: sum.skins + part.skins,
            indices: sum.indices + part.indices,
            displacements: sum.displacements + part.displacements,
        })
    }
}

impl Morphs {
    fn new(device: &wgpu::Device) -> Self {
        let format = wgpu::TextureFormat::Rgba32Float;
        let texture = DataTexture::new(device, "morph_displacements", format, DATA_WIDTH);
        Self { texture, free: RangeAllocator::new(0..0) }
    }

    /// Whether so many more texels have room, in a table that is not much too large for `all`.
    fn suits(&mut self, more: u64, all: u64) -> bool {
        let capacity = u64::from(self.free.initial_range().end);
        let mut has_room = more == 0;
        if let Ok(range) = self.free.allocate_range(u32::try_from(more).unwrap_or(u32::MAX).max(1)) {
            self.free.free_range(range);
            has_room = true;
        }
        has_room && (all > 0 || capacity == 0) && 4 * all.next_multiple_of(u64::from(DATA_WIDTH)) >= capacity
    }

    /// Forgets all, for `texels`; fewer if the device holds no more.
    fn begin(&mut self, device: &wgpu::Device, texels: u64) {
        let most = u64::from(device.limits().max_texture_dimension_2d) * u64::from(DATA_WIDTH);
        let capacity = self.texture.resize(device, texels.min(most) as u32);
        self.free = RangeAllocator::new(0..if texels == 0 { 0 } else { capacity });
    }
}

impl Geometry {
    /// No meshes yet.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            vertices: Pages::new("vertices", wgpu::BufferUsages::VERTEX, size_of::<Vertex>()),
            skins: Pages::new("skins", wgpu::BufferUsages::VERTEX, size_of::<SkinVertex>()),
            indices: Pages::new("indices", wgpu::BufferUsages::INDEX, 4),
            morphs: Morphs::new(&gpu.device),
            meshes: Vec::new(),
            primitives: Vec::new(),
            of_mesh: Vec::new(),
        }
    }

    /// The primitives of a mesh of the scene.
    pub(crate) fn primitives(&self, mesh: usize) -> &[GpuPrimitive] {
        self.of_mesh.get(mesh).map_or(&[], |range| &self.primitives[range.start as usize..range.end as usize])
    }

    /// The box around a mesh of the scene in object space, and how far its farthest vertex lies from the middle of
    /// that, in metres; none if any of it is deformed.
    pub(crate) fn rigid(&self, mesh: usize) -> Option<(&Aabb, f32)> {
        let (bounds, radius_m) = self.meshes.get(mesh)?.rigid.as_ref()?;
        Some((bounds, *radius_m))
    }

    /// The table of displacements.
    pub(crate) fn morph_displacements(&self) -> &DataTexture {
        &self.morphs.texture
    }

    /// What was left out of the meshes.
    pub fn warnings(&self) -> impl Iterator<Item = &String> {
        self.meshes.iter().flat_map(|mesh| &mesh.warnings)
    }

    /// Bytes of all buffers and of the table.
    pub fn bytes(&self) -> u64 {
        self.vertices.bytes() + self.skins.bytes() + self.indices.bytes() + self.morphs.texture.bytes()
    }

    /// Uploads those of `meshes` that are new, or were changed, and gives back what is no longer among them. Says how
    /// many bytes that wrote; None if there was nothing to do.
    pub fn follow(&mut self, gpu: &Gpu, meshes: &[Arc<Mesh>]) -> Option<u64> {
        at_once(self.follow_in_turns(gpu, meshes, &mut || None))
    }

    /// As [`Self::follow`]; after every mesh that is uploaded, and between slices of a large one, `turns` is asked.
    pub async fn follow_in_turns(&mut self, gpu: &Gpu, meshes: &[Arc<Mesh>], turns: &mut Turns<'_>) -> Option<u64> {
        let is_known = |(known, mesh): (&Arc<GpuMesh>, &Arc<Mesh>)| known.source.as_ptr() == Arc::as_ptr(mesh);
        if self.meshes.len() == meshes.len() && self.meshes.iter().zip(meshes).all(is_known) {
            return None;
        }
        let mut known = self.keep(meshes);
        let all: u64 = distinct(meshes).map(|mesh| GeometryDemand::of(mesh).displacements).sum();
        let is_new = |known: &MeshIndex, mesh: &Arc<Mesh>| !known.contains_key(&Arc::as_ptr(mesh));
        let mut expected: GeometryDemand =
            distinct(meshes).filter(|mesh| is_new(&known, mesh)).map(|mesh| GeometryDemand::of(mesh)).sum();
        if !self.morphs.suits(expected.displacements, all) {
            // What is morphed moves to another table.
            let is_morphed = |mesh: &GpuMesh| mesh.primitives.iter().any(|primitive| primitive.morph_count > 0);
            known.extract_if(|_, mesh| is_morphed(mesh)).for_each(|(_, mesh)| self.give_back(&mesh));
            self.morphs.begin(&gpu.device, all);
            expected = distinct(meshes).filter(|mesh| is_new(&known, mesh)).map(|mesh| GeometryDemand::of(mesh)).sum();
        }
        let mut written_bytes = 0;
        self.meshes = Vec::with_capacity(meshes.len());
        for mesh in meshes {
            let mesh = match known.entry(Arc::as_ptr(mesh)) {
                Entry::Occupied(of_mesh) => of_mesh.get().clone(),
                Entry::Vacant(place) => {
                    let (uploaded, displacement_bytes) = self.upload(gpu, mesh, &mut expected, turns).await;
                    written_bytes += displacement_bytes;
                    let uploaded = place.insert(Arc::new(uploaded)).clone();
                    give_turn(turns).await;
                    uploaded
                }
            };
            self.meshes.push(mesh);
        }
        self.primitives.clear();
        self.of_mesh.clear();
        for mesh in &self.meshes {
            let first = self.primitives.len() as u32;
            self.primitives.extend_from_slice(&mesh.primitives);
            self.of_mesh.push(first..self.primitives.len() as u32);
        }
        for pages in [&mut self.vertices, &mut self.skins, &mut self.indices] {
            pages.flush(&gpu.queue);
            pages.trim();
            written_bytes += pages.take_written_bytes();
        }
        Some(written_bytes)
    }

    /// Takes the meshes out, those that are no longer wanted for good.
    fn keep(&mut self, wanted: &[Arc<Mesh>]) -> MeshIndex {
        let wanted: HashSet<*const Mesh> = wanted.iter().map(Arc::as_ptr).collect();
        let mut known: MeshIndex = self.meshes.drain(..).map(|mesh| (mesh.source.as_ptr(), mesh)).collect();
        known.extract_if(|source, _| !wanted.contains(source)).for_each(|(_, mesh)| self.give_back(&mesh));
        known
    }

    fn give_back(&mut self, mesh: &GpuMesh) {
        for primitive in &mesh.primitives {
            self.vertices.give_back(&primitive.vertices);
            primitive.skin.iter().for_each(|place| self.skins.give_back(place));
            primitive.indices.iter().for_each(|place| self.indices.give_back(place));
            primitive.levels.iter().for_each(|level| self.indices.give_back(&level.indices));
            if !primitive.morph.is_empty() {
                self.morphs.free.free_range(primitive.morph.clone());
            }
        }
    }

    /// A mesh, and how many bytes of displacements it took.
    async fn upload(
        &mut self,
        gpu: &Gpu,
        mesh: &Arc<Mesh>,
        expected: &mut GeometryDemand,
        turns: &mut Turns<'_>,
    ) -> (GpuMesh, u64) {
        let source = Arc::downgrade(mesh);
        let mut uploaded = GpuMesh { source, primitives: Vec::new(), rigid: rigid_of(mesh), warnings: Vec::new() };
        let mut displacement_bytes = 0;
        for primitive in mesh.primitives.iter().filter(|primitive| !primitive.positions.is_empty()) {
            // They would be those of another mesh in the page.
            let of_levels = primitive.levels.iter().flat_map(|level| &level.indices);
            if primitive.indices.iter().chain(of_levels).any(|index| *index as usize >= primitive.positions.len()) {
                uploaded.warnings.push(format!(
                    "mesh {} has indices of vertices that it does not have; they are not drawn",
                    quoted(mesh)
                ));
                continue;
            }
            give_turn(turns).await;
            match self.upload_primitive(gpu, primitive, expected, turns).await {
                Some(of_primitive) => {
                    displacement_bytes += 16 * u64::from(of_primitive.morph.end - of_primitive.morph.start);
                    if of_primitive.morph_count < primitive.morph_targets.len() as u32 {
                        let message =
                            "the morph targets of mesh {} do not fit a texture of this adapter; it is drawn unmorphed";
                        uploaded.warnings.push(message.replace("{}", &quoted(mesh)));
                    }
                    uploaded.primitives.push(of_primitive);
                }
                None => uploaded.warnings.push(format!(
                    "the {} vertices and {} indices of mesh {} do not fit a buffer of this adapter; they are not drawn",
                    primitive.positions.len(),
                    primitive.indices.len(),
                    quoted(mesh),
                )),
            }
        }
        (uploaded, displacement_bytes)
    }

    /// Uploads the coarser forms of a primitive, as far as there is room.
    async fn upload_levels(
        &mut self,
        gpu: &Gpu,
        primitive: &Primitive,
        placed: &mut GpuPrimitive,
        expected: &mut GeometryDemand,
        turns: &mut Turns<'_>,
    ) {
        let first = if placed.is_bound_apart() { 0 } else { placed.vertices.units.start };
        for level in &primitive.levels {
            let count = level.indices.len() as u32;
            let Some(place) = self.indices.take(&gpu.device, count, expected.indices) else { return };
            expected.indices = expected.indices.saturating_sub(count.into());
            let indices = level.indices.iter().map(|index| index + first);
            self.indices.write_in_turns(&gpu.queue, &place, indices, turns).await;
            placed.levels.push(GpuLevel { indices: place, error_m: level.error_m });
        }
    }

    /// None if no buffer is large enough.
    async fn upload_primitive(
        &mut self,
        gpu: &Gpu,
        primitive: &Primitive,
        expected: &mut GeometryDemand,
        turns: &mut Turns<'_>,
    ) -> Option<GpuPrimitive> {
        let (device, queue) = (&gpu.device, &gpu.queue);
        let primitive = &*in_drawing_order(primitive);
        let count = |length: usize| u32::try_from(length).ok();
        let vertex_count = count(drawn_vertices(primitive))?;
        let is_deformed = is_deformed(primitive);
        let vertices = self.vertices.take(device, vertex_count, expected.vertices)?;
        expected.vertices = expected.vertices.saturating_sub(vertex_count.into());
        let mut placed = GpuPrimitive {
            vertices,
            skin: None,
            indices: None,
            levels: Vec::new(),
            vertex_count,
            count: vertex_count,
            topology: primitive.topology,
            material: primitive.material,
            variant_materials: primitive.variant_materials.clone(),
            morph: 0..0,
            morph_count: 0,
            without_normals: primitive.topology != Topology::Triangles && primitive.normals.is_empty(),
            bounds: primitive.bounds,
            radius_m: primitive.reach_m(primitive.bounds.center()),
            parts: if is_deformed { None } else { parts_of(primitive) },
            cloud: Cloud::of(primitive).map(Arc::new),
        };
        if is_deformed {
            placed.skin = self.skins.take(device, vertex_count, expected.skins);
            expected.skins = expected.skins.saturating_sub(vertex_count.into());
        }
        if !primitive.indices.is_empty() {
            placed.count = count(primitive.indices.len())?;
            placed.indices = self.indices.take(device, placed.count, expected.indices);
            expected.indices = expected.indices.saturating_sub(placed.count.into());
        }
        if placed.skin.is_some() != is_deformed || placed.indices.is_none() != primitive.indices.is_empty() {
            self.vertices.give_back(&placed.vertices);
            placed.skin.iter().for_each(|place| self.skins.give_back(place));
            placed.indices.iter().for_each(|place| self.indices.give_back(place));
            return None;
        }
        give_turn(turns).await;
        let displacements = vertices::displacements(primitive);
        if !displacements.is_empty()
            && let Ok(range) = self.morphs.free.allocate_range(displacements.len() as u32)
        {
            self.morphs.texture.write_at(queue, range.start, &displacements);
            (placed.morph, placed.morph_count) = (range, primitive.morph_targets.len() as u32);
        }
        self.vertices.write_in_turns(queue, &placed.vertices, vertices::vertices(primitive), turns).await;
        if let Some(place) = &placed.skin {
            self.skins.write_in_turns(queue, place, vertices::skins(primitive), turns).await;
        }
        if let Some(place) = &placed.indices {
            let first = if placed.is_bound_apart() { 0 } else { placed.vertices.units.start };
            let indices = primitive.indices.iter().map(|index| index.wrapping_add(first));
            self.indices.write_in_turns(queue, place, indices, turns).await;
        }
        self.upload_levels(gpu, primitive, &mut placed, expected, turns).await;
        Some(placed)
    }
}

/// What is on the device, by what it was made from.
type MeshIndex = HashMap<*const Mesh, Arc<GpuMesh>>;

/// Every mesh once.
fn distinct(meshes: &[Arc<Mesh>]) -> impl Iterator<Item = &Arc<Mesh>> {
    let mut seen = HashSet::new();
    meshes.iter().filter(move |mesh| seen.insert(Arc::as_ptr(mesh)))
}

fn quoted(mesh: &Mesh) -> String {
    format!("`{}`", mesh.name)
}
