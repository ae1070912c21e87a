//! The curve from radiance to display colours, chosen when a shader is composed (`shaders/tone_curve.wgsl`).

use serde::{Deserialize, Serialize};

/// The curve from radiance to display colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Tonemap {
    /// Values above 1 are cut off.
    None,
    /// Khronos PBR Neutral.
    #[default]
    Neutral,
    /// Hill's fit of ACES, exposure divided by 0.6.
    Aces,
    /// AgX.
    Agx,
    /// Reinhard, on luminance.
    Reinhard,
    /// 1 − exp(−x).
    Exponential,
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
