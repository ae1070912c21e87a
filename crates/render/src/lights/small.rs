//! Which lights are seen so small that they lose their range.
//!
//! What a light at a place reaches is a sphere; how many pixels wide that is where it is nearest to the eye says what
//! the light is worth, in whichever direction it lies, so that a turning camera changes nothing. Between twice the
//! least size and the least size its range shrinks to nothing, so that none appears or goes at once. It is decided where
//! the table of lights is made, and so it is the same in every way of lighting.

use super::Reach;
use crate::view::View;
use glam::Vec3;
use manypass_scene::LightKind;

/// From how many times the least size on a light has all of its range.
const WHOLE_AT: f32 = 2.0;
/// A smaller share of the range than this is none.
const SHARE_MIN: f32 = 1e-3;

/// From where lights are seen, and how large they have to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeastLights {
    view: View,
    size_px: (u32, u32),
    min_px: f32,
}

impl LeastLights {
    /// Those of at least `min_px` pixels in a picture of `size_px`; none if all count.
    pub fn new(view: &View, size_px: (u32, u32), min_px: f32) -> Option<Self> {
        (min_px > 0.0).then_some(Self { view: *view, size_px, min_px })
    }

    /// What is left of the range of a light, as a share: 1 of most, 0 of one that is left out.
    pub(super) fn share(&self, kind: LightKind, position: Vec3, direction: Vec3, range_m: f32) -> f32 {
        let reach = Reach::of_light(kind, position, direction, range_m);
        let eye = self.view.world_from_view.w_axis.truncate();
        let nearest_m = reach.center.distance(eye) - reach.radius_m;
        if nearest_m <= 0.0 && !self.view.is_orthographic() {
            return 1.0;
        }
        let width_px = 2.0 * reach.radius_m * self.view.pixels_per_m(self.size_px, nearest_m);
        let share = (width_px / self.min_px - 1.0) / (WHOLE_AT - 1.0);
        if share < SHARE_MIN { 0.0 } else { share.min(1.0) }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use super::*;
    use glam::Mat4;
    use manypass_scene::Projection;

    /// At the origin; a metre is 100 pixels wide at a distance of a metre, or everywhere.
    fn view(is_orthographic: bool) -> View {
        let projection = if is_orthographic {
            Projection::Orthographic { height_m: 1.0, near_m: 0.1, far_m: 1e4 }
        } else {
            Projection::Perspective { fov_y_rad: 2.0 * 0.5f32.atan(), near_m: 0.1, far_m: None }
        };
        View { world_from_view: Mat4::IDENTITY, projection }
    }

    fn share(least: &LeastLights, kind: LightKind, place: Vec3, range_m: f32) -> f32 {
        least.share(kind, place, Vec3::NEG_Y, range_m)
    }

    #[test]
    fn ranges_shrink_between_two_sizes_in_every_direction() {
        let least = LeastLights::new(&view(false), (160, 100), 4.0).unwrap();
        // Of 1 m: nearest at the distance less 1 m, so that 200 px / (d − 1) is its width.
        for (distance_m, expected) in [(0.5, 1.0), (1.0, 1.0), (20.0, 1.0), (25.9, 1.0), (51.1, 0.0), (1e30, 0.0)] {
            for direction in [Vec3::NEG_Z, Vec3::Z, Vec3::X, Vec3::new(0.6, 0.0, -0.8)] {
                let found = share(&least, LightKind::Point, direction * distance_m, 1.0);
                assert_eq!(found, expected, "{distance_m} m along {direction}");
            }
        }
        let between = share(&least, LightKind::Point, Vec3::NEG_Z * (1.0 + 200.0 / 6.0), 1.0);
        assert!((between - 0.5).abs() < 1e-4, "{between}");
        let shares: Vec<f32> =
            (0..2000u16).map(|step| share(&least, LightKind::Point, Vec3::X * f32::from(step) * 0.03, 1.0)).collect();
        assert!(shares.is_sorted_by(|near, far| near >= far));
        let jump = shares.windows(2).map(|pair| pair[0] - pair[1]).fold(0.0, f32::max);
        assert!(jump < 0.01, "{jump}: a light goes at once");
    }

    #[test]
    fn a_narrow_spot_is_as_wide_as_the_sphere_around_its_cone() {
        let least = LeastLights::new(&view(false), (160, 100), 4.0).unwrap();
        let spot = LightKind::Spot { inner_cone_rad: 0.0, outer_cone_rad: 0.1 };
        let place = Vec3::NEG_Z * 20.0;
        assert_eq!(share(&least, LightKind::Point, place, 1.0), 1.0);
        let narrow = share(&least, spot, place, 1.0);
        assert!((0.2..0.4).contains(&narrow), "half as wide, and hanging down from there: {narrow}");
    }

    #[test]
    fn with_parallel_rays_distance_does_not_matter() {
        let least = LeastLights::new(&view(true), (160, 100), 4.0).unwrap();
        for distance_m in [0.0, 1.0, 1e3] {
            let shares =
                [0.01, 0.03, 0.05].map(|range_m| share(&least, LightKind::Point, Vec3::NEG_Z * distance_m, range_m));
            assert!(shares[0] == 0.0 && (shares[1] - 0.5).abs() < 1e-4 && shares[2] == 1.0, "{shares:?}");
        }
    }

    #[test]
    fn without_a_least_size_all_count() {
        assert_eq!(LeastLights::new(&view(false), (160, 100), 0.0), None);
    }
}
