//! The rectangle of a view's picture that its opaque surfaces lie in: passes over surfaces draw nothing beside it.

use super::world::{Item, WorldDraws};
use crate::constants::{POINT_DIAMETER_MIN_PX, POINT_HEIGHT_SHARE};
use crate::lights::Rectangle;
use crate::view::ViewUniform;
use glam::{DMat4, DVec2, DVec4, Vec3};
use manypass_scene::{Aabb, Topology};

/// Lines are a pixel wide, and rounding moves edges by less than another one.
const MARGIN_PX: f64 = 2.0;

/// How far rounding may move a vertex, as a share of the largest coordinate that its position is the sum of.
const ROUNDING_SHARE: f32 = 1e-6;

/// The same of what skins and morph targets move: weights of joints add up to 1 within their rounding only.
const DEFORMED_SHARE: f32 = 1e-3;

/// Nearer to the plane of the eye than that, in metres, places in the picture are not known.
const NEAREST_M: f64 = 1e-6;

/// Of so many items each is projected; of more the box around all of them is.
const ITEMS_MAX: usize = 2048;

impl WorldDraws {
    /// The rectangle, in pixels, around the surfaces that do not blend, or with `all` around those that do, too. None
    /// where it may be the whole picture.
    pub fn surfaces_px(&self, view: &ViewUniform, all: bool) -> Option<Rectangle> {
        let projector = Projector::new(view);
        let count = if all { self.items.len() } else { self.opaque_count };
        let rectangle = if count > ITEMS_MAX {
            projector.project(&widened(&self.bounds_world, DEFORMED_SHARE, Vec3::ZERO), projector.point_reach_px)?
        } else {
            let items = self.items.iter().take(count);
            items.map(|item| self.project(&projector, item)).try_fold(PixelBox::EMPTY, |union, next| {
                let union = union.union(next?);
                (!projector.is_whole(&union)).then_some(union)
            })?
        };
        projector.rectangle(&rectangle)
    }

    fn project(&self, projector: &Projector, item: &Item) -> Option<PixelBox> {
        let share = if item.extent.is_none() { DEFORMED_SHARE } else { ROUNDING_SHARE };
        // Where an object lies far from its own origin, its matrix brings it back.
        let place = self.instances.get(item.instance as usize)?.world_from_object.map(|row| row[3]);
        let reach_px = if item.topology == Topology::Points { projector.point_reach_px } else { MARGIN_PX };
        projector.project(&widened(&item.bounds_world, share, place.into()), reach_px)
    }
}

/// A box with room for rounding of what is as large as its coordinates and `place`.
fn widened(bounds: &Aabb, share: f32, place: Vec3) -> Aabb {
    let largest = bounds.min.abs().max(bounds.max.abs()).max(place.abs()).max_element();
    let room = Vec3::splat(share * largest);
    Aabb { min: bounds.min - room, max: bounds.max + room }
}

/// A part of the plane of the picture, from its top left corner.
#[derive(Clone, Copy, Debug)]
struct PixelBox {
    low: DVec2,
    high: DVec2,
}

impl PixelBox {
    const EMPTY: Self = Self { low: DVec2::INFINITY, high: DVec2::NEG_INFINITY };

    fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }
}

/// How a view sees boxes of the world.
struct Projector {
    clip_from_world: DMat4,
    size_px: DVec2,
    /// How far the disc of a point reaches from its middle.
    point_reach_px: f64,
}

impl Projector {
    fn new(view: &ViewUniform) -> Self {
        // Discs have one size in the picture at all distances (`surface_vertex.wgsl`).
        let diameter_px = (view.size_px.y * POINT_HEIGHT_SHARE).max(POINT_DIAMETER_MIN_PX);
        Self {
            clip_from_world: view.clip_from_world.as_dmat4(),
            size_px: view.size_px.as_dvec2(),
            point_reach_px: 0.5 * f64::from(diameter_px) + MARGIN_PX,
        }
    }

    /// What a box covers of the plane of the picture, with a border of `reach_px`; none where a part of the box is not
    /// before the eye, and where its size is not known.
    fn project(&self, bounds: &Aabb, reach_px: f64) -> Option<PixelBox> {
        if bounds.is_empty() {
            return None;
        }
        let clip = bounds.corners().map(|corner| self.clip_from_world * corner.as_dvec3().extend(1.0));
        if !clip.iter().all(|corner| corner.is_finite()) {
            return None;
        }
        if clip.iter().all(|corner| corner.w <= 0.0) {
            return Some(PixelBox::EMPTY);
        }
        if clip.iter().any(|corner| corner.w <= NEAREST_M) {
            return None;
        }
        let place = |corner: DVec4| (DVec2::new(corner.x, -corner.y) / corner.w * 0.5 + 0.5) * self.size_px;
        let pixels = clip.map(place);
        let low = pixels.into_iter().fold(DVec2::INFINITY, DVec2::min) - reach_px;
        let high = pixels.into_iter().fold(DVec2::NEG_INFINITY, DVec2::max) + reach_px;
        (low.is_finite() && high.is_finite()).then_some(PixelBox { low, high })
    }

    fn is_whole(&self, part: &PixelBox) -> bool {
        part.low.cmple(DVec2::ZERO).all() && part.high.cmpge(self.size_px).all()
    }

    /// The pixels that a part touches; none if these are all.
    fn rectangle(&self, part: &PixelBox) -> Option<Rectangle> {
        if self.is_whole(part) {
            return None;
        }
        let low = part.low.floor().clamp(DVec2::ZERO, self.size_px);
        let high = part.high.ceil().clamp(DVec2::ZERO, self.size_px);
        let size = (high - low).max(DVec2::ZERO);
        Some([low.x, low.y, size.x, size.y].map(|px| px as u32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::{DepthRange, View};
    use glam::{Mat4, Vec2};
    use manypass_scene::Projection;

    const PERSPECTIVE: Projection = Projection::Perspective { fov_y_rad: 1.0, near_m: 0.05, far_m: None };
    const PARALLEL: Projection = Projection::Orthographic { height_m: 4.0, near_m: 0.05, far_m: 100.0 };

    /// From the origin along -z, in a picture of 200 × 100 pixels.
    fn uniform(projection: Projection) -> ViewUniform {
        let range = DepthRange { near_m: 0.05, far_m: 100.0 };
        View { world_from_view: Mat4::IDENTITY, projection }.uniform(range, 200, 100, Vec2::new(0.4, -0.3), 1.0, 0)
    }

    fn cube(center: Vec3, half_m: f32) -> Aabb {
        Aabb { min: center - half_m, max: center + half_m }
    }

    /// Of one box; none where that is not known or the whole picture.
    fn around(projection: Projection, bounds: &Aabb) -> Option<Rectangle> {
        let projector = Projector::new(&uniform(projection));
        projector.rectangle(&projector.project(bounds, MARGIN_PX)?)
    }

    #[test]
    fn a_box_before_the_eye_has_a_rectangle_with_a_margin() {
        for projection in [PERSPECTIVE, PARALLEL] {
            let bounds = cube(Vec3::new(0.5, 0.2, -6.0), 0.8);
            let [x, y, width, height] = around(projection, &bounds).expect("a part of the picture");
            let clip_from_world = uniform(projection).clip_from_world;
            let pixels = bounds.corners().map(|corner| {
                let ndc = clip_from_world.project_point3(corner);
                (Vec2::new(ndc.x, -ndc.y) * 0.5 + 0.5) * Vec2::new(200.0, 100.0)
            });
            let low = pixels.into_iter().fold(Vec2::INFINITY, Vec2::min);
            let high = pixels.into_iter().fold(Vec2::NEG_INFINITY, Vec2::max);
            let to_low = low - Vec2::new(x as f32, y as f32);
            let to_high = Vec2::new((x + width) as f32, (y + height) as f32) - high;
            for room_px in [to_low.x, to_low.y, to_high.x, to_high.y] {
                assert!((1.99..3.01).contains(&room_px), "{projection:?}: {room_px}");
            }
        }
    }

    #[test]
    fn what_is_small_has_its_margin_and_what_is_outside_nothing() {
        for projection in [PERSPECTIVE, PARALLEL] {
            let [_, _, width, height] = around(projection, &cube(Vec3::new(0.0, 0.0, -9.0), 1e-5)).expect("a part");
            assert!((4..=6).contains(&width) && (4..=6).contains(&height), "{width} × {height}");
            for outside in [Vec3::new(60.0, 0.0, -9.0), Vec3::new(-60.0, 0.0, -9.0), Vec3::new(0.0, 60.0, -9.0)] {
                let [_, _, width, height] = around(projection, &cube(outside, 0.5)).expect("a part");
                assert_eq!(width * height, 0, "{outside}");
            }
        }
    }

    #[test]
    fn what_reaches_behind_the_eye_may_be_anywhere_and_what_is_behind_it_is_nowhere() {
        assert_eq!(around(PERSPECTIVE, &cube(Vec3::ZERO, 1.0)), None);
        assert_eq!(around(PERSPECTIVE, &cube(Vec3::new(9.0, 0.0, 0.0), 1.0)), None);
        let behind = around(PERSPECTIVE, &cube(Vec3::new(0.0, 0.0, 5.0), 1.0)).expect("nothing");
        assert_eq!(behind[2] * behind[3], 0);
        // It covers the picture.
        assert_eq!(around(PERSPECTIVE, &cube(Vec3::new(0.0, 0.0, -3.0), 2.5)), None);
    }

    #[test]
    fn boxes_that_are_not_known_may_be_anywhere() {
        assert_eq!(around(PERSPECTIVE, &Aabb::EMPTY), None);
        let endless = Aabb { min: Vec3::splat(-2.0), max: Vec3::new(1.0, f32::INFINITY, -1.0) };
        assert_eq!(around(PERSPECTIVE, &endless), None);
        let broken = Aabb { min: Vec3::splat(-2.0), max: Vec3::new(1.0, f32::NAN, -1.0) };
        assert_eq!(around(PERSPECTIVE, &broken), None);
    }

    #[test]
    fn rounding_has_room() {
        let far = cube(Vec3::new(1e5, 0.0, -3.0), 1.0);
        let widened_far = widened(&far, ROUNDING_SHARE, Vec3::ZERO);
        assert!(far.min.z - widened_far.min.z > 0.09 && widened_far.max.y - far.max.y > 0.09);
        let brought_back = widened(&cube(Vec3::ZERO, 1.0), ROUNDING_SHARE, Vec3::new(0.0, -1e5, 0.0));
        assert!(brought_back.max.x > 1.09);
    }

    #[test]
    fn a_world_without_items_has_an_empty_rectangle() {
        let around_none = WorldDraws::default().surfaces_px(&uniform(PERSPECTIVE), false);
        assert!(around_none.is_some_and(|[_, _, width, height]| width * height == 0), "{around_none:?}");
    }
}
