//! Meshes and their primitives.

use super::accessor::{to_f32, to_u32};
use super::component::Component;
use super::document::Document;
use super::error::LoadError;
use super::faults::List;
use super::json::Json;
use super::{draco, geometry};
use crate::turns::{Turns, give_turn, in_slices};
use crate::{Material, Mesh, MorphTarget, Primitive, Topology};
use glam::{Vec3, Vec4};
use std::sync::Arc;

/// Every mesh. `turns` is asked after every primitive, and between slices of a large one.
pub(super) async fn read_meshes(
    document: &mut Document<'_>,
    materials: &[Material],
    turns: &mut Turns<'_>,
) -> Result<Vec<Arc<Mesh>>, LoadError> {
    let mut meshes = Vec::new();
    for (index, json) in document.root.objects("meshes")?.iter().enumerate() {
        let read = read_mesh(document, json, materials, turns).await;
        // What another primitive packs into the same accessors is not this.
        document.unpacked.clear();
        meshes.push(Arc::new(document.faults.or(List::Meshes, index, read, Mesh::default())));
    }
    Ok(meshes)
}

async fn read_mesh(
    document: &mut Document<'_>,
    json: &Json<'_>,
    materials: &[Material],
    turns: &mut Turns<'_>,
) -> Result<Mesh, LoadError> {
    let mut mesh = Mesh {
        name: json.name(),
        primitives: Vec::new(),
        default_morph_weights: json.number_list("weights")?.unwrap_or_default(),
    };
    for primitive in json.objects("primitives")? {
        mesh.primitives.push(read_primitive(document, &primitive, materials, turns).await?);
        document.unpacked.clear();
        give_turn(turns).await;
    }
    let target_count = mesh.primitives.first().map_or(0, |primitive| primitive.morph_targets.len());
    if mesh.primitives.iter().any(|primitive| primitive.morph_targets.len() != target_count) {
        return Err(json.error("primitives", "expected the same number of morph targets in every primitive"));
    }
    if !mesh.default_morph_weights.is_empty() && mesh.default_morph_weights.len() != target_count {
        return Err(json.error("weights", format!("expected {target_count} weights, one a morph target")));
    }
    mesh.default_morph_weights.resize(target_count, 0.0);
    Ok(mesh)
}

async fn read_primitive(
    document: &mut Document<'_>,
    json: &Json<'_>,
    materials: &[Material],
    turns: &mut Turns<'_>,
) -> Result<Primitive, LoadError> {
    // Packed strips come out as lists.
    let mode = if draco::unpack(document, json)? { 4 } else { json.integer("mode")?.unwrap_or(4) };
    let topology = geometry::topology(mode);
    let topology = topology.ok_or_else(|| json.error("mode", format!("expected 0 to 6, found {mode}")))?;
    let mut primitive =
        Primitive { topology, material: json.index("material", materials.len(), "material")?, ..Primitive::default() };
    primitive.variant_materials = read_variants(document, json, materials.len())?;
    let attributes = json.require_object("attributes")?;
    read_attributes(document, &attributes, &mut primitive, turns).await?;
    let vertex_count = primitive.positions.len();
    if vertex_count == 0 {
        document.warn(&attributes.at("POSITION"), "the primitive has no positions and is not drawn");
        return Ok(Primitive { topology, material: primitive.material, ..Primitive::default() });
    }
    for target in json.objects("targets")? {
        let positions = read_floats(document, &target, "POSITION", vertex_count, turns).await?;
        let normals = read_floats(document, &target, "NORMAL", vertex_count, turns).await?;
        let tangents = read_floats(document, &target, "TANGENT", vertex_count, turns).await?;
        primitive.morph_targets.push(MorphTarget { positions, normals, tangents });
    }

    let indices = read_indices(document, json, vertex_count, turns).await?;
    document.spend(indices.len() as u64 * 12, &json.at("indices"))?;
    let drawn = indices.len();
    primitive.indices = geometry::to_list(mode, indices);
    if (mode == 1 && drawn % 2 != 0) || (mode == 4 && drawn % 3 != 0) {
        document.warn(&json.pointer, "the number of vertices does not fit the mode; the rest is not drawn");
    }
    complete(document, json, &mut primitive, materials, turns).await?;
    primitive.bounds = geometry::bounds(&primitive);
    Ok(primitive)
}

/// Generates the normals and tangents that are missing.
async fn complete(
    document: &mut Document<'_>,
    json: &Json<'_>,
    primitive: &mut Primitive,
    materials: &[Material],
    turns: &mut Turns<'_>,
) -> Result<(), LoadError> {
    if primitive.topology != Topology::Triangles {
        return Ok(());
    }
    // A vertex takes up to 112 bytes without morph targets, and 36 more for each of them.
    let vertex_bytes = 112 + 36 * primitive.morph_targets.len() as u64;
    let unwelded_bytes = primitive.indices.len() as u64 * vertex_bytes;
    if primitive.normals.is_empty() {
        document.spend(unwelded_bytes, &json.pointer)?;
        geometry::add_flat_normals(primitive, turns).await;
    }
    let all = primitive.material.into_iter().chain(primitive.variant_materials.iter().map(|(_, material)| *material));
    let with_levels = all.flat_map(|material| {
        let coarser = materials.get(material).and_then(|material| material.levels.as_ref());
        std::iter::once(material).chain(coarser.into_iter().flat_map(|levels| levels.coarser.iter().copied()))
    });
    let uv_set = with_levels.filter_map(|material| materials.get(material)?.tangent_uv_set()).next();
    if let Some(uv_set) = uv_set.filter(|_| primitive.tangents.is_empty()) {
        document.spend(unwelded_bytes, &json.pointer)?;
        geometry::add_tangents_in_turns(primitive, uv_set, turns).await;
    }
    Ok(())
}

/// The variants that give the primitive another material.
fn read_variants(document: &Document, json: &Json, material_count: usize) -> Result<Vec<(usize, usize)>, LoadError> {
    let Some(extension) = json.extension("KHR_materials_variants")? else { return Ok(Vec::new()) };
    let count = document.variants.len();
    let mut materials = Vec::new();
    for mapping in extension.objects("mappings")? {
        let Some(material) = mapping.index("material", material_count, "material")? else { continue };
        let variants = mapping.indices("variants", count, "variant")?;
        materials.extend(variants.into_iter().map(|variant| (variant, material)));
    }
    Ok(materials)
}

/// The sets of attributes that are read of every primitive.
const READ_SETS: [&str; 7] = ["JOINTS_0", "JOINTS_1", "WEIGHTS_0", "WEIGHTS_1", "COLOR_0", "TEXCOORD_0", "TEXCOORD_1"];

/// The names of the UV sets that the material of a primitive is on.
fn uv_keys(document: &mut Document, primitive: &Primitive) -> [String; 2] {
    let of_material = |material: usize| document.uv_sets.get(material).copied().unwrap_or([0, 1]);
    let sets = primitive.material.map_or([0, 1], of_material);
    let others = primitive.variant_materials.iter().map(|(_, material)| of_material(*material));
    if others.into_iter().any(|others| others != sets) {
        document
            .warn("/meshes", "variants of a primitive are on other UV sets than its own material; that one's are read");
    }
    sets.map(|set| format!("TEXCOORD_{set}"))
}

async fn read_attributes(
    document: &mut Document<'_>,
    json: &Json<'_>,
    primitive: &mut Primitive,
    turns: &mut Turns<'_>,
) -> Result<(), LoadError> {
    let [uv0, uv1] = uv_keys(document, primitive);
    for key in json.keys() {
        json.index(key, document.accessors.len(), "accessor")?;
        let is_set = ["JOINTS_", "WEIGHTS_", "TEXCOORD_", "COLOR_"].iter().any(|start| key.starts_with(start));
        let is_read = READ_SETS.contains(&key) || key == uv0 || key == uv1;
        if is_set && !is_read {
            document.warn(&json.at(key), "not read; the attribute is passed over");
        }
    }
    let Some(position) = json.integer("POSITION")? else { return Ok(()) };
    let count = document.accessor_header(position, &json.at("POSITION"))?.count;
    primitive.positions = read_floats(document, json, "POSITION", count, turns).await?;
    primitive.normals = read_floats(document, json, "NORMAL", count, turns).await?;
    let mut bad_normals = false;
    let make_unit = |normal: &mut [f32; 3]| {
        let unit = Vec3::from(*normal).try_normalize();
        bad_normals |= unit.is_none();
        *normal = unit.unwrap_or(Vec3::Z).to_array();
    };
    change_each(&mut primitive.normals, turns, make_unit).await;
    if bad_normals {
        document.warn(&json.at("NORMAL"), "some normals have no direction; they point along +Z instead");
    }
    primitive.tangents = read_floats(document, json, "TANGENT", count, turns).await?;
    let make_unit = |tangent: &mut [f32; 4]| {
        let [x, y, z, w] = *tangent;
        let unit = Vec3::new(x, y, z).try_normalize().unwrap_or(Vec3::X);
        *tangent = unit.extend(if w < 0.0 { -1.0 } else { 1.0 }).to_array();
    };
    change_each(&mut primitive.tangents, turns, make_unit).await;
    primitive.uv0 = read_floats(document, json, &uv0, count, turns).await?;
    primitive.uv1 = read_floats(document, json, &uv1, count, turns).await?;
    primitive.colors = read_colors(document, json, count, turns).await?;
    read_joints(document, json, primitive, count, turns).await
}

/// Changes every value of a list, slice by slice.
async fn change_each<T>(values: &mut [T], turns: &mut Turns<'_>, change: impl FnMut(&mut T)) {
    let count = values.len();
    let (mut left, mut change) = (values.iter_mut(), change);
    in_slices(count, turns, |range| left.by_ref().take(range.len()).for_each(&mut change)).await;
}

/// Checks the count of an attribute's accessor; none if there is no such attribute.
fn attribute(
    document: &Document,
    json: &Json,
    key: &str,
    count: usize,
) -> Result<Option<(usize, super::accessor::Header)>, LoadError> {
    let Some(index) = json.index(key, document.accessors.len(), "accessor")? else { return Ok(None) };
    let header = document.accessor_header(index, &json.at(key))?;
    if header.count != count {
        let message = format!("expected {count} elements, as many as positions, found {}", header.count);
        return Err(json.error(key, message));
    }
    Ok(Some((index, header)))
}

async fn read_floats<const N: usize>(
    document: &mut Document<'_>,
    json: &Json<'_>,
    key: &str,
    count: usize,
    turns: &mut Turns<'_>,
) -> Result<Vec<[f32; N]>, LoadError> {
    let Some((index, header)) = attribute(document, json, key, count)? else { return Ok(Vec::new()) };
    if header.component == Component::U32 {
        return Err(json.error(key, "expected floats or integers of 8 or 16 bits, found integers of 32 bits"));
    }
    let mut values = document.read_in_turns::<f32, N>(index, &json.at(key), to_f32, turns).await?;
    let mut broken = false;
    let mend = |value: &mut [f32; N]| {
        for part in value.iter_mut().filter(|part| !part.is_finite()) {
            *part = 0.0;
            broken = true;
        }
    };
    change_each(&mut values, turns, mend).await;
    if broken {
        document.warn(&json.at(key), "some values are not finite; they are 0 instead");
    }
    Ok(values)
}

async fn read_colors(
    document: &mut Document<'_>,
    json: &Json<'_>,
    count: usize,
    turns: &mut Turns<'_>,
) -> Result<Vec<[f32; 4]>, LoadError> {
    let mut colors: Vec<[f32; 4]> = match attribute(document, json, "COLOR_0", count)? {
        Some((_, header)) if header.width == 3 => {
            let colors = read_floats::<3>(document, json, "COLOR_0", count, turns).await?;
            colors.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect()
        }
        _ => read_floats(document, json, "COLOR_0", count, turns).await?,
    };
    let mut is_clamped = false;
    let clamp = |color: &mut [f32; 4]| {
        for value in color.iter_mut().filter(|value| !(0.0..=1.0).contains(*value)) {
            *value = value.clamp(0.0, 1.0);
            is_clamped = true;
        }
    };
    change_each(&mut colors, turns, clamp).await;
    if is_clamped {
        document.warn(&json.at("COLOR_0"), "some colours are not from 0 to 1; they are clamped");
    }
    Ok(colors)
}

/// One set of joints with their weights; empty without such a set.
async fn read_joint_set(
    document: &mut Document<'_>,
    json: &Json<'_>,
    [joints_key, weights_key]: [&str; 2],
    count: usize,
    turns: &mut Turns<'_>,
) -> Result<Vec<[(u32, f32); 4]>, LoadError> {
    let Some((index, header)) = attribute(document, json, joints_key, count)? else { return Ok(Vec::new()) };
    if !matches!(header.component, Component::U8 | Component::U16) {
        return Err(json.error(joints_key, "expected unsigned integers of 8 or 16 bits"));
    }
    let joints = document.read_in_turns::<u32, 4>(index, &json.at(joints_key), to_u32, turns).await?;
    let weights: Vec<[f32; 4]> = read_floats(document, json, weights_key, count, turns).await?;
    if weights.len() != joints.len() {
        return Err(json.error(weights_key, format!("expected weights beside {joints_key}, found nothing")));
    }
    let pairs = joints.into_iter().zip(weights);
    Ok(pairs.map(|([a, b, c, d], [s, t, u, v])| [(a, s), (b, t), (c, u), (d, v)]).collect())
}

/// Joints and weights: weights add up to 1, and a joint without weight is 0. Of eight the strongest four stay.
async fn read_joints(
    document: &mut Document<'_>,
    json: &Json<'_>,
    primitive: &mut Primitive,
    count: usize,
    turns: &mut Turns<'_>,
) -> Result<(), LoadError> {
    let mut sets = read_joint_set(document, json, ["JOINTS_0", "WEIGHTS_0"], count, turns).await?;
    if sets.is_empty() {
        return Ok(());
    }
    let second = read_joint_set(document, json, ["JOINTS_1", "WEIGHTS_1"], count, turns).await?;
    let mut is_cut = false;
    for (first, second) in sets.iter_mut().zip(second) {
        let [a, b, c, d] = *first;
        let [e, f, g, h] = second;
        let mut all = [a, b, c, d, e, f, g, h];
        all.sort_by(|(_, a), (_, b)| b.total_cmp(a));
        let [a, b, c, d, next, ..] = all;
        is_cut |= next.1 > 0.0;
        *first = [a, b, c, d];
    }
    if is_cut {
        document.warn(&json.at("JOINTS_1"), "some vertices have more than four joints; the strongest four move them");
    }
    let add = |influences: &mut [(u32, f32); 4]| {
        let influences = *influences;
        let weights = Vec4::from(influences.map(|(_, weight)| weight)).max(Vec4::ZERO);
        let sum = weights.element_sum();
        let weights = if sum > 0.0 && sum.is_finite() { weights / sum } else { Vec4::X };
        let weights = weights.to_array();
        let mut joints = [0; 4];
        for ((slot, (joint, _)), weight) in joints.iter_mut().zip(influences).zip(weights) {
            *slot = if weight > 0.0 { joint as u16 } else { 0 };
        }
        primitive.joints.push(joints);
        primitive.weights.push(weights);
    };
    change_each(&mut sets, turns, add).await;
    Ok(())
}

async fn read_indices(
    document: &mut Document<'_>,
    json: &Json<'_>,
    vertex_count: usize,
    turns: &mut Turns<'_>,
) -> Result<Vec<u32>, LoadError> {
    let Some(index) = json.index("indices", document.accessors.len(), "accessor")? else {
        let count = u32::try_from(vertex_count);
        return Ok((0..count.map_err(|_| json.error("attributes", "expected fewer than 2^32 vertices"))?).collect());
    };
    let pointer = json.at("indices");
    let header = document.accessor_header(index, &pointer)?;
    if !matches!(header.component, Component::U8 | Component::U16 | Component::U32) || header.normalized {
        return Err(json.error("indices", "expected unsigned integers that are not normalized"));
    }
    let indices = document.read_in_turns::<u32, 1>(index, &pointer, to_u32, turns).await?.into_flattened();
    match indices.iter().find(|&&index| index as usize >= vertex_count) {
        Some(index) => Err(json.error("indices", format!("index {index} is beyond the {vertex_count} vertices"))),
        None => Ok(indices),
    }
}
