//! The ground: a plane under the scene that catches its shadow, and is no part of the scene.
//!
//! What the scene takes from it of light is a map of the plane, drawn when the scene or the light has changed and not
//! in every frame (`passes/ground`). It has two causes: the parallel light that stands before the others (that of the
//! environment, else the first of the scene, else the broad source of a picture or the key of the faint studio), past
//! what casts shadows; and light from everywhere, past what hangs over the plane. Lights at a place do not reach it.

mod map;
mod settings;

use map::EDGE_BAND;
pub(crate) use map::{GroundMap, ParallelLight, side_texels};
pub use settings::GroundSettings;

use crate::colour::finite_product;
use crate::environment::{Background, Environment};
use crate::lights::LightTable;
use crate::view::View;
use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3, Vec4};
use manypass_scene::{Aabb, EnvironmentLight, LightKind, Projection};

/// The ground under the scene: a shadow catcher, a floor or nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Ground {
    /// A shadow where the environment is the studio, be it faint, the sky or a picture, and the background is not
    /// transparent; else nothing.
    #[default]
    Auto,
    /// A plane that is seen by its shadow alone: it darkens the background as a surface there would be darker.
    Shadow,
    /// Nothing.
    None,
    /// A plane of this albedo, linear Rec. 709, which ends in the background far from the scene.
    Color([f32; 3]),
}

impl Ground {
    /// With [`Self::Auto`] as it is before a background in an environment.
    pub fn resolved(self, environment: Environment, background: Background) -> Self {
        match self {
            Self::Auto if has_ground(environment) && background != Background::Transparent => Self::Shadow,
            Self::Auto => Self::None,
            ground => ground,
        }
    }
}

/// Whether the border of a picture has to be its background exactly: where that is of colours or nothing. Before an
/// environment a shadow runs out of the picture, as in a photograph.
pub(crate) fn keeps_border(environment: Environment, background: Background) -> bool {
    background != Background::Environment || !has_ground(environment)
}

fn has_ground(environment: Environment) -> bool {
    matches!(environment, Environment::Studio | Environment::Fill | Environment::Sky | Environment::File)
}

/// The uniform of `ground.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct GroundUniform {
    /// The height of the plane in metres, the distances from the middle between which it ends, zero.
    plane: Vec4,
    /// The x and z of the map's middle, one divided by its width and depth in metres.
    place: Vec4,
    /// Albedo; 1 if it is a surface, 0 if it is seen by its shadow alone.
    color: Vec4,
    /// Irradiance of the parallel light on the plane, pre-exposed; 1 if it is part of the light from everywhere.
    light: Vec4,
    /// How much the picture's border counts; over how many metres beside the scene it comes to count wholly for
    /// occlusion; zero.
    border: Vec4,
    /// X and z of the middle of the scene's bounds, half their width and depth.
    footprint: Vec4,
}

/// How far a view shows a scene as a whole, and not from near: 1 where all of it is in the picture. It goes by the
/// sphere around the scene's bounds, so that it stays as it is while a camera goes around the scene.
fn wholeness(view: &View, aspect: f32, center: Vec3, radius_m: f32) -> f32 {
    let half_extent = view.projection.half_extent(aspect).max_element();
    let sphere = match view.projection {
        Projection::Orthographic { .. } => radius_m,
        Projection::Perspective { .. } => {
            let distance_m = view.world_from_view.w_axis.truncate().distance(center);
            radius_m / (distance_m * distance_m - radius_m * radius_m).max(1e-12).sqrt()
        }
    };
    // The sphere around a cube that fills the picture is up to 2.2 times as large as that.
    let excess = ((sphere / half_extent - 2.5) / 2.5).clamp(0.0, 1.0);
    1.0 - excess * excess * (3.0 - 2.0 * excess)
}

/// The ground as a view has it.
#[derive(Clone, Debug)]
pub(crate) struct ViewGround {
    pub uniform: GroundUniform,
    /// The map of the plane.
    pub map: wgpu::TextureView,
    /// The corners of the map, where the plane is seen by its shadow alone: beyond there is none.
    pub shadow: Option<[Vec3; 4]>,
}

impl ViewGround {
    /// The height of the plane.
    pub fn height_m(&self) -> f32 {
        self.uniform.plane.x
    }

    /// `ground` is resolved; none where there is nothing. `picture` is the camera of a picture whose border is kept
    /// free, and its width / height: the shadow has faded to nothing there where it shows the scene as a whole.
    pub fn new(
        ground: Ground,
        (map, texture): (&GroundMap, &wgpu::TextureView),
        light: Option<GroundLight>,
        picture: Option<(&View, f32)>,
    ) -> Option<Self> {
        let color = match ground {
            Ground::None | Ground::Auto => return None,
            Ground::Shadow => Vec4::ZERO,
            Ground::Color(color) => Vec3::from(color).min(Vec3::ONE).extend(1.0),
        };
        let on_plane = |light: GroundLight| {
            let irradiance = light.irradiance * light.parallel.direction.y.max(0.0);
            irradiance.extend(f32::from(u8::from(light.is_from_everywhere)))
        };
        let GroundMap { height_m, center, half_m, radius_m, bounds, .. } = *map;
        // A floor has no border in the picture.
        let picture = picture.filter(|_| ground == Ground::Shadow);
        let whole = picture.map_or(0.0, |(view, aspect)| wholeness(view, aspect, bounds.center(), radius_m));
        let middle = bounds.center();
        let half_extent = (0.5 * (bounds.max - bounds.min)).max(Vec3::splat(1e-3 * radius_m));
        let uniform = GroundUniform {
            plane: Vec4::new(height_m, 2.0 * radius_m, 6.0 * radius_m, 0.0),
            place: Vec4::new(center.x, center.y, 0.5 / half_m.x, 0.5 / half_m.y),
            color,
            light: light.map_or(Vec4::ZERO, on_plane),
            border: Vec4::new(whole, 0.5 * radius_m, 0.0, 0.0),
            footprint: Vec4::new(middle.x, middle.z, half_extent.x, half_extent.z),
        };
        let corner = |x: f32, z: f32| Vec3::new(center.x + x * half_m.x, height_m, center.y + z * half_m.y);
        let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0)];
        Some(Self { uniform, map: texture.clone(), shadow: (ground == Ground::Shadow).then_some(corners) })
    }
}

/// The light of which the ground catches the shadow.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GroundLight {
    pub parallel: ParallelLight,
    /// On a plane across it, pre-exposed.
    irradiance: Vec3,
    /// Whether light from everywhere holds it, which is then without it.
    is_from_everywhere: bool,
}

impl GroundLight {
    /// The parallel light that stands before the others of a table.
    pub fn of_table(table: &LightTable) -> Option<Self> {
        let light = table.lights.first().filter(|light| light.kind == LightKind::Directional)?;
        let [red, green, blue, _] = *table.texels.get(1)?;
        let casts_shadows = light.casts_shadows;
        let parallel = ParallelLight { direction: -light.direction, half_angle_tan: light.radius_m, casts_shadows };
        Some(Self { parallel, irradiance: Vec3::new(red, green, blue), is_from_everywhere: false })
    }

    /// A source within the light from everywhere, turned and as strong as its environment is.
    pub fn of_broad_source(source: &EnvironmentLight, pre_exposure: f32) -> Self {
        let EnvironmentLight { direction, irradiance, half_angle_tan } = *source;
        let parallel = ParallelLight { direction, half_angle_tan, casts_shadows: true };
        let irradiance = irradiance.map(|value| finite_product(value, pre_exposure));
        Self { parallel, irradiance, is_from_everywhere: true }
    }
}

/// The map of the plane under `bounds` at `height_m`; none under nothing.
pub(crate) fn map_under(
    bounds: &Aabb,
    height_m: Option<f32>,
    light: Option<ParallelLight>,
    side_texels: u32,
) -> Option<GroundMap> {
    let radius_m = bounds.radius_m();
    if bounds.is_empty() || !(radius_m.is_finite() && radius_m > 0.0) {
        return None;
    }
    let height_m = height_m.unwrap_or(bounds.min.y).min(bounds.max.y);
    let top_m = (bounds.max.y - height_m).max(1e-3 * radius_m);
    let [low, high] = [bounds.min, bounds.max].map(|corner| Vec2::new(corner.x, corner.z));
    // What hangs over the plane darkens it as far as this around.
    let margin = Vec2::splat(0.6 * (bounds.max - bounds.min).max_element());
    let (mut least, mut most) = (low - margin, high + margin);
    if let Some(light) = light.filter(ParallelLight::reaches) {
        // Where the shadow of the top lies, with its penumbra; of a light that stands low not all of it.
        let shift = Vec2::new(light.direction.x, light.direction.z) * (-top_m / light.direction.y);
        let shift = shift.clamp_length_max(6.0 * radius_m);
        let penumbra = Vec2::splat(light.half_angle_tan.min(1.0) * (shift.length() + top_m));
        let (low, high) = (low + shift - penumbra, high + shift + penumbra);
        // A side is so far from the one across that the shadow ends beside the band.
        let beyond = |end: Vec2, across: Vec2| (end - 0.5 * EDGE_BAND * across) / (1.0 - 0.5 * EDGE_BAND);
        (least, most) = (least.min(beyond(low, most.max(high))), most.max(beyond(high, least.min(low))));
    }
    let (center, half_m) = (0.5 * (least + most), (0.5 * (most - least)).max(Vec2::splat(1e-6 * radius_m)));
    Some(GroundMap { height_m, top_m, center, half_m, radius_m, light, bounds: *bounds, side_texels })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!("ground", "Ground", GroundUniform, [plane, place, color, light, border, footprint]);
    }

    #[test]
    fn what_lights_from_everywhere_has_a_shadow_under_the_scene_unasked() {
        let of = |environment, background| Ground::Auto.resolved(environment, background);
        assert_eq!(of(Environment::Studio, Background::Environment), Ground::Shadow);
        assert_eq!(of(Environment::Studio, Background::Color([1.0; 3])), Ground::Shadow);
        assert_eq!(of(Environment::Fill, Background::Environment), Ground::Shadow);
        assert_eq!(of(Environment::Studio, Background::Transparent), Ground::None);
        for environment in [Environment::File, Environment::Sky] {
            assert_eq!(of(environment, Background::Environment), Ground::Shadow);
            assert_eq!(of(environment, Background::Transparent), Ground::None);
        }
        for environment in [Environment::None, Environment::Color([1.0; 3])] {
            assert_eq!(of(environment, Background::Environment), Ground::None);
        }
        assert_eq!(Ground::Shadow.resolved(Environment::None, Background::Transparent), Ground::Shadow);
    }

    #[test]
    fn the_border_is_kept_free_before_colours_and_nothing() {
        for environment in [Environment::Studio, Environment::Fill, Environment::Sky, Environment::File] {
            assert!(!keeps_border(environment, Background::Environment), "{environment:?}");
            for background in
                [Background::Color([1.0; 3]), Background::Gradient([[0.5; 3]; 2]), Background::Transparent]
            {
                assert!(keeps_border(environment, background), "{environment:?}, {background:?}");
            }
        }
        for environment in [Environment::None, Environment::Color([1.0; 3])] {
            assert!(keeps_border(environment, Background::Environment), "{environment:?}");
        }
    }

    #[test]
    fn the_map_holds_the_shadow_of_the_top() {
        let bounds = Aabb { min: Vec3::new(-1.0, 0.0, -1.0), max: Vec3::new(1.0, 4.0, 1.0) };
        let direction = Vec3::new(-1.0, 1.0, 0.0).normalize();
        let light = ParallelLight { direction, half_angle_tan: 0.1, casts_shadows: true };
        let holds = |map: &GroundMap, x: f32| (x - map.center.x).abs() <= map.half_m.x;
        let lit = map_under(&bounds, None, Some(light), 256).expect("there is something");
        assert!(holds(&lit, 5.0) && holds(&lit, -3.0) && !holds(&lit, -6.0));
        // Light comes back along its edge, and not before the shadow of the top and its penumbra end.
        let end = (5.8 - lit.center.x) / lit.half_m.x;
        assert!(end <= 1.0 - EDGE_BAND + 1e-3, "{end}");
        let unlit = map_under(&bounds, None, None, 256).expect("there is something");
        assert!(!holds(&unlit, 5.0));
        assert!(map_under(&Aabb::EMPTY, None, None, 256).is_none());
    }
}
