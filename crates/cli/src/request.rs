//! What the renderer is asked for: flags as settings, effects and a request.

use crate::args::{RenderArgs, TonemapArg};
use crate::failure::{Failure, Kind};
use crate::job::{Backdrop, Job};
use crate::session;
use manypass::{
    Averaging, Background, Effect, Environment, FrameRequest, Renderer, Settings, Tonemap, View, WgslEffect,
};
use manypass_offline::Format;
use manypass_offline::still::aov_named;
use manypass_scene::Scene;
use std::path::Path;
use std::sync::Arc;

/// The effect in a file; errors name the file and the line.
pub fn effect(renderer: &Renderer, path: &Path) -> Result<Arc<dyn Effect>, Failure> {
    let name = path.display().to_string();
    let source = std::fs::read_to_string(path)
        .map_err(|error| Failure::new(Kind::Failed, format!("{name}: {error}"), "name a WGSL file"))?;
    let effect = WgslEffect::new(renderer.gpu(), &name, &source)
        .map_err(|error| Failure::new(Kind::Failed, error, "correct the WGSL file"))?;
    Ok(Arc::new(effect))
}

/// The settings of the file and of `--set`, the latter last.
///
/// # Errors
/// A file that cannot be read, or a wrong key or value.
pub fn settings(args: &RenderArgs, job: &Job) -> Result<Settings, Failure> {
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

/// The request of one picture.
pub fn request(args: &RenderArgs, job: &Job, settings: &Settings, camera: View, scene: &Scene) -> FrameRequest {
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
            None => Environment::of_scene(scene),
            Some(Backdrop::Named) => Environment::Studio,
            Some(Backdrop::Nothing) => Environment::None,
            Some(Backdrop::Color(color)) => Environment::Color(color),
        },
        environment_intensity: args.environment_intensity,
        settings: settings.clone(),
        path: session::path(args.path),
        light_culling: session::light_culling(args.light_culling),
        light_subset: None,
        tonemap: match args.tonemap {
            TonemapArg::Neutral => Tonemap::Neutral,
            TonemapArg::Aces => Tonemap::Aces,
            TonemapArg::Agx => Tonemap::Agx,
            TonemapArg::Reinhard => Tonemap::Reinhard,
            TonemapArg::Exponential => Tonemap::Exponential,
            TonemapArg::None => Tonemap::None,
        },
        // `exposure::expose` puts in what is metered once for all pictures of an input.
        exposure_stops: 0.0,
        metering: None,
        averaging: if job.format == Format::Exr { Averaging::Radiance } else { Averaging::Display },
        want_aovs: job.aovs.iter().filter_map(|name| aov_named(name)).collect(),
        previous: None,
        effects: Vec::new(),
    }
}
