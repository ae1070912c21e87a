//! `--report`: what was done, one JSON value a picture.

use crate::failure::{Failure, Kind};
use crate::looks::Look;
use crate::pattern::is_stdout;
use crate::provenance::InputFile;
use crate::session::{print, write_failure};
use manypass::graph::{PassTime, PassWork};
use manypass::{AdapterSummary, FisheyeInfo, FrameStats, PairCounts, Plan, Renderer, Settings, SimulationReport};
use manypass_offline::atomic::{AtomicFile, is_in_place};
use manypass_offline::lines::LineFile;
use manypass_offline::{PictureInfo, PngRange};
use manypass_scene::{NodeId, Scene};
use serde::Serialize;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::Path;

/// Where it is written.
#[derive(Debug)]
pub struct Report {
    sink: Sink,
    /// JSON Lines, against one indented value.
    is_lines: bool,
    /// Whether what an earlier call reported stays: nothing that is worth more was done since.
    keeps_earlier: bool,
}

#[derive(Debug)]
enum Sink {
    /// A file that appears when [`Report::finish`] is called.
    Whole(AtomicFile),
    /// A file that grows with every picture, so that a batch that is killed leaves what it did.
    Lines(LineFile),
    Stdout,
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

/// The files of a picture.
#[derive(Clone, Debug, Serialize)]
pub struct Outputs<'a> {
    /// The picture itself.
    pub picture: &'a str,
    /// Variables that have files of their own, by name.
    pub aovs: &'a BTreeMap<&'static str, String>,
    /// The contact sheet.
    pub contact_sheet: Option<String>,
    /// The pictures of its passes.
    pub passes: Vec<String>,
}

/// A picture that was rendered.
#[derive(Debug)]
pub struct Entry<'a> {
    /// The name of its input.
    pub input: &'a str,
    /// What was read, with hashes.
    pub input_files: &'a [InputFile],
    /// Its files.
    pub outputs: Outputs<'a>,
    /// Its frame, time and camera.
    pub info: &'a PictureInfo,
    /// The views that it is put together from, if it is that of a fisheye.
    pub fisheye: Option<FisheyeInfo>,
    /// Which variant and camera of the file it shows.
    pub look: &'a Look,
    /// The files of its effects, their names and settings.
    pub effects: &'a [Value],
    /// Its settings, those that have their defaults included.
    pub settings: &'a Settings,
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// How many samples were averaged.
    pub samples: u32,
    /// How many of them pixels have on average.
    pub samples_mean: f64,
    /// The adapter that rendered it.
    pub adapter: &'a AdapterSummary,
    /// Milliseconds.
    pub phases: Phases,
    /// Numbers of its last sample.
    pub stats: &'a FrameStats,
    /// What is said of its shadows, by [`shadow_numbers`].
    pub shadows: &'a serde_json::Value,
    /// The materials that are shaded where they are drawn, and why, by `manifest::forward_materials`.
    pub forward_materials: &'a [serde_json::Value],
    /// What became of its simulations.
    pub simulations: &'a [SimulationReport],
    /// The passes of its first sample.
    pub plan: &'a Plan,
    /// Measured in the first sample, drawn once more.
    pub pass_times: &'a [PassTime],
    /// Counted in a frame of its own.
    pub pairs: PairCounts,
    /// What the numbers in PNG files of variables stand for.
    pub aov_ranges: &'a BTreeMap<&'static str, PngRange>,
    /// Mode, stops, what was metered.
    pub exposure: Option<Value>,
    /// Pixels of radiance that half floats clamped; none if no radiance was read.
    pub clamped_pixels: Option<u64>,
    /// Pixels that effects left as no numbers, counted in a frame of its own; none without effects.
    pub scrubbed_pixels: Option<u64>,
    /// What the reader and the renderer warned of.
    pub warnings: &'a [String],
    /// What was hinted at.
    pub hints: &'a [String],
}

/// What the program was called with, without its own name.
fn arguments() -> Vec<String> {
    std::env::args_os().skip(1).map(|argument| argument.to_string_lossy().into_owned()).collect()
}

impl Report {
    /// Opens the file, or takes standard output; `is_lines` wherever there may be several pictures. With `goes_on`
    /// lines are added to those that an earlier call left.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn create(path: &Path, is_lines: bool, goes_on: bool) -> Result<Self, Failure> {
        let sink = match path {
            path if is_stdout(path) => Sink::Stdout,
            path if is_lines && goes_on => Sink::Lines(LineFile::open(path).map_err(write_failure)?),
            path if is_lines => Sink::Lines(LineFile::create(path).map_err(write_failure)?),
            path => Sink::Whole(AtomicFile::create(path).map_err(write_failure)?),
        };
        let keeps_earlier = matches!(sink, Sink::Whole(_)) && path.is_file() && !is_in_place(path);
        Ok(Self { sink, is_lines, keeps_earlier })
    }

    /// Whether somebody may read along: it is one picture's, on standard output.
    pub fn is_shown(&self) -> bool {
        matches!(self.sink, Sink::Stdout) && !self.is_lines
    }

    /// Adds a picture.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn rendered(&mut self, entry: &Entry<'_>) -> Result<(), Failure> {
        let (phases, stats) = (&entry.phases, entry.stats);
        let scene = phases.load + phases.decode + phases.upload + phases.meter;
        let total = phases.start + scene + phases.compile + phases.frames + phases.readback + phases.encode;
        let bytes = entry.plan.bytes();
        let depth = entry.aov_ranges.get("depth");
        let named = |name: &str| (!name.is_empty()).then(|| name.to_owned());
        let depth_range_m = depth.and_then(|range| Some([*range.low.first()?, *range.high.first()?]));
        self.add(&json!({
            "version": env!("CARGO_PKG_VERSION"),
            "arguments": arguments(),
            "input": entry.input,
            "input_files": entry.input_files,
            "output": entry.outputs.picture,
            "outputs": entry.outputs,
            "frame": entry.info.frame,
            "time_secs": entry.info.time_secs,
            "frames_per_second": entry.info.frames_per_second,
            "camera": entry.info.camera,
            "fisheye": entry.fisheye,
            "camera_name": named(&entry.look.camera_name),
            "variant": named(&entry.look.variant_name),
            "effects": entry.effects,
            "settings": entry.settings,
            "width": entry.size.0,
            "height": entry.size.1,
            "samples": entry.samples,
            "samples_mean": entry.samples_mean,
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
            "passes": measured_passes(entry.pass_times, &entry.plan.pass_work()),
            "plan": {
                "passes": entry.plan.passes.iter().map(|pass| &pass.name).collect::<Vec<_>>(),
                "culled": entry.plan.culled,
                "render_passes": entry.plan.render_passes,
                "bytes": bytes,
            },
            // Of the plan, because only the first sample of several has the passes of variables.
            "texture_bytes": bytes.aliased,
            "texture_bytes_unaliased": bytes.unaliased,
            "captures": stats.captures,
            "captures_left_out": stats.captures_left_out,
            "probes_captured": stats.probes_captured,
            "draws": stats.draws,
            "light_draws": stats.light_draws,
            "written_bytes": stats.written_bytes,
            "triangles": stats.triangles,
            "points": stats.points,
            "levels": stats.levels,
            "lights": stats.lights,
            "lights_too_small": stats.lights_too_small,
            "list_entries": stats.list_entries,
            "light_lists_made": stats.light_lists_made,
            "shadows": entry.shadows,
            "forward_materials": entry.forward_materials,
            "simulations": entry.simulations,
            "bind_groups_made": stats.bind_groups_made,
            "bundles_executed": stats.bundles_executed,
            "pipelines_made": stats.pipelines_made,
            "uploaded_bytes": stats.uploaded_bytes,
            "pairs_visited": entry.pairs.pairs_visited,
            "pairs_shaded": entry.pairs.pairs_shaded,
            "pairs_in_range": entry.pairs.pairs_in_range,
            "pairs_passed_over": entry.pairs.pairs_passed_over,
            "aov_ranges": entry.aov_ranges,
            "depth_range_m": depth_range_m,
            "exposure": entry.exposure,
            "clamped_pixels": entry.clamped_pixels,
            "scrubbed_pixels": entry.scrubbed_pixels,
            "warnings": entry.warnings,
            "hints": entry.hints,
        }))
    }

    /// Adds a picture that was there already. One report of one picture stays as an earlier call left it.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn skipped(&mut self, input: &str, output: &str, frame: Option<u32>) -> Result<(), Failure> {
        if self.keeps_earlier {
            return Ok(());
        }
        self.add(&json!({ "input": input, "output": output, "frame": frame, "skipped": true }))
    }

    /// Adds an input that failed, and at which frame of a sequence. One report of one picture stays as an earlier call
    /// left it if the user said stop.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn failed(&mut self, input: &str, frame: Option<u32>, failure: &Failure) -> Result<(), Failure> {
        if self.keeps_earlier && failure.kind == Kind::Interrupted {
            return Ok(());
        }
        self.add(&json!({
            "version": env!("CARGO_PKG_VERSION"),
            "input": input,
            "frame": frame,
            "error": failure.message,
            "hint": failure.hint,
        }))
    }

    fn add(&mut self, value: &Value) -> Result<(), Failure> {
        self.keeps_earlier = false;
        let text = if self.is_lines { value.to_string() } else { format!("{value:#}") };
        match &mut self.sink {
            Sink::Whole(file) => file.write(format!("{text}\n").as_bytes()).map_err(write_failure),
            Sink::Lines(file) => file.append(&text).map_err(write_failure),
            Sink::Stdout => print(&format!("{text}\n")),
        }
    }

    /// Puts the file in its place, unless it grew there.
    ///
    /// # Errors
    /// If that fails.
    pub fn finish(self) -> Result<(), Failure> {
        match self.sink {
            Sink::Whole(_) if self.keeps_earlier => Ok(()),
            Sink::Whole(file) => file.commit().map_err(write_failure),
            Sink::Lines(_) | Sink::Stdout => Ok(()),
        }
    }
}

/// What each pass took, and what it draws and moves: `work` is that of the plan.
pub fn measured_passes(times: &[PassTime], work: &[PassWork]) -> Vec<Value> {
    let measured = |time: &PassTime| {
        let done = work.iter().find(|done| done.name == time.name);
        json!({
            "name": time.name,
            "cpu_ms": time.cpu_ms,
            "gpu_ms": time.gpu_ms,
            "draws": done.and_then(|done| done.draws),
            "read_bytes": done.map(|done| done.read),
            "written_bytes": done.map(|done| done.written),
        })
    };
    times.iter().map(measured).collect()
}

/// So many lights of a kind are named in a report.
const NAMED_MAX: usize = 32;

/// What a report says of the shadows of the last frame.
pub fn shadow_numbers(renderer: &Renderer, scene: &Scene) -> serde_json::Value {
    let stats = renderer.stats();
    let named = |lights: &[NodeId]| {
        let name = |id: &NodeId| json!({ "node": id.0, "name": scene.node(*id).name });
        lights.iter().take(NAMED_MAX).map(name).collect::<Vec<_>>()
    };
    json!({
        "lights": stats.shadowed_lights,
        "tiles_drawn": stats.shadow_tiles_drawn,
        "tiles_kept": stats.shadow_tiles_kept,
        "bytes": stats.texture_bytes_of_shadows,
        "lights_starved": stats.lights_starved,
        "starved": named(renderer.starved_lights()),
        "lights_beyond_atlas": stats.lights_beyond_atlas,
        "beyond_atlas": named(renderer.lights_without_shadows()),
        "lights_dealt": stats.lights_dealt,
        "light_rounds": stats.light_rounds,
        "lights_in_emitters": stats.lights_in_emitters,
    })
}
