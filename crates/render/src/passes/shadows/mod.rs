//! shadows: the depth of what casts shadows, seen from lights, in tiles of one atlas.
//!
//! Source: Williams 1978, "Casting Curved Shadows on Curved Surfaces". Reads: materials, where they drop
//! fragments. Writes: the atlas, and of it the tiles alone that changed (`shadows` says which). Nearer to the
//! light is greater, as everywhere.

use crate::record::Recorder;
use crate::shader::program::ProgramError;
use crate::shadows::FrameShadows;
use manypass_graph::Handle;

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
