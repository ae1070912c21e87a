//! Geometry. Attributes are parallel arrays; strips, fans and loops are turned into lists when a file is read.

use crate::Aabb;
use glam::Vec3;

/// The topology of a primitive: what its indices, or its vertices in order, form.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Topology {
    /// Every vertex is a point; the renderer draws a small disc.
    Points,
    /// Every two are a segment.
    Lines,
    /// Every three are a triangle, counter-clockwise seen from the front.
    #[default]
    Triangles,
}

/// Displacements for one morph target. Each is empty or as long as `positions` of the primitive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MorphTarget {
    /// Added to positions, in metres.
    pub positions: Vec<[f32; 3]>,
    /// Added to normals.
    pub normals: Vec<[f32; 3]>,
    /// Added to the xyz of tangents.
    pub tangents: Vec<[f32; 3]>,
}

/// A level of detail of a primitive: other triangles between its vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PrimitiveLevel {
    /// Indices into the vertices of the primitive, three a triangle.
    pub indices: Vec<u32>,
    /// How far it is from the primitive, in metres of object space: of its shape, and of what normals and textures show
    /// as much as a shift by so much would. A mean over what is near; single triangles may be twice as far.
    pub error_m: f32,
}

/// One draw: vertices, indices and a material. Every attribute is empty or as long as `positions`, and every index
/// is below that length; [`crate::gltf_file`] guarantees both.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Primitive {
    /// What the indices form.
    pub topology: Topology,
    /// Positions in object space, in metres.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals in object space.
    pub normals: Vec<[f32; 3]>,
    /// Unit tangents in xyz; the sign of the bitangent `w · (n × t)` in w.
    pub tangents: Vec<[f32; 4]>,
    /// The first UV set; v points down.
    pub uv0: Vec<[f32; 2]>,
    /// The second UV set.
    pub uv1: Vec<[f32; 2]>,
    /// Linear colour and alpha that multiply the base colour, up to 65,504; half floats on the device.
    pub colors: Vec<[f32; 4]>,
    /// Indices into [`crate::Skin::joints`].
    pub joints: Vec<[u16; 4]>,
    /// The share of each joint; they add up to 1.
    pub weights: Vec<[f32; 4]>,
    /// Indices into the vertices; empty means 0, 1, 2, ….
    pub indices: Vec<u32>,
    /// Index into [`crate::Scene::materials`]; none is the default material.
    pub material: Option<usize>,
    /// What takes its place in variants: indices into [`crate::Scene::variants`] and [`crate::Scene::materials`].
    pub variant_materials: Vec<(usize, usize)>,
    /// Morph targets.
    pub morph_targets: Vec<MorphTarget>,
    /// Coarser forms of it, finer ones first; [`crate::Scene::simplify`] makes them.
    pub levels: Vec<PrimitiveLevel>,
    /// The box around `positions`, before morphing and skinning.
    pub bounds: Aabb,
}

impl Primitive {
    /// Triangles between vertices: every three of `indices` are one, counter-clockwise seen from the front. `normals`
    /// are of length 1, one for each of `positions`. The box around them follows.
    ///
    /// # Panics
    /// There are not as many normals as positions, or an index has no vertex.
    ///
    /// ```
    /// use manypass_scene::Primitive;
    ///
    /// let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let triangle = Primitive::of_triangles(corners, vec![[0.0, 0.0, 1.0]; 3], vec![0, 1, 2]);
    /// assert_eq!(triangle.bounds.max, [1.0, 1.0, 0.0].into());
    /// ```
    pub fn of_triangles(positions: Vec<[f32; 3]>, normals: Vec<[f32; 3]>, indices: Vec<u32>) -> Self {
        assert_eq!(positions.len(), normals.len(), "every vertex has a normal");
        assert!(indices.iter().all(|index| (*index as usize) < positions.len()), "every index has a vertex");
        let bounds = Aabb::from_points(positions.iter().copied().map(Vec3::from));
        Self { positions, normals, indices, bounds, ..Self::default() }
    }

    /// How far the farthest of `positions` lies from a place, in metres of object space; positions that are not finite
    /// are passed over.
    pub fn reach_m(&self, from: Vec3) -> f32 {
        let squares = self.positions.iter().map(|position| Vec3::from(*position).distance_squared(from));
        squares.filter(|square| square.is_finite()).fold(0.0, f32::max).sqrt()
    }
}

impl Default for Aabb {
    fn default() -> Self {
        Self::EMPTY
    }
}

/// A mesh: the primitives that a node draws.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// The name in the file; empty if it has none.
    pub name: String,
    /// The draws.
    pub primitives: Vec<Primitive>,
    /// The weights of the morph targets where a node gives none.
    pub default_morph_weights: Vec<f32>,
}
