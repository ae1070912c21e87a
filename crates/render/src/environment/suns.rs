//! What is found out about a map of the environment on the CPU: its strong small sources.

use glam::Vec3;
use half::slice::HalfFloatSliceExt;
use manypass_scene::EnvironmentMap;
use manypass_scene::environment::equirectangular_direction;

/// So many strong small sources are found at most.
pub(crate) const SUNS_MAX: usize = 4;

/// What is so small is a sun, as the cosine of the angle from its middle; and what lies up to the other angle surrounds
/// it.
const SUN_COS: f32 = 0.999_78; // 1.2°
const SURROUNDINGS_COS: f32 = 0.999_12; // 2.4°

/// A source whose light is not so large a share of all is none to take out.
const SUN_SHARE_MIN: f32 = 0.01;

/// A strong small source.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Sun {
    /// Where it is.
    pub direction: Vec3,
    /// Its irradiance on a plane across the direction, beyond that of its surroundings.
    pub irradiance: Vec3,
    /// The radiance of its surroundings.
    pub surroundings: Vec3,
    /// The square of half the half angle of a disc whose light is as far from its middle as this one's: half the mean
    /// of that distance squared. `environment_suns.wgsl` has the disc in lobes.
    pub spread: f32,
}

impl Sun {
    /// The cosine of the angle that holds it.
    pub fn cos(&self) -> f32 {
        // None has no place.
        if self.direction == Vec3::ZERO { 2.0 } else { SUN_COS }
    }
}

/// Strong small sources of a map; there may be fewer.
pub(crate) type Suns = [Sun; SUNS_MAX];

/// Finds them.
pub(crate) fn suns(map: &EnvironmentMap) -> Suns {
    take_suns(&mut cells(map))
}

/// A part of all directions: where, how large, and its mean radiance.
#[derive(Clone, Copy, Debug)]
struct Cell {
    direction: Vec3,
    solid_angle: f32,
    radiance: Vec3,
}

/// Across and down, at most.
const CELLS: (u32, u32) = (1024, 512);

/// Means of the map's texels.
fn cells(map: &EnvironmentMap) -> Vec<Cell> {
    let size = (CELLS.0.min(map.width), CELLS.1.min(map.height));
    let (columns, rows) = (size.0 as usize, size.1 as usize);
    let mut sums = vec![(Vec3::ZERO, 0u32); columns * rows];
    let mut values = vec![0f32; 4 * map.width as usize];
    for (y, row) in map.texels.chunks_exact(map.width as usize).enumerate() {
        let halves: &[half::f16] = bytemuck::cast_slice(row);
        halves.convert_to_f32_slice(&mut values);
        let sums = &mut sums[y * rows / map.height as usize * columns..][..columns];
        for (x, texel) in values.chunks_exact(4).enumerate() {
            let sum = &mut sums[x * columns / map.width as usize];
            sum.0 += Vec3::new(texel[0], texel[1], texel[2]);
            sum.1 += 1;
        }
    }
    // Means of what texels hold, and of what they cannot.
    for (index, beyond) in &map.peaks {
        let (x, y) = ((index % map.width) as usize, (index / map.width) as usize);
        let place = y * rows / map.height as usize * columns + x * columns / map.width as usize;
        if let Some(sum) = sums.get_mut(place) {
            sum.0 += *beyond;
        }
    }
    let cell = |(i, (sum, count)): (usize, (Vec3, u32))| {
        let (x, y) = ((i % columns) as u32, (i / columns) as u32);
        let edge = |row: u32| (std::f32::consts::PI * row as f32 / size.1 as f32).cos();
        Cell {
            direction: equirectangular_direction((x, y), size),
            solid_angle: std::f32::consts::TAU / size.0 as f32 * (edge(y) - edge(y + 1)),
            radiance: sum / count.max(1) as f32,
        }
    };
    sums.into_iter().enumerate().map(cell).collect()
}

fn luminance(radiance: Vec3) -> f32 {
    radiance.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Takes the strongest small sources out of `cells`.
fn take_suns(cells: &mut [Cell]) -> Suns {
    let all: f32 = cells.iter().map(|cell| luminance(cell.radiance) * cell.solid_angle).sum();
    let mut suns = [Sun::default(); SUNS_MAX];
    for found in &mut suns {
        let brightest = cells.iter().max_by(|a, b| luminance(a.radiance).total_cmp(&luminance(b.radiance)));
        let Some(middle) = brightest.map(|cell| cell.direction) else { break };
        let around = cells.iter().filter(|cell| (SURROUNDINGS_COS..SUN_COS).contains(&cell.direction.dot(middle)));
        let (sum, weight) = around.fold((Vec3::ZERO, 0.0), |(sum, weight), cell| {
            (sum + cell.radiance * cell.solid_angle, weight + cell.solid_angle)
        });
        if weight == 0.0 {
            break;
        }
        let surroundings = sum / weight;
        let (mut irradiance, mut light, mut offset, mut squares) = (Vec3::ZERO, 0.0, Vec3::ZERO, 0.0);
        for cell in cells.iter_mut().filter(|cell| cell.direction.dot(middle) > SUN_COS) {
            let beyond = (cell.radiance - surroundings).max(Vec3::ZERO) * cell.solid_angle;
            irradiance += beyond;
            let (share, from_middle) = (luminance(beyond), cell.direction - middle);
            light += share;
            offset += from_middle * share;
            // A square is as wide as a third of the square of half its side, in both directions.
            squares += (from_middle.length_squared() + cell.solid_angle / 6.0) * share;
        }
        if luminance(irradiance) <= SUN_SHARE_MIN * all {
            break;
        }
        for cell in cells.iter_mut().filter(|cell| cell.direction.dot(middle) > SUN_COS) {
            cell.radiance = cell.radiance.min(surroundings);
        }
        let offset = offset / light;
        let spread = 0.5 * (squares / light - offset.length_squared()).max(0.0);
        *found = Sun { direction: (middle + offset).normalize_or(middle), irradiance, surroundings, spread };
    }
    suns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sun_that_texels_cannot_hold_lights_in_full() {
        let size = (256, 128);
        let at = (40, 30);
        let mut map = EnvironmentMap::from_fn("sun", size.0, size.1, |_| Vec3::splat(0.5));
        let index = at.1 * size.0 + at.0;
        map.texels[index as usize] = [half::f16::from_f32(64_000.0); 4];
        map.peaks = vec![(index, Vec3::splat(136_000.0))];
        let found = suns(&map);
        let edge = |row: u32| (std::f32::consts::PI * row as f32 / size.1 as f32).cos();
        let solid_angle = std::f32::consts::TAU / size.0 as f32 * (edge(at.1) - edge(at.1 + 1));
        let expected = 199_999.5 * solid_angle;
        assert!((found[0].irradiance.x / expected - 1.0).abs() < 1e-3, "{} of {expected}", found[0].irradiance.x);
        assert!(found[0].direction.dot(equirectangular_direction(at, size)) > 0.9999);
        assert_eq!(found[1], Sun::default());
    }
}
