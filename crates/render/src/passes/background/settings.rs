//! Settings of what the camera sees where there is no surface.

use crate::environment::Background;
use crate::setting::settings;

settings! {
    /// Settings of what the camera sees where there is no surface.
    pub struct BackgroundSettings {
        /// What is seen behind the surfaces: the environment, nothing, or a colour that comes out as it is under every
        /// curve and exposure; or two, `rrggbb,rrggbb`, at the lower and at the upper edge of the picture.
        source: Background = Background::Environment;
        /// How blurred the picture of an environment is seen: 0 is sharp, 1 as a rough surface reflects it.
        blur: f32 = 0.0, in 0.0..=1.0;
    }
}
