//! Light from everywhere: a constant, or the built-in studio; and what the camera sees of it. The uniform of
//! `environment.wgsl`.

mod computed;
pub(crate) mod lobe;
mod mean;
pub(crate) mod picture;
mod radiance;
mod settings;
pub(crate) mod stored;
pub(crate) mod studio;

pub(crate) use computed::ComputedEnvironments;
pub use radiance::EnvironmentRadiance;
pub use settings::EnvironmentSettings;

use crate::colour::{finite_product, linear_from_srgb, srgb_from_linear};
use crate::probes::ProbesUniforms;
use crate::surroundings::SurroundingsUniforms;
use bytemuck::{Pod, Zeroable};
use glam::{Vec3, Vec4};
use manypass_scene::environment::suns;
use manypass_scene::{Cache, EnvironmentLight, Scene};
use picture::EnvironmentTiles;
use std::sync::Arc;

/// The environment, which lights the scene from all sides: a studio, the sky, a picture or none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Environment {
    /// As [`Self::of_scene`] says.
    #[default]
    Auto,
    /// A room with soft boxes, in grey, before a calm backdrop. Its key is a light with shadows.
    Studio,
    /// The studio, faint, for a scene that brings its own lights: what they leave dark can still be seen. It has
    /// [`FILL_SHARE`] of the studio's level in the picture that automatic exposure makes, however strong the lights
    /// are; so it neither drowns a lamp of 1 cd nor vanishes beside one of 10⁶ cd. Its backdrop has
    /// [`FILL_BACKDROP_SHARE`]. Where the lights leave more than half of what is seen dark it is brighter, up to the
    /// whole studio where they reach nothing.
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

/// The format of a picture, and of what tiles are made from; their own is that of
/// [`crate::gpu::Capabilities::tiles_format`].
pub(crate) const ENVIRONMENT_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// The brightest that the disc of a sun is, pre-exposed.
const DISC_RADIANCE_MAX: f32 = 0.9 * crate::constants::RADIANCE_MAX;

/// The level of [`Environment::Fill`] in the picture, compared with the studio.
pub const FILL_SHARE: f32 = 1.0 / 16.0;

/// The level of its backdrop; tone curves darken what is dark, and a picture at night need not end in black.
pub const FILL_BACKDROP_SHARE: f32 = 0.25;

impl Environment {
    /// Starts to compute on another thread what the first frame would wait for: the studio, where this may come to it.
    /// It is of use while files are read or a device starts; nothing depends on it. What earlier processes left in
    /// `cache` need not be computed again.
    pub fn begin(self, cache: Option<Arc<dyn Cache>>) {
        if matches!(self, Self::Auto | Self::Studio | Self::Fill) {
            studio::begin(cache);
        }
    }

    /// What surrounds `scene` where nobody says: its own picture; else the studio, [`Environment::Fill`] where the
    /// scene brings its own lights or the light that was baked of them, or nothing where it states an exposure as well, because then its light is meant as
    /// it is.
    pub fn of_scene(scene: &Scene) -> Self {
        if scene.environment.is_some() {
            return Self::File;
        }
        let is_lit = scene.holds_baked_light || scene.is_lit();
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

/// The background of the picture, where there is no surface.
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

    /// The colour, linear Rec. 709, at a height in the picture, from 0 at the lower edge to 1 at the upper one, if it
    /// is of colours.
    pub(crate) fn color_at(self, height: f32) -> Option<[f32; 3]> {
        let Self::Gradient([below, above]) = self else { return self.colors().map(|[color, _]| color) };
        let between = |at: usize| {
            let [below, above] = [below, above].map(|color| srgb_from_linear(color[at].clamp(0.0, 1.0)));
            linear_from_srgb(below + (above - below) * height)
        };
        Some([0, 1, 2].map(between))
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
    /// What the camera sees straight down; w is 0.
    pub backdrop_below: Vec4,
    /// What the camera sees straight up; w is 0.
    pub backdrop_above: Vec4,
    /// Of the picture: what its light is multiplied by, zero, the cosine and the sine of its rotation.
    pub picture: Vec4,
    /// The sides of its tiles in texels: the mirror's, fine, medium and coarse ones.
    pub tile_sides: Vec4,
    /// What the picture is multiplied by as the camera sees it, and its level; one divided by the size of the texture
    /// in texels.
    pub picture_backdrop: Vec4,
    /// Of the lobe in which the camera sees suns where the picture is blurred: the square of alpha, one divided by the
    /// lobe's integral times how much of them is not in the mirror's tile; zeros.
    pub backdrop_lobe: Vec4,
    /// Where strong small sources of the picture are; w is how far half vectors go apart by their discs: the
    /// square of half the half angle.
    pub sun_directions: [Vec4; suns::SUNS_MAX],
    /// Their irradiance, pre-exposed; w is 0.
    pub sun_irradiances: [Vec4; suns::SUNS_MAX],
    /// The radiance of the first of them where it is a disc that the camera sees, pre-exposed, and the cosine of half
    /// its angle.
    pub sun_disc: Vec4,
    /// What stands for it in parts of the scene.
    pub(crate) surroundings: SurroundingsUniforms,
    /// The sides of their tiles, as `tile_sides`.
    pub surrounding_sides: Vec4,
    /// Grids of probes, whose light surfaces in their boxes have in its place.
    pub(crate) probes: ProbesUniforms,
}

/// What the camera sees of the studio, straight down and straight up: between the darkest and the brightest materials,
/// so that white and black ones stand out alike.
const STUDIO_BACKDROP: [Vec3; 2] = [Vec3::splat(0.42), Vec3::splat(0.60)];

/// The same where it is a fill, before a scene at night.
const FILL_BACKDROP: [Vec3; 2] = [Vec3::new(0.06, 0.061, 0.064), Vec3::new(0.34, 0.35, 0.37)];

impl EnvironmentUniform {
    /// The environment with its light times `scale` (its intensity and the pre-exposure, and what makes the studio a
    /// fill) and its backdrop times `backdrop_scale`.
    pub fn new(environment: Environment, scale: f32, backdrop_scale: f32) -> Self {
        let scaled = |color: Vec3, scale: f32| color.map(|color| finite_product(color, scale).max(0.0));
        let mut uniform = Self::zeroed();
        match environment {
            // A picture is placed afterwards.
            Environment::None | Environment::File | Environment::Sky => {}
            Environment::Color(color) => {
                uniform.constant = scaled(Vec3::from(color), scale);
                uniform.backdrop_below = scaled(Vec3::from(color), backdrop_scale).extend(0.0);
                uniform.backdrop_above = uniform.backdrop_below;
            }
            // The light of a picture is placed afterwards, and so is the studio's.
            Environment::Auto | Environment::Studio | Environment::Fill => {
                let backdrop = if environment == Environment::Fill { FILL_BACKDROP } else { STUDIO_BACKDROP };
                let [below, above] = backdrop.map(|radiance| scaled(radiance, backdrop_scale).extend(0.0));
                (uniform.backdrop_below, uniform.backdrop_above) = (below, above);
            }
        }
        uniform
    }

    /// How many probes all grids have.
    pub fn probe_count(&self) -> u32 {
        self.probes.iter().map(|grid| grid.counts.truncate().element_product() as u32).sum()
    }

    /// Whether no light comes from it.
    pub fn is_dark(&self) -> bool {
        let has_others = self.surrounding_sides != Vec4::ZERO || self.probes[0].half_m != Vec4::ZERO;
        self.constant == Vec3::ZERO && self.picture.x == 0.0 && !has_others
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
        let EnvironmentTiles { desc, sides, suns, .. } = self.tiles;
        let (sin, cos) = self.rotation_deg.to_radians().sin_cos();
        uniform.picture = Vec4::new(scale, 0.0, cos, sin);
        uniform.tile_sides = sides.uniform();
        let roughness = self.blur.clamp(0.0, 1.0);
        let level = lobe::level_of_roughness(roughness);
        let alpha = roughness * roughness;
        let sun_scale = if scale > 0.0 { backdrop_scale / scale } else { 0.0 };
        let integral = lobe::lobe_integral(alpha);
        uniform.backdrop_lobe = Vec4::new(alpha * alpha, level.min(1.0) * sun_scale / integral, 0.0, 0.0);
        uniform.picture_backdrop = Vec4::new(backdrop_scale, level, 1.0 / desc.width as f32, 1.0 / desc.height as f32);
        for (at, sun) in suns.iter().enumerate() {
            let Vec3 { x, y, z } = sun.direction;
            uniform.sun_directions[at] = Vec4::new(cos * x + sin * z, y, cos * z - sin * x, sun.spread);
            let irradiance = sun.irradiance.map(|value| finite_product(value, scale));
            uniform.sun_irradiances[at] = irradiance.extend(0.0);
        }
        if let Some(light) = &self.tiles.light {
            let Vec3 { x, y, z } = light.direction;
            let spread = 0.25 * light.half_angle_tan * light.half_angle_tan;
            uniform.sun_directions[0] = Vec4::new(cos * x + sin * z, y, cos * z - sin * x, spread);
            uniform.sun_irradiances[0] = light.irradiance.map(|value| finite_product(value, scale)).extend(0.0);
            uniform.sun_disc = disc(light, backdrop_scale * (1.0 - level.min(1.0)));
        }
    }
}

/// The disc of a light as the camera sees it. It is kept below what counts as too bright for half floats: in most
/// pictures of the sun it is beyond them.
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
        assert_same_layout!(
            "forward",
            "Environment",
            EnvironmentUniform,
            [
                constant,
                padding,
                backdrop_below,
                backdrop_above,
                picture,
                tile_sides,
                picture_backdrop,
                backdrop_lobe,
                sun_directions,
                sun_irradiances,
                sun_disc,
                surroundings,
                surrounding_sides,
                probes
            ]
        );
    }
}
