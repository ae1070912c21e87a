//! What a PLY holds, once it is read.

use super::elements::{Face, Vertex};
use crate::formats::readers::parts::{Extent, from_origin};
use glam::Vec3;

pub(super) type Resolve<'r> = dyn FnMut(&str) -> Result<Vec<u8>, String> + 'r;

/// What the elements of a file hold.
#[derive(Default)]
pub(super) struct Contents {
    pub(super) vertices: Vec<Vertex>,
    pub(super) faces: Vec<Face>,
    pub(super) strips: Vec<Face>,
    pub(super) has_vertices: bool,
    pub(super) has_faces: bool,
}

impl Contents {
    /// Tells positions from the middle of what lies away from the file's origin, and gives that; else they stay.
    pub(super) fn bring_near(&mut self) -> Vec3 {
        let mut extent = Extent::default();
        self.vertices.iter().for_each(|vertex| extent.add(vertex.place()));
        let origin = extent.origin();
        if origin != Vec3::ZERO {
            self.vertices.iter_mut().for_each(|vertex| vertex.position = from_origin(vertex.place(), origin));
        }
        origin
    }
}

/// Which attributes vertices have.
#[derive(Clone, Copy, Debug)]
pub(super) struct VertexAttributes {
    pub(super) normals: bool,
    pub(super) colors: bool,
    pub(super) uvs: bool,
}

/// Triangles, and the corner of a face that each of their corners is.
#[derive(Debug, Default)]
pub(super) struct Triangles {
    pub(super) indices: Vec<u32>,
    /// The face and its corner; only where faces have surfaces of their own.
    pub(super) corners: Vec<(u32, u32)>,
}

/// Whether a vertex has a place.
pub(super) fn is_placed(vertex: &Vertex) -> bool {
    vertex.position.iter().all(|value| value.is_finite())
}

/// Vertices with normals: of each corner of the triangles its vertex here, and of those the former vertices.
pub(super) struct WithNormals {
    pub(super) of_corner: Vec<u32>,
    pub(super) source: Vec<u32>,
    pub(super) normals: Vec<[f32; 3]>,
}
