//! What a decal is: a picture, and the box that throws it.

use crate::NodeId;
use crate::capture::LAYERS_ALL;
use glam::{Mat4, Vec2, Vec3, Vec4};
use std::sync::Arc;

/// How much of what lies below a decal each of its parts hides, from 0 to 1, where its picture hides all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DecalOpacity {
    /// Base colour, and whether that is metal's.
    pub color: f32,
    /// The normal.
    pub normal: f32,
    /// Roughness.
    pub roughness: f32,
    /// Emission.
    pub emission: f32,
}

impl DecalOpacity {
    /// The same with another opacity of roughness.
    pub fn with_roughness(self, roughness: f32) -> Self {
        Self { roughness, ..self }
    }
}

/// What decals show. Many may share one.
#[derive(Clone, Debug, PartialEq)]
pub struct DecalLook {
    /// Base colour, linear; times that of the image.
    pub color: Vec3,
    /// Index into [`crate::Scene::images`]: base colour, and in alpha how much of it there is, for all parts of the decal.
    pub color_image: Option<usize>,
    /// Whether its base colour is that of metal, times blue of [`Self::rough_metal_image`].
    pub metallic: f32,
    /// Perceptual roughness, times green of [`Self::rough_metal_image`].
    pub roughness: f32,
    /// Index into [`crate::Scene::images`]: roughness in green, metallic in blue, as in glTF.
    pub rough_metal_image: Option<usize>,
    /// Index into [`crate::Scene::images`]: a normal map as of glTF, whose X goes to the right and Y up in the picture.
    pub normal_image: Option<usize>,
    /// By how much the normals lean.
    pub normal_scale: f32,
    /// What it emits, linear: radiance in the scene's units, cd/m² where lights are lux and candela; times that of the
    /// image.
    pub emission: Vec3,
    /// Index into [`crate::Scene::images`].
    pub emission_image: Option<usize>,
    /// How much of what is below is hidden.
    pub opacity: DecalOpacity,
}

impl DecalLook {
    /// Whether it makes what it covers smoother than `roughness` somewhere; its image may say anything.
    pub fn may_be_smooth(&self, roughness: f32) -> bool {
        self.opacity.roughness > 0.0 && (self.roughness < roughness || self.rough_metal_image.is_some())
    }
}

impl Default for DecalLook {
    fn default() -> Self {
        Self {
            color: Vec3::ONE,
            color_image: None,
            metallic: 0.0,
            roughness: 1.0,
            rough_metal_image: None,
            normal_image: None,
            normal_scale: 1.0,
            emission: Vec3::ZERO,
            emission_image: None,
            opacity: DecalOpacity { color: 1.0, normal: 1.0, roughness: 0.0, emission: 0.0 },
        }
    }
}

/// A box that throws a picture onto the surfaces within it.
#[derive(Clone, Debug, PartialEq)]
pub struct Decal {
    /// Its name, in messages.
    pub name: String,
    /// The node in whose space it is placed, and with which it moves and is hidden; none for world space.
    pub node: Option<NodeId>,
    /// From a box whose sides are 1, around the origin, to that space. The picture lies in its X and Y, and is thrown along
    /// its −Z, all the way through.
    pub parent_from_box: Mat4,
    /// What it shows.
    pub look: Arc<DecalLook>,
    /// By how much surfaces may be turned away from +Z, in radians: up to the first angle they show all of it, from the
    /// second on nothing.
    pub angle_rad: Vec2,
    /// The layers ([`crate::Node::layers`]) on whose surfaces it is, a bit each.
    pub layers: u32,
    /// Those of higher order lie over those of lower; of equal ones later ones over earlier ones.
    pub order: i32,
}

impl Decal {
    /// A box of one metre around the origin, thrown along −Z onto all layers.
    pub fn new(name: impl Into<String>, look: impl Into<Arc<DecalLook>>) -> Self {
        Self {
            name: name.into(),
            node: None,
            parent_from_box: Mat4::IDENTITY,
            look: look.into(),
            angle_rad: Vec2::new(60.0, 80.0) * (std::f32::consts::PI / 180.0),
            layers: LAYERS_ALL,
            order: 0,
        }
    }

    /// Puts the middle of the box at `center`, thrown along `direction`, with the upper edge of the picture towards
    /// `up`; width and height of the picture, and depth of the box along the direction, in metres. Of `up` only what is
    /// across the direction counts; where nothing is, some other direction is taken.
    pub fn place(&mut self, center: Vec3, direction: Vec3, up: Vec3, size_m: Vec3) {
        let z = -direction.normalize_or(Vec3::NEG_Z);
        let y = (up - z * up.dot(z)).normalize_or_zero();
        let y = if y == Vec3::ZERO { z.any_orthonormal_vector() } else { y };
        let x = y.cross(z);
        let axis = |axis: Vec3, length: f32| (axis * length).extend(0.0);
        self.parent_from_box =
            Mat4::from_cols(axis(x, size_m.x), axis(y, size_m.y), axis(z, size_m.z), center.extend(1.0));
    }

    /// Whether its box has no volume, or a number in it is none.
    pub fn is_flat(matrix: &Mat4) -> bool {
        let volume = matrix.determinant();
        let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(Vec4::length);
        !volume.is_finite() || volume.abs() < f32::MIN_POSITIVE || !axes.iter().all(|length| *length > 1e-6)
    }
}
