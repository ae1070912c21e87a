//! Settings of textures.

use crate::setting::settings;

settings! {
    /// Settings of the textures of models.
    pub struct TextureSettings {
        /// The largest width and height of a model's textures. Larger images are halved until they fit, and height maps
        /// are scaled down. 0 leaves all sizes. Another number uploads all textures again.
        max_px: u32 = 0, in 0..=65536, unit "px";
    }
}
