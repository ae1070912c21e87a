//! `bench`: milliseconds per frame.

mod live;

use crate::args::BenchArgs;
use crate::camera::{self, CameraSpec};
use crate::chosen::SettingsChoice;
use crate::failure::Failure;
use crate::input::{Input, InputScene};
use crate::job;
use crate::older::ToldNames;
use crate::pattern::is_stdout;
use crate::places::Places;
use crate::report::{measured_passes, shadow_numbers};
use crate::request::{effect_values, effects};
use crate::scenes;
use crate::session::{self, ms_since, output_failure, print, still_failure, write_failure};
use crate::size;
use crate::surroundings::Surroundings;
use crate::table;
use live::Live;
use manypass::{
    Adaptation, Background, Environment, Exposure, FrameRequest, FrameStats, PairCounts, Plan, RenderError, Renderer,
    Settings, Switch, Tonemap, View,
};
use manypass_offline::{atomic, encode};
use manypass_scene::{Framing, Scene, Stage};
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;

/// The frames between the first and the counted ones.
const WARM_UP_FRAMES: u32 = 3;
/// What exposure takes to have passed between frames of `--live`, whatever they take: a picture that does not depend on
/// how fast it is drawn.
const FRAME_SECS: f32 = 1.0 / 60.0;

/// Runs `bench`; `started` is when the process started.
///
/// # Errors
/// Wrong usage, an input that cannot be read, no adapter, or a renderer that fails.
pub fn bench(args: &BenchArgs, started: Instant) -> Result<(), Failure> {
    let (width, height) = size::parse(&args.size)?;
    let input = &checked_input(args)?;
    // What a demo is shown with is no part of what is measured bare.
    let takes_settings = args.live || !matches!(input, Input::Demo(_));
    let chosen = SettingsChoice::of_change(&args.change)?.meeting_stages(takes_settings && input.has_settings());
    let base = || if args.live { Settings::default() } else { bare() };
    let (settings, effect_files) = chosen.settings(base(), None)?;
    if let Some(path) = &args.png {
        check_png(path)?;
        Places::of_input_and_effects(input, &effect_files).write(path)?;
    }
    let failed = |error: RenderError| still_failure(&error.into());
    if !args.json {
        session::note_cache(!args.cache.no_cache);
    }
    let mut renderer = session::open(args.adapter.as_deref(), !args.cache.no_cache)?;
    let load_started = Instant::now();
    let InputScene { mut scene, mut warnings, stage } = input.load()?;
    let stage = told_of(&chosen, input, stage.filter(|_| takes_settings));
    let (settings, effect_files) = match &stage {
        None => (settings, effect_files),
        stage => chosen.settings(base(), stage.as_ref())?,
    };
    let effect_values: Vec<_> = effect_files.iter().map(effect_values).collect();
    let mut live = live_of(args, &chosen, &settings, stage.as_ref())?;
    warnings.extend(Surroundings::new(session::cache(!args.cache.no_cache)).prepare(&mut scene, &settings)?);
    scenes::show(&mut scene, args.scene.as_deref(), &mut warnings)?;
    scenes::bring_near(&mut scene, &settings);
    let load_ms = ms_since(load_started);
    let upload_started = Instant::now();
    renderer.limit_textures(settings.textures.max_px);
    renderer.load(&scene).map_err(failed)?;
    let upload_ms = ms_since(upload_started);
    let view = view_of(&scene, (width, height))?;
    let exposure = settings.exposure.resolved(&scene, settings.environment.source);
    let mut request = FrameRequest {
        settings: settings.clone(),
        effects: effects(&renderer, effect_files)?,
        overlay: scene.overlay.clone(),
        goes_on: args.live,
        adaptation: if args.live { Adaptation::After { secs: FRAME_SECS } } else { Adaptation::Still },
        ..FrameRequest::new(width, height, view)
    };
    renderer.expose(&scene, &mut request, exposure).map_err(failed)?;
    live.begin(&mut request);
    let mut frame = |renderer: &mut Renderer| -> Result<f64, Failure> {
        let start = Instant::now();
        renderer.render(&scene, &request).map_err(failed)?;
        renderer.wait();
        let frame_ms = ms_since(start);
        live.take(frame_ms, &mut request);
        Ok(frame_ms)
    };
    let first_frame_ms = frame(&mut renderer)?;
    let first_ms = ms_since(started);
    // Later frames find that the lists of lights and the shadow maps are still right.
    let first = renderer.stats();
    let frames_ms = if args.first_frame { Vec::new() } else { frames_after_the_first(args, || frame(&mut renderer))? };
    let stats = renderer.stats();
    let shadows = shadow_numbers(&renderer, &scene);
    if let Some(path) = &args.png {
        write_png(path, (width, height), &mut renderer)?;
    }
    let plan = renderer.plan(&scene, &request).map_err(failed)?;
    let of_passes = if args.first_frame { None } else { Some(measure_passes(&mut renderer, &scene, &request, &plan)?) };
    let (passes, table, pairs) = of_passes.unwrap_or_default();
    let measured = Measurements {
        renderer: &renderer,
        size: (width, height),
        settings: &settings,
        live: &live,
        effect_values,
        first,
        stats,
        shadows,
        plan: &plan,
        pairs,
        passes,
        first_frame_ms,
        load_ms,
        upload_ms,
    };
    if !args.json {
        let shown_ms: &[f64] = if args.first_frame { &[first_frame_ms] } else { &frames_ms };
        print(&format!("{}{table}", measured.summary(&input.name(), shown_ms, first_ms)))?;
    }
    let line = json!({ "timeToFirstFrame": first_ms, "frames": frames_ms, "info": measured.info() });
    print(&format!("{line}\n"))
}

/// The budget of frames as a page draws them; none of others, whose settings are checked.
fn live_of(
    args: &BenchArgs,
    chosen: &SettingsChoice<'_>,
    settings: &Settings,
    stage: Option<&Stage>,
) -> Result<Live, Failure> {
    match args.live {
        true => Live::new(chosen, settings, stage),
        false => job::check_settings(settings).map(|()| Live::default()),
    }
}

/// The stage, once the older names that are used are told of.
fn told_of(chosen: &SettingsChoice<'_>, input: &Input, stage: Option<Stage>) -> Option<Stage> {
    ToldNames::default().say(&input.name(), &chosen.older_names(input, stage.as_ref()));
    stage
}

/// From where a scene is seen that nobody says more of.
fn view_of(scene: &Scene, (width, height): (u32, u32)) -> Result<View, Failure> {
    let aspect = width as f32 / height as f32;
    let (world_from_view, projection) =
        camera::resolve(&CameraSpec::default(), scene, &Framing::of_scene(scene), aspect, 0.0)?;
    Ok(View { world_from_view, projection })
}

/// The passes for JSON and as a table, and pairs of lights, in frames of their own.
fn measure_passes(
    renderer: &mut Renderer,
    scene: &Scene,
    request: &FrameRequest,
    plan: &Plan,
) -> Result<(Vec<Value>, String, Option<PairCounts>), Failure> {
    let failed = |error: RenderError| still_failure(&error.into());
    let times = renderer.pass_times(scene, request).map_err(failed)?;
    let pairs = renderer.count_pairs(scene, request).map_err(failed)?;
    let work = plan.pass_work();
    Ok((measured_passes(&times, &work), table::of_times(&times, &work), Some(pairs)))
}

/// The one input, after flags that nothing else checks.
fn checked_input(args: &BenchArgs) -> Result<Input, Failure> {
    if let Some(budget_ms) = args.budget_ms.filter(|ms| !(ms.is_finite() && *ms > 0.0)) {
        return Err(Failure::usage(format!("--budget-ms {budget_ms} is out of range"), "give milliseconds above 0"));
    }
    let mut inputs = Input::parse(&args.input)?;
    match (inputs.pop(), inputs.is_empty()) {
        (Some(input), true) => Ok(input),
        _ => Err(Failure::usage("bench takes one file", "name one model")),
    }
}

/// Writes the last frame.
fn write_png(path: &Path, (width, height): (u32, u32), renderer: &mut Renderer) -> Result<(), Failure> {
    let pixels = renderer.read_display().map_err(|error: RenderError| still_failure(&error.into()))?;
    let bytes = encode::png_rgba8(width, height, &pixels).map_err(output_failure)?;
    atomic::write_file(path, &bytes).map_err(write_failure)
}

/// What was measured beside the times of frames.
struct Measurements<'m> {
    renderer: &'m Renderer,
    size: (u32, u32),
    settings: &'m Settings,
    live: &'m Live,
    effect_values: Vec<Value>,
    /// Of the first frame.
    first: FrameStats,
    /// Of the last.
    stats: FrameStats,
    shadows: Value,
    plan: &'m Plan,
    pairs: Option<PairCounts>,
    passes: Vec<Value>,
    first_frame_ms: f64,
    load_ms: f64,
    upload_ms: f64,
}

impl Measurements<'_> {
    /// Lines for people.
    fn summary(&self, name: &str, shown_ms: &[f64], first_ms: f64) -> String {
        let ((width, height), stats) = (self.size, &self.stats);
        let (median, min, max) = summary(shown_ms);
        format!(
            "{name} at {width}x{height} on {}\nframes: {}, median {median:.2} ms, min {min:.2} ms, max {max:.2} ms; first \
             after {first_ms:.0} ms\nlights: {}, draws: {}, triangles: {}\n{}",
            self.renderer.gpu().adapter.name,
            shown_ms.len(),
            stats.lights,
            stats.draws,
            stats.triangles,
            self.live.summary(),
        )
    }

    /// `info` of the JSON.
    fn info(&self) -> Value {
        let Self { renderer, settings, live, first, stats, pairs, .. } = self;
        let adapter = &renderer.gpu().adapter;
        let over = pairs
            .filter(|pairs| pairs.pairs_in_range > 0)
            .map(|pairs| pairs.pairs_visited as f64 / pairs.pairs_in_range as f64);
        json!({
            "adapter": adapter.name,
            "backend": adapter.backend,
            "driver": adapter.driver,
            "width": self.size.0,
            "height": self.size.1,
            "path": settings.render.path.name(),
            "light_culling": settings.lights.culling.name(),
            "settings": live.settings().unwrap_or(settings),
            "quality": live.numbers(),
            "scene_bytes": renderer.scene_bytes(),
            "effects": self.effect_values,
            "lights": stats.lights,
            "lights_too_small": stats.lights_too_small,
            "captures": stats.captures,
            "captures_left_out": stats.captures_left_out,
            "probes_captured": stats.probes_captured,
            "draws": stats.draws,
            "light_draws": stats.light_draws,
            "written_bytes": stats.written_bytes,
            "triangles": stats.triangles,
            "levels": stats.levels,
            "culling_ms": first.culling_ms,
            "list_entries": stats.list_entries,
            "light_lists_made": stats.light_lists_made,
            "shadows": self.shadows,
            "shadow_tiles_drawn_first": first.shadow_tiles_drawn,
            "bind_groups_made": stats.bind_groups_made,
            "bundles_executed": stats.bundles_executed,
            "binding_changes": stats.binding_changes,
            "pipelines_made": stats.pipelines_made,
            "uploaded_bytes": stats.uploaded_bytes,
            "pairs_visited": pairs.map(|pairs| pairs.pairs_visited),
            "pairs_shaded": pairs.map(|pairs| pairs.pairs_shaded),
            "pairs_in_range": pairs.map(|pairs| pairs.pairs_in_range),
            "pairs_passed_over": pairs.map(|pairs| pairs.pairs_passed_over),
            "visited_over_in_range": over,
            "texture_bytes": stats.texture_bytes,
            "texture_bytes_unaliased": stats.texture_bytes_unaliased,
            "texture_bytes_imported": self.plan.bytes().imported,
            "passes": self.passes,
            "first_frame_ms": self.first_frame_ms,
            "load_ms": self.load_ms,
            "upload_ms": self.upload_ms,
        })
    }
}

/// The times of the frames after the first, in milliseconds. The budget is for all of them; a quarter of it at most
/// warms up.
fn frames_after_the_first(
    args: &BenchArgs,
    mut frame: impl FnMut() -> Result<f64, Failure>,
) -> Result<Vec<f64>, Failure> {
    let budget_ms = args.budget_ms.unwrap_or(f64::INFINITY);
    let measured = Instant::now();
    for _ in 0..WARM_UP_FRAMES {
        if ms_since(measured) >= 0.25 * budget_ms {
            break;
        }
        frame()?;
    }
    let mut frames_ms = Vec::new();
    while frames_ms.is_empty() || (frames_ms.len() < args.count as usize && ms_since(measured) < budget_ms) {
        frames_ms.push(frame()?);
    }
    Ok(frames_ms)
}

/// What `bench` begins with: the scene's own lights alone, nothing that is found in the picture, and radiance as it is.
fn bare() -> Settings {
    let mut settings = Settings::default();
    settings.environment.source = Environment::None;
    settings.background.source = Background::Color([0.0; 3]);
    settings.exposure.stops = Exposure::Stops(0.0);
    settings.tone_map.curve = Tonemap::None;
    settings.tone_map.dither = 0.0;
    settings.shadows.enabled = false;
    settings.occlusion.enabled = Switch::Off;
    settings.reflections.enabled = Switch::Off;
    settings
}

/// `--png` takes the name of a .png file, or a device.
fn check_png(path: &Path) -> Result<(), Failure> {
    if is_stdout(path) {
        let hint = "standard output takes the measurements; write --png FILE.png";
        return Err(Failure::usage("--png cannot go to standard output", hint));
    }
    let is_png = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("png")) || atomic::is_in_place(path);
    if is_png {
        return Ok(());
    }
    Err(Failure::usage(format!("--png {} does not end in .png", path.display()), "write --png FILE.png"))
}

/// Median, smallest and largest.
fn summary(frames_ms: &[f64]) -> (f64, f64, f64) {
    let mut sorted = frames_ms.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = |index: usize| sorted.get(index).copied().unwrap_or(0.0);
    let middle = sorted.len() / 2;
    let median = if sorted.len() % 2 == 1 { at(middle) } else { 0.5 * (at(middle.saturating_sub(1)) + at(middle)) };
    (median, at(0), at(sorted.len().saturating_sub(1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn summaries_do_not_depend_on_the_order() {
        assert_eq!(summary(&[3.0, 1.0, 2.0]), (2.0, 1.0, 3.0));
        assert_eq!(summary(&[4.0, 1.0, 2.0, 3.0]), (2.5, 1.0, 4.0));
        assert_eq!(summary(&[5.0]), (5.0, 5.0, 5.0));
    }
}
