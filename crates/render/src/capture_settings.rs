//! Settings of pictures within the picture.

use crate::setting::settings;

settings! {
    /// Settings of what is drawn within the scene for the picture: what monitors show, what mirrors reflect, and what is around
    /// probes.
    pub struct CaptureSettings {
        /// Whether pictures within the picture are drawn. Otherwise monitors are dark, mirrors show the environment, and
        /// probes that frames find the light of have none.
        enabled: bool = true;
        /// How deep they are within each other: 1 leaves screens dark that are seen in what another one shows, and mirrors
        /// without each other.
        depth: u32 = 2, in 1..=8;
        /// How many monitors a frame of a live view draws anew at most, in turns; 0 for all. Stills draw all.
        per_frame: u32 = 0, in 0..=64;
        /// Around how many probes whose light frames find a frame of a live view looks at most, in turns. Stills look around
        /// all.
        probes: u32 = 2, in 1..=64;
    }
}
