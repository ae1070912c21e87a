//! Filters: what turns elements as they are packed into those that accessors read, in place.

use meshoptimizer_rs::{Error, Workspace, codec};

/// How elements are stored before they are packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Filter {
    /// Unit vectors, folded onto an octahedron (Meyer et al. 2010), of 4 or 8 bytes.
    Octahedral,
    /// Rotations by their three smaller components, of 8 bytes.
    Quaternion,
    /// Floats as an integer of 24 bits and an exponent of 8.
    Exponential,
    /// Colours as brightness and two differences, of 4 or 8 bytes.
    Color,
}

/// Turns `elements` of `stride` bytes into those that they stand for.
///
/// # Errors
/// One of them is a direction of no length, or a colour of no bits, which no encoder writes.
pub(super) fn apply(
    filter: Filter,
    elements: &mut [u8],
    stride: usize,
    workspace: &mut Workspace,
) -> Result<(), Error> {
    let decode = match filter {
        Filter::Octahedral => codec::decode_filter_oct,
        Filter::Quaternion => codec::decode_filter_quat,
        Filter::Exponential => codec::decode_filter_exp,
        Filter::Color => codec::decode_filter_color,
    };
    decode(elements, elements.len() / stride, stride, workspace)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn applied(filter: Filter, elements: &mut [u8], stride: usize) {
        apply(filter, elements, stride, &mut Workspace::default()).expect("what encoders write");
    }

    #[test]
    fn directions_of_no_length_are_refused() {
        let mut bytes = [0; 8];
        assert!(apply(Filter::Octahedral, &mut bytes, 4, &mut Workspace::default()).is_err());
    }

    /// Unit vectors all around.
    fn directions() -> impl Iterator<Item = [f32; 3]> {
        (0..24).flat_map(|i| {
            let (sin_theta, cos_theta) = (0.13 + 0.127 * i as f32).sin_cos();
            (0..48).map(move |j| {
                let (sin_phi, cos_phi) = (0.05 + 0.131 * j as f32).sin_cos();
                [sin_theta * cos_phi, sin_theta * sin_phi, cos_theta]
            })
        })
    }

    #[test]
    fn directions_come_back_within_their_bits() {
        for (stride, bits) in [(4, 8), (4, 6), (8, 8), (8, 12), (8, 16)] {
            let one = ((1_i32 << (bits - 1)) - 1) as f32;
            let full = if stride == 4 { 127.0 } else { 32767.0 };
            for [x, y, z] in directions() {
                // As Meyer et al. fold it.
                let sum = x.abs() + y.abs() + z.abs();
                let (mut u, mut v) = (x / sum, y / sum);
                if z < 0.0 {
                    (u, v) = ((1.0 - v.abs()).copysign(u), (1.0 - u.abs()).copysign(v));
                }
                let packed = [u * one, v * one, one, 77.0].map(|component| component.round() as i16);
                let mut bytes: Vec<u8> = if stride == 4 {
                    packed.iter().map(|component| *component as u8).collect()
                } else {
                    packed.iter().flat_map(|component| component.to_le_bytes()).collect()
                };
                applied(Filter::Octahedral, &mut bytes, stride);
                let read = |i: usize| match stride {
                    4 => f32::from(bytes[i] as i8),
                    _ => f32::from(i16::from_le_bytes([bytes[2 * i], bytes[2 * i + 1]])),
                };
                let error = (0..3).map(|i| (read(i) / full - [x, y, z][i]).abs()).fold(0.0, f32::max);
                // Half a step in both coordinates is a whole one in the third, on a face that is 1/√3 away.
                assert!(error < 1.74 / one + 0.51 / full, "{bits} bits: {x} {y} {z} is off by {error}");
                assert_eq!(read(3), 77.0);
            }
        }
    }

    #[test]
    fn rotations_come_back_within_their_bits() {
        for bits in [4, 8, 12, 16] {
            let one = ((1_i32 << (bits - 1)) - 1) as f32;
            for ([x, y, z], angle) in directions().zip((0..).map(|i| 0.3 + 0.01 * i as f32)) {
                let (sin, cos) = angle.sin_cos();
                let rotation = [x * sin, y * sin, z * sin, cos];
                let largest = (0..4).max_by(|&a, &b| rotation[a].abs().total_cmp(&rotation[b].abs())).unwrap_or(0);
                let sign = rotation[largest].signum();
                let store = |i: usize| (rotation[(largest + i) % 4] * sign * 2_f32.sqrt() * one).round() as i16;
                let code = (one as i16 & !3) | largest as i16;
                let mut bytes: Vec<u8> =
                    [store(1), store(2), store(3), code].into_iter().flat_map(i16::to_le_bytes).collect();
                applied(Filter::Quaternion, &mut bytes, 8);
                for (found, expected) in bytes.as_chunks().0.iter().zip(rotation) {
                    let found = f32::from(i16::from_le_bytes(*found)) / 32767.0;
                    // The largest component takes up the errors of the three others.
                    assert!((found - expected * sign).abs() < 1.8 / one + 1e-4, "{bits} bits: {found} {expected}");
                }
            }
        }
    }

    #[test]
    fn numbers_with_exponents_and_colours_are_exact() {
        for (exponent, mantissa) in [(0_i32, 5_i32), (3, -7), (-20, 8_388_607), (-100, -8_388_608), (100, 1), (-12, 0)]
        {
            let mut bytes = ((exponent << 24) | (mantissa & 0xff_ffff)).to_le_bytes();
            applied(Filter::Exponential, &mut bytes, 4);
            assert_eq!(f32::from_le_bytes(bytes), mantissa as f32 * 2_f32.powi(exponent));
        }
        // Multiples of four are brightness and differences without a remainder.
        for [red, green, blue] in [[0_i32, 0, 0], [252, 252, 252], [252, 0, 0], [4, 128, 200], [0, 252, 0], [0, 4, 252]]
        {
            let (y, co, cg) = ((red + 2 * green + blue) / 4, (red - blue) / 2, (2 * green - red - blue) / 4);
            let mut bytes = [y as u8, co as u8, cg as u8, 0x80 | 0x55];
            if (-128..128).contains(&co) {
                applied(Filter::Color, &mut bytes, 4);
                assert_eq!(bytes, [red as u8, green as u8, blue as u8, 0xab]);
            }
            let mut wide: Vec<u8> =
                [y, co, cg, 0x80 | 0x55].into_iter().flat_map(|component| (component as i16).to_le_bytes()).collect();
            applied(Filter::Color, &mut wide, 8);
            let found: Vec<u16> = wide.as_chunks().0.iter().map(|bytes| u16::from_le_bytes(*bytes)).collect();
            assert_eq!(found, [red, green, blue, 0xab].map(|component| component as u16 * 257));
        }
    }
}
