//! The directional albedo of GGX (Karis 2013, "Real Shading in Unreal Engine 4") and of sheen: what surfaces reflect of
//! light from everywhere.
//!
//! The table is a file, so that no build waits for it and every machine has the same. `cargo xtask goldens` writes it
//! again; a test holds it to the integrals.

use crate::constants::DIRECTIONAL_ALBEDO_SIZE;
use manypass_scene::environment::BrdfTable;

/// How many texels the table has.
const TEXELS: usize = (DIRECTIONAL_ALBEDO_SIZE * DIRECTIONAL_ALBEDO_SIZE) as usize;

/// Three floats a texel, the least significant byte first.
static TABLE: &[u8; TEXELS * 12] = include_bytes!("directional_albedo.bin");

/// Scale and bias of f0, and the albedo of sheen: n·v goes from 0 to 1 along a row, perceptual roughness from row to
/// row.
fn table() -> impl Iterator<Item = [f32; 3]> {
    let (floats, _) = TABLE.as_chunks::<4>();
    let (texels, _) = floats.as_chunks::<3>();
    texels.iter().map(|texel| texel.map(f32::from_le_bytes))
}

/// The table as half floats, which every backend can filter, four a texel; scale and bias are those of
/// `brdf` if there is one.
pub(crate) fn directional_albedo_texels(brdf: Option<&BrdfTable>) -> Vec<u16> {
    let last = DIRECTIONAL_ALBEDO_SIZE - 1;
    let place = |at: u32| at as f32 / last as f32;
    let texel = |(index, [scale, bias, sheen]): (u32, [f32; 3])| {
        let (column, row) = (index % DIRECTIONAL_ALBEDO_SIZE, index / DIRECTIONAL_ALBEDO_SIZE);
        let [scale, bias] = brdf.map_or([scale, bias], |brdf| brdf.at(place(column), place(row)));
        [scale, bias, sheen, 0.0].map(half_from_unit)
    };
    (0..).zip(table()).flat_map(texel).collect()
}

/// A half float of a value from 0 to 2, rounded to nearest; values below 2⁻¹⁴ become denormal.
fn half_from_unit(value: f32) -> u16 {
    let bits = value.max(0.0).to_bits();
    let exponent = (bits >> 23) as i32 - 127 + 15;
    if exponent <= 0 {
        return (value * 16_777_216.0).round() as u16;
    }
    let rounded = (bits & 0x7f_ffff) + 0x1000;
    (((exponent as u32) << 10) + (rounded >> 13)) as u16
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constants::ROUGHNESS_PERCEPTUAL_MIN;
    use half::f16;
    use manypass_testkit::radiance_file::RadiancePicture;
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
            let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/resources/directional_albedo.bin");
            let bytes: Vec<u8> = truth.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
            return std::fs::write(path, bytes).expect("written");
        }
        assert!(is_current, "directional_albedo.bin differs from its integrals: run `cargo xtask goldens`");
    }

    /// Our own table as a file of 256 by 256 texels.
    fn exported() -> BrdfTable {
        const SIDE: usize = 256;
        let (own, last) = (Vec::from_iter(table()), DIRECTIONAL_ALBEDO_SIZE as usize - 1);
        let texel = |i: usize| {
            let place = |at: usize| (at as f32 + 0.5) / SIDE as f32 * last as f32;
            let (x, y) = (place(i % SIDE), place(i / SIDE));
            let at = |x: usize, y: usize| own[y * (last + 1) + x];
            [0, 1, 2].map(|channel: usize| {
                let (left, top) = (x as usize, y as usize);
                let [above, below] = [top, top + 1].map(|row| {
                    let [a, b] = [left, left + 1].map(|column| at(column, row)[channel]);
                    a + (b - a) * x.fract()
                });
                above + (below - above) * y.fract()
            })
        };
        let pixels = (0..SIDE * SIDE).map(texel).collect();
        let bytes = RadiancePicture { width: SIDE, height: SIDE, pixels }.to_exr();
        BrdfTable::decode("own.exr", &bytes).expect("a table")
    }

    #[test]
    fn a_file_of_our_own_table_is_our_own_table() {
        let [own, read] = [None, Some(&exported())].map(directional_albedo_texels);
        let value = |bits: &u16| f16::from_bits(*bits).to_f32();
        let worst = own.iter().zip(&read).map(|(a, b)| (value(a) - value(b)).abs()).fold(0.0, f32::max);
        // A step of a byte. Our table has corners, where its texels are, which lie between those of the file.
        assert!(own.len() == read.len() && worst < 1.0 / 255.0, "{worst}");
        let flat = BrdfTable::decode("flat.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x40\0\x81");
        let flat = directional_albedo_texels(Some(&flat.expect("a table")));
        let is_kept = |(of_file, own): (&[u16], &[u16])| {
            [value(&of_file[0]), value(&of_file[1])] == [1.0, 0.5] && of_file[2..] == own[2..]
        };
        assert!(flat.chunks_exact(4).zip(own.chunks_exact(4)).all(is_kept), "the sheen stays our own");
    }
}
