//! Fits a camera of fixed rotation to points.
//!
//! Each of the four planes at the sides of the picture is touched by one point, its support. The two planes at the left and
//! the right settle how far back the camera stands and where between them; so do those above and below. The larger distance
//! wins. In the other direction there is room then, and the camera moves to where the outermost points of both sides are as
//! far from the picture's middle: planes of a smaller slope that still meet at the camera. That slope is found by Newton's
//! method on a convex function made of straight pieces, one for each pair of supports, so it ends after a few exact steps.

use super::points::Points;
use glam::{Mat3, Quat, Vec2, Vec3};

/// The share of the picture's width or height that stays free on each side of what is framed.
pub const MARGIN: f32 = 0.06;

/// What is framed, relative to an origin.
#[derive(Clone, Debug)]
enum Shape<'a> {
    /// Points.
    Points(&'a Points<3>),
    /// Circles around an axis through the origin.
    Rings {
        /// Of length 1.
        axis: Vec3,
        /// Radius, and height along the axis.
        rings: Points<2>,
    },
}

impl Shape<'_> {
    /// The point farthest along `direction`; the origin if there is none.
    fn support(&self, direction: Vec3) -> Vec3 {
        match self {
            Self::Points(points) => points.farthest(direction.to_array()).into(),
            Self::Rings { axis, rings } => {
                let along = direction.dot(*axis);
                let across = direction - *axis * along;
                let [radius, height] = rings.farthest([across.length(), along]);
                across.normalize_or(axis.any_orthonormal_vector()) * radius + *axis * height
            }
        }
    }

    /// The outermost points to both sides between planes that lean by `slope`.
    fn supports(&self, side: Vec3, back: Vec3, slope: f64) -> [Reach; 2] {
        let lean = back * slope as f32;
        [side, -side].map(|outward| {
            let point = self.support(outward + lean);
            Reach { side: dot(point, side), back: dot(point, back) }
        })
    }
}

/// Places cameras before what is framed. Their rotations are `world_from_view`; `half_extent` is half the width and height
/// of the picture at a distance of 1 m.
#[derive(Clone, Debug)]
pub struct Fit<'a> {
    origin_world: Vec3,
    radius_m: f32,
    shape: Shape<'a>,
}

/// Newton's method takes fewer than ten steps; this ends it where rounding would not.
const MOST_STEPS: usize = 64;

impl<'a> Fit<'a> {
    /// Of points relative to `origin_world`, about which they reach as far as `radius_m`.
    pub(super) fn of_points(points: &'a Points<3>, origin_world: Vec3, radius_m: f32) -> Self {
        Self { origin_world, radius_m, shape: Shape::Points(points) }
    }

    /// As [`Self::of_points`], for points that turn around the line through `on_axis_world` along `up`.
    pub(super) fn of_turning_points(
        points: &Points<3>,
        origin_world: Vec3,
        radius_m: f32,
        on_axis_world: Vec3,
        up: Vec3,
    ) -> Self {
        let to_axis = origin_world - on_axis_world;
        let ring = |point: Vec3| {
            let arm = point + to_axis;
            let height = arm.dot(up);
            [(arm - up * height).length(), height]
        };
        let rings = Points::new(points.iter().map(ring));
        Self { origin_world: on_axis_world, radius_m, shape: Shape::Rings { axis: up, rings } }
    }

    /// Where a camera sees everything, with [`MARGIN`] on each side of the picture's width or height, whichever limits, and
    /// as much on the left as on the right, and above as below.
    pub fn eye(&self, world_from_view: Quat, half_extent: Vec2) -> Vec3 {
        let Vec2 { x: slope_x, y: slope_y } = slopes(half_extent);
        let Mat3 { x_axis: right, y_axis: up, z_axis: back } = Mat3::from_quat(world_from_view);
        let (x, y) = (self.between(right, back, slope_x), self.between(up, back, slope_y));
        let eye_back = x.eye_back.max(y.eye_back).max(self.nearest(back));
        let along = |axis: Vec3, limits: Place| {
            if limits.eye_back < eye_back { self.centred(axis, back, eye_back) } else { limits.eye_side }
        };
        self.world((right, along(right, x)), (up, along(up, y)), (back, eye_back))
    }

    /// As [`Self::eye`], for parallel rays, which see the same from any distance: one from which nothing is cut.
    pub fn eye_of_parallel_rays(&self, world_from_view: Quat) -> Vec3 {
        let Mat3 { x_axis: right, y_axis: up, z_axis: back } = Mat3::from_quat(world_from_view);
        let middle = |side: Vec3| {
            let [high, low] = self.shape.supports(side, back, 0.0);
            0.5 * (high.side + low.side)
        };
        let eye_back = dot(self.shape.support(back), back) + f64::from(self.radius_m);
        self.world((right, middle(right)), (up, middle(up)), (back, eye_back))
    }

    /// How far from `target_world` a camera that looks at it sees everything.
    pub fn distance_m(&self, target_world: Vec3, world_from_view: Quat, half_extent: Vec2) -> f32 {
        let slopes = slopes(half_extent);
        let Mat3 { x_axis: right, y_axis: up, z_axis: back } = Mat3::from_quat(world_from_view);
        let target = target_world - self.origin_world;
        let target_back = dot(target, back);
        let mut distance = self.nearest(back) - target_back;
        for (side, slope) in [(right, f64::from(slopes.x)), (up, f64::from(slopes.y))] {
            let target_side = dot(target, side);
            let [high, low] = self.shape.supports(side, back, slope);
            distance = distance.max((high.side - target_side) / slope + high.back - target_back);
            distance = distance.max((target_side - low.side) / slope + low.back - target_back);
        }
        distance as f32
    }

    /// A near plane that cuts nothing: half of the way to the nearest point along the axis of the camera, or from inside a
    /// thousandth of the radius.
    pub fn near_m(&self, eye_world: Vec3, world_from_view: Quat) -> f32 {
        let back = world_from_view * Vec3::Z;
        let gap_m = dot(eye_world - self.origin_world, back) - dot(self.shape.support(back), back);
        (0.5 * gap_m as f32).max(1e-3 * self.radius_m)
    }

    /// The nearest place along `back` for an eye: a needle that points at the camera would have it touch the tip.
    fn nearest(&self, back: Vec3) -> f64 {
        dot(self.shape.support(back), back) + 0.05 * f64::from(self.radius_m)
    }

    /// Where the two planes that lean by `slope` meet.
    fn between(&self, side: Vec3, back: Vec3, slope: f32) -> Place {
        let slope = f64::from(slope);
        let [high, low] = self.shape.supports(side, back, slope);
        Place {
            eye_side: 0.5 * (high.side + low.side + slope * (high.back - low.back)),
            eye_back: (high.side - low.side + slope * (high.back + low.back)) / (2.0 * slope),
        }
    }

    /// Where along `side` the eye stands, at `eye_back`, so that it sees as far to one side as to the other.
    fn centred(&self, side: Vec3, back: Vec3, eye_back: f64) -> f64 {
        let (mut slope, mut eye_side) = (0.0, 0.0);
        for _ in 0..MOST_STEPS {
            let [high, low] = self.shape.supports(side, back, slope);
            let next = (high.side - low.side) / (2.0 * eye_back - high.back - low.back);
            eye_side = 0.5 * (high.side + low.side + next * (high.back - low.back));
            if next <= slope * (1.0 + 1e-9) {
                break;
            }
            slope = next;
        }
        eye_side
    }

    fn world(&self, right: (Vec3, f64), up: (Vec3, f64), back: (Vec3, f64)) -> Vec3 {
        let along = |(axis, length): (Vec3, f64)| axis.as_dvec3() * length;
        (self.origin_world.as_dvec3() + along(right) + along(up) + along(back)).as_vec3()
    }
}

/// The half extent that is left inside the margins.
fn slopes(half_extent: Vec2) -> Vec2 {
    half_extent.max(Vec2::splat(1e-4)) * (1.0 - 2.0 * MARGIN)
}

/// The place of an eye.
#[derive(Clone, Copy)]
struct Place {
    eye_side: f64,
    eye_back: f64,
}

/// The place of a support.
#[derive(Clone, Copy)]
struct Reach {
    side: f64,
    back: f64,
}

/// Rounding of single precision would show where a model lies far from a long lens.
fn dot(point: Vec3, axis: Vec3) -> f64 {
    point.as_dvec3().dot(axis.as_dvec3())
}
