//! Why nothing was baked.

/// Why nothing was baked.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BakeError {
    /// A setting is out of range.
    #[error("the bake asks for {0}")]
    Setting(String),
    /// No surface can have light.
    #[error(
        "the scene has no surface to bake: none is opaque, lit and static; animated, skinned and transmissive surfaces are left out"
    )]
    Nothing,
    /// The maps would be too large.
    #[error(
        "{texels_per_m} texels a metre are {texels} texels together, more than {max}; up to {possible:.3} texels a metre are possible",
        max = crate::TEXELS_MAX
    )]
    TooLarge {
        /// The texels of all surfaces together.
        texels: u64,
        /// What was asked for.
        texels_per_m: f32,
        /// What would be possible.
        possible: f64,
    },
    /// Surfaces cannot be laid out.
    #[error("the surfaces cannot be laid out: {0}")]
    Layout(String),
    /// A picture cannot be written.
    #[error("the light cannot be written: {0}")]
    Encode(String),
    /// Whoever watched said to stop.
    #[error("interrupted")]
    Interrupted,
}
