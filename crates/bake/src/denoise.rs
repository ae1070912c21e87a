//! Noise leaves bounced light where neighbours of the same piece of surface agree within it.
//!
//! First what stands out is brought down. Then a texel becomes the mean of those around it whose light differs by no
//! more than noise explains, on the same chart and facing the same way: three rounds, each with wider gaps (Dammertz et
//! al. 2010, "Edge-Avoiding À-Trous Wavelet Transform"), whose differences are weighed by the variance that the samples themselves show (Schied et al. 2017,
//! "Spatiotemporal Variance-Guided Filtering"). Where light comes from takes part with the weights of its luminance, so that
//! it goes on being the moment of that light.

use crate::BakeError;
use crate::emitters::luminance;
use crate::progress::{Progress, Stage};
use crate::texels::Texels;
use crate::work::share_out;
use glam::Vec3;

/// Gaps between texels of each round.
const STEPS: [i32; 3] = [1, 2, 4];

/// How much brighter than all but one of those around it a texel stands out: less is noise as it is everywhere, and to cut
/// that would darken.
const PEAK: f32 = 1.15;

/// The filter of a round along one axis, from the middle outwards.
const KERNEL: [f32; 3] = [3.0 / 8.0, 1.0 / 4.0, 1.0 / 16.0];

/// How many standard deviations apart light may be.
const DEVIATIONS: f32 = 2.0;

/// Two facets with a smaller cosine between them are not the same surface.
const COSINE_MIN: f32 = 0.95;

/// What a texel holds while it is filtered: its light and what belongs to it, and the variance of its luminance.
type NoisyTexel<const N: usize> = ([f32; N], f32);

/// The luminance of light that red, green and blue begin.
fn luminance_of<const N: usize>(light: &[f32; N]) -> f32 {
    luminance(Vec3::from_slice(light))
}

/// Takes the noise out of `light`, of which `variance` says how far the luminance of each texel may be off, squared. Of the
/// numbers of a texel red, green and blue are the first; the others are averaged as these are.
///
/// # Errors
/// `progress` says to stop.
pub(crate) fn denoise<const N: usize>(
    light: Vec<[f32; N]>,
    variance: Vec<f32>,
    texels: &Texels,
    size: (usize, usize),
    (progress, stage): (&dyn Progress, Stage),
) -> Result<Vec<[f32; N]>, BakeError> {
    let mut noisy: Vec<NoisyTexel<N>> = light.into_iter().zip(variance).collect();
    let mut next = vec![([0.0; N], 0.0); noisy.len()];
    share_out(&mut next, (progress, stage), |index| without_peak(&noisy, texels, size, index))?;
    std::mem::swap(&mut noisy, &mut next);
    for step in STEPS {
        share_out(&mut next, (progress, stage), |index| filtered(&noisy, texels, size, index, step))?;
        std::mem::swap(&mut noisy, &mut next);
    }
    drop(next);
    Ok(noisy.into_iter().map(|(light, _)| light).collect())
}

/// A texel that is brighter than all around it but one has met by chance what is small and bright, which others missed: it
/// is brought down to the second of them, so that it does not become a spot.
fn without_peak<const N: usize>(
    noisy: &[NoisyTexel<N>],
    texels: &Texels,
    (width, height): (usize, usize),
    index: usize,
) -> NoisyTexel<N> {
    let (light, variance) = noisy[index];
    let Some(chart) = texels.triangle(index).map(|owner| texels.chart(owner)) else { return (light, variance) };
    let (x, y) = (index % width, index / width % height);
    let first = index - (y * width + x);
    let rows = y.saturating_sub(1)..(y + 2).min(height);
    let around = rows.flat_map(|row| (x.saturating_sub(1)..(x + 2).min(width)).map(move |column| row * width + column));
    let others = around
        .map(|other| first + other)
        .filter(|other| *other != index)
        .filter(|other| texels.triangle(*other).is_some_and(|owner| texels.chart(owner) == chart))
        .map(|other| luminance_of(&noisy[other].0));
    let [_, second] = others.fold(
        [0.0f32; 2],
        |[most, second], other| {
            if other > most { [other, most] } else { [most, second.max(other)] }
        },
    );
    let own = luminance_of(&light);
    // A piece of one or two texels has nothing to go by.
    if second <= 0.0 || own <= PEAK * second {
        return (light, variance);
    }
    let share = second / own;
    (light.map(|part| part * share), variance * share * share)
}

fn filtered<const N: usize>(
    noisy: &[NoisyTexel<N>],
    texels: &Texels,
    (width, height): (usize, usize),
    index: usize,
    step: i32,
) -> NoisyTexel<N> {
    let Some(owner) = texels.triangle(index) else { return noisy[index] };
    let (chart, facet) = (texels.chart(owner), texels.facet(owner));
    let middle = luminance_of(&noisy[index].0);
    // Of few samples the variance of one texel is a poor guess; that of nine is better.
    let scale = 1.0 / (DEVIATIONS * (variance_around(noisy, (width, height), index) + 1e-12).sqrt());
    let (x, y) = ((index % width) as i32, (index / width % height) as i32);
    let first = index - (y as usize * width + x as usize);
    let (mut sum, mut of_variance, mut total) = ([0.0; N], 0.0, 0.0);
    for row in -2..=2i32 {
        for column in -2..=2i32 {
            let (x, y) = (x + column * step, y + row * step);
            if x < 0 || y < 0 || x >= width as i32 || y >= height as i32 {
                continue;
            }
            let other = first + y as usize * width + x as usize;
            let is_same = texels.triangle(other).is_some_and(|of_other| {
                of_other == owner || texels.chart(of_other) == chart && texels.facet(of_other).dot(facet) > COSINE_MIN
            });
            if !is_same {
                continue;
            }
            let (light, variance) = noisy[other];
            let apart = (luminance_of(&light) - middle).abs() * scale;
            let kernel = KERNEL[row.unsigned_abs() as usize] * KERNEL[column.unsigned_abs() as usize];
            let weight = kernel * (-apart * apart).exp();
            sum.iter_mut().zip(light).for_each(|(sum, part)| *sum += part * weight);
            of_variance += variance * weight * weight;
            total += weight;
        }
    }
    (sum.map(|sum| sum / total), of_variance / (total * total))
}

fn variance_around<const N: usize>(noisy: &[NoisyTexel<N>], (width, height): (usize, usize), index: usize) -> f32 {
    let (x, y) = (index % width, index / width % height);
    let first = index - (y * width + x);
    let (mut sum, mut count) = (0.0, 0.0);
    for row in y.saturating_sub(1)..(y + 2).min(height) {
        for column in x.saturating_sub(1)..(x + 2).min(width) {
            let variance = noisy[first + row * width + column].1;
            if variance > 0.0 {
                sum += variance;
                count += 1.0;
            }
        }
    }
    if count > 0.0 { sum / count } else { 0.0 }
}
