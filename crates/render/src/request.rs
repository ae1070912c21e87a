//! What a frame is asked for, and what is told of it afterwards.

mod error;
mod exposure;
mod lamps;
mod stats;

pub use error::RenderError;
pub use stats::{FrameStats, PairCounts};

use crate::aov::Aov;
use crate::camera_settings::Fisheye;
use crate::effect::{Effect, EffectStage};
use crate::environment::Environment;
use crate::exposure::{Adaptation, Exposure, Metering};
use crate::fisheye::FisheyeLens;
use crate::pass_info::Reach;
use crate::passes::PASSES;
use crate::passes::upscale::UpscaleMethod;
use crate::pose::Pose;
use crate::render_settings::Path;
use crate::settings::{Settings, Switch};
use crate::shadows::Dealing;
use crate::transparency::TransparencyMode;
use crate::view::View;
use glam::{Vec3, Vec4};
use manypass_scene::capture::LAYERS_ALL;
use manypass_scene::{Framing, Overlay, Scene};
use std::cell::LazyCell;
use std::sync::Arc;

/// A request for a frame: size, camera, samples, settings, effects, AOVs. Everything but the scene.
///
/// Start from [`Self::of_scene`] or [`Self::new`] and change what differs. Later versions may add fields, so a literal
/// ends with a base. (The type is not `#[non_exhaustive]`, which would forbid that form.)
///
/// ```
/// use manypass::{FrameRequest, scene};
///
/// let scene = scene::demo::hall();
/// let mut request = FrameRequest { sample_count: 8, ..FrameRequest::of_scene(&scene, 640, 360) };
/// request.settings.shadows.enabled = false;
/// ```
#[derive(Clone, Debug)]
pub struct FrameRequest {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// From where the scene is seen.
    pub camera: View,
    /// Where world space has its origin in the space of the file ([`Scene::origin_m`]): positions that are read are told
    /// in the file's space, rounded to floats there.
    pub origin_m: Vec3,
    /// What lies on the negative side of this plane (x, y, z, w with `x·X + y·Y + z·Z + w < 0` in world space) is not
    /// drawn: what is behind a mirror, or before a portal. The plane must not lead through the eye.
    pub clip_plane_world: Option<Vec4>,
    /// The layers that are seen ([`manypass_scene::Node::layers`]), a bit each. Light and shadows are those of all.
    pub layers: u32,
    /// Which of the accumulated frames this is; 0 starts anew.
    pub sample_index: u32,
    /// How many frames are accumulated. A single one needs no means: its picture is made of its radiance at once.
    pub sample_count: u32,
    /// How many frames, one after the other, make up one sample: they show the scene through the same point of every
    /// pixel, each under other lights. 1 unless [`Self::light_rounds`] is more than the number of samples.
    pub frames_per_sample: u32,
    /// In how many rounds lights share the atlas of shadow maps over the frames of a picture, so that every light casts
    /// its shadow: what [`crate::Renderer::light_rounds`] says. There have to be at least so many frames, and of all
    /// but what glows radiance is averaged. None where every frame stands for itself: then lights beyond the atlas, and
    /// beyond `shadows.maps` of the settings, cast no shadow, and are counted.
    pub light_rounds: Option<u32>,
    /// Whether a frame that starts anew still goes on from the view's last one: what effects keep from frame to frame
    /// lasts, as a live view wants it. It is shown before its other samples are there, so its textures and shadows are
    /// filtered like those of a picture of its own. Otherwise a picture depends on nothing before its first sample, and
    /// all its samples are filtered alike.
    pub goes_on: bool,
    /// Whether effects go on from what they made in the view's last frame (`reads: previous`), as the frames of a
    /// sequence do; all else depends on nothing before it. [`Self::goes_on`] says so, too.
    pub effects_go_on: bool,
    /// The height of the ground, if there is one (`ground.mode`): where the scene's lowest point is, over an animation
    /// if it plays. Without it the lower side of the bounds of what is drawn, which encloses what is turned with some
    /// room.
    pub ground_height_m: Option<f32>,
    /// Settings of the passes.
    pub settings: Settings,
    /// Only the lights k, k + n, k + 2n, … of (k, n); for tests that add them up.
    pub light_subset: Option<(u32, u32)>,
    /// What was metered; none: the light is taken to be at the level of the exposure. [`Self::expose`] sets it.
    pub metering: Option<Metering>,
    /// How the exposure follows from that of the view's last picture, where settings ask for that.
    pub adaptation: Adaptation,
    /// What is averaged over the samples, and so what can be read.
    pub averaging: Averaging,
    /// The variables that will be read after the frame.
    pub want_aovs: Vec<Aov>,
    /// The scene and camera of the previous frame, for [`Aov::Motion`] and effects that read `motion`. A view that is
    /// anti-aliased by its last frame ([`Self::is_temporal`]) knows that frame's, which come first.
    pub previous: Option<Arc<Pose>>,
    /// Passes of the user's own, after shading and before accumulation, in this order.
    pub effects: Vec<Arc<dyn Effect>>,
    /// What is drawn over the finished picture; radiance and variables are without it. [`Self::of_scene`] takes that of
    /// the scene. One that is made anew has its letters rasterised anew: keep it while it stays the same.
    ///
    /// ```
    /// # use manypass::{FrameRequest, scene};
    /// use manypass::scene::overlay::{Overlay, OverlayItem, OverlayPlace};
    /// # let scene = scene::demo::hall();
    /// let mut request = FrameRequest::of_scene(&scene, 640, 360);
    /// let lamp = OverlayItem::text("lamp", OverlayPlace::at_world([0.0, 6.5, 6.0].into()));
    /// let frame = OverlayItem::line(vec![[8.5, 8.5].into(), [-8.5, 8.5].into()]);
    /// request.overlay = Overlay { items: vec![OverlayItem { depth_test: true, ..lamp }, frame] }.into();
    /// ```
    pub overlay: Arc<Overlay>,
}

/// The averages over the samples of a picture that can be read afterwards. The picture of a single sample is the
/// same whatever is averaged; its radiance is kept unless this is [`Self::Display`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Averaging {
    /// Colours of the display, after the tone curve: edges are smooth however bright one side is. Where lights take
    /// turns ([`FrameRequest::light_rounds`]) only what glows; of all else radiance is, in another pair of textures of
    /// 16 bytes a pixel.
    #[default]
    Display,
    /// Radiance, for linear files. The picture is the tone curve of that mean.
    Radiance,
    /// Both, in another pair of textures of 16 bytes a pixel.
    Both,
}

/// What a scene asks for where nobody says.
pub(crate) struct SceneDefaults {
    environment: Environment,
    exposure: Exposure,
    exposure_under_sky: Exposure,
}

impl SceneDefaults {
    pub fn of(scene: &Scene) -> Self {
        let environment = Environment::of_scene(scene);
        let exposure = |environment| Exposure::Scene.resolved(scene, environment);
        Self { environment, exposure: exposure(environment), exposure_under_sky: exposure(Environment::Sky) }
    }
}

impl FrameRequest {
    /// Whether samples go through the tone curve before they are averaged; a single one goes through it afterwards.
    pub(crate) fn averages_display(&self) -> bool {
        let is_asked = self.sample_count > 1 && self.averaging != Averaging::Radiance;
        is_asked && !self.deals_lights() && !self.has_late_exposure()
    }

    /// Whether samples are right in the mean of radiance alone, or their exposure is known only when they are drawn.
    fn has_late_exposure(&self) -> bool {
        self.is_stochastic() || self.samples_lens_or_shutter() || self.adapts()
    }

    /// Whether later samples leave out what earlier ones agree on, as far as the request says: where display colours
    /// are averaged, and no pass of their frames looks at what lies beside its pixel ([`Reach`]), nor an effect.
    pub(crate) fn is_adaptive(&self) -> bool {
        let Settings { adaptive, render, .. } = &self.settings;
        let is_of_pixels = PASSES.iter().all(|pass| match (pass.reach)(&self.settings) {
            None | Some(Reach::OwnPixel) => true,
            Some(Reach::FirstSamples) => render.path == Path::Deferred,
            Some(Reach::EverySample) => false,
        });
        let is_of_pixels = is_of_pixels && !self.changes_radiance();
        adaptive.threshold > 0.0 && is_of_pixels && self.averages_display() && !self.averages_radiance()
    }

    /// Whether the part of samples that glows goes through the tone curve before it is averaged, and the rest
    /// afterwards: a light that shines in some samples alone, and is so much brighter there, is right in the mean of
    /// radiance only. What effects leave of the parts nobody knows.
    pub(crate) fn averages_parts(&self) -> bool {
        let (_, samples) = self.sample();
        let is_asked = samples > 1 && self.averaging != Averaging::Radiance && self.deals_lights();
        // A mean over a pixel of marks of what glows is none.
        let is_whole =
            !self.changes_radiance() && !self.is_temporal() && !self.is_fisheye() && !self.is_enlarged_along_edges();
        let is_marked = is_whole && self.settings.msaa.samples.count() == 1;
        is_asked && is_marked && !self.has_late_exposure()
    }

    /// Whether samples show one of several surfaces in place of their mixture, which goes through the tone curve
    /// afterwards, what glows too.
    fn is_stochastic(&self) -> bool {
        self.settings.transparency.mode == TransparencyMode::Stochastic
    }

    /// The radius in pixels of the image circle of a fisheye; none for other projections.
    pub fn fisheye_radius_px(&self) -> Option<f64> {
        FisheyeLens::new(&self.settings.camera, (self.width, self.height)).map(|lens| lens.radius_px)
    }

    /// Whether the picture is put together from views of all sides.
    pub(crate) fn is_fisheye(&self) -> bool {
        self.settings.camera.fisheye != Fisheye::None
    }

    /// Whether a pass makes the picture's size of that at which frames are shaded.
    fn is_enlarged_along_edges(&self) -> bool {
        let Settings { render, upscale, .. } = &self.settings;
        render.scale < 1.0 && upscale.method != UpscaleMethod::Bilinear
    }

    /// Whether effects make new radiance of every sample's.
    fn changes_radiance(&self) -> bool {
        self.effects.iter().any(|effect| effect.is_on() && effect.stage() == EffectStage::Radiance)
    }

    /// Whether something reads how far surfaces moved since the previous frame.
    pub(crate) fn needs_motion(&self) -> bool {
        let is_read = || crate::effect::is_read(&self.effects, "motion");
        self.resolves_over_time() || self.want_aovs.contains(&Aov::Motion) || is_read()
    }

    /// Whether pictures have temporal anti-aliasing (`taa.enabled`): those of live views, and those of one sample. Later
    /// samples of a live view do not; their mean is smooth without it.
    pub fn is_temporal(&self) -> bool {
        let is_asked = self.settings.taa.enabled && self.settings.effects.enabled;
        is_asked && (self.goes_on || self.sample_count <= 1)
    }

    /// Whether the frame is anti-aliased by those before it.
    pub(crate) fn resolves_over_time(&self) -> bool {
        self.is_temporal() && self.sample_index == 0
    }

    /// Whether samples are right in the mean of radiance alone, whatever lens there is.
    pub(crate) fn needs_mean_of_radiance(&self) -> bool {
        self.sample_count > 1 && (self.deals_lights() || self.is_stochastic())
    }

    fn deals_lights(&self) -> bool {
        self.light_rounds.is_some_and(|rounds| rounds > 1)
    }

    /// Index and number of the sample that the frame is of.
    pub(crate) fn sample(&self) -> (u32, u32) {
        let frames = self.frames_per_sample.max(1);
        (self.sample_index / frames, self.sample_count.div_ceil(frames))
    }

    /// How lights share the atlas of shadow maps.
    pub(crate) fn dealing(&self) -> Dealing {
        let (frame, frames, rounds) = (self.sample_index, self.sample_count, self.light_rounds);
        Dealing { frame, frames, rounds, goes_on: self.goes_on }
    }

    /// Whether radiance can be read when all samples are drawn.
    pub fn averages_radiance(&self) -> bool {
        self.averaging != Averaging::Display || self.want_aovs.contains(&Aov::Radiance)
    }

    /// A request that shows `scene` through its first camera, or else all of it; under its own lights and a faint
    /// studio, or else in the studio. Where the scene brings lights, [`crate::Renderer::expose`] finds the exposure.
    pub fn of_scene(scene: &Scene, width: u32, height: u32) -> Self {
        let (aspect, framing) = (width as f32 / height.max(1) as f32, Framing::of_scene(scene));
        let (world_from_view, projection) = scene.first_camera(aspect).unwrap_or_else(|| framing.automatic(aspect));
        let ground_height_m = framing.lowest_m();
        let camera = View { world_from_view, projection };
        let overlay = scene.overlay.clone();
        Self { ground_height_m, overlay, origin_m: scene.origin_m, ..Self::new(width, height, camera) }
            .with_scene_defaults(&LazyCell::new(|| SceneDefaults::of(scene)))
    }

    /// The same request with settings resolved: those that are left to the scene, and those that depend on other
    /// settings.
    pub fn resolved(&self, scene: &Scene) -> Self {
        self.resolved_by(&LazyCell::new(|| SceneDefaults::of(scene)))
    }

    /// As [`Self::resolved`], of several requests for one scene.
    pub(crate) fn resolved_by(&self, defaults: &LazyCell<SceneDefaults, impl FnOnce() -> SceneDefaults>) -> Self {
        self.with_scene_defaults(defaults).without_effects_that_are_off().with_switches_resolved()
    }

    /// The same with what the scene says of light and exposure.
    fn with_scene_defaults(&self, defaults: &LazyCell<SceneDefaults, impl FnOnce() -> SceneDefaults>) -> Self {
        self.with(|settings| {
            if settings.environment.source == Environment::Auto {
                settings.environment.source = defaults.environment;
            }
            if settings.exposure.stops == Exposure::Scene {
                let is_outside = matches!(settings.environment.source, Environment::Sky | Environment::File);
                let of_scene = if is_outside { defaults.exposure_under_sky } else { defaults.exposure };
                settings.exposure.stops = if settings.exposure.adapt { Exposure::AUTO } else { of_scene };
            }
        })
    }

    /// The same without what [`crate::effect::EffectSettings::enabled`] switches off.
    fn without_effects_that_are_off(mut self) -> Self {
        if !self.settings.effects.enabled {
            self.effects.clear();
            self.settings.occlusion.enabled = Switch::Off;
            self.settings.reflections.enabled = Switch::Off;
            self.settings.gi.enabled = false;
            self.settings.taa.enabled = false;
            self.settings.shadows.contact_m = 0.0;
            self.settings.upscale.method = UpscaleMethod::Bilinear;
        }
        self
    }

    /// What is asked of a picture within this one: radiance, without what variables, effects and overlays would be.
    pub(crate) fn within(&self, settings: Settings) -> Self {
        Self {
            averaging: Averaging::Radiance,
            want_aovs: Vec::new(),
            previous: None,
            effects: Vec::new(),
            overlay: Default::default(),
            settings,
            ..self.clone()
        }
    }

    /// The same with what the settings leave open, as they allow it.
    pub(crate) fn with_switches_resolved(mut self) -> Self {
        let is_of_one_view = !self.is_fisheye();
        // The first frame of a live view is shown before the others are there.
        let sample_count = if self.goes_on { 1 } else { self.sample_count };
        let Settings { render, occlusion, reflections, transparency, .. } = &mut self.settings;
        transparency.masks = transparency.masks.resolved(sample_count);
        let is_possible = is_of_one_view && render.path != Path::Gouraud;
        occlusion.enabled = occlusion.enabled.resolved(is_possible);
        reflections.enabled = reflections.enabled.resolved(is_possible);
        self
    }

    /// The same request with changed settings.
    pub fn with(&self, change: impl FnOnce(&mut Settings)) -> Self {
        let mut request = self.clone();
        change(&mut request.settings);
        request
    }

    /// A request with the defaults of the command line.
    pub fn new(width: u32, height: u32, camera: View) -> Self {
        Self {
            width,
            height,
            camera,
            origin_m: Vec3::ZERO,
            clip_plane_world: None,
            layers: LAYERS_ALL,
            ground_height_m: None,
            sample_index: 0,
            sample_count: 1,
            frames_per_sample: 1,
            light_rounds: None,
            goes_on: false,
            effects_go_on: false,
            settings: Settings::default(),
            light_subset: None,
            metering: None,
            adaptation: Adaptation::default(),
            averaging: Averaging::default(),
            want_aovs: Vec::new(),
            previous: None,
            effects: Vec::new(),
            overlay: Arc::default(),
        }
    }
}
