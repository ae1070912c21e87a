//! Points of a scan that lie far from all others: dust before the scanner, reflections, returns from nowhere.

use crate::{Aabb, NodeId, Scene, Topology};
use glam::Vec3;
use std::collections::HashSet;

/// Points of a cloud that lie far from all others, and are not framed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outliers {
    /// How many they are.
    pub count: usize,
    /// The smallest box around all points, these among them.
    pub bounds_world: Aabb,
}

/// Of so many points one is an outlier at most.
const POINTS_OF_AN_OUTLIER: usize = 1000;

/// Outliers make the box around all points more than so many times as large.
const LEAST_GROWTH: f32 = 2.0;

/// Up to so many times the radius that all other points have, a point changes the picture little, and is no outlier.
const LEAST_DISTANCE: f32 = 1.25;

/// A point is joined to others that lie in its cell of a grid or in a neighbour of that. So many cells are as long as
/// that radius: masts and wires are joined to what they stand on, and single points in a room as large as ten models
/// are not.
const CELLS: f32 = 8.0;

/// Cells end here, so that integers hold them.
const FARTHEST_CELL: Vec3 = Vec3::splat(1e6);

/// How many points the primitives have that a scene draws.
pub(super) fn points_of(scene: &Scene) -> usize {
    let mesh_of = |id: NodeId| scene.meshes.get(scene.node(id).mesh?);
    let primitives = scene.visible_nodes().into_iter().filter_map(mesh_of).flat_map(|mesh| &mesh.primitives);
    primitives.map(|primitive| primitive.positions.len()).sum()
}

/// Whether points are all that a scene draws.
pub(super) fn is_cloud(scene: &Scene) -> bool {
    let mesh_of = |id: NodeId| scene.meshes.get(scene.node(id).mesh?);
    let mut primitives = scene.visible_nodes().into_iter().filter_map(mesh_of).flat_map(|mesh| &mesh.primitives);
    primitives.all(|primitive| primitive.topology == Topology::Points)
}

/// Takes the outliers of a cloud out of its points, which are finite.
pub(super) fn leave_out(points: &mut Vec<Vec3>) -> Option<Outliers> {
    let most = points.len() / POINTS_OF_AN_OUTLIER;
    if most == 0 {
        return None;
    }
    let middle = middle(points);
    let mut distances_m: Vec<f32> = points.iter().map(|point| point.distance(middle)).collect();
    let (_, radius_m, _) = distances_m.select_nth_unstable_by(points.len() - 1 - most, f32::total_cmp);
    let radius_m = *radius_m;
    let is_near = |point: &Vec3| point.distance(middle) <= LEAST_DISTANCE * radius_m;
    let bounds_world = Aabb::from_points(points.iter().copied());
    let grows = |without: &Aabb| bounds_world.radius_m() > LEAST_GROWTH * without.radius_m();
    // Without all that can be outliers the box is smallest.
    if radius_m <= 0.0 || !grows(&Aabb::from_points(points.iter().copied().filter(is_near))) {
        return None;
    }
    let cell = |point: &Vec3| {
        let place = (*point - middle) * (CELLS / radius_m);
        place.clamp(-FARTHEST_CELL, FARTHEST_CELL).floor().as_ivec3().to_array()
    };
    let (mut joined, mut apart) = (HashSet::new(), HashSet::new());
    for point in points.iter() {
        let cells = if is_near(point) { &mut joined } else { &mut apart };
        cells.insert(cell(point));
    }
    take_joined(joined.into_iter().collect(), &mut apart);
    let is_kept = |point: &Vec3| is_near(point) || !apart.contains(&cell(point));
    if !grows(&Aabb::from_points(points.iter().copied().filter(is_kept))) {
        return None;
    }
    let count = points.len();
    points.retain(is_kept);
    Some(Outliers { count: count - points.len(), bounds_world })
}

/// The median of the points along each axis: outliers do not move it.
fn middle(points: &[Vec3]) -> Vec3 {
    let median = |axis: usize| {
        let mut places: Vec<f32> = points.iter().map(|point| point[axis]).collect();
        let half = places.len() / 2;
        let (_, median, _) = places.select_nth_unstable_by(half, f32::total_cmp);
        *median
    };
    Vec3::new(median(0), median(1), median(2))
}

/// Takes the cells out of `apart` that lie among others or beside them, or beside such a one.
fn take_joined(mut others: Vec<[i32; 3]>, apart: &mut HashSet<[i32; 3]>) {
    while let Some([x, y, z]) = others.pop() {
        for step in 0..27 {
            let neighbour = [x + step % 3 - 1, y + step / 3 % 3 - 1, z + step / 9 - 1];
            if apart.remove(&neighbour) {
                others.push(neighbour);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clouds_of_any_shape_and_size_end() {
        let on_line = |i: u16| Vec3::new(f32::from(i), 0.0, 0.0);
        let line: Vec<Vec3> = (0..2000).map(on_line).collect();
        let few: Vec<Vec3> = (0..990).map(on_line).collect();
        let one_place: Vec<Vec3> = std::iter::repeat_n(Vec3::ONE, 2000).collect();
        let far = Vec3::splat(1e17);
        for (name, points, outlier, expected) in [
            ("a line", &line[..], far, Some(1)),
            ("a line and a point on it", &line[..], Vec3::X, None),
            ("few points", &few[..], far, None),
            ("one place", &one_place[..], far, None),
            ("nothing", &[][..], Vec3::ZERO, None),
        ] {
            let mut all = points.to_vec();
            all.push(outlier);
            let outliers = leave_out(&mut all);
            assert_eq!(outliers.map(|outliers| outliers.count), expected, "{name}");
            assert_eq!(all.len(), points.len() + usize::from(expected.is_none()), "{name}");
        }
    }
}
