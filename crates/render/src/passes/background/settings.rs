//! Settings of the background.

use crate::environment::Background;
use crate::setting::settings;

settings! {
    /// Settings of the background, which the camera sees where there is no surface.
    pub struct BackgroundSettings {
        /// The background: the environment, nothing, or a colour that no tone curve or exposure changes. Two colours,
        /// `rrggbb,rrggbb`, are a gradient from the lower to the upper edge of the picture.
        source: Background = Background::Environment;
        /// The blur of the environment map in the background: 0 is sharp, 1 as a rough surface reflects it.
        blur: f32 = 0.0, in 0.0..=1.0;
    }
}
