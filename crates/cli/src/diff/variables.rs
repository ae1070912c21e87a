//! How two models differ in what a frame knows of every pixel: whether geometry, material or light changed.

use super::models::Models;
use manypass::Aov;
use manypass_offline::{AovLayer, Samples};

/// How a variable of two pictures differs.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Which.
    pub aov: Aov,
    /// The mean difference of the pixels that are compared, in [`unit`]; of ids the share that differs.
    pub mean: f64,
    /// The largest difference, in the same unit.
    pub largest: f32,
    /// The first pixel that has it: column and row from the top left.
    pub largest_at_px: (usize, usize),
    /// The share of the compared pixels that differ by more than storage rounds, 0 to 1.
    pub share: f64,
    /// The difference of every pixel, rows from the top; 0 where none is compared.
    pub differences: Vec<f32>,
}

/// What became of the pixels in which a surface of either model is seen, as shares of them: of each the first that
/// holds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChangeShares {
    /// A surface is there in one picture alone, or at another place, or turned another way.
    pub geometry: f64,
    /// Its base colour, metallic, roughness, occlusion or emission is another.
    pub material: f64,
    /// It is the same, and sends other light.
    pub light: f64,
}

/// All variables, and what they say together.
#[derive(Clone, Debug, PartialEq)]
pub struct Variables {
    /// In the order in which they were drawn, those that are listed.
    pub all: Vec<Variable>,
    /// What changed.
    pub changed: ChangeShares,
    /// The shares of the pixels in which either model is seen that show the first, and the second, alone.
    pub only: [f64; 2],
}

/// The unit of a variable's differences.
pub fn unit(aov: Aov) -> &'static str {
    match aov {
        Aov::Normal | Aov::NormalView => "deg",
        Aov::Position | Aov::Depth => "m",
        Aov::Emission | Aov::Radiance => "cd/m2",
        Aov::Motion => "px",
        Aov::BaseColor | Aov::Occlusion | Aov::OcclusionScreen | Aov::Metallic | Aov::Roughness => "1",
        Aov::ObjectId | Aov::MaterialId => "share",
    }
}

/// Which part of a model a variable tells of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ModelPart {
    Geometry,
    Material,
    Light,
    /// Names, and what follows from the others.
    Neither,
}

const fn part(aov: Aov) -> ModelPart {
    match aov {
        Aov::Depth | Aov::Position | Aov::Normal | Aov::NormalView => ModelPart::Geometry,
        Aov::BaseColor | Aov::Occlusion | Aov::Metallic | Aov::Roughness | Aov::Emission => ModelPart::Material,
        Aov::Radiance => ModelPart::Light,
        // What lies beside a pixel's surface changes its occlusion.
        Aov::OcclusionScreen | Aov::Motion | Aov::ObjectId | Aov::MaterialId => ModelPart::Neither,
    }
}

/// Compares all variables of two models.
pub fn compare(models: &Models) -> Variables {
    let [a, b] = &models.layers;
    let width = models.a.picture.size().0.max(1);
    let seen: Vec<[bool; 2]> = match (depths(a), depths(b)) {
        (Some(a), Some(b)) => a.iter().zip(b).map(|(a, b)| [a.is_finite(), b.is_finite()]).collect(),
        _ => Vec::new(),
    };
    let mut parts = vec![[false; 3]; seen.len()];
    let mut all = Vec::new();
    for (a, b) in a.iter().zip(b) {
        let differs = |pixel: usize, difference: f32| {
            let size = magnitude(&a.samples, pixel).max(magnitude(&b.samples, pixel));
            difference > tolerance(a.aov, size, models.radius_m)
        };
        let is_compared = |pixel: usize| a.aov == Aov::Radiance || seen.get(pixel) == Some(&[true, true]);
        let mut found = Variable {
            aov: a.aov,
            mean: 0.0,
            largest: 0.0,
            largest_at_px: (0, 0),
            share: 0.0,
            differences: vec![0.0; seen.len()],
        };
        let (mut compared, mut different, mut sum) = (0_usize, 0_usize, 0.0);
        for (pixel, slot) in found.differences.iter_mut().enumerate().filter(|(pixel, _)| is_compared(*pixel)) {
            let difference = difference(a.aov, &a.samples, &b.samples, pixel);
            *slot = difference;
            compared += 1;
            sum += f64::from(difference);
            if difference > found.largest {
                (found.largest, found.largest_at_px) = (difference, (pixel % width, pixel / width));
            }
            if differs(pixel, difference) {
                different += 1;
                let index = match part(a.aov) {
                    ModelPart::Geometry => 0,
                    ModelPart::Material => 1,
                    ModelPart::Light => 2,
                    ModelPart::Neither => continue,
                };
                parts[pixel][index] = true;
            }
        }
        found.mean = sum / compared.max(1) as f64;
        found.share = different as f64 / compared.max(1) as f64;
        if models.listed.contains(&a.aov) {
            all.push(found);
        }
    }
    let (changed, only) = shares(&seen, &parts);
    Variables { all, changed, only }
}

fn shares(seen: &[[bool; 2]], parts: &[[bool; 3]]) -> (ChangeShares, [f64; 2]) {
    let (mut counts, mut only, mut either) = ([0_usize; 3], [0_usize; 2], 0_usize);
    for (seen, parts) in seen.iter().zip(parts) {
        let first = match seen {
            [false, false] => continue,
            [true, true] => parts.iter().position(|differs| *differs),
            [is_first, _] => {
                only[usize::from(!is_first)] += 1;
                Some(0)
            }
        };
        either += 1;
        first.into_iter().for_each(|index| counts[index] += 1);
    }
    let share = |count: usize| count as f64 / either.max(1) as f64;
    let [geometry, material, light] = counts.map(share);
    (ChangeShares { geometry, material, light }, only.map(share))
}

fn depths(layers: &[AovLayer]) -> Option<&[f32]> {
    layers.iter().find(|layer| layer.aov == Aov::Depth).and_then(|layer| match &layer.samples {
        Samples::Float { data, .. } => Some(&data[..]),
        Samples::Id(_) => None,
    })
}

/// The values of a pixel; none of ids.
fn values(samples: &Samples, pixel: usize) -> &[f32] {
    match samples {
        Samples::Float { components, data } => data.get(pixel * components..(pixel + 1) * components).unwrap_or(&[]),
        Samples::Id(_) => &[],
    }
}

/// The largest of the absolute values of a pixel.
fn magnitude(samples: &Samples, pixel: usize) -> f32 {
    values(samples, pixel).iter().fold(0.0, |largest, value| largest.max(value.abs()))
}

fn difference(aov: Aov, a: &Samples, b: &Samples, pixel: usize) -> f32 {
    if let (Samples::Id(a), Samples::Id(b)) = (a, b) {
        return f32::from(u8::from(a.get(pixel) != b.get(pixel)));
    }
    let (a, b) = (values(a, pixel), values(b, pixel));
    let pairs = || a.iter().zip(b).map(|(a, b)| f64::from(*a) - f64::from(*b));
    let distance = || pairs().map(|difference| difference * difference).sum::<f64>().sqrt();
    (match aov {
        // The angle of two vectors of length 1, by the chord between them.
        Aov::Normal | Aov::NormalView => 2.0 * (0.5 * distance()).min(1.0).asin().to_degrees(),
        Aov::Position | Aov::Motion => distance(),
        _ => pairs().fold(0.0, |largest: f64, difference| largest.max(difference.abs())),
    }) as f32
}

/// What rounding of the stored values can make of nothing. `magnitude` is the larger of both values.
fn tolerance(aov: Aov, magnitude: f32, radius_m: f32) -> f32 {
    match aov {
        // 16 bits of either angle.
        Aov::Normal | Aov::NormalView => 0.05,
        Aov::Position => 1e-4 * radius_m,
        Aov::Depth => 1e-4 * magnitude,
        // A tenth of the step from black.
        Aov::BaseColor => 3e-5,
        Aov::Occlusion | Aov::Metallic | Aov::Roughness => 0.5 / 255.0,
        Aov::OcclusionScreen => 2.0 / 255.0,
        // Half floats have eleven bits; lists of lights add in another order.
        Aov::Emission => 2e-3 * magnitude,
        Aov::Radiance => 1e-2 * magnitude,
        Aov::Motion => 0.01,
        Aov::ObjectId | Aov::MaterialId => 0.5,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_part_that_differs_counts() {
        let seen = [[true, true], [true, true], [true, true], [true, false], [false, false], [true, true]];
        let mut parts = [[false; 3]; 6];
        parts[0] = [true, true, true];
        parts[1] = [false, true, true];
        parts[2] = [false, false, true];
        let (changed, only) = shares(&seen, &parts);
        assert_eq!(changed, ChangeShares { geometry: 0.4, material: 0.2, light: 0.2 });
        assert_eq!(only, [0.2, 0.0]);
    }

    #[test]
    fn differences_have_the_units_that_are_said() {
        let floats = |data: &[f32]| Samples::Float { components: data.len(), data: data.to_vec() };
        let angle = difference(Aov::Normal, &floats(&[0.0, 0.0, 1.0]), &floats(&[0.0, 1.0, 0.0]), 0);
        assert!((angle - 90.0).abs() < 1e-4, "{angle}");
        let distance = difference(Aov::Position, &floats(&[0.0, 3.0, 0.0]), &floats(&[4.0, 0.0, 0.0]), 0);
        assert_eq!((distance, unit(Aov::Position)), (5.0, "m"));
        assert_eq!(difference(Aov::BaseColor, &floats(&[0.5, 0.25, 0.0]), &floats(&[0.375, 0.5, 0.0]), 0), 0.25);
        assert_eq!(difference(Aov::ObjectId, &Samples::Id(vec![1, 2]), &Samples::Id(vec![1, 3]), 1), 1.0);
    }
}
