//! Cameras that a stage names.

use super::table::{Source, SpannedValue};
use crate::{Diagnostic, NodeId, Scene};

/// The node that holds a camera of a name, its own or the camera's.
pub(super) fn camera_called(
    source: &Source,
    scene: &Scene,
    named: &SpannedValue<String>,
) -> Result<NodeId, Box<Diagnostic>> {
    let name_of = |camera: usize| scene.cameras.get(camera).map_or("", |camera| camera.name.as_str());
    let holders = || (0..).zip(&scene.nodes).filter_map(|(id, node)| Some((NodeId(id), node, node.camera?)));
    let of_node = holders().find(|(_, node, _)| node.name == named.value);
    let found = of_node.or_else(|| holders().find(|(.., camera)| name_of(*camera) == named.value));
    let Some((id, ..)) = found else {
        let known: Vec<&str> = holders().flat_map(|(_, node, camera)| [node.name.as_str(), name_of(camera)]).collect();
        let names = known.into_iter().filter(|name| !name.is_empty());
        let message = format!("the model has no camera called `{}`", named.value);
        return Err(source.unknown(named.range.clone(), message, &named.value, names));
    };
    Ok(id)
}
