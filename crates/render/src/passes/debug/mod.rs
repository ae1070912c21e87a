//! debug: what a frame is made of, in place of the picture: lights and fragments a pixel, texture coordinates, normals,
//! the density of texels, inputs that cannot be right, slices of clusters, cascades of shadows, levels of detail,
//! weights of probes.
//!
//! Sources: lists of lights a pixel as heat after Olsson et al. 2012; the range of base colours (sRGB 30 to 240, of its
//! luminance; metals may be brighter) after McDermott 2018, "The PBR Guide". It draws all surfaces again, with a depth
//! of its own, so that it is the same on every path. Reads: surfaces, lists of lights, tiles of shadows, texels of
//! probes. Writes: the picture, in display colours, so that they are those of the legend whatever curve and exposure.

mod legends;
mod settings;

pub use settings::{DebugSettings, DebugView};

use crate::pass_info::PassInfo;
use crate::record::{ADD, DrawSelection, Recorder};
use crate::shader::program::ProgramError;
use legends::{BACKGROUND, Color, Legend, ViewDrawing};
use manypass_graph::{ColorLoad, DepthLoad, Handle};
use std::borrow::Cow;

/// What lists of passes say of this one.
pub const PASS: PassInfo =
    PassInfo { off: Some("debug.view=off"), in_fisheye: false, tiers: &[], ..PassInfo::new("debug") };

/// The format of what surfaces leave: half floats add up on every backend, and hold whole numbers up to 2,048.
const DRAWN: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// The most steps that a view can have; `debug.wgsl` has the same number.
const STEPS_MAX: usize = 16;

/// The uniform of `debug.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct DebugUniform {
    /// Colour, and the least number that has it.
    steps: [[f32; 4]; STEPS_MAX],
    /// The colour where there is no surface.
    background: [f32; 4],
    /// 1 / width and height of the picture.
    inverse_size_px: [f32; 2],
    /// Zero.
    padding: [f32; 2],
}

impl DebugUniform {
    fn new(drawn: Legend, display: &Handle) -> Self {
        let with = |color: Color, last: f32| {
            let [r, g, b] = color.map(|byte| f32::from(byte) / 255.0);
            [r, g, b, last]
        };
        let mut steps = [with(BACKGROUND, f32::MAX); STEPS_MAX];
        if let Legend::Steps(of_view) = drawn {
            for (step, (from, color, _)) in steps.iter_mut().zip(of_view) {
                *step = with(*color, *from);
            }
        }
        let desc = display.desc();
        let inverse_size_px = [1.0 / desc.width as f32, 1.0 / desc.height as f32];
        Self { steps, background: with(BACKGROUND, 1.0), inverse_size_px, padding: [0.0; 2] }
    }
}

/// Records the passes: the picture is what the settings name. Without one it stays what it is.
///
/// # Errors
/// A program that does not compile.
pub fn record(r: &mut Recorder<'_, '_>, settings: &DebugSettings, display: Handle) -> Result<Handle, ProgramError> {
    let Some(shown) = ViewDrawing::of(settings.view) else { return Ok(display) };
    let drawn = record_surfaces(r, shown)?;
    r.legend("debug", shown.legend());
    let has_steps = matches!(shown.drawn, Legend::Steps(_));
    let uniform = DebugUniform::new(shown.drawn, &display);
    r.fullscreen("debug", "debug", &[])
        .constant("has_steps", u32::from(has_steps))
        .uniform("debug", &uniform)
        .read("drawn", &drawn)
        .draw_into(display, ColorLoad::Discard)
}

/// Draws all surfaces of the view as `shown` says.
fn record_surfaces(r: &mut Recorder<'_, '_>, shown: ViewDrawing) -> Result<Handle, ProgramError> {
    const CLEAR: DepthLoad = DepthLoad::Clear { depth: 0.0, stencil: 0 };
    let mut drawn = r.texture("debug.drawn", DRAWN);
    let mut depth = r.texture("debug.depth", r.frame.gpu.capabilities.depth_format);
    if shown.adds_hidden {
        // Nothing is hidden behind depth that stays cleared.
        depth = r.graph.pass("debug.depth").depth_stencil(depth, CLEAR);
    }
    let levels = if shown.parts_levels { r.view.level_count() } else { 1 };
    for level in 0..levels {
        let is_first = level == 0;
        let mut pass = r.surfaces(step_name("debug.opaque", level), "debug_surfaces");
        pass.constant("shown", shown.number);
        drawn = pass.color(drawn, if is_first { ColorLoad::Clear(wgpu::Color::TRANSPARENT) } else { ColorLoad::Keep });
        if shown.adds_hidden {
            pass.depth_read_only(&depth);
            pass.blend(ADD);
        } else {
            depth = pass.depth(depth, if is_first { CLEAR } else { DepthLoad::Keep });
        }
        if shown.parts_levels {
            pass.constant("level_of_detail", level);
            pass.draw_opaque_at(level)?;
        } else {
            pass.draw_opaque(DrawSelection::All)?;
        }
    }
    if !r.view.has_blended() {
        return Ok(drawn);
    }
    for level in 0..levels {
        let mut pass = r.surfaces(step_name("debug.blended", level), "debug_surfaces");
        pass.constant("shown", shown.number);
        drawn = pass.color(drawn, ColorLoad::Keep);
        if shown.adds_blended {
            pass.depth_read_only(&depth);
            pass.blend(ADD);
        } else {
            depth = pass.depth(depth, DepthLoad::Keep);
        }
        if shown.parts_levels {
            pass.constant("level_of_detail", level);
            pass.draw_blended_at(level)?;
        } else {
            pass.draw_blended()?;
        }
    }
    Ok(drawn)
}

/// The name of a step's pass of a level; the finest has that of the step.
fn step_name(step: &'static str, level: u32) -> Cow<'static, str> {
    if level == 0 { step.into() } else { format!("{step}.{level}").into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::layout::assert_same_layout;

    #[test]
    fn the_uniform_has_one_layout() {
        assert_same_layout!("debug", "Debug", DebugUniform, [steps, background, inverse_size_px, padding]);
    }

    #[test]
    fn steps_rise_and_every_colour_is_of_one_meaning() {
        for name in DebugView::NAMES {
            let Some(shown) = DebugView::named(name).and_then(ViewDrawing::of) else { continue };
            let legend = shown.legend();
            for (i, entry) in legend.iter().enumerate() {
                assert!(legend[..i].iter().all(|other| other.color_srgb != entry.color_srgb), "{name}: {entry:?}");
                assert!(entry.label.is_ascii() && entry.label.len() < 38, "{name}: {entry:?} fits a sheet");
            }
            let Legend::Steps(steps) = shown.drawn else { continue };
            assert!(steps.len() <= STEPS_MAX && steps[0].0 == 0.0 && steps.is_sorted_by(|a, b| a.0 < b.0), "{name}");
        }
    }
}
