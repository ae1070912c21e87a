//! Surroundings: what is to be seen around a place, as the environment of the surfaces near it.
//!
//! ```
//! # use manypass_scene::surroundings::{Region, Surroundings};
//! # use manypass_scene::Scene;
//! # use glam::Vec3;
//! # let mut scene = Scene::default();
//! let room = Region { center_world: Vec3::new(0.0, 1.5, 0.0), half_m: Vec3::new(4.0, 1.5, 3.5) };
//! scene.surroundings.push(Surroundings::of_room("room", room));
//! ```

use crate::EnvironmentMap;
use crate::capture::{LAYERS_ALL, Update};
use glam::Vec3;
use std::sync::Arc;

/// The most surroundings of a scene that are drawn.
pub const SURROUNDINGS_MAX: usize = 4;

/// The most times that surroundings are captured.
pub const BOUNCES_MAX: u32 = 4;

/// A box along the axes of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Its middle.
    pub center_world: Vec3,
    /// Half its extent, in metres.
    pub half_m: Vec3,
}

/// Six pictures around a place, which stand for the environment within a box: what surfaces there reflect, and the light
/// that comes to them from everywhere.
///
/// What is captured first has the environment's light itself; captured again, it has the light of what was captured before.
#[derive(Clone, Debug, PartialEq)]
pub struct Surroundings {
    /// Its name: in the names of passes.
    pub name: String,
    /// From where they are seen.
    pub position_world: Vec3,
    /// The surfaces that have them: those in this box.
    pub region: Region,
    /// Over how many metres within the box's faces the environment takes over.
    pub fade_m: f32,
    /// The walls that are seen, as a box: reflections in it are shifted as the place of a surface says. None for what is
    /// far away.
    pub walls: Option<Region>,
    /// How often they are captured, each time in the light of what was captured before: so often light goes back and forth. 1
    /// to [`BOUNCES_MAX`].
    pub bounces: u32,
    /// The layers that are seen ([`crate::Node::layers`]), a bit each.
    pub layers: u32,
    /// The tier of quality whose passes draw them; none for that of the picture.
    pub quality: Option<String>,
    /// When they are drawn anew.
    pub update: Update,
    /// What is to be seen around the place, where that was found beforehand: then frames draw nothing for it.
    pub picture: Option<Arc<EnvironmentMap>>,
}

impl Surroundings {
    /// Of a room: seen from its middle, for all that is in it, with its walls.
    pub fn of_room(name: impl Into<String>, room: Region) -> Self {
        Self {
            name: name.into(),
            position_world: room.center_world,
            region: room,
            fade_m: 0.0,
            walls: Some(room),
            bounces: 2,
            layers: LAYERS_ALL,
            quality: None,
            update: Update::Always,
            picture: None,
        }
    }
}
