//! An input of a batch: read, on the device, and metered.

use super::batch::{Batch, failed};
use crate::ahead::ReadAhead;
use crate::args::RenderArgs;
use crate::camera::Place;
use crate::deliver::check_ids;
use crate::exposure::InputExposure;
use crate::failure::{Failure, say};
use crate::gather::Item;
use crate::input::{Input, InputScene};
use crate::job;
use crate::looks::{self, Look};
use crate::provenance::{InputFile, input_files};
use crate::report::Phases;
use crate::request::{effect_warnings, effects, request};
use crate::session::ms_since;
use crate::shot::{pose, time_secs, view};
use crate::{camera, coverage, interrupt, memory, scenes, shot, surroundings};
use manypass::settings::CameraSettings;
use manypass::{EffectFile, Environment, Fisheye, Settings};
use manypass_scene::{Framing, Scene, Stage, demo};
use std::time::Instant;

/// An input in memory and on the device.
pub(super) struct LoadedInput {
    /// As it was read, in the pose of the latest picture.
    pub scene: Scene,
    /// What an automatic camera shows whole.
    pub framing: Framing,
    /// How it is shown, each a picture of its own or a sequence.
    pub looks: Vec<Look>,
    /// Whether the next picture follows the last one of a sequence.
    pub goes_on: bool,
    /// The exposure of all pictures of the look that is shown.
    pub exposure: Option<InputExposure>,
    /// What its reader and the renderer warned of.
    pub warnings: Vec<String>,
    /// What may help, and is no warning.
    pub hints: Vec<String>,
    /// Whether a picture of the look that is shown was looked at: a sequence is hinted at once.
    pub is_looked_at: bool,
    /// The files it was read from; only with a report.
    pub files: Vec<InputFile>,
}

impl Batch<'_> {
    /// Reads an input and hands it to the device; says what is wrong with it.
    ///
    /// # Errors
    /// It cannot be read or drawn, or there are warnings where those are errors.
    pub(super) fn load(&mut self, item: &Item, phases: &mut Phases) -> Result<LoadedInput, Failure> {
        let start = Instant::now();
        // Two scenes at once need not fit into memory.
        self.renderer.unload();
        let InputScene { mut scene, mut warnings, stage } = ReadAhead::take(&mut self.ahead, &item.input)?;
        warnings.extend(self.choose(stage.as_ref())?);
        if let Input::Demo(name) = &item.input
            && let Some(of_frames) = demo::frame_stage(name)
        {
            // A test applies it.
            let _ = of_frames.apply(&mut scene);
        }
        warnings.extend(self.surroundings.prepare(&mut scene, &self.settings)?);
        if let Some(preset) = self.chosen.preset() {
            preset.prepare(&mut scene, &mut self.settings);
        }
        interrupt::check()?;
        check_ids(self.job, &scene)?;
        let files = self
            .report
            .as_ref()
            .map(|_| input_files(&item.input, &surroundings::files(&self.settings)))
            .unwrap_or_default();
        scenes::show(&mut scene, self.args.frame.scene.as_deref(), &mut warnings)?;
        let has_moved = scenes::bring_near(&mut scene, &self.settings);
        let (frame, job) = (&self.args.frame, self.job);
        let mut looks = looks::of_scene(&scene, frame, &job.look.camera, &job.views.cameras, &mut warnings)?;
        scene.variant = looks.first().and_then(|look| look.variant);
        memory::check_scene(&scene, &self.renderer.gpu().adapter)?;
        let framing = shot::framing(&mut scene, self.args)?;
        // What was moved is as fine as the numbers of its meshes.
        let bounds = if has_moved { scene.bounds_of_meshes() } else { *framing.bounds_world() };
        warnings.extend(bounds.far_warning());
        phases.load = ms_since(start);
        let start = Instant::now();
        self.renderer.limit_textures(self.settings.textures.max_px);
        self.renderer.load(&scene).map_err(failed)?;
        phases.decode = self.renderer.decode_ms();
        phases.upload = ms_since(start) - phases.decode;
        interrupt::check()?;
        warnings.extend(self.renderer.warnings());
        let args = self.args;
        // The frames of a turntable turn the camera, whichever of them are asked for.
        let turns = args.turntable.is_some() && args.time.is_none() && args.animation.is_none();
        let is_still = scene.animations.is_empty() && !shot::has_waves(&scene) && !turns;
        if is_still && (args.time.is_some() || args.frames.is_some() || args.animation.is_some()) {
            warnings.push("it has no animation; every time shows it as it stands".into());
        }
        if self.settings.environment.source == Environment::None && coverage::is_dark(&scene) {
            warnings.push("nothing lights it: the file has no lights, and --environment is none".into());
        }
        warnings.extend(unsampled(args, &self.settings, &scene));
        warnings.extend(unmoved(args, &self.effect_files, &scene));
        if self.settings.camera.fisheye != Fisheye::None {
            warnings.extend(of_fisheye(args, &scene));
        }
        self.warn(&item.input.name(), &warnings)?;
        let mut hints: Vec<String> = camera::hint(&self.job.look.camera, &scene, &framing).into_iter().collect();
        hints.extend(self.show_whole(&scene, &framing, &mut looks));
        hints.extend(looks.iter().find_map(|look| camera::outlier_hint(&look.camera, &scene, &framing)));
        hints.extend(shot::unborn_hint(&scene, args));
        hints.iter().for_each(|hint| self.hint(&item.input.name(), hint));
        let older = self.chosen.older_names(&item.input, stage.as_ref());
        self.told.news(&older).iter().for_each(|name| self.hint(&item.input.name(), &name.to_string()));
        hints.extend(older.iter().map(ToString::to_string));
        Ok(LoadedInput {
            scene,
            framing,
            looks,
            goes_on: false,
            exposure: None,
            warnings,
            hints,
            is_looked_at: false,
            files,
        })
    }

    /// Takes the automatic camera where nobody names one and the file's shows hardly anything of the model, and says so.
    /// Sequences and cameras that move are left as they are.
    fn show_whole(&self, scene: &Scene, framing: &Framing, looks: &mut [Look]) -> Option<String> {
        let aspect = self.job.width as f32 / self.job.height as f32;
        if self.args.frames.is_some() || self.args.turntable.is_some() {
            return None;
        }
        let plays = self.args.time.is_some() || self.args.animation.is_some();
        let hint = camera::hides_model(&self.job.look.camera, scene, (framing, plays), aspect)?;
        for look in looks.iter_mut().filter(|look| look.camera.place == Place::Default) {
            look.camera.place = Place::Automatic;
        }
        Some(hint)
    }

    /// Says what may help, and hinders nothing.
    pub(super) fn hint(&self, name: &str, hint: &str) {
        if !self.args.quiet {
            self.bar.suspend(|| say(format_args!("hint: {name}: {hint}")));
        }
    }

    /// Shows an input in one of its looks, and meters that.
    ///
    /// # Errors
    /// It has no such camera, or cannot be drawn.
    pub(super) fn meter(
        &mut self,
        name: &str,
        loaded: &mut LoadedInput,
        index: usize,
        phases: &mut Phases,
    ) -> Result<(), Failure> {
        let start = Instant::now();
        let LoadedInput { scene, framing, looks, exposure, goes_on, hints, is_looked_at, .. } = loaded;
        (*goes_on, *is_looked_at) = (false, false);
        let Some(look) = looks.get(index) else { return Ok(()) };
        scene.variant = look.variant;
        let taken = self.metered(scene, framing, look)?;
        if let Some(hint) = taken.dark_hint(self.settings.environment.source.resolved(scene)) {
            self.hint(name, &hint);
            hints.push(hint);
        }
        *exposure = Some(taken);
        phases.meter = ms_since(start);
        Ok(())
    }

    /// Takes the settings and effects of an input; says what is wrong with those of its stage.
    ///
    /// # Errors
    /// Wrong settings of its stage, or none with which the job can be done; an effect that does not compile.
    fn choose(&mut self, stage: Option<&Stage>) -> Result<Vec<String>, Failure> {
        let (settings, files) = match stage {
            None => (self.plain_settings.clone(), self.plain_effect_files.to_vec()),
            stage => self.chosen.settings(Settings::default(), stage)?,
        };
        self.job.check(&settings)?;
        job::check_settings(&settings)?;
        self.settings = settings;
        if self.effect_files.len() == files.len() && self.effect_files.iter().zip(&files).all(|(a, b)| a.is_same(b)) {
            return Ok(Vec::new());
        }
        self.effects = effects(&self.renderer, files.clone())?;
        self.effect_files = files;
        Ok(if stage.is_some() { effect_warnings(&self.effect_files, self.job.format) } else { Vec::new() })
    }

    /// At time 0 and before a turntable turns, whatever the frame: so a frame is the same alone and in its sequence.
    fn metered(&mut self, scene: &mut Scene, framing: &Framing, look: &Look) -> Result<InputExposure, Failure> {
        let (args, job) = (self.args, self.job);
        pose(scene, args, time_secs(args, 0).map(|_| 0.0))?;
        let camera = view(scene, framing, args, (job, look), 0.0)?;
        InputExposure::new(&mut self.renderer, scene, &request(args, job, &self.settings, camera, scene))
    }
}

/// Warnings of what a fisheye picture shows otherwise than others.
fn of_fisheye(args: &RenderArgs, scene: &Scene) -> Vec<String> {
    let mut warnings = Vec::new();
    if args.frame.fov_y.is_some() {
        warnings.push("--fov-y does nothing: the angle of a fisheye is camera.fisheye_fov_deg".into());
    }
    if scene
        .materials
        .iter()
        .any(|material| material.transmission.is_some_and(|transmission| transmission.factor > 0.0))
    {
        let why = "the background behind them comes from only one of the views of a fisheye";
        warnings.push(format!("seams may show in transmissive surfaces: {why}"));
    }
    warnings
}

/// The warning of effects that show how things move, where nothing does.
fn unmoved(args: &RenderArgs, effects: &[EffectFile], scene: &Scene) -> Option<String> {
    // An animation alone is shown at its beginning.
    let moves = shot::moves(scene, args) && (args.time.is_some() || args.frames.is_some() || args.turntable.is_some());
    let effect = effects.iter().find(|effect| effect.reads_motion()).filter(|_| !moves)?;
    let name = effect.name();
    Some(format!("the effect `{name}` finds no motion: nothing moves without --frames, --time or --turntable"))
}

/// Warnings of a lens and a shutter that a picture will not show.
fn unsampled(args: &RenderArgs, settings: &Settings, scene: &Scene) -> Option<String> {
    let CameraSettings { f_stop, shutter_deg, .. } = settings.camera;
    let names = match (f_stop > 0.0, shutter_deg > 0.0) {
        (false, false) => return None,
        (true, false) => "camera.f_stop is",
        (false, true) => "camera.shutter_deg is",
        (true, true) => "camera.f_stop and camera.shutter_deg are",
    };
    if args.frame.samples < 2 {
        let of_one = "one sample is drawn, through a pinhole at the frame's time; add --samples 64, or more";
        return Some(format!("{names} left out: {of_one}"));
    }
    let stands = shutter_deg > 0.0 && !shot::moves(scene, args);
    stands.then(|| "camera.shutter_deg shows nothing: nothing moves without --frames, --time or --turntable".into())
}
