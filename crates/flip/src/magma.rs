//! The colours that maps of errors are shown in.

/// Every fifteenth of the 256 colours of the map *magma* (Smith and van der Walt 2015, dedicated to the public under
/// CC0), sRGB. Straight lines between them are within 3 of 255 levels of the others.
const COLOURS_SRGB: [[u8; 3]; 18] = [
    [0, 0, 4],
    [9, 7, 32],
    [26, 16, 66],
    [49, 17, 101],
    [74, 16, 121],
    [98, 25, 128],
    [121, 34, 130],
    [145, 43, 129],
    [170, 51, 125],
    [194, 59, 117],
    [217, 70, 107],
    [236, 88, 96],
    [247, 114, 92],
    [252, 142, 100],
    [254, 170, 116],
    [254, 198, 138],
    [253, 226, 163],
    [252, 253, 191],
];

/// The sRGB colour of an error, from nearly black at 0 to a bright yellow at 1; lightness grows evenly.
pub fn magma(error: f32) -> [u8; 3] {
    let last = COLOURS_SRGB.len() - 1;
    let place = error.clamp(0.0, 1.0) * last as f32;
    let index = (place as usize).min(last - 1);
    let part = place - index as f32;
    let (below, above) = (COLOURS_SRGB[index], COLOURS_SRGB[index + 1]);
    std::array::from_fn(|c| (f32::from(below[c]) * (1.0 - part) + f32::from(above[c]) * part).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn larger_errors_are_lighter() {
        assert_eq!((magma(-1.0), magma(0.0)), ([0, 0, 4], [0, 0, 4]));
        assert_eq!((magma(1.0), magma(7.0)), ([252, 253, 191], [252, 253, 191]));
        let luma = |error: u8| {
            let [r, g, b] = magma(f32::from(error) / 50.0).map(f32::from);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        assert!((1..=50).all(|error| luma(error) > luma(error - 1)));
    }
}
