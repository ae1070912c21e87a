//! Points that are spread evenly, and directions made of them.
//!
//! Everything here is a function of whole numbers, so that a bake gives the same bytes whoever computes which part of it.

use glam::{Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// A hash of 32 bits with good avalanche (the finaliser of MurmurHash3, Appleby 2011).
pub(crate) fn hash(mut value: u32) -> u32 {
    value = (value ^ (value >> 16)).wrapping_mul(0x85eb_ca6b);
    value = (value ^ (value >> 13)).wrapping_mul(0xc2b2_ae35);
    value ^ (value >> 16)
}

/// A hash of two numbers.
pub(crate) fn hash2(a: u32, b: u32) -> u32 {
    hash(a.wrapping_mul(0x9e37_79b9) ^ hash(b).wrapping_add(0x7feb_352d))
}

/// A permutation in which a bit depends on itself and lower ones alone (Laine & Karras 2011, with the constants of
/// Burley 2020, "Practical Hash-based Owen Scrambling").
fn laine_karras(mut bits: u32, seed: u32) -> u32 {
    bits = bits.wrapping_add(seed);
    bits ^= bits.wrapping_mul(0x6c50_b47c);
    bits ^= bits.wrapping_mul(0xb82f_1e52);
    bits ^= bits.wrapping_mul(0xc7af_e638);
    bits ^ bits.wrapping_mul(0x8d22_f6e6)
}

fn owen_scramble(bits: u32, seed: u32) -> u32 {
    laine_karras(bits.reverse_bits(), seed).reverse_bits()
}

/// The second dimension of Sobol's sequence.
fn sobol_second(mut index: u32) -> u32 {
    let (mut result, mut direction) = (0, 1u32 << 31);
    while index != 0 {
        if index & 1 != 0 {
            result ^= direction;
        }
        index >>= 1;
        direction ^= direction >> 1;
    }
    result
}

fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 / (1u32 << 24) as f32
}

/// The point of a number in the unit square, of a sequence that is another one for every seed: Sobol's, scrambled after
/// Owen and in another order (Burley 2020).
pub(crate) fn point(index: u32, seed: u32) -> Vec2 {
    let shuffled = owen_scramble(index, seed);
    let first = owen_scramble(shuffled.reverse_bits(), hash2(seed, 1));
    let second = owen_scramble(sobol_second(shuffled), hash2(seed, 2));
    Vec2::new(unit(first), unit(second))
}

/// Two directions across a unit vector and each other (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
pub(crate) fn across(normal: Vec3) -> [Vec3; 2] {
    let sign = 1f32.copysign(normal.z);
    let a = -1.0 / (sign + normal.z);
    let b = normal.x * normal.y * a;
    [
        Vec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
        Vec3::new(b, sign + normal.y * normal.y * a, -normal.y),
    ]
}

/// A direction about a normal, as dense as the cosine of its angle: its density is that cosine divided by π.
pub(crate) fn cosine_direction(normal: Vec3, point: Vec2) -> Vec3 {
    let [tangent, bitangent] = across(normal);
    let (sin, cos) = (TAU * point.x).sin_cos();
    let radius = point.y.sqrt();
    (tangent * (radius * cos) + bitangent * (radius * sin) + normal * (1.0 - point.y).max(0.0).sqrt()).normalize()
}

/// A direction, all of which are as likely.
pub(crate) fn even_direction(point: Vec2) -> Vec3 {
    let (z, (sin, cos)) = (1.0 - 2.0 * point.x, (TAU * point.y).sin_cos());
    let radius = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(radius * cos, radius * sin, z)
}

/// The density of [`cosine_direction`] for the cosine of an angle.
pub(crate) fn cosine_density(cosine: f32) -> f32 {
    cosine.max(0.0) / PI
}

/// What a sample of a density counts where as many were drawn of another one (Veach & Guibas 1995, the balance
/// heuristic).
pub(crate) fn balance(density: f32, other: f32) -> f32 {
    if density > 0.0 { density / (density + other) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_power_of_two_points_are_spread_over_all_boxes() {
        for seed in [0, 1, 77, u32::MAX] {
            for bits in 0..=6 {
                let (columns, rows) = (1u32 << bits, 1u32 << (6 - bits));
                let mut seen = vec![0; 64];
                for index in 0..64 {
                    let place = point(index, seed);
                    assert!((0.0..1.0).contains(&place.x) && (0.0..1.0).contains(&place.y));
                    let cell = (place.x * columns as f32) as u32 * rows + (place.y * rows as f32) as u32;
                    seen[cell as usize] += 1;
                }
                assert!(seen.iter().all(|count| *count == 1), "{seed} {bits}: {seen:?}");
            }
        }
    }

    #[test]
    fn directions_are_as_dense_as_their_cosine() {
        let normal = Vec3::new(0.3, -0.9, -0.2).normalize();
        let count = 4096;
        let mean: Vec3 = (0..count).map(|index| cosine_direction(normal, point(index, 5))).sum::<Vec3>() / count as f32;
        // The mean of cosines of that density is 2 / 3.
        assert!((mean - normal * (2.0 / 3.0)).length() < 1e-3, "{mean}");
        let mean: Vec3 = (0..count).map(|index| even_direction(point(index, 5))).sum::<Vec3>() / count as f32;
        assert!(mean.length() < 2e-3, "{mean}");
    }
}
