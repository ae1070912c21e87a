//! mips: the coarser levels of a picture, each half the size of the one before: of what lies behind surfaces that light
//! comes through, and of what monitors show.
//!
//! Source: what transmission is seen before in KHR_materials_transmission, with tents in place of boxes. Reads: radiance or
//! the first level. Writes: the levels.

use crate::gbuffer::RADIANCE;
use crate::pass_info::PassInfo;
use crate::record::Recorder;
use crate::shader::program::ProgramError;
use bytemuck::{Pod, Zeroable};
use glam::Vec4;
use manypass_graph::{ColorLoad, Handle, TextureDesc};

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo::new("mips");

/// What a texel of a level is the mean of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// The four texels above it: as sharp as textures are.
    Box,
    /// A tent over sixteen, so that coarse levels show no squares where they are magnified.
    Tent,
}

/// The uniform of `mips.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Mips {
    /// How far samples lie from the middle, in both directions; one divided by the size of what is drawn.
    step: Vec4,
}

/// Records the passes that draw a texture with all levels by tents, the first of `picture`, under names that begin with
/// `name`. `picture` has the size of the view, and one sample a pixel.
///
/// # Errors
/// A program that does not compile.
pub fn record_of(r: &mut Recorder<'_, '_>, name: &str, picture: &Handle) -> Result<Handle, ProgramError> {
    let (width, height) = r.view.size;
    let desc = TextureDesc { mips: width.max(height).ilog2() + 1, ..TextureDesc::new_2d(width, height, RADIANCE) };
    let texture = r.texture_of(name.to_owned(), desc);
    record_level(r, name, (&texture, 0, Filter::Tent), Some(picture))?;
    record(r, name, Filter::Tent, &texture)?;
    Ok(texture)
}

/// Records the passes that draw all levels of `texture` but the first, which is there, under names that begin with
/// `name`: one for each.
///
/// # Errors
/// A program that does not compile.
pub fn record(r: &mut Recorder<'_, '_>, name: &str, filter: Filter, texture: &Handle) -> Result<(), ProgramError> {
    (1..texture.desc().mips).try_for_each(|level| record_level(r, name, (texture, level, filter), None))
}

/// A level of the one above it, or of a picture of its size.
fn record_level(
    r: &mut Recorder<'_, '_>,
    name: &str,
    (texture, level, filter): (&Handle, u32, Filter),
    picture: Option<&Handle>,
) -> Result<(), ProgramError> {
    let (width, height) = (texture.desc().width, texture.desc().height);
    let size_of = |level: u32| ((width >> level).max(1) as f32, (height >> level).max(1) as f32);
    let target = r.graph.subview(texture, level, 0);
    let above = picture.is_none().then(|| r.graph.subview(texture, level.saturating_sub(1), 0));
    let Some(finer) = picture.or(above.as_ref()) else { return Ok(()) };
    let (across, down) = size_of(level);
    // Texels themselves of a picture of its size, and between four of them the mean of these; else a texel to each side.
    let spread = if picture.is_some() || filter == Filter::Box { 0.0 } else { 1.0 };
    let (finer_across, finer_down) = size_of(level.saturating_sub(1));
    let step = Vec4::new(spread / finer_across, spread / finer_down, 1.0 / across, 1.0 / down);
    let step_name = if picture.is_some() { format!("{name}.copy") } else { format!("{name}.halve.{level}") };
    let pass = r.fullscreen(step_name, "mips", &[]).read("finer", finer);
    pass.uniform("mips", &Mips { step }).draw_into(target, ColorLoad::Discard).map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!("mips", "Mips", Mips, [step]);
    }
}
