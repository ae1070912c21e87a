//! background: the backdrop of the environment, where there is no opaque surface; blended ones are drawn over it later.
//!
//! Reads: the environment, depth. Writes: radiance. A background colour is none of radiance: `tone_map` lays the picture
//! over it.

mod settings;

pub use settings::BackgroundSettings;

use crate::environment::Background;
use crate::frame::{PicturePart, Shared};
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Graph, Handle};

/// Records the pass; only the environment as background needs it.
///
/// # Errors
/// A program that does not compile.
pub fn record<'f>(
    graph: &mut Graph<'f>,
    shared: &'f Shared<'f>,
    depth: &Handle,
    radiance: Handle,
) -> Result<Handle, ProgramError> {
    if shared.background != Background::Environment {
        return Ok(radiance);
    }
    let step = shared.fullscreen_over(PicturePart::Background, "background", None)?;
    let mut pass = graph.pass("background");
    let radiance = pass.color(radiance, ColorLoad::Keep);
    pass.depth_stencil_read_only(depth);
    pass.draw(move |context| step.draw(context, &[], &[]));
    Ok(radiance)
}
