//! Light from everywhere: a constant, or the built-in studio. The uniform of `environment.wgsl`.

use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};
use manypass_scene::Scene;

/// What surrounds the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Environment {
    /// Soft boxes around the scene, with neutral colours.
    #[default]
    Studio,
    /// Nothing.
    None,
    /// The same radiance from everywhere, linear Rec. 709.
    Color([f32; 3]),
}

impl Environment {
    /// What surrounds `scene` where nobody says: the studio, or nothing where the scene brings its own lights.
    pub fn of_scene(scene: &Scene) -> Self {
        let is_lit = scene.visible_nodes().into_iter().any(|id| scene.node(id).light.is_some());
        if is_lit { Self::None } else { Self::Studio }
    }
}

/// What the camera sees where there is no surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Background {
    /// The environment.
    #[default]
    Environment,
    /// Nothing: alpha is 0.
    Transparent,
    /// A display colour, linear Rec. 709; exposure leaves it alone.
    Color([f32; 3]),
}

/// The uniform of `environment.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct EnvironmentUniform {
    /// Constant radiance.
    pub constant: Vec3,
    /// The number of soft boxes.
    pub box_count: u32,
    /// Axis and sharpness.
    pub axes: [Vec4; 6],
    /// Radiance on the axis.
    pub amplitudes: [Vec4; 6],
    /// Radiance where there is no surface; w = 1: the environment instead.
    pub background: Vec4,
}

/// The studio: a soft key from above on the left, a fill on the right, a rim from behind, a bright ceiling. Direction,
/// sharpness, radiance; chosen so that a white sphere reads about 0.5 on average.
const STUDIO: [([f32; 3], f32, [f32; 3]); 4] = [
    ([-0.55, 0.65, 0.55], 14.0, [4.2, 4.1, 3.9]),
    ([0.85, 0.25, 0.45], 10.0, [1.1, 1.15, 1.3]),
    ([0.2, 0.45, -0.9], 18.0, [2.6, 2.7, 3.0]),
    ([0.0, 1.0, 0.0], 3.0, [0.55, 0.57, 0.6]),
];
const STUDIO_CONSTANT: Vec3 = Vec3::new(0.16, 0.16, 0.165);

impl EnvironmentUniform {
    /// The environment times `scale` (its intensity and the pre-exposure).
    pub fn new(environment: Environment, background: Background, scale: f32) -> Self {
        let mut uniform = Self::zeroed();
        match environment {
            Environment::None => {}
            Environment::Color(color) => uniform.constant = Vec3::from(color) * scale,
            Environment::Studio => {
                uniform.constant = STUDIO_CONSTANT * scale;
                uniform.box_count = STUDIO.len() as u32;
                for (i, (axis, sharpness, radiance)) in STUDIO.iter().enumerate() {
                    uniform.axes[i] = Vec3::from(*axis).normalize().extend(*sharpness);
                    uniform.amplitudes[i] = (Vec3::from(*radiance) * scale).extend(0.0);
                }
            }
        }
        uniform.background = match background {
            Background::Environment => Vec4::W,
            Background::Transparent => Vec4::ZERO,
            Background::Color([r, g, b]) => Vec4::new(r, g, b, 0.0),
        };
        uniform
    }

    /// Whether no light comes from it.
    pub fn is_dark(&self) -> bool {
        self.constant == Vec3::ZERO && self.box_count == 0
    }
}
