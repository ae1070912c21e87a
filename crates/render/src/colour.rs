//! The sRGB transfer functions (IEC 61966-2-1), of values from 0 to 1, the twin of `colour.wgsl`; and products that
//! stay numbers.

use crate::constants::{SRGB_ENCODED_END, SRGB_LINEAR_END, SRGB_OFFSET, SRGB_POWER, SRGB_SLOPE};

/// The encoded value of a linear one.
pub fn srgb_from_linear(linear: f32) -> f32 {
    if linear <= SRGB_LINEAR_END {
        SRGB_SLOPE * linear
    } else {
        (1.0 + SRGB_OFFSET) * linear.powf(1.0 / SRGB_POWER) - SRGB_OFFSET
    }
}

/// The linear value of an encoded one.
pub fn linear_from_srgb(srgb: f32) -> f32 {
    if srgb <= SRGB_ENCODED_END {
        srgb / SRGB_SLOPE
    } else {
        ((srgb + SRGB_OFFSET) / (1.0 + SRGB_OFFSET)).powf(SRGB_POWER)
    }
}

/// The product, within what a shader can go on multiplying with: infinity times 0 is no number, and a NaN stays one.
pub(crate) fn finite_product(a: f32, b: f32) -> f32 {
    let product = a * b;
    if product.is_nan() { 0.0 } else { product.clamp(-1e30, 1e30) }
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
