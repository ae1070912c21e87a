//! Punctual lights in physical units (`KHR_lights_punctual`). A light shines along −Z of its node.

use glam::Vec3;

/// The most lights that are drawn: lists of lights hold numbers of 16 bits.
pub const LIGHTS_MAX: u32 = 65_535;

/// The shortest range that is read, in metres.
pub const RANGE_MIN_M: f64 = 1e-6;

/// The narrowest cone of a spot, from its axis, in radians: 32 bits do not tell the cosines of narrower ones apart.
pub const CONE_MIN_RAD: f32 = 1e-3;

/// The kind of a light: point, spot or directional.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Parallel light; intensity is illuminance in lux.
    Directional,
    /// Light from a point; intensity is luminous intensity in candela.
    Point,
    /// A cone of light from a point; intensity is in candela.
    Spot {
        /// Within this angle from the axis the light is at its full strength, in radians.
        inner_cone_rad: f32,
        /// Beyond this angle from the axis there is no light, in radians.
        outer_cone_rad: f32,
    },
}

/// The mode of a light: its direct and indirect light is baked, or computed in frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LightMode {
    /// Frames add it, and bakers leave it out: it may move and change.
    Dynamic,
    /// Frames add what comes straight from it, with its highlights and shadows; bakers what surfaces send back.
    #[default]
    Mixed,
    /// Bakers put all of it into light maps and probes, and frames leave it out.
    Baked,
}

impl LightMode {
    /// The words for all of them.
    pub const NAMES: [&str; 3] = ["dynamic", "mixed", "baked"];

    /// The one of a word.
    pub fn named(word: &str) -> Option<Self> {
        match word {
            "dynamic" => Some(Self::Dynamic),
            "mixed" => Some(Self::Mixed),
            "baked" => Some(Self::Baked),
            _ => None,
        }
    }

    /// Its word.
    pub fn name(self) -> &'static str {
        let [dynamic, mixed, baked] = Self::NAMES;
        match self {
            Self::Dynamic => dynamic,
            Self::Mixed => mixed,
            Self::Baked => baked,
        }
    }
}

/// A light; its place and direction are those of the node that holds it.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// The name in the file; empty if it has none.
    pub name: String,
    /// Linear Rec. 709 colour.
    pub color_linear: Vec3,
    /// Candela for point and spot lights, lux for directional ones.
    pub intensity: f32,
    /// Beyond this distance in metres the light is nothing; none means that it only falls off with the square.
    pub range_m: Option<f32>,
    /// The shape of its emission.
    pub kind: LightKind,
    /// The radius in metres of the sphere that gives the light, for the width of its penumbrae; 0 is a point. Of
    /// directional light this is the tangent of half the angle that its source takes in the sky.
    pub radius_m: f32,
    /// Whether surfaces keep its light from what lies behind them.
    pub casts_shadows: bool,
    /// Whether it is baked. In glTF files `extras.mode` of the light says so.
    pub mode: LightMode,
}

impl Default for Light {
    /// A white point of one candela that casts shadows.
    fn default() -> Self {
        Self {
            name: String::new(),
            color_linear: Vec3::ONE,
            intensity: 1.0,
            range_m: None,
            kind: LightKind::Point,
            radius_m: 0.0,
            casts_shadows: true,
            mode: LightMode::default(),
        }
    }
}
