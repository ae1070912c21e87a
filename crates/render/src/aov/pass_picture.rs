//! What a target of a pass is shown as.

use crate::record::LegendEntry;

/// The picture of one target of one pass.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct PassPicture {
    /// Pass and target.
    pub name: String,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// sRGB, opaque.
    pub rgba8: Vec<u8>,
    /// What its colours mean, if the pass says so.
    pub legend: Vec<LegendEntry>,
}
