//! Settings of pictures within the picture.

use crate::setting::settings;

settings! {
    /// Settings of what cameras take within the scene for the picture: what monitors show.
    pub struct CaptureSettings {
        /// Whether pictures within the picture are drawn. Otherwise monitors are dark.
        enabled: bool = true;
        /// How deep they are within each other: 1 leaves screens dark that are seen in what another one shows.
        depth: u32 = 2, in 1..=8;
        /// How many of them a frame of a live view draws anew at most, in turns; 0 for all. Stills draw all.
        per_frame: u32 = 0, in 0..=64;
    }
}
