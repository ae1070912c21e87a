//! From objects to a scene.

use super::xml::{Item, Key, Model, Object, Property};
use crate::formats::parts::{Parts, by_material, linear, plain_material};
use crate::formats::smooth::{Smoothing, smooth, weld};
use crate::gltf_file::{LoadError, Loaded};
use crate::{AlphaMode, Material, Node, NodeId, Primitive};
use glam::{Mat4, Vec4};
use std::collections::HashMap;

/// The most nodes. A few components can ask for the product of many.
const MOST_NODES: usize = 100_000;
/// The most components within each other; more are a circle.
const MOST_LEVELS: usize = 64;

/// What is made of a property: by the part, the property and the index.
type Materials = HashMap<(String, u32, u32), usize>;

pub(super) fn scene(models: &HashMap<String, Model>, root: &str) -> Result<Loaded, LoadError> {
    let mut parts = Parts::default();
    let mut names: Vec<&String> = models.keys().collect();
    names.sort();
    names.iter().filter_map(|name| models.get(*name)).for_each(|model| {
        model.warnings.iter().for_each(|warning| parts.warn(warning.as_str()));
    });
    let Some(model) = models.get(root) else { return parts.finish() };
    let unit_m = model.unit_m;
    // Z up to Y up, as in `parts::y_up`.
    let world_from_file = Mat4::from_cols(
        Vec4::new(unit_m, 0.0, 0.0, 0.0),
        Vec4::new(0.0, 0.0, -unit_m, 0.0),
        Vec4::new(0.0, unit_m, 0.0, 0.0),
        Vec4::W,
    );
    let top = parts.scene.add_node(None, Node { matrix: Some(world_from_file), ..Node::default() });
    let (mut meshes, mut materials) = (HashMap::new(), Materials::new());
    let mut pending: Vec<(&Item, NodeId, usize)> = model.items.iter().rev().map(|item| (item, top, 0)).collect();
    while let Some((item, parent, level)) = pending.pop() {
        let (part, id) = &item.object;
        let object = models.get(part).and_then(|model| model.objects.get(id)).ok_or_else(|| {
            LoadError::malformed("", format!("object {id} is named, and part \"{part}\" has none such"))
        })?;
        if level > MOST_LEVELS {
            let message = format!("components lie within each other without end, object {id} of part \"{part}\" too");
            return Err(LoadError::malformed("", message));
        }
        if parts.scene.nodes.len() + pending.len() + object.components.len() > MOST_NODES {
            return Err(LoadError::malformed("", format!("it shows more than {MOST_NODES} objects; join them")));
        }
        let mesh = match object.triangles[..] {
            [] => None,
            _ => Some(match meshes.get(&item.object) {
                Some(mesh) => *mesh,
                None => {
                    let primitives = primitives(models, &item.object, object, &mut materials, &mut parts);
                    let mesh = parts.mesh(&object.name, primitives);
                    meshes.insert(item.object.clone(), mesh);
                    mesh
                }
            }),
        };
        let node = Node { name: object.name.clone(), matrix: Some(item.parent_from_object), mesh, ..Node::default() };
        let node = parts.scene.add_node(Some(parent), node);
        pending.extend(object.components.iter().rev().map(|component| (component, node, level + 1)));
    }
    parts.finish()
}

/// A primitive for every base material of an object, and one for what has colours at corners.
fn primitives(
    models: &HashMap<String, Model>,
    (part, _): &Key,
    object: &Object,
    materials: &mut Materials,
    parts: &mut Parts,
) -> Vec<Primitive> {
    let (positions, places) = weld(object.positions.iter().copied());
    let corners = object.triangles.iter().flat_map(|triangle| triangle.vertices);
    let indices: Vec<u32> = corners.filter_map(|vertex| places.get(vertex as usize).copied()).collect();
    let smoothed = smooth(&positions, &indices, |_| Smoothing::ByAngle);
    let properties = models.get(part).map(|model| &model.properties);
    let colors_of = |property: u32| match properties.and_then(|properties| properties.get(&property)) {
        Some(Property::Colors(colors)) => Some(colors),
        _ => None,
    };
    let of_triangle: Vec<usize> = object
        .triangles
        .iter()
        .map(|triangle| {
            let property = properties.and_then(|properties| properties.get(&triangle.property));
            // A base is a material of its own, whatever it looks like.
            let key = match property {
                Some(Property::Bases(_)) => (part.clone(), triangle.property, triangle.indices[0]),
                Some(Property::Colors(_)) => (String::new(), 0, 0),
                None => (String::new(), 0, 1),
            };
            *materials.entry(key).or_insert_with(|| {
                let material = material(property, triangle.indices[0], parts);
                parts.scene.materials.push(material);
                parts.scene.materials.len() - 1
            })
        })
        .collect();
    let color = |corner: usize| {
        let triangle = object.triangles.get(corner / 3)?;
        let index = triangle.indices.get(corner % 3).copied().unwrap_or_default();
        Some((triangle.property, index, colors_of(triangle.property)?.get(index as usize).copied()))
    };
    let normal_of = |corner: usize| smoothed.indices.get(corner).copied().unwrap_or_default() as usize;
    by_material(
        &of_triangle,
        |corner| (normal_of(corner), color(corner).map(|(property, index, _)| (property, index))),
        |primitive, corner| {
            let place = smoothed.source.get(normal_of(corner)).copied().unwrap_or_default() as usize;
            primitive.positions.push(positions.get(place).copied().unwrap_or_default());
            primitive.normals.push(smoothed.normals.get(normal_of(corner)).copied().unwrap_or([0.0, 1.0, 0.0]));
            if let Some((_, _, color)) = color(corner) {
                primitive.colors.push(color.map_or([1.0; 4], linear));
            }
        },
    )
}

fn material(property: Option<&Property>, index: u32, parts: &mut Parts) -> Material {
    match property {
        None => plain_material(false),
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
