//! Texels without light of their own take that of their neighbours: what lies inside something, and what lies around
//! charts.

use crate::texels::Texels;

/// Gives every texel that has no light the mean of those beside it that have, again and again: all that have a surface, and
/// `padding` texels around them. Pages are `size` texels wide and high.
pub(crate) fn fill<const N: usize>(light: &mut [[f32; N]], texels: &impl Covered, size: (usize, usize), padding: u32) {
    let page_texels = (size.0 * size.1).max(1);
    for (page, light) in light.chunks_exact_mut(page_texels).enumerate() {
        let first = page * page_texels;
        let mut has_light: Vec<bool> = (first..first + page_texels).map(|index| texels.has_light(index)).collect();
        let mut missing: Vec<usize> = (0..page_texels).filter(|index| !has_light[*index]).collect();
        let mut round = 0;
        loop {
            let found: Vec<(usize, [f32; N])> = missing
                .iter()
                .filter(|index| round < padding || texels.has_surface(first + **index))
                .filter_map(|index| Some((*index, mean_around(*index, size, light, &has_light)?)))
                .collect();
            if found.is_empty() {
                break;
            }
            for (index, value) in found {
                light[index] = value;
                has_light[index] = true;
            }
            missing.retain(|index| !has_light[*index]);
            round += 1;
        }
    }
}

fn mean_around<const N: usize>(
    index: usize,
    (width, height): (usize, usize),
    light: &[[f32; N]],
    has_light: &[bool],
) -> Option<[f32; N]> {
    let (x, y) = (index % width, index / width);
    let (mut sum, mut count) = ([0.0; N], 0.0f32);
    for row in y.saturating_sub(1)..(y + 2).min(height) {
        for column in x.saturating_sub(1)..(x + 2).min(width) {
            let other = row * width + column;
            if has_light[other] {
                sum.iter_mut().zip(light[other]).for_each(|(sum, value)| *sum += value);
                count += 1.0;
            }
        }
    }
    (count > 0.0).then(|| sum.map(|sum| sum / count))
}

/// Which texels have what.
pub(crate) trait Covered {
    /// Whether a texel has light of its own.
    fn has_light(&self, index: usize) -> bool;
    /// Whether it has a surface.
    fn has_surface(&self, index: usize) -> bool;
}

impl Covered for Texels<'_> {
    fn has_light(&self, index: usize) -> bool {
        self.triangle(index).is_some()
    }

    fn has_surface(&self, index: usize) -> bool {
        Texels::has_surface(self, index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first texel has light, and the first four a surface.
    struct Row;

    impl Covered for Row {
        fn has_light(&self, index: usize) -> bool {
            index == 0
        }

        fn has_surface(&self, index: usize) -> bool {
            index < 4
        }
    }

    #[test]
    fn light_spreads_as_far_as_padding_and_into_all_that_is_inside() {
        let mut light = vec![[0.0]; 8];
        light[0] = [2.0];
        fill(&mut light, &Row, (8, 1), 2);
        assert_eq!(light.concat(), [2.0, 2.0, 2.0, 2.0, 0.0, 0.0, 0.0, 0.0]);
    }
}
