//! Where on the lens, and when, the samples of a still are taken.
//!
//! Source: Cook et al. 1984, "Distributed Ray Tracing", by accumulation: Haeberli & Akeley 1990, "The Accumulation
//! Buffer". Every sample is a picture through one point of a thin lens: a pinhole there, whose frustum is sheared so that
//! the plane in focus stays where it is in the picture. Points lie on the disc by Shirley & Chiu 1997, "A Low Distortion
//! Map Between Disk and Square". The picture's scale does not depend on the focus: there is no focus breathing.
//!
//! The first sample is taken through the middle of the lens in the middle of the shutter's time, so that a single one
//! and variables are those of the pinhole.

use crate::request::FrameRequest;
use crate::view::View;
use glam::{Mat4, Vec2, Vec3};
use manypass_scene::{Aabb, Projection};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

/// A camera as a sample sees through it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SampleView {
    /// At the sample's point of the lens.
    pub camera: View,
    /// How far the picture is moved, so that what is in focus stays where it is.
    pub shift_ndc: Vec2,
    /// How far samples see beyond the picture of the pinhole: metres everywhere, and beside them metres a metre.
    pub beyond: [f32; 2],
}

impl SampleView {
    /// Of the sample of `request`, in a picture whose width is `aspect` times its height; what is drawn lies within
    /// `bounds_world`.
    pub fn of(request: &FrameRequest, aspect: f32, bounds_world: &Aabb) -> Self {
        let camera = request.camera;
        let Some(radius_m) = request.lens_radius_m() else {
            return Self { camera, shift_ndc: Vec2::ZERO, beyond: [0.0; 2] };
        };
        let (sample_index, sample_count) = request.sample();
        let offset_m = lens_position(sample_index, sample_count) * radius_m;
        let focus_m = match request.settings.camera.focus_m {
            0.0 => camera.automatic_focus_m(bounds_world),
            focus_m => focus_m,
        };
        // A point (x, y, −focus) in view space is at (x − offset, …) of the moved camera.
        let shift_ndc = offset_m / (focus_m * camera.half_extent(aspect));
        let world_from_view = camera.world_from_view * Mat4::from_translation(offset_m.extend(0.0));
        Self { camera: View { world_from_view, ..camera }, shift_ndc, beyond: [radius_m, radius_m / focus_m] }
    }
}

impl SampleView {
    /// The same, whose picture is moved by more, so that it reaches beyond the frustum by so many metres a metre.
    pub fn sheared(mut self, shift_ndc: Vec2, beyond: f32) -> Self {
        self.shift_ndc += shift_ndc;
        self.beyond[1] += beyond;
        self
    }

    /// The shift in pixels of a picture that is shaded at a size.
    pub fn shift_px(&self, (width, height): (u32, u32)) -> Vec2 {
        0.5 * self.shift_ndc * Vec2::new(width as f32, -(height as f32))
    }
}

impl FrameRequest {
    /// The radius of the lens, if samples are taken through its points.
    pub(crate) fn lens_radius_m(&self) -> Option<f32> {
        let settings = &self.settings.camera;
        let (_, sample_count) = self.sample();
        let is_sampled = settings.f_stop > 0.0 && sample_count > 1 && !self.goes_on;
        let Projection::Perspective { fov_y_rad, .. } = self.camera.projection else { return None };
        // A camera's scale is none of its lens.
        let focal_m = 0.5e-3 * settings.sensor_height_mm / (0.5 * fov_y_rad).tan();
        is_sampled.then_some(0.5 * focal_m / settings.f_stop)
    }

    /// Whether the samples of a still show the scene from different places or at different times: then radiance is
    /// averaged, because a light that is spread over many pixels must lose none of it.
    pub(crate) fn samples_lens_or_shutter(&self) -> bool {
        let settings = &self.settings.camera;
        let (_, sample_count) = self.sample();
        (settings.f_stop > 0.0 || settings.shutter_deg > 0.0) && sample_count > 1 && !self.goes_on
    }
}

impl View {
    /// The distance along the axis of a point in world space; negative behind the camera.
    pub fn distance_m(&self, point_world: Vec3) -> f32 {
        -self.world_from_view.inverse().transform_point3(point_world).z
    }

    /// What `camera.focus_m` is where nobody says: the distance of the middle of `bounds_world`; where that is behind the
    /// camera or just before it, as in a room, half of how far anything in it is away.
    pub fn automatic_focus_m(&self, bounds_world: &Aabb) -> f32 {
        let middle_m = if bounds_world.is_empty() { 0.0 } else { self.distance_m(bounds_world.center()) };
        let farthest_m = self.depth_range(bounds_world).far_m.max(1e-3);
        if middle_m > 0.1 * farthest_m { middle_m } else { 0.5 * farthest_m }
    }
}

/// The middle of the shutter's time is 0, its ends, which no sample has, are −0.5 and 0.5: the golden ratio's multiples,
/// which divide it evenly for any number of samples. 0 of a single sample.
pub fn shutter_position(sample_index: u32, sample_count: u32) -> f32 {
    if sample_count <= 1 {
        return 0.0;
    }
    let golden = 0.618_033_988_749_894_9;
    ((0.5 + f64::from(sample_index) * golden).fract() - 0.5) as f32
}

/// Where on the lens a sample is taken, in radii: of the first two dimensions of Sobol's sequence (Sobol 1967), turned
/// so that the first lies in the middle. Jitter is of another sequence, so that the two have nothing to do with each
/// other.
fn lens_position(sample_index: u32, sample_count: u32) -> Vec2 {
    if sample_index == 0 || sample_count <= 1 {
        return Vec2::ZERO;
    }
    // Points lie at the lower corners of cells; half a cell further their mean is the middle.
    let cells = f64::from(sample_count.next_power_of_two());
    let unit = |bits: u32| (f64::from(bits ^ 0x8000_0000) / 4_294_967_296.0 + 0.5 / cells) as f32;
    concentric_disc(Vec2::new(unit(sample_index.reverse_bits()), unit(sobol_second(sample_index))))
}

/// The second dimension of Sobol's sequence, in units of 2⁻³².
fn sobol_second(mut index: u32) -> u32 {
    let (mut direction, mut value) = (0x8000_0000u32, 0);
    while index != 0 {
        if index & 1 == 1 {
            value ^= direction;
        }
        index >>= 1;
        direction ^= direction >> 1;
    }
    value
}

/// A point of the unit disc for one of the unit square: squares around the middle become circles (Shirley & Chiu 1997),
/// and parts of equal area stay so.
fn concentric_disc(unit: Vec2) -> Vec2 {
    let square = 2.0 * unit - 1.0;
    if square == Vec2::ZERO {
        return Vec2::ZERO;
    }
    let (radius, angle_rad) = if square.x.abs() > square.y.abs() {
        (square.x, FRAC_PI_4 * (square.y / square.x))
    } else {
        (square.y, FRAC_PI_2 - FRAC_PI_4 * (square.x / square.y))
    };
    radius * Vec2::from_angle(angle_rad)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::DepthRange;

    #[test]
    fn the_lens_is_covered_evenly_from_its_middle() {
        assert_eq!(lens_position(0, 64), Vec2::ZERO);
        assert_eq!(lens_position(0, 1), Vec2::ZERO);
        for count in [32u32, 64, 100, 256] {
            let points: Vec<Vec2> = (0..count).map(|index| lens_position(index, count)).collect();
            assert!(points.iter().all(|point| point.length() < 1.0), "{count}");
            let mean = points.iter().sum::<Vec2>() / count as f32;
            assert!(mean.length() < 0.6 / (count as f32).sqrt().powf(1.5), "{count}: {mean}");
            // Of a disc with an even density, half lies within √½ of the radius, a quarter in each quadrant.
            let share = |is_in: &dyn Fn(&Vec2) -> bool| {
                points.iter().filter(|point| is_in(point)).count() as f32 / count as f32
            };
            let tolerance = 0.6 / (count as f32).sqrt();
            assert!((share(&|point| point.length_squared() < 0.5) - 0.5).abs() < tolerance, "{count}");
            assert!((share(&|point| point.x > 0.0 && point.y > 0.0) - 0.25).abs() < tolerance, "{count}");
            // No two lie together.
            let nearest = |at: usize| {
                let others = points.iter().enumerate().filter(|(other, _)| *other != at);
                others.map(|(_, point)| point.distance(points[at])).fold(f32::INFINITY, f32::min)
            };
            let least = (0..points.len()).map(nearest).fold(f32::INFINITY, f32::min);
            assert!(least > 0.15 / (count as f32).sqrt(), "{count}: {least}");
        }
    }

    #[test]
    fn the_time_of_the_shutter_is_divided_evenly_around_its_middle() {
        assert_eq!(shutter_position(0, 16), 0.0);
        assert_eq!(shutter_position(5, 1), 0.0);
        for count in [2u32, 7, 16, 100, 4096] {
            let mut times: Vec<f32> = (0..count).map(|index| shutter_position(index, count)).collect();
            times.sort_by(f32::total_cmp);
            assert!(times.iter().all(|time| time.abs() < 0.5), "{count}");
            let gap = times.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f32::max);
            // Gaps between multiples of the golden ratio differ by at most its square.
            assert!(gap < 2.0 / count as f32 * 1.31, "{count}: {gap}");
        }
    }

    #[test]
    fn the_plane_in_focus_stays_where_it_is() {
        let projection = Projection::Perspective { fov_y_rad: 0.7, near_m: 0.1, far_m: None };
        let world_from_view = Mat4::from_rotation_translation(
            glam::Quat::from_euler(glam::EulerRot::YXZ, 0.7, -0.4, 0.2),
            Vec3::new(3.0, 4.0, 5.0),
        );
        let mut request = FrameRequest::new(97, 73, View { world_from_view, projection });
        request.sample_count = 16;
        (request.settings.camera.f_stop, request.settings.camera.focus_m) = (0.5, 4.0);
        let aspect = 97.0 / 73.0;
        let range = DepthRange { near_m: 0.5, far_m: 60.0 };
        let at = |sample_index: u32, point: Vec3| {
            let request = FrameRequest { sample_index, ..request.clone() };
            let seen = SampleView::of(&request, aspect, &Aabb::EMPTY);
            let clip_from_view = seen.camera.clip_from_view(range, aspect, seen.shift_ndc);
            let point_world = world_from_view.transform_point3(point);
            (clip_from_view * seen.camera.world_from_view.inverse()).project_point3(point_world).truncate()
        };
        // 24 mm by 2 · tan(0.35) · 0.5.
        let diameter_m = 0.024 / (2.0 * 0.35f32.tan()) / 0.5;
        let mut widest = 0.0f32;
        for sample_index in 0..16 {
            for point in [Vec3::new(0.4, -0.3, -4.0), Vec3::new(-1.2, 0.9, -4.0)] {
                assert!(at(sample_index, point).distance(at(0, point)) < 2e-6, "{sample_index}");
            }
            let far = Vec3::new(0.2, 0.1, -10.0);
            widest = widest.max(at(sample_index, far).distance(at(0, far)) / (0.35f32.tan().recip() / 10.0));
        }
        // The radius of the circle in the plane of the point: the lens's by (10 − 4) / 4.
        let radius_m = 0.5 * diameter_m * 6.0 / 4.0;
        assert!(widest < 1.35 * radius_m && widest > 0.8 * radius_m, "{widest} {radius_m}");
    }
}
