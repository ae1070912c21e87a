//! Lines as rectangles that meet at mitres.

use glam::{DVec2, DVec3};

/// By how much of its width a part of a line goes on beyond a corner at most: up to turns of 152°. What would be longer
/// ends there.
const MITRE_WIDTHS: f64 = 2.0;

/// Points of a line nearer to each other than this are one.
const NEAREST_PX: f64 = 1e-3;

/// A part of a line: a rectangle, whose first side goes along the line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LinePart {
    /// The corner where it begins.
    pub origin_px: DVec2,
    /// The unit direction of its first side.
    pub direction: DVec2,
    pub length_px: f64,
    /// Where along the line from one point to the next the rectangle begins and ends, 0 and 1 at the points.
    pub along: [f64; 2],
    /// It is drawn where the product with (x, y, 1) is at least 0 with the first, and below 0 with the second.
    pub planes: [DVec3; 2],
}

/// Where a line is not cut.
const BEGINS: DVec3 = DVec3::ZERO;
const ENDS: DVec3 = DVec3::new(0.0, 0.0, -1.0);

/// The parts of a line through `points_px` that lie near a picture of `size_px`, each with the index of the point where
/// it begins. Every pixel belongs to one of two parts that meet, so that what is clear is equally so at corners.
pub(super) fn parts(points_px: &[DVec2], width_px: f64, size_px: DVec2) -> Vec<(usize, usize, LinePart)> {
    let mut points: Vec<(usize, DVec2)> = Vec::with_capacity(points_px.len());
    for (index, point) in points_px.iter().enumerate() {
        if points.last().is_none_or(|(_, last)| last.distance(*point) > NEAREST_PX) {
            points.push((index, *point));
        }
    }
    let directions: Vec<DVec2> = points.windows(2).map(|pair| (pair[1].1 - pair[0].1).normalize()).collect();
    let joint = |index: usize| -> Option<(DVec3, f64)> {
        let (before, after) = (*directions.get(index.checked_sub(1)?)?, *directions.get(index)?);
        let sum = before + after;
        if sum.length() < 1e-6 {
            return None;
        }
        let normal = sum.normalize();
        let (_, point) = points[index];
        // The tangent of half the turn.
        let slope = before.perp_dot(normal).abs() / before.dot(normal).max(1e-9);
        let beyond_px = (0.5 * width_px * slope).min(MITRE_WIDTHS * width_px);
        Some((normal.extend(-normal.dot(point)), beyond_px))
    };
    let mut parts = Vec::new();
    for (index, direction) in directions.iter().enumerate() {
        let ((first, start), (last, end)) = (points[index], points[index + 1]);
        let [begin, finish] = [joint(index), joint(index + 1)];
        let length = start.distance(end);
        let beyond = |joint: &Option<(DVec3, f64)>| joint.map_or(0.0, |(_, beyond_px)| beyond_px);
        let Some([from, to]) = seen([start, end], [-beyond(&begin), length + beyond(&finish)], width_px, size_px)
        else {
            continue;
        };
        let aside = direction.perp() * (0.5 * width_px);
        let part = LinePart {
            origin_px: start + *direction * from - aside,
            direction: *direction,
            length_px: to - from,
            along: [from / length, to / length],
            planes: [begin.map_or(BEGINS, |(plane, _)| plane), finish.map_or(ENDS, |(plane, _)| plane)],
        };
        parts.push((first, last, part));
    }
    parts
}

/// What of a line is near the picture, of distances along it (Liang & Barsky 1984): places far outside have too few
/// digits as 32 bits.
fn seen([start, end]: [DVec2; 2], along: [f64; 2], width_px: f64, size_px: DVec2) -> Option<[f64; 2]> {
    let margin = DVec2::splat(width_px + 4.0);
    let direction = (end - start).normalize();
    let [mut from, mut to] = along;
    for axis in 0..2 {
        let (low, high) = (-margin[axis] - start[axis], size_px[axis] + margin[axis] - start[axis]);
        if direction[axis].abs() < 1e-12 {
            if low > 0.0 || high < 0.0 {
                return None;
            }
            continue;
        }
        let (a, b) = (low / direction[axis], high / direction[axis]);
        (from, to) = (from.max(a.min(b)), to.min(a.max(b)));
    }
    (to > from).then_some([from, to])
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: DVec2 = DVec2::new(100.0, 100.0);

    #[test]
    fn parts_meet_at_one_plane_and_reach_the_corner() {
        let points = [DVec2::new(10.0, 20.0), DVec2::new(50.0, 20.0), DVec2::new(50.0, 60.0)];
        let parts = parts(&points, 4.0, SIZE);
        let [(0, 1, across), (1, 2, down)] = parts[..] else { panic!("{parts:?}") };
        assert_eq!(across.planes[1], down.planes[0]);
        assert_eq!((across.planes[0], down.planes[1]), (BEGINS, ENDS));
        assert!((across.length_px - 42.0).abs() < 1e-9 && across.origin_px.abs_diff_eq(DVec2::new(10.0, 18.0), 1e-9));
        // The outer corner is at (52, 18): on the plane, and within both.
        let plane = across.planes[1];
        assert!(plane.dot(DVec3::new(52.0, 18.0, 1.0)).abs() < 1e-9);
        assert!(plane.dot(DVec3::new(50.0, 30.0, 1.0)) > 0.0 && plane.dot(DVec3::new(40.0, 20.0, 1.0)) < 0.0);
    }

    #[test]
    fn sharp_turns_end_and_points_that_coincide_are_one() {
        let tip = [DVec2::new(10.0, 10.0), DVec2::new(60.0, 10.0), DVec2::new(60.0, 10.0), DVec2::new(10.0, 11.0)];
        let found = parts(&tip, 2.0, SIZE);
        assert_eq!(found.len(), 2);
        assert!((found[0].2.length_px - 54.0).abs() < 1e-9, "{found:?}");
        let back = [DVec2::new(10.0, 10.0), DVec2::new(60.0, 10.0), DVec2::new(10.0, 10.0)];
        assert!(parts(&back, 2.0, SIZE).iter().all(|(_, _, part)| part.planes == [BEGINS, ENDS]));
        assert!(parts(&[DVec2::ONE, DVec2::ONE], 2.0, SIZE).is_empty());
    }

    #[test]
    fn only_what_is_near_the_picture_is_drawn() {
        let far = parts(&[DVec2::new(-1e9, 50.0), DVec2::new(1e9, 50.0)], 1.0, SIZE);
        let [(_, _, part)] = far[..] else { panic!("{far:?}") };
        assert!(part.length_px < 120.0 && (part.origin_px.y - 49.5).abs() < 1e-6, "{part:?}");
        assert!(parts(&[DVec2::new(-1e9, 200.0), DVec2::new(1e9, 200.0)], 1.0, SIZE).is_empty());
    }
}
