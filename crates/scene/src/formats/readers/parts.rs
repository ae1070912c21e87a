//! A scene of parts: one node and one mesh each.

use crate::colour::linear_from_srgb;
use crate::gltf_file::{LoadError, LoadedScene, geometry};
use crate::scenes::MAX_DRAWN_PRIMITIVES;
use crate::tally::Tally;
use crate::{Material, Mesh, Node, NodeId, Primitive, Scene, bounds};
use glam::{DVec3, Vec3};
use std::collections::{BTreeMap, HashMap};
use std::hash::Hash;
use std::ops::Neg;

/// A scene that is being made.
#[derive(Debug, Default)]
pub(super) struct Parts {
    pub(super) scene: Scene,
    pub(super) warnings: Tally,
}

/// The colour of what has none: a cool grey that is darker than the studio's backdrop in its light and in its shade. A
/// grey of 0.6 has the backdrop's own levels on the sides that face a camera.
pub(super) const NO_COLOR_LINEAR: [f32; 4] = [0.19, 0.22, 0.26, 1.0];

/// The surface of what has no material: a grey without gloss, and white below colours of vertices. It has two sides,
/// because these formats do not say which faces are seen, and their winding is often wrong.
pub(super) fn plain_material(has_colors: bool) -> Material {
    let color_linear = if has_colors { [1.0; 4] } else { NO_COLOR_LINEAR };
    Material {
        base_color_factor: color_linear.into(),
        metallic_factor: 0.0,
        roughness_factor: 0.6,
        double_sided: true,
        ..Material::default()
    }
}

impl Parts {
    /// Warns of the whole file.
    pub(super) fn warn(&mut self, message: impl AsRef<str>) {
        self.warnings.add("", message.as_ref());
    }

    /// The index of a material like `material`, which is added if there is none like the last.
    pub(super) fn material(&mut self, material: Material) -> usize {
        match self.scene.materials.iter().position(|other| *other == material) {
            Some(index) => index,
            None => {
                self.scene.materials.push(material);
                self.scene.materials.len() - 1
            }
        }
    }

    /// The index of a material like the one at `index`, of whose surfaces the fronts alone are drawn.
    pub(super) fn one_sided(&mut self, index: usize) -> usize {
        let Some(material) = self.scene.materials.get(index) else { return index };
        let material = Material { double_sided: false, ..material.clone() };
        self.material(material)
    }

    /// Adds a mesh; gives its index.
    pub(super) fn mesh(&mut self, name: &str, mut primitives: Vec<Primitive>) -> usize {
        for primitive in &mut primitives {
            let normal_texture = primitive.material.and_then(|index| self.scene.materials.get(index)?.normal_texture);
            if let Some(normal_texture) = normal_texture {
                geometry::add_tangents(primitive, normal_texture.uv_set);
            }
            primitive.bounds = geometry::bounds(primitive);
        }
        let mesh = Mesh { name: name.to_owned(), primitives, ..Mesh::default() };
        self.scene.meshes.push(mesh.into());
        self.scene.meshes.len() - 1
    }

    /// Adds a mesh and a node that shows it.
    pub(super) fn add(&mut self, name: &str, primitives: Vec<Primitive>) -> NodeId {
        let mesh = self.mesh(name, primitives);
        self.scene.add_node(None, Node { name: name.to_owned(), mesh: Some(mesh), ..Node::default() })
    }

    /// The scene, unless it draws too much.
    ///
    /// # Errors
    /// It does.
    pub(super) fn finish(mut self) -> Result<LoadedScene, LoadError> {
        self.scene.update_transforms();
        match self.scene.drawn_primitives() {
            0 => self.warn("the file draws nothing"),
            1..=MAX_DRAWN_PRIMITIVES => {}
            count => {
                let message = format!("it draws {count} parts, and {MAX_DRAWN_PRIMITIVES} are possible; join them");
                return Err(LoadError::malformed("", message));
            }
        }
        Ok(LoadedScene { scene: self.scene, warnings: self.warnings.into_lines() })
    }
}

/// One primitive for every material of a list of triangles. Corners with the same key are one vertex, which `push` adds
/// to the attributes.
pub(super) fn by_material<K: Eq + Hash>(
    materials: &[usize],
    key: impl Fn(usize) -> K,
    mut push: impl FnMut(&mut Primitive, usize),
) -> Vec<Primitive> {
    let mut primitives: BTreeMap<usize, (Primitive, HashMap<K, u32>)> = BTreeMap::new();
    for (triangle, &material) in materials.iter().enumerate() {
        let (primitive, vertices) = primitives.entry(material).or_default();
        primitive.material = Some(material);
        for corner in 3 * triangle..3 * triangle + 3 {
            let vertex = *vertices.entry(key(corner)).or_insert_with(|| {
                push(primitive, corner);
                primitive.positions.len() as u32 - 1
            });
            primitive.indices.push(vertex);
        }
    }
    primitives.into_values().map(|(primitive, _)| primitive).collect()
}

/// The positions of a model as floats, from an origin that is given first ([`Extent::origin`]).
pub(super) fn from_middle(places: Vec<[f64; 3]>) -> (Vec3, Vec<[f32; 3]>) {
    let mut extent = Extent::default();
    places.iter().for_each(|place| extent.add(*place));
    let origin = extent.origin();
    let position = |place: [f64; 3]| from_origin(place, origin);
    (origin, places.into_iter().map(position).collect())
}

/// The box around places of a file, in doubles: in floats small things far away would have no extent.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    min: DVec3,
    max: DVec3,
}

impl Default for Extent {
    fn default() -> Self {
        Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY }
    }
}

impl Extent {
    /// Takes a place in; one that is no number is passed over.
    pub(super) fn add(&mut self, place: [f64; 3]) {
        let place = DVec3::from(place);
        if place.is_finite() {
            (self.min, self.max) = (self.min.min(place), self.max.max(place));
        }
    }

    /// The middle, rounded, if the box lies away from the file's origin ([`crate::Aabb::is_away`]); else that itself.
    pub(super) fn origin(&self) -> Vec3 {
        let center = 0.5 * (self.min + self.max);
        let radius_m = 0.5 * (self.max - self.min).length();
        if bounds::is_away(center.length() as f32, radius_m as f32) { center.as_vec3() } else { Vec3::ZERO }
    }
}

/// A place of the file from another one.
pub(super) fn from_origin(place: [f64; 3], origin: Vec3) -> [f32; 3] {
    (DVec3::from(place) - origin.as_dvec3()).as_vec3().to_array()
}

/// Where Z points up, to where Y does.
pub(super) fn y_up<T: Neg<Output = T>>([x, y, z]: [T; 3]) -> [T; 3] {
    [x, z, -y]
}

/// A colour as displays show it, as light; alpha stays.
pub(super) fn linear(color_srgb: [f32; 4]) -> [f32; 4] {
    let [r, g, b, a] = color_srgb.map(|value| value.clamp(0.0, 1.0));
    [linear_from_srgb(r), linear_from_srgb(g), linear_from_srgb(b), a]
}
