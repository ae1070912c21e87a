//! indirect: light from the environment, added to `radiance`.
//!
//! Source: split sum (Karis 2013) over spherical Gaussians (Wang et al. 2009). Reads: G-buffer, depth. Writes: radiance.

use crate::frame::{ADD, PicturePart, Shared};
use crate::gbuffer::Gbuffer;
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Graph, Handle};

/// Records the pass.
///
/// # Errors
/// A program that does not compile.
pub fn record<'f>(
    graph: &mut Graph<'f>,
    shared: &'f Shared<'f>,
    gbuffer: &Gbuffer,
    depth: &Handle,
    radiance: Handle,
) -> Result<Handle, ProgramError> {
    if shared.environment.is_dark() {
        return Ok(radiance);
    }
    let step = shared.fullscreen_over(PicturePart::Surfaces, "indirect", Some(ADD))?;
    let mut pass = graph.pass("indirect");
    let reads = gbuffer.read(&mut pass);
    let radiance = pass.color(radiance, ColorLoad::Keep);
    pass.depth_stencil_read_only(depth);
    pass.draw(move |context| step.draw(context, &reads.named(), &[]));
    Ok(radiance)
}
