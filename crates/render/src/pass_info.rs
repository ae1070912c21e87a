//! What every pass says of itself, for decisions that look at all of them: `PASS` in `passes/NAME/mod.rs`, which
//! `passes/mod.rs` lists.

use crate::render_settings::Path;

/// How far beside its own pixel a pass looks while later samples of a still skip converged tiles, whose pixels hold
/// nothing then.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// At its own pixel, or at what is whole in every sample: the atlas of shadows, the environment.
    OwnPixel,
    /// Around in the first samples, which draw all tiles. Later ones take what those found, on the deferred path alone.
    FirstSamples,
    /// Around in every sample: no tile can be skipped.
    EverySample,
}

/// Tiers of quality that record a pass which no tier switches off.
const TIERS: &[&str] = &["low", "medium", "high", "ultra"];

/// What a pass says of itself.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(
    not(test),
    allow(dead_code, reason = "tests compare what no decision reads with tiers, variables and effects")
)]
pub struct PassInfo {
    /// Its folder, with which the names of its steps begin.
    pub name: &'static str,
    /// The setting that switches it off, as `key=value`. None: it is recorded where the scene or a request needs it.
    pub off: Option<&'static str>,
    /// The paths that have it.
    pub paths: &'static [Path],
    /// Whether the views of a fisheye's sides have it, at whose edges screen space ends.
    pub in_fisheye: bool,
    /// The tiers of quality that have it, by their names.
    pub tiers: &'static [&'static str],
    /// The variables (AOVs) that show what it writes, by their names.
    pub variables: &'static [&'static str],
    /// What effects read of it (`//! reads: …`).
    pub effect_inputs: &'static [&'static str],
}

impl PassInfo {
    /// A pass that nothing switches off, for no variable and no effect.
    pub const fn new(name: &'static str) -> Self {
        Self {
            name,
            off: None,
            paths: &[Path::Deferred, Path::Forward, Path::ForwardBatched, Path::Gouraud],
            in_fisheye: true,
            tiers: TIERS,
            variables: &[],
            effect_inputs: &[],
        }
    }

    /// A pass that the deferred path alone has.
    pub const fn deferred(name: &'static str) -> Self {
        Self { paths: &[Path::Deferred], ..Self::new(name) }
    }
}
