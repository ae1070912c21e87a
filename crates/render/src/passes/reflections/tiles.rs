//! The tiles of a picture in which rays met something: what follows is drawn within them alone.

use crate::record::{Fullscreen, Recorder};
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Handle, TextureDesc};

/// A texel says whether anything is there.
const FLAG: wgpu::TextureFormat = wgpu::TextureFormat::R8Unorm;

/// The least pixels along a side of a cell. A tile has two.
const CELL_PX: u32 = 8;

/// The farthest that what a ray brought is seen, in texels: the filter takes the mean over three to each side, and who
/// enlarges its picture looks at one more. A cell has as many at least.
const REACH_TEXELS: u32 = 4;

/// Tiles of a picture of rays, which texels of the size of these and of pixels may be drawn in.
#[derive(Debug)]
pub struct Tiles {
    flags: Handle,
    /// Texels of the picture of rays along a side.
    texels: u32,
    /// Pixels along a side of such a texel.
    side_px: u32,
}

impl Tiles {
    /// Those in which `rays`, whose texels have `side_px` pixels along a side, brought anything, or where that is seen.
    ///
    /// # Errors
    /// A program that does not compile.
    pub fn record(r: &mut Recorder<'_, '_>, rays: &Handle, side_px: u32) -> Result<Self, ProgramError> {
        let (width, height) = (rays.desc().width, rays.desc().height);
        let cell = (CELL_PX / side_px).max(REACH_TEXELS);
        let flags_of = |side: u32| TextureDesc::new_2d(width.div_ceil(side), height.div_ceil(side), FLAG);
        let cells = r.texture_of("reflections.cells", flags_of(cell));
        let step = r.fullscreen("reflections.cells", "reflections_tiles", &[]).read("hits", rays);
        let step = step.constants(&[("looked_at", cell), ("stride", cell)]);
        let cells = step.draw_into(cells, ColorLoad::Discard)?;
        let flags = r.texture_of("reflections.tiles", flags_of(2 * cell));
        let step = r.fullscreen("reflections.tiles", "reflections_tiles", &[]).read("hits", &cells);
        let step = step.constants(&[("looked_at", 4), ("before", 1), ("stride", 2), ("in_first", 1)]);
        let flags = step.draw_into(flags, ColorLoad::Discard)?;
        Ok(Self { flags, texels: 2 * cell, side_px })
    }

    /// Draws `step`, into a target whose texels have `side_px` pixels along a side, within `tiles` alone, if there are any.
    pub fn limit<'r, 'f>(tiles: Option<&Self>, side_px: u32, step: Fullscreen<'r, 'f>) -> Fullscreen<'r, 'f> {
        let Some(Self { flags, texels, side_px: of_rays }) = tiles else { return step.stand_in("drawn_tiles") };
        let desc = flags.desc();
        let step = step.read("drawn_tiles", flags).constant("tile_side", texels * of_rays / side_px);
        step.tiles(desc.width * desc.height)
    }
}
