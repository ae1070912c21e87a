//! The lists of lights of objects, for paths that draw an object once for each few lights, or light its vertices.

use super::reaches::RADIUS_SLACK;
use super::record::ListRecord;
use super::{ClusterLists, LightTable, ListLimits};
use glam::Vec3;
use manypass_scene::Aabb;

/// Boxes around objects in world space, by object id.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjectBounds(Vec<Place>);

#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    /// Nothing of it is drawn.
    Nowhere,
    /// Within a box.
    Box(Aabb),
    /// It is deformed, so that its box is not known.
    Anywhere,
}

impl ObjectBounds {
    /// Adds a part of the object `id`; without a box it may be anywhere.
    pub fn add(&mut self, id: u32, part: Option<Aabb>) {
        let index = id as usize;
        if self.0.len() <= index {
            self.0.resize(index + 1, Place::Nowhere);
        }
        let place = &mut self.0[index];
        *place = match (*place, part) {
            (_, None) | (Place::Anywhere, _) => Place::Anywhere,
            (Place::Nowhere, Some(part)) => Place::Box(part),
            (Place::Box(known), Some(part)) => Place::Box(known.union(&part)),
        };
    }
}

impl ClusterLists {
    /// Appends a list for every object id, of the lights with a range that may reach the object, in the order of the
    /// lights. What may be anywhere, and what there is no room for within `limits`, has a list of all lights.
    pub fn append_objects(&mut self, table: &LightTable, objects: &ObjectBounds, limits: ListLimits) {
        let everything: Vec<u16> = (table.global_count()..table.len()).map(|light| light as u16).collect();
        let of_everything = ListRecord::new(self.lights.len(), &everything, &table.class_ends);
        self.lights.extend(everything);
        for place in &objects.0 {
            let bounds = match place {
                Place::Nowhere => {
                    self.table.push(ListRecord::EMPTY);
                    continue;
                }
                Place::Box(bounds) if self.lights.len() + table.reaches.len() <= limits.entries => bounds,
                Place::Box(_) | Place::Anywhere => {
                    self.table.push(of_everything);
                    continue;
                }
            };
            let first = self.lights.len();
            let touches = |center: Vec3, radius_m: f32| {
                let nearest = center.clamp(bounds.min, bounds.max);
                nearest.distance_squared(center) <= radius_m * radius_m
            };
            let reaching = (table.global_count()..).zip(&table.reaches);
            let reaching = reaching.filter(|(_, reach)| touches(reach.center, reach.radius_m * RADIUS_SLACK));
            self.lights.extend(reaching.map(|(light, _)| light as u16));
            self.table.push(ListRecord::new(first, &self.lights[first..], &table.class_ends));
        }
    }
}
