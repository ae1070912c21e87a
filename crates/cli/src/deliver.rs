//! From the renderer to files: reads what was rendered, piece by piece, and writes the picture and its variables.

use crate::failure::Failure;
use crate::interrupt;
use crate::job::Job;
use crate::looks::Subject;
use crate::one_tone::OneTone;
use crate::output;
use crate::session::{output_failure, still_failure, write_failure};
use crate::stream::{begun, stream_failure};
use manypass::{FrameRequest, PngEncoding, RenderError, Renderer};
use manypass_offline::atomic::{self, AtomicFile};
use manypass_offline::exr_file::WriteError;
use manypass_offline::still::{StillError, aov_named, read_for_png, write_exr};
use manypass_offline::{Container, Format, PictureInfo, PngRange, Stream, aov_png, encode};
use manypass_scene::Scene;
use std::collections::BTreeMap;
use std::io::{BufWriter, Cursor};
use std::path::Path;
use std::time::{Duration, Instant};

/// What was written.
#[derive(Debug, Default)]
pub struct Delivery {
    /// The files of variables that have files of their own, by name.
    pub aovs: BTreeMap<&'static str, String>,
    /// What the numbers in those files stand for.
    pub aov_ranges: BTreeMap<&'static str, PngRange>,
    /// Milliseconds to read pixels back.
    pub readback_ms: f64,
    /// Milliseconds to encode and write them.
    pub encode_ms: f64,
    /// What nearly all of the picture is, if it is no EXR.
    pub one_tone: Option<OneTone>,
    /// Files with all of their bytes, which are not in their places yet; the picture is the last.
    whole: Vec<AtomicFile>,
    /// What goes to standard output, or into a stream: a file, or pixels where the stream holds those.
    to_stdout: Option<Vec<u8>>,
    /// Its name in a tar.
    name: String,
}

/// Refuses ids that a 16-bit PNG cannot hold, before anything is rendered.
///
/// # Errors
/// If the scene has too many nodes or materials for the variables that are asked for.
pub fn check_ids(job: &Job, scene: &Scene) -> Result<(), Failure> {
    // Surfaces without a material have an id of their own.
    for (name, count) in [("object_id", scene.nodes.len()), ("material_id", scene.materials.len() + 1)] {
        let is_png = job.format == Format::Png && job.output.container().is_none();
        let is_wanted = is_png && job.aovs.iter().any(|aov| aov == name);
        if is_wanted && count > PngEncoding::LARGEST_ID as usize {
            let message = format!("{name} goes up to {count}, and a 16-bit PNG holds {}", PngEncoding::LARGEST_ID);
            return Err(Failure::usage(message, "write .exr, whose ids have 32 bits"));
        }
    }
    Ok(())
}

impl Delivery {
    /// Reads a picture and its variables, and writes them to files that are not in their places yet: that is for
    /// [`Self::finish`], so that what reading finds can still hinder it.
    ///
    /// # Errors
    /// If the device was lost, or a file cannot be encoded or written.
    pub fn begin(
        renderer: &mut Renderer,
        request: &FrameRequest,
        job: &Job,
        info: &PictureInfo,
        subject: Subject<'_>,
        stream: &mut Option<Stream>,
    ) -> Result<Self, Failure> {
        let start = Instant::now();
        let mut delivery = Self::default();
        let files = output::files(job, subject);
        let target = files.as_ref().map(|(target, _)| target.as_path());
        let mut reading = Duration::ZERO;
        delivery.name = job.output.stream().map(|place| place.name(subject)).unwrap_or_default();
        if let Some(stream) = begun(stream, job)? {
            reading += stream.read_variables(renderer).map_err(stream_failure)?;
        }
        if job.format == Format::Exr {
            reading += delivery.exr(renderer, request, info, target)?;
        } else {
            for (name, path) in job.aovs.iter().zip(files.iter().flat_map(|(_, aovs)| aovs)) {
                let Some(aov) = aov_named(name) else { continue };
                let begun = Instant::now();
                let layer = read_for_png(renderer, aov).map_err(|error| still_failure(&error))?;
                reading += begun.elapsed();
                let (bytes, range) = aov_png(&layer, request.width, request.height).map_err(output_failure)?;
                delivery.whole.push(written(path, &bytes)?);
                delivery.aovs.insert(aov.name(), path.display().to_string());
                delivery.aov_ranges.extend(range.map(|range| (aov.name(), range)));
            }
            let begun = Instant::now();
            let pixels = renderer.read_display().map_err(failed)?;
            reading += begun.elapsed();
            delivery.one_tone = OneTone::of(&pixels, request.settings.background.source);
            let bytes = match job.output.container() {
                Some(Container::Y4m | Container::Npz) => pixels,
                Some(Container::Tar) | None => encoded(&pixels, request, job.format)?,
            };
            match target {
                // Last, because --skip-existing and readers take it for the sign that the picture is done.
                Some(target) => delivery.whole.push(written(target, &bytes)?),
                None => delivery.to_stdout = Some(bytes),
            }
        }
        delivery.readback_ms = reading.as_secs_f64() * 1e3;
        delivery.encode_ms = start.elapsed().as_secs_f64() * 1e3 - delivery.readback_ms;
        Ok(delivery)
    }

    /// Puts the files in their places, or the picture into its stream.
    ///
    /// # Errors
    /// If that fails, or the user has said stop.
    pub fn finish(&mut self, stream: Option<&mut Stream>) -> Result<(), Failure> {
        let start = Instant::now();
        self.whole.drain(..).try_for_each(|file| file.commit().map_err(write_failure))?;
        if let Some(bytes) = self.to_stdout.take() {
            interrupt::check()?;
            match stream {
                Some(stream) => stream.add(&self.name, &bytes).map_err(stream_failure)?,
                None => atomic::write_stdout(&bytes).map_err(write_failure)?,
            }
        }
        self.encode_ms += start.elapsed().as_secs_f64() * 1e3;
        Ok(())
    }

    /// The picture and its variables as OpenEXR. Where one cannot go back, as in a pipe, the file is put together in
    /// memory. Gives the time that it took to read.
    fn exr(
        &mut self,
        renderer: &mut Renderer,
        request: &FrameRequest,
        info: &PictureInfo,
        target: Option<&Path>,
    ) -> Result<Duration, Failure> {
        let mut file = target.map(output::begin).transpose()?;
        let mut bytes = Cursor::new(Vec::new());
        let written = match file.as_mut().filter(|file| file.is_seekable()) {
            Some(file) => write_exr(&mut BufWriter::new(file), renderer, request, info),
            None => write_exr(&mut bytes, renderer, request, info),
        };
        let reading = written.map_err(|error| match (error, &file) {
            (WriteError::Pixels(error), _) => still_failure(&error),
            (WriteError::Encode(error), _) => output_failure(error),
            (WriteError::Io(error), Some(file)) => write_failure(file.failed(error)),
            (WriteError::Io(error), None) => output_failure(error),
        })?;
        match file {
            Some(mut file) => {
                // Nothing, if it went to the file at once.
                file.write(bytes.get_ref()).map_err(write_failure)?;
                self.whole.push(file);
            }
            None => self.to_stdout = Some(bytes.into_inner()),
        }
        Ok(reading)
    }
}

/// A file with all of its bytes that is not yet in its place.
fn written(path: &Path, bytes: &[u8]) -> Result<AtomicFile, Failure> {
    let mut file = output::begin(path)?;
    file.write(bytes).map_err(write_failure)?;
    Ok(file)
}

/// The file of the picture for the display.
fn encoded(pixels: &[u8], request: &FrameRequest, format: Format) -> Result<Vec<u8>, Failure> {
    let (width, height) = (request.width, request.height);
    let bytes = match format {
        Format::Jpg => encode::jpg(width, height, pixels),
        Format::Webp => encode::webp(width, height, pixels),
        Format::Png | Format::Exr => encode::png_rgba8(width, height, pixels),
    };
    bytes.map_err(output_failure)
}

fn failed(error: RenderError) -> Failure {
    still_failure(&StillError::from(error))
}
