//! How pictures within the picture are drawn.

/// The layers that a node is in where nobody says: the first.
pub const LAYERS_DEFAULT: u32 = 1;

/// All layers.
pub const LAYERS_ALL: u32 = u32::MAX;

/// When a picture within the picture is drawn anew, where frames of a live view follow each other. Stills, and every
/// picture of a sequence, depend on nothing before them: there it always is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Update {
    /// In every frame that shows it.
    #[default]
    Always,
    /// In the first frame that shows it, and then in one of so many.
    Every(u32),
    /// In the first frame that shows it.
    Once,
}

/// How a picture within the picture is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct CaptureOptions {
    /// When it is drawn anew.
    pub update: Update,
    /// The layers that it shows ([`crate::Node::layers`]), a bit each.
    pub layers: u32,
    /// The tier of quality whose passes draw it; none for that of the picture that shows it.
    pub quality: Option<String>,
}

impl Default for CaptureOptions {
    fn default() -> Self {
        Self { update: Update::Always, layers: LAYERS_ALL, quality: None }
    }
}
