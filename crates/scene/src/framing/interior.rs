//! Scenes that enclose their middle are seen from inside.
//!
//! Rays from the middle tell a room from a solid: they meet surfaces that are turned towards them, all around and
//! below, where those of a helmet or a box meet the backs of what is to be seen from outside. A roof may be open, as
//! that of Sponza's court. A vessel, such as a vase or a shoe, is turned inwards too, but it has an outside. What has
//! an outside is a room only if it is furnished ([`furniture`]). Size tells nothing: most formats have no unit, and
//! those that have one are often written in another.

use super::furniture;
use super::panorama::{Panorama, Ray};
use crate::turns::{Turns, at_once};
use crate::{Aabb, Mesh, Primitive, Projection, Scene};
use glam::{Mat3, Mat4, Vec3};
use std::sync::Arc;

/// The camera inside a scene that encloses its middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interior {
    /// The camera's transform: at the height of a person's eye, at one end of the longest free way, looking along it.
    pub world_from_view: Mat4,
    /// A wider one than outside.
    pub projection: Projection,
}

/// Rays that climb or fall by less than 30° go to walls, the others to the ceiling and the floor.
const STEEPEST_WALL: f32 = 0.5;

/// The share of walls and floor that is to be turned inwards. Sponza: 0.99; a shoe, seen from its insole: 0.95.
const LEAST_TURNED_IN: f32 = 0.97;

/// The height of a person's eye.
const EYE_HEIGHT_M: f32 = 1.6;

/// The vertical field of view inside.
const FOV_Y_RAD: f32 = std::f32::consts::FRAC_PI_3;

/// The directions that are compared.
const AZIMUTHS: u16 = 32;

/// Above so many indices, four million of triangles, nobody waits to be told.
const MOST_INDICES: usize = 12_000_000;

impl Interior {
    /// The view from inside, if the scene, as of its last [`Scene::update_transforms`], encloses its middle.
    pub(super) fn find(scene: &Scene) -> Option<Self> {
        at_once(Self::find_in_turns(scene, &mut || None))
    }

    /// As [`Self::find`]; `turns` is asked between slices of many triangles.
    pub(super) async fn find_in_turns(scene: &Scene, turns: &mut Turns<'_>) -> Option<Self> {
        let bounds = scene.bounds_world();
        let is_flat = bounds.is_empty() || bounds.min.cmpeq(bounds.max).any();
        if is_flat || !bounds.radius_m().is_finite() || indices_drawn(scene) > MOST_INDICES {
            return None;
        }
        let middle = bounds.center();
        let panorama = Panorama::new(scene, middle, turns).await;
        let rays = panorama.rays();
        let is_room =
            encloses(rays, bounds.radius_m()) && (!has_outside(rays) || furniture::is_furnished(scene, &bounds, rays));
        if is_room { Some(Self::looking_along(scene, &bounds, &panorama, turns).await) } else { None }
    }

    async fn looking_along(scene: &Scene, bounds: &Aabb, from_middle: &Panorama, turns: &mut Turns<'_>) -> Self {
        let middle = bounds.center();
        let to_floor_m = free_m(from_middle.rays(), Vec3::NEG_Y).min(middle.y - bounds.min.y);
        let to_ceiling_m = free_m(from_middle.rays(), Vec3::Y).min(bounds.max.y - middle.y);
        let clear_m = to_floor_m + to_ceiling_m;
        let eye_height_m = EYE_HEIGHT_M.clamp(0.15 * clear_m, 0.5 * clear_m);
        let place = middle.with_y(middle.y - to_floor_m + eye_height_m);
        let panorama = Panorama::new(scene, place, turns).await;
        let free_m = |direction: Vec3| free_m(panorama.rays(), direction).min(to_exit_m(bounds, place, direction));
        let (mut best, mut longest_m, mut behind_m) = (Vec3::NEG_Z, 0.0, 0.0);
        for i in 0..AZIMUTHS {
            let azimuth_rad = std::f32::consts::TAU * f32::from(i) / f32::from(AZIMUTHS);
            let direction = Vec3::new(azimuth_rad.cos(), 0.0, azimuth_rad.sin());
            let (ahead_m, back_m) = (free_m(direction), free_m(-direction));
            // Of the two ways along a line, the longer one from the middle; a little more is no reason to prefer
            // another.
            if ahead_m >= back_m && ahead_m + back_m > 1.001 * longest_m {
                (best, longest_m, behind_m) = (direction, ahead_m + back_m, back_m);
            }
        }
        let eye = place - 0.8 * behind_m * best;
        let right = best.cross(Vec3::Y);
        let axes = Mat3::from_cols(right, Vec3::Y, -best);
        let near_m = 1e-3 * bounds.radius_m();
        Self {
            world_from_view: Mat4::from_translation(eye) * Mat4::from_mat3(axes),
            projection: Projection::Perspective { fov_y_rad: FOV_Y_RAD, near_m, far_m: None },
        }
    }
}

/// How many indices are drawn, those of a mesh once for every node that shows it.
fn indices_drawn(scene: &Scene) -> usize {
    let of_primitive = |primitive: &Primitive| primitive.indices.len().max(primitive.positions.len());
    let of_mesh = |mesh: &Arc<Mesh>| mesh.primitives.iter().map(of_primitive).fold(0, usize::saturating_add);
    let counts: Vec<usize> = scene.meshes.iter().map(of_mesh).collect();
    let nodes = scene.visible_nodes().into_iter().filter_map(|id| counts.get(scene.node(id).mesh?));
    nodes.fold(0, |sum, count| sum.saturating_add(*count))
}

/// The share of those rays that are asked, by solid angle, that are counted.
fn share(rays: &[Ray], is_asked: impl Fn(&Ray) -> bool, is_counted: impl Fn(&Ray) -> bool) -> f32 {
    let sum =
        |is: &dyn Fn(&Ray) -> bool| -> f32 { rays.iter().filter(|ray| is(ray)).map(|ray| ray.solid_angle_sr).sum() };
    sum(&|ray| is_asked(ray) && is_counted(ray)) / sum(&is_asked).max(f32::MIN_POSITIVE)
}

/// Whether rays from the middle of a scene of that radius meet walls and a floor that are turned towards them, and not
/// nearby.
fn encloses(rays: &[Ray], radius_m: f32) -> bool {
    let is_wall = |ray: &Ray| ray.direction_world.y.abs() < STEEPEST_WALL;
    let is_floor = |ray: &Ray| ray.direction_world.y < -STEEPEST_WALL;
    let is_turned_in = |ray: &Ray| ray.is_faced;
    // There is room where at most half of the rays end nearby.
    share(rays, is_wall, is_turned_in) >= LEAST_TURNED_IN
        && share(rays, is_floor, is_turned_in) >= LEAST_TURNED_IN
        && share(rays, |_| true, |ray| ray.distance_m < 0.1 * radius_m) < 0.5
}

/// Whether what rays from the middle leave a scene through is to be seen from outside.
fn has_outside(rays: &[Ray]) -> bool {
    share(rays, |_| true, |ray| ray.last_is_back) > 0.5
}

/// How far one can go in a direction: as far as three quarters of the rays within 12° do.
fn free_m(rays: &[Ray], direction: Vec3) -> f32 {
    let is_near = |ray: &&Ray| ray.direction_world.dot(direction) > 0.978;
    let mut distances_m: Vec<f32> = rays.iter().filter(is_near).map(|ray| ray.distance_m).collect();
    distances_m.sort_by(f32::total_cmp);
    distances_m.get(distances_m.len() / 4).copied().unwrap_or(0.0)
}

/// How far it is from a point in a box to its side.
fn to_exit_m(bounds: &Aabb, from: Vec3, direction: Vec3) -> f32 {
    let to_side = |axis: usize| {
        let side = if direction[axis] > 0.0 { bounds.max[axis] } else { bounds.min[axis] };
        if direction[axis] == 0.0 { f32::INFINITY } else { (side - from[axis]) / direction[axis] }
    };
    to_side(0).min(to_side(1)).min(to_side(2)).max(0.0)
}
