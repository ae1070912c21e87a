//! Does what the command line asks for. Every call to the renderer is here or in `manypass_offline::still`.

use crate::args::{Cli, Command, CullingArg, PathArg, RenderArgs, TonemapArg};
use crate::camera;
use crate::failure::{Failure, Kind};
use crate::input::Input;
use crate::job::{Backdrop, Job, Output, expand};
use clap::CommandFactory;
use manypass::{
    Background, Environment, FrameRequest, Gpu, GpuError, LightCulling, Path, Renderer, Settings, Tonemap, View,
};
use manypass_offline::still::{StillError, aov_named, aov_names};
use manypass_offline::{Format, Picture, atomic, encode, exr_file, render_still};
use std::sync::atomic::{AtomicBool, Ordering};

static STOP: AtomicBool = AtomicBool::new(false);

/// Runs `command`.
///
/// # Errors
/// The first failure; a batch finishes the rest before.
pub fn run(command: &Command) -> Result<(), Failure> {
    match command {
        Command::Render(args) => render(args),
        Command::Adapters { .. } => {
            for adapter in Gpu::adapters() {
                println!("{}  {}  {}  {}", adapter.name, adapter.backend, adapter.device_type, adapter.driver);
            }
            Ok(())
        }
        Command::Completions { shell } => {
            clap_complete::generate(*shell, &mut Cli::command(), "manypass", &mut std::io::stdout());
            Ok(())
        }
        _ => Err(Failure::new(Kind::Failed, "this subcommand is not built yet", "use `manypass render`")),
    }
}

fn gpu_failure(error: &GpuError) -> Failure {
    match error {
        GpuError::Lost(_) => Failure::new(Kind::DeviceLost, error, "try a smaller --size or another --adapter"),
        GpuError::UnknownAdapter { .. } => Failure::new(Kind::NoAdapter, error, "see `manypass adapters`"),
        _ => Failure::new(Kind::NoAdapter, error, "on Debian and Ubuntu install mesa-vulkan-drivers"),
    }
}

fn still_failure(error: &StillError) -> Failure {
    match error {
        StillError::Stopped => Failure::new(Kind::Interrupted, error, "run it again with --skip-existing"),
        StillError::Render(e) if e.is_device_lost() => Failure::new(Kind::DeviceLost, error, "try a smaller --size"),
        StillError::Render(_) => Failure::new(Kind::Failed, error, "try a smaller --size or another --adapter"),
    }
}

fn settings(args: &RenderArgs, job: &Job) -> Result<Settings, Failure> {
    let mut settings = Settings::default();
    if let Some(path) = &args.settings {
        let read = std::fs::read_to_string(path);
        let text =
            read.map_err(|e| Failure::new(Kind::Failed, format!("{}: {e}", path.display()), "name a TOML file"))?;
        settings = Settings::from_toml(&text).map_err(|e| Failure::usage(e, "correct the file"))?;
    }
    for (key, value) in &job.set {
        settings.set(key, value).map_err(|e| Failure::usage(e, "write --set KEY=VALUE"))?;
    }
    Ok(settings)
}

fn render(args: &RenderArgs) -> Result<(), Failure> {
    let mut inputs = Vec::new();
    for argument in &args.inputs {
        inputs.extend(Input::parse(argument)?);
    }
    let job = Job::new(args, inputs.len() > 1, &aov_names())?;
    let settings = settings(args, &job)?;
    let (first, last) = job.frames.unwrap_or((0, 0));
    let mut seen = std::collections::BTreeSet::new();
    if let Output::Pattern(pattern) = &job.output {
        for path in inputs.iter().flat_map(|i| (first..=last).map(|f| expand(pattern, &i.stem(), f, "rgba"))) {
            if let Some(path) = seen.replace(path) {
                let message = format!("two pictures would be written to {}", path.display());
                return Err(Failure::usage(message, "use {stem} and {frame:04} in -o"));
            }
        }
    }
    // Without a handler an interrupt ends the program as the system does it.
    let _ = ctrlc::set_handler(|| {
        if STOP.swap(true, Ordering::SeqCst) {
            atomic::remove_unfinished();
            std::process::exit(130);
        }
    });
    let gpu = Gpu::headless(args.adapter.as_deref()).map_err(|error| gpu_failure(&error))?;
    let mut renderer = Renderer::new(gpu).map_err(|error| still_failure(&error.into()))?;
    let mut result = Ok(());
    for input in &inputs {
        if let Err(failure) = render_input(&mut renderer, input, args, &job, &settings) {
            if inputs.len() == 1 || matches!(failure.kind, Kind::DeviceLost | Kind::Interrupted) {
                return Err(failure);
            }
            if let Err(former) = std::mem::replace(&mut result, Err(failure)) {
                former.print();
            }
        }
    }
    result
}

fn render_input(
    r: &mut Renderer,
    input: &Input,
    args: &RenderArgs,
    job: &Job,
    settings: &Settings,
) -> Result<(), Failure> {
    let (mut scene, warnings) = input.load()?;
    r.load(&scene).map_err(|error| still_failure(&error.into()))?;
    for warning in warnings.iter().filter(|_| !args.quiet) {
        eprintln!("warning: {}: {warning}", input.name());
    }
    let (first, last) = job.frames.unwrap_or((0, 0));
    for frame in first..=last {
        let time_secs = if args.frames.is_some() { Some(frame as f32 / args.fps) } else { args.time };
        if let Some(time_secs) = time_secs.filter(|_| !scene.animations.is_empty()) {
            let named =
                |name: &String| scene.animations.iter().position(|a| a.name == *name).or_else(|| name.parse().ok());
            let index = args.animation.as_ref().map_or(Some(0), named).filter(|i| *i < scene.animations.len());
            let index = index.ok_or_else(|| Failure::usage("there is no such animation", "see `manypass info`"))?;
            scene.pose(index, time_secs);
            scene.update_transforms();
        }
        let turn_deg = args.turntable.map_or(0.0, |count| 360.0 * frame as f32 / count as f32);
        let aspect = job.width as f32 / job.height as f32;
        let (world_from_view, projection) = camera::resolve(&job.camera, &scene, aspect, turn_deg)?;
        let request = request(args, job, settings, View { world_from_view, projection }, scene.lights.is_empty());
        let go_on = |_| !STOP.load(Ordering::SeqCst);
        let picture = render_still(r, &scene, &request, args.samples, job.format == Format::Exr, go_on);
        write(&picture.map_err(|error| still_failure(&error))?, job, &input.stem(), frame)?;
    }
    Ok(())
}

fn request(args: &RenderArgs, job: &Job, settings: &Settings, camera: View, is_unlit: bool) -> FrameRequest {
    FrameRequest {
        width: job.width,
        height: job.height,
        camera,
        sample_index: 0,
        sample_count: args.samples,
        background: match job.background {
            Backdrop::Named => Background::Environment,
            Backdrop::Nothing => Background::Transparent,
            Backdrop::Color(color) => Background::Color(color),
        },
        environment: match job.environment {
            Some(Backdrop::Named) => Environment::Studio,
            None if is_unlit => Environment::Studio,
            Some(Backdrop::Color(color)) => Environment::Color(color),
            _ => Environment::None,
        },
        environment_intensity: args.environment_intensity,
        settings: settings.clone(),
        path: if args.path == PathArg::Forward { Path::Forward } else { Path::Deferred },
        light_culling: if args.light_culling == CullingArg::None {
            LightCulling::None
        } else {
            LightCulling::Clustered
        },
        light_subset: None,
        tonemap: match args.tonemap {
            TonemapArg::Neutral => Tonemap::Neutral,
            TonemapArg::Aces => Tonemap::Aces,
            TonemapArg::Agx => Tonemap::Agx,
            TonemapArg::Reinhard => Tonemap::Reinhard,
            TonemapArg::Exponential => Tonemap::Exponential,
            TonemapArg::None => Tonemap::None,
        },
        exposure_stops: args.exposure,
        want_aovs: job.aovs.iter().filter_map(|name| aov_named(name)).collect(),
    }
}

fn write(picture: &Picture, job: &Job, stem: &str, frame: u32) -> Result<(), Failure> {
    let failed = |e: &dyn std::fmt::Display| {
        Failure::new(Kind::Failed, e, "check -o, the folder's permissions and its free space")
    };
    let (w, h, pixels) = (picture.width, picture.height, &picture.display_rgba8);
    let bytes = match job.format {
        Format::Png => encode::png_rgba8(w, h, pixels),
        Format::Jpg => encode::jpg(w, h, pixels),
        Format::Webp => encode::webp(w, h, pixels),
        Format::Exr => exr_file::encode(w, h, Some(&picture.radiance), &picture.aovs),
    }
    .map_err(|e| failed(&e))?;
    let Output::Pattern(pattern) = &job.output else { return atomic::write_stdout(&bytes).map_err(|e| failed(&e)) };
    let target = expand(pattern, stem, frame, "rgba");
    atomic::write_file(&target, &bytes).map_err(|e| failed(&e))?;
    for aov in picture.aovs.iter().filter(|_| job.format == Format::Png) {
        let (bytes, _) = manypass_offline::still::aov_png(aov, w, h).map_err(|e| failed(&e))?;
        let named = expand(pattern, stem, frame, &aov.name);
        let path = if named == target { target.with_extension(format!("{}.png", aov.name)) } else { named };
        atomic::write_file(&path, &bytes).map_err(|e| failed(&e))?;
    }
    Ok(())
}
