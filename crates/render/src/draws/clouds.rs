//! Which parts of clouds of points a view draws.

use super::list::DrawList;
use super::unsettled::UnsettledTiles;
use super::world::WorldDraws;
use crate::constants::{POINT_CORNERS, POINT_DIAMETER_MIN_PX, POINT_HEIGHT_SHARE};
use crate::resources::Cloud;
use crate::view::ViewUniform;
use glam::{DMat4, DVec2, DVec4, Mat4, Vec2, Vec3, Vec4};
use manypass_scene::{Aabb, Topology};
use std::collections::HashMap;
use std::ops::Range;

/// How far the rounding of positions may move a disc, with room to spare.
const ROUNDING_PX: f32 = 0.5;

/// How far rounding in shaders may move a point, as a share of its largest coordinate.
const ROUNDING_SHARE: f64 = 5e-7;

/// Clouds are drawn in so many stretches at most, near ones first, so that what they hide is not shaded: each is a draw
/// call or more.
const STRETCHES_MAX: usize = 64;

/// Of a cloud that is there more often, no part is left out: so many chunks take about as many microseconds.
const TESTED_MAX: usize = 1 << 16;

/// What a view draws of clouds.
#[derive(Debug, Default)]
pub(crate) struct VisibleClouds {
    /// Vertices, by instance.
    by_instance: HashMap<u32, Vec<Range<u32>>>,
    /// Points of all draws, be they in clouds or not.
    pub points: u64,
}

impl VisibleClouds {
    /// Of the `draws` of a view with this uniform, what may be in the picture and, where that is known, on tiles that
    /// are not settled.
    pub fn new(
        world: &WorldDraws,
        draws: &DrawList,
        uniform: &ViewUniform,
        unsettled: Option<&UnsettledTiles>,
    ) -> Self {
        let mut seen = Self::default();
        for draw in draws.opaque.iter().chain(&draws.transmissive).chain(&draws.blended) {
            let Some(item) = world.items.get(draw.item as usize) else { continue };
            if item.topology != Topology::Points {
                continue;
            }
            let is_tested = |cloud: &&Cloud| cloud.chunks().len() * draw.instances.len() <= TESTED_MAX;
            let Some(cloud) = item.cloud.as_deref().filter(is_tested) else {
                let vertices = item.elements.len() as u64 * draw.instances.len() as u64;
                seen.points += vertices / u64::from(POINT_CORNERS);
                continue;
            };
            let is_opaque = (draw.item as usize) < world.opaque_count;
            for at in draw.instances.clone() {
                // Those that fade are drawn whole.
                let Some(instance) = world.instances.get(at as usize) else {
                    seen.points += item.elements.len() as u64 / u64::from(POINT_CORNERS);
                    continue;
                };
                let [x, y, z] = instance.world_from_object.map(Vec4::from_array);
                let world_from_object = Mat4::from_cols(x, y, z, Vec4::W).transpose();
                let runs = CloudCuller::new(uniform, &world_from_object, unsettled).runs(cloud, is_opaque);
                let vertices: u64 = runs.iter().map(|run| run.len() as u64).sum();
                seen.points += vertices / u64::from(POINT_CORNERS);
                seen.by_instance.insert(at, runs);
            }
        }
        seen
    }

    /// The vertices that are drawn of an instance of a cloud; none of what is no cloud, and drawn whole.
    pub fn of(&self, instance: u32) -> Option<&[Range<u32>]> {
        self.by_instance.get(&instance).map(Vec::as_slice)
    }
}

/// How a view sees the space of an object.
struct CloudCuller<'u> {
    clip_from_object: DMat4,
    /// Gives the distance along the view axis.
    distance_row: DVec4,
    /// The planes beside the picture with room for discs: a point lies between them where its products with all are at
    /// least 0.
    sides: [DVec4; 4],
    size_px: Vec2,
    /// How far a disc reaches from its middle.
    reach_px: f32,
    unsettled: Option<&'u UnsettledTiles>,
}

impl<'u> CloudCuller<'u> {
    fn new(uniform: &ViewUniform, world_from_object: &Mat4, unsettled: Option<&'u UnsettledTiles>) -> Self {
        // In doubles, because positions of the cloud and its place in the world may be far from the origin, each.
        let world_from_object = world_from_object.as_dmat4();
        let clip_from_object = uniform.clip_from_world.as_dmat4() * world_from_object;
        let view_from_object = uniform.view_from_world.as_dmat4() * world_from_object;
        // Discs have one size in the picture at all distances (`surface_vertex.wgsl`).
        let diameter_px = (uniform.size_px.y * POINT_HEIGHT_SHARE).max(POINT_DIAMETER_MIN_PX);
        let reach_px = 0.5 * diameter_px + ROUNDING_PX;
        let [x, y, w] = [0, 1, 3].map(|row| clip_from_object.row(row));
        let room = (1.0 + 2.0 * reach_px * uniform.inverse_size_px).as_dvec2();
        let sides = [room.x * w + x, room.x * w - x, room.y * w + y, room.y * w - y];
        let distance_row = -view_from_object.row(2);
        Self { clip_from_object, distance_row, sides, size_px: uniform.size_px, reach_px, unsettled }
    }

    /// The vertices of a cloud that may be seen, near stretches first if `sorts`.
    fn runs(&self, cloud: &Cloud, sorts: bool) -> Vec<Range<u32>> {
        let chunks = cloud.chunks();
        let of_stretch = chunks.len().div_ceil(STRETCHES_MAX).max(1);
        let stretch = |(at, chunks): (usize, &[Aabb])| (self.nearest_m(chunks), at * of_stretch);
        let mut stretches: Vec<(f64, usize)> = chunks.chunks(of_stretch).enumerate().map(stretch).collect();
        if sorts {
            stretches.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        let mut runs = Vec::new();
        for (_, first) in stretches {
            for (chunk, bounds) in chunks.iter().enumerate().skip(first).take(of_stretch) {
                self.add_chunk(cloud, (chunk, bounds), &mut runs);
            }
        }
        runs
    }

    fn add_chunk(&self, cloud: &Cloud, (chunk, bounds): (usize, &Aabb), runs: &mut Vec<Range<u32>>) {
        if !self.may_see(bounds) {
            return;
        }
        if self.unsettled.is_none() {
            add(runs, cloud.points_of_chunk(chunk));
            return;
        }
        for (block, bounds) in cloud.blocks_of(chunk) {
            if self.may_see(bounds) {
                add(runs, cloud.points_of_block(block));
            }
        }
    }

    /// Whether discs of points in a box may be in the picture, on tiles that are not settled.
    fn may_see(&self, bounds: &Aabb) -> bool {
        if bounds.is_empty() {
            return false;
        }
        let is_beside = |side: &DVec4| {
            let [distance, reach] = across(bounds, side);
            distance + reach < 0.0
        };
        if self.sides.iter().any(is_beside) {
            return false;
        }
        let Some(unsettled) = self.unsettled else { return true };
        self.rectangle_px(bounds).is_none_or(|[low, high]| unsettled.touches(low, high))
    }

    /// The corners of a rectangle around discs of points in a box; none where a part of the box is not before the eye.
    fn rectangle_px(&self, bounds: &Aabb) -> Option<[Vec2; 2]> {
        let room = Vec3::splat(rounding_m(bounds) as f32);
        let bounds = Aabb { min: bounds.min - room, max: bounds.max + room };
        let clip = bounds.corners().map(|corner| self.clip_from_object * corner.as_dvec3().extend(1.0));
        if clip.iter().any(|corner| corner.w.is_nan() || corner.w <= 1e-6) {
            return None;
        }
        let place = |corner: DVec4| (DVec2::new(corner.x, -corner.y) / corner.w * 0.5 + 0.5).as_vec2() * self.size_px;
        let pixels = clip.map(place);
        let low = pixels.into_iter().fold(Vec2::INFINITY, Vec2::min) - self.reach_px;
        let high = pixels.into_iter().fold(Vec2::NEG_INFINITY, Vec2::max) + self.reach_px;
        (low.is_finite() && high.is_finite()).then_some([low, high])
    }

    /// The least distance of what lies in boxes.
    fn nearest_m(&self, boxes: &[Aabb]) -> f64 {
        let bounds = boxes.iter().fold(Aabb::EMPTY, |all, bounds| all.union(bounds));
        let [distance, reach] = across(&bounds, &self.distance_row);
        distance - reach
    }
}

/// How far rounding in shaders may move the points of a box.
fn rounding_m(bounds: &Aabb) -> f64 {
    ROUNDING_SHARE * f64::from(bounds.min.abs().max(bounds.max.abs()).max_element())
}

/// The product of the middle of a box with a row, and by how much that of its corners differs at most.
fn across(bounds: &Aabb, row: &DVec4) -> [f64; 2] {
    let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    let (center, half) = (0.5 * (min + max), 0.5 * (max - min) + rounding_m(bounds));
    let normal = row.truncate();
    [normal.dot(center) + row.w, normal.abs().dot(half)]
}

/// Adds the vertices of `points`, to the last run if they follow it.
fn add(runs: &mut Vec<Range<u32>>, points: Range<usize>) {
    let [start, end] = [points.start, points.end].map(|point| point as u32 * POINT_CORNERS);
    match runs.last_mut().filter(|last| last.end == start) {
        Some(last) => last.end = end,
        None => runs.push(start..end),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::{DepthRange, View};
    use glam::Quat;
    use manypass_scene::{Primitive, Projection};

    const SIZE: (u32, u32) = (320, 200);

    /// Points in many small balls, one after the other.
    fn balls() -> Primitive {
        let noise = |i: u32| (i.wrapping_mul(0x9e37_79b9) ^ i.wrapping_mul(0x85eb_ca6b) >> 13) as f32 / u32::MAX as f32;
        let point = |i: u32| {
            let offset = Vec3::new(noise(7 * i + 1), noise(11 * i + 2), noise(13 * i + 3)) - 0.5;
            let middle = Vec3::new((i / 400 % 7) as f32 - 3.0, (i / 2800 % 5) as f32 - 2.0, (i / 14_000) as f32 - 1.0);
            (middle + 0.2 * offset).to_array()
        };
        Primitive { topology: Topology::Points, positions: (0..40_000).map(point).collect(), ..Primitive::default() }
    }

    fn view(projection: Projection, from: Vec3) -> ViewUniform {
        let world_from_view = Mat4::from_rotation_translation(Quat::from_rotation_y(0.2), from);
        let range = DepthRange { near_m: 0.05, far_m: 20.0 };
        View { world_from_view, projection }.uniform(range, SIZE.0, SIZE.1, Vec2::new(0.3, -0.2), 1.0, 0)
    }

    #[test]
    fn all_that_shows_is_drawn_and_little_else() {
        let primitive = balls();
        let cloud = Cloud::of(&primitive).expect("many points");
        let world_from_object = Mat4::from_rotation_z(0.4) * Mat4::from_scale(Vec3::new(-0.5, 0.6, 0.7));
        let perspective = Projection::Perspective { fov_y_rad: 0.9, near_m: 0.05, far_m: None };
        let orthographic = Projection::Orthographic { height_m: 1.5, near_m: 0.05, far_m: 20.0 };
        // One of them from among the points.
        let views = [(perspective, 4.0), (perspective, 0.1), (orthographic, 4.0)];
        let (across, down) = (SIZE.0 / 4, SIZE.1 / 4);
        for (projection, distance_m) in views {
            let uniform = view(projection, Vec3::new(0.3, 0.1, distance_m));
            for unsettled_of in [None, Some(3), Some(40)] {
                let tile = |at: u32| {
                    let far = unsettled_of.is_some_and(|far| {
                        !(at % across / far).is_multiple_of(3) || !(at / across / far).is_multiple_of(3)
                    });
                    u8::from(far) * 191
                };
                let settled: Vec<u8> = (0..across * down).map(tile).collect();
                let tiles = unsettled_of.map(|_| UnsettledTiles::new(&settled, SIZE));
                let eye = CloudCuller::new(&uniform, &world_from_object, tiles.as_ref());
                let runs = eye.runs(&cloud, true);
                let mut times = vec![0; primitive.positions.len()];
                for run in &runs {
                    assert!(run.start % POINT_CORNERS == 0 && run.end % POINT_CORNERS == 0);
                    (run.start / POINT_CORNERS..run.end / POINT_CORNERS).for_each(|point| times[point as usize] += 1);
                }
                let clip_from_object = uniform.clip_from_world * world_from_object;
                let shows = |position: &[f32; 3]| {
                    let clip = clip_from_object * Vec3::from_array(*position).extend(1.0);
                    let middle = (Vec2::new(clip.x, -clip.y) / clip.w * 0.5 + 0.5) * uniform.size_px;
                    let disc = [-1.0, 0.0, 1.0].into_iter().flat_map(|y| [-1.0, 0.0, 1.0].map(|x| Vec2::new(x, y)));
                    clip.w > 0.0
                        && disc.map(|offset| middle + offset).any(|at| {
                            let is_inside = at.cmpge(Vec2::ZERO).all() && at.cmplt(uniform.size_px).all();
                            is_inside && tile(at.y as u32 / 4 * across + at.x as u32 / 4) == 0
                        })
                };
                let shown: Vec<bool> = primitive.positions.iter().map(shows).collect();
                let count = shown.iter().filter(|shows| **shows).count();
                let drawn: usize = times.iter().sum();
                println!("{distance_m} m, {unsettled_of:?}: {count} show, {drawn} drawn in {} runs", runs.len());
                assert!(count > 0 && times.iter().all(|times| *times <= 1));
                assert!(shown.iter().zip(&times).all(|(shows, times)| !shows || *times == 1));
                if unsettled_of.is_some() {
                    assert!(drawn < primitive.positions.len() / 2, "{drawn}");
                }
            }
        }
    }

    #[test]
    fn near_stretches_come_first() {
        let positions = (0..70_000u32).map(|i| [(i % 97) as f32 * 1e-3, 0.0, i as f32 * 1e-4]).collect();
        let primitive = Primitive { topology: Topology::Points, positions, ..Primitive::default() };
        let cloud = Cloud::of(&primitive).expect("many points");
        let projection = Projection::Orthographic { height_m: 40.0, near_m: 0.05, far_m: 20.0 };
        let uniform = view(projection, Vec3::new(0.0, 0.0, 9.0));
        let eye = CloudCuller::new(&uniform, &Mat4::IDENTITY, None);
        let firsts: Vec<u32> = eye.runs(&cloud, true).iter().map(|run| run.start).collect();
        assert!(firsts.len() > 20 && firsts.is_sorted_by(|a, b| a > b), "{firsts:?}");
        let whole = eye.runs(&cloud, false);
        assert!(matches!(&whole[..], [run] if *run == (0..70_000 * POINT_CORNERS)), "{whole:?}");
    }
}
