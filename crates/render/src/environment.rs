//! Light from everywhere: a constant, or the built-in studio; and what the camera sees of it. The uniform of
//! `environment.wgsl`.

mod computed;
pub(crate) mod lobe;
mod settings;
pub(crate) mod suns;
pub(crate) mod tiles;

pub(crate) use computed::ComputedEnvironments;
pub use settings::EnvironmentSettings;

use crate::colour::{finite_product, linear_from_srgb, srgb_from_linear};
use crate::resources::environment::EnvironmentTiles;
use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};
use manypass_scene::{EnvironmentLight, Scene};

/// What surrounds the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Environment {
    /// As [`Self::of_scene`] says.
    #[default]
    Auto,
    /// Soft boxes around the scene, with neutral colours, before a calm backdrop.
    Studio,
    /// The studio, faint, for a scene that brings its own lights: what they leave dark can still be seen. It has
    /// [`FILL_SHARE`] of the studio's level in the picture that automatic exposure makes, however strong the lights are;
    /// so it neither drowns a lamp of 1 cd nor vanishes beside one of 10⁶ cd. Its backdrop has [`FILL_BACKDROP_SHARE`].
    /// Where the lights reach nothing that is seen it is the whole studio.
    Fill,
    /// The sky of the Earth, computed from sun, air and ground ([`manypass_scene::Sky`]); its sun casts shadows.
    Sky,
    /// The scene's own picture of it ([`Scene::environment`]); nothing where it has none.
    File,
    /// Nothing.
    None,
    /// The same radiance from everywhere, linear Rec. 709.
    Color([f32; 3]),
}

/// The format of the tiles of a picture.
pub(crate) const ENVIRONMENT_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// The brightest that the disc of a sun is, pre-exposed.
const DISC_RADIANCE_MAX: f32 = 0.9 * crate::constants::RADIANCE_MAX;

/// The level of [`Environment::Fill`] in the picture, compared with the studio.
pub const FILL_SHARE: f32 = 1.0 / 16.0;

/// The level of its backdrop; tone curves darken what is dark, and a picture at night need not end in black.
pub const FILL_BACKDROP_SHARE: f32 = 0.25;

impl Environment {
    /// What surrounds `scene` where nobody says: its own picture; else the studio, [`Environment::Fill`] where the scene brings
    /// its own lights, or nothing where it states an exposure as well, because then its light is meant as it is.
    pub fn of_scene(scene: &Scene) -> Self {
        if scene.environment.is_some() {
            return Self::File;
        }
        let is_lit = scene.visible_nodes().into_iter().any(|id| scene.node(id).light.is_some());
        match (is_lit, scene.exposure_stops) {
            (false, _) => Self::Studio,
            (true, None) => Self::Fill,
            (true, Some(_)) => Self::None,
        }
    }

    /// With [`Self::Auto`] as it is for `scene`.
    pub fn resolved(self, scene: &Scene) -> Self {
        if self == Self::Auto { Self::of_scene(scene) } else { self }
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
    /// A display colour, linear Rec. 709, under every tone curve and at every exposure. In linear outputs it is the
    /// radiance that the exposure would show with these values.
    Color([f32; 3]),
    /// The same of two colours, at the lower and at the upper edge of the picture. Between them it goes evenly in sRGB.
    Gradient([[f32; 3]; 2]),
}

impl Background {
    /// The colours at the lower and at the upper edge of the picture, if it is of colours.
    pub(crate) fn colors(self) -> Option<[[f32; 3]; 2]> {
        match self {
            Self::Color(color) => Some([color; 2]),
            Self::Gradient(colors) => Some(colors),
            Self::Environment | Self::Transparent => None,
        }
    }

    /// The colour, linear Rec. 709, at a height in the picture, from 0 at the lower edge to 1 at the upper one, if it is of colours.
    pub(crate) fn color_at(self, height: f32) -> Option<[f32; 3]> {
        let Self::Gradient([below, above]) = self else { return self.colors().map(|[color, _]| color) };
        let between = |at: usize| {
            let [below, above] = [below, above].map(|color| srgb_from_linear(color[at].clamp(0.0, 1.0)));
            linear_from_srgb(below + (above - below) * height)
        };
        Some([0, 1, 2].map(between))
    }
}

/// A soft box of `environment.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct SoftBox {
    /// Axis and sharpness.
    pub axis: Vec4,
    /// Scale and bias of the irradiance, and the part of its curve that depends on sharpness alone.
    pub irradiance_fit: Vec4,
    /// Radiance times the integral of the Gaussian over the sphere.
    pub power: Vec3,
    /// Zero.
    pub padding: f32,
}

impl SoftBox {
    /// A spherical Gaussian about `axis`, with `radiance` on it; its irradiance is the fit of Hill 2016, "SG Series".
    fn new(axis: Vec3, sharpness: f32, radiance: Vec3) -> Self {
        let c0 = 0.36;
        let em = (-sharpness).exp();
        let em2 = em * em;
        let r = 1.0 / sharpness;
        let scale = 1.0 + 2.0 * em2 - r;
        let bias = (em - em2) * r - em2;
        let x = (1.0 - scale).max(0.0).sqrt();
        Self {
            axis: axis.normalize().extend(sharpness),
            irradiance_fit: Vec4::new(scale, bias, x / (4.0 * c0), 1.0 / x.max(1e-6)),
            power: radiance.map(|radiance| finite_product(radiance, std::f32::consts::TAU * (1.0 - em2) * r)),
            padding: 0.0,
        }
    }
}

/// The uniform of `environment.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct EnvironmentUniform {
    /// Constant radiance.
    pub constant: Vec3,
    /// Zero.
    pub padding: f32,
    /// The soft boxes.
    pub boxes: [SoftBox; STUDIO.len()],
    /// What the camera sees straight down; w is 0.
    pub backdrop_below: Vec4,
    /// What the camera sees straight up; w is 0.
    pub backdrop_above: Vec4,
    /// Of the picture: what its light is multiplied by, the side of the mirror's tile in texels, the cosine and the sine of its
    /// rotation.
    pub picture: Vec4,
    /// What the picture is multiplied by as the camera sees it, and its level; one divided by the size of the texture in texels.
    pub picture_backdrop: Vec4,
    /// Of the lobe in which the camera sees suns where the picture is blurred: the square of alpha, one divided by the lobe's
    /// integral times how much of them is not in the mirror's tile; zeros.
    pub backdrop_lobe: Vec4,
    /// Where strong small sources of the picture are; w is 0.
    pub sun_directions: [Vec4; suns::SUNS_MAX],
    /// Their irradiance, pre-exposed; w is 0.
    pub sun_irradiances: [Vec4; suns::SUNS_MAX],
    /// The radiance of the first of them where it is a disc that the camera sees, pre-exposed, and the cosine of half its angle.
    pub sun_disc: Vec4,
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

/// What the camera sees of the studio, straight down and straight up: between the darkest and the brightest materials, so
/// that white and black ones stand out alike.
const STUDIO_BACKDROP: [Vec3; 2] = [Vec3::new(0.06, 0.061, 0.064), Vec3::new(0.34, 0.35, 0.37)];

impl EnvironmentUniform {
    /// The environment with its light times `scale` (its intensity and the pre-exposure, and what makes the studio a fill)
    /// and its backdrop times `backdrop_scale`.
    pub fn new(environment: Environment, scale: f32, backdrop_scale: f32) -> Self {
        let scaled = |color: Vec3, scale: f32| color.map(|color| finite_product(color, scale).max(0.0));
        // A box without power has an axis and a sharpness all the same: 0 / 0 is no number.
        let mut uniform = Self { boxes: [SoftBox::new(Vec3::Y, 1.0, Vec3::ZERO); STUDIO.len()], ..Self::zeroed() };
        match environment {
            // A picture is placed afterwards.
            Environment::None | Environment::File | Environment::Sky => {}
            Environment::Color(color) => {
                uniform.constant = scaled(Vec3::from(color), scale);
                uniform.backdrop_below = scaled(Vec3::from(color), backdrop_scale).extend(0.0);
                uniform.backdrop_above = uniform.backdrop_below;
            }
            // One that was not resolved with its scene is that of a scene without lights.
            Environment::Auto | Environment::Studio | Environment::Fill => {
                uniform.constant = scaled(STUDIO_CONSTANT, scale);
                uniform.boxes = STUDIO.map(|(axis, sharpness, radiance)| {
                    SoftBox::new(Vec3::from(axis), sharpness, scaled(Vec3::from(radiance), scale))
                });
                let [below, above] = STUDIO_BACKDROP.map(|radiance| scaled(radiance, backdrop_scale).extend(0.0));
                (uniform.backdrop_below, uniform.backdrop_above) = (below, above);
            }
        }
        uniform
    }

    /// Whether no light comes from it.
    pub fn is_dark(&self) -> bool {
        let has_boxes = self.boxes.iter().any(|soft_box| soft_box.power != Vec3::ZERO);
        self.constant == Vec3::ZERO && !has_boxes && self.picture.x == 0.0
    }
}

/// The picture of the environment as a view has it.
pub(crate) struct PlacedPicture<'a> {
    /// What is on the device.
    pub tiles: &'a EnvironmentTiles,
    /// By how much it is turned about +Y, counter-clockwise seen from above, in degrees.
    pub rotation_deg: f32,
    /// How blurred the camera sees it: from 0, sharp, to 1, as a surface of roughness 1 reflects it.
    pub blur: f32,
}

impl PlacedPicture<'_> {
    /// Puts the picture into a uniform, its light times `scale` and what the camera sees times `backdrop_scale`.
    pub fn place(&self, uniform: &mut EnvironmentUniform, scale: f32, backdrop_scale: f32) {
        // Radiance in it goes up to half floats' own limit, and what comes out is cut again.
        let [scale, backdrop_scale] = [scale, backdrop_scale].map(|scale| finite_product(1.0, scale).max(0.0));
        let EnvironmentTiles { desc, mirror_side, suns, .. } = self.tiles;
        let (sin, cos) = self.rotation_deg.to_radians().sin_cos();
        uniform.picture = Vec4::new(scale, *mirror_side as f32, cos, sin);
        let roughness = self.blur.clamp(0.0, 1.0);
        let level = lobe::level_of_roughness(roughness);
        let alpha = roughness * roughness;
        let sun_scale = if scale > 0.0 { backdrop_scale / scale } else { 0.0 };
        let integral = lobe::lobe_integral(alpha);
        uniform.backdrop_lobe = Vec4::new(alpha * alpha, level.min(1.0) * sun_scale / integral, 0.0, 0.0);
        uniform.picture_backdrop = Vec4::new(backdrop_scale, level, 1.0 / desc.width as f32, 1.0 / desc.height as f32);
        for (at, sun) in suns.iter().enumerate() {
            let Vec3 { x, y, z } = sun.direction;
            uniform.sun_directions[at] = Vec4::new(cos * x + sin * z, y, cos * z - sin * x, 0.0);
            let irradiance = sun.irradiance.map(|value| finite_product(value, scale));
            uniform.sun_irradiances[at] = irradiance.extend(0.0);
        }
        if let Some(light) = &self.tiles.light {
            let Vec3 { x, y, z } = light.direction;
            uniform.sun_directions[0] = Vec4::new(cos * x + sin * z, y, cos * z - sin * x, 0.0);
            uniform.sun_irradiances[0] = light.irradiance.map(|value| finite_product(value, scale)).extend(0.0);
            uniform.sun_disc = disc(light, backdrop_scale * (1.0 - level.min(1.0)));
        }
    }
}

/// The disc of a light as the camera sees it. It is kept below what counts as too bright for half floats: in most pictures of the
/// sun it is beyond them.
fn disc(light: &EnvironmentLight, scale: f32) -> Vec4 {
    let tangent = light.half_angle_tan;
    let radiance =
        light.irradiance.map(|value| finite_product(value, scale / (std::f32::consts::PI * tangent * tangent)));
    let share = (DISC_RADIANCE_MAX / radiance.max_element().max(1e-30)).min(1.0);
    (radiance * share).extend(tangent.atan().cos())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!("forward", "SoftBox", SoftBox, [axis, irradiance_fit, power, padding]);
        assert_same_layout!(
            "forward",
            "Environment",
            EnvironmentUniform,
            [
                constant,
                padding,
                boxes,
                backdrop_below,
                backdrop_above,
                picture,
                picture_backdrop,
                backdrop_lobe,
                sun_directions,
                sun_irradiances,
                sun_disc
            ]
        );
    }
}
