//! Fisheye pictures: which direction each of their points shows, and the views that they are put together from.
//!
//! The camera sees a circle of the picture, whose rim is half the field of view away from its axis. A point at the
//! distance r from the middle, the rim's being 1, shows what is at the angle θ from the axis (Kannala & Brandt 2006, "A
//! Generic Camera Model and Calibration Method for Conventional, Wide-Angle, and Fish-Eye Lenses", equations 2 to 4):
//! equidistant r ∝ θ, equisolid r ∝ sin(θ / 2), stereographic r ∝ tan(θ / 2).
//!
//! It is drawn as up to five views with perspective from one eye, sides of a cube around it, each no larger than what
//! the picture shows of it and a guard band, and put together by `passes/fisheye`. Up to 220° nothing of the sixth side
//! is seen: its nearest corner is 125.3° from the axis.

use crate::camera_settings::{CameraSettings, Fisheye, FisheyeFrame};
use glam::{DVec2, DVec3, Quat, Vec2};
use serde::Serialize;
use std::f32::consts::FRAC_PI_2;

/// Pixels are the means of so many rays by so many.
pub(crate) const RAYS_A_SIDE: u32 = 2;
/// The most pixels of its view that a ray is wide, so that one filtered texel is what it sees.
const RAY_PX_MAX: f64 = 1.5;
/// The most pixels of a view for a pixel of the picture where that has the fewest: more would show nowhere.
const DETAIL_PX: f64 = 1.0;
/// Of a quarter of the picture so many points by so many are looked at to find what it shows of each side.
const POINTS_A_SIDE: u32 = 64;
/// What views have beyond what is shown of them, in pixels and in parts of that, on every side: for filters, and for passes that
/// look at what lies beside a pixel.
const GUARD_PX: f64 = 4.0;
const GUARD_SHARE: f64 = 1.0 / 64.0;

/// A side of the cube around the eye.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Front,
    Right,
    Left,
    Up,
    Down,
}

impl Side {
    /// In the order of the textures and numbers of `fisheye.wgsl`.
    pub const ALL: [Self; 5] = [Self::Front, Self::Right, Self::Left, Self::Up, Self::Down];

    pub fn name(self) -> &'static str {
        match self {
            Self::Front => "front",
            Self::Right => "right",
            Self::Left => "left",
            Self::Up => "up",
            Self::Down => "down",
        }
    }

    /// The rotation of a camera that looks at it.
    pub fn rotation(self) -> Quat {
        match self {
            Self::Front => Quat::IDENTITY,
            Self::Right => Quat::from_rotation_y(-FRAC_PI_2),
            Self::Left => Quat::from_rotation_y(FRAC_PI_2),
            Self::Up => Quat::from_rotation_x(FRAC_PI_2),
            Self::Down => Quat::from_rotation_x(-FRAC_PI_2),
        }
    }

    /// Where a ray along `direction` of view space meets the side's plane at a distance of 1, x right and y up as its
    /// camera sees it; none behind that. `fisheye.wgsl` has the same.
    fn place(self, direction: DVec3) -> Option<DVec2> {
        let DVec3 { x, y, z } = direction;
        let (across, ahead) = match self {
            Self::Front => (DVec2::new(x, y), -z),
            Self::Right => (DVec2::new(z, y), x),
            Self::Left => (DVec2::new(-z, y), -x),
            Self::Up => (DVec2::new(x, z), y),
            Self::Down => (DVec2::new(x, -z), -y),
        };
        (ahead > 1e-9).then(|| across / ahead)
    }
}

/// How points of a picture and directions belong together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FisheyeLens {
    pub map: Fisheye,
    /// From the axis to the rim.
    pub half_angle_rad: f64,
    /// From the middle of the picture to the rim.
    pub radius_px: f64,
}

impl FisheyeLens {
    /// That of a picture of a size; none of one that has perspective, or parallel rays.
    pub fn new(settings: &CameraSettings, (width, height): (u32, u32)) -> Option<Self> {
        let (width, height) = (f64::from(width), f64::from(height));
        let diameter_px = match settings.fisheye_frame {
            FisheyeFrame::Circular => width.min(height),
            FisheyeFrame::Full => width.hypot(height),
        };
        (settings.fisheye != Fisheye::None).then(|| Self {
            map: settings.fisheye,
            half_angle_rad: 0.5 * f64::from(settings.fisheye_fov_deg).to_radians(),
            radius_px: 0.5 * diameter_px,
        })
    }

    /// The direction in view space at a place in pixels from the picture's middle, y up; none outside of the circle.
    fn direction(&self, place_px: DVec2) -> Option<DVec3> {
        let radius = place_px.length() / self.radius_px;
        if radius > 1.0 {
            return None;
        }
        let half = self.half_angle_rad;
        let angle_rad = match self.map {
            Fisheye::None | Fisheye::Equidistant => radius * half,
            Fisheye::Equisolid => 2.0 * (radius * (0.5 * half).sin()).asin(),
            Fisheye::Stereographic => 2.0 * (radius * (0.5 * half).tan()).atan(),
        };
        let across = place_px.normalize_or_zero() * angle_rad.sin();
        Some(across.extend(-angle_rad.cos()))
    }

    /// The place in pixels from the picture's middle, y up, of what lies in a direction of view space; none outside of
    /// the circle.
    pub fn place(&self, direction: DVec3) -> Option<DVec2> {
        let across = direction.truncate();
        let angle_rad = across.length().atan2(-direction.z);
        let half = self.half_angle_rad;
        let radius = match self.map {
            Fisheye::None | Fisheye::Equidistant => angle_rad / half,
            Fisheye::Equisolid => (0.5 * angle_rad).sin() / (0.5 * half).sin(),
            Fisheye::Stereographic => (0.5 * angle_rad).tan() / (0.5 * half).tan(),
        };
        let is_seen = angle_rad <= half && direction.length_squared() > 0.0;
        is_seen.then(|| across.normalize_or_zero() * (radius * self.radius_px))
    }

    /// How far places on a side are apart for points that are a pixel apart, at most: the larger singular value of the
    /// derivatives.
    fn spread(&self, side: Side, place_px: DVec2) -> Option<f64> {
        let step_px = 1e-4 * self.radius_px;
        // Towards the middle, where there always is something.
        let inward = |axis: DVec2| if place_px.dot(axis) > 0.0 { -step_px * axis } else { step_px * axis };
        let at = |place_px| side.place(self.direction(place_px)?);
        let middle = at(place_px)?;
        let [dx, dy] = [DVec2::X, DVec2::Y].map(|axis| Some((at(place_px + inward(axis))? - middle) / step_px));
        let (dx, dy) = (dx?, dy?);
        let (sum, difference) = (dx.length_squared() + dy.length_squared(), dx.length_squared() - dy.length_squared());
        Some((0.5 * (sum + difference.hypot(2.0 * dx.dot(dy)))).sqrt())
    }
}

/// A view of one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Face {
    pub side: Side,
    /// Its first column and row, and those after its last, in pixels from the middle of the side, y down.
    left_px: i32,
    top_px: i32,
    right_px: i32,
    bottom_px: i32,
    /// Pixels of half a side of 90°.
    scale_px: f64,
}

impl Face {
    pub fn size(&self) -> (u32, u32) {
        (self.right_px.abs_diff(self.left_px), self.bottom_px.abs_diff(self.top_px))
    }

    /// Half the width and height at a distance of 1, and where the middle is.
    fn extent(&self) -> (DVec2, DVec2) {
        let [left, top, right, bottom] =
            [self.left_px, self.top_px, self.right_px, self.bottom_px].map(|px| f64::from(px) / self.scale_px);
        (0.5 * DVec2::new(right - left, bottom - top), 0.5 * DVec2::new(right + left, -(bottom + top)))
    }

    /// By how much its frustum is sheared, as that of [`crate::lens::SampleView`].
    pub fn shift_ndc(&self) -> Vec2 {
        let (half, middle) = self.extent();
        (-middle / half).as_vec2()
    }

    /// How far it reaches beyond a frustum of its size around the axis, metres a metre.
    pub fn beyond(&self) -> f32 {
        self.extent().1.abs().max_element() as f32
    }

    /// The vertical field of view of its camera.
    pub fn fov_y_rad(&self) -> f32 {
        (2.0 * self.extent().0.y.atan()) as f32
    }

    /// From a place on the side to its texture, which a sample is offset in by `jitter_uv`: u and v are the place by the
    /// first two numbers and more by the others.
    pub fn uv_from_place(&self, jitter_uv: Vec2) -> [f32; 4] {
        let (width, height) = self.size();
        let size_px = DVec2::new(f64::from(width), f64::from(height));
        let scale = DVec2::new(self.scale_px, -self.scale_px) / size_px;
        let offset = jitter_uv.as_dvec2() - DVec2::new(f64::from(self.left_px), f64::from(self.top_px)) / size_px;
        [scale.x, scale.y, offset.x, offset.y].map(|value| value as f32)
    }
}

/// The views that a fisheye picture is put together from.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FisheyeFaces {
    pub lens: FisheyeLens,
    /// In the order of [`Side::ALL`].
    pub faces: Vec<Face>,
    /// How many pixels of its view a ray is wide, at most.
    pub ray_px: f64,
}

/// The rectangle of a side that is looked at, at a distance of 1.
#[derive(Clone, Copy)]
struct SideRectangle {
    low: DVec2,
    high: DVec2,
}

impl SideRectangle {
    /// The rectangle around two.
    fn and(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// The same with so much more on all sides, as far as the side goes.
    fn grown(self, margin: f64) -> Self {
        Self { low: (self.low - margin).max(DVec2::NEG_ONE), high: (self.high + margin).min(DVec2::ONE) }
    }

    /// Around it and what it is when x, or y, is mirrored.
    fn mirrored(self, axis: DVec2) -> Self {
        let other = DVec2::ONE - 2.0 * axis;
        self.and(Self { low: self.low * other, high: self.low * other })
            .and(Self { low: self.high * other, high: self.high * other })
    }

    /// Its longer side.
    fn extent(&self) -> f64 {
        (self.high - self.low).max_element()
    }

    /// That of a side, of what a quarter of the picture shows of that in front, on the right and above.
    fn of_side(side: Side, [front, right, up]: [Option<Self>; 3]) -> Option<Self> {
        let turned = |seen: Self| Self { low: -seen.high, high: -seen.low };
        Some(match side {
            Side::Front => front?.mirrored(DVec2::X).mirrored(DVec2::Y),
            Side::Right => right?.mirrored(DVec2::Y),
            Side::Left => turned(right?.mirrored(DVec2::Y)),
            Side::Up => up?.mirrored(DVec2::X),
            Side::Down => turned(up?.mirrored(DVec2::X)),
        })
    }
}

impl FisheyeFaces {
    /// Those of a picture of `size` of views that are no larger than `limit_px`; none if it is no fisheye picture.
    pub fn new(settings: &CameraSettings, size: (u32, u32), limit_px: u32) -> Option<Self> {
        let lens = FisheyeLens::new(settings, size)?;
        let half_px = 0.5 * DVec2::new(f64::from(size.0), f64::from(size.1));
        // One quarter is like the others.
        let steps = f64::from(POINTS_A_SIDE - 1);
        let points: Vec<DVec2> = (0..POINTS_A_SIDE * POINTS_A_SIDE)
            .map(|at| half_px * DVec2::new(f64::from(at % POINTS_A_SIDE), f64::from(at / POINTS_A_SIDE)) / steps)
            .collect();
        const OF_QUARTER: [Side; 3] = [Side::Front, Side::Right, Side::Up];
        let seen_by = |side: Side, place_px: DVec2, margin: f64| {
            let place = side.place(lens.direction(place_px)?)?;
            (place.abs().max_element() <= 1.0 + margin).then_some(place)
        };
        let spreads = OF_QUARTER.into_iter().flat_map(|side| {
            points.iter().filter_map(move |px| seen_by(side, *px, 1e-9).and_then(|_| lens.spread(side, *px)))
        });
        let (least, most) =
            spreads.fold((f64::INFINITY, 0.0f64), |(least, most), spread| (least.min(spread), most.max(spread)));
        // What lies between two points is no farther from one of them than this.
        let margin = most * half_px.max_element() / steps;
        let of_quarter = OF_QUARTER.map(|side| {
            let places = points.iter().filter_map(|px| seen_by(side, *px, margin));
            places
                .map(|place| SideRectangle { low: place, high: place })
                .reduce(SideRectangle::and)
                .map(|seen| seen.grown(margin))
        });
        let seen: Vec<(Side, SideRectangle)> =
            Side::ALL.into_iter().filter_map(|side| Some((side, SideRectangle::of_side(side, of_quarter)?))).collect();
        let rays = f64::from(RAYS_A_SIDE);
        let wanted_px = (RAY_PX_MAX * rays / most).min(DETAIL_PX / least);
        let largest = seen.iter().map(|(_, seen)| seen.extent()).fold(0.0, f64::max);
        let largest_px = (f64::from(limit_px) - 2.0 * GUARD_PX - 2.0) / (largest * (1.0 + 2.0 * GUARD_SHARE));
        let scale_px = wanted_px.min(largest_px);
        let faces = seen.into_iter().map(|(side, seen)| {
            let guard_px = GUARD_PX.max(GUARD_SHARE * seen.extent() * scale_px);
            let (low, high) = (seen.low * scale_px - guard_px, seen.high * scale_px + guard_px);
            Face {
                side,
                left_px: low.x.floor() as i32,
                top_px: (-high.y).floor() as i32,
                right_px: high.x.ceil() as i32,
                bottom_px: (-low.y).ceil() as i32,
                scale_px,
            }
        });
        Some(Self { lens, faces: faces.collect(), ray_px: most * scale_px / rays })
    }

    /// What reports say of them.
    pub fn info(&self) -> FisheyeInfo {
        let view = |face: &Face| {
            let (width, height) = face.size();
            FisheyeView { name: face.side.name(), width, height }
        };
        FisheyeInfo { views: self.faces.iter().map(view).collect(), ray_px: self.ray_px }
    }
}

/// The cube of views from which a fisheye picture is resampled, and its resolution.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FisheyeInfo {
    /// Each of them.
    pub views: Vec<FisheyeView>,
    /// How many pixels of its view each of the four rays of a pixel is wide, at most: 1.5, or less.
    pub ray_px: f64,
}

/// One view of the cube from which a fisheye picture is resampled.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FisheyeView {
    /// `front`, `right`, `left`, `up` or `down`.
    pub name: &'static str,
    /// Its width in pixels, before `render.scale`.
    pub width: u32,
    /// Its height in pixels, before `render.scale`.
    pub height: u32,
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use super::*;

    fn settings(fisheye: Fisheye, fisheye_fov_deg: f32, fisheye_frame: FisheyeFrame) -> CameraSettings {
        CameraSettings { fisheye, fisheye_fov_deg, fisheye_frame, ..CameraSettings::default() }
    }

    /// The side of the largest component, as `fisheye.wgsl` finds it.
    fn side_of(direction: DVec3) -> Side {
        let DVec3 { x, y, z } = direction.abs();
        match () {
            () if x >= y && x > z => {
                if direction.x > 0.0 {
                    Side::Right
                } else {
                    Side::Left
                }
            }
            () if y > x && y > z => {
                if direction.y > 0.0 {
                    Side::Up
                } else {
                    Side::Down
                }
            }
            () => Side::Front,
        }
    }

    #[test]
    fn every_ray_is_in_its_view_and_no_wider_than_said() {
        let maps = [Fisheye::Equidistant, Fisheye::Equisolid, Fisheye::Stereographic];
        for (map, frame) in maps.into_iter().flat_map(|map| [(map, FisheyeFrame::Circular), (map, FisheyeFrame::Full)])
        {
            for (fov_deg, size) in [
                (1.0, (40, 40)),
                (80.0, (64, 41)),
                (100.0, (61, 61)),
                (140.0, (97, 20)),
                (180.0, (1, 1)),
                (220.0, (96, 54)),
            ] {
                let faces = FisheyeFaces::new(&settings(map, fov_deg, frame), size, 8192).unwrap();
                let case = format!("{map:?} {frame:?} {fov_deg} {size:?}");
                let middle = 0.5 * DVec2::new(f64::from(size.0), f64::from(size.1));
                let rays = RAYS_A_SIDE as usize;
                let at = |x: usize, y: usize| {
                    let place = (DVec2::new(x as f64, y as f64) + 0.5) / f64::from(RAYS_A_SIDE) - middle;
                    let direction = faces.lens.direction(place)?;
                    let side = side_of(direction);
                    let face = faces.faces.iter().find(|face| face.side == side);
                    let face =
                        face.unwrap_or_else(|| panic!("{case}: {place} is in the view {side:?}, which is not drawn"));
                    let px = side.place(direction).unwrap() * DVec2::new(face.scale_px, -face.scale_px);
                    // A texel beyond it and the offset of a sample.
                    let is_within = |px: f64, low: i32, high: i32| px - 1.0 >= low.into() && px + 1.0 <= high.into();
                    let is_seen =
                        is_within(px.x, face.left_px, face.right_px) && is_within(px.y, face.top_px, face.bottom_px);
                    assert!(is_seen, "{case}: {place} is at {px} of {face:?}");
                    Some((side, px))
                };
                let mut widest = 0.0f64;
                for (x, y) in (0..size.1 as usize * rays).flat_map(|y| (0..size.0 as usize * rays).map(move |x| (x, y)))
                {
                    let Some((side, px)) = at(x, y) else { continue };
                    for other in [at(x + 1, y), at(x, y + 1)] {
                        let other = other.filter(|(other, _)| *other == side);
                        widest = other.map_or(widest, |(_, other)| widest.max(px.distance(other)));
                    }
                }
                // Rays of few pixels are longer than derivatives say.
                assert!(
                    faces.ray_px <= RAY_PX_MAX * 1.000_001 && widest < RAY_PX_MAX * 1.03,
                    "{case}: {} {widest}",
                    faces.ray_px
                );
                let is_limited = faces.ray_px > 1.49;
                assert!(!is_limited || size.0 < 40 || size.1 < 40 || widest > 1.2, "{case}: {widest}");
            }
        }
    }

    #[test]
    fn only_what_is_seen_is_drawn_and_nothing_larger_than_the_device_allows() {
        let drawn = |fov_deg, limit_px| {
            let settings = settings(Fisheye::Equidistant, fov_deg, FisheyeFrame::Circular);
            FisheyeFaces::new(&settings, (512, 512), limit_px).unwrap()
        };
        for (fov_deg, count) in [(1.0, 1), (80.0, 1), (120.0, 5), (220.0, 5)] {
            let faces = drawn(fov_deg, 8192);
            assert_eq!(faces.faces.len(), count, "{fov_deg}");
            let pixels: u32 = faces.faces.iter().map(|face| face.size().0 * face.size().1).sum();
            println!("{fov_deg}: {} views, {pixels} pixels, rays of {:.2} pixels", count, faces.ray_px);
            assert!(pixels < 2 * 512 * 512, "{fov_deg}: {pixels}");
        }
        // Half of the sides at 180°.
        let faces = drawn(180.0, 8192).faces;
        let [front, right] = [0, 1].map(|at: usize| faces[at].size());
        assert!(front.0 == front.1 && right.1 == front.1 && right.0 < front.0 * 6 / 10, "{front:?} {right:?}");
        let small = drawn(180.0, 64);
        assert!(
            small.faces.iter().all(|face| face.size().0 <= 64 && face.size().1 <= 64) && small.ray_px < 1.0,
            "{small:?}"
        );
        let settings = CameraSettings::default();
        assert_eq!(FisheyeFaces::new(&settings, (512, 512), 8192), None);
    }
}
