//! Strong small sources of a picture of the environment: its sun, and lamps.

use super::map::{EnvironmentLight, EnvironmentMap, equirectangular_direction};
use glam::{DVec3, Vec3};
use half::f16;
use half::slice::HalfFloatSliceExt;
use std::collections::HashSet;
use std::ops::Range;

/// So many strong small sources are found at most.
pub const SUNS_MAX: usize = 4;

/// What is so small is a sun, as the cosine of the angle from its middle; and what lies up to the other angle surrounds
/// it.
const SUN_COS: f32 = 0.999_78; // 1.2°
const SURROUNDINGS_COS: f32 = 0.999_12; // 2.4°

/// A source whose light is not so large a share of all is none to take out.
const SUN_SHARE_MIN: f32 = 0.01;

/// A single source is the sun, and becomes a light with shadows, if it gives a plane that faces it at least so large a
/// share of what that gets of all.
const LIGHT_SHARE_MIN: f32 = 0.2;

/// How far a broad source reaches from its middle, and up to where its surroundings lie, as cosines.
const BROAD_COS: f32 = 0.939_69; // 20°
const BROAD_SURROUNDINGS_COS: f32 = 0.866_03; // 30°

/// A broad source gives a plane that faces it at least so large a share of what that gets of all: less makes no shadow
/// that is seen.
const BROAD_SHARE_MIN: f32 = 0.1;

/// So many times the middle of a broad source is looked for again: noisy clouds are within 0.2° of theirs then.
const BROAD_STEPS: usize = 6;

/// A strong small source.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sun {
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
pub type Suns = [Sun; SUNS_MAX];

/// Finds the strong small sources of a picture.
pub fn suns(map: &EnvironmentMap) -> Suns {
    take_suns(&mut cells(map))
}

impl EnvironmentMap {
    /// The mean radiance over all directions, that of [`Self::light`] included: what a white matte ball has on the
    /// average of its surface. Where a file brings irradiance, that of the file.
    pub fn mean_radiance(&self) -> Vec3 {
        if let Some(irradiance) = &self.irradiance {
            return irradiance.mean();
        }
        let light = self.light.map_or(Vec3::ZERO, |light| light.irradiance).as_dvec3();
        let lit = |cell: &Cell| cell.radiance.as_dvec3() * f64::from(cell.solid_angle);
        let sum: DVec3 = cells(self).iter().map(lit).sum();
        ((sum + light) / (4.0 * std::f64::consts::PI)).as_vec3()
    }

    /// Takes the sun out of the picture and makes it a light, which casts shadows, if the picture has one source that is
    /// small and strong enough: within 1.2° of its middle, and at least a fifth of the light on a plane that faces it. Of
    /// several small sources none is taken, and what brings its own reflections or irradiance keeps its own.
    #[must_use]
    pub fn with_sun_as_light(mut self) -> Self {
        if self.light.is_some() || self.prefiltered.is_some() || self.irradiance.is_some() {
            return self;
        }
        let mut cells = cells(&self);
        let [sun, second, ..] = take_suns(&mut cells);
        let facing =
            |cell: &Cell| luminance(cell.radiance) * cell.solid_angle * cell.direction.dot(sun.direction).max(0.0);
        let rest: f32 = cells.iter().map(facing).sum();
        let own = luminance(sun.irradiance);
        if second.irradiance != Vec3::ZERO || own <= 0.0 || own < LIGHT_SHARE_MIN * (own + rest) {
            return self;
        }
        let surroundings = sun.surroundings;
        let mut taken = HashSet::new();
        for (index, texel) in (0..).zip(&mut self.texels) {
            let direction =
                equirectangular_direction((index % self.width, index / self.width), (self.width, self.height));
            if direction.dot(sun.direction) > SUN_COS {
                let [r, g, b, _] = texel.map(f16::to_f32);
                let [r, g, b] = Vec3::new(r, g, b).min(surroundings).to_array().map(f16::from_f32);
                *texel = [r, g, b, f16::ONE];
                taken.insert(index);
            }
        }
        self.peaks.retain(|(index, _)| !taken.contains(index));
        // Of an even disc the mean square of the distance from its middle is half the square of its radius.
        let half_angle_tan = (4.0 * sun.spread).sqrt();
        self.light = Some(EnvironmentLight { direction: sun.direction, irradiance: sun.irradiance, half_angle_tan });
        self
    }
}

impl EnvironmentMap {
    /// The broad source from which most light of a picture comes, if there is one, up to 20° from its middle: a sun
    /// behind clouds, a window, a soft box. It stays in the picture; what stands on the ground takes it from there.
    /// None where light comes evenly, where a sun is [`Self::light`], and where the file brings its own reflections or
    /// irradiance.
    pub fn broad_source(&self) -> Option<EnvironmentLight> {
        if self.light.is_some() || self.prefiltered.is_some() || self.irradiance.is_some() {
            return None;
        }
        let mut cells = cells(self);
        // Small sources are no part of what is blurred.
        take_suns(&mut cells);
        let brightest = cells.iter().max_by(|a, b| luminance(a.radiance).total_cmp(&luminance(b.radiance)))?;
        let mut source = broad_about(&cells, brightest.direction);
        for _ in 0..BROAD_STEPS {
            source = broad_about(&cells, source.direction);
        }
        let facing =
            |cell: &Cell| luminance(cell.radiance) * cell.solid_angle * cell.direction.dot(source.direction).max(0.0);
        let all: f32 = cells.iter().map(facing).sum();
        let own = luminance(source.irradiance);
        (own > 0.0 && own >= BROAD_SHARE_MIN * all).then_some(source)
    }
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

/// The middle of the source of which a cell is the brightest: of what is half as bright, and as near as its surroundings.
fn middle_of(cells: &[Cell], brightest: &Cell) -> Vec3 {
    let least = 0.5 * luminance(brightest.radiance);
    let is_of_it =
        |cell: &&Cell| cell.direction.dot(brightest.direction) > SURROUNDINGS_COS && luminance(cell.radiance) >= least;
    let sum: Vec3 = cells.iter().filter(is_of_it).map(|cell| cell.direction * cell.solid_angle).sum();
    sum.normalize_or(brightest.direction)
}

/// The mean radiance of what lies between two angles from a direction, as cosines; none if nothing does.
fn mean_between(cells: &[Cell], middle: Vec3, cosines: Range<f32>) -> Option<Vec3> {
    let between = cells.iter().filter(|cell| cosines.contains(&cell.direction.dot(middle)));
    let (sum, weight) = between.fold((Vec3::ZERO, 0.0), |(sum, weight), cell| {
        (sum + cell.radiance * cell.solid_angle, weight + cell.solid_angle)
    });
    (weight > 0.0).then(|| sum / weight)
}

/// What is brighter within 20° of a direction than its surroundings, as a light from the middle of that.
fn broad_about(cells: &[Cell], middle: Vec3) -> EnvironmentLight {
    let surroundings = mean_between(cells, middle, BROAD_SURROUNDINGS_COS..BROAD_COS).unwrap_or_default();
    let (mut irradiance, mut light, mut directions, mut squares) = (Vec3::ZERO, 0.0f32, Vec3::ZERO, 0.0f32);
    for cell in cells.iter().filter(|cell| cell.direction.dot(middle) >= BROAD_COS) {
        let beyond = (cell.radiance - surroundings).max(Vec3::ZERO) * cell.solid_angle;
        let share = luminance(beyond);
        irradiance += beyond;
        light += share;
        directions += cell.direction * share;
        squares += cell.direction.distance_squared(middle) * share;
    }
    // Of an even disc the mean square of the distance from its middle is half the square of its radius.
    let half_angle_tan = (2.0 * squares / light.max(f32::MIN_POSITIVE)).sqrt();
    EnvironmentLight { direction: directions.normalize_or(middle), irradiance, half_angle_tan }
}

/// Takes the strongest small sources out of `cells`.
fn take_suns(cells: &mut [Cell]) -> Suns {
    let all: f32 = cells.iter().map(|cell| luminance(cell.radiance) * cell.solid_angle).sum();
    let mut suns = [Sun::default(); SUNS_MAX];
    for found in &mut suns {
        let brightest = cells.iter().max_by(|a, b| luminance(a.radiance).total_cmp(&luminance(b.radiance)));
        let Some(middle) = brightest.map(|cell| middle_of(cells, cell)) else { break };
        let Some(surroundings) = mean_between(cells, middle, SURROUNDINGS_COS..SUN_COS) else { break };
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

    /// The luminance that a plane with a normal gets of the texels of a map.
    fn irradiance(map: &EnvironmentMap, normal: Vec3) -> f32 {
        let share = |cell: &Cell| luminance(cell.radiance) * cell.solid_angle * cell.direction.dot(normal).max(0.0);
        cells(map).iter().map(share).sum()
    }

    #[test]
    fn the_mean_is_over_all_directions_and_holds_the_sun() {
        // 3 (1 + y) / 2 is 1.5 on the average, and what is red above the horizon is half of it.
        let map = EnvironmentMap::from_fn("mean", 128, 64, |to| {
            Vec3::new(f32::from(u8::from(to.y > 0.0)), 1.5 + 1.5 * to.y, 0.25)
        });
        let mean = map.mean_radiance();
        assert!((mean - Vec3::new(0.5, 1.5, 0.25)).abs().max_element() < 2e-3, "{mean}");
        // What a file brings as irradiance is what a white ball has of it.
        let even = EnvironmentMap::from_fn("even", 64, 32, |_| Vec3::splat(0.125));
        let brought = map.clone().with_irradiance(&even).mean_radiance();
        assert!((brought - Vec3::splat(0.125)).abs().max_element() < 1e-4, "{brought}");
        // A light has its irradiance over 4 π.
        let irradiance = Vec3::splat(4.0 * std::f32::consts::PI);
        let light = EnvironmentLight { direction: Vec3::Y, irradiance, half_angle_tan: 0.0 };
        let lit = EnvironmentMap { light: Some(light), ..map }.mean_radiance();
        assert!((lit - mean - Vec3::ONE).abs().max_element() < 1e-4, "{lit}");
        // It is the same whether the sun is in the picture or beside it.
        let to_sun = Vec3::new(0.4, 0.7, -0.3).normalize();
        let sunny = EnvironmentMap::from_fn("sun", 1024, 512, |to| {
            Vec3::splat(if to.dot(to_sun) > 0.99993 { 20_000.0 } else { 0.2 })
        });
        let beside = sunny.clone().with_sun_as_light();
        assert!(beside.light.is_some());
        let ratio = beside.mean_radiance().x / sunny.mean_radiance().x;
        assert!((ratio - 1.0).abs() < 1e-3, "{ratio}");
    }

    #[test]
    fn the_one_sun_of_a_picture_becomes_a_light_and_no_light_is_lost() {
        let to_sun = Vec3::new(0.4, 0.7, -0.3).normalize();
        let other = Vec3::new(-0.4, 0.7, 0.3).normalize();
        let sky = |to: Vec3| if to.y > 0.0 { Vec3::new(0.3, 0.5, 0.9) } else { Vec3::splat(0.15) };
        let with = |radiance: f32, second: f32| {
            EnvironmentMap::from_fn("a", 1024, 512, move |to| match () {
                () if to.dot(to_sun) > 0.99993 => Vec3::splat(radiance),
                () if to.dot(other) > 0.99993 => Vec3::splat(second),
                () => sky(to),
            })
        };
        let sunny = with(20_000.0, 0.0);
        let split = sunny.clone().with_sun_as_light();
        let light = split.light.expect("a light");
        assert!(light.direction.dot(to_sun) > 0.999_99, "{}", light.direction);
        // A disc whose cosine is 0.99993 has a half angle of 0.678°.
        assert!((light.half_angle_tan / 0.011_83 - 1.0).abs() < 0.05, "{}", light.half_angle_tan);
        for normal in [Vec3::Y, to_sun, Vec3::X, -Vec3::Z] {
            let whole = irradiance(&sunny, normal);
            let parts = irradiance(&split, normal) + luminance(light.irradiance) * light.direction.dot(normal).max(0.0);
            assert!((parts / whole - 1.0).abs() < 1e-2, "{normal}: {parts} of {whole}");
        }
        assert_eq!(split.clone().with_sun_as_light(), split, "once is enough");
        // Too faint, one of two, none.
        for map in [with(200.0, 0.0), with(20_000.0, 20_000.0), with(0.5, 0.5)] {
            assert_eq!(map.clone().with_sun_as_light(), map);
        }
    }

    #[test]
    fn a_sun_behind_clouds_is_a_broad_source() {
        let to_sun = Vec3::new(0.5, 0.6, 0.6).normalize();
        let sky = |to: Vec3| if to.y > 0.0 { 0.6 } else { 0.15 };
        let cloudy = |peak: f32, width_deg: f32| {
            EnvironmentMap::from_fn("cloudy", 256, 128, |to| {
                let from_sun = to.dot(to_sun).clamp(-1.0, 1.0).acos().to_degrees() / width_deg;
                Vec3::splat(sky(to) + peak * (-from_sun * from_sun).exp())
            })
        };
        // Of a bell curve the mean square of the distance is the square of its width: √2 times that of the disc.
        let (map, width_deg) = (cloudy(30.0, 8.0), 8.0f32);
        assert_eq!(map.clone().with_sun_as_light().light, None, "it is no small source");
        let source = map.broad_source().expect("a broad source");
        assert!(source.direction.dot(to_sun) > 0.999_9, "{}", source.direction);
        let half_angle_deg = source.half_angle_tan.atan().to_degrees();
        assert!((half_angle_deg / (2.0f32.sqrt() * width_deg) - 1.0).abs() < 0.06, "{half_angle_deg}");
        // Within small angles the integral of the curve is π times the square of its width in radians.
        let expected = 30.0 * std::f32::consts::PI * width_deg.to_radians().powi(2);
        assert!((source.irradiance.x / expected - 1.0).abs() < 0.05, "{} of {expected}", source.irradiance.x);
        let share = luminance(source.irradiance) / irradiance(&map, to_sun);
        assert!((0.4..0.6).contains(&share), "{share}");
        assert_eq!([cloudy(0.0, 8.0), cloudy(0.5, 25.0)].map(|map| map.broad_source()), [None; 2]);
        // A sun that is a light of its own needs none.
        let light = Some(EnvironmentLight { direction: Vec3::Y, irradiance: Vec3::ONE, half_angle_tan: 0.0 });
        assert_eq!(EnvironmentMap { light, ..map }.broad_source(), None);
    }
}
