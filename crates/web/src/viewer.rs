//! The exported API.

mod frame_times;
mod frames;
mod images;
mod info;
mod life;
mod time;
mod variables;

use crate::camera;
use crate::canvas::Canvas;
use crate::loss::Loss;
use crate::options::{self, Options};
use crate::overlay;
use crate::types::{
    EffectFiles, OrbitObject, OverlayItems, RenderOptions, Resources, decode_uri, object, read_resources,
};
use frame_times::FrameTimes;
use life::Backend;
pub use life::create;
use manypass::{
    Aov, EffectFile, FrameRequest, Metering, QualityBudget, Renderer, View, WgslEffect,
    scene::{
        Framing, LateImages, Overlay, Scene, Stage, demo, formats,
        renamed::{NameKind, renamed},
        stage,
        turns::{Turns, at_once},
        water::Water,
    },
};
use std::sync::Arc;
pub use time::ShownTime;
use wasm_bindgen::prelude::*;

/// A canvas with a renderer behind it.
#[wasm_bindgen]
pub struct Viewer {
    canvas: Canvas,
    renderer: Renderer,
    /// What the canvas is bound to again when its device was lost.
    wanted: Backend,
    loss: Loss,
    scene: Option<Scene>,
    /// Images that come after the model.
    late: LateImages,
    /// What an automatic camera shows whole.
    framing: Framing,
    warnings: Vec<String>,
    /// What the user chose: view, size and background come with each frame.
    options: Options,
    /// What chooses settings by what frames take.
    budget: Option<QualityBudget>,
    /// Passes of the user's own, in their order.
    effects: Vec<Arc<WgslEffect>>,
    /// The last frame that was drawn, for those that are added to it.
    last: Option<FrameRequest>,
    /// From where the frame before that was seen.
    camera_before: Option<View>,
    /// The variables that were drawn of the last frame.
    drawn: Vec<Aov>,
    /// What was metered of the scene as it is first seen, so that the picture does not breathe while the view turns.
    metering: Option<Metering>,
    /// When frames were drawn, for an exposure that adapts.
    frame_times: FrameTimes,
    /// The time of the scene that the next frame shows.
    time: ShownTime,
    /// Whether anyone asks for radiance beside the picture.
    keeps_radiance: bool,
    /// What the stage that is shown draws over the picture.
    of_stage: Arc<Overlay>,
}

/// The model that a stage names: a path from the stage's own place, or `demo:NAME`.
///
/// # Errors
/// When the stage is wrong; the message names the place in it.
#[wasm_bindgen(js_name = stageModel)]
pub fn stage_model(bytes: &[u8]) -> Result<String, JsError> {
    Ok(parsed_stage(bytes)?.model().to_owned())
}

/// The picture of the environment that a stage names, a path from the stage's own place; undefined if it names none.
///
/// # Errors
/// When the stage is wrong; the message names the place in it.
#[wasm_bindgen(js_name = stageEnvironment)]
pub fn stage_environment(bytes: &[u8]) -> Result<Option<String>, JsError> {
    Ok(parsed_stage(bytes)?.environment().map(str::to_owned))
}

/// The images that the materials of a stage name, the sprites and fonts of its overlay, and the files of light that its
/// environment names beside the picture: paths from the stage's own place.
///
/// # Errors
/// When the stage is wrong; the message names the place in it.
#[wasm_bindgen(js_name = stageImages)]
pub fn stage_images(bytes: &[u8]) -> Result<Vec<String>, JsError> {
    Ok(parsed_stage(bytes)?.images().into_iter().map(str::to_owned).collect())
}

fn parsed_stage(bytes: &[u8]) -> Result<Stage, JsError> {
    let text = std::str::from_utf8(bytes).map_err(|_| JsError::new("the stage is not UTF-8 text"))?;
    Stage::parse("the stage", text).map_err(|error| JsError::new(&error.to_string()))
}

/// The paths of the files that an OBJ refers to, as far as they are known: its libraries of materials, and the textures
/// of those that are among the `resources`. None of other models.
#[wasm_bindgen(js_name = modelFiles)]
pub fn model_files(bytes: &[u8], resources: Option<Resources>) -> Vec<String> {
    formats::named_files(bytes, &mut resolver(resources))
}

/// Finds what a model or a stage refers to.
fn resolver(resources: Option<Resources>) -> impl FnMut(&str) -> Result<Vec<u8>, String> {
    let resources = resources.map(|resources| read_resources(&resources.into())).unwrap_or_default();
    move |uri: &str| {
        let found = resources.iter().find(|(name, _)| *name == uri || decode_uri(name) == uri);
        found.map(|(_, bytes)| bytes.clone()).ok_or_else(|| format!("`{uri}` was not given with the model"))
    }
}

impl Viewer {
    fn take(&mut self, scene: Scene, warnings: Vec<String>, stage: Option<&Stage>) -> Result<(), JsError> {
        at_once(self.take_in_turns(scene, warnings, stage, &mut || None))
    }

    /// Takes the place of the model before. What there is to find out of a large model is found between turns.
    async fn take_in_turns(
        &mut self,
        mut scene: Scene,
        mut warnings: Vec<String>,
        stage: Option<&Stage>,
        turns: &mut Turns<'_>,
    ) -> Result<(), JsError> {
        let options = self.options.for_stage(stage)?;
        if options.simplifies() {
            warnings.extend(scene.simplify());
        }
        let has_moved = scene.bring_near();
        let (effects, budget) = (self.compiled(&options)?, options.budget()?);
        let framing = Framing::of_scene_in_turns(&scene, turns).await;
        // A model that fails must not leave the former one half replaced.
        self.scene = None;
        self.late = LateImages::default();
        (self.options, self.effects, self.budget) = (options, effects, budget);
        self.forget_frame();
        self.time.forget();
        self.renderer.forget_simulations();
        self.renderer.limit_textures(self.options.textures_max_px());
        self.renderer.load(&scene)?;
        self.warnings = warnings;
        self.warnings.extend(self.renderer.warnings());
        self.framing = framing;
        // What was moved is as fine as the numbers of its meshes.
        let bounds = if has_moved { scene.bounds_of_meshes() } else { *self.framing.bounds_world() };
        self.warnings.extend(bounds.far_warning());
        self.of_stage = scene.overlay.clone();
        self.scene = Some(scene);
        Ok(())
    }

    /// The effects of `options` on the device. Those that are there already, with the same texts, are given the values.
    fn compiled(&self, options: &Options) -> Result<Vec<Arc<WgslEffect>>, JsError> {
        let compile = |file: &EffectFile| -> Result<Arc<WgslEffect>, JsError> {
            let known = self.effects.iter().zip(self.options.effects()).find(|(_, known)| known.has_text_of(file));
            let Some((effect, _)) = known else {
                return Ok(Arc::new(WgslEffect::compile(self.renderer.gpu(), file.clone())?));
            };
            for (key, value) in file.values() {
                effect.set(&key, &value.to_string())?;
            }
            Ok(effect.clone())
        };
        options.effects().iter().map(compile).collect()
    }

    /// Forgets the last frame, because another scene comes in its place.
    fn forget_frame(&mut self) {
        (self.last, self.camera_before, self.metering) = (None, None, None);
        self.frame_times = FrameTimes::default();
        self.renderer.cut();
        self.drawn.clear();
    }
}

#[wasm_bindgen]
impl Viewer {
    /// Takes a model of any format that is read, with the files it refers to. The bytes tell the format. Replaces the
    /// model before.
    ///
    /// # Errors
    /// When the file cannot be read; the message names the place in it.
    pub fn load(&mut self, bytes: Vec<u8>, resources: Option<Resources>) -> Result<(), JsError> {
        let loaded = formats::load_bytes(&bytes, &mut resolver(resources), "the model")?;
        self.take(loaded.scene, loaded.warnings, None)
    }

    /// Takes a stage, `NAME.stage.toml`, with its model under the name that `stageModel` gives, the files that the
    /// model refers to, the picture that `stageEnvironment` names and the images of `stageImages`. Replaces the model
    /// before; options come after the stage's settings.
    ///
    /// # Errors
    /// When the stage or its model cannot be read; the message names the place in it.
    #[wasm_bindgen(js_name = loadStage)]
    pub fn load_stage(&mut self, bytes: Vec<u8>, resources: Option<Resources>) -> Result<(), JsError> {
        let loaded = stage::load_bytes(&bytes, &mut resolver(resources), "the stage")?;
        self.take(loaded.scene, loaded.warnings, Some(&loaded.stage))
    }

    /// Takes an equirectangular picture, Radiance (.hdr) or OpenEXR (.exr), as the environment of the model that is
    /// shown, until another is loaded. The option `environment` says whether it lights: with `auto` it does.
    ///
    /// # Errors
    /// When there is no model, or the picture cannot be read.
    #[wasm_bindgen(js_name = loadEnvironment)]
    pub fn load_environment(&mut self, bytes: Vec<u8>) -> Result<(), JsError> {
        let scene = self.scene.as_mut().ok_or_else(|| JsError::new("load a model first"))?;
        let map = manypass::scene::EnvironmentMap::decode("the environment", &bytes)?.with_sun_as_light();
        self.warnings.extend(map.notes.iter().cloned());
        scene.environment = Some(map.into());
        self.forget_frame();
        Ok(())
    }

    /// Draws `items` over the picture from the next frame on, after what the stage draws over it, until another model is
    /// loaded; an empty array takes away those before. They have the keys of `[[overlay]]` in stages; sprites and fonts
    /// are found by their names in `resources`.
    ///
    /// # Errors
    /// When there is no model, or an item cannot be drawn; the message names what is wrong. Those before stay then.
    #[wasm_bindgen(js_name = setOverlay)]
    pub fn set_overlay(&mut self, items: OverlayItems, resources: Option<Resources>) -> Result<(), JsError> {
        let scene = self.scene.as_mut().ok_or_else(|| JsError::new("load a model first"))?;
        let text = overlay::text_of(&items.into())?;
        let mut own = stage::read_overlay("the overlay", &text, scene, &mut resolver(resources))?;
        own.move_by(-scene.origin_m);
        scene.overlay = Overlay { items: self.of_stage.items.iter().cloned().chain(own.items).collect() }.into();
        Ok(())
    }

    /// Takes a built-in scene with its own settings: `hall`.
    ///
    /// # Errors
    /// When there is no such scene.
    #[wasm_bindgen(js_name = loadDemo)]
    pub fn load_demo(&mut self, name: &str) -> Result<(), JsError> {
        let known = || format!("unknown demo `{name}`: there are {}", demo::NAMES.join(", "));
        let mut scene = demo::named(name).ok_or_else(|| JsError::new(&known()))?;
        scene.update_transforms();
        let older = renamed(NameKind::Demo, name);
        self.take(scene, older.map(ToString::to_string).into_iter().collect(), demo::stage(name).as_ref())
    }

    /// The names of the file's scenes, in order; those without one are empty.
    pub fn scenes(&self) -> Vec<String> {
        let scenes = self.scene.iter().flat_map(|scene| &scene.scenes);
        scenes.map(|roots| roots.name.clone()).collect()
    }

    /// Shows another scene of the file, by its name or its index.
    ///
    /// # Errors
    /// When there is no such scene, or it draws too much; the one before stays then.
    #[wasm_bindgen(js_name = showScene)]
    pub fn show_scene(&mut self, name_or_index: &str) -> Result<(), JsError> {
        let scene = self.scene.as_mut().ok_or_else(|| JsError::new("no model is loaded"))?;
        let index = scene.scene_named(name_or_index);
        let index = index.ok_or_else(|| JsError::new(&format!("there is no scene `{name_or_index}`")))?;
        scene.show_scene(index)?;
        self.framing = Framing::of_scene(scene);
        self.forget_frame();
        Ok(())
    }

    /// The names of the file's variants (KHR_materials_variants), in order.
    pub fn variants(&self) -> Vec<String> {
        self.scene.iter().flat_map(|scene| &scene.variants).cloned().collect()
    }

    /// Shows the model in a variant, by its name or its index; without one, in the materials that the file shows first.
    ///
    /// # Errors
    /// When there is no such variant; the one before stays then.
    #[wasm_bindgen(js_name = showVariant)]
    pub fn show_variant(&mut self, name_or_index: Option<String>) -> Result<(), JsError> {
        let scene = self.scene.as_mut().ok_or_else(|| JsError::new("no model is loaded"))?;
        let index = name_or_index.map(|name| {
            scene.variant_named(&name).ok_or_else(|| JsError::new(&format!("there is no variant `{name}`")))
        });
        scene.variant = index.transpose()?;
        self.forget_frame();
        Ok(())
    }

    /// Whether anything moves as time goes by: an animation, waves, or a simulation.
    pub fn moves(&self) -> bool {
        let moves = |scene: &Scene| {
            !scene.animations.is_empty() || scene.has_simulations() || scene.water.iter().any(Water::has_waves)
        };
        self.scene.as_ref().is_some_and(moves)
    }

    /// Changes how frames are drawn from now on.
    ///
    /// # Errors
    /// When a value is none of those that are known; nothing is changed then.
    pub fn configure(&mut self, options: RenderOptions) -> Result<(), JsError> {
        let options = self.options.changed(&options.into())?;
        if !options.has_light_of(&self.options) {
            self.metering = None;
        }
        self.effects = self.compiled(&options)?;
        if !options.has_settings_of(&self.options) {
            self.budget = options.budget()?;
        }
        self.options = options;
        Ok(())
    }

    /// Puts effects before and after the tone curve from now on, in the place of those before: in their order, unless the
    /// setting `chain` has another.
    ///
    /// # Errors
    /// When one does not compile, or a setting is refused; the message names file, line and column. Nothing is changed
    /// then.
    #[wasm_bindgen(js_name = setEffects)]
    pub fn set_effects(&mut self, effects: EffectFiles) -> Result<(), JsError> {
        let mut given: Vec<EffectFile> = Vec::new();
        for effect in js_sys::Array::from(&effects.into()).iter() {
            let text = |key: &str| js_sys::Reflect::get(&effect, &key.into()).ok().and_then(|value| value.as_string());
            let mut parsed = match (text("name"), text("file"), text("source")) {
                (None, Some(file), Some(source)) => EffectFile::parse(&file, &source)?,
                (Some(name), None, None) => EffectFile::built_in(&name).ok_or_else(|| {
                    let known: Vec<_> = EffectFile::built_in_names().collect();
                    JsError::new(&format!("no effect is called `{name}`; there is: {}", known.join(", ")))
                })??,
                _ => return Err(JsError::new("an effect is an object with `name`, or with `file` and `source`")),
            };
            if let Some(settings) = js_sys::Reflect::get(&effect, &"settings".into()).ok().filter(JsValue::is_object) {
                for (key, value) in options::entries(&settings) {
                    parsed.give(&key, &value)?;
                }
            }
            given.push(parsed);
        }
        let options = self.options.with_effects(given)?;
        self.effects = self.compiled(&options)?;
        self.options = options;
        Ok(())
    }

    /// Gives the effect `name` another text from the next frame on; its settings keep their values where it takes them. So
    /// a file can be watched, or written in the page.
    ///
    /// # Errors
    /// When the text does not compile; the message names file, line and column, and the effect stays as it is.
    #[wasm_bindgen(js_name = replaceEffect)]
    pub fn replace_effect(&mut self, name: &str, source: &str) -> Result<(), JsError> {
        let options = self.options.with_text_of(name, source)?;
        self.effects = self.compiled(&options)?;
        self.options = options;
        Ok(())
    }

    /// The orbit from which a user sets out: where the model's first camera stands, or else around the whole model.
    #[wasm_bindgen(js_name = startOrbit)]
    pub fn start_orbit(&self) -> Option<OrbitObject> {
        let scene = self.scene.as_ref()?;
        let orbit = camera::start(scene, &self.framing, self.canvas.aspect());
        let target = orbit.target_world.as_dvec3() + scene.origin_m.as_dvec3();
        let target = js_sys::Float64Array::from(target.to_array().as_slice());
        let entries: [(&str, JsValue); 4] = [
            ("yaw", orbit.yaw_deg.into()),
            ("pitch", orbit.pitch_deg.into()),
            ("radius", orbit.radius_m.into()),
            ("target", js_sys::Array::from(&target).into()),
        ];
        Some(object(&entries).unchecked_into())
    }

    /// What was left out of, or replaced in, the model, and which older names are called otherwise now; one line each.
    pub fn warnings(&self) -> Vec<String> {
        [&self.warnings[..], &self.options.notices()].concat()
    }
}
