//! Variables as pictures that people can look at.

use manypass::Aov;
use manypass_offline::Samples;

/// The smallest and the largest finite value that two pictures of a variable have; (0, 1) where there are none.
pub fn range(pictures: [&Samples; 2]) -> (f32, f32) {
    let values = pictures.into_iter().filter_map(|samples| match samples {
        Samples::Float { data, .. } => Some(data.iter().copied()),
        Samples::Id(_) => None,
    });
    let finite = values.flatten().filter(|value| value.is_finite());
    let (low, high) = finite.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    if low < high {
        (low, high)
    } else if low == high {
        (low, low + 1.0)
    } else {
        (0.0, 1.0)
    }
}

/// A variable as opaque bytes of sRGB. Vectors of length 1 have grey for 0; places and distances go from `range`'s
/// smallest value to its largest, what is near being bright; radiance and emission are as a display shows them; every
/// id has a colour.
pub fn shown(aov: Aov, samples: &Samples, range: (f32, f32)) -> Vec<u8> {
    match samples {
        Samples::Id(ids) => ids.iter().flat_map(|id| opaque(id_color(*id))).collect(),
        Samples::Float { components, data } => {
            data.chunks_exact((*components).max(1)).flat_map(|values| opaque(color(aov, values, range))).collect()
        }
    }
}

/// A pixel without transparency.
pub const fn opaque([r, g, b]: [u8; 3]) -> [u8; 4] {
    [r, g, b, 255]
}

/// The byte of linear light on a display (IEC 61966-2-1).
pub fn srgb(linear: f32) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let value = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (value * 255.0).round() as u8
}

fn color(aov: Aov, values: &[f32], (low, high): (f32, f32)) -> [u8; 3] {
    let at = |index: usize| values.get(index).or(values.first()).copied().unwrap_or(0.0);
    let byte = |value: f32| (value.clamp(0.0, 1.0) * 255.0).round() as u8;
    let place = |value: f32| (value - low) / (high - low);
    std::array::from_fn(|index| match aov {
        Aov::BaseColor | Aov::Emission | Aov::Radiance => srgb(at(index)),
        Aov::Normal | Aov::NormalView => byte(0.5 + 0.5 * at(index)),
        // What is farthest is brighter than what is not there.
        Aov::Depth => byte(1.0 - 0.85 * place(at(0))),
        Aov::Position => byte(place(at(index))),
        Aov::Motion => byte(if index < 2 { place(at(index)) } else { 0.0 }),
        _ => byte(at(index)),
    })
}

/// A colour that other ids hardly have; black for nothing.
fn id_color(id: u32) -> [u8; 3] {
    // The golden ratio's multiples lie apart whatever their number (Knuth 1998, 6.4).
    let hash = id.wrapping_mul(0x9e37_79b9);
    if id == 0 { [0; 3] } else { [24, 16, 8].map(|shift| 64 + (hash >> shift & 0xff) as u8 / 4 * 3) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_become_the_colours_that_are_said() {
        let floats = |components: usize, data: &[f32]| Samples::Float { components, data: data.to_vec() };
        let (near, far) = (floats(1, &[1.0, f32::INFINITY]), floats(1, &[3.0, 2.0]));
        assert_eq!(range([&near, &far]), (1.0, 3.0));
        assert_eq!(shown(Aov::Depth, &near, (1.0, 3.0)), [255, 255, 255, 255, 0, 0, 0, 255]);
        assert_eq!(shown(Aov::Normal, &floats(3, &[0.0, 1.0, -1.0]), (0.0, 1.0)), [128, 255, 0, 255]);
        assert_eq!(shown(Aov::BaseColor, &floats(3, &[1.0, 0.0, 0.214]), (0.0, 1.0)), [255, 0, 127, 255]);
        assert_eq!(range([&floats(1, &[]), &Samples::Id(vec![1])]), (0.0, 1.0));
        let ids = shown(Aov::ObjectId, &Samples::Id(vec![0, 1, 2]), (0.0, 1.0));
        assert!(ids[..3] == [0; 3] && ids[4..7] != ids[8..11], "{ids:?}");
    }
}
