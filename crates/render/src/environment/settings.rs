//! Settings of the environment, and how it and the background are written.

use super::{Background, Environment};
use crate::setting::{
    LinearColor, SettingField, SettingType, SettingValue, Written, read_word_or_color, settings, word_or_color,
};
use std::path::PathBuf;

settings! {
    /// Settings of the environment.
    pub struct EnvironmentSettings {
        /// What surrounds the scene; `auto` is the picture of `environment.file` if there is one; else studio, or fill
        /// (a faint studio) where the scene brings its own lights, or none where it states an exposure as well. `sky`
        /// is computed from the sun, air and ground.
        source: Environment = Environment::Auto;
        /// An equirectangular picture, Radiance (.hdr) or OpenEXR (.exr), of the light from all directions, or a cube
        /// map (.ktx2); or a folder with the six faces of a cube (px, nx, py, ny, pz, nz; .hdr, .exr, .png or .jpg).
        file: PathBuf = PathBuf::new();
        /// The diffuse light of the picture, in place of what is worked out of it: what a white matte surface reflects
        /// that faces a direction, irradiance divided by π. Any file that `environment.file` takes.
        irradiance_file: PathBuf = PathBuf::new();
        /// What rough surfaces reflect of the picture, in place of what is worked out of it, by perceptual roughness
        /// from 0 to 1 in equal steps: a cube map with levels (.ktx2), or a picture for each, `room_{level}.hdr`, from
        /// `room_0.hdr` on. Without `environment.file` the first level is the picture, too.
        prefiltered_file: PathBuf = PathBuf::new();
        /// The share of light from everywhere that surfaces mirror, in place of Manypass's own table: .png, .hdr or
        /// .exr, linear; red is what f0 is multiplied by, green is added. Columns go by n·v from 0 at the left to 1,
        /// rows by perceptual roughness from 0 at the top to 1.
        brdf_file: PathBuf = PathBuf::new();
        /// By how much the picture is turned about the vertical, counter-clockwise seen from above.
        rotation_deg: f32 = 0.0, in -360.0..=360.0, unit "°";
        /// Multiplies the environment.
        intensity: f32 = 1.0, in 0.0.., unit "factor";
        /// How high the sun of the sky stands above the horizon.
        sun_elevation_deg: f32 = 40.0, in -90.0..=90.0, unit "°", needs "environment.source=sky";
        /// Where the sun of the sky stands: 0 is +Z, and it grows towards +X, as the yaw of an orbit does.
        sun_azimuth_deg: f32 = -45.0, in -360.0..=360.0, unit "°", needs "environment.source=sky";
        /// How hazy the sky is: the optical depth of air and haze straight up, divided by that of the air alone; 1 is
        /// air without haze, 2 a clear day, 6 haze.
        turbidity: f32 = 2.0, in 1.0..=10.0, unit "factor", needs "environment.source=sky";
        /// The share of light that the ground below the sky reflects.
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

    fn read(written: &Written) -> Option<Self> {
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

    fn read(written: &Written) -> Option<Self> {
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
