//! Settings of AOVs.

use crate::setting::settings;

settings! {
    /// Settings of AOVs.
    pub struct AovSettings {
        /// Whether AOVs show the first surface of a pixel, also a blended one (with alpha of at least 1/255) or a
        /// transmissive one. Otherwise they show the opaque surface behind. `radiance` does not change.
        first_surface: bool = false;
    }
}
