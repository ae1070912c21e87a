//! Settings of several samples a pixel.

use crate::setting::{NumberType, Scalar, SettingField, SettingType, SettingValue, Written, settings};

/// How many samples of a pixel surfaces cover each for itself. Every adapter has these numbers, and no other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PixelSamples {
    /// The middle of the pixel, or for stills the place of the frame's sample.
    #[default]
    One,
    /// Four places.
    Four,
}

impl PixelSamples {
    const NUMBERS: &'static [&'static str] = &["1", "4"];

    /// The number.
    pub fn count(self) -> u32 {
        match self {
            Self::One => 1,
            Self::Four => 4,
        }
    }
}

impl SettingField for PixelSamples {
    fn kind() -> SettingType {
        SettingType::Number(NumberType { scalar: Scalar::U32, count: 1 })
    }

    fn choices() -> &'static [&'static str] {
        Self::NUMBERS
    }

    fn read(written: &Written) -> Option<Self> {
        [Self::One, Self::Four].into_iter().find(|samples| u32::read(written) == Some(samples.count()))
    }

    fn value(&self) -> SettingValue {
        self.count().value()
    }
}

settings! {
    /// Settings of multisampling, several samples of a pixel that are shaded once.
    pub struct MultisamplingSettings {
        /// How many samples of each pixel surfaces cover, while they are shaded once a pixel: 4 make edges smooth,
        /// those of masks too (alpha to coverage). For `render.path=forward` alone, other paths are refused.
        samples: PixelSamples = PixelSamples::One, needs "render.path=forward";
    }
}
