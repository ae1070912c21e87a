//! Corners of a polygon in a tree, to find one in a triangle.

use glam::DVec2;

/// Twice the area of a triangle; below 0 where it turns clockwise.
pub(super) fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// So many corners are looked at one by one.
const LEAF_CORNERS: usize = 16;

/// Corners that lie together.
#[derive(Debug)]
struct Branch {
    min: DVec2,
    max: DVec2,
    /// How many were not removed.
    count: usize,
    /// Where it begins and ends in the order.
    start: usize,
    end: usize,
    parent: usize,
    /// The index of the first of its two halves; 0 where it has none.
    halves: usize,
}

/// A tree whose branches are halved along their longer side (Bentley 1975).
#[derive(Debug)]
pub(super) struct Corners<'a> {
    points: &'a [DVec2],
    order: Vec<usize>,
    branches: Vec<Branch>,
    /// Of each point its leaf; none if it is not there, or no more.
    leaf_of: Vec<Option<u32>>,
}

impl<'a> Corners<'a> {
    /// A tree of the corners at these places in `points`.
    pub(super) fn new(points: &'a [DVec2], order: Vec<usize>) -> Self {
        let mut tree = Self { points, leaf_of: vec![None; points.len()], branches: Vec::new(), order };
        let root = tree.branch(0, tree.order.len(), 0);
        tree.branches.push(root);
        let mut next = 0;
        while let Some(&Branch { min, max, start, end, .. }) = tree.branches.get(next) {
            if end - start > LEAF_CORNERS {
                let middle = start + (end - start) / 2;
                let is_wide = (max - min).x >= (max - min).y;
                let key =
                    |corner: &usize| points.get(*corner).map_or(0.0, |point| if is_wide { point.x } else { point.y });
                if let Some(range) = tree.order.get_mut(start..end) {
                    range.select_nth_unstable_by(middle - start, |a, b| key(a).total_cmp(&key(b)));
                }
                let halves = [tree.branch(start, middle, next), tree.branch(middle, end, next)];
                let first = tree.branches.len();
                tree.branches.extend(halves);
                if let Some(branch) = tree.branches.get_mut(next) {
                    branch.halves = first;
                }
            } else {
                for &corner in tree.order.get(start..end).unwrap_or_default() {
                    if let Some(leaf) = tree.leaf_of.get_mut(corner) {
                        *leaf = Some(next as u32);
                    }
                }
            }
            next += 1;
        }
        tree
    }

    fn branch(&self, start: usize, end: usize, parent: usize) -> Branch {
        let corners = self.order.get(start..end).unwrap_or_default().iter();
        let points = corners.filter_map(|corner| self.points.get(*corner));
        let (min, max) =
            points.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(min, max), point| (min.min(*point), max.max(*point)));
        Branch { min, max, count: end - start, start, end, parent, halves: 0 }
    }

    /// Takes a corner out, if it is there.
    pub(super) fn remove(&mut self, corner: usize) {
        let Some(leaf) = self.leaf_of.get_mut(corner).and_then(Option::take) else { return };
        let mut at = leaf as usize;
        while let Some(branch) = self.branches.get_mut(at) {
            branch.count -= 1;
            if at == 0 {
                return;
            }
            at = branch.parent;
        }
    }

    /// Whether any corner lies in a triangle or on its edges, and not at one of its ends.
    pub(super) fn any_inside(&self, triangle: [DVec2; 3]) -> bool {
        let [p, q, r] = triangle;
        let edges = [(p, q), (q, r), (r, p)];
        let (min, max) = (p.min(q).min(r), p.max(q).max(r));
        // The corner of a box that lies farthest to the left of an edge.
        let is_beside = |branch: &Branch| {
            edges.iter().any(|(a, b)| {
                let along = *b - *a;
                let x = if along.y < 0.0 { branch.max.x } else { branch.min.x };
                let y = if along.x > 0.0 { branch.max.y } else { branch.min.y };
                turn(*a, *b, DVec2::new(x, y)) < 0.0
            })
        };
        let holds = |corner: &usize| {
            let is_there = self.leaf_of.get(*corner).is_some_and(Option::is_some);
            let point = self.points.get(*corner).copied().filter(|_| is_there);
            point.is_some_and(|s| !triangle.contains(&s) && edges.iter().all(|(a, b)| turn(*a, *b, s) >= 0.0))
        };
        let mut pending = vec![0];
        while let Some(branch) = pending.pop().and_then(|index: usize| self.branches.get(index)) {
            let is_apart = branch.min.cmpgt(max).any() || branch.max.cmplt(min).any();
            if branch.count == 0 || is_apart || is_beside(branch) {
                continue;
            }
            if branch.halves > 0 {
                pending.extend([branch.halves, branch.halves + 1]);
            } else if self.order.get(branch.start..branch.end).unwrap_or_default().iter().any(holds) {
                return true;
            }
        }
        false
    }
}
