//! From objects to a scene.

use super::package::Package;
use super::xml::{Item, Key, Model, Object, Property, TextureFile, Triangle};
use crate::formats::readers::image_files::{ImageFiles, texture};
use crate::formats::readers::parts::{Parts, by_material, linear, plain_material};
use crate::formats::readers::smooth::{Smoothing, smooth, weld};
use crate::gltf_file::{LoadError, LoadedScene};
use crate::{AlphaMode, Material, Node, NodeId, Primitive, Scene, TextureRef, TextureTransform};
use glam::{DMat4, DVec4, Vec3, Vec4};
use std::collections::{BTreeSet, HashMap};

/// The most objects that are shown. A few components can ask for the product of many.
const MOST_NODES: u64 = 20_000;
/// The most triangles that are shown, counted once for every object that has them.
const MOST_TRIANGLES: u64 = 100_000_000;
/// The most components within each other; more are a circle.
const MOST_LEVELS: usize = 64;
/// So many base materials are materials of their own; more are colours of vertices.
const MOST_BASES: usize = 1000;

/// What is made of a property: by the part, the property and the index.
type Materials = HashMap<(String, u32, u32), usize>;

/// Objects and triangles that an object shows.
type ShapeCounts = (u64, u64);

/// Counts what an object shows, before anything is made of it.
fn shown<'m>(
    models: &'m HashMap<String, Model>,
    key: &'m Key,
    level: usize,
    known: &mut HashMap<&'m Key, ShapeCounts>,
) -> Result<ShapeCounts, LoadError> {
    if let Some(known) = known.get(key) {
        return Ok(*known);
    }
    let (part, id) = key;
    let object = models
        .get(part)
        .and_then(|model| model.objects.get(id))
        .ok_or_else(|| LoadError::malformed("", format!("object {id} is named, and part \"{part}\" has none such")))?;
    if level > MOST_LEVELS {
        let message = format!("components lie within each other without end, object {id} of part \"{part}\" too");
        return Err(LoadError::malformed("", message));
    }
    let mut sum: ShapeCounts = (1, object.triangles.len() as u64);
    for component in &object.components {
        let (nodes, triangles) = shown(models, &component.object, level + 1, known)?;
        sum = (sum.0.saturating_add(nodes), sum.1.saturating_add(triangles));
    }
    known.insert(key, sum);
    Ok(sum)
}

pub(super) fn scene(
    models: &HashMap<String, Model>,
    root: &str,
    package: &mut Package,
) -> Result<LoadedScene, LoadError> {
    let mut parts = Parts::default();
    let mut names: Vec<&String> = models.keys().collect();
    names.sort();
    names.iter().filter_map(|name| models.get(*name)).for_each(|model| {
        model.warnings.clone().into_lines().iter().for_each(|warning| parts.warn(warning));
    });
    let Some(model) = models.get(root) else { return parts.finish() };
    let (mut nodes, mut triangles, mut known) = (0_u64, 0_u64, HashMap::new());
    for item in &model.items {
        let of_item = shown(models, &item.object, 0, &mut known)?;
        (nodes, triangles) = (nodes.saturating_add(of_item.0), triangles.saturating_add(of_item.1));
    }
    for (count, most, what) in [(nodes, MOST_NODES, "objects"), (triangles, MOST_TRIANGLES, "triangles")] {
        if count > most {
            let message = format!("it shows {count} {what}, and {most} are possible; join or leave out some");
            return Err(LoadError::malformed("", message));
        }
    }
    let unit_m = model.unit_m;
    // Z up to Y up, as in `parts::y_up`.
    let world_from_file = DMat4::from_cols(
        DVec4::new(unit_m, 0.0, 0.0, 0.0),
        DVec4::new(0.0, 0.0, -unit_m, 0.0),
        DVec4::new(0.0, unit_m, 0.0, 0.0),
        DVec4::W,
    );
    let top = parts.scene.add_node(None, Node { matrix: Some(world_from_file.as_mat4()), ..Node::default() });
    let mut items = Vec::new();
    let mut surfaces = Surfaces { models, materials: Materials::new(), images: ImageFiles::default(), package };
    let mut meshes = HashMap::new();
    // With the origin of the parent's mesh, from which its node stands.
    let mut pending: Vec<(&Item, NodeId, Vec3)> =
        model.items.iter().rev().map(|item| (item, top, Vec3::ZERO)).collect();
    while let Some((item, parent, origin)) = pending.pop() {
        let (part, id) = &item.object;
        let Some(object) = models.get(part).and_then(|model| model.objects.get(id)) else { continue };
        let mesh = match object.triangles[..] {
            [] => None,
            _ => Some(match meshes.get(&item.object) {
                Some(mesh) => *mesh,
                None => {
                    let primitives = surfaces.primitives(&item.object, object, &mut parts);
                    let mesh = parts.mesh(&object.name, primitives);
                    meshes.insert(item.object.clone(), mesh);
                    mesh
                }
            }),
        };
        let from = |origin: Vec3| DMat4::from_translation(origin.as_dvec3());
        let parent_from_object = from(-origin) * item.parent_from_object * from(object.origin);
        let matrix = Some(parent_from_object.as_mat4());
        let node =
            parts.scene.add_node(Some(parent), Node { name: object.name.clone(), matrix, mesh, ..Node::default() });
        if parent == top {
            items.push((node, parent_from_object));
        }
        pending.extend(object.components.iter().rev().map(|component| (component, node, object.origin)));
    }
    place_from_middle(&mut parts.scene, (top, world_from_file), &items);
    parts.finish()
}

/// Places items that lie away from the file's origin for their size from the middle of all, so that their numbers are
/// rounded there. `items` are the nodes below `top` and where they are in the file.
fn place_from_middle(scene: &mut Scene, (top, world_from_file): (NodeId, DMat4), items: &[(NodeId, DMat4)]) {
    scene.update_transforms();
    let bounds = scene.bounds_world();
    if !scene.is_away(&bounds) {
        return;
    }
    let middle_m = bounds.center().as_dvec3();
    let middle = world_from_file.inverse().transform_point3(middle_m);
    let matrix = DMat4::from_translation(middle_m) * world_from_file;
    scene.node_mut(top).matrix = Some(matrix.as_mat4());
    for (node, file_from_object) in items {
        let matrix = DMat4::from_translation(-middle) * *file_from_object;
        scene.node_mut(*node).matrix = Some(matrix.as_mat4());
    }
}

/// What triangles look like: materials that are made once for all objects.
struct Surfaces<'m, 'p, 'a> {
    models: &'m HashMap<String, Model>,
    materials: Materials,
    images: ImageFiles,
    package: &'p mut Package<'a>,
}

impl Surfaces<'_, '_, '_> {
    /// A primitive for every base material and texture of an object, and one for what has colours at corners.
    fn primitives(&mut self, (part, _): &Key, object: &Object, parts: &mut Parts) -> Vec<Primitive> {
        let (positions, places) = weld(object.positions.iter().copied());
        let corners = object.triangles.iter().flat_map(|triangle| triangle.vertices);
        let indices: Vec<u32> = corners.filter_map(|vertex| places.get(vertex as usize).copied()).collect();
        let smoothed = smooth(&positions, &indices, |_| Smoothing::ByAngle);
        let of_triangle: Vec<usize> =
            object.triangles.iter().map(|triangle| self.material_of(part, triangle, parts)).collect();
        let properties = self.models.get(part).map(|model| &model.properties);
        let property_of = |property: u32| properties.and_then(|properties| properties.get(&property));
        let has_texture = |material: usize| {
            parts.scene.materials.get(material).is_some_and(|material| material.base_color_texture.is_some())
        };
        let textured: Vec<bool> = of_triangle.iter().map(|material| has_texture(*material)).collect();
        // Colours of vertices are those of groups, and of bases that are no materials of their own.
        let overflowing: BTreeSet<usize> =
            OVERFLOWING.iter().filter_map(|key| self.materials.get(&(String::new(), 0, *key)).copied()).collect();
        let corner_of = |corner: usize| {
            let triangle = object.triangles.get(corner / 3)?;
            let index = triangle.indices.get(corner % 3).copied().unwrap_or_default();
            Some((triangle, index, property_of(triangle.property)?))
        };
        let color = |corner: usize| match corner_of(corner)? {
            (_, index, Property::Colors(colors)) => Some(colors.get(index as usize).copied().map_or([1.0; 4], linear)),
            (triangle, _, Property::Bases(bases)) if overflowing.contains(of_triangle.get(corner / 3)?) => {
                Some(bases.get(triangle.indices[0] as usize).map_or([1.0; 4], |(_, color)| linear(*color)))
            }
            _ => None,
        };
        let uv = |corner: usize| match corner_of(corner)? {
            (_, index, Property::Coordinates { uvs, .. }) if textured.get(corner / 3) == Some(&true) => {
                let [u, v] = uvs.get(index as usize).copied().unwrap_or_default();
                Some([u, 1.0 - v])
            }
            _ => None,
        };
        let normal_of = |corner: usize| smoothed.indices.get(corner).copied().unwrap_or_default() as usize;
        by_material(
            &of_triangle,
            |corner| {
                let looked_up = color(corner).is_some() || uv(corner).is_some();
                let look =
                    corner_of(corner).filter(|_| looked_up).map(|(triangle, index, _)| (triangle.property, index));
                (normal_of(corner), look)
            },
            |primitive, corner| {
                let place = smoothed.source.get(normal_of(corner)).copied().unwrap_or_default() as usize;
                primitive.positions.push(positions.get(place).copied().unwrap_or_default());
                primitive.normals.push(smoothed.normals.get(normal_of(corner)).copied().unwrap_or([0.0, 1.0, 0.0]));
                primitive.colors.extend(color(corner));
                primitive.uv0.extend(uv(corner));
            },
        )
    }

    /// The material of a triangle.
    fn material_of(&mut self, part: &str, triangle: &Triangle, parts: &mut Parts) -> usize {
        let model = self.models.get(part);
        let property = model.and_then(|model| model.properties.get(&triangle.property));
        let index = triangle.indices[0];
        let mut key = match property {
            // A base is a material of its own, whatever it looks like.
            Some(Property::Bases(_)) => (part.to_owned(), triangle.property, index),
            Some(Property::Coordinates { .. }) => (part.to_owned(), triangle.property, 0),
            Some(Property::Colors(_)) => (String::new(), 0, 0),
            None => (String::new(), 0, 1),
        };
        if let Some(material) = self.materials.get(&key) {
            return *material;
        }
        let material = match property {
            Some(Property::Bases(bases)) if self.materials.len() >= MOST_BASES => {
                parts.warn(format!("it uses more than {MOST_BASES} materials; the others are colours of vertices"));
                let is_opaque = bases.get(index as usize).is_none_or(|(_, color)| color[3] == 1.0);
                let [opaque, blended] = OVERFLOWING;
                key = (String::new(), 0, if is_opaque { opaque } else { blended });
                let alpha_mode = if is_opaque { AlphaMode::Opaque } else { AlphaMode::Blend };
                Material { alpha_mode, ..plain_material(true) }
            }
            Some(Property::Coordinates { texture, .. }) => match model.and_then(|model| model.textures.get(texture)) {
                Some(file) => self.textured(file, parts),
                None => {
                    parts.warn(format!("texture {texture} is named but missing; it is drawn grey"));
                    plain_material(false)
                }
            },
            property => material(property, index, parts),
        };
        *self.materials.entry(key).or_insert_with(|| {
            parts.scene.materials.push(material);
            parts.scene.materials.len() - 1
        })
    }

    /// The material of a texture; grey where it cannot be read.
    fn textured(&mut self, file: &TextureFile, parts: &mut Parts) -> Material {
        let package = &mut *self.package;
        let mut resolve = |name: &str| package.read_bytes(name).map_err(|error| error.to_string());
        let Some(image) = self.images.image(&file.path, parts, &mut resolve) else { return plain_material(false) };
        let texture = texture(parts, image, file.sampler);
        let reference = TextureRef { texture, uv_set: 0, transform: TextureTransform::default() };
        Material { base_color_texture: Some(reference), ..plain_material(true) }
    }
}

/// The keys of the materials below bases that are colours of vertices: opaque, blended.
const OVERFLOWING: [u32; 2] = [2, 3];

fn material(property: Option<&Property>, index: u32, parts: &mut Parts) -> Material {
    match property {
        None | Some(Property::Coordinates { .. }) => plain_material(false),
        Some(Property::Colors(_)) => plain_material(true),
        Some(Property::Bases(bases)) => match bases.get(index as usize) {
            Some((name, color_srgb)) => {
                let color = linear(*color_srgb);
                let alpha_mode = if color[3] < 1.0 { AlphaMode::Blend } else { AlphaMode::Opaque };
                let base_color_factor = Vec4::from(color);
                Material { name: name.clone(), base_color_factor, alpha_mode, ..plain_material(true) }
            }
            None => {
                parts.warn(format!("base material {index} is named, and there are {}; it is drawn grey", bases.len()));
                plain_material(false)
            }
        },
    }
}
