//! The ball around something, by which levels of detail know how large it is in the picture.

use glam::{Mat3, Mat4, Vec3};
use manypass_scene::{Aabb, Node};

/// A ball in world space, and an upright box around the same.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ball {
    pub center: Vec3,
    pub radius_m: f32,
    bounds: Aabb,
}

impl Ball {
    /// The ball around an upright box.
    pub fn around(bounds: &Aabb) -> Self {
        Self { center: bounds.center(), radius_m: bounds.radius_m(), bounds: *bounds }
    }

    /// The ball around what a node draws: of what nothing deforms by its box in object space and how far its farthest
    /// vertex lies from the middle of that.
    pub fn of_node(node: &Node, rigid: Option<(&Aabb, f32)>) -> Self {
        match rigid {
            Some((bounds, radius_m)) => Self::posed(bounds, radius_m, &node.world_from_object),
            None => Self::around(&node.bounds_world),
        }
    }

    /// The ball around vertices that lie in a box of object space, none farther than `radius_m` from its middle. It is
    /// the smaller one of those around the box and around a ball of that radius, where the matrix puts them: exact for
    /// boxes and for spheres, however they are stretched.
    pub fn posed(bounds: &Aabb, radius_m: f32, world_from_object: &Mat4) -> Self {
        if bounds.is_empty() {
            return Self::around(bounds);
        }
        let half = 0.5 * (bounds.max - bounds.min);
        let linear = Mat3::from_mat4(*world_from_object);
        let [x, y, z] = [linear.x_axis * half.x, linear.y_axis * half.y, linear.z_axis * half.z];
        // The other four corners are as far away.
        let to_corner_m =
            [x + y + z, x + y - z, x - y + z, x - y - z].map(Vec3::length).into_iter().fold(0.0, f32::max);
        let radius_m = to_corner_m.min(radius_m * stretch_max(&linear));
        let center = world_from_object.transform_point3(bounds.center());
        let half = (x.abs() + y.abs() + z.abs()).min(Vec3::splat(radius_m));
        Self { center, radius_m, bounds: Aabb { min: center - half, max: center + half } }
    }

    /// A ball around several.
    pub fn around_all(balls: impl Iterator<Item = Self> + Clone) -> Self {
        let bounds = balls.clone().fold(Aabb::EMPTY, |bounds, ball| bounds.union(&ball.bounds));
        let around = Self::around(&bounds);
        let reach_m = |ball: Self| around.center.distance(ball.center) + ball.radius_m;
        let radius_m = balls.map(reach_m).fold(0.0, f32::max);
        Self { radius_m: radius_m.min(around.radius_m), ..around }
    }
}

/// How many times as long a matrix makes a vector, at most: its largest singular value.
///
/// Source: Smith 1961, "Eigenvalues of a symmetric 3 × 3 matrix".
fn stretch_max(matrix: &Mat3) -> f32 {
    let longest = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(Vec3::length).into_iter().fold(0.0, f32::max);
    if longest <= 0.0 {
        return 0.0;
    }
    // Near 1, so that squares of squares are numbers.
    let matrix = *matrix * (1.0 / longest);
    let squared = matrix.transpose() * matrix;
    let trace = |matrix: &Mat3| matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z;
    let mean = trace(&squared) / 3.0;
    let rest = squared - Mat3::from_diagonal(Vec3::splat(mean));
    let spread = (trace(&(rest * rest)) / 6.0).sqrt();
    // As much as rounding leaves of a matrix that only turns and scales evenly.
    if spread < 1e-6 {
        return longest * mean.sqrt();
    }
    let angle_rad = (0.5 * (rest * (1.0 / spread)).determinant()).clamp(-1.0, 1.0).acos() / 3.0;
    longest * (mean + 2.0 * spread * angle_rad.cos()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    const UNIT: Aabb = Aabb { min: Vec3::NEG_ONE, max: Vec3::ONE };

    fn turned(x_rad: f32, y_rad: f32) -> Mat4 {
        Mat4::from_quat(Quat::from_rotation_x(x_rad) * Quat::from_rotation_y(y_rad))
    }

    #[test]
    fn spheres_and_boxes_have_their_own_balls_however_they_are_stretched() {
        let (scale, place) = (Vec3::new(0.5, 3.0, -2.0), Vec3::new(4.0, 5.0, 6.0));
        let stretched = Mat4::from_scale(scale);
        // Turned before, after, and both: an ellipsoid with half axes of 0.5, 3 and 2.
        let (none, some, other) = (Mat4::IDENTITY, turned(0.4, 1.0), turned(-1.0, 0.2));
        for (before, after) in [(none, none), (none, some), (some, none), (some, other)] {
            let matrix = Mat4::from_translation(place) * after * stretched * before;
            let sphere = Ball::posed(&UNIT, 1.0, &matrix);
            assert!((sphere.radius_m - 3.0).abs() < 1e-4 && sphere.center.distance(place) < 1e-5, "{sphere:?}");
        }
        let cube = Ball::posed(&UNIT, 3f32.sqrt(), &(turned(0.4, 1.0) * stretched));
        assert!((cube.radius_m - scale.length()).abs() < 1e-5, "{cube:?}");
        let same = Ball::posed(&UNIT, 1.0, &(turned(0.1, 0.2) * Mat4::from_scale(Vec3::splat(1e-12))));
        assert!((same.radius_m - 1e-12).abs() < 1e-17, "{same:?}");
        assert_eq!(Ball::posed(&UNIT, 1.0, &Mat4::from_scale(Vec3::ZERO)).radius_m, 0.0);
        assert_eq!(Ball::posed(&Aabb::EMPTY, 0.0, &Mat4::IDENTITY).radius_m, 0.0);
    }

    #[test]
    fn several_have_the_ball_around_their_box_or_around_theirs() {
        let at = |x_m: f32, radius_m: f32| Ball::posed(&UNIT, radius_m, &Mat4::from_translation(Vec3::X * x_m));
        let all = |balls: [Ball; 2]| Ball::around_all(balls.into_iter());
        let spheres = all([at(-2.0, 1.0), at(2.0, 1.0)]);
        assert_eq!((spheres.center, spheres.radius_m), (Vec3::ZERO, 3.0));
        let cubes = all([at(-1.0, 3f32.sqrt()), at(1.0, 3f32.sqrt())]);
        assert!((cubes.radius_m - 6f32.sqrt()).abs() < 1e-6, "{cubes:?}");
    }
}
