//! ids: which node and which material every pixel shows: their indices plus 1; 0 where there is no surface. Recorded
//! only when a variable asks for it.
//!
//! Source: Saito & Takahashi 1990, "Comprehensible Rendering of 3-D Shapes", whose id image is a target of its own
//! here, so that frames without it pay nothing. It draws opaque and masked surfaces again where their depth lies in the
//! depth buffer: positions are `@invariant`. Reads: depth. Writes: ids (rg32uint).

use crate::pass_info::PassInfo;
use crate::record::{DrawSelection, Recorder, Texels};
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle};

/// What lists of passes say of this one.
pub const PASS: PassInfo =
    PassInfo { variables: &["object_id", "material_id"], effect_inputs: &["ids"], ..PassInfo::new("ids") };

/// The format of `ids`: node, material.
pub const IDS: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Uint;

/// Records the pass of some objects alone, by their ids, under the name `name`; elsewhere ids are 0.
///
/// # Errors
/// A program that does not compile.
pub fn record_of(
    r: &mut Recorder<'_, '_>,
    name: &'static str,
    objects: &[u32],
    depth: &Handle,
) -> Result<Handle, ProgramError> {
    let target = r.texture(name, IDS);
    r.declare_texels(&target, Texels::Ids);
    let mut pass = r.surfaces(name, "ids");
    let ids = pass.color(target, ColorLoad::Clear(wgpu::Color::TRANSPARENT));
    pass.depth_read_only(depth);
    pass.draw_opaque_of(objects)?;
    Ok(ids)
}

/// Records the pass.
///
/// # Errors
/// A program that does not compile.
pub fn record(r: &mut Recorder<'_, '_>, depth: &Handle) -> Result<Handle, ProgramError> {
    let target = r.texture("ids", IDS);
    r.declare_texels(&target, Texels::Ids);
    let mut pass = r.surfaces("ids", "ids");
    let ids = pass.color(target, ColorLoad::Clear(wgpu::Color::TRANSPARENT));
    pass.depth_read_only(depth);
    pass.draw_opaque(DrawSelection::All)?;
    Ok(ids)
}
