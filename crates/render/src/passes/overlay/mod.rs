//! overlay: text, lines and sprites over the finished picture.
//!
//! Sources: Porter & Duff 1984, "over", in display colours; lines are covered by the share of a pixel's square that a
//! line along an axis would cover. One draw for all items, in their order: an instance each of rectangles of any
//! direction, from a table that the CPU fills (`overlay/quads.rs`); what monitors show is a draw of its own among them.
//! Reads: the table, the atlas of letters and images, what monitors show, and the depth of opaque surfaces where an item is
//! hidden by them. Writes: the picture, after everything else that changes it. Over a picture that may be transparent the items are drawn into a layer of their own first, because
//! unassociated alpha cannot be blended.

use crate::overlay::draw::OverlayDraw;
use crate::pass_info::PassInfo;
use crate::record::Recorder;
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle, TextureDesc};
use std::borrow::Cow;

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo::new("overlay");

/// The format of a layer: colours times a small alpha have too few steps as bytes.
const LAYER: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// The uniform of `overlay.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct OverlayUniform {
    /// 1 / width and height of the picture.
    inverse_size_px: [f32; 2],
    /// 1 / width and height of the atlas.
    inverse_atlas_texels: [f32; 2],
    /// The first rectangle that is drawn.
    first_quad: u32,
    padding_0: u32,
    padding_1: u32,
    padding_2: u32,
}

impl OverlayUniform {
    fn new(inverse_size_px: [f32; 2], inverse_atlas_texels: [f32; 2], first_quad: u32) -> Self {
        Self { inverse_size_px, inverse_atlas_texels, first_quad, padding_0: 0, padding_1: 0, padding_2: 0 }
    }
}

/// Draws the items over `picture`, which is opaque. `depth` is that of opaque surfaces, if items look at it.
///
/// # Errors
/// A program that does not compile.
pub fn record(
    r: &mut Recorder<'_, '_>,
    overlay: &OverlayDraw,
    depth: Option<&Handle>,
    picture: Handle,
) -> Result<Handle, ProgramError> {
    draw(r, "overlay", overlay, depth, picture, ColorLoad::Keep)
}

/// Draws the items over `below`, which may be transparent, into `picture`.
///
/// # Errors
/// A program that does not compile.
pub fn record_over(
    r: &mut Recorder<'_, '_>,
    overlay: &OverlayDraw,
    depth: Option<&Handle>,
    below: &Handle,
    picture: Handle,
) -> Result<Handle, ProgramError> {
    let layer = r.texture_of("overlay.layer", TextureDesc { format: LAYER, ..below.desc() });
    let layer = draw(r, "overlay.layer", overlay, depth, layer, ColorLoad::Clear(wgpu::Color::TRANSPARENT))?;
    let uniform = OverlayUniform::new([0.0; 2], [0.0; 2], 0);
    r.fullscreen("overlay", "overlay", &[])
        .constant("composes", 1)
        .uniform("overlay", &uniform)
        .table("quads", &overlay.quads)
        .read("atlas", &layer)
        .stand_in("depth")
        .stand_in("monitor")
        .read("below", below)
        .quads(1)
        .draw_into(picture, ColorLoad::Discard)
}

fn draw(
    r: &mut Recorder<'_, '_>,
    name: &'static str,
    overlay: &OverlayDraw,
    depth: Option<&Handle>,
    mut target: Handle,
    load: ColorLoad,
) -> Result<Handle, ProgramError> {
    let desc = target.desc();
    let inverse_size_px = [1.0 / desc.width as f32, 1.0 / desc.height as f32];
    let inverse_atlas_texels = overlay.atlas_side.map(|side| 1.0 / side as f32);
    for (number, run) in (1..).zip(&overlay.runs) {
        let name = if number == 1 { Cow::Borrowed(name) } else { format!("{name}.{number}").into() };
        let step = r
            .fullscreen(name, "overlay", &[])
            .constant("tests_depth", u32::from(depth.is_some()))
            .constant("shows_monitor", u32::from(run.monitor.is_some()))
            .blend(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING)
            .uniform("overlay", &OverlayUniform::new(inverse_size_px, inverse_atlas_texels, run.first))
            .table("quads", &overlay.quads)
            .table("atlas", &overlay.atlas)
            .stand_in("below")
            .quads(run.count);
        let step = match &run.monitor {
            Some(monitor) => step.table("monitor", monitor),
            None => step.stand_in("monitor"),
        };
        let step = match depth {
            Some(depth) => step.read_depth("depth", depth),
            None => step.stand_in("depth"),
        };
        target = step.draw_into(target, if number == 1 { load } else { ColorLoad::Keep })?;
    }
    Ok(target)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!(
            "overlay",
            "Overlay",
            OverlayUniform,
            [inverse_size_px, inverse_atlas_texels, first_quad, padding_0, padding_1, padding_2]
        );
    }
}
