//! Settings of the environment, and how it and the background are written.

use super::{Background, Environment};
use crate::setting::{
    LinearColor, SettingField, SettingInput, SettingType, SettingValue, read_word_or_color, settings, word_or_color,
};
use std::path::PathBuf;

settings! {
    /// Settings of the environment.
    pub struct EnvironmentSettings {
        /// The environment of the scene. `auto` is the picture of `environment.file`, if there is one. Else it is
        /// `studio`; `fill` (a faint studio) if the scene has lights; or `none` if it states an exposure as well. `sky`
        /// is computed from sun, air and ground.
        source: Environment = Environment::Auto;
        /// The environment map: an equirectangular picture, Radiance (.hdr) or OpenEXR (.exr), or a cube map (.ktx2). A
        /// folder with the six faces of a cube works, too (px, nx, py, ny, pz, nz; .hdr, .exr, .png or .jpg).
        file: PathBuf = PathBuf::new();
        /// The irradiance map, in place of the one computed from the picture. It holds irradiance divided by π, which a
        /// white matte surface reflects. It takes the same files as `environment.file`.
        irradiance_file: PathBuf = PathBuf::new();
        /// The prefiltered environment map, in place of the one computed from the picture. Its levels go from
        /// perceptual roughness 0 to 1 in equal steps. It is a cube map with levels (.ktx2), or a picture for each
        /// level: `room_{level}.hdr`, from `room_0.hdr` on. Without `environment.file` the first level is the picture,
        /// too.
        prefiltered_file: PathBuf = PathBuf::new();
        /// The split-sum BRDF table, in place of the built-in one: .png, .hdr or .exr, linear. F0 is multiplied by red,
        /// and green is added. Columns are n·v from 0 at the left to 1. Rows are perceptual roughness from 0 at the top
        /// to 1.
        brdf_file: PathBuf = PathBuf::new();
        /// The rotation of the environment map about the vertical, counter-clockwise seen from above.
        rotation_deg: f32 = 0.0, in -360.0..=360.0, unit "°";
        /// Multiplies the radiance of the environment.
        intensity: f32 = 1.0, in 0.0.., unit "factor";
        /// The elevation of the sky's sun above the horizon.
        sun_elevation_deg: f32 = 40.0, in -90.0..=90.0, unit "°", needs "environment.source=sky";
        /// The azimuth of the sky's sun: 0 is +Z, and it grows towards +X like the yaw of an orbit.
        sun_azimuth_deg: f32 = -45.0, in -360.0..=360.0, unit "°", needs "environment.source=sky";
        /// The haziness of the sky: the optical depth of air and haze straight up, divided by that of the air alone. 1
        /// is air without haze, 2 a clear day, 6 haze.
        turbidity: f32 = 2.0, in 1.0..=10.0, unit "factor", needs "environment.source=sky";
        /// The albedo of the ground below the sky.
        ground_albedo: f32 = 0.3, in 0.0..=1.0, needs "environment.source=sky";
    }
}

/// The words of an environment; a colour is another one.
const ENVIRONMENTS: [(&str, Environment); 6] = [
    ("auto", Environment::Auto),
    ("studio", Environment::Studio),
    ("fill", Environment::Fill),
    ("sky", Environment::Sky),
    ("file", Environment::File),
    ("none", Environment::None),
];

const BACKGROUNDS: [(&str, Background); 2] =
    [("environment", Background::Environment), ("transparent", Background::Transparent)];

impl SettingField for Environment {
    fn kind() -> SettingType {
        SettingType::ChoiceOrColor
    }

    fn choices() -> &'static [&'static str] {
        const {
            let [auto, studio, fill, sky, file, none] = ENVIRONMENTS;
            &[auto.0, studio.0, fill.0, sky.0, file.0, none.0]
        }
    }

    fn read(written: &SettingInput) -> Option<Self> {
        read_word_or_color(&ENVIRONMENTS, Self::Color, written)
    }

    fn value(&self) -> SettingValue {
        let color = if let Self::Color(linear) = self { Some(*linear) } else { None };
        word_or_color(&ENVIRONMENTS, self, color)
    }
}

impl SettingField for Background {
    fn kind() -> SettingType {
        SettingType::ChoiceOrColors
    }

    fn choices() -> &'static [&'static str] {
        const { &[BACKGROUNDS[0].0, BACKGROUNDS[1].0] }
    }

    fn read(written: &SettingInput) -> Option<Self> {
        let text = written.text();
        let pair = text.as_deref().and_then(|text| text.split_once(',')).and_then(|(below, above)| {
            Some(Self::Gradient([LinearColor::of_hex(below.trim())?.0, LinearColor::of_hex(above.trim())?.0]))
        });
        pair.or_else(|| read_word_or_color(&BACKGROUNDS, Self::Color, written))
    }

    fn value(&self) -> SettingValue {
        if let Self::Gradient(colors) = self {
            return SettingValue::Text(colors.map(|color| LinearColor(color).hex()).join(","));
        }
        let color = if let Self::Color(linear) = self { Some(*linear) } else { None };
        word_or_color(&BACKGROUNDS, self, color)
    }
}
