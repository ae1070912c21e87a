//! Triangles that cover a polygon.

mod corners;

use corners::{Corners, turn};
use glam::{DVec2, DVec3, Vec3};
use std::collections::VecDeque;

/// What is said of a polygon whose triangles are a guess.
pub(super) const GUESSED: &str = "a polygon crosses itself; it is covered as well as can be";

/// Simple polygons take one pass, those with corners on their edges a few; each of one that crosses itself may cut off
/// little.
const MOST_PASSES: usize = 16;

/// The triangles of a polygon.
#[derive(Debug, Default)]
pub(super) struct Triangulation {
    /// Three places in its points each, wound as the polygon is.
    pub(super) triangles: Vec<[usize; 3]>,
    /// Whether it crosses itself, so that they may cover other places than it does.
    pub(super) is_guessed: bool,
}

/// Cuts a polygon into triangles.
pub(super) fn triangles(points: &[Vec3]) -> Triangulation {
    let fan = |count: usize| (2..count).map(|i| [0, i - 1, i]).collect();
    let triangles = match points {
        [] | [_] | [_, _] => Vec::new(),
        [_, _, _] => fan(3),
        &[a, b, c, d] => {
            let face = |a: Vec3, b: Vec3, c: Vec3| (b - a).as_dvec3().cross((c - a).as_dvec3());
            // The other diagonal lies inside where this one does not.
            if face(a, b, c).dot(face(a, c, d)) >= 0.0 { fan(4) } else { vec![[0, 1, 3], [1, 2, 3]] }
        }
        _ => return Ears::new(&flattened(points)).cut(),
    };
    Triangulation { triangles, is_guessed: false }
}

/// The corners in the polygon's plane, counter-clockwise (Newell's normal: the sum over its edges).
fn flattened(points: &[Vec3]) -> Vec<DVec2> {
    // Far from the origin products of positions would lose the shape.
    let origin = points.first().copied().unwrap_or_default().as_dvec3();
    let at = |point: &Vec3| point.as_dvec3() - origin;
    let next = points.iter().cycle().skip(1);
    let normal: DVec3 = points.iter().zip(next).map(|(a, b)| at(a).cross(at(b))).sum();
    let (x, y) = normal.normalize_or(DVec3::Z).any_orthonormal_pair();
    // The pair and the normal are right-handed.
    points.iter().map(|point| DVec2::new(at(point).dot(x), at(point).dot(y))).collect()
}

/// Cuts off corners that hold no other corner, one after the other (Meisters 1975). What is cut off is within the
/// polygon, so that a corner becomes an ear only where its neighbour was cut off; and only corners that are not convex
/// can lie in an ear (O'Rourke, Computational Geometry in C, 1998). Those are found by a tree.
struct Ears<'a> {
    points: &'a [DVec2],
    next: Vec<usize>,
    last: Vec<usize>,
    is_cut: Vec<bool>,
    concave: Corners<'a>,
    left: usize,
}

impl<'a> Ears<'a> {
    fn new(points: &'a [DVec2]) -> Self {
        let count = points.len();
        let next: Vec<usize> = (1..count).chain([0]).collect();
        let last: Vec<usize> = [count - 1].into_iter().chain(0..count - 1).collect();
        let at = |i: usize| points.get(i).copied().unwrap_or_default();
        let around = |i: usize| [at((i + count - 1) % count), at(i), at((i + 1) % count)];
        let is_concave = |&i: &usize| {
            let [a, b, c] = around(i);
            turn(a, b, c) <= 0.0
        };
        let concave = Corners::new(points, (0..count).filter(is_concave).collect());
        Self { points, next, last, is_cut: vec![false; count], concave, left: count }
    }

    fn at(&self, corner: usize) -> DVec2 {
        self.points.get(corner).copied().unwrap_or_default()
    }

    /// A corner between its neighbours.
    fn around(&self, corner: usize) -> [usize; 3] {
        let of = |list: &[usize]| list.get(corner).copied().unwrap_or_default();
        [of(&self.last), corner, of(&self.next)]
    }

    fn turn_at(&self, corner: usize) -> f64 {
        let [a, b, c] = self.around(corner).map(|corner| self.at(corner));
        turn(a, b, c)
    }

    fn is_ear(&self, corner: usize) -> bool {
        let triangle = self.around(corner).map(|corner| self.at(corner));
        self.turn_at(corner) > 0.0 && !self.concave.any_inside(triangle)
    }

    /// Takes a corner out.
    fn cut_off(&mut self, corner: usize) -> [usize; 3] {
        let [a, b, c] = self.around(corner);
        for (list, place, value) in [(&mut self.next, a, c), (&mut self.last, c, a)] {
            if let Some(slot) = list.get_mut(place) {
                *slot = value;
            }
        }
        if let Some(slot) = self.is_cut.get_mut(b) {
            *slot = true;
        }
        self.left -= 1;
        for neighbour in [a, c] {
            if self.turn_at(neighbour) > 0.0 {
                self.concave.remove(neighbour);
            }
        }
        [a, b, c]
    }

    fn cut(mut self) -> Triangulation {
        let mut triangles = Vec::with_capacity(self.points.len());
        for _ in 0..MOST_PASSES {
            let before = self.left;
            let all = 0..self.points.len();
            let mut pending: VecDeque<usize> = all.filter(|i| self.is_cut.get(*i) == Some(&false)).collect();
            while self.left > 3
                && let Some(corner) = pending.pop_front()
            {
                if self.is_cut.get(corner) == Some(&false) && self.is_ear(corner) {
                    let [a, b, c] = self.cut_off(corner);
                    triangles.push([a, b, c]);
                    pending.extend([a, c]);
                }
            }
            if self.left == 3 || self.left == before {
                break;
            }
        }
        // One that crosses itself, or has no area, may have no ear; it is covered as well as can be.
        let Some(first) = self.is_cut.iter().position(|is_cut| !is_cut) else { return Triangulation::default() };
        let rest: Vec<usize> =
            std::iter::successors(Some(first), |corner| self.next.get(*corner).copied()).take(self.left).collect();
        let is_guessed = rest.len() > 3 && rest.iter().any(|corner| self.turn_at(*corner) != 0.0);
        triangles.extend(rest.windows(2).skip(1).filter_map(|pair| match *pair {
            [a, b] => Some([first, a, b]),
            _ => None,
        }));
        Triangulation { triangles, is_guessed }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The area of the triangles and the area that they would have if none were turned.
    fn areas(points: &[Vec3]) -> (f32, f32) {
        let areas = triangles(points).triangles.into_iter().map(|[a, b, c]| {
            let [a, b, c] = [a, b, c].map(|i| points[i]);
            0.5 * (b - a).cross(c - a).z
        });
        areas.fold((0.0, 0.0), |(sum, most), area| (sum + area, most + area.abs()))
    }

    #[test]
    fn polygons_that_are_not_convex_are_covered_once() {
        let star: Vec<Vec3> = (0..14)
            .map(|i| {
                let radius = if i % 2 == 0 { 2.0 } else { 0.5 };
                let (sin, cos) = (i as f32 * std::f32::consts::TAU / 14.0).sin_cos();
                Vec3::new(radius * cos, radius * sin, 1.0)
            })
            .collect();
        let arrow = [[0.0, 0.0], [4.0, 1.0], [0.0, 2.0], [1.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 0.0));
        for i in 0..4 {
            let mut turned = arrow;
            turned.rotate_left(i);
            assert_eq!(areas(&turned), (3.0, 3.0), "{i}");
        }
        let (sum, most) = areas(&star);
        // Fourteen triangles from the centre: half the product of the radii and the sine of the angle between them.
        let expected = 14.0 * 0.5 * 2.0 * 0.5 * (std::f32::consts::TAU / 14.0).sin();
        assert!((sum - expected).abs() < 1e-5 && (most - expected).abs() < 1e-5, "{sum} {most} {expected}");
        assert_eq!(triangles(&star).triangles.len(), 12);
        assert!(triangles(&[]).triangles.is_empty());
        let nothing = triangles(&[Vec3::ZERO; 9]);
        assert_eq!((nothing.triangles.len(), nothing.is_guessed), (7, false));
        let crossed = [[0.0, 0.0], [2.0, 0.0], [0.0, 2.0], [2.0, 2.0], [1.0, 3.0], [1.0, -1.0]];
        let crossed = triangles(&crossed.map(|[x, y]| Vec3::new(x, y, 0.0)));
        assert_eq!((crossed.triangles.len(), crossed.is_guessed), (4, true));
    }

    /// A comb with so many corners, each second one between two teeth, turned by an angle.
    fn comb(count: u16, angle_rad: f32) -> Vec<Vec3> {
        let corner = |i: u16| Vec3::new(f32::from(i) / f32::from(count), f32::from(i % 2) * 0.5, 0.0);
        let corners = (0..=count).map(corner).chain([Vec3::new(1.0, 1.0, 0.0), Vec3::new(0.0, 1.0, 0.0)]);
        corners.map(|corner| glam::Quat::from_rotation_z(angle_rad) * corner).collect()
    }

    #[test]
    fn polygons_of_many_corners_are_covered_once_and_soon() {
        for angle_rad in [0.0, 0.5, 1.57] {
            for count in [300, 20_000] {
                let points = comb(count, angle_rad);
                assert!(!triangles(&points).is_guessed, "{angle_rad} {count}");
                let (sum, most) = areas(&points);
                assert!((sum - 0.75).abs() < 1e-3 && (most - 0.75).abs() < 1e-3, "{angle_rad} {count}: {sum} {most}");
            }
        }
        // A square within a square, joined by an edge that is passed twice.
        let ring = [[0., 0.], [4., 0.], [4., 4.], [0., 4.], [0., 0.], [1., 1.], [1., 3.], [3., 3.], [3., 1.], [1., 1.]];
        assert_eq!(areas(&ring.map(|[x, y]| Vec3::new(x, y, 0.0))), (12.0, 12.0));
    }
}
