//! Two models, seen by one camera: their pictures and their variables.

use super::source::Source;
use crate::args::diff::DiffArgs;
use crate::camera::{self, CameraSpec, DEFAULT_ORBIT, Place};
use crate::chosen::SettingsChoice;
use crate::exposure::InputExposure;
use crate::failure::{Failure, say};
use crate::input::InputScene;
use crate::inspect::one;
use crate::older::ToldNames;
use crate::request::effects;
use crate::session::{self, still_failure};
use crate::surroundings::Surroundings;
use crate::{interrupt, job, looks, memory, scenes, size};
use manypass::{Aov, EffectFile, FrameRequest, Renderer, Settings, View};
use manypass_offline::still::{aov_named, aov_names, render_still};
use manypass_offline::{AovLayer, CameraData, Picture};
use manypass_scene::stage::is_stage;
use manypass_scene::{Framing, Scene};
use std::path::Path;
use std::sync::atomic::Ordering;

/// What was drawn of two models.
#[derive(Debug)]
pub struct Models {
    /// The picture of the first.
    pub a: Source,
    /// The picture of the second.
    pub b: Source,
    /// The variables of both, in one order.
    pub layers: [Vec<AovLayer>; 2],
    /// Those that are spoken of one by one.
    pub listed: Vec<Aov>,
    /// The camera of both.
    pub camera: CameraData,
    /// Half the diagonal of the box around what an automatic camera sees whole, in metres.
    pub radius_m: f32,
    /// Where the second lies.
    pub placement: Placement,
}

/// Where the second model lies for the first.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Placement {
    /// From the middle of the first to that of the second, in metres.
    pub offset_m: [f64; 3],
    /// Whether that is so far for their size that no picture shows both: an automatic camera sees the first then.
    pub is_far: bool,
}

/// A model in memory, and the settings that it is drawn with.
struct ModelInput {
    name: String,
    scene: Scene,
    settings: Settings,
    effects: Vec<EffectFile>,
    is_stage: bool,
}

/// The variables that are asked for, and depth, which says where a surface is.
///
/// # Errors
/// An unknown name.
fn variables(asked: &str) -> Result<Vec<Aov>, Failure> {
    let names = job::aovs(Some(asked), &aov_names())?;
    let named = names.iter().filter_map(|name| aov_named(name));
    // Nothing has moved where there is no frame before.
    Ok(std::iter::once(Aov::Depth).chain(named.filter(|aov| !matches!(aov, Aov::Depth | Aov::Motion))).collect())
}

/// Draws both models in the same light, by the camera that `args` describe, or else one that sees both whole.
///
/// # Errors
/// Wrong usage, an input that cannot be read, no adapter, or a picture that cannot be drawn.
pub fn draw(args: &DiffArgs) -> Result<Models, Failure> {
    let frame = &args.frame;
    let (width, height) = size::parse(&frame.size)?;
    let spec = job::camera(frame)?;
    // All are drawn, because what changed is told by all.
    let (listed, drawn) = (variables(frame.aov.as_deref().unwrap_or("all"))?, variables("all")?);
    let meets_stages = [&args.a, &args.b].into_iter().any(|input| is_stage(Path::new(input)));
    let chosen = SettingsChoice::of_frame(frame)?.meeting_stages(meets_stages);
    job::check_aovs(true, &chosen.settings(Settings::default(), None)?.0)?;
    session::note_cache(!args.cache.no_cache);
    let mut surroundings = Surroundings::new(session::cache(!args.cache.no_cache));
    interrupt::heed(true);
    let mut told = ToldNames::default();
    let mut read = |argument: &str| -> Result<ModelInput, Failure> {
        let input = one(argument)?;
        let InputScene { mut scene, mut warnings, stage } = input.load()?;
        let (mut settings, effects) = chosen.settings(Settings::default(), stage.as_ref())?;
        job::check_aovs(true, &settings)?;
        warnings.extend(surroundings.prepare(&mut scene, &settings)?);
        if let Some(preset) = chosen.preset() {
            preset.prepare(&mut scene, &mut settings);
        }
        scenes::show(&mut scene, frame.scene.as_deref(), &mut warnings)?;
        scene.variant = looks::variant(&scene, frame.variant.as_deref())?;
        let name = input.name();
        warnings.iter().for_each(|warning| say(format_args!("warning: {name}: {warning}")));
        told.say(&name, &chosen.older_names(&input, stage.as_ref()));
        Ok(ModelInput { name, scene, settings, effects, is_stage: stage.is_some() })
    };
    let (mut a, mut b) = (read(&args.a)?, read(&args.b)?);
    let (framing, placement) = bring_near(&mut a, &mut b, &spec);
    let view = view(&spec, &a.scene, &framing, width as f32 / height as f32)?;
    let mut renderer = session::open(args.adapter.as_deref(), !args.cache.no_cache)?;
    // Positions are compared in world space, where floats are fine.
    let request =
        FrameRequest { sample_count: frame.samples, want_aovs: drawn, ..FrameRequest::new(width, height, view) };
    let request_of = |read: &ModelInput| -> Result<FrameRequest, Failure> {
        let (settings, effects) = (read.settings.clone(), effects(&renderer, read.effects.clone())?);
        let overlay = read.scene.overlay.clone();
        Ok(FrameRequest { settings, effects, overlay, ..request.clone() }.resolved(&read.scene))
    };
    let (request_a, mut request_b) = (request_of(&a)?, request_of(&b)?);
    // What a scene would decide by itself, A decides for both; stages decide on purpose.
    let is_shared = !a.is_stage && !b.is_stage;
    if is_shared {
        request_b.settings = request_a.settings.clone();
    }
    let (picture_a, taken) = still(&mut renderer, &a, request_a, None)?;
    let (picture_b, _) = still(&mut renderer, &b, request_b, is_shared.then_some(taken))?;
    let source = |read: &ModelInput, picture: &Picture| Source::of_display(&read.name, picture);
    Ok(Models {
        a: source(&a, &picture_a)?,
        b: source(&b, &picture_b)?,
        layers: [picture_a.aovs, picture_b.aovs],
        listed,
        camera: CameraData::from_origin(&view, a.scene.origin_m, width, height),
        radius_m: framing.radius_m(),
        placement,
    })
}

/// Draws both near the origin if they lie far from it for their size, by one origin, so that they stay where they are to
/// each other; says how coarse what stays far away is. Gives what an automatic camera sees whole, and where they lie.
fn bring_near(a: &mut ModelInput, b: &mut ModelInput, spec: &CameraSpec) -> (Framing, Placement) {
    let may_move = [&*a, &*b].iter().all(|read| scenes::may_move(&read.settings));
    let has_moved = may_move && a.scene.bring_near_with(&mut b.scene);
    let scenes = [&a.scene, &b.scene];
    let [box_a, box_b] = scenes.map(Scene::posed_bounds_world);
    let is_far = box_a.is_far_from(&box_b);
    let is_automatic =
        spec.target.is_none() && matches!(spec.place, Place::Default | Place::Automatic | Place::Orbit { .. });
    let framing = if is_far && is_automatic { Framing::of_scene(&a.scene) } else { Framing::of_scenes(&scenes) };
    // What was moved is as fine as the numbers of its meshes.
    let [meshes_a, meshes_b] = scenes.map(Scene::bounds_of_meshes);
    let bounds = if has_moved { meshes_a.union(&meshes_b) } else { *framing.bounds_world() };
    bounds.far_warning().iter().for_each(|warning| say(format_args!("warning: both models: {warning}")));
    let offset_m = (box_b.center().as_dvec3() - box_a.center().as_dvec3()).to_array();
    (framing, Placement { offset_m, is_far })
}

/// The camera of both; a camera of the file that nobody asked for is none of both.
fn view(spec: &CameraSpec, scene: &Scene, framing: &Framing, aspect: f32) -> Result<View, Failure> {
    let is_outside = spec.place == Place::Default && framing.interior().is_none();
    let place = if is_outside { DEFAULT_ORBIT } else { spec.place.clone() };
    let spec = CameraSpec { place, ..spec.clone() };
    let (world_from_view, projection) = camera::resolve(&spec, scene, framing, aspect, 0.0)?;
    Ok(View { world_from_view, projection })
}

/// One picture with its variables, and the exposure that was taken if none was given.
fn still(
    renderer: &mut Renderer,
    read: &ModelInput,
    mut request: FrameRequest,
    taken: Option<InputExposure>,
) -> Result<(Picture, InputExposure), Failure> {
    memory::check_scene(&read.scene, &renderer.gpu().adapter)?;
    renderer.unload();
    renderer.load(&read.scene).map_err(|error| still_failure(&error.into()))?;
    renderer.warnings().iter().for_each(|warning| say(format_args!("warning: {}: {warning}", read.name)));
    let taken = match taken {
        Some(taken) => taken,
        None => InputExposure::new(renderer, &read.scene, &request)?,
    };
    taken.expose(&mut request);
    let samples = request.sample_count;
    let go_on = |_| !interrupt::STOP.load(Ordering::SeqCst);
    let picture = render_still(renderer, &read.scene, &request, samples, false, go_on);
    renderer.forget_variables();
    Ok((picture.map_err(|error| still_failure(&error))?, taken))
}
