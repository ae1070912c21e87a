//! GPU times of passes: query sets, and the buffers in which their results come back.

use std::borrow::Cow;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

use crate::execute::Timing;
use crate::report::PassTime;

/// Frames whose times may be under way at once.
const RING: usize = 3;

/// Begin and end of the first `count` passes as `u64` ticks.
#[derive(Debug)]
pub(crate) struct Timestamps {
    pub(crate) buffer: wgpu::Buffer,
    pub(crate) count: usize,
    pub(crate) ms_per_tick: f64,
}

/// A frame whose times are under way.
struct PendingFrame {
    timestamps: Timestamps,
    passes: Vec<(Cow<'static, str>, f64)>,
    /// Of the mapping: none was asked for, it is under way, it succeeded, it failed.
    state: Arc<AtomicU8>,
}

const UNMAPPED: u8 = 0;
const MAPPING: u8 = 1;
const MAPPED: u8 = 2;
const FAILED: u8 = 3;

/// Measures frames.
pub(crate) struct Times {
    device: wgpu::Device,
    queue: wgpu::Queue,
    is_supported: bool,
    queries: Option<wgpu::QuerySet>,
    ring: Vec<PendingFrame>,
    latest: Option<Vec<PassTime>>,
}

impl Times {
    pub(crate) fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        Self {
            device: device.clone(),
            queue: queue.clone(),
            is_supported: device.features().contains(wgpu::Features::TIMESTAMP_QUERY),
            queries: None,
            ring: Vec::with_capacity(RING),
            latest: None,
        }
    }

    pub(crate) fn queries(&self) -> Option<&wgpu::QuerySet> {
        self.queries.as_ref()
    }

    /// How many of `passes` can be timed: all that one set of queries holds, or none.
    pub(crate) fn begin(&mut self, timing: Timing, passes: usize) -> usize {
        let is_free = timing == Timing::Once || (timing == Timing::Live && self.ring.len() < RING);
        if !self.is_supported || !is_free {
            return 0;
        }
        // One set holds begin and end of this many passes.
        let timed = passes.min(wgpu::QUERY_SET_MAX_QUERIES as usize / 2);
        let needed = (timed as u32 * 2).max(2);
        if self.queries.as_ref().is_none_or(|queries| queries.count() < needed) {
            self.queries = Some(self.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("pass times"),
                ty: wgpu::QueryType::Timestamp,
                count: needed,
            }));
        }
        timed
    }

    /// Copies the times of a frame to where they can be read.
    pub(crate) fn end(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        timing: Timing,
        timed: usize,
        passes: &[(Cow<'static, str>, f64)],
    ) -> Option<Timestamps> {
        let queries = self.queries.as_ref().filter(|_| timed > 0)?;
        let size = timed as u64 * 16;
        let buffer = |usage| {
            self.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("pass times"),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let resolved = buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC);
        let readable = buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
        encoder.resolve_query_set(queries, 0..timed as u32 * 2, &resolved, 0);
        encoder.copy_buffer_to_buffer(&resolved, 0, &readable, 0, size);
        let timestamps = Timestamps {
            buffer: readable,
            count: timed,
            ms_per_tick: f64::from(self.queue.get_timestamp_period()) * 1e-6,
        };
        if timing == Timing::Once {
            return Some(timestamps);
        }
        self.ring.push(PendingFrame { timestamps, passes: passes.to_vec(), state: Arc::default() });
        None
    }

    /// Collects what has arrived, in the order of the frames, and gives the last of it.
    pub(crate) fn latest(&mut self) -> Option<&[PassTime]> {
        for pending in &self.ring {
            if pending.state.load(Ordering::Acquire) == UNMAPPED {
                pending.state.store(MAPPING, Ordering::Release);
                let state = pending.state.clone();
                pending.timestamps.buffer.map_async(wgpu::MapMode::Read, .., move |result| {
                    state.store(if result.is_ok() { MAPPED } else { FAILED }, Ordering::Release);
                });
            }
        }
        // An error here (device lost) shows as mappings that fail or never end.
        let _ = self.device.poll(wgpu::PollType::Poll);
        let is_done = |pending: &PendingFrame| pending.state.load(Ordering::Acquire) >= MAPPED;
        while self.ring.first().is_some_and(is_done) {
            let pending = self.ring.remove(0);
            if let Some(ticks) = read_ticks(&pending.timestamps) {
                self.latest = Some(pass_times(pending.passes, &ticks));
            }
        }
        self.latest.as_deref()
    }
}

/// The times of passes in their order; `gpu_ms` are those of the first ones.
pub(crate) fn pass_times(passes: Vec<(Cow<'static, str>, f64)>, gpu_ms: &[f64]) -> Vec<PassTime> {
    let passes = passes.into_iter().enumerate();
    passes
        .map(|(index, (name, cpu_ms))| PassTime { name: name.into_owned(), cpu_ms, gpu_ms: gpu_ms.get(index).copied() })
        .collect()
}

/// GPU milliseconds of each pass, from a buffer that is mapped.
pub(crate) fn read_ticks(timestamps: &Timestamps) -> Option<Vec<f64>> {
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
