//! Points by component, so that the one farthest along a direction is found eight at a time.

use glam::Vec3;

const LANES: usize = 8;

/// Points of `N` components.
#[derive(Clone, Debug)]
pub(super) struct Points<const N: usize> {
    /// A column for each component, filled up with the last point to a multiple of eight.
    columns: [Vec<f32>; N],
}

impl<const N: usize> Points<N> {
    pub(super) fn new(points: impl ExactSizeIterator<Item = [f32; N]>) -> Self {
        let mut columns = [(); N].map(|()| Vec::with_capacity(points.len().next_multiple_of(LANES)));
        for point in points {
            columns.iter_mut().zip(point).for_each(|(column, value)| column.push(value));
        }
        for column in &mut columns {
            let last = column.last().copied().unwrap_or(0.0);
            column.resize(column.len().next_multiple_of(LANES), last);
        }
        Self { columns }
    }

    /// The point with the largest dot product with `direction`; the origin if there is no point.
    pub(super) fn farthest(&self, direction: [f32; N]) -> [f32; N] {
        let blocks = self.columns.each_ref().map(|column| column.as_chunks::<LANES>().0);
        let mut most = [f32::NEG_INFINITY; LANES];
        let mut best = [0u32; LANES];
        let count = blocks.iter().map(|blocks| blocks.len()).min().unwrap_or(0);
        for block in 0..count {
            let mut reach = [0.0; LANES];
            for (blocks, weight) in blocks.iter().zip(direction) {
                for (reach, value) in reach.iter_mut().zip(&blocks[block]) {
                    *reach += value * weight;
                }
            }
            for lane in 0..LANES {
                let is_farther = reach[lane] > most[lane];
                most[lane] = if is_farther { reach[lane] } else { most[lane] };
                best[lane] = if is_farther { block as u32 } else { best[lane] };
            }
        }
        let lane = (1..LANES).fold(0, |lane, other| if most[other] > most[lane] { other } else { lane });
        let index = best[lane] as usize * LANES + lane;
        self.columns.each_ref().map(|column| column.get(index).copied().unwrap_or(0.0))
    }
}

impl Points<3> {
    pub(super) fn iter(&self) -> impl ExactSizeIterator<Item = Vec3> {
        let [xs, ys, zs] = &self.columns;
        (0..xs.len()).map(|i| Vec3::new(xs[i], ys[i], zs[i]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_farthest_of_any_number_of_points_is_found() {
        assert_eq!(Points::<2>::new([].into_iter()).farthest([1.0, 0.0]), [0.0, 0.0]);
        for count in 1..40 {
            let points: Vec<[f32; 2]> =
                (0..count).map(|i| [(i as f32 * 2.4).sin() - 2.0, (i as f32 * 1.7).cos()]).collect();
            for direction in [[1.0, 0.0], [-0.3, 1.0], [-1.0, -2.0]] {
                let reach = |point: &[f32; 2]| point[0] * direction[0] + point[1] * direction[1];
                let most = points.iter().map(reach).fold(f32::NEG_INFINITY, f32::max);
                let found = Points::new(points.iter().copied()).farthest(direction);
                assert!(points.contains(&found) && reach(&found) == most, "{count} {found:?}");
            }
        }
    }
}
