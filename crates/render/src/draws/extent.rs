//! The extent of what a view sees, which lengths follow that settings leave open.

use super::world::WorldDraws;
use crate::view::ViewUniform;
use glam::{Mat4, Vec2, Vec3, Vec4};
use manypass_scene::Aabb;
use std::array;
use std::ops::Range;

/// Rays along each side of the picture.
const RAYS: usize = 16;

/// The extent is at most so many times as long as what the picture's longer side shows of a metre's mean size. A scene
/// that is framed as a whole is about one such length, and a room from within about three: those keep their diagonal.
const PICTURES_MAX: f32 = 8.0;

/// The diagonal of a box in metres; 1 if it is empty.
fn diagonal_m(bounds: &Aabb) -> f32 {
    if bounds.is_empty() { 1.0 } else { bounds.min.distance(bounds.max) }
}

impl WorldDraws {
    /// The diagonal of all that is drawn, in metres, if the view sees a good part of it, and else a length that goes
    /// with how large a metre is seen in the mean: what stands on a plain of 100 km has the lengths that it has in a
    /// room. It need not be finite.
    pub fn extent_m(&self, view: &ViewUniform) -> f32 {
        let diagonal_m = diagonal_m(&self.bounds_world);
        let picture_m = 2.0 * PICTURES_MAX * view.view_from_ndc_scale.max_element();
        if view.orthographic > 0.5 {
            return diagonal_m.min(picture_m);
        }
        // All that is drawn is at least as far away.
        let middle_m = -view.view_from_world.transform_point3(self.bounds_world.center()).z;
        if !diagonal_m.is_finite() || picture_m * (middle_m - 0.5 * diagonal_m) >= diagonal_m {
            return diagonal_m;
        }
        let of = ([view.world_from_view, view.view_from_world], view.view_from_ndc_scale);
        self.lists.extent_m(of, || diagonal_m.min(picture_m / self.mean_nearness_per_m(view)))
    }

    /// The mean over the picture of 1 / the distance along the view axis.
    fn mean_nearness_per_m(&self, view: &ViewUniform) -> f32 {
        let mut rays = Rays::new(view);
        rays.meet(&self.flat_bounds_world);
        for item in &self.items {
            match &item.parts {
                Some(parts) if has_within(&item.bounds_world, rays.eye) => {
                    let [x, y, z] = self.instances[item.instance as usize].world_from_object.map(Vec4::from_array);
                    let world_from_object = Mat4::from_cols(x, y, z, Vec4::W).transpose();
                    let parts = parts.iter().filter(|part| !part.is_empty());
                    parts.for_each(|part| rays.meet(&part.transformed(&world_from_object)));
                }
                _ => rays.meet(&item.bounds_world),
            }
        }
        rays.mean_nearness_per_m()
    }
}

fn has_within(bounds: &Aabb, point: Vec3) -> bool {
    bounds.min.cmple(point).all() && bounds.max.cmpge(point).all()
}

/// Rays through the picture, evenly, in rows.
struct Rays<'v> {
    view: &'v ViewUniform,
    eye: Vec3,
    /// To what is 1 m away along the view axis.
    directions: [Vec3; RAYS * RAYS],
    /// 1 / the distance along the view axis at which each meets something; 0 where it meets nothing.
    nearness_per_m: [f32; RAYS * RAYS],
}

impl<'v> Rays<'v> {
    fn new(view: &'v ViewUniform) -> Self {
        let direction = |at: usize| {
            let place = Vec2::new((at % RAYS) as f32, (at / RAYS) as f32) + 0.5;
            let ndc = place * (2.0 / RAYS as f32) - 1.0;
            view.world_from_view.transform_vector3((ndc * view.view_from_ndc_scale).extend(-1.0))
        };
        let eye = view.world_from_view.w_axis.truncate();
        Self { view, eye, directions: array::from_fn(direction), nearness_per_m: [0.0; RAYS * RAYS] }
    }

    /// Which columns, or rows, may meet a ball whose middle lies so far beside the view axis, between two distances
    /// along it. `half` is half the extent of the picture.
    fn range(&self, beside_m: f32, radius_m: f32, [near_m, far_m]: [f32; 2], half: f32) -> Range<usize> {
        if near_m <= 0.0 {
            return 0..RAYS;
        }
        let [low_m, high_m] = [beside_m - radius_m, beside_m + radius_m];
        let low = low_m / if low_m < 0.0 { near_m } else { far_m };
        let high = high_m / if high_m < 0.0 { far_m } else { near_m };
        let place = |tangent: f32| (0.5 * tangent / half + 0.5) * RAYS as f32 - 0.5;
        let first = place(low).ceil().max(0.0) as usize;
        let end = (place(high).floor() + 1.0).clamp(0.0, RAYS as f32) as usize;
        first..end
    }

    /// What is in the box may be met.
    fn meet(&mut self, bounds: &Aabb) {
        if bounds.is_empty() {
            return;
        }
        let middle = self.view.view_from_world.transform_point3(bounds.center());
        let radius_m = bounds.radius_m();
        let depths_m = [-middle.z - radius_m, -middle.z + radius_m];
        if depths_m[1] <= 0.0 {
            return;
        }
        let half = self.view.view_from_ndc_scale;
        let columns = self.range(middle.x, radius_m, depths_m, half.x);
        for row in self.range(middle.y, radius_m, depths_m, half.y) {
            for at in columns.clone().map(|column| row * RAYS + column) {
                if let Some(distance_m) = met_at_m(bounds, self.eye, self.directions[at]) {
                    self.nearness_per_m[at] = self.nearness_per_m[at].max(1.0 / distance_m);
                }
            }
        }
    }

    fn mean_nearness_per_m(&self) -> f32 {
        self.nearness_per_m.iter().sum::<f32>() / (RAYS * RAYS) as f32
    }
}

/// At how many of `ray` from `eye` a box is met: where it is entered, or from within, as a room is, where it is left.
fn met_at_m(bounds: &Aabb, eye: Vec3, ray: Vec3) -> Option<f32> {
    let inverse = ray.recip();
    let (to_min, to_max) = ((bounds.min - eye) * inverse, (bounds.max - eye) * inverse);
    let (enters, leaves) = (to_min.min(to_max).max_element(), to_min.max(to_max).min_element());
    let at = if enters > 0.0 { enters } else { leaves };
    (leaves >= enters && at > 0.0).then_some(at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::{DepthRange, View};
    use glam::camera::rh::view::look_at_mat4;
    use manypass_scene::Projection;

    /// At `eye`, to what is so far ahead, a little below.
    fn view(eye: Vec3, target: Vec3) -> ViewUniform {
        let projection = Projection::Perspective { fov_y_rad: 0.8, near_m: 0.05, far_m: None };
        let view = View { world_from_view: look_at_mat4(eye, target, Vec3::Y).inverse(), projection };
        view.uniform(DepthRange { near_m: 0.05, far_m: 1e6 }, 160, 120, Vec2::ZERO, 1.0, 0)
    }

    fn cube(center: Vec3, half_m: f32) -> Aabb {
        Aabb { min: center - half_m, max: center + half_m }
    }

    /// A ground of half the side `half_m` and a cube of 1 m on it.
    fn extent_m(half_m: f32, scale: f32, eye: Vec3) -> f32 {
        let ground = scale * Vec3::new(half_m, 0.0, half_m);
        let ground = Aabb { min: -ground, max: ground };
        let of_cube = cube(scale * Vec3::new(0.0, 0.5, 0.0), 0.5 * scale);
        let view = view(scale * eye, scale * Vec3::new(0.0, 0.5, 0.0));
        let mut rays = Rays::new(&view);
        rays.meet(&ground);
        rays.meet(&of_cube);
        let picture_m = 2.0 * PICTURES_MAX * rays.view.view_from_ndc_scale.max_element();
        diagonal_m(&ground.union(&of_cube)).min(picture_m / rays.mean_nearness_per_m())
    }

    #[test]
    fn extents_of_large_scenes_are_those_of_what_is_seen() {
        let eye = Vec3::new(0.0, 1.5, 3.0);
        let [small, large, plain] = [20.0, 1e3, 5e4].map(|half_m| extent_m(half_m, 1.0, eye));
        assert!((10.0..60.0).contains(&small), "{small}");
        assert!((large - small).abs() < 0.05 * small && (plain - small).abs() < 0.05 * small, "{large} {plain}");
        for scale in [1e-3, 1e3] {
            let scaled = extent_m(5e4, scale, eye) / scale;
            assert!((scaled - plain).abs() < 1e-3 * plain, "× {scale}: {scaled}");
        }
        let turned = |angle: f32| Vec3::new(3.0 * angle.sin(), 1.5, 3.0 * angle.cos());
        let around = [1.0, 2.0, 3.0].map(|angle| extent_m(5e4, 1.0, turned(angle)));
        assert!(around.iter().all(|length| (length - plain).abs() < 0.1 * plain), "{around:?}");
    }

    #[test]
    fn scenes_that_are_framed_as_a_whole_keep_their_diagonal() {
        let world = &mut WorldDraws::default();
        world.bounds_world = cube(Vec3::ZERO, 1.0);
        let whole = world.bounds_world.min.distance(world.bounds_world.max);
        for turn in [0.0f32, 0.7, 2.0] {
            let eye = 5.0 * Vec3::new(turn.sin(), 0.3, turn.cos());
            assert_eq!(world.extent_m(&view(eye, Vec3::ZERO)), whole);
        }
        assert_eq!(WorldDraws::default().extent_m(&view(Vec3::Z, Vec3::ZERO)), 1.0);
    }

    #[test]
    fn a_box_is_met_where_it_is_entered_and_a_room_where_it_ends() {
        let bounds = cube(Vec3::ZERO, 1.0);
        let ahead = |z_m: f32| met_at_m(&bounds, Vec3::new(0.1, 0.2, z_m), Vec3::new(1e-4, 1e-4, -1.0));
        let near = |found: Option<f32>, truth: f32| found.is_some_and(|found| (found - truth).abs() < 1e-5);
        assert!(near(ahead(4.0), 3.0) && near(ahead(0.5), 1.5) && ahead(-2.0).is_none());
        // Rays that no column or row is asked about meet nothing.
        let seen = view(Vec3::new(0.0, 0.0, 6.0), Vec3::ZERO);
        for (x_m, y_m, half_m) in [(0.0, 0.0, 1.0), (-1.5, 0.8, 0.4), (2.0, -1.0, 0.7), (0.3, 0.2, 0.05)] {
            let bounds = cube(Vec3::new(x_m, y_m, 0.0), half_m);
            let mut rays = Rays::new(&seen);
            rays.meet(&bounds);
            for (direction, nearness) in rays.directions.iter().zip(rays.nearness_per_m) {
                let truth = met_at_m(&bounds, rays.eye, *direction).map_or(0.0, |distance_m| 1.0 / distance_m);
                assert_eq!(nearness, truth, "{bounds:?}");
            }
        }
    }
}
