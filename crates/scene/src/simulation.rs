//! Simulations: pictures that follow from themselves, step by step, such as waves, smoke or patterns.
//!
//! A simulation is a text in WGSL with states, the steps that make them anew, and pictures of them; whoever draws the scene
//! knows those that are built in, and what a text has to be. Its steps are as long as its rate says, so that what it shows
//! at a time follows from that time alone.
//!
//! ```
//! # use manypass_scene::{Image, Scene};
//! # use manypass_scene::simulation::Simulation;
//! # let mut scene = Scene::default();
//! scene.simulations.push(Simulation { seed: 3, ..Simulation::built_in("coral", "gray_scott") });
//! scene.images.push(Image::of_simulation("coral", 0, "color")); // For a texture of a material.
//! scene.time_secs = 10.0; // What is shown is that after so many seconds.
//! ```

mod program;
mod seen;

pub use crate::image::SimulatedImage;
pub use program::{Program, Simulation};
pub use seen::{SIDE as SEEN_SIDE, SeenSurfaces};

use crate::animation::Path;
use crate::{Aabb, NodeId, Scene};
use glam::{Mat4, Vec2, Vec3};

/// The most simulations of a scene that are run.
pub const SIMULATIONS_MAX: usize = 16;

/// The most bodies and walls of a simulation together.
pub const BODIES_MAX: usize = 16;

/// The most cells along a side.
pub const CELLS_SIDE_MAX: u32 = 2048;

/// The most steps in a second.
pub const RATE_HZ_MAX: f32 = 10_000.0;

/// The rectangle that the cells of a simulation lie over: its middle, its unit axes to the right and up, as who looks onto
/// its front sees it, its unit normal, and its width and height in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// World space from the place's own: metres to the right, up and out of it, from its middle.
    pub world_from_place: Mat4,
    /// Width and height in metres.
    pub size_m: Vec2,
}

/// A body of a simulation, whose place can be told at every time of the animation that was last posed.
#[derive(Clone, Debug)]
pub struct Body<'s> {
    path: Path<'s>,
    /// The box around its meshes, seen from its node.
    bounds: Aabb,
    /// Whether it stands in the way.
    pub is_wall: bool,
}

impl Body<'_> {
    /// The box around it at a time, along the axes of a place and in its metres.
    pub fn bounds_in(&self, place: &Place, time_secs: f32) -> Aabb {
        let place_from_body = place.world_from_place.inverse() * self.path.world_from_object(time_secs);
        self.bounds.transformed(&place_from_body)
    }

    /// Its middle at a time, in metres of a place, and its radius: the mean of half its sides.
    pub fn sphere_in(&self, place: &Place, time_secs: f32) -> (Vec3, f32) {
        let place_from_body = place.world_from_place.inverse() * self.path.world_from_object(time_secs);
        let half = 0.5 * (self.bounds.max - self.bounds.min);
        let axes = [place_from_body.x_axis, place_from_body.y_axis, place_from_body.z_axis];
        let scaled = axes.iter().zip(half.to_array()).map(|(axis, half)| axis.truncate().length() * half);
        let middle = place_from_body.transform_point3(0.5 * (self.bounds.min + self.bounds.max));
        (middle, scaled.sum::<f32>() / 3.0)
    }

    /// Whether it moves in the animation.
    pub fn moves(&self) -> bool {
        self.path.moves()
    }
}

impl Default for Place {
    /// A square of 1 m in the middle of the world, which faces +Z.
    fn default() -> Self {
        Self { world_from_place: Mat4::IDENTITY, size_m: Vec2::ONE }
    }
}

impl Scene {
    /// Whether there is anything that simulations make or move.
    pub fn has_simulations(&self) -> bool {
        !self.simulations.is_empty() || !self.particles.is_empty()
    }

    /// The rectangle that the cells of a simulation lie over, as of the last [`Scene::update_transforms`].
    pub fn place_of_simulation(&self, index: usize) -> Place {
        let of_water = self.water.iter().find(|water| water.simulation == Some(index)).map(|water| water.node);
        let node = self.simulations.get(index).and_then(|simulation| simulation.place).or(of_water);
        let Some(panel) = node.and_then(|node| self.panel(node).ok()) else {
            return Place::default();
        };
        let [across, up] = panel.half_edges_world;
        let (right, up) = (across.normalize_or_zero(), up.normalize_or_zero());
        let size_m = 2.0 * Vec2::new(panel.half_edges_world[0].length(), panel.half_edges_world[1].length());
        let axes = [right.extend(0.0), up.extend(0.0), panel.normal_world.extend(0.0)];
        let world_from_place = Mat4::from_cols(axes[0], axes[1], axes[2], panel.center_world.extend(1.0));
        Place { world_from_place, size_m }
    }

    /// The bodies and walls of a simulation, at most [`BODIES_MAX`].
    pub fn bodies_of_simulation(&self, index: usize) -> Vec<Body<'_>> {
        let Some(simulation) = self.simulations.get(index) else { return Vec::new() };
        let all = simulation.bodies.iter().map(|id| (id, false)).chain(simulation.walls.iter().map(|id| (id, true)));
        all.filter_map(|(id, is_wall)| {
            let bounds = self.bounds_below(*id)?;
            Some(Body { path: self.path_of(*id), bounds, is_wall })
        })
        .take(BODIES_MAX)
        .collect()
    }

    /// The box around the meshes of a node and of all below it, seen from the node.
    fn bounds_below(&self, id: NodeId) -> Option<Aabb> {
        let mut ids = vec![(id, Mat4::IDENTITY)];
        let mut bounds = Aabb::EMPTY;
        while let Some((id, matrix)) = ids.pop() {
            let node = self.nodes.get(id.0 as usize)?;
            let mesh = node.mesh.and_then(|mesh| self.meshes.get(mesh));
            let boxes = mesh.iter().flat_map(|mesh| &mesh.primitives).map(|one| one.bounds.transformed(&matrix));
            bounds = boxes.fold(bounds, |bounds, other| bounds.union(&other));
            ids.extend(
                node.children
                    .iter()
                    .filter_map(|child| Some((*child, matrix * self.nodes.get(child.0 as usize)?.local_matrix()))),
            );
        }
        bounds.min.cmple(bounds.max).all().then_some(bounds)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::primitives::{cube, plane};
    use crate::{Animation, Channel, Interpolation, Keyframes, Mesh, Node};

    #[test]
    fn bodies_are_where_the_animation_has_them() {
        let mut scene = Scene::default();
        scene.meshes.push(Mesh { primitives: vec![plane(4.0)], ..Mesh::default() }.into());
        scene.meshes.push(Mesh { primitives: vec![cube(Vec3::splat(0.5))], ..Mesh::default() }.into());
        let floor = scene.add_node(None, Node { mesh: Some(0), translation: Vec3::Y, ..Node::default() });
        let carrier = scene.add_node(None, Node::default());
        let ball = scene.add_node(Some(carrier), Node { mesh: Some(1), translation: Vec3::Y, ..Node::default() });
        scene.animations.push(Animation {
            channels: vec![Channel {
                node: carrier,
                times_secs: vec![0.0, 2.0],
                interpolation: Interpolation::Linear,
                keyframes: Keyframes::Translation(vec![Vec3::ZERO, Vec3::X]),
            }],
            ..Animation::default()
        });
        let simulation = Simulation { place: Some(floor), bodies: vec![ball], ..Simulation::built_in("a", "ripples") };
        scene.simulations.push(simulation);
        scene.pose(0, 2.0);
        scene.update_transforms();
        let place = scene.place_of_simulation(0);
        assert!(place.size_m.abs_diff_eq(Vec2::splat(4.0), 1e-5), "{place:?}");
        let bodies = scene.bodies_of_simulation(0);
        assert!(bodies.len() == 1 && bodies[0].moves() && !bodies[0].is_wall);
        for time_secs in [0.0, 0.5, 2.0] {
            let (middle, radius_m) = bodies[0].sphere_in(&place, time_secs);
            let world = place.world_from_place.transform_point3(middle);
            let expected = Vec3::new(0.5 * time_secs, 1.0, 0.0);
            assert!(world.abs_diff_eq(expected, 1e-5), "{world} at {time_secs}");
            let size = bodies[0].bounds_in(&place, time_secs);
            assert!((size.max - size.min).abs_diff_eq(Vec3::splat(2.0 * radius_m), 1e-4), "{size:?} {radius_m}");
        }
        // Without an animation that was posed it is where it is.
        scene.posed = None;
        scene.node_mut(carrier).translation = 3.0 * Vec3::Z;
        let (middle, _) = scene.bodies_of_simulation(0)[0].sphere_in(&place, 0.0);
        assert!(place.world_from_place.transform_point3(middle).abs_diff_eq(Vec3::new(0.0, 1.0, 3.0), 1e-5));
    }
}
