//! The strongest small source of the light that arrives at a place.

use crate::emitters::luminance;
use glam::Vec3;
use manypass_scene::probes::{Harmonics, SmallSource};

/// Light within the first of these cosines of its direction is all of the source, and none beyond the second: 15 and 30
/// degrees.
const WITHIN: [f32; 2] = [0.965_9, 0.866];

/// How often the direction is moved to where light is within that.
const STEPS: usize = 4;

/// Light straight from where it is made.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DirectLight {
    pub direction: Vec3,
    /// What it adds to irradiance across its direction.
    pub share: Vec3,
    /// Its radiance; infinite of a point.
    pub level: f32,
}

/// How much of light from a direction belongs to a source in another one.
fn belongs(cosine: f32) -> f32 {
    let [all, none] = WITHIN;
    let share = ((cosine - none) / (all - none)).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

/// Takes the strongest small source out of light, of which `made` says what comes straight from where it is made.
pub(crate) fn take_small_source(light: &mut Harmonics, made: &[DirectLight]) -> SmallSource {
    let mean = luminance(light.0[0]) * 0.282_095;
    // What light is on average is of no source.
    let beyond = |of: &DirectLight| (1.0 - mean / of.level.max(1e-20)).max(0.0);
    let bright: Vec<(Vec3, Vec3, f32)> = made
        .iter()
        .map(|of| (of.direction, of.share * beyond(of)))
        .map(|(direction, share)| (direction, share, luminance(share)))
        .filter(|(.., weight)| *weight > 0.0)
        .collect();
    // Of the axes and corners of a cube the one with most of the light about it is where the search begins.
    let starts = (0..27).map(|at| Vec3::new((at % 3) as f32 - 1.0, (at / 3 % 3) as f32 - 1.0, (at / 9) as f32 - 1.0));
    let about = |start: Vec3| -> f32 {
        bright.iter().map(|(direction, _, weight)| weight * direction.dot(start).max(0.0).powi(8)).sum()
    };
    let starts = starts.filter(|start| *start != Vec3::ZERO).map(Vec3::normalize).map(|start| (start, about(start)));
    let Some((mut direction, strength)) = starts.max_by(|a, b| a.1.total_cmp(&b.1)) else {
        return SmallSource::default();
    };
    if strength <= 0.0 {
        return SmallSource::default();
    }
    for step in 0..=STEPS {
        // At first all that is nearer than the next start.
        let share = |cosine: f32| if step == 0 { cosine.max(0.0).powi(8) } else { belongs(cosine) };
        let sum: Vec3 = bright.iter().map(|(of, _, weight)| *of * (weight * share(of.dot(direction)))).sum();
        direction = sum.normalize_or(direction);
    }
    let (mut irradiance, mut off_axis, mut all) = (Vec3::ZERO, 0.0, 0.0);
    for (of, share, _) in &bright {
        let cosine = of.dot(direction);
        let taken = *share * belongs(cosine);
        irradiance += taken * cosine.max(0.0);
        light.add(*of, -taken);
        let weight = luminance(taken);
        off_axis += weight * (1.0 - cosine * cosine).max(0.0);
        all += weight;
    }
    if all <= 0.0 {
        return SmallSource::default();
    }
    // Over a disc the square of the distance from its middle is half that of its radius on average.
    SmallSource { direction, irradiance, spread: (2.0 * off_axis / all).sqrt().min(0.5) }
}
