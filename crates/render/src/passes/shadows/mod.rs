//! shadows: the depth of what casts shadows, seen from lights, in tiles of one atlas.
//!
//! Source: Williams 1978, "Casting Curved Shadows on Curved Surfaces". Reads: materials, where they drop
//! fragments. Writes: the atlas, and of it the tiles alone that changed (`shadows` says which). Nearer to the
//! light is greater, as everywhere.

use crate::pass_info::{PassInfo, Reach};
use crate::record::Recorder;
use crate::shader::program::ProgramError;
use crate::shadows::FrameShadows;
use crate::shadows::ShadowSettings;
use manypass_graph::Handle;

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo { off: Some("shadows.enabled=false"), ..PassInfo::new("shadows") };

/// How far what it gives is looked for; none if settings switch it off. Contact shadows are found in screen space.
pub fn reach(settings: &ShadowSettings) -> Option<Reach> {
    let reach = if settings.has_contact() { Reach::EverySample } else { Reach::OwnPixel };
    settings.enabled.then_some(reach)
}

/// Records the pass, if there is anything to draw.
///
/// # Errors
/// A program that does not compile.
pub fn record(r: &mut Recorder<'_, '_>, shadows: &FrameShadows, atlas: Handle) -> Result<(), ProgramError> {
    if shadows.tiles.is_empty() {
        return Ok(());
    }
    let atlas = r.tiles("shadows", "shadows").draw_into(atlas, shadows.is_first, &shadows.tiles)?;
    // Lights find it in group 0, of which the graph knows nothing.
    r.graph.export(atlas);
    Ok(())
}
