//! The curve from radiance to display colours, chosen when a pipeline is made (`shaders/tone_curve.wgsl`).

use crate::constants::{CURVE_ACES, CURVE_AGX, CURVE_EXPONENTIAL, CURVE_NEUTRAL, CURVE_NONE, CURVE_REINHARD};
use crate::setting::choices;
use crate::shader::program::Constant;

choices! {
    /// The curve from radiance to display colours.
    pub enum Tonemap {
        /// Khronos PBR Neutral.
        #[default]
        Neutral = "neutral",
        /// Hill's fit of ACES, exposure divided by 0.6.
        Aces = "aces",
        /// AgX.
        Agx = "agx",
        /// Reinhard, on luminance.
        Reinhard = "reinhard",
        /// 1 − exp(−x).
        Exponential = "exponential",
        /// Values above 1 are cut off.
        None = "none",
    }
}

impl Tonemap {
    /// The constant of `shaders/tone_curve.wgsl` that chooses this curve.
    pub(crate) fn constant(self) -> Constant {
        let number = match self {
            Self::None => CURVE_NONE,
            Self::Neutral => CURVE_NEUTRAL,
            Self::Aces => CURVE_ACES,
            Self::Agx => CURVE_AGX,
            Self::Reinhard => CURVE_REINHARD,
            Self::Exponential => CURVE_EXPONENTIAL,
        };
        ("curve", number)
    }
}
