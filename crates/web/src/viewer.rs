//! The exported API.

use crate::options::{self, Options};
use crate::{
    blit::Blit,
    camera::{self, Orbit},
};
use manypass::{
    Averaging, Effect, EffectFile, FrameRequest, Gpu, Metering, Renderer, View, WgslEffect,
    scene::{Aabb, Framing, Scene, demo, gltf_file},
};
use std::collections::BTreeMap;
use std::sync::Arc;
use wasm_bindgen::prelude::*;

/// So many frames are averaged while nothing moves, as on the command line.
const REFINED_SAMPLES: u32 = 16;

/// Every canvas takes it; WebGPU canvases have no sRGB format, so the last shader encodes.
const CANVAS: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** Which API draws. `auto` takes WebGPU where there is an adapter, else WebGL 2. */
export type Backend = "auto" | "webgpu" | "webgl";
/** The adapter in use, and the size of the picture in pixels. */
export interface ViewerInfo { backend: "webgpu" | "webgl"; adapter: string; driver: string; width: number; height: number; }
/**
 * A camera that looks at `target` (metres) from `radius` metres away. Yaw 0 degrees looks along -Z and grows towards +X;
 * positive pitch looks down from above. What is missing is as in `startOrbit()`.
 */
export interface Orbit { yaw?: number; pitch?: number; radius?: number; target?: [number, number, number]; }
/** How frames are drawn; what is left out keeps its value. */
export interface RenderOptions {
  path?: "deferred" | "forward";
  lightCulling?: "clustered" | "none";
  /** Lights nothing, or with the built-in studio; `auto` takes the studio, faint where the model has lights. */
  environment?: "auto" | "studio" | "none";
  tonemap?: "neutral" | "aces" | "agx" | "reinhard" | "exponential" | "none";
  /** Stops, or metered once for a model: "auto", "auto+1", "auto-0.5". Null: "auto" where the model has lights, else 0. */
  exposure?: number | string | null;
  /** Only the lights k, k + n, k + 2n, … of [k, n]; null takes all. */
  lightSubset?: [number, number] | null;
  /** Settings by key, as in `--set` on the command line: `{ "clusters.tile_px": 32, "tone_map.curve": "agx" }`. */
  settings?: Record<string, number | boolean | string | (number | string)[]>;
}
/**
 * An effect of one's own, as on the command line: the name of its file, which stands in errors, the file's text, and settings
 * by key (`{ "echo.share": 0.25 }`).
 */
export interface EffectFile { file: string; source: string; settings?: RenderOptions["settings"]; }
/** The exposure in use: how it was found, what it comes to, and the log-average luminance if it was metered. */
export interface ExposureInfo { mode: "auto" | "stops"; stops: number; logAverageLuminance: number | null; }
/** What a `.gltf` refers to: its relative addresses as written in the file, and the bytes. */
export type Resources = Map<string, Uint8Array> | Record<string, Uint8Array>;
"#;

#[wasm_bindgen]
extern "C" {
    /// `Backend` of the TypeScript section.
    #[wasm_bindgen(typescript_type = "Backend")]
    pub type BackendName;
    /// `ViewerInfo` of the TypeScript section.
    #[wasm_bindgen(typescript_type = "ViewerInfo")]
    pub type ViewerInfo;
    /// `Orbit` of the TypeScript section.
    #[wasm_bindgen(typescript_type = "Orbit")]
    pub type OrbitObject;
    /// `RenderOptions` of the TypeScript section.
    #[wasm_bindgen(typescript_type = "RenderOptions")]
    pub type RenderOptions;
    /// `ExposureInfo` of the TypeScript section.
    #[wasm_bindgen(typescript_type = "ExposureInfo")]
    pub type ExposureInfo;
    /// Effects of the TypeScript section.
    #[wasm_bindgen(typescript_type = "EffectFile[]")]
    pub type EffectFiles;
    /// `Resources` of the TypeScript section.
    #[wasm_bindgen(typescript_type = "Resources | undefined")]
    pub type Resources;
}

/// A canvas with a renderer behind it.
#[wasm_bindgen]
pub struct Viewer {
    canvas: web_sys::HtmlCanvasElement,
    surface: wgpu::Surface<'static>,
    /// The size that `surface` was configured for.
    surface_size: Option<(u32, u32)>,
    adapter: wgpu::Adapter,
    blit: Blit,
    renderer: Renderer,
    scene: Option<Scene>,
    /// What an automatic camera shows whole.
    framing: Framing,
    warnings: Vec<String>,
    /// What the user chose: view, size and background come with each frame.
    options: Options,
    /// Passes of the user's own, in their order.
    effects: Vec<Arc<dyn Effect>>,
    /// The last frame that was drawn, for those that are added to it.
    last: Option<FrameRequest>,
    /// What was metered of the scene as it is first seen, so that the picture does not breathe while the view turns.
    metering: Option<Metering>,
    /// Whether anyone asks for radiance beside the picture.
    keeps_radiance: bool,
}

/// Binds `canvas`. A canvas keeps the first kind of context it was given, so `auto` decides before it touches one.
///
/// # Errors
/// When the browser has no adapter for `backend`; the message says what to turn on.
#[wasm_bindgen]
pub async fn create(canvas: web_sys::HtmlCanvasElement, backend: Option<BackendName>) -> Result<Viewer, JsError> {
    console_error_panic_hook::set_once();
    let name = backend.and_then(|name| JsValue::from(name).as_string()).unwrap_or_else(|| "auto".to_owned());
    let backends = match name.as_str() {
        "webgpu" => wgpu::Backends::BROWSER_WEBGPU,
        "webgl" => wgpu::Backends::GL,
        "auto" if wgpu::util::is_browser_webgpu_supported().await => wgpu::Backends::BROWSER_WEBGPU,
        "auto" => wgpu::Backends::GL,
        _ => return Err(JsError::new(&format!("backend is `{name}`: expected `auto`, `webgpu` or `webgl`"))),
    };
    Viewer::bind(canvas, backends, &name).await
}

/// What the user reads when there is no device; wgpu's own words come last.
fn no_device(error: &dyn std::fmt::Display, name: &str) -> JsError {
    let lacking = match name {
        "webgpu" => "no WebGPU",
        "webgl" => "no WebGL 2",
        _ => "neither WebGPU nor WebGL 2",
    };
    JsError::new(&format!(
        "This browser offers {lacking}. Turn on hardware acceleration in its settings, or try another browser.\n({error})"
    ))
}

impl Viewer {
    async fn bind(canvas: web_sys::HtmlCanvasElement, backends: wgpu::Backends, name: &str) -> Result<Self, JsError> {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = backends;
        let instance = wgpu::Instance::new(descriptor);
        let surface = instance
            .create_surface(wgpu::SurfaceTarget::Canvas(canvas.clone()))
            .map_err(|error| no_device(&error, name))?;
        let adapter = instance
            .request_adapter(&wgpu::RequestAdapterOptions { compatible_surface: Some(&surface), ..Default::default() })
            .await
            .map_err(|error| no_device(&error, name))?;
        let gpu = Gpu::from_adapter(&adapter).await.map_err(|error| no_device(&error, name))?;
        let blit = Blit::new(&gpu.device, CANVAS);
        let renderer = Renderer::new(gpu)?;
        Ok(Self {
            canvas,
            surface,
            surface_size: None,
            adapter,
            blit,
            renderer,
            scene: None,
            framing: Framing::of_bounds(&Aabb::EMPTY),
            warnings: Vec::new(),
            options: Options::default(),
            effects: Vec::new(),
            last: None,
            metering: None,
            keeps_radiance: false,
        })
    }

    fn size(&self) -> (u32, u32) {
        (self.canvas.width().max(1), self.canvas.height().max(1))
    }

    fn aspect(&self) -> f32 {
        let (width, height) = self.size();
        width as f32 / height as f32
    }

    fn take(&mut self, scene: Scene, warnings: Vec<String>) -> Result<(), JsError> {
        // A model that fails must not leave the former one half replaced.
        self.scene = None;
        self.last = None;
        self.metering = None;
        self.renderer.load(&scene)?;
        self.warnings = warnings;
        self.warnings.extend(self.renderer.warnings());
        self.framing = Framing::of_scene(&scene);
        self.scene = Some(scene);
        Ok(())
    }

    fn show(&mut self) -> Result<(), JsError> {
        let size = self.size();
        let gpu = self.renderer.gpu();
        if self.surface_size != Some(size) {
            let mut configuration = self
                .surface
                .get_default_config(&self.adapter, size.0, size.1)
                .ok_or_else(|| JsError::new("this canvas cannot be drawn on by the adapter"))?;
            configuration.format = CANVAS;
            self.surface.configure(&gpu.device, &configuration);
            self.surface_size = Some(size);
        }
        let output = match self.surface.get_current_texture() {
            wgpu::CurrentSurfaceTexture::Success(output) | wgpu::CurrentSurfaceTexture::Suboptimal(output) => output,
            other => {
                self.surface_size = None;
                return Err(JsError::new(&format!("the canvas gave nothing to draw into: {other:?}")));
            }
        };
        let picture = self.renderer.display_view().ok_or_else(|| JsError::new("nothing was rendered yet"))?;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        self.blit.record(&gpu.device, &mut encoder, &picture, &output.texture.create_view(&Default::default()));
        gpu.queue.submit([encoder.finish()]);
        gpu.queue.present(output);
        Ok(())
    }
}

#[wasm_bindgen]
impl Viewer {
    /// Takes a `.glb`, or a `.gltf` with the files it refers to. Replaces the model before.
    ///
    /// # Errors
    /// When the file cannot be read; the message names the place in it.
    pub fn load(&mut self, bytes: Vec<u8>, resources: Option<Resources>) -> Result<(), JsError> {
        let resources = resources.map(|resources| read_resources(&resources.into())).unwrap_or_default();
        let mut resolve = |uri: &str| {
            let found = resources.iter().find(|(name, _)| *name == uri || decode_uri(name) == uri);
            found.map(|(_, bytes)| bytes.clone()).ok_or_else(|| format!("`{uri}` was not given with the model"))
        };
        let loaded = gltf_file::load_bytes(&bytes, &mut resolve, "the model")?;
        self.take(loaded.scene, loaded.warnings)
    }

    /// Takes a built-in scene: `hall`.
    ///
    /// # Errors
    /// When there is no such scene.
    #[wasm_bindgen(js_name = loadDemo)]
    pub fn load_demo(&mut self, name: &str) -> Result<(), JsError> {
        if name != "hall" {
            return Err(JsError::new(&format!("unknown demo `{name}`: there is `hall`")));
        }
        let mut scene = demo::hall();
        scene.update_transforms();
        self.take(scene, Vec::new())
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
        self.last = None;
        self.metering = None;
        Ok(())
    }

    /// Draws one frame at the canvas's size: seen from `orbit`, or else from the model's first camera, or else so that
    /// the whole model is seen. Wait for the promise before you call another method.
    ///
    /// # Errors
    /// When no model is loaded, or the device fails.
    pub async fn render(&mut self, orbit: Option<OrbitObject>) -> Result<(), JsError> {
        let (width, height) = self.size();
        let aspect = self.aspect();
        let scene = self.scene.as_ref().ok_or_else(|| JsError::new("no model is loaded"))?;
        let orbit = orbit.map(|object| read_orbit(&object.into(), camera::start(scene, &self.framing, aspect)));
        let (world_from_view, projection) = camera::resolve(orbit, scene, &self.framing, aspect);
        let request = FrameRequest::new(width, height, View { world_from_view, projection });
        let mut request = self.options.applied(request, scene);
        request.sample_count = REFINED_SAMPLES;
        request.effects.clone_from(&self.effects);
        request.averaging = if self.keeps_radiance { Averaging::Both } else { Averaging::Display };
        self.last = None;
        let exposure = self.options.exposure(scene);
        if self.metering.is_none() && request.needs_metering(exposure) {
            let (world_from_view, projection) = camera::resolve(None, scene, &self.framing, aspect);
            let first = FrameRequest { camera: View { world_from_view, projection }, ..request.clone() };
            self.metering = Some(self.renderer.meter_async(scene, &first).await?);
        }
        request.expose(exposure, self.metering);
        self.renderer.render_async(scene, &request).await?;
        self.last = Some(request);
        self.show()
    }

    /// Adds one more frame, moved by a part of a pixel, to the last one, and shows the mean: so edges become smooth
    /// while nothing moves. False when nothing is left to add. Wait for the promise as with `render`.
    ///
    /// # Errors
    /// When the device fails.
    pub async fn refine(&mut self) -> Result<bool, JsError> {
        let (Some(scene), Some(request)) = (&self.scene, &mut self.last) else { return Ok(false) };
        let size = (self.canvas.width().max(1), self.canvas.height().max(1));
        if request.sample_index + 1 >= request.sample_count || size != (request.width, request.height) {
            return Ok(false);
        }
        request.sample_index += 1;
        self.renderer.render_async(scene, request).await?;
        let is_more_left = request.sample_index + 1 < request.sample_count;
        self.show()?;
        Ok(is_more_left)
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
        self.options = options;
        Ok(())
    }

    /// Puts effects between shading and tone curve from now on, in the place of those before.
    ///
    /// # Errors
    /// When one does not compile, or a setting is refused; the message names file, line and column. Nothing is changed
    /// then.
    #[wasm_bindgen(js_name = setEffects)]
    pub fn set_effects(&mut self, effects: EffectFiles) -> Result<(), JsError> {
        let mut compiled: Vec<Arc<dyn Effect>> = Vec::new();
        for effect in js_sys::Array::from(&effects.into()).iter() {
            let text = |key: &str| js_sys::Reflect::get(&effect, &key.into()).ok().and_then(|value| value.as_string());
            let (Some(file), Some(source)) = (text("file"), text("source")) else {
                return Err(JsError::new("an effect is an object with `file` and `source`"));
            };
            let mut parsed = EffectFile::parse(&file, &source)?;
            if let Some(settings) = js_sys::Reflect::get(&effect, &"settings".into()).ok().filter(JsValue::is_object) {
                for (key, value) in options::entries(&settings) {
                    parsed.give(&key, &value)?;
                }
            }
            compiled.push(Arc::new(WgslEffect::compile(self.renderer.gpu(), parsed)?));
        }
        self.effects = compiled;
        Ok(())
    }

    /// The radiance of the last frame: linear RGBA, four floats a pixel, rows from the top. The first call draws the frame
    /// again, and from then on frames keep their radiance. Wait for the promise as with `render`.
    ///
    /// # Errors
    /// When nothing was rendered, or the device was lost.
    pub async fn radiance(&mut self) -> Result<Vec<f32>, JsError> {
        self.keeps_radiance = true;
        let (Some(scene), Some(last)) = (&self.scene, &mut self.last) else {
            return Err(JsError::new("nothing was rendered yet"));
        };
        if last.averaging == Averaging::Display {
            (last.averaging, last.sample_index) = (Averaging::Both, 0);
            self.renderer.render_async(scene, last).await?;
        }
        Ok(self.renderer.read_radiance_async().await?)
    }

    /// The exposure of the last frame.
    pub fn exposure(&self) -> Option<ExposureInfo> {
        let (scene, last) = (self.scene.as_ref()?, self.last.as_ref()?);
        let average = last.metering.and_then(|metering| metering.log_average_luminance);
        let entries: [(&str, JsValue); 3] = [
            ("mode", self.options.exposure(scene).mode().into()),
            ("stops", last.exposure_stops().into()),
            ("logAverageLuminance", average.map_or(JsValue::NULL, JsValue::from)),
        ];
        Some(object(&entries).unchecked_into())
    }

    /// The orbit from which a user sets out: where the model's first camera stands, or else around the whole model.
    #[wasm_bindgen(js_name = startOrbit)]
    pub fn start_orbit(&self) -> Option<OrbitObject> {
        let orbit = camera::start(self.scene.as_ref()?, &self.framing, self.aspect());
        let target = js_sys::Float32Array::from(orbit.target_world.to_array().as_slice());
        let entries: [(&str, JsValue); 4] = [
            ("yaw", orbit.yaw_deg.into()),
            ("pitch", orbit.pitch_deg.into()),
            ("radius", orbit.radius_m.into()),
            ("target", js_sys::Array::from(&target).into()),
        ];
        Some(object(&entries).unchecked_into())
    }

    /// What was left out of, or replaced in, the model; one line each.
    pub fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// The last frame as RGBA, 8 bits each, rows from the top.
    ///
    /// # Errors
    /// When nothing was rendered, or the device was lost.
    pub async fn pixels(&self) -> Result<Vec<u8>, JsError> {
        Ok(self.renderer.read_display_async().await?)
    }

    /// The adapter in use, and the size of the picture.
    pub fn info(&self) -> ViewerInfo {
        let adapter = self.adapter.get_info();
        let backend = if adapter.backend == wgpu::Backend::Gl { "webgl" } else { "webgpu" };
        let (width, height) = self.size();
        let entries: [(&str, JsValue); 5] = [
            ("backend", backend.into()),
            ("adapter", adapter.name.as_str().into()),
            ("driver", adapter.driver.as_str().into()),
            ("width", width.into()),
            ("height", height.into()),
        ];
        object(&entries).unchecked_into()
    }

    /// Frees the GPU's memory and lets go of the canvas. The viewer cannot be used afterwards.
    pub fn dispose(self) {
        self.renderer.gpu().device.destroy();
    }
}

fn object(entries: &[(&str, JsValue)]) -> JsValue {
    let object = js_sys::Object::new();
    for (key, value) in entries {
        // Setting a property of a plain object cannot fail.
        let _ = js_sys::Reflect::set(&object, &(*key).into(), value);
    }
    object.into()
}

/// An orbit from JavaScript; what is missing, or no number, is taken from `start`.
fn read_orbit(value: &JsValue, start: Orbit) -> Orbit {
    let number = |object: &JsValue, key: &JsValue| {
        js_sys::Reflect::get(object, key).ok()?.as_f64().map(|n| n as f32).filter(|n| n.is_finite())
    };
    let target = js_sys::Reflect::get(value, &"target".into()).unwrap_or(JsValue::UNDEFINED);
    let mut target_world = start.target_world;
    for axis in 0..3 {
        target_world[axis as usize] = number(&target, &axis.into()).unwrap_or(target_world[axis as usize]);
    }
    Orbit {
        yaw_deg: number(value, &"yaw".into()).unwrap_or(start.yaw_deg),
        pitch_deg: number(value, &"pitch".into()).unwrap_or(start.pitch_deg),
        radius_m: number(value, &"radius".into()).filter(|m| *m > 0.0).unwrap_or(start.radius_m),
        target_world,
    }
}

/// `uri` without percent-encoding; as it is where that is broken.
fn decode_uri(uri: &str) -> String {
    js_sys::decode_uri_component(uri).map_or_else(|_| uri.to_owned(), String::from)
}

fn read_resources(resources: &JsValue) -> BTreeMap<String, Vec<u8>> {
    let entries = match resources.dyn_ref::<js_sys::Map>() {
        Some(map) => js_sys::Array::from(&map.entries()),
        None => resources.dyn_ref::<js_sys::Object>().map(js_sys::Object::entries).unwrap_or_default(),
    };
    let pair = |entry: JsValue| {
        let entry = js_sys::Array::from(&entry);
        Some((entry.get(0).as_string()?, entry.get(1).dyn_ref::<js_sys::Uint8Array>()?.to_vec()))
    };
    entries.iter().filter_map(pair).collect()
}
