//! What a frame is run for: what of it is drawn, what lasts of it, and what is read back.

use crate::passes::present::Target;
use manypass_graph::{RunOptions, Taps, Timing};

/// What a frame is run for. The public functions make it, mostly as a difference to [`Self::PICTURE`] or [`Self::BESIDE`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Purpose<'t> {
    /// Whether it is run. If not, it is planned alone.
    pub is_run: bool,
    /// Whether it ends once shadow maps have their tiles: no pass is recorded, so that no pipeline is made.
    pub ends_at_shadows: bool,
    /// Whether it is one of those that make the picture: it adds to means, and histories go on.
    pub is_picture: bool,
    /// Whether simulations step to the scene's time. Whoever looks at the same picture once more finds them as they are.
    pub steps_simulations: bool,
    /// Whether monitors, mirrors, portals and probes are drawn. If not, they show what they showed last.
    pub draws_captures: bool,
    /// Whether it is exposed as pictures are. Light that irradiance probes find at another exposure is not kept.
    pub is_exposed: bool,
    /// Whether effects are drawn and the picture is made. If not, radiance goes no further.
    pub draws_picture: bool,
    /// Whether the picture is shown, with what is drawn over it.
    pub shows_picture: bool,
    /// Where the picture is drawn, too.
    pub target: Option<&'t Target>,
    /// Whether the frame's variables can be read afterwards.
    pub keeps_variables: bool,
    /// Whether variables are drawn, and nothing else.
    pub draws_variables_alone: bool,
    /// Whether pairs of light and what it may reach are counted in place of light.
    pub counts_pairs: bool,
    /// Whether pixels are counted that are no numbers.
    pub counts_scrubbed: bool,
    /// Whether the targets of all passes are read. All shadow maps are drawn for that.
    pub reads_passes: bool,
    /// Whether passes are timed.
    pub times_passes: bool,
}

impl Purpose<'static> {
    /// A picture.
    pub const PICTURE: Self = Self {
        is_run: true,
        ends_at_shadows: false,
        is_picture: true,
        steps_simulations: true,
        draws_captures: true,
        is_exposed: true,
        draws_picture: true,
        shows_picture: true,
        target: None,
        keeps_variables: true,
        draws_variables_alone: false,
        counts_pairs: false,
        counts_scrubbed: false,
        reads_passes: false,
        times_passes: false,
    };

    /// A frame beside those that make the picture, which leaves means and histories as they are.
    pub const BESIDE: Self =
        Self { is_picture: false, steps_simulations: false, keeps_variables: false, ..Self::PICTURE };
}

impl Purpose<'_> {
    /// What is measured and kept while the frame runs.
    pub fn run_options(&self) -> RunOptions<'static> {
        RunOptions {
            taps: if self.reads_passes { Taps::All } else { Taps::None },
            time: if self.times_passes { Timing::Once } else { Timing::Off },
            leaves_histories: !self.is_picture,
        }
    }
}
