//! Settings of the display transform.

use crate::setting::settings;
use crate::tone_curve::Tonemap;

settings! {
    /// Settings of the display transform.
    pub struct ToneMapSettings {
        /// The curve from radiance to display colours.
        curve: Tonemap = Tonemap::Neutral;
        /// The amplitude of the dither.
        dither: f32 = 1.0, in 0.0..=2.0, unit "1/255";
    }
}
