//! What the tests of reflections share.

use super::floats;
use glam::Vec3;
use manypass::{Aov, FrameRequest, Renderer, View};
use manypass_scene::{Material, Projection, Scene, ShadingModel};
use manypass_testkit::build::grey;
use std::f32::consts::TAU;

/// White metal: it reflects all light, whatever its roughness.
pub fn metal(roughness_factor: f32) -> Material {
    Material { metallic_factor: 1.0, roughness_factor, ..grey(1.0) }
}

/// Of the same radiance from everywhere.
pub fn glowing(color: [f32; 3]) -> Material {
    Material {
        base_color_factor: Vec3::from(color).extend(1.0),
        shading_model: ShadingModel::Unlit,
        ..Material::default()
    }
}

/// Black but for the light that it gives.
pub fn bulb(radiance: f32) -> Material {
    Material { emissive_factor: Vec3::splat(radiance), roughness_factor: 1.0, ..grey(0.0) }
}

/// As it is without reflections.
pub fn without(request: &FrameRequest) -> FrameRequest {
    request.with(|settings| settings.reflections.enabled = false.into())
}

pub fn load(renderer: &mut Renderer, scene: &Scene) {
    renderer.unload();
    renderer.load(scene).unwrap();
}

/// Where surfaces are that the pixels of a view show, and their normals.
pub fn places(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<(Vec3, Vec3)> {
    let request = FrameRequest { want_aovs: vec![Aov::Position, Aov::Normal], ..request.clone() };
    renderer.render(scene, &request).unwrap();
    let [positions, normals] = [Aov::Position, Aov::Normal].map(|aov| floats(renderer.read_aov(aov).unwrap()));
    let both = positions.chunks_exact(3).zip(normals.chunks_exact(3));
    both.map(|(position, normal)| (Vec3::from_slice(position), Vec3::from_slice(normal))).collect()
}

/// The place in a picture, from 0 to its size, of what lies before the camera.
pub fn pixel_of(view: &View, (width, height): (u32, u32), position: Vec3) -> (f32, f32) {
    let (width, height) = (width as f32, height as f32);
    let seen = view.world_from_view.inverse().transform_point3(position);
    let half = match view.projection {
        Projection::Perspective { fov_y_rad, .. } => (0.5 * fov_y_rad).tan() * -seen.z,
        Projection::Orthographic { height_m, .. } => 0.5 * height_m,
    };
    ((0.5 + 0.5 * seen.x / (half * width / height)) * width, (0.5 - 0.5 * seen.y / half) * height)
}

/// The lobe of a rough mirror.
#[derive(Clone, Copy, Debug)]
pub struct Lobe {
    /// In world space.
    pub normal: Vec3,
    /// Perceptual.
    pub roughness: f32,
    /// The reflectance at normal incidence.
    pub f0: f32,
}

impl Lobe {
    /// The direction in which a microfacet reflects the line of sight, and how much of the light from there reaches the
    /// eye, up to a common factor; none where that direction points into the surface. Two numbers from 0 up to 1 choose
    /// the microfacet by the distribution of GGX itself (Walter et al. 2007). Masking is Smith's, height-correlated
    /// (Heitz 2014), Fresnel's term Schlick's.
    pub fn reflected(&self, to_eye: Vec3, [u, turn]: [f32; 2]) -> Option<(Vec3, f32)> {
        let Self { normal, roughness, f0 } = *self;
        let alpha = roughness * roughness;
        let lambda = |cosine: f32| 0.5 * ((1.0 + alpha * alpha * (1.0 / (cosine * cosine) - 1.0)).sqrt() - 1.0);
        let cosine = ((1.0 - u) / (1.0 + (alpha * alpha - 1.0) * u)).sqrt();
        let (sin_turn, cos_turn) = (TAU * turn).sin_cos();
        let (tangent, bitangent) = normal.any_orthonormal_pair();
        let across = (1.0 - cosine * cosine).max(0.0).sqrt();
        let half = across * (cos_turn * tangent + sin_turn * bitangent) + cosine * normal;
        let v_dot_h = to_eye.dot(half);
        let towards = 2.0 * v_dot_h * half - to_eye;
        let [n_dot_v, n_dot_l] = [to_eye, towards].map(|direction| direction.dot(normal));
        if v_dot_h <= 0.0 || n_dot_v <= 0.0 || n_dot_l <= 0.0 {
            return None;
        }
        let fresnel = f0 + (1.0 - f0) * (1.0 - v_dot_h).max(0.0).powi(5);
        let masking = 1.0 / (1.0 + lambda(n_dot_v) + lambda(n_dot_l));
        Some((towards, fresnel * masking * v_dot_h / (n_dot_v * cosine)))
    }
}
