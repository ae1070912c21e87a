//! Flat surfaces that entries of a stage are about: nodes of the model, or rectangles of the stage's own.

use super::names::Pattern;
use super::table::{Source, SpannedValue, Table};
use crate::framing::look_along;
use crate::primitives::plane;
use crate::{Diagnostic, Material, Mesh, Node, NodeId, Primitive, Scene};
use glam::{Quat, Vec2, Vec3};
use std::f32::consts::FRAC_PI_2;
use std::ops::Range;

/// The largest side.
const SIZE_MAX_M: f32 = 1e6;

/// A flat surface.
#[derive(Clone, Debug)]
pub(super) enum Surface {
    /// Nodes of the model.
    Nodes(SpannedValue<Pattern>),
    /// A rectangle.
    New(Rectangle),
}

/// A rectangle at a place.
#[derive(Clone, Debug)]
pub(super) struct Rectangle {
    position: Vec3,
    /// From a plane that faces up, whose width goes along X and whose height along Z.
    rotation: Quat,
    size_m: Vec2,
    /// Where its entry begins.
    pub range: Range<usize>,
}

/// How a rectangle is turned: the keys that say so, and what reads them, which gives nothing where one is missing.
pub(super) type Turn = (&'static [&'static str], fn(&Table<'_>) -> Result<Option<Quat>, Box<Diagnostic>>);

/// By `facing`, where it faces.
pub(super) const FACING: Turn = (&["facing"], |table| facing_rotation(table, "facing"));

/// It lies, turned by `turn_deg` where that is there.
pub(super) const LYING: Turn =
    (&["turn_deg"], |table| Ok(Some(Quat::from_rotation_y(table.number("turn_deg").unwrap_or(0.0).to_radians()))));

/// The rotation of a rectangle that faces where a key says.
///
/// # Errors
/// The direction has no length.
pub(super) fn facing_rotation(table: &Table<'_>, key: &str) -> Result<Option<Quat>, Box<Diagnostic>> {
    let Some(facing) = table.vector(key) else { return Ok(None) };
    // It looks back along what it faces; and the plane faces up, and its v runs down the picture.
    let rotation = look_along(-facing, Vec3::Y);
    let rotation = rotation.ok_or_else(|| table.fault(key, format!("`{key}` is a direction, and has no length")))?;
    Ok(Some(rotation * Quat::from_rotation_x(FRAC_PI_2)))
}

impl Surface {
    /// The surface of `what`, such as a mirror.
    ///
    /// # Errors
    /// The entry names nodes and a rectangle, or neither; or the rectangle is none.
    pub(super) fn read(table: &Table<'_>, what: &str, (turn_keys, turn): Turn) -> Result<Self, Box<Diagnostic>> {
        let of_rectangle = || ["position", "size_m"].iter().chain(turn_keys);
        if let Some(node) = table.text("node") {
            return match of_rectangle().find(|key| table.place(key).is_some()) {
                Some(key) => {
                    Err(table.fault(key, format!("`node` is a surface of the model; leave out `{key}`, or `node`")))
                }
                None => Ok(Self::Nodes(SpannedValue { value: Pattern::new(&node.value), range: node.range })),
            };
        }
        let (position, size_m, rotation) = (table.vector("position"), table.pair("size_m"), turn(table)?);
        let (Some(position), Some(size_m), Some(rotation)) = (position, size_m, rotation) else {
            let turned = if turn_keys.contains(&"facing") {
                "`position`, `facing` and `size_m`"
            } else {
                "`position` and `size_m`"
            };
            let message = format!("{what} needs `node`, a flat surface of the model, or {turned}");
            return Err(table.source.fault(table.range.clone(), message));
        };
        Ok(Self::New(Rectangle::new(table, (position, rotation), size_m)?))
    }
}

impl Rectangle {
    /// At a place, of a size that `size_m` of the entry says.
    ///
    /// # Errors
    /// It has no area, or is too large.
    pub(super) fn new(
        table: &Table<'_>,
        (position, rotation): (Vec3, Quat),
        size_m: Vec2,
    ) -> Result<Self, Box<Diagnostic>> {
        if size_m.min_element() <= 0.0 || size_m.max_element() > SIZE_MAX_M {
            let message = format!("`size_m` is a width and a height above 0, of at most {SIZE_MAX_M} metres");
            return Err(table.fault("size_m", message));
        }
        Ok(Self { position, rotation, size_m, range: table.range.clone() })
    }

    /// Adds it to every scene of the file, as a node of its own.
    pub(super) fn put(&self, scene: &mut Scene, name: &str, material: Material) -> NodeId {
        scene.materials.push(material);
        let material = Some(scene.materials.len() - 1);
        let square = Primitive { material, ..plane(1.0) };
        scene.meshes.push(Mesh { primitives: vec![square], ..Mesh::default() }.into());
        let node = Node {
            name: name.into(),
            mesh: Some(scene.meshes.len() - 1),
            translation: self.position,
            rotation: self.rotation,
            scale: Vec3::new(self.size_m.x, 1.0, self.size_m.y),
            ..Node::default()
        };
        let id = scene.add_node(None, node);
        scene.scenes.iter_mut().for_each(|roots| roots.roots.push(id));
        scene.update_transforms();
        id
    }
}

/// The nodes of the model that have a name.
///
/// # Errors
/// There are none.
pub(super) fn nodes_called(
    names: &SpannedValue<Pattern>,
    source: &Source,
    scene: &Scene,
) -> Result<Vec<NodeId>, Box<Diagnostic>> {
    let pattern = &names.value;
    let named = (0..).map(NodeId).zip(&scene.nodes).filter(|(_, node)| pattern.matches(&node.name));
    let found: Vec<NodeId> = named.map(|(id, _)| id).collect();
    // Of many those are meant that are something.
    let is_thing = |id: &NodeId| scene.node(*id).mesh.is_some() || scene.node(*id).light.is_some();
    let has_things = pattern.has_stars() && found.iter().any(is_thing);
    let found: Vec<NodeId> = found.into_iter().filter(|id| !has_things || is_thing(id)).collect();
    if found.is_empty() {
        let message = format!("the model has no node called `{}`", pattern.text());
        let known = scene.nodes.iter().map(|node| node.name.as_str());
        return Err(source.unknown(names.range.clone(), message, pattern.text(), known));
    }
    Ok(found)
}
