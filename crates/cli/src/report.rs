//! `--report`: what was done, one JSON value a picture.

use crate::failure::Failure;
use crate::session::output_failure;
use manypass::graph::PassTime;
use manypass::{AdapterSummary, FrameStats, PairCounts, Plan};
use manypass_offline::atomic::AtomicFile;
use serde_json::{Value, json};
use std::path::Path;

/// The file; it appears when [`Report::finish`] is called.
#[derive(Debug)]
pub struct Report {
    file: AtomicFile,
    /// JSON Lines, against one indented value.
    is_lines: bool,
}

/// Milliseconds of the phases of a picture. What a picture shares with the one before it counts there.
#[derive(Clone, Copy, Debug, Default)]
pub struct Phases {
    /// From the start of the process to the renderer.
    pub start: f64,
    /// Reading and parsing the input.
    pub load: f64,
    /// Waiting for decoded images; decoding runs beside the upload.
    pub decode: f64,
    /// Handing the scene to the device.
    pub upload: f64,
    /// Metering, and what it waits for: decoded images, shaders.
    pub meter: f64,
    /// Shaders and pipelines.
    pub compile: f64,
    /// Rendering all samples.
    pub frames: f64,
    /// Reading the picture back.
    pub readback: f64,
    /// Encoding and writing the files.
    pub encode: f64,
}

/// A picture that was rendered.
#[derive(Debug)]
pub struct Entry<'a> {
    /// The name of its input.
    pub input: &'a str,
    /// Its file.
    pub output: &'a str,
    /// Its frame.
    pub frame: Option<u32>,
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// How many samples were averaged.
    pub samples: u32,
    /// The adapter that rendered it.
    pub adapter: &'a AdapterSummary,
    /// Milliseconds.
    pub phases: Phases,
    /// Numbers of its last sample.
    pub stats: &'a FrameStats,
    /// The passes of a frame.
    pub plan: &'a Plan,
    /// Measured in a frame of its own.
    pub pass_times: &'a [PassTime],
    /// Counted in a frame of its own.
    pub pairs: PairCounts,
    /// The nearest and the farthest depth in the depth PNG, in metres.
    pub depth_range_m: Option<[f32; 2]>,
    /// Mode, stops, what was metered.
    pub exposure: Value,
    /// Pixels of radiance that half floats clamped; none if no radiance was read.
    pub clamped_pixels: Option<u64>,
    /// What the reader and the renderer warned of.
    pub warnings: &'a [String],
}

impl Report {
    /// Opens the file; `is_lines` for several pictures.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn create(path: &Path, is_lines: bool) -> Result<Self, Failure> {
        Ok(Self { file: AtomicFile::create(path).map_err(output_failure)?, is_lines })
    }

    /// Adds a picture.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn rendered(&mut self, entry: &Entry<'_>) -> Result<(), Failure> {
        let (phases, stats) = (&entry.phases, entry.stats);
        let scene = phases.load + phases.decode + phases.upload + phases.meter;
        let total = phases.start + scene + phases.compile + phases.frames + phases.readback + phases.encode;
        self.add(&json!({
            "input": entry.input,
            "output": entry.output,
            "frame": entry.frame,
            "width": entry.size.0,
            "height": entry.size.1,
            "samples": entry.samples,
            "adapter": entry.adapter,
            "milliseconds": {
                "start": phases.start,
                "load": phases.load,
                "decode": phases.decode,
                "upload": phases.upload,
                "meter": phases.meter,
                "compile": phases.compile,
                "frames": phases.frames,
                "readback": phases.readback,
                "encode": phases.encode,
                "total": total,
                "culling": stats.culling_ms,
            },
            "passes": entry.pass_times,
            "plan": {
                "passes": entry.plan.passes.iter().map(|pass| &pass.name).collect::<Vec<_>>(),
                "culled": entry.plan.culled,
                "render_passes": entry.plan.render_passes,
                "bytes": entry.plan.bytes(),
            },
            "texture_bytes": stats.texture_bytes,
            "texture_bytes_unaliased": stats.texture_bytes_unaliased,
            "draws": stats.draws,
            "triangles": stats.triangles,
            "lights": stats.lights,
            "list_entries": stats.list_entries,
            "pairs_visited": entry.pairs.pairs_visited,
            "pairs_shaded": entry.pairs.pairs_shaded,
            "pairs_in_range": entry.pairs.pairs_in_range,
            "depth_range_m": entry.depth_range_m,
            "exposure": entry.exposure,
            "clamped_pixels": entry.clamped_pixels,
            "warnings": entry.warnings,
        }))
    }

    /// Adds a picture that was there already.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn skipped(&mut self, input: &str, output: &str, frame: Option<u32>) -> Result<(), Failure> {
        self.add(&json!({ "input": input, "output": output, "frame": frame, "skipped": true }))
    }

    /// Adds an input that failed.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn failed(&mut self, input: &str, failure: &Failure) -> Result<(), Failure> {
        self.add(&json!({ "input": input, "error": failure.message, "hint": failure.hint }))
    }

    fn add(&mut self, value: &Value) -> Result<(), Failure> {
        let text = if self.is_lines { format!("{value}\n") } else { format!("{value:#}\n") };
        self.file.write(text.as_bytes()).map_err(output_failure)
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// If that fails.
    pub fn finish(self) -> Result<(), Failure> {
        self.file.commit().map_err(output_failure)
    }
}
