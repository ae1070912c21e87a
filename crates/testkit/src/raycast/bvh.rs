//! A hierarchy of boxes around triangles in `f64`.
//!
//! - Boxes are split where the surface area heuristic over 16 bins says so (Wald, "On fast Construction of SAH-based
//!   Bounding Volume Hierarchies", 2007), or at the median where that does not end.
//! - Triangles after Möller & Trumbore, "Fast, Minimum Storage Ray-Triangle Intersection", 1997, a billionth larger
//!   than they are, so that no ray slips through between two. One through an edge hits both.

use glam::DVec3;
use std::ops::ControlFlow;

/// How far a triangle reaches beyond its edges, in barycentric coordinates.
const EDGE_SLACK: f64 = 1e-9;
/// Leaves hold so many triangles at most, unless all of them have one centre.
const LEAF_TRIANGLES: usize = 4;
const BINS: usize = 16;
/// Deeper than this, halves are of equal number: so a path has at most 40 + 32 boxes.
const SAH_DEPTH_MAX: u32 = 40;
const STACK: usize = 80;

/// An upright box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub min: DVec3,
    pub max: DVec3,
}

impl Bounds {
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    pub fn of(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |bounds, point| bounds.union(&Self { min: point, max: point }))
    }

    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    pub fn contains(&self, point: DVec3) -> bool {
        self.min.cmple(point).all() && point.cmple(self.max).all()
    }

    /// Half of the surface; 0 of nothing.
    fn half_area(&self) -> f64 {
        let size = (self.max - self.min).max(DVec3::ZERO);
        size.x * size.y + size.y * size.z + size.z * size.x
    }

    /// Where a ray enters, if it does so between `start_m` and `end_m`. Ends are moved by a few roundings (Ize, "Robust
    /// BVH Ray Traversal", 2013).
    fn entry_m(&self, ray: &Ray, start_m: f64, end_m: f64) -> Option<f64> {
        let (mut near_m, mut far_m) = (start_m, end_m);
        for axis in 0..3 {
            let (low, high) = (self.min[axis] - ray.origin[axis], self.max[axis] - ray.origin[axis]);
            if ray.direction[axis] == 0.0 {
                // Parallel to two of the planes: between them, or on one, it is always inside.
                if low > 0.0 || high < 0.0 {
                    return None;
                }
                continue;
            }
            let (low, high) = (low * ray.inverse_direction[axis], high * ray.inverse_direction[axis]);
            near_m = near_m.max(low.min(high));
            far_m = far_m.min(low.max(high) * (1.0 + 4.0 * f64::EPSILON));
        }
        (near_m <= far_m).then_some(near_m)
    }
}

/// A ray with a unit direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    pub origin: DVec3,
    pub direction: DVec3,
    inverse_direction: DVec3,
}

impl Ray {
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        Self { origin, direction, inverse_direction: direction.recip() }
    }
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Crossing {
    /// Metres along the ray.
    pub distance_m: f64,
    /// Index of the triangle, as they were given.
    pub triangle: u32,
    /// Weights of its second and third corner.
    pub weights: [f64; 2],
    /// Whether the ray comes from the side from which its corners go round counter-clockwise.
    pub from_front: bool,
}

#[derive(Clone, Copy, Debug)]
struct Triangle {
    corner: DVec3,
    edges: [DVec3; 2],
    index: u32,
}

impl Triangle {
    fn crossing(&self, ray: &Ray) -> Option<Crossing> {
        let across = ray.direction.cross(self.edges[1]);
        let determinant = self.edges[0].dot(across);
        if determinant == 0.0 {
            return None;
        }
        let offset = ray.origin - self.corner;
        let u = offset.dot(across) / determinant;
        if !(-EDGE_SLACK..=1.0 + EDGE_SLACK).contains(&u) {
            return None;
        }
        let around = offset.cross(self.edges[0]);
        let v = ray.direction.dot(around) / determinant;
        if v < -EDGE_SLACK || u + v > 1.0 + EDGE_SLACK {
            return None;
        }
        let distance_m = self.edges[1].dot(around) / determinant;
        Some(Crossing { distance_m, triangle: self.index, weights: [u, v], from_front: determinant > 0.0 })
    }
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Bounds,
    /// The first triangle of a leaf, or the second child of others, whose first child follows them.
    first: u32,
    /// The number of triangles of a leaf, 0 of others.
    count: u32,
}

/// Triangles that rays can be asked about.
#[derive(Clone, Debug, Default)]
pub(super) struct Bvh {
    nodes: Vec<Node>,
    triangles: Vec<Triangle>,
}

/// A triangle while boxes are built.
struct Entry {
    bounds: Bounds,
    center: DVec3,
    index: u32,
}

impl Bvh {
    /// The hierarchy of triangles, given by their corners. What has no area or is not finite is never hit.
    pub fn new(corners: &[[DVec3; 3]]) -> Self {
        let mut entries: Vec<Entry> = Vec::with_capacity(corners.len());
        for (index, [a, b, c]) in corners.iter().enumerate() {
            let area = (*b - *a).cross(*c - *a).length_squared();
            if area > 0.0 && area.is_finite() {
                let bounds = Bounds::of([*a, *b, *c]);
                entries.push(Entry { bounds, center: 0.5 * (bounds.min + bounds.max), index: index as u32 });
            }
        }
        let mut bvh = Self::default();
        if !entries.is_empty() {
            bvh.build(&mut entries, 0, 0);
        }
        let triangle = |entry: &Entry| {
            let [a, b, c] = corners[entry.index as usize];
            Triangle { corner: a, edges: [b - a, c - a], index: entry.index }
        };
        bvh.triangles = entries.iter().map(triangle).collect();
        bvh
    }

    /// The box around everything.
    pub fn bounds(&self) -> Bounds {
        self.nodes.first().map_or(Bounds::EMPTY, |node| node.bounds)
    }

    /// Adds the boxes of `entries`, the first of which is the `first` triangle.
    fn build(&mut self, entries: &mut [Entry], first: u32, depth: u32) {
        let bounds = entries.iter().fold(Bounds::EMPTY, |bounds, entry| bounds.union(&entry.bounds));
        let node = self.nodes.len();
        self.nodes.push(Node { bounds, first, count: entries.len() as u32 });
        if entries.len() <= LEAF_TRIANGLES {
            return;
        }
        let Some(middle) = split(entries, depth < SAH_DEPTH_MAX) else { return };
        let (left, right) = entries.split_at_mut(middle);
        self.build(left, first, depth + 1);
        self.nodes[node].first = self.nodes.len() as u32;
        self.nodes[node].count = 0;
        self.build(right, first + middle as u32, depth + 1);
    }

    /// Calls `visit` with crossings beyond `start_m` and before `end_m`, in no order. It gives the distance beyond
    /// which crossings are of no interest any more, or breaks.
    pub fn crossings(
        &self,
        ray: &Ray,
        start_m: f64,
        end_m: f64,
        mut visit: impl FnMut(Crossing) -> ControlFlow<(), f64>,
    ) {
        let mut end_m = end_m;
        let mut stack = [(0_u32, 0.0); STACK];
        let mut height = 0;
        if let Some(entry_m) = self.nodes.first().and_then(|root| root.bounds.entry_m(ray, start_m, end_m)) {
            stack[0] = (0, entry_m);
            height = 1;
        }
        while height > 0 {
            height -= 1;
            let (at, entry_m) = stack[height];
            if entry_m > end_m {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.count > 0 {
                let first = node.first as usize;
                for triangle in &self.triangles[first..first + node.count as usize] {
                    let Some(crossing) = triangle.crossing(ray) else { continue };
                    if crossing.distance_m > start_m && crossing.distance_m < end_m {
                        match visit(crossing) {
                            ControlFlow::Break(()) => return,
                            ControlFlow::Continue(limit_m) => end_m = end_m.min(limit_m),
                        }
                    }
                }
                continue;
            }
            let children = [at + 1, node.first];
            let entries_m = children.map(|child| self.nodes[child as usize].bounds.entry_m(ray, start_m, end_m));
            // The nearer one is taken first: it lies on top of the stack.
            let far_first = entries_m[0].unwrap_or(f64::INFINITY) < entries_m[1].unwrap_or(f64::INFINITY);
            for which in if far_first { [1, 0] } else { [0, 1] } {
                if let Some(entry_m) = entries_m[which] {
                    stack[height] = (children[which], entry_m);
                    height += 1;
                }
            }
        }
    }
}

/// Orders `entries` into two groups and gives the number of the first; none if one box is best.
fn split(entries: &mut [Entry], by_area: bool) -> Option<usize> {
    let centers = Bounds::of(entries.iter().map(|entry| entry.center));
    let size = centers.max - centers.min;
    let axis = if size.x >= size.y.max(size.z) { 0 } else { 1 + usize::from(size.z > size.y) };
    if size[axis] <= 0.0 {
        return None;
    }
    if by_area && let Some((axis, bin)) = best_bin(entries, &centers) {
        entries.sort_by_key(|entry| bin_of(entry, &centers, axis) >= bin);
        return Some(entries.partition_point(|entry| bin_of(entry, &centers, axis) < bin));
    }
    let middle = entries.len() / 2;
    entries.select_nth_unstable_by(middle, |a, b| a.center[axis].total_cmp(&b.center[axis]));
    Some(middle)
}

fn bin_of(entry: &Entry, centers: &Bounds, axis: usize) -> usize {
    let place = (entry.center[axis] - centers.min[axis]) / (centers.max[axis] - centers.min[axis]);
    ((place * BINS as f64) as usize).min(BINS - 1)
}

/// The axis, and the first bin of the second group, with the least number of triangles times area.
fn best_bin(entries: &[Entry], centers: &Bounds) -> Option<(usize, usize)> {
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in (0..3).filter(|axis| centers.max[*axis] > centers.min[*axis]) {
        let mut bins = [(Bounds::EMPTY, 0_u32); BINS];
        for entry in entries {
            let (bounds, count) = &mut bins[bin_of(entry, centers, axis)];
            *bounds = bounds.union(&entry.bounds);
            *count += 1;
        }
        // The cost of all bins from each one on, and of all before it.
        let mut costs_after = [0.0; BINS];
        let mut sum = (Bounds::EMPTY, 0_u32);
        for bin in (0..BINS).rev() {
            sum = (sum.0.union(&bins[bin].0), sum.1 + bins[bin].1);
            costs_after[bin] = f64::from(sum.1) * sum.0.half_area();
        }
        sum = (Bounds::EMPTY, 0);
        for bin in 1..BINS {
            sum = (sum.0.union(&bins[bin - 1].0), sum.1 + bins[bin - 1].1);
            if sum.1 == 0 || sum.1 as usize == entries.len() {
                continue;
            }
            let cost = f64::from(sum.1) * sum.0.half_area() + costs_after[bin];
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, bin));
            }
        }
    }
    best.map(|(_, axis, bin)| (axis, bin))
}

#[cfg(test)]
mod tests {
    use super::super::random::Random;
    use super::*;

    fn soup(count: usize, size_m: f64) -> Vec<[DVec3; 3]> {
        let mut random = Random::new(7, &[]);
        let mut point = |scale: f64| {
            let mut next = || scale * (random.next_unit() - 0.5);
            DVec3::new(next(), next(), next())
        };
        (0..count)
            .map(|_| {
                let center = point(10.0);
                [center + point(size_m), center + point(size_m), center + point(size_m)]
            })
            .collect()
    }

    fn nearest(bvh: &Bvh, ray: &Ray) -> Option<Crossing> {
        let mut nearest = None;
        bvh.crossings(ray, 0.0, f64::INFINITY, |crossing| {
            nearest = Some(crossing);
            ControlFlow::Continue(crossing.distance_m)
        });
        nearest
    }

    #[test]
    fn the_nearest_triangle_is_that_of_brute_force() {
        for (count, size_m) in [(3, 9.0), (1000, 1.0), (300, 8.0)] {
            let corners = soup(count, size_m);
            let bvh = Bvh::new(&corners);
            let mut random = Random::new(3, &[]);
            let mut hits = 0;
            for _ in 0..500 {
                let mut next = || random.next_unit() - 0.5;
                let origin = 12.0 * DVec3::new(next(), next(), next());
                let ray = Ray::new(origin, DVec3::new(next(), next(), next()).normalize());
                let all = corners.iter().enumerate().filter_map(|(index, [a, b, c])| {
                    let triangle = Triangle { corner: *a, edges: [*b - *a, *c - *a], index: index as u32 };
                    triangle.crossing(&ray).filter(|crossing| crossing.distance_m > 0.0)
                });
                let expected = all.min_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
                assert_eq!(nearest(&bvh, &ray), expected);
                hits += usize::from(expected.is_some());
            }
            assert!(hits > 10, "{hits} hits");
        }
    }

    #[test]
    fn rays_along_planes_edges_and_corners_hit() {
        // A square of 8 × 8 cells; rays through its grid's points and along its diagonals, from straight above.
        let mut corners = Vec::new();
        for cell in 0..64 {
            let point = |dx: i32, dz: i32| DVec3::new(f64::from(cell % 8 + dx), 0.0, f64::from(cell / 8 + dz)) / 3.0;
            corners.push([point(0, 0), point(0, 1), point(1, 0)]);
            corners.push([point(1, 0), point(0, 1), point(1, 1)]);
        }
        let bvh = Bvh::new(&corners);
        for i in 0..=16 {
            for j in 0..=16 {
                let target = DVec3::new(f64::from(i) / 6.0, 0.0, f64::from(j) / 6.0);
                for origin in [target + DVec3::Y, DVec3::new(1.3, 2.0, -0.4)] {
                    let ray = Ray::new(origin, (target - origin).normalize());
                    let hit = nearest(&bvh, &ray);
                    let at = hit.map(|hit| origin + hit.distance_m * ray.direction);
                    assert!(at.is_some_and(|at| at.distance(target) < 1e-8), "{target} from {origin}: {at:?}");
                    assert!(hit.is_some_and(|hit| hit.from_front));
                }
            }
        }
    }

    #[test]
    fn equal_triangles_and_none_are_no_trouble() {
        assert_eq!(nearest(&Bvh::new(&[]), &Ray::new(DVec3::ZERO, DVec3::X)), None);
        let triangle = [DVec3::new(1.0, -1.0, -1.0), DVec3::new(1.0, 1.0, -1.0), DVec3::new(1.0, 0.0, 1.0)];
        let bvh = Bvh::new(&[triangle; 100]);
        assert!((nearest(&bvh, &Ray::new(DVec3::ZERO, DVec3::X)).unwrap().distance_m - 1.0).abs() < 1e-12);
        let flat = [DVec3::ZERO, DVec3::X, 2.0 * DVec3::X];
        assert_eq!(nearest(&Bvh::new(&[flat, [DVec3::NAN; 3]]), &Ray::new(DVec3::Y, DVec3::NEG_Y)), None);
    }
}
