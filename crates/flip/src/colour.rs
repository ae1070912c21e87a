//! Spaces of colour: linear sRGB, XYZ relative to white, YyCxCz (Kolpatzik and Bouman 1992), CIELAB (CIE 1976).

/// CIE XYZ of the primaries of sRGB and white D65 (IEC 61966-2-1), solved for chromaticities (0.64, 0.33), (0.30,
/// 0.60), (0.15, 0.06) and (0.3127, 0.3290); as in CSS Color 4.
const XYZ_FROM_RGB: [[f32; 3]; 3] = [
    [0.412_390_8, 0.357_584_33, 0.180_480_8],
    [0.212_639, 0.715_168_7, 0.072_192_32],
    [0.019_330_818, 0.119_194_78, 0.950_532_14],
];

/// XYZ of red, green and blue at 1: the reference white of both opponent spaces.
const WHITE_XYZ: [f32; 3] = [0.950_455_9, 1.0, 1.089_057_8];

/// The inverse of [`XYZ_FROM_RGB`].
const RGB_FROM_XYZ: [[f32; 3]; 3] = [
    [3.240_97, -1.537_383_2, -0.498_610_76],
    [-0.969_243_65, 1.875_967_5, 0.041_555_06],
    [0.055_630_08, -0.203_976_96, 1.056_971_5],
];

fn product(matrix: &[[f32; 3]; 3], [x, y, z]: [f32; 3]) -> [f32; 3] {
    matrix.map(|[a, b, c]| a * x + b * y + c * z)
}

/// Linear light of an sRGB value (IEC 61966-2-1); what is below 0 stays linear.
pub fn linear_from_srgb(value: f32) -> f32 {
    if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

/// The luminance of linear red, green and blue.
pub fn luminance(rgb_linear: [f32; 3]) -> f32 {
    let [r, g, b] = rgb_linear;
    let [kr, kg, kb] = XYZ_FROM_RGB[1];
    kr * r + kg * g + kb * b
}

/// XYZ in units of white's.
fn relative_xyz_from_rgb(rgb_linear: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = product(&XYZ_FROM_RGB, rgb_linear);
    [x * (1.0 / WHITE_XYZ[0]), y * (1.0 / WHITE_XYZ[1]), z * (1.0 / WHITE_XYZ[2])]
}

/// Luminance, red against green and blue against yellow, linear in light: white is (100, 0, 0).
pub fn ycxcz_from_rgb(rgb_linear: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = relative_xyz_from_rgb(rgb_linear);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// The inverse of [`ycxcz_from_rgb`].
pub fn rgb_from_ycxcz([luma, red_green, blue_yellow]: [f32; 3]) -> [f32; 3] {
    let y = (luma + 16.0) / 116.0;
    let (x, z) = (y + red_green / 500.0, y - blue_yellow / 200.0);
    product(&RGB_FROM_XYZ, [x * WHITE_XYZ[0], y * WHITE_XYZ[1], z * WHITE_XYZ[2]])
}

/// CIELAB, its two axes of colour multiplied by L* / 100: colour is seen the less, the darker it is (the Hunt effect).
pub fn hunt_lab_from_rgb(rgb_linear: [f32; 3]) -> [f32; 3] {
    // Where the cube root would become too steep CIELAB goes on in a straight line.
    let f = |t: f32| {
        const DELTA: f32 = 6.0 / 29.0;
        if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    };
    let [x, y, z] = relative_xyz_from_rgb(rgb_linear).map(f);
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)]
}

/// The distance HyAB, made for large differences (Abasi, Tehran and Fairchild 2020): by steps in lightness, straight in
/// colour.
pub fn hyab(a: [f32; 3], b: [f32; 3]) -> f32 {
    let colour = [a[1] - b[1], a[2] - b[2]];
    (a[0] - b[0]).abs() + (colour[0] * colour[0] + colour[1] * colour[1]).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_is_where_the_spaces_put_it() {
        for (found, expected) in [(ycxcz_from_rgb([1.0; 3]), 100.0), (hunt_lab_from_rgb([1.0; 3]), 100.0)] {
            assert!((found[0] - expected).abs() < 1e-3 && found[1].abs() < 1e-3 && found[2].abs() < 1e-3, "{found:?}");
        }
        let black = hunt_lab_from_rgb([0.0; 3]);
        assert!(black.iter().all(|value| value.abs() < 1e-4), "{black:?}");
        assert!((luminance([1.0; 3]) - 1.0).abs() < 1e-6);
        // Red of sRGB in CIELAB is (53.24, 80.09, 67.20) as everybody prints it.
        let red = hunt_lab_from_rgb([1.0, 0.0, 0.0]);
        let expected = [53.24, 0.5324 * 80.09, 0.5324 * 67.20];
        assert!(red.iter().zip(expected).all(|(a, b): (&f32, f32)| (a - b).abs() < 0.05), "{red:?}");
    }

    #[test]
    fn the_opponent_space_goes_there_and_back() {
        for rgb in [[0.2, 0.7, 0.1], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.01, 0.02, 0.03]] {
            let back = rgb_from_ycxcz(ycxcz_from_rgb(rgb));
            assert!(back.iter().zip(rgb).all(|(a, b): (&f32, f32)| (a - b).abs() < 1e-5), "{rgb:?}: {back:?}");
        }
        assert!((linear_from_srgb(0.5) - 0.214_041).abs() < 1e-5 && (linear_from_srgb(1.0) - 1.0).abs() < 1e-6);
    }
}
