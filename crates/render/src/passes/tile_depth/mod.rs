//! tile_depth: the nearest and the farthest surface of every tile of the lists of lights.
//!
//! Source: tiled shading (Olsson & Assarsson 2011), whose bounds a compute shader reduces in shared memory; here, on a
//! floor without compute, two full-screen passes reduce rows and then columns. Reads: linear_depth. Writes:
//! `tile_depth` (rg32float, a texel a tile): least and greatest distance along the view axis, of surfaces alone.

use crate::pass_info::PassInfo;
use crate::record::{Recorder, Texels};
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle, TextureDesc};

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo::deferred("tile_depth");

const BOUNDS: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Float;

/// Records the passes.
///
/// # Errors
/// A program that does not compile.
pub fn record(r: &mut Recorder<'_, '_>, linear_depth: &Handle) -> Result<Handle, ProgramError> {
    let [across, down, _] = r.view.light_tiles;
    let rows = r.texture_of("tile_depth.rows", TextureDesc::new_2d(across, r.view.size.1, BOUNDS));
    r.declare_texels(&rows, Texels::Distance);
    let rows = r
        .fullscreen("tile_depth.rows", "tile_depth", &[])
        .read("bounded", linear_depth)
        .draw_into(rows, ColorLoad::Discard)?;
    let tiles = r.texture_of("tile_depth", TextureDesc::new_2d(across, down, BOUNDS));
    r.declare_texels(&tiles, Texels::Distance);
    r.fullscreen("tile_depth", "tile_depth", &[])
        .constant("columns", 1)
        .read("bounded", &rows)
        .draw_into(tiles, ColorLoad::Discard)
}
