//! Lights of a stage: new ones, and changes of the model's own.

use super::names::Pattern;
use super::table::{Source, SpannedValue, Table};
use crate::light::CONE_MIN_RAD;
use crate::{Diagnostic, Light, LightKind, LightMode, Node, NodeId, Scene};
use glam::{Quat, Vec3};
use std::collections::BTreeSet;

/// A new light and where it is.
#[derive(Clone, Debug)]
pub(super) struct NewLight {
    light: Light,
    position: Vec3,
    rotation: Quat,
}

/// What is changed of the model's lights.
#[derive(Clone, Debug)]
pub(super) struct LightChange {
    names: SpannedValue<Pattern>,
    color_linear: Option<Vec3>,
    intensity: Option<f32>,
    range_m: Option<f32>,
    radius_m: Option<f32>,
    /// The tangent of half the angle of a directional light's source.
    tangent: Option<f32>,
    casts_shadows: Option<bool>,
    mode: Option<LightMode>,
}

/// An entry of `[[lights]]`.
#[derive(Clone, Debug)]
pub(super) enum LightEntry {
    New(NewLight),
    Change(LightChange),
}

impl LightEntry {
    pub(super) fn read(table: &Table<'_>) -> Result<Self, Box<Diagnostic>> {
        match table.text("kind") {
            Some(kind) => NewLight::read(table, &kind.value).map(Self::New),
            None => LightChange::read(table).map(Self::Change),
        }
    }
}

fn mode(table: &Table<'_>) -> Option<LightMode> {
    table.text("mode").and_then(|word| LightMode::named(&word.value))
}

/// The tangent of half an angle.
fn half_tangent(angle_deg: f32) -> f32 {
    (0.5 * angle_deg).to_radians().tan()
}

impl NewLight {
    fn read(table: &Table<'_>, word: &str) -> Result<Self, Box<Diagnostic>> {
        let is_directional = word == "directional";
        let kind = match word {
            "spot" => cone(table)?,
            "directional" => LightKind::Directional,
            _ => LightKind::Point,
        };
        let foreign: &[&str] = match kind {
            LightKind::Point => &["direction", "target", "inner_cone_deg", "outer_cone_deg", "angle_deg"],
            LightKind::Spot { .. } => &["angle_deg"],
            LightKind::Directional => &["range_m", "radius_m", "inner_cone_deg", "outer_cone_deg"],
        };
        if let Some(key) = foreign.iter().find(|key| table.place(key).is_some()) {
            return Err(table.fault(key, format!("a {word} light has no `{key}`")));
        }
        let position = table.vector("position");
        if position.is_none() && !is_directional {
            return Err(table.fault("kind", format!("a {word} light needs `position`, its place in metres")));
        }
        let radius_m =
            if is_directional { table.number("angle_deg").map(half_tangent) } else { table.number("radius_m") };
        let light = Light {
            name: table.text("name").map(|name| name.value).unwrap_or_default(),
            color_linear: table.vector("color").unwrap_or(Vec3::ONE),
            intensity: table.number("intensity").unwrap_or(1.0),
            range_m: table.number("range_m"),
            kind,
            radius_m: radius_m.unwrap_or(0.0),
            casts_shadows: table.boolean("cast").unwrap_or(true),
            mode: mode(table).unwrap_or_default(),
        };
        let rotation = if kind == LightKind::Point { Quat::IDENTITY } else { rotation(table, word, position)? };
        Ok(Self { light, position: position.unwrap_or(Vec3::ZERO), rotation })
    }
}

fn cone(table: &Table<'_>) -> Result<LightKind, Box<Diagnostic>> {
    let inner_deg = table.number("inner_cone_deg").unwrap_or(0.0);
    let outer_deg = table.number("outer_cone_deg").unwrap_or(45.0);
    if inner_deg >= outer_deg {
        let key = if table.place("inner_cone_deg").is_some() { "inner_cone_deg" } else { "outer_cone_deg" };
        let message =
            format!("the inner cone of {inner_deg} degrees is not narrower than the outer one of {outer_deg}");
        return Err(table.fault(key, message));
    }
    let outer_cone_rad = outer_deg.to_radians().clamp(CONE_MIN_RAD, std::f32::consts::FRAC_PI_2);
    Ok(LightKind::Spot { inner_cone_rad: inner_deg.to_radians().min(0.999 * outer_cone_rad), outer_cone_rad })
}

/// From −Z, along which lights shine, to where this one does.
fn rotation(table: &Table<'_>, word: &str, position: Option<Vec3>) -> Result<Quat, Box<Diagnostic>> {
    let (key, direction) = match (table.vector("direction"), table.vector("target"), position) {
        (Some(_), Some(_), _) => {
            return Err(table.fault("target", "`direction` and `target` are two ways to say one thing"));
        }
        (Some(direction), None, _) => ("direction", direction),
        (None, Some(target), Some(position)) => ("target", target - position),
        (None, Some(_), None) => return Err(table.fault("target", "`target` needs `position`")),
        (None, None, _) => return Err(table.fault("kind", format!("a {word} light needs `direction` or `target`"))),
    };
    // Scaled first, so that neither very short nor very long ones lose their length.
    let direction = (direction / direction.abs().max_element()).try_normalize();
    let direction = direction.ok_or_else(|| table.fault(key, "a direction of no length"))?;
    Ok(Quat::from_rotation_arc(Vec3::NEG_Z, direction))
}

impl LightChange {
    fn read(table: &Table<'_>) -> Result<Self, Box<Diagnostic>> {
        let Some(name) = table.text("name") else {
            let message = "a light needs `kind` if it is new, or the `name` of lights of the model that it changes";
            return Err(table.source.fault(table.range.clone(), message));
        };
        let foreign = ["position", "direction", "target", "inner_cone_deg", "outer_cone_deg"];
        if let Some(key) = foreign.iter().find(|key| table.place(key).is_some()) {
            let message =
                format!("`{key}` is only for new lights, which have a `kind`; this changes lights of the model");
            return Err(table.fault(key, message));
        }
        Ok(Self {
            names: SpannedValue { value: Pattern::new(&name.value), range: name.range },
            color_linear: table.vector("color"),
            intensity: table.number("intensity"),
            range_m: table.number("range_m"),
            radius_m: table.number("radius_m"),
            tangent: table.number("angle_deg").map(half_tangent),
            casts_shadows: table.boolean("cast"),
            mode: mode(table),
        })
    }

    /// Changes the lights that have the name, or whose nodes have it.
    fn apply(&self, source: &Source, scene: &mut Scene) -> Result<(), Box<Diagnostic>> {
        let pattern = &self.names.value;
        let holders = scene.nodes.iter().filter_map(|node| Some((node.name.as_str(), node.light?)));
        let own = scene.lights.iter().enumerate().map(|(index, light)| (light.name.as_str(), index));
        let named: Vec<(&str, usize)> = own.chain(holders).collect();
        let found: BTreeSet<usize> =
            named.iter().filter(|(name, _)| pattern.matches(name)).map(|(_, index)| *index).collect();
        if found.is_empty() {
            let message = format!("the model has no light called `{}`", pattern.text());
            let known = named.iter().map(|(name, _)| *name);
            return Err(source.unknown(self.names.range.clone(), message, pattern.text(), known));
        }
        self.check_kinds(source, found.iter().filter_map(|index| scene.lights.get(*index)))?;
        for index in found {
            let Some(light) = scene.lights.get_mut(index) else { continue };
            let is_directional = light.kind == LightKind::Directional;
            light.color_linear = self.color_linear.unwrap_or(light.color_linear);
            light.intensity = self.intensity.unwrap_or(light.intensity);
            light.casts_shadows = self.casts_shadows.unwrap_or(light.casts_shadows);
            light.mode = self.mode.unwrap_or(light.mode);
            let radius_m = if is_directional { self.tangent } else { self.radius_m };
            light.radius_m = radius_m.unwrap_or(light.radius_m);
            light.range_m = self.range_m.filter(|_| !is_directional).or(light.range_m);
        }
        Ok(())
    }
}

impl LightChange {
    /// Whether every key is of any of the lights.
    fn check_kinds<'l>(&self, source: &Source, lights: impl Iterator<Item = &'l Light>) -> Result<(), Box<Diagnostic>> {
        let (mut has_directional, mut has_other) = (false, false);
        for light in lights {
            let is_directional = light.kind == LightKind::Directional;
            (has_directional, has_other) = (has_directional | is_directional, has_other | !is_directional);
        }
        let name = self.names.value.text();
        let fault = |message: String| Err(source.fault(self.names.range.clone(), message));
        match (self.radius_m.map(|_| "radius_m").or(self.range_m.map(|_| "range_m")), self.tangent) {
            (Some(key), _) if !has_other => {
                let remedy = if key == "radius_m" { ": give it `angle_deg`" } else { "" };
                fault(format!("`{name}` is a directional light, which has no `{key}`{remedy}"))
            }
            (_, Some(_)) if !has_directional => {
                fault(format!("`{name}` is not a directional light: give it `radius_m`"))
            }
            _ => Ok(()),
        }
    }
}

/// Changes the model's lights, then adds the new ones to every scene of the file.
pub(super) fn apply(entries: &[LightEntry], source: &Source, scene: &mut Scene) -> Result<(), Box<Diagnostic>> {
    for entry in entries {
        if let LightEntry::Change(change) = entry {
            change.apply(source, scene)?;
        }
    }
    for entry in entries {
        let LightEntry::New(NewLight { light, position, rotation }) = entry else { continue };
        scene.lights.push(light.clone());
        let (name, light) = (light.name.clone(), Some(scene.lights.len() - 1));
        let node = Node { name, light, translation: *position, rotation: *rotation, ..Node::default() };
        let id: NodeId = scene.add_node(None, node);
        scene.scenes.iter_mut().for_each(|roots| roots.roots.push(id));
    }
    Ok(())
}
