//! The curve from radiance to display colours, chosen when a shader is composed (`shaders/tone_curve.wgsl`).

use crate::setting::choices;

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
    /// The variant axes of `shaders/tone_curve.wgsl` that choose this curve.
    pub(crate) fn axes(self) -> &'static [&'static str] {
        match self {
            Self::None => &[],
            Self::Neutral => &["curve_0"],
            Self::Aces => &["curve_1"],
            Self::Agx => &["curve_0", "curve_1"],
            Self::Reinhard => &["curve_2"],
            Self::Exponential => &["curve_0", "curve_2"],
        }
    }
}
