//! Portals of a stage.

use super::names::Pattern;
use super::surfaces::{Rectangle, facing_rotation, nodes_called};
use super::table::{Source, SpannedValue, Table};
use crate::capture::LAYERS_ALL;
use crate::portal::{PORTALS_MAX, Portal};
use crate::{Diagnostic, Material, NodeId, Scene};
use std::ops::Range;

/// An entry of `[[portals]]`.
#[derive(Clone, Debug)]
pub(super) struct PortalEntry {
    ends: [End; 2],
    carries: Option<SpannedValue<Pattern>>,
    /// Without ends; its name may be empty.
    portal: Portal,
    range: Range<usize>,
}

/// An end.
#[derive(Clone, Debug)]
enum End {
    /// A node of the model.
    Node(SpannedValue<Pattern>),
    /// A rectangle.
    New(Rectangle),
}

impl End {
    /// From the keys that are called so.
    fn read(table: &Table<'_>, [node, position, facing]: [&'static str; 3]) -> Result<Self, Box<Diagnostic>> {
        if let Some(name) = table.text(node) {
            return match [position, facing].into_iter().find(|key| table.place(key).is_some()) {
                Some(key) => {
                    Err(table.fault(key, format!("`{node}` is a surface of the model; leave out `{key}`, or `{node}`")))
                }
                None => Ok(Self::Node(SpannedValue { value: Pattern::new(&name.value), range: name.range })),
            };
        }
        let (Some(position), Some(rotation), Some(size_m)) =
            (table.vector(position), facing_rotation(table, facing)?, table.pair("size_m"))
        else {
            let message = format!(
                "a portal has two ends: `{node}`, a flat surface of the model, or `{position}` and `{facing}`, with `size_m`"
            );
            return Err(table.source.fault(table.range.clone(), message));
        };
        Ok(Self::New(Rectangle::new(table, (position, rotation), size_m)?))
    }

    /// Its node.
    fn put(&self, source: &Source, scene: &mut Scene, name: &str) -> Result<NodeId, Box<Diagnostic>> {
        match self {
            Self::New(rectangle) => {
                let material = Material { name: "portal".into(), ..Material::default() };
                Ok(rectangle.put(scene, name, material))
            }
            Self::Node(names) => match nodes_called(names, source, scene)?[..] {
                [id] => Ok(id),
                ref all => {
                    let (count, name) = (all.len(), names.value.text());
                    let message = format!("an end of a portal is one node, and {count} are called `{name}`");
                    Err(source.fault(names.range.clone(), message))
                }
            },
        }
    }
}

impl PortalEntry {
    pub(super) fn read(table: &Table<'_>) -> Result<Self, Box<Diagnostic>> {
        let ends = [
            End::read(table, ["node", "position", "facing"])?,
            End::read(table, ["to_node", "to_position", "to_facing"])?,
        ];
        if ends.iter().all(|end| matches!(end, End::Node(_))) && table.place("size_m").is_some() {
            return Err(table.fault("size_m", "nodes have a size of their own; leave out `size_m`"));
        }
        let carries = table.text("carries");
        let portal = Portal {
            scale: table.number("scale").unwrap_or(1.0),
            layers: table.layers("layers").unwrap_or(LAYERS_ALL),
            quality: table.text("quality").map(|word| word.value),
            ..Portal::new(table.text("name").map(|name| name.value).unwrap_or_default().trim(), [NodeId(0); 2])
        };
        let carries = carries.map(|names| SpannedValue { value: Pattern::new(&names.value), range: names.range });
        Ok(Self { ends, carries, portal, range: table.range.clone() })
    }

    /// Links its ends. Transforms are up to date.
    ///
    /// # Errors
    /// The model has no node of a name, an end is not flat, or there are too many.
    pub(super) fn apply(&self, source: &Source, scene: &mut Scene) -> Result<(), Box<Diagnostic>> {
        let fault = |message: String| source.fault(self.range.clone(), message);
        if scene.portals.len() == PORTALS_MAX {
            return Err(fault(format!("there are more portals than {PORTALS_MAX}")));
        }
        // What is carried is of the model, and none of what the stage adds.
        let carried = match &self.carries {
            Some(names) => nodes_called(names, source, scene)?,
            None => Vec::new(),
        };
        let name = if self.portal.name.is_empty() { "portal" } else { &self.portal.name };
        let [first, second] = &self.ends;
        let nodes = [first.put(source, scene, name)?, second.put(source, scene, name)?];
        if nodes[0] == nodes[1] {
            let node = &scene.node(nodes[0]).name;
            return Err(fault(format!("both ends are the node `{node}`; a portal leads from one place to another")));
        }
        for id in nodes {
            let node = scene.node(id).name.clone();
            let taken = [
                ("an end of a portal", scene.portals.iter().any(|portal| portal.nodes.contains(&id))),
                ("a mirror", scene.mirrors.iter().any(|mirror| mirror.node == id)),
                ("water", scene.water.iter().any(|water| water.node == id)),
            ];
            if let Some((what, _)) = taken.into_iter().find(|(_, is_taken)| *is_taken) {
                return Err(fault(format!(
                    "the node `{node}` is {what} already; it cannot be an end of a portal, too"
                )));
            }
            if let Err(what) = scene.panel(id) {
                return Err(fault(format!("an end of a portal is flat, and the node `{node}` {what}")));
            }
        }
        scene.add_portal(Portal { name: name.into(), nodes, ..self.portal.clone() }, &carried);
        Ok(())
    }
}
