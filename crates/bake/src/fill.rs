//! Texels without light of their own take that of their neighbours: what lies inside something, and what lies around
//! charts.

use crate::texels::Texels;
use glam::Vec3;
use half::f16;
use manypass_scene::environment::RADIANCE_MAX;

/// Gives every texel that has no light the mean of those beside it that have, again and again: all that have a surface, and
/// `padding` texels around them. Pages are `size` texels wide and high.
pub(crate) fn fill<L: Light>(light: &mut [L], texels: &impl TexelCoverage, size: (usize, usize), padding: u32) {
    let page_texels = (size.0 * size.1).max(1);
    for (page, light) in light.chunks_exact_mut(page_texels).enumerate() {
        let first = page * page_texels;
        let mut has_light: Vec<bool> = (first..first + page_texels).map(|index| texels.has_light(index)).collect();
        let mut missing: Vec<u32> = (0..page_texels as u32).filter(|index| !has_light[*index as usize]).collect();
        let mut round = 0;
        loop {
            let found: Vec<(usize, L)> = missing
                .iter()
                .map(|index| *index as usize)
                .filter(|index| round < padding || texels.has_surface(first + index))
                .filter_map(|index| Some((index, mean_around(index, size, light, &has_light)?)))
                .collect();
            if found.is_empty() {
                break;
            }
            for (index, value) in found {
                light[index] = value;
                has_light[index] = true;
            }
            missing.retain(|index| !has_light[*index as usize]);
            round += 1;
        }
    }
}

fn mean_around<L: Light>(index: usize, (width, height): (usize, usize), light: &[L], has_light: &[bool]) -> Option<L> {
    let (x, y) = (index % width, index / width);
    let (mut sum, mut count) = (Vec3::ZERO, 0.0f32);
    for row in y.saturating_sub(1)..(y + 2).min(height) {
        for column in x.saturating_sub(1)..(x + 2).min(width) {
            let other = row * width + column;
            if has_light[other] {
                sum += light[other].value();
                count += 1.0;
            }
        }
    }
    (count > 0.0).then(|| L::of(sum / count))
}

/// Light of a texel, as it is kept.
pub(crate) trait Light: Copy {
    /// Its value.
    fn value(self) -> Vec3;
    /// That of a value.
    fn of(value: Vec3) -> Self;
}

impl Light for [f32; 3] {
    fn value(self) -> Vec3 {
        self.into()
    }

    fn of(value: Vec3) -> Self {
        value.into()
    }
}

/// Light that is looked up where rays end: half floats are within 0.05 %, and take half the memory.
impl Light for [f16; 3] {
    fn value(self) -> Vec3 {
        self.map(f16::to_f32).into()
    }

    fn of(value: Vec3) -> Self {
        value.to_array().map(|part| f16::from_f32(if part.is_finite() { part.min(RADIANCE_MAX) } else { 0.0 }))
    }
}

/// Which texels have what.
pub(crate) trait TexelCoverage {
    /// Whether a texel has light of its own.
    fn has_light(&self, index: usize) -> bool;
    /// Whether it has a surface.
    fn has_surface(&self, index: usize) -> bool;
}

impl TexelCoverage for Texels<'_> {
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

    impl TexelCoverage for Row {
        fn has_light(&self, index: usize) -> bool {
            index == 0
        }

        fn has_surface(&self, index: usize) -> bool {
            index < 4
        }
    }

    #[test]
    fn light_spreads_as_far_as_padding_and_into_all_that_is_inside() {
        let mut light = vec![[0.0f32; 3]; 8];
        light[0] = [2.0; 3];
        fill(&mut light, &Row, (8, 1), 2);
        let reds: Vec<f32> = light.iter().map(|light| light[0]).collect();
        assert_eq!(reds, [2.0, 2.0, 2.0, 2.0, 0.0, 0.0, 0.0, 0.0]);
    }
}
