//! tone_map: from scene-linear radiance to display colours: tone curve, sRGB, dithering.
//!
//! Sources: see `tone_map.wgsl`. Reads: radiance. Writes: the output, in display colours.

use crate::frame::Shared;
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, Graph, Handle};
use serde::{Deserialize, Serialize};

/// The curve from radiance to display colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Tonemap {
    /// Values above 1 are cut off.
    None,
    /// Khronos PBR Neutral.
    #[default]
    Neutral,
    /// Hill's fit of ACES, exposure divided by 0.6.
    Aces,
    /// AgX.
    Agx,
    /// Reinhard, on luminance.
    Reinhard,
    /// 1 − exp(−x).
    Exponential,
}

/// Settings of the display transform.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ToneMapSettings {
    /// The amplitude of the dither in steps of 1/255 (0 to 2).
    pub dither: f32,
}

impl Default for ToneMapSettings {
    fn default() -> Self {
        Self { dither: 1.0 }
    }
}

/// The uniform of `tone_map.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub struct ToneMapUniform {
    /// 0 none, 1 neutral, 2 aces, 3 agx, 4 reinhard, 5 exponential.
    pub curve: u32,
    /// Amplitude of the dither in steps of 1/255.
    pub dither: f32,
    /// Zero.
    pub padding: [f32; 2],
}

/// Records the pass.
///
/// # Errors
/// A program that does not compile.
pub fn record<'f>(
    graph: &mut Graph<'f>,
    shared: &'f Shared<'f>,
    radiance: &Handle,
    output: Handle,
) -> Result<Handle, ProgramError> {
    let step = shared.fullscreen("tone_map", &[], output.desc().format, None)?;
    let mut pass = graph.pass("tone_map");
    let reads = [("radiance", pass.read(radiance))];
    let output = pass.color(output, ColorLoad::Discard);
    pass.draw(move |context| step.draw(context, &reads, &[("tone_map", shared.tone_map.as_entire_binding())]));
    Ok(output)
}
