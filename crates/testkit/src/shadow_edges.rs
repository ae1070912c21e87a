//! Where shadows end, in closed form.

use std::f64::consts::PI;

/// The width in metres of the penumbra that an edge `to_receiver_m` above a surface throws on it in the light of a
/// sphere of `radius_m`, `to_light_m` above the edge: 2 · radius · to_receiver / to_light. Of light from infinitely far
/// away, whose `radius_m` is the tangent of half its angle, `to_light_m` is 1.
pub fn penumbra_width_m(radius_m: f64, to_receiver_m: f64, to_light_m: f64) -> f64 {
    2.0 * radius_m * to_receiver_m / to_light_m
}

/// The share of a disc's area that a straight edge leaves, whose distance from the disc's middle is `offset` radii: 1
/// at 1, 0 at −1.
pub fn share_of_disc_beside(offset: f64) -> f64 {
    let offset = offset.clamp(-1.0, 1.0);
    1.0 - (offset.acos() - offset * (1.0 - offset * offset).sqrt()) / PI
}

/// The share of a light that is seen `beside_m` from the middle of the penumbra that [`penumbra_width_m`] describes,
/// positive towards the light.
pub fn visibility_beside_edge(beside_m: f64, radius_m: f64, to_receiver_m: f64, to_light_m: f64) -> f64 {
    share_of_disc_beside(2.0 * beside_m / penumbra_width_m(radius_m, to_receiver_m, to_light_m))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_of_a_disc_are_those_of_counting() {
        for offset in [-1.5, -1.0, -0.6, 0.0, 0.3, 0.9, 1.0, 2.0] {
            let cells = 1000;
            let (mut inside, mut left) = (0, 0);
            for cell in 0..cells * cells {
                let x = 2.0 * (f64::from(cell % cells) + 0.5) / f64::from(cells) - 1.0;
                let y = 2.0 * (f64::from(cell / cells) + 0.5) / f64::from(cells) - 1.0;
                inside += i32::from(x * x + y * y < 1.0);
                left += i32::from(x * x + y * y < 1.0 && x < offset);
            }
            let counted = f64::from(left) / f64::from(inside);
            assert!((share_of_disc_beside(offset) - counted).abs() < 2e-3, "{offset}");
        }
    }
}
