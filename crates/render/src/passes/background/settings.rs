//! Settings of what the camera sees where there is no surface.

use crate::environment::Background;
use crate::setting::settings;

settings! {
    /// Settings of what the camera sees where there is no surface.
    pub struct BackgroundSettings {
        /// What is seen behind the surfaces: the environment, nothing, or a colour that comes out as it is under every curve
        /// and exposure.
        source: Background = Background::Environment;
    }
}
