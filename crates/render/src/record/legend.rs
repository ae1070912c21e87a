//! Legends: what the colours mean that a pass draws.

use super::TargetTexels;
use std::borrow::Cow;
use std::cell::RefCell;

/// An entry of a pass's legend: a colour and its meaning.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LegendEntry {
    /// A few words.
    pub label: Cow<'static, str>,
    /// The colour, sRGB.
    pub color_srgb: [u8; 3],
}

/// What the passes of a frame say of their pictures.
#[derive(Debug, Default)]
pub(crate) struct Legends {
    /// Legends, each with the name of its pass.
    of_passes: RefCell<Vec<(String, Vec<LegendEntry>)>>,
    /// What targets hold.
    pub texels: TargetTexels,
}

impl Legends {
    /// Adds that of the pass `pass` of the view `view`.
    pub fn add(&self, view: &str, pass: &str, entries: Vec<LegendEntry>) {
        let name = if view.is_empty() { pass.into() } else { format!("{view}/{pass}") };
        self.of_passes.borrow_mut().push((name, entries));
    }

    /// All of them, for whoever outlives the frame; none are left here.
    pub fn take(&self) -> Self {
        Self { of_passes: RefCell::new(self.of_passes.take()), texels: self.texels.take() }
    }

    /// That of the pass whose name in the graph is `pass`; empty if it has none.
    #[cfg_attr(target_arch = "wasm32", allow(dead_code, reason = "a browser reads no pictures of passes"))]
    pub fn of(&self, pass: &str) -> Vec<LegendEntry> {
        let all = self.of_passes.borrow();
        all.iter().find(|(name, _)| name == pass).map(|(_, entries)| entries.clone()).unwrap_or_default()
    }
}
