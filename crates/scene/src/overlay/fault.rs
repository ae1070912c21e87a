//! What is wrong with what is drawn over a picture, and the largest sizes.

/// The largest size of a font in pixels.
pub(crate) const TEXT_SIZE_PX_MAX: f32 = 1000.0;
/// The largest width of a line, side of a sprite, and padding, in pixels.
pub(crate) const SIDE_PX_MAX: f32 = 16384.0;

/// Why an item cannot be drawn.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{key}`: {message}")]
pub struct OverlayFault {
    /// The key of stage files that says it.
    pub key: &'static str,
    /// What is wrong, and what to do.
    pub message: String,
}
