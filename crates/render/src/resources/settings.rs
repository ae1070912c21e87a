//! Settings of what is uploaded.

use crate::setting::settings;

settings! {
    /// Settings of the textures of models.
    pub struct TextureSettings {
        /// The widest and highest that textures of models may be: larger images are halved until they are not, and height
        /// maps made smaller. 0 leaves them as they are. Another number uploads all of them again.
        max_px: u32 = 0, in 0..=65536, unit "px";
    }
}
