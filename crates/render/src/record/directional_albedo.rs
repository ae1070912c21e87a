//! The directional albedo of GGX (Karis 2013, "Real Shading in Unreal Engine 4") and of sheen: what surfaces reflect of
//! light from everywhere.
//!
//! The table is a file, so that no build waits for it and every machine has the same. `cargo xtask goldens` writes it
//! again; a test holds it to the integrals.

use crate::constants::DIRECTIONAL_ALBEDO_SIZE;

/// How many texels the table has.
const TEXELS: usize = (DIRECTIONAL_ALBEDO_SIZE * DIRECTIONAL_ALBEDO_SIZE) as usize;

/// Three floats a texel, the least significant byte first.
static TABLE: &[u8; TEXELS * 12] = include_bytes!("directional_albedo.bin");

/// Scale and bias of f0, and the albedo of sheen: n·v goes from 0 to 1 along a row, perceptual roughness from row to
/// row.
pub(super) fn table() -> impl Iterator<Item = [f32; 3]> {
    let (floats, _) = TABLE.as_chunks::<4>();
    let (texels, _) = floats.as_chunks::<3>();
    texels.iter().map(|texel| texel.map(f32::from_le_bytes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constants::ROUGHNESS_PERCEPTUAL_MIN;
    use std::f64::consts::{PI, TAU};

    /// Directions that are spread evenly (Hammersley): their error is below the step of the half floats that hold the
    /// table on a device.
    const POINTS: u32 = 4096;

    /// The angle around the normal, and a number from 0 to 1, of a direction.
    fn point(i: u32) -> (f64, f64) {
        (2.0 * PI * (f64::from(i) + 0.5) / f64::from(POINTS), f64::from(i.reverse_bits()) / 4_294_967_296.0)
    }

    /// The fit of shadowing in Estevez & Kulla 2017, "Production Friendly Microfacet Sheen BRDF"; as in `layers.wgsl`.
    fn sheen_shadowing(cosine: f64, alpha: f64) -> f64 {
        let share = (1.0 - alpha) * (1.0 - alpha);
        let mix = |rough: f64, smooth: f64| rough + (smooth - rough) * share;
        let (a, b, c) = (mix(21.5473, 25.3245), mix(3.82987, 3.32435), mix(0.19823, 0.16801));
        let (d, e) = (mix(-1.97760, -1.27393), mix(-4.32054, -4.85967));
        let curve = |x: f64| a / (1.0 + b * x.max(1e-6).powf(c)) + d * x + e;
        if cosine < 0.5 { curve(cosine).exp() } else { (2.0 * curve(0.5) - curve(1.0 - cosine)).exp() }
    }

    /// What sheen of a perceptual roughness reflects of light from everywhere.
    fn sheen_albedo(n_dot_v: f64, roughness: f64) -> f64 {
        let roughness = roughness.max(0.07);
        let alpha = roughness * roughness;
        let eye = [(1.0 - n_dot_v * n_dot_v).sqrt(), 0.0, n_dot_v];
        let light = |i: u32| {
            let (phi, u) = point(i);
            let n_dot_l = u.max(1e-3);
            let sine = (1.0 - n_dot_l * n_dot_l).sqrt();
            let sum = [eye[0] + sine * phi.cos(), sine * phi.sin(), eye[2] + n_dot_l];
            let length = sum.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-9);
            let n_dot_half = sum[2] / length;
            let sine_squared = (1.0 - n_dot_half * n_dot_half).max(1e-4);
            let distribution = (2.0 + 1.0 / alpha) * sine_squared.powf(0.5 / alpha) / TAU;
            let shadowing = 1.0 + sheen_shadowing(n_dot_v, alpha) + sheen_shadowing(n_dot_l, alpha);
            distribution / (shadowing * 4.0 * n_dot_l * n_dot_v).max(1e-5) * n_dot_l
        };
        (0..POINTS).map(light).sum::<f64>() * TAU / f64::from(POINTS)
    }

    /// Scale and bias of f0, by importance-sampling GGX with the height-correlated visibility of `brdf.wgsl`.
    fn ggx_albedo(n_dot_v: f64, roughness: f64) -> [f64; 2] {
        let alpha = roughness * roughness;
        let a2 = alpha * alpha;
        let eye = [(1.0 - n_dot_v * n_dot_v).sqrt(), 0.0, n_dot_v];
        let (mut scale, mut bias) = (0.0, 0.0);
        for i in 0..POINTS {
            let (phi, u) = point(i);
            let cos = ((1.0 - u) / (1.0 + (a2 - 1.0) * u)).sqrt();
            let sin = (1.0 - cos * cos).max(0.0).sqrt();
            let half = [sin * phi.cos(), sin * phi.sin(), cos];
            let v_dot_h = (eye[0] * half[0] + eye[2] * half[2]).max(0.0);
            let n_dot_l = 2.0 * v_dot_h * half[2] - eye[2];
            if n_dot_l > 0.0 {
                let light = n_dot_v * (n_dot_l * n_dot_l * (1.0 - a2) + a2).sqrt();
                let back = n_dot_l * (n_dot_v * n_dot_v * (1.0 - a2) + a2).sqrt();
                let weight = 0.5 / (light + back) * 4.0 * n_dot_l * v_dot_h / half[2].max(1e-9);
                let fresnel = (1.0 - v_dot_h).powi(5);
                scale += weight * (1.0 - fresnel);
                bias += weight * fresnel;
            }
        }
        [scale, bias].map(|sum| sum / f64::from(POINTS))
    }

    fn integrated(index: u32) -> [f32; 3] {
        let place = |at: u32| f64::from(at) / f64::from(DIRECTIONAL_ALBEDO_SIZE - 1);
        let (cosine, roughness) = (place(index % DIRECTIONAL_ALBEDO_SIZE), place(index / DIRECTIONAL_ALBEDO_SIZE));
        let n_dot_v = cosine.max(1e-4);
        let [scale, bias] = ggx_albedo(n_dot_v, roughness.max(ROUGHNESS_PERCEPTUAL_MIN.into()));
        [scale, bias, sheen_albedo(n_dot_v.max(1e-2), roughness).min(1.0)].map(|albedo| albedo as f32)
    }

    #[test]
    fn the_golden_table_of_directional_albedo_is_current() {
        let truth: Vec<[f32; 3]> = (0..TEXELS as u32).map(integrated).collect();
        // Sine, exponential and power are not the same to the last bit on all systems.
        let is_near = |(a, b): (f32, f32)| (a - b).abs() <= 1e-6;
        let is_current = table().zip(&truth).all(|(a, b)| a.into_iter().zip(*b).all(is_near));
        if !is_current && std::env::var_os("MANYPASS_GOLDENS").is_some_and(|value| value == "write") {
            let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/record/directional_albedo.bin");
            let bytes: Vec<u8> = truth.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
            return std::fs::write(path, bytes).expect("written");
        }
        assert!(is_current, "directional_albedo.bin differs from its integrals: run `cargo xtask goldens`");
    }
}
