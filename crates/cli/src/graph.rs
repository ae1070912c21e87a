//! `graph`: the passes of a frame, without drawing it for anybody.

use crate::args::{FrameArgs, GraphArgs, GraphFormat};
use crate::chosen::SettingsChoice;
use crate::failure::{Failure, say};
use crate::input::InputScene;
use crate::inspect::one;
use crate::older::ToldNames;
use crate::request::effects;
use crate::session::{self, list, still_failure};
use crate::surroundings::Surroundings;
use crate::{camera, job, looks, scenes, size, table};
use manypass::gpu::Floor;
use manypass::{EffectFile, FrameRequest, Gpu, Plan, RenderError, Renderer, Settings, View};
use manypass_offline::still::{aov_named, aov_names};
use manypass_scene::{Framing, Scene};

/// Runs `graph`.
///
/// # Errors
/// Wrong usage, an input that cannot be read, no adapter, or a frame that cannot be planned.
pub fn graph(args: &GraphArgs) -> Result<(), Failure> {
    let input = one(&args.input)?;
    let chosen = SettingsChoice::of_frame(&args.frame)?.meeting_stages(input.has_settings());
    let (settings, files) = chosen.settings(Settings::default(), None)?;
    size::parse(&args.frame.size)?;
    job::camera(&args.frame)?;
    let aovs = job::aovs(args.frame.aov.as_deref(), &aov_names())?;
    job::check_aovs(!aovs.is_empty(), &settings)?;
    let InputScene { mut scene, mut warnings, stage } = input.load()?;
    let (mut settings, files) = match &stage {
        None => (settings, files),
        stage => chosen.settings(Settings::default(), stage.as_ref())?,
    };
    job::check_aovs(!aovs.is_empty(), &settings)?;
    job::check_settings(&settings)?;
    warnings.extend(Surroundings::new(None).prepare(&mut scene, &settings)?);
    if let Some(preset) = chosen.preset() {
        preset.prepare(&mut scene, &mut settings);
    }
    scenes::show(&mut scene, args.frame.scene.as_deref(), &mut warnings)?;
    scenes::bring_near(&mut scene, &settings);
    scene.variant = looks::variant(&scene, args.frame.variant.as_deref())?;
    let floor = args.limits.as_deref().and_then(Floor::named);
    let mut renderer = match floor {
        None => session::open(args.adapter.as_deref(), false)?,
        Some(floor) => {
            let gpu = Gpu::without_adapter(floor).map_err(|error| session::gpu_failure(&error))?;
            Renderer::new(gpu).map_err(failed)?
        }
    };
    warnings.extend(files.iter().flat_map(|file| file.warnings().iter().cloned()));
    let plan = plan(&mut renderer, &scene, &args.frame, settings, files, &aovs)?;
    warnings.extend(renderer.warnings());
    warnings.iter().for_each(|warning| say(format_args!("warning: {}: {warning}", input.name())));
    ToldNames::default().say(&input.name(), &chosen.older_names(&input, stage.as_ref()));
    let text = match args.format {
        GraphFormat::Text => plan.to_text(),
        GraphFormat::Table => table::of_plan(&plan),
        GraphFormat::Json => plan.to_json(),
        GraphFormat::Mermaid => plan.to_mermaid(),
    };
    list(&format!("{}\n", text.trim_end()))
}

fn plan(
    renderer: &mut Renderer,
    scene: &Scene,
    args: &FrameArgs,
    settings: Settings,
    files: Vec<EffectFile>,
    aovs: &[String],
) -> Result<Plan, Failure> {
    let (width, height) = size::parse(&args.size)?;
    renderer.limit_textures(settings.textures.max_px);
    renderer.load(scene).map_err(failed)?;
    let aspect = width as f32 / height as f32;
    let (world_from_view, projection) =
        camera::resolve(&job::camera(args)?, scene, &Framing::of_scene(scene), aspect, 0.0)?;
    let request = FrameRequest {
        settings,
        sample_count: args.samples,
        want_aovs: aovs.iter().filter_map(|name| aov_named(name)).collect(),
        effects: effects(renderer, files)?,
        overlay: scene.overlay.clone(),
        ..FrameRequest::new(width, height, View { world_from_view, projection })
    };
    renderer.plan(scene, &request).map_err(failed)
}

fn failed(error: RenderError) -> Failure {
    still_failure(&error.into())
}
