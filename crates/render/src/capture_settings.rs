//! Settings of captures.

use crate::setting::settings;

settings! {
    /// Settings of captures: the views that monitors, mirrors and probes show.
    pub struct CaptureSettings {
        /// Whether captures are drawn. Otherwise monitors are dark, mirrors show the environment, and live probes have
        /// no light.
        enabled: bool = true;
        /// The nesting depth of captures. With 1, monitors in other captures are dark, and mirrors do not show each
        /// other.
        depth: u32 = 2, in 1..=8;
        /// The most monitors that a frame of a live view redraws, in turns; 0 for all. Stills draw all.
        per_frame: u32 = 0, in 0..=64;
        /// The most live probes that a frame of a live view updates, in turns. Stills update all.
        probes: u32 = 2, in 1..=64;
    }
}
