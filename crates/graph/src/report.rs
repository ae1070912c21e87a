//! What a run measured and kept: times per pass, and copies of what it wrote.

use std::borrow::Cow;

use serde::Serialize;

use crate::TextureDesc;

/// A copy of one attachment as it was after one pass.
#[derive(Clone, Debug)]
pub struct Tap {
    /// Name of the pass that wrote it.
    pub pass: String,
    /// Name of the texture or view.
    pub texture: String,
    /// Shape of the copied view. Of a depth format, depth alone is copied.
    pub desc: TextureDesc,
    /// The rows, for mapping after submission.
    pub buffer: wgpu::Buffer,
    /// Distance of rows in `buffer`; a multiple of 256.
    pub bytes_per_row: u32,
}

/// A recorded frame. Submit its encoder, then call [`Run::read`] if taps or GPU
/// times are wanted; otherwise drop it.
#[derive(Debug)]
pub struct Run {
    /// Copies of attachments in the order of passes; empty unless asked for.
    pub taps: Vec<Tap>,
    pub(crate) passes: Vec<(Cow<'static, str>, f64)>,
    pub(crate) exports: Vec<(Cow<'static, str>, wgpu::Texture)>,
    pub(crate) timestamps: Option<Timestamps>,
}

#[derive(Debug)]
#[cfg_attr(target_arch = "wasm32", allow(dead_code, reason = "a browser cannot wait for what would be read"))]
pub(crate) struct Timestamps {
    /// Begin and end of the first `count` passes as `u64` ticks.
    pub(crate) buffer: wgpu::Buffer,
    pub(crate) count: usize,
    pub(crate) ms_per_tick: f64,
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
    /// Milliseconds to record each pass, in order of execution.
    pub fn cpu_ms(&self) -> impl Iterator<Item = (&str, f64)> {
        self.passes.iter().map(|(name, ms)| (name.as_ref(), *ms))
    }

    /// The texture behind an exported transient, for copying it away before the
    /// executor's next run reuses it. Imported textures are the importer's.
    pub fn exported(&self, name: &str) -> Option<&wgpu::Texture> {
        let found = self.exports.iter().find(|(export, _)| export == name);
        found.map(|(_, texture)| texture)
    }

    /// Waits for the submitted frame and reads taps and times. In a browser, which
    /// cannot wait, there are no taps and no GPU times.
    pub fn read(self, device: &wgpu::Device) -> RunReport {
        let (ticks, taps) = read_buffers(&self, device);
        let passes = self.passes.into_iter().enumerate();
        RunReport {
            passes: passes
                .map(|(index, (name, cpu_ms))| PassTime {
                    name: name.into_owned(),
                    cpu_ms,
                    gpu_ms: ticks.get(index).copied(),
                })
                .collect(),
            taps,
        }
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
fn read_ticks(timestamps: &Timestamps) -> Option<Vec<f64>> {
    let range = timestamps.buffer.get_mapped_range(..).ok()?;
    let tick = |bytes: &[u8]| -> u64 { bytes.try_into().map(u64::from_le_bytes).unwrap_or(0) };
    let pairs = range.chunks_exact(16).take(timestamps.count);
    Some(
        pairs
            .map(|pair| {
                let (begin, end) = pair.split_at(8);
                tick(end).saturating_sub(tick(begin)) as f64 * timestamps.ms_per_tick
            })
            .collect(),
    )
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

/// The format and texel size of a copy; `None` if it cannot be copied.
pub(crate) fn copied_format(format: wgpu::TextureFormat) -> Option<(wgpu::TextureFormat, u32)> {
    use wgpu::TextureFormat as F;
    match format {
        F::Depth32Float | F::Depth32FloatStencil8 => Some((F::Depth32Float, 4)),
        F::Depth16Unorm => Some((F::Depth16Unorm, 2)),
        F::Depth24Plus | F::Depth24PlusStencil8 | F::Stencil8 => None,
        other => other.block_copy_size(None).map(|bytes| (other, bytes)),
    }
}
