//! Reflection probes of a stage.

use super::table::{Source, Table, whole};
use super::updates::update_of;
use crate::capture::LAYERS_ALL;
use crate::surroundings::{Region, SURROUNDINGS_MAX, Surroundings};
use crate::{Diagnostic, Scene};
use glam::Vec3;
use std::ops::Range;

/// The largest side of a box.
const SIZE_MAX_M: f32 = 1e6;

/// An entry of `[[reflection_probes]]`.
#[derive(Clone, Debug)]
pub(super) struct SurroundingsEntry {
    surroundings: Surroundings,
    range: Range<usize>,
}

/// A box by the keys of its middle and its size, if it is there.
pub(super) fn region(table: &Table<'_>, [center, size]: [&str; 2]) -> Result<Option<Region>, Box<Diagnostic>> {
    let (Some(center_world), Some(size_m)) = (table.vector(center), table.vector(size)) else {
        let lacking = [(center, size), (size, center)].into_iter().find(|(key, _)| table.place(key).is_some());
        return match lacking {
            Some((key, other)) => {
                Err(table.fault(key, format!("a box has a middle and a size: `{key}` needs `{other}`")))
            }
            None => Ok(None),
        };
    };
    if size_m.min_element() <= 0.0 || size_m.max_element() > SIZE_MAX_M {
        let message = format!("`{size}` has three lengths above 0, of at most {SIZE_MAX_M} metres");
        return Err(table.fault(size, message));
    }
    Ok(Some(Region { center_world, half_m: 0.5 * size_m }))
}

/// Whether a picture of one is that of the other, within what is rounded.
fn are_of_one_place(a: &Surroundings, b: &Surroundings) -> bool {
    let largest_m = a.region.half_m.max_element();
    let is_near = |a: Vec3, b: Vec3| (a - b).abs().max_element() < 1e-3 * largest_m;
    let is_one = |a: &Region, b: &Region| is_near(a.center_world, b.center_world) && is_near(a.half_m, b.half_m);
    let has_same_walls = match (&a.walls, &b.walls) {
        (Some(a), Some(b)) => is_one(a, b),
        (a, b) => a.is_none() && b.is_none(),
    };
    is_near(a.position_world, b.position_world) && is_one(&a.region, &b.region) && has_same_walls
}

impl SurroundingsEntry {
    pub(super) fn read(table: &Table<'_>) -> Result<Self, Box<Diagnostic>> {
        let Some(own) = region(table, ["center", "size_m"])? else {
            let message = "a reflection probe needs `center` and `size_m`: the box whose surfaces reflect it";
            return Err(table.source.fault(table.range.clone(), message));
        };
        let has_walls = table.boolean("parallax_correction").unwrap_or(true);
        let walls = region(table, ["parallax_center", "parallax_size_m"])?;
        if let (false, Some(_)) = (has_walls, &walls) {
            let message =
                "without parallax correction there is no box for it; leave out `parallax_center` and `parallax_size_m`";
            return Err(table.fault("parallax_correction", message));
        }
        let of_room = Surroundings::of_room(table.text("name").map_or("room".into(), |name| name.value), own);
        let surroundings = Surroundings {
            position_world: table.vector("position").unwrap_or(own.center_world),
            fade_m: table.number("fade_m").unwrap_or(0.0),
            walls: walls.or(has_walls.then_some(own)),
            bounces: table
                .number("bounces")
                .map(|bounces| whole(table, "bounces", bounces))
                .transpose()?
                .unwrap_or(of_room.bounces),
            layers: table.layers("layers").unwrap_or(LAYERS_ALL),
            quality: table.text("quality").map(|word| word.value),
            update: update_of(table)?,
            ..of_room
        };
        Ok(Self { surroundings, range: table.range.clone() })
    }

    /// Adds them to the scene. Of those that the file has a picture of, by their name, that is taken if it is of the same place.
    ///
    /// # Errors
    /// There are too many.
    pub(super) fn apply(&self, source: &Source, scene: &mut Scene) -> Result<(), Box<Diagnostic>> {
        let own = &self.surroundings;
        let is_baked = |of: &&mut Surroundings| of.name == own.name && of.picture.is_some();
        if let Some(baked) = scene.surroundings.iter_mut().find(is_baked) {
            let picture = baked.picture.take().filter(|_| are_of_one_place(baked, own));
            *baked = Surroundings { picture, ..own.clone() };
            return Ok(());
        }
        if scene.surroundings.len() == SURROUNDINGS_MAX {
            let message = format!("there are more reflection probes than {SURROUNDINGS_MAX}");
            return Err(source.fault(self.range.clone(), message));
        }
        scene.surroundings.push(self.surroundings.clone());
        Ok(())
    }
}
