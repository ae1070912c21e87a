//! Light from all directions as spherical harmonics of order 2, and as an ambient cube.

use glam::Vec3;
use std::f32::consts::PI;

/// The real spherical harmonics up to order 2 of a unit direction, in the order of Ramamoorthi & Hanrahan 2001, "An
/// Efficient Representation for Irradiance Environment Maps": 1, y, z, x, xy, yz, 3 z² − 1, xz, x² − y².
pub fn harmonics(direction: Vec3) -> [f32; 9] {
    let Vec3 { x, y, z } = direction;
    let of = [1.0, y, z, x, x * y, y * z, 3.0 * z * z - 1.0, x * z, x * x - y * y];
    std::array::from_fn(|at| SCALES[at] * of[at])
}

/// What makes the square of each integrate to 1 over all directions.
const SCALES: [f32; 9] = [
    0.282_094_8,
    0.488_602_5,
    0.488_602_5,
    0.488_602_5,
    1.092_548_4,
    1.092_548_4,
    0.315_391_57,
    1.092_548_4,
    0.546_274_2,
];

/// The order of each.
const ORDERS: [usize; 9] = [0, 1, 1, 1, 2, 2, 2, 2, 2];

/// What a cosine lobe leaves of each order, divided by π.
const COSINE: [f32; 3] = [1.0, 2.0 / 3.0, 0.25];

/// So many directions are looked at, spread evenly.
const DIRECTIONS: usize = 256;

/// Directions that are spread evenly over the sphere, on a spiral that turns by the golden angle.
fn spread_directions() -> impl Iterator<Item = Vec3> {
    (0..DIRECTIONS).map(|index| {
        let y = 1.0 - (2 * index + 1) as f32 / DIRECTIONS as f32;
        let radius = (1.0 - y * y).max(0.0).sqrt();
        let (sin, cos) = (index as f32 * 2.399_963_2).sin_cos();
        Vec3::new(radius * cos, y, radius * sin)
    })
}

/// Radiance from all directions as coefficients of [`harmonics`], for each of red, green and blue.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Harmonics(pub [Vec3; 9]);

impl Harmonics {
    /// Adds radiance from a unit direction, times the solid angle in steradians that it stands for.
    pub fn add(&mut self, direction: Vec3, radiance: Vec3) {
        let basis = harmonics(direction);
        self.0.iter_mut().zip(basis).for_each(|(sum, basis)| *sum += radiance * basis);
    }

    /// The coefficients by which irradiance divided by π is a sum of 1, y, z, x, xy, yz, 3 z² − 1, xz and x² − y² of the
    /// normal.
    pub fn irradiance_polynomial(&self) -> [Vec3; 9] {
        std::array::from_fn(|at| self.0[at] * (SCALES[at] * COSINE[ORDERS[at]]))
    }

    /// The light that has such a polynomial.
    pub fn of_irradiance_polynomial(polynomial: &[Vec3; 9]) -> Self {
        Self(std::array::from_fn(|at| polynomial[at] / (SCALES[at] * COSINE[ORDERS[at]])))
    }

    /// Irradiance divided by π on a surface with a unit normal: what a white surface sends back. Not below 0.
    pub fn irradiance(&self, normal: Vec3) -> Vec3 {
        self.unbounded(normal).max(Vec3::ZERO)
    }

    fn unbounded(&self, normal: Vec3) -> Vec3 {
        let basis = harmonics(normal);
        (0..9).map(|at| self.0[at] * (basis[at] * COSINE[ORDERS[at]])).sum()
    }

    /// What a window of a strength leaves of each order. Of windows that the light of a single point needs to be lit nowhere
    /// below 0, this one leaves most of orders 1 and 2: 0.87 and 0.76.
    pub fn window(strength: f32, order: usize) -> f32 {
        1.0 / (1.0 + strength * order as f32)
    }

    /// The strength of the weakest window under which irradiance is nowhere below 0: 0 for light that is spread widely, 0.16
    /// at the most, where all of it comes from one small source (found for each light, after Sloan 2017, "Deringing
    /// Spherical Harmonics").
    pub fn window_strength(&self) -> f32 {
        // Under it even the light of a single point is nowhere below 0.
        const STRENGTH_MAX: f32 = 0.16;
        let is_dark_somewhere = |strength: f32| {
            let windowed = self.windowed_by(strength);
            let least = 1e-4 * windowed.0[0].abs().max_element() * SCALES[0];
            spread_directions().any(|normal| windowed.unbounded(normal).min_element() < -least)
        };
        if !is_dark_somewhere(0.0) {
            return 0.0;
        }
        let (mut weak, mut strong) = (0.0, STRENGTH_MAX);
        for _ in 0..10 {
            let middle = 0.5 * (weak + strong);
            if is_dark_somewhere(middle) { weak = middle } else { strong = middle }
        }
        strong
    }

    fn windowed_by(&self, strength: f32) -> Self {
        Self(std::array::from_fn(|at| self.0[at] * Self::window(strength, ORDERS[at])))
    }

    /// The same under the weakest window that keeps irradiance from ringing below 0.
    pub fn windowed(&self) -> Self {
        let strength = self.window_strength();
        if strength > 0.0 { self.windowed_by(strength) } else { *self }
    }
}

/// Irradiance divided by π as six colours, those of surfaces that face +X, −X, +Y, −Y, +Z and −Z: between them it is their
/// mean by the squares of the normal (McTaggart 2004, "Half-Life 2 / Valve Source Shading").
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AmbientCube(pub [Vec3; 6]);

impl AmbientCube {
    /// The cube that is nearest to the irradiance of light, by the mean of squares over all normals.
    pub fn of(light: &Harmonics) -> Self {
        // The integrals of products of two of the six squares: of one with itself 2 π / 5, with the opposite one 0, with
        // another π / 15. Divided by π / 15, the six equations are 6 a + (b + b' + c + c') = right.
        let mut right = [Vec3::ZERO; 6];
        let solid_angle = 4.0 * PI / DIRECTIONS as f32;
        for normal in spread_directions() {
            let irradiance = light.unbounded(normal) * (solid_angle * 15.0 / PI);
            Self::shares(normal).into_iter().zip(&mut right).for_each(|(share, sum)| *sum += irradiance * share);
        }
        // Of one axis the difference is right / 6, and the sums of the three axes S follow from 6 S + 2 (S' + S'') = R.
        let sums: [Vec3; 3] = std::array::from_fn(|axis| right[2 * axis] + right[2 * axis + 1]);
        let all = (sums[0] + sums[1] + sums[2]) / 10.0;
        Self(std::array::from_fn(|at| {
            let sum = (sums[at / 2] - 2.0 * all) / 4.0;
            let difference = (right[at] - right[at ^ 1]) / 6.0;
            (0.5 * (sum + difference)).max(Vec3::ZERO)
        }))
    }

    /// What each colour counts for a unit normal.
    fn shares(normal: Vec3) -> [f32; 6] {
        let squares = (normal * normal).to_array();
        let is_ahead = normal.cmpge(Vec3::ZERO);
        let is_ahead = [is_ahead.x, is_ahead.y, is_ahead.z];
        std::array::from_fn(|at| if is_ahead[at / 2] == (at % 2 == 0) { squares[at / 2] } else { 0.0 })
    }

    /// Irradiance divided by π on a surface with a unit normal.
    pub fn irradiance(&self, normal: Vec3) -> Vec3 {
        Self::shares(normal).into_iter().zip(self.0).map(|(share, color)| color * share).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Light whose radiance a function says, summed over many directions.
    fn light(radiance: impl Fn(Vec3) -> f32) -> Harmonics {
        let count = 20_000u32;
        let mut light = Harmonics::default();
        for index in 0..count {
            let y = 1.0 - (2.0 * index as f32 + 1.0) / count as f32;
            let radius = (1.0 - y * y).max(0.0).sqrt();
            let (sin, cos) = (f64::from(index) * 2.399_963_229_728_653).sin_cos();
            let direction = Vec3::new(radius * cos as f32, y, radius * sin as f32);
            light.add(direction, Vec3::splat(radiance(direction) * 4.0 * PI / count as f32));
        }
        light
    }

    fn normals() -> Vec<Vec3> {
        spread_directions().chain([Vec3::X, Vec3::NEG_Y, Vec3::Z]).collect()
    }

    #[test]
    fn constant_light_lights_all_normals_alike() {
        let light = light(|_| 2.0);
        assert!((light.0[0].x / (2.0 * (4.0 * PI).sqrt()) - 1.0).abs() < 1e-3);
        assert!(light.0[1..].iter().all(|of| of.x.abs() < 0.01), "{light:?}");
        assert_eq!(light.window_strength(), 0.0);
        let cube = AmbientCube::of(&light);
        for normal in normals() {
            assert!((light.irradiance(normal).x - 2.0).abs() < 0.002);
            assert!((cube.irradiance(normal).x - 2.0).abs() < 0.01, "{cube:?}");
        }
    }

    #[test]
    fn a_cosine_lobe_has_its_closed_form() {
        let axis = Vec3::new(0.3, 0.8, -0.5).normalize();
        let light = light(|direction| direction.dot(axis).max(0.0));
        // A clamped cosine has π, 2 π / 3 and π / 4 of the harmonics about its axis, orders 0 to 2.
        for (at, expected) in harmonics(axis).into_iter().enumerate() {
            let expected = expected * PI * COSINE[ORDERS[at]];
            assert!((light.0[at].x - expected).abs() < 0.01 * PI * SCALES[0], "{at}: {} {expected}", light.0[at].x);
        }
        // Along the axis irradiance is 2 π / 3, away from it 0, and what order 2 gives is within 1 % of that.
        assert!((light.irradiance(axis).x * PI / (2.0 * PI / 3.0) - 1.0).abs() < 0.01, "{}", light.irradiance(axis).x);
    }

    #[test]
    fn a_small_sun_is_windowed_and_rings_nowhere_below_zero() {
        let axis = Vec3::new(-0.2, 0.7, 0.6).normalize();
        // Of one degree, with an irradiance of 3 across its direction.
        let cos = 1f32.to_radians().cos();
        let mut light = Harmonics::default();
        light.add(axis, Vec3::splat(3.0));
        let solid_angle = 2.0 * PI * (1.0 - cos);
        assert!(solid_angle < 1e-3);
        let strength = light.window_strength();
        assert!(strength > 0.0 && strength <= 0.16, "{strength}");
        let windowed = light.windowed();
        for (at, basis) in harmonics(axis).into_iter().enumerate() {
            let expected = 3.0 * basis * Harmonics::window(strength, ORDERS[at]);
            assert!((windowed.0[at].x - expected).abs() <= 0.01 * expected.abs(), "{at}");
        }
        for normal in normals() {
            assert!(windowed.unbounded(normal).x > -0.003, "{normal} {}", windowed.unbounded(normal).x);
        }
        // A window moves light from where it is strong to where it is weak, and takes none: the mean over all normals is
        // irradiance / 4.
        let mean = spread_directions().map(|normal| windowed.unbounded(normal).x).sum::<f32>() / DIRECTIONS as f32;
        assert!((mean * PI / (3.0 / 4.0) - 1.0).abs() < 0.01, "{mean}");
    }

    #[test]
    fn a_cube_is_near_the_light_that_it_is_of() {
        let axis = Vec3::new(0.1, 0.9, 0.2).normalize();
        let light = light(|direction| 0.2 + direction.dot(axis).max(0.0).powi(2));
        let cube = AmbientCube::of(&light);
        let mean = |of: &dyn Fn(Vec3) -> f32| spread_directions().map(of).sum::<f32>() / DIRECTIONS as f32;
        let (of_light, of_cube) = (mean(&|normal| light.irradiance(normal).x), mean(&|n| cube.irradiance(n).x));
        assert!((of_cube / of_light - 1.0).abs() < 0.01, "{of_light} {of_cube}");
        for normal in normals() {
            let (a, b) = (light.irradiance(normal).x, cube.irradiance(normal).x);
            assert!((a - b).abs() < 0.12 * light.irradiance(axis).x, "{normal}: {a} {b}");
        }
    }
}
