//! ids: which node and which material every pixel shows: their indices plus 1; 0 where there is no surface. Recorded
//! only when a variable asks for it.
//!
//! Source: Saito & Takahashi 1990, "Comprehensible Rendering of 3-D Shapes", whose id image is a target of its own
//! here, so that frames without it pay nothing. It draws opaque and masked surfaces again where their depth lies in the
//! depth buffer: positions are `@invariant`. Reads: depth. Writes: ids (rg32uint).

use crate::frame::Shared;
use crate::shader::program::ProgramError;
use crate::surfaces::{self, Targets};
use manypass_graph::{ColorLoad, Graph, Handle, TextureDesc};

/// The format of `ids`: node, material.
pub const IDS: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Uint;

/// Records the pass.
///
/// # Errors
/// A program that does not compile.
pub fn record<'f>(graph: &mut Graph<'f>, shared: &'f Shared<'f>, depth: &Handle) -> Result<Handle, ProgramError> {
    let (width, height) = shared.size;
    let targets = Targets { colors: vec![IDS], blend: None, depth: shared.depth_format, depth_write: false };
    let draws = surfaces::prepare(shared, "ids", &targets, &shared.draws.opaque)?;
    let target = graph.texture("ids", TextureDesc::new_2d(width, height, IDS));
    let mut pass = graph.pass("ids");
    let ids = pass.color(target, ColorLoad::Clear(wgpu::Color::TRANSPARENT));
    pass.depth_stencil_read_only(depth);
    pass.draw(move |context| surfaces::draw(context, shared.resources, shared.instances, &draws));
    Ok(ids)
}
