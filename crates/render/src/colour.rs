//! The sRGB transfer functions (IEC 61966-2-1), of values from 0 to 1; the twin of `colour.wgsl`.

/// The encoded value of a linear one.
pub fn srgb_from_linear(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The linear value of an encoded one.
pub fn linear_from_srgb(srgb: f32) -> f32 {
    if srgb <= 0.04045 { srgb / 12.92 } else { ((srgb + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_comes_back() {
        for byte in 0..=255u8 {
            let srgb = f32::from(byte) / 255.0;
            assert_eq!((srgb_from_linear(linear_from_srgb(srgb)) * 255.0).round() as u8, byte);
        }
        // Mid grey.
        assert!((linear_from_srgb(0.5) - 0.214_041).abs() < 1e-6);
    }
}
