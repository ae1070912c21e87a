//! The BRDF, written from the papers:
//!
//! - D: Walter, Marschner, Li, Torrance, "Microfacet Models for Refraction through Rough Surfaces", 2007 (GGX).
//! - V: Heitz, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", 2014 (height-correlated
//!   Smith).
//! - F: Schlick, "An Inexpensive BRDF Model for Physically-based Rendering", 1994.
//! - Compensation: Turquin, "Practical multiple scattering compensation for microfacet models", 2019.
//! - Diffuse: Lambert, times (1 − F) (glTF 2.0 specification, appendix B).

use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// What an object is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Linear Rec. 709.
    pub base_color: DVec3,
    /// 0 dielectric, 1 metal.
    pub metallic: f64,
    /// 0 to 1.
    pub roughness_perceptual: f64,
    /// Radiance emitted.
    pub emission: DVec3,
}

impl Surface {
    /// The α of GGX. Perceptual roughness below 0.045 counts as 0.045.
    pub fn roughness_alpha(&self) -> f64 {
        self.roughness_perceptual.max(0.045).powi(2)
    }

    /// The reflectance at normal incidence: 0.04 for dielectrics, the base colour for metals.
    pub fn f0(&self) -> DVec3 {
        DVec3::splat(0.04).lerp(self.base_color, self.metallic)
    }

    /// The factor on the specular lobe that makes up for light scattered more than once, where `albedo` is the
    /// directional albedo of the lobe with a Fresnel term of 1.
    pub fn compensation(&self, albedo: f64) -> DVec3 {
        DVec3::ONE + self.f0() * (1.0 / albedo - 1.0)
    }

    /// The BRDF in sr⁻¹ for unit vectors; `compensation` multiplies the specular lobe.
    pub fn brdf(&self, normal: DVec3, to_viewer: DVec3, to_light: DVec3, compensation: DVec3) -> DVec3 {
        let diffuse = self.base_color * ((1.0 - self.metallic) / PI);
        // A normal that is interpolated or mapped may be turned away from the viewer: he sees it at a grazing angle
        // then.
        let (n_dot_v, n_dot_l) = (normal.dot(to_viewer).max(1e-4), normal.dot(to_light));
        if n_dot_l <= 0.0 {
            return diffuse;
        }
        let half = (to_viewer + to_light).normalize();
        let alpha = self.roughness_alpha();
        let f0 = self.f0();
        let fresnel = f0 + (DVec3::ONE - f0) * (1.0 - to_viewer.dot(half).clamp(0.0, 1.0)).powi(5);
        let lobe = distribution(normal.dot(half), alpha) * visibility(n_dot_v, n_dot_l, alpha);
        // glTF 2.0, appendix B: what Fresnel reflects does not enter the surface.
        diffuse * (DVec3::ONE - fresnel) + fresnel * compensation * lobe
    }
}

/// GGX: the density of microfacet normals at the cosine `n_dot_h`.
fn distribution(n_dot_h: f64, alpha: f64) -> f64 {
    // Walter et al., equation 33: α² / (π cos⁴θ (α² + tan²θ)²).
    let cos_squared = n_dot_h * n_dot_h;
    let tan_squared = (1.0 - cos_squared).max(0.0) / cos_squared;
    alpha * alpha / (PI * cos_squared * cos_squared * (alpha * alpha + tan_squared).powi(2))
}

/// Λ of Smith's masking function for GGX (Heitz, equation 72).
fn lambda(cos: f64, alpha: f64) -> f64 {
    let tan_squared = (1.0 - cos * cos).max(0.0) / (cos * cos);
    0.5 * ((1.0 + alpha * alpha * tan_squared).sqrt() - 1.0)
}

/// G₂ / (4 N·V N·L) with the height-correlated G₂ = 1 / (1 + Λ(V) + Λ(L)) (Heitz, equation 99).
fn visibility(n_dot_v: f64, n_dot_l: f64, alpha: f64) -> f64 {
    1.0 / ((1.0 + lambda(n_dot_v, alpha) + lambda(n_dot_l, alpha)) * 4.0 * n_dot_v * n_dot_l)
}

/// The directional albedo of GGX with a Fresnel term of 1, over N·V, for one α.
#[derive(Clone, Debug, PartialEq)]
pub struct AlbedoTable(Vec<f64>);

impl Default for AlbedoTable {
    /// The table of a surface that loses nothing.
    fn default() -> Self {
        Self(vec![1.0; 2])
    }
}

impl AlbedoTable {
    /// Integrates the albedo at 65 values of N·V, which lie closer together towards grazing angles.
    pub fn new(alpha: f64) -> Self {
        Self((0..=64).map(|i| directional_albedo((f64::from(i) / 64.0).powi(2).max(1e-4), alpha)).collect())
    }

    /// The albedo at `n_dot_v`, interpolated.
    pub fn get(&self, n_dot_v: f64) -> f64 {
        let last = self.0.len() - 1;
        let place = n_dot_v.clamp(0.0, 1.0).sqrt() * last as f64;
        let cell = (place as usize).min(last - 1);
        let weight = place - cell as f64;
        self.0[cell] * (1.0 - weight) + self.0[cell + 1] * weight
    }
}

/// ∫ D V (N·L) dω over the hemisphere: a midpoint rule over the half vectors that GGX distributes, on 64 × 64 cells.
pub fn directional_albedo(n_dot_v: f64, alpha: f64) -> f64 {
    const CELLS: u32 = 64;
    let to_viewer = DVec3::new((1.0 - n_dot_v * n_dot_v).max(0.0).sqrt(), 0.0, n_dot_v);
    let mut sum = 0.0;
    for cell in 0..CELLS * CELLS {
        let u = (DVec2::new(f64::from(cell % CELLS), f64::from(cell / CELLS)) + 0.5) / f64::from(CELLS);
        // Walter et al., equations 35 and 36; by symmetry half a turn is enough.
        let tan_squared = alpha * alpha * u.x / (1.0 - u.x);
        let n_dot_h = 1.0 / (1.0 + tan_squared).sqrt();
        let sin = (1.0 - n_dot_h * n_dot_h).max(0.0).sqrt();
        let half = DVec3::new(sin * (PI * u.y).cos(), sin * (PI * u.y).sin(), n_dot_h);
        let v_dot_h = to_viewer.dot(half);
        let n_dot_l = 2.0 * v_dot_h * half.z - to_viewer.z;
        if v_dot_h > 0.0 && n_dot_l > 0.0 {
            sum += visibility(n_dot_v, n_dot_l, alpha) * n_dot_l * 4.0 * v_dot_h / n_dot_h;
        }
    }
    sum / f64::from(CELLS * CELLS)
}
