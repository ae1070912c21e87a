//! What a run measured and kept: times per pass, and copies of what it wrote.

use std::borrow::Cow;

use serde::Serialize;

use crate::PlanError;
use crate::graph::Export;
#[cfg(not(target_arch = "wasm32"))]
use crate::tap::copied_format;
use crate::tap::{Tap, TapFailure};
#[cfg(not(target_arch = "wasm32"))]
use crate::times::read_ticks;
use crate::times::{Timestamps, pass_times};

/// A recorded frame. Submit its encoder, then call [`Run::read`] if taps or GPU
/// times are wanted; otherwise drop it.
#[derive(Debug)]
pub struct Run {
    /// Copies of attachments in the order of passes; empty unless asked for.
    pub taps: Vec<Tap>,
    /// What was to be copied and could not be.
    pub untapped: Vec<TapFailure>,
    pub(crate) passes: Vec<(Cow<'static, str>, f64)>,
    pub(crate) exports: Vec<Option<wgpu::Texture>>,
    /// The names of the histories that the next frame is to find as they were written.
    pub(crate) written: Vec<Cow<'static, str>>,
    #[cfg_attr(target_arch = "wasm32", allow(dead_code, reason = "a browser cannot wait for what would be read"))]
    pub(crate) timestamps: Option<Timestamps>,
    /// What the first pass did wrong that asked for what it has not declared.
    pub(crate) misuse: Option<PlanError>,
    graph: u32,
}

/// Time of one pass. Passes that are measured are not merged.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PassTime {
    /// Name of the pass.
    pub name: String,
    /// Time to record it.
    pub cpu_ms: f64,
    /// Time to execute it, where the adapter has timestamps and they were asked for.
    pub gpu_ms: Option<f64>,
}

/// The texels of a tap on the CPU.
#[derive(Clone, Debug)]
pub struct TapPixels {
    /// Name of the pass that wrote them.
    pub pass: String,
    /// Name of the texture or view.
    pub texture: String,
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Format of `data`; for depth formats `Depth32Float` or `Depth16Unorm`.
    pub format: wgpu::TextureFormat,
    /// Rows from the top, without padding.
    pub data: Vec<u8>,
}

/// What [`Run::read`] found.
#[derive(Clone, Debug)]
pub struct RunReport {
    /// Times in order of execution.
    pub passes: Vec<PassTime>,
    /// Texels in order of execution. A tap that cannot be mapped is left out.
    pub taps: Vec<TapPixels>,
}

impl Run {
    pub(crate) fn new(graph: u32, passes: usize) -> Self {
        Self {
            taps: Vec::new(),
            untapped: Vec::new(),
            passes: Vec::with_capacity(passes),
            exports: Vec::new(),
            written: Vec::new(),
            timestamps: None,
            misuse: None,
            graph,
        }
    }

    /// Milliseconds to record each pass, in order of execution.
    pub fn cpu_ms(&self) -> impl Iterator<Item = (&str, f64)> {
        self.passes.iter().map(|(name, ms)| (name.as_ref(), *ms))
    }

    /// The texture behind an export of this run's graph, for copying it away before the executor's next run uses it
    /// again; `None` for the export of another graph.
    pub fn exported(&self, export: Export) -> Option<&wgpu::Texture> {
        self.exports.get(export.index as usize).filter(|_| export.graph == self.graph)?.as_ref()
    }

    /// Waits for the submitted frame and reads taps and times. In a browser, which
    /// cannot wait, there are no taps and no GPU times.
    pub fn read(self, device: &wgpu::Device) -> RunReport {
        let (ticks, taps) = read_buffers(&self, device);
        RunReport { passes: pass_times(self.passes, &ticks), taps }
    }
}

#[cfg(target_arch = "wasm32")]
fn read_buffers(_run: &Run, _device: &wgpu::Device) -> (Vec<f64>, Vec<TapPixels>) {
    (Vec::new(), Vec::new())
}

/// GPU milliseconds per pass and texels per tap.
#[cfg(not(target_arch = "wasm32"))]
fn read_buffers(run: &Run, device: &wgpu::Device) -> (Vec<f64>, Vec<TapPixels>) {
    let buffers = run.taps.iter().map(|tap| &tap.buffer);
    let buffers: Vec<_> = buffers.chain(run.timestamps.iter().map(|timestamps| &timestamps.buffer)).collect();
    if buffers.is_empty() {
        return (Vec::new(), Vec::new());
    }
    for buffer in buffers {
        // A failure shows when the range is taken below.
        buffer.map_async(wgpu::MapMode::Read, .., |_| {});
    }
    // An error here (device lost) shows below as well: nothing can be mapped.
    let _ = device.poll(wgpu::PollType::wait_indefinitely());
    let ticks = run.timestamps.as_ref().and_then(read_ticks);
    let taps = run.taps.iter().filter_map(read_tap).collect();
    (ticks.unwrap_or_default(), taps)
}

#[cfg(not(target_arch = "wasm32"))]
fn read_tap(tap: &Tap) -> Option<TapPixels> {
    let (format, texel_bytes) = copied_format(tap.desc.format)?;
    let range = tap.buffer.get_mapped_range(..).ok()?;
    let row_bytes = (tap.desc.width * texel_bytes) as usize;
    let mut data = Vec::with_capacity(row_bytes * tap.desc.height as usize);
    let rows = range.chunks(tap.bytes_per_row as usize);
    for row in rows.take(tap.desc.height as usize) {
        data.extend_from_slice(row.get(..row_bytes)?);
    }
    Some(TapPixels {
        pass: tap.pass.clone(),
        texture: tap.texture.clone(),
        width: tap.desc.width,
        height: tap.desc.height,
        format,
        data,
    })
}
