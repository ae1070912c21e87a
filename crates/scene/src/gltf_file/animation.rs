//! Animations: channels with their keyframes.

use super::accessor::{Component, to_f32};
use super::{Document, LoadError, json::Json};
use crate::{Animation, Channel, Interpolation, Keyframes, NodeId, Scene};
use glam::{Quat, Vec3};

/// Every animation.
pub(super) fn read_animations(document: &mut Document, scene: &mut Scene) -> Result<(), LoadError> {
    for json in document.root.objects("animations")? {
        let samplers = json.objects("samplers")?;
        let mut animation = Animation { name: json.name()?, channels: Vec::new() };
        for channel in json.objects("channels")? {
            let sampler = channel.index("sampler", samplers.len(), "sampler")?.and_then(|i| samplers.get(i));
            let sampler = sampler.ok_or_else(|| channel.error("sampler", "expected the index of a sampler"))?;
            animation.channels.extend(read_channel(document, scene, &channel, sampler)?);
        }
        scene.animations.push(animation);
    }
    Ok(())
}

fn read_channel(
    document: &mut Document,
    scene: &Scene,
    channel: &Json,
    sampler: &Json,
) -> Result<Option<Channel>, LoadError> {
    let target = channel.require_object("target")?;
    let path = target.string("path")?.unwrap_or("nothing");
    let node = target.index("node", scene.nodes.len(), "node")?;
    if !["translation", "rotation", "scale", "weights"].contains(&path) {
        document.warn(&target.at("path"), &format!("{path} cannot be animated; the channel is passed over"));
        return Ok(None);
    }
    let Some(node) = node else { return Ok(None) };
    let interpolation = match sampler.string("interpolation")?.unwrap_or("LINEAR") {
        "STEP" => Interpolation::Step,
        "LINEAR" => Interpolation::Linear,
        "CUBICSPLINE" => Interpolation::CubicSpline,
        other => {
            return Err(sampler.error("interpolation", format!("expected STEP, LINEAR or CUBICSPLINE, found {other}")));
        }
    };
    let times_secs = read_times(document, sampler)?;
    let values_a_key = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    let count = times_secs.len() * values_a_key;
    let keyframes = match path {
        "rotation" => {
            let values = read_values::<4>(document, sampler, count)?;
            Keyframes::Rotation(values.into_iter().map(Quat::from_array).collect())
        }
        "weights" => {
            let mesh = scene.nodes.get(node).and_then(|node| node.mesh).and_then(|mesh| scene.meshes.get(mesh));
            let targets = mesh.map_or(0, |mesh| mesh.default_morph_weights.len());
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
    Ok(Some(Channel { node: NodeId(node as u32), times_secs, interpolation, keyframes }))
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
    let values = document.read::<f32, N>(index, &sampler.at("output"), to_f32)?;
    if values.len() != count {
        return Err(sampler.error("output", format!("expected {count} elements, found {}", values.len())));
    }
    if values.iter().flatten().any(|value| !value.is_finite()) {
        return Err(sampler.error("output", "expected finite numbers"));
    }
    Ok(values)
}
