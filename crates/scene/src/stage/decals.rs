//! Decals of a stage.

use super::materials::StageImages;
use super::names::Pattern;
use super::surfaces::nodes_called;
use super::table::{Source, SpannedValue, Table};
use crate::chance::unit;
use crate::decal::{DECALS_MAX, Decal, DecalLook, DecalOpacity};
use crate::{Diagnostic, NodeId, Scene};
use glam::{Quat, Vec2, Vec3};
use std::ops::Range;
use std::sync::Arc;

/// Keys that name an image.
pub(super) const IMAGES: [&str; 4] = ["image", "normal_map", "rough_metal_map", "emission_map"];

/// What the name of an image of the model begins with.
const OF_MODEL: &str = "model:";

/// How deep a box is where nobody says, in metres.
const DEPTH_M: f32 = 0.5;

/// The most that scattered decals differ in size from what is said, as a share.
const SIZE_SPREAD: f32 = 0.3;

/// An entry of `[[decals]]`.
#[derive(Clone, Debug)]
pub(super) struct DecalEntry {
    /// Without a node, without images, and with its box around the origin.
    decal: Decal,
    look: DecalLook,
    nodes: Option<SpannedValue<Pattern>>,
    /// By [`IMAGES`].
    images: [Option<SpannedValue<String>>; 4],
    direction: Vec3,
    up: Option<Vec3>,
    turn_rad: f32,
    size_m: Vec3,
    positions: Vec<Vec3>,
    scatter: Option<Scatter>,
    range: Range<usize>,
}

/// Many within a box.
#[derive(Clone, Copy, Debug)]
struct Scatter {
    count: u32,
    extent_m: Vec3,
    seed: u32,
}

impl DecalEntry {
    pub(super) fn read(table: &Table<'_>) -> Result<Self, Box<Diagnostic>> {
        let name = table.text("name").map(|name| name.value).filter(|name| !name.trim().is_empty());
        let images = IMAGES.map(|key| table.text(key));
        for (key, image) in IMAGES.iter().zip(&images) {
            if image.as_ref().is_some_and(|image| name_of(&image.value).1.trim().is_empty()) {
                let message = format!("the name of `{key}` is empty; name a file such as leaf.png, or model:Leaf");
                return Err(table.fault(key, message));
            }
        }
        let [_, normal, rough_metal, glow] = &images;
        let plain = DecalLook::default();
        let emission = table.number("emission").unwrap_or(if glow.is_some() { 1.0 } else { 0.0 });
        let needs = |key: &str, others: &[&str]| match table.place(key) {
            Some(_) if !others.iter().any(|other| table.place(other).is_some()) => {
                Err(table.fault(key, format!("`{key}` needs `{}`", others.join("` or `"))))
            }
            _ => Ok(()),
        };
        needs("normal_scale", &["normal_map"])?;
        needs("normal_opacity", &["normal_map"])?;
        needs("roughness_opacity", &["roughness", "rough_metal_map"])?;
        needs("emission_color", &["emission", "emission_map"])?;
        needs("spread_m", &["count"])?;
        needs("seed", &["count"])?;
        let has_roughness = table.place("roughness").is_some() || rough_metal.is_some();
        // What is there is there whole.
        let there = |is_there: bool| if is_there { 1.0 } else { 0.0 };
        let share = |key: &str, other: f32| table.number(key).unwrap_or(other);
        let look = DecalLook {
            color: table.vector("color").unwrap_or(Vec3::ONE),
            metallic: table.number("metallic").unwrap_or(there(rough_metal.is_some())),
            roughness: table.number("roughness").unwrap_or(1.0),
            normal_scale: table.number("normal_scale").unwrap_or(1.0),
            emission: table.vector("emission_color").unwrap_or(Vec3::ONE) * emission,
            opacity: DecalOpacity {
                color: share("opacity", 1.0),
                normal: share("normal_opacity", there(normal.is_some())),
                roughness: share("roughness_opacity", there(has_roughness)),
                emission: share("emission_opacity", there(emission > 0.0)),
            },
            ..plain
        };
        let size = table.pair("size_m").unwrap_or(Vec2::ONE);
        if size.min_element() <= 0.0 {
            return Err(table.fault("size_m", "`size_m` is the width and the height of the picture, both above 0"));
        }
        let direction = table.vector("direction").unwrap_or(Vec3::NEG_Y);
        let angle_deg = table.pair("angle_deg").unwrap_or(Vec2::new(60.0, 80.0));
        check_placement(table, direction, angle_deg)?;
        let whole = |key: &str| table.number(key).map(|number| super::table::whole(table, key, number)).transpose();
        let seed = whole("seed")?.unwrap_or(0);
        let extent_m = table.vector("spread_m").unwrap_or(Vec3::new(1.0, 0.0, 1.0));
        let scatter = whole("count")?.map(|count| Scatter { count, extent_m, seed });
        let mut decal = Decal::new(name.unwrap_or_else(|| "decal".into()), plain);
        decal.angle_rad = angle_deg * (std::f32::consts::PI / 180.0);
        decal.layers = table.layers("layers").unwrap_or(decal.layers);
        decal.order = table.number("order").map_or(0, |order| order as i32);
        let positions = match table.vectors("positions") {
            Some(positions) => positions.to_vec(),
            None => vec![table.vector("position").unwrap_or_default()],
        };
        Ok(Self {
            decal,
            look,
            nodes: table.text("node").map(|name| SpannedValue { value: Pattern::new(&name.value), range: name.range }),
            images,
            direction,
            up: table.vector("up"),
            turn_rad: table.number("turn_deg").unwrap_or(0.0).to_radians(),
            size_m: size.extend(table.number("depth_m").unwrap_or(DEPTH_M)),
            positions,
            scatter,
            range: table.range.clone(),
        })
    }

    /// The images that it names which are files.
    pub(super) fn images(&self) -> impl Iterator<Item = &SpannedValue<String>> {
        self.images.iter().flatten().filter(|image| is_file(&image.value))
    }

    /// Puts its decals into the scene.
    ///
    /// # Errors
    /// The model has no node or image of a name, or there are too many decals.
    pub(super) fn apply(
        &self,
        source: &Source,
        scene: &mut Scene,
        images: &StageImages,
    ) -> Result<(), Box<Diagnostic>> {
        let of_name = |image: &Option<SpannedValue<String>>| {
            let Some(image) = image else { return Ok(None) };
            let (true, name) = name_of(&image.value) else { return Ok(Some(images.index(image))) };
            let called = scene.images.iter().position(|known| known.name == name);
            let numbered = || name.parse().ok().filter(|index| *index < scene.images.len());
            let found = called.or_else(numbered);
            found.map(Some).ok_or_else(|| {
                let message = format!("the model has no image called `{name}`");
                source.unknown(image.range.clone(), message, name, scene.images.iter().map(|known| &*known.name))
            })
        };
        let [color_image, normal_image, rough_metal_image, emission_image] = self.images.each_ref().map(of_name);
        let look = Arc::new(DecalLook {
            color_image: color_image?,
            normal_image: normal_image?,
            rough_metal_image: rough_metal_image?,
            emission_image: emission_image?,
            ..self.look.clone()
        });
        let nodes: Vec<Option<NodeId>> = match &self.nodes {
            Some(names) => nodes_called(names, source, scene)?.into_iter().map(Some).collect(),
            None => vec![None],
        };
        // Counted before any is made: a short text can ask for more than memory holds.
        let of_position = self.scatter.map_or(1, |scatter| scatter.count as usize);
        let count = self.positions.len().saturating_mul(of_position).saturating_mul(nodes.len());
        if scene.decals.len().saturating_add(count) > DECALS_MAX {
            let message = format!("there are more decals than {DECALS_MAX}: {count} of this entry");
            return Err(source.fault(self.range.clone(), message));
        }
        let boxes = self.boxes();
        for node in nodes {
            let of_box = |parent_from_box| Decal { node, look: look.clone(), parent_from_box, ..self.decal.clone() };
            scene.decals.extend(boxes.iter().copied().map(of_box));
        }
        Ok(())
    }

    /// The matrix of each box.
    fn boxes(&self) -> Vec<glam::Mat4> {
        let direction = self.direction.normalize_or(Vec3::NEG_Y);
        // The upper edge of what lies is turned away from who looks along −Z.
        let up = self.up.unwrap_or(if direction.y.abs() > 0.9 { Vec3::NEG_Z } else { Vec3::Y });
        let placed = |center: Vec3, turn_rad: f32, scale: f32| {
            let mut decal = self.decal.clone();
            let up = Quat::from_axis_angle(-direction, turn_rad) * up;
            decal.place(center, direction, up, self.size_m * Vec3::new(scale, scale, 1.0));
            decal.parent_from_box
        };
        let Some(scatter) = self.scatter else {
            return self.positions.iter().map(|position| placed(*position, self.turn_rad, 1.0)).collect();
        };
        let around = self.positions.iter().flat_map(|middle| (0..scatter.count).map(move |at| (*middle, at)));
        let box_of = |(entry, (middle, _)): (u32, (Vec3, u32))| {
            let chance = |which: u32| unit(entry.wrapping_mul(8).wrapping_add(which), scatter.seed.wrapping_add(1));
            let offset = Vec3::new(chance(0), chance(1), chance(2)) - 0.5;
            let scale = 1.0 + SIZE_SPREAD * (2.0 * chance(4) - 1.0);
            placed(middle + offset * scatter.extent_m, self.turn_rad + std::f32::consts::TAU * chance(3), scale)
        };
        (0..).zip(around).map(box_of).collect()
    }
}

/// Whether an image is the model's, and its name.
fn name_of(image: &str) -> (bool, &str) {
    image.strip_prefix(OF_MODEL).map_or((false, image), |name| (true, name))
}

/// What directions, extents and angles must be.
///
/// # Errors
/// The first key that is wrong, with its place.
fn check_placement(table: &Table<'_>, direction: Vec3, angle_deg: Vec2) -> Result<(), Box<Diagnostic>> {
    if direction.normalize_or_zero() == Vec3::ZERO {
        return Err(table.fault("direction", "`direction` has no length; [0, -1, 0] points down"));
    }
    if table.vector("up").is_some_and(|up| up.normalize_or_zero() == Vec3::ZERO) {
        return Err(table.fault("up", "`up` has no length; [0, 1, 0] points up"));
    }
    if table.vector("spread_m").is_some_and(|spread_m| spread_m.min_element() < 0.0) {
        return Err(table.fault("spread_m", "`spread_m` is an extent along X, Y and Z, each at least 0"));
    }
    let is_end = angle_deg.y > 0.0 && (angle_deg.x..=180.0).contains(&angle_deg.y);
    if !(0.0..=180.0).contains(&angle_deg.x) || !is_end {
        let message = "`angle_deg` is where surfaces begin to show less and where they show nothing, from 0 to 180, \
                       in this order, the second above 0";
        return Err(table.fault("angle_deg", message));
    }
    if table.place("position").is_some() && table.place("positions").is_some() {
        return Err(table.fault("positions", "leave out `position`, or `positions`"));
    }
    Ok(())
}

/// Whether what is named is a file.
pub(super) fn is_file(image: &str) -> bool {
    !name_of(image).0
}
