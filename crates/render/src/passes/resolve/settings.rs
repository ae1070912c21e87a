//! Settings of multisampling.

use crate::setting::{NumberType, Scalar, SettingField, SettingInput, SettingType, SettingValue, settings};

/// The number of samples a pixel in multisampling. All adapters have these two numbers, and no other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PixelSamples {
    /// One: the middle of the pixel, or in stills the position of the frame's sample.
    #[default]
    One,
    /// Four samples.
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

    fn read(written: &SettingInput) -> Option<Self> {
        [Self::One, Self::Four].into_iter().find(|samples| u32::read(written) == Some(samples.count()))
    }

    fn value(&self) -> SettingValue {
        self.count().value()
    }
}

settings! {
    /// Settings of multisampling (MSAA): several samples of a pixel are covered and shaded once.
    pub struct MultisamplingSettings {
        /// The number of samples of each pixel that surfaces cover (MSAA). They are shaded once a pixel. 4 smooths
        /// edges, also of masks (alpha to coverage). Only `render.path=forward` takes it; other paths refuse it.
        samples: PixelSamples = PixelSamples::One, needs "render.path=forward";
    }
}
