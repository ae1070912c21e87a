//! Triangles that cover a polygon.

use glam::{DVec2, DVec3, Vec3};

/// The most corners of a polygon that is cut by its ears, which takes the square of them.
const MOST_EARS: usize = 256;

/// The triangles of a polygon, each as three places in `points`, wound as the polygon is. One with more than 256
/// corners is taken as convex.
pub(super) fn triangles(points: &[Vec3]) -> Vec<[usize; 3]> {
    let fan = |count: usize| (2..count).map(|i| [0, i - 1, i]).collect();
    match points {
        [] | [_] | [_, _] => Vec::new(),
        [_, _, _] => fan(3),
        &[a, b, c, d] => {
            let face = |a: Vec3, b: Vec3, c: Vec3| (b - a).as_dvec3().cross((c - a).as_dvec3());
            // The other diagonal lies inside where this one does not.
            if face(a, b, c).dot(face(a, c, d)) >= 0.0 { fan(4) } else { vec![[0, 1, 3], [1, 2, 3]] }
        }
        _ if points.len() > MOST_EARS => fan(points.len()),
        _ => ears(&flattened(points)),
    }
}

/// The corners in the polygon's plane, counter-clockwise (Newell's normal: the sum over its edges).
fn flattened(points: &[Vec3]) -> Vec<DVec2> {
    let next = points.iter().cycle().skip(1);
    let normal: DVec3 = points.iter().zip(next).map(|(a, b)| a.as_dvec3().cross(b.as_dvec3())).sum();
    let (x, y) = normal.normalize_or(DVec3::Z).any_orthonormal_pair();
    // The pair and the normal are right-handed.
    points.iter().map(|point| DVec2::new(point.as_dvec3().dot(x), point.as_dvec3().dot(y))).collect()
}

/// Cuts off corners that hold no other corner, one after the other (Meisters 1975).
fn ears(points: &[DVec2]) -> Vec<[usize; 3]> {
    let at = |i: usize| points.get(i).copied().unwrap_or_default();
    let turn = |a: DVec2, b: DVec2, c: DVec2| (b - a).perp_dot(c - a);
    let mut left: Vec<usize> = (0..points.len()).collect();
    let mut triangles = Vec::new();
    while left.len() > 3 {
        let count = left.len();
        let corner = |i: usize| left.get(i % count).copied().unwrap_or_default();
        let is_ear = |&i: &usize| {
            let [a, b, c] = [corner(i), corner(i + 1), corner(i + 2)];
            let (p, q, r) = (at(a), at(b), at(c));
            let holds = |&other: &usize| {
                let s = at(other);
                ![a, b, c].contains(&other)
                    && ![p, q, r].contains(&s)
                    && turn(p, q, s) >= 0.0
                    && turn(q, r, s) >= 0.0
                    && turn(r, p, s) >= 0.0
            };
            turn(p, q, r) > 0.0 && !left.iter().any(holds)
        };
        let Some(ear) = (0..count).find(is_ear) else {
            // One that crosses itself, or has no area, may have no ear; it is covered as well as can be.
            triangles.extend((2..count).map(|i| [corner(0), corner(i - 1), corner(i)]));
            return triangles;
        };
        triangles.push([corner(ear), corner(ear + 1), corner(ear + 2)]);
        left.remove((ear + 1) % count);
    }
    if let &[a, b, c] = &left[..] {
        triangles.push([a, b, c]);
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The area of the triangles and the area that they would have if none were turned.
    fn areas(points: &[Vec3]) -> (f32, f32) {
        let areas = triangles(points).into_iter().map(|[a, b, c]| {
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
        assert_eq!(triangles(&star).len(), 12);
        assert!(triangles(&[]).is_empty());
        assert_eq!(triangles(&[Vec3::ZERO; 9]).len(), 7);
    }
}
