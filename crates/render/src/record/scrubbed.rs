//! What a frame exports that counts pixels which are no numbers.

use manypass_graph::Export;
use std::cell::RefCell;

/// The textures in which such pixels are 1; none where nobody counts.
#[derive(Debug, Default)]
pub(crate) struct ScrubMasks(Option<RefCell<Vec<Export>>>);

impl ScrubMasks {
    /// Of a frame that counts them, or of one that does not.
    pub fn new(counts: bool) -> Self {
        Self(counts.then(RefCell::default))
    }

    pub fn is_counted(&self) -> bool {
        self.0.is_some()
    }

    pub fn add(&self, export: Export) {
        if let Some(exports) = &self.0 {
            exports.borrow_mut().push(export);
        }
    }

    pub fn exports(&self) -> Vec<Export> {
        self.0.as_ref().map(|exports| exports.borrow().clone()).unwrap_or_default()
    }
}
