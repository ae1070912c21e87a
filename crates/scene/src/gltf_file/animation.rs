//! Animations: channels with their keyframes.

mod pointer;

use super::accessor::to_f32;
use super::component::Component;
use super::document::Document;
use super::error::LoadError;
use super::json::Json;
use crate::animation::{MaterialFactor, Property, PropertyChannel};
use crate::{Animation, Channel, Interpolation, Keyframes, NodeId, Scene};
use glam::{Quat, Vec3};
use pointer::NODE_PATHS;
use std::collections::HashSet;

/// Every animation.
pub(super) fn read_animations(document: &mut Document, scene: &mut Scene) -> Result<(), LoadError> {
    for json in document.root.objects("animations")? {
        // The model can be drawn without what moves it.
        let animation = read_animation(document, scene, &json).unwrap_or_else(|error| {
            let pointer = error.pointer().to_owned();
            document.warn(&pointer, &format!("{}; the animation moves nothing", error.into_message()));
            Animation { name: json.name(), ..Animation::default() }
        });
        scene.animations.push(animation);
    }
    Ok(())
}

fn read_animation(document: &mut Document, scene: &Scene, json: &Json) -> Result<Animation, LoadError> {
    let (samplers, channels) = (json.objects("samplers")?, json.objects("channels")?);
    let mut animation = Animation { name: json.name(), ..Animation::default() };
    for channel in channels {
        match read_channel(document, scene, &channel, &samplers) {
            Ok(Some(AnyChannel::Node(channel))) => animation.channels.push(channel),
            Ok(Some(AnyChannel::Property(channel))) => animation.properties.push(channel),
            Ok(None) => {}
            Err(error) => {
                let pointer = error.pointer().to_owned();
                document.warn(&pointer, &format!("{}; the channel is passed over", error.into_message()));
            }
        }
    }
    settle_emission(document, &mut animation)?;
    Ok(animation)
}

/// A channel of whatever kind.
enum AnyChannel {
    Node(Channel),
    Property(PropertyChannel),
}

fn read_channel(
    document: &mut Document,
    scene: &Scene,
    channel: &Json,
    samplers: &[Json],
) -> Result<Option<AnyChannel>, LoadError> {
    let sampler = channel.index("sampler", samplers.len(), "sampler")?.and_then(|i| samplers.get(i));
    let sampler = sampler.ok_or_else(|| channel.error("sampler", "expected the index of a sampler"))?;
    let target = channel.require_object("target")?;
    let path = target.string("path")?.unwrap_or("nothing");
    let node = target.index("node", scene.nodes.len(), "node")?;
    if let Some(extension) = target.extension("KHR_animation_pointer")? {
        let pointer = extension.string("pointer")?.unwrap_or_default();
        let read = match pointer::target(pointer, scene) {
            Some(pointer::Target::Node(node, path)) => read_node(document, scene, &target, sampler, (node, path)),
            Some(pointer::Target::Property(property)) => read_property(document, sampler, property).map(Some),
            None => {
                let message = format!("\"{pointer}\" cannot be animated; the channel is passed over");
                document.warn(&extension.at("pointer"), &message);
                return Ok(None);
            }
        };
        return read;
    }
    if !NODE_PATHS.contains(&path) {
        document.warn(&target.at("path"), &format!("{path} cannot be animated; the channel is passed over"));
        return Ok(None);
    }
    let Some(node) = node else { return Ok(None) };
    read_node(document, scene, &target, sampler, (node, path))
}

fn read_node(
    document: &mut Document,
    scene: &Scene,
    target: &Json,
    sampler: &Json,
    (node, path): (usize, &str),
) -> Result<Option<AnyChannel>, LoadError> {
    let mesh = scene.nodes.get(node).and_then(|node| node.mesh).and_then(|mesh| scene.meshes.get(mesh));
    let targets = mesh.map_or(0, |mesh| mesh.default_morph_weights.len());
    let of_key = if path == "weights" { targets.max(1) } else { 1 };
    let Keys { times_secs, interpolation, count } = Keys::read(document, sampler, of_key)?;
    let keyframes = match path {
        "rotation" => {
            let values = read_values::<4>(document, sampler, count)?;
            Keyframes::Rotation(values.into_iter().map(Quat::from_array).collect())
        }
        "weights" => {
            if targets == 0 {
                document.warn(&target.at("node"), "the node has no morph targets; the channel is passed over");
                return Ok(None);
            }
            let values = read_values::<1>(document, sampler, count.saturating_mul(targets))?;
            Keyframes::MorphWeights { count: targets, values: values.into_iter().flatten().collect() }
        }
        _ => {
            let values = read_values::<3>(document, sampler, count)?.into_iter().map(Vec3::from).collect();
            if path == "scale" { Keyframes::Scale(values) } else { Keyframes::Translation(values) }
        }
    };
    Ok(Some(AnyChannel::Node(Channel { node: NodeId(node as u32), times_secs, interpolation, keyframes })))
}

/// When the keyframes of a sampler are, what is between them, and how many values they have.
struct Keys {
    times_secs: Vec<f32>,
    interpolation: Interpolation,
    count: usize,
}

impl Keys {
    /// `values_of_key` are the elements of a value: as many as there are morph targets, or 1.
    fn read(document: &mut Document, sampler: &Json, values_of_key: usize) -> Result<Self, LoadError> {
        let interpolation = match sampler.string("interpolation")?.unwrap_or("LINEAR") {
            "STEP" => Interpolation::Step,
            "LINEAR" => Interpolation::Linear,
            "CUBICSPLINE" => Interpolation::CubicSpline,
            other => {
                let message = format!("expected STEP, LINEAR or CUBICSPLINE, found {other}; LINEAR is used");
                document.warn(&sampler.at("interpolation"), &message);
                Interpolation::Linear
            }
        };
        let mut times_secs = read_times(document, sampler)?;
        let values_a_key = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        let mut count = times_secs.len() * values_a_key;
        let found = document.accessor_header(accessor(document, sampler, "output")?, &sampler.at("output"))?.count;
        let of_key = values_a_key * values_of_key;
        if found < count.saturating_mul(values_of_key) && found >= of_key {
            let keys = found / of_key;
            let message = format!("{} keyframes have {found} values; the first {keys} are used", times_secs.len());
            document.warn(&sampler.at("output"), &message);
            times_secs.truncate(keys);
            count = keys * values_a_key;
        }
        Ok(Self { times_secs, interpolation, count })
    }
}

fn read_property(document: &mut Document, sampler: &Json, property: Property) -> Result<AnyChannel, LoadError> {
    let Keys { times_secs, interpolation, count } = Keys::read(document, sampler, 1)?;
    let values = match property.components() {
        1 => read_values::<1>(document, sampler, count)?.into_flattened(),
        2 => read_values::<2>(document, sampler, count)?.into_flattened(),
        3 => read_values::<3>(document, sampler, count)?.into_flattened(),
        _ => read_values::<4>(document, sampler, count)?.into_flattened(),
    };
    Ok(AnyChannel::Property(PropertyChannel { property, times_secs, interpolation, values }))
}

/// Where only one of a material's emission and its strength moves, the other is as the material has it; both multiply
/// each other.
fn settle_emission(document: &Document, animation: &mut Animation) -> Result<(), LoadError> {
    let moved: HashSet<Property> = animation.properties.iter().map(|channel| channel.property).collect();
    let materials = if moved.is_empty() { Vec::new() } else { document.root.objects("materials")? };
    let moves = |material, factor| moved.contains(&Property::Material(material, factor));
    for channel in &mut animation.properties {
        match channel.property {
            Property::Material(material, MaterialFactor::Emissive)
                if !moves(material, MaterialFactor::EmissiveStrength) =>
            {
                let (_, strength) = emission(materials.get(material))?;
                channel.values.iter_mut().for_each(|value| *value *= strength);
            }
            Property::Material(material, MaterialFactor::EmissiveStrength)
                if !moves(material, MaterialFactor::Emissive) =>
            {
                let (factor, _) = emission(materials.get(material))?;
                channel.property = Property::Material(material, MaterialFactor::Emissive);
                channel.values = channel.values.iter().flat_map(|strength| (factor * *strength).to_array()).collect();
            }
            _ => {}
        }
    }
    Ok(())
}

/// The emission of a material, and its strength.
fn emission(material: Option<&Json>) -> Result<(Vec3, f32), LoadError> {
    let Some(json) = material else { return Ok((Vec3::ZERO, 1.0)) };
    let factor = Vec3::from(json.numbers("emissiveFactor")?.unwrap_or([0.0; 3]));
    let extension = json.extension("KHR_materials_emissive_strength")?;
    let strength = extension.map(|extension| extension.number("emissiveStrength")).transpose()?.flatten();
    Ok((factor, strength.unwrap_or(1.0)))
}

fn accessor(document: &Document, sampler: &Json, key: &str) -> Result<usize, LoadError> {
    let index = sampler.index(key, document.accessors.len(), "accessor")?;
    index.ok_or_else(|| sampler.error(key, "expected the index of an accessor"))
}

fn read_times(document: &mut Document, sampler: &Json) -> Result<Vec<f32>, LoadError> {
    let index = accessor(document, sampler, "input")?;
    if document.accessor_header(index, &sampler.at("input"))?.component != Component::F32 {
        return Err(sampler.error("input", "expected times as floats"));
    }
    let times: Vec<f32> = document.read::<f32, 1>(index, &sampler.at("input"), to_f32)?.into_iter().flatten().collect();
    let ascending = times.windows(2).all(|pair| matches!(pair, [a, b] if a < b));
    if !ascending || times.iter().any(|time| !time.is_finite() || *time < 0.0) {
        return Err(sampler.error("input", "expected ascending, finite times from 0"));
    }
    Ok(times)
}

fn read_values<const N: usize>(
    document: &mut Document,
    sampler: &Json,
    count: usize,
) -> Result<Vec<[f32; N]>, LoadError> {
    let index = accessor(document, sampler, "output")?;
    let mut values = document.read::<f32, N>(index, &sampler.at("output"), to_f32)?;
    if values.len() > count {
        document
            .warn(&sampler.at("output"), &format!("expected {count} elements, found more; the rest is passed over"));
        values.truncate(count);
    }
    if values.len() != count {
        return Err(sampler.error("output", format!("expected {count} elements, found {}", values.len())));
    }
    if values.iter().flatten().any(|value| !value.is_finite()) {
        return Err(sampler.error("output", "expected finite numbers"));
    }
    Ok(values)
}
