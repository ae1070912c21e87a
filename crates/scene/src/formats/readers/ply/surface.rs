//! How the triangles of a PLY look: colours of vertices or faces, and textures with coordinates of either.

use super::contents::{Contents, Resolve, Triangles, VertexAttributes, WithNormals, is_placed};
use super::elements::{Surface, Vertex};
use crate::formats::readers::image_files::{ImageFiles, texture};
use crate::formats::readers::mtl::NamedFile;
use crate::formats::readers::parts::{Parts, by_material, linear, plain_material};
use crate::{Material, Primitive, Sampler, TextureRef, TextureTransform};
use glam::Vec4;
use ply_rs_bw::ply::{Header, PropertyAccess as _};

/// The most textures of a file.
const MOST_TEXTURES: usize = 256;

/// What a file has, by its header.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surfaces {
    of_vertices: VertexAttributes,
    /// Texture coordinates of the corners of faces, which come before those of vertices.
    has_wedges: bool,
    /// Faces that say which texture they have.
    has_numbers: bool,
    /// Colours of faces, which come after those of vertices.
    has_face_colors: bool,
}

/// Adds a vertex but for its normal. What is no number is 0, or white.
pub(super) fn set_attributes(primitive: &mut Primitive, vertex: &Vertex, has: VertexAttributes) {
    primitive.positions.push(vertex.position);
    if has.colors {
        primitive.colors.push(light(vertex.color_srgb));
    }
    if has.uvs {
        primitive.uv0.push(uv_down(vertex.uv));
    }
}

/// The light of a colour; white where it is no colour.
fn light(color_srgb: [f32; 4]) -> [f32; 4] {
    linear(color_srgb.map(|value| if value.is_finite() { value } else { 1.0 }))
}

/// The file's v points up, and that of textures down.
fn uv_down([u, v]: [f32; 2]) -> [f32; 2] {
    let finite = |value: f32| if value.is_finite() { value } else { 0.0 };
    [finite(u), 1.0 - finite(v)]
}

impl Surfaces {
    pub(super) fn of(header: &Header, of_vertices: VertexAttributes) -> Self {
        let has = |name| header.elements.get("face").is_some_and(|face| face.properties.contains_key(name));
        Self {
            of_vertices,
            has_wedges: has("texcoord"),
            has_numbers: has("texnumber"),
            has_face_colors: has("red") && !of_vertices.colors,
        }
    }

    /// Whether corners and faces have more than their vertices.
    pub(super) fn are_of_faces(self) -> bool {
        self.has_wedges || self.has_numbers || self.has_face_colors
    }

    /// A material for every texture; one without if there are none, or none that is looked up.
    pub(super) fn materials(self, textures: &[NamedFile], parts: &mut Parts, resolve: &mut Resolve) -> Vec<usize> {
        let has_uvs = self.has_wedges || self.of_vertices.uvs;
        let plain = plain_material(self.of_vertices.colors || self.has_face_colors);
        if let (Some(first), false) = (textures.first(), has_uvs) {
            parts.warn(format!(
                "no vertex and no face has coordinates on the texture \"{}\"; it is not drawn",
                first.path
            ));
        }
        let mut images = ImageFiles::default();
        let mut materials = Vec::new();
        for named in textures.iter().take(if has_uvs { MOST_TEXTURES } else { 0 }) {
            named.warn("", &mut parts.warnings);
            let image = images.image(&named.path, parts, resolve);
            let reference = image.map(|image| TextureRef {
                texture: texture(parts, image, Sampler::default()),
                uv_set: 0,
                transform: TextureTransform::default(),
            });
            let base_color_factor = if image.is_some() { Vec4::ONE } else { plain.base_color_factor };
            let material = Material { base_color_texture: reference, base_color_factor, ..plain.clone() };
            materials.push(parts.material(material));
        }
        if materials.is_empty() {
            materials.push(parts.material(plain));
        }
        materials
    }

    /// A primitive for every material.
    pub(super) fn primitives(
        self,
        contents: &Contents,
        triangles: &Triangles,
        with_normals: &WithNormals,
        materials: &[usize],
    ) -> Vec<Primitive> {
        let first = materials.first().copied().unwrap_or_default();
        let vertex_of = |index: u32| {
            let vertex =
                with_normals.source.get(index as usize).and_then(|vertex| contents.vertices.get(*vertex as usize));
            vertex.filter(|vertex| is_placed(vertex)).copied()
        };
        let nowhere = Vertex::new();
        if !self.are_of_faces() {
            let mut primitive = Primitive { material: Some(first), ..Primitive::default() };
            primitive.indices.clone_from(&with_normals.of_corner);
            primitive.normals.clone_from(&with_normals.normals);
            for index in 0..with_normals.source.len() as u32 {
                // A vertex at no place is one that no triangle has.
                set_attributes(&mut primitive, &vertex_of(index).unwrap_or(nowhere), self.of_vertices);
            }
            return vec![primitive];
        }
        let surface = |corner: usize| -> Option<(&Surface, u32)> {
            let (face, place) = triangles.corners.get(corner)?;
            Some((contents.faces.get(*face as usize)?.surface.as_deref()?, *place))
        };
        let material = |triangle: usize| {
            let number = surface(3 * triangle).map_or(0, |(surface, _)| surface.texture);
            materials.get(number as usize).copied().unwrap_or(first)
        };
        let of_triangle: Vec<usize> = (0..triangles.indices.len() / 3).map(material).collect();
        let wedge = |corner: usize| {
            let (surface, place) = surface(corner).filter(|_| self.has_wedges)?;
            let at = 2 * place as usize;
            Some([surface.uvs.get(at).copied()?, surface.uvs.get(at + 1).copied()?])
        };
        let color =
            |corner: usize| surface(corner).filter(|_| self.has_face_colors).map(|(surface, _)| surface.color_srgb);
        let vertex = |corner: usize| with_normals.of_corner.get(corner).copied().unwrap_or_default();
        let has = VertexAttributes {
            normals: true,
            colors: self.of_vertices.colors || self.has_face_colors,
            uvs: self.of_vertices.uvs || self.has_wedges,
        };
        by_material(
            &of_triangle,
            |corner| {
                (
                    vertex(corner),
                    wedge(corner).map(|uv| uv.map(f32::to_bits)),
                    color(corner).map(|c| c.map(f32::to_bits)),
                )
            },
            |primitive, corner| {
                let mut found = vertex_of(vertex(corner)).unwrap_or(nowhere);
                found.uv = wedge(corner).unwrap_or(found.uv);
                found.color_srgb = color(corner).unwrap_or(found.color_srgb);
                set_attributes(primitive, &found, has);
                let normal = with_normals.normals.get(vertex(corner) as usize).copied();
                primitive.normals.push(normal.unwrap_or([0.0, 1.0, 0.0]));
            },
        )
    }
}
