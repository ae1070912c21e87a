//! The exported API.

use crate::{
    frame::{self, Model, Orbit},
    readback,
};
use std::collections::BTreeMap;
use wasm_bindgen::prelude::*;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** Which API draws. `auto` takes WebGPU where there is an adapter, else WebGL 2. */
export type Backend = "auto" | "webgpu" | "webgl";
/** The adapter in use, and the size of the picture in pixels. */
export interface ViewerInfo { backend: "webgpu" | "webgl"; adapter: string; driver: string; width: number; height: number; }
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
    /// `Resources` of the TypeScript section.
    #[wasm_bindgen(typescript_type = "Resources | undefined")]
    pub type Resources;
}

/// A canvas with a device behind it.
#[wasm_bindgen]
pub struct Viewer {
    canvas: web_sys::HtmlCanvasElement,
    surface: wgpu::Surface<'static>,
    adapter_info: wgpu::AdapterInfo,
    device: wgpu::Device,
    queue: wgpu::Queue,
    picture: wgpu::Texture,
    model: Option<Model>,
    orbit: Orbit,
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
    Viewer::bind(canvas, backends).await
}

fn describe(error: &dyn std::fmt::Display, backends: wgpu::Backends) -> JsError {
    let api = if backends.contains(wgpu::Backends::GL) { "WebGL 2" } else { "WebGPU" };
    JsError::new(&format!(
        "This browser offers no {api}: {error}. Turn on hardware acceleration, or try another browser."
    ))
}

impl Viewer {
    async fn bind(canvas: web_sys::HtmlCanvasElement, backends: wgpu::Backends) -> Result<Self, JsError> {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = backends;
        let instance = wgpu::Instance::new(descriptor);
        let surface = instance
            .create_surface(wgpu::SurfaceTarget::Canvas(canvas.clone()))
            .map_err(|error| describe(&error, backends))?;
        let adapter = instance
            .request_adapter(&wgpu::RequestAdapterOptions { compatible_surface: Some(&surface), ..Default::default() })
            .await
            .map_err(|error| describe(&error, backends))?;
        let (device, queue) = adapter
            .request_device(&wgpu::DeviceDescriptor { required_limits: adapter.limits(), ..Default::default() })
            .await
            .map_err(|error| describe(&error, backends))?;
        let picture = configure(&surface, &adapter, &device, &canvas)?;
        let orbit = Orbit { yaw_deg: 0.0, pitch_deg: 0.0, radius_m: 0.0 };
        Ok(Self { canvas, surface, adapter_info: adapter.get_info(), device, queue, picture, model: None, orbit })
    }
}

/// Configures the canvas and makes the picture that every frame is drawn into before it is copied there.
fn configure(
    surface: &wgpu::Surface<'_>,
    adapter: &wgpu::Adapter,
    device: &wgpu::Device,
    canvas: &web_sys::HtmlCanvasElement,
) -> Result<wgpu::Texture, JsError> {
    let (width, height) = (canvas.width().max(1), canvas.height().max(1));
    let mut configuration = surface
        .get_default_config(adapter, width, height)
        .ok_or_else(|| JsError::new("this canvas cannot be drawn on by the adapter"))?;
    configuration.format = wgpu::TextureFormat::Rgba8Unorm;
    surface.configure(device, &configuration);
    Ok(device.create_texture(&wgpu::TextureDescriptor {
        label: Some("picture"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    }))
}

#[wasm_bindgen]
impl Viewer {
    /// Takes a `.glb`, or a `.gltf` with the files it refers to. Replaces the model before.
    ///
    /// # Errors
    /// When the file is neither.
    pub fn load(&mut self, bytes: Vec<u8>, resources: Option<Resources>) -> Result<(), JsError> {
        let binary = bytes.starts_with(b"glTF");
        let json = bytes.iter().find(|byte| !byte.is_ascii_whitespace()) == Some(&b'{');
        if !binary && !json {
            return Err(JsError::new("this is neither a .glb nor a .gltf file"));
        }
        let resources = resources.map(|resources| read_resources(&resources.into())).unwrap_or_default();
        self.model = Some(Model { bytes, resources });
        Ok(())
    }

    /// Draws one frame. Yaw 0 looks along −Z; positive pitch looks down; a radius of 0 frames the model.
    ///
    /// # Errors
    /// When the canvas gives no picture to draw into.
    pub fn render(&mut self, yaw_deg: f32, pitch_deg: f32, radius_m: f32) -> Result<(), JsError> {
        self.orbit = Orbit { yaw_deg, pitch_deg, radius_m };
        let output = match self.surface.get_current_texture() {
            wgpu::CurrentSurfaceTexture::Success(output) | wgpu::CurrentSurfaceTexture::Suboptimal(output) => output,
            other => return Err(JsError::new(&format!("the canvas gave nothing to draw into: {other:?}"))),
        };
        let mut encoder = self.device.create_command_encoder(&Default::default());
        for texture in [&output.texture, &self.picture] {
            let view = texture.create_view(&Default::default());
            frame::record(&mut encoder, &view, self.model.as_ref(), self.orbit);
        }
        self.queue.submit([encoder.finish()]);
        self.queue.present(output);
        Ok(())
    }

    /// The last frame as RGBA, 8 bits each, rows from the top.
    ///
    /// # Errors
    /// When the picture cannot be mapped.
    pub async fn pixels(&self) -> Result<Vec<u8>, JsError> {
        readback::read_rgba8(&self.device, &self.queue, &self.picture).await
    }

    /// The adapter in use, and the size of the picture.
    pub fn info(&self) -> ViewerInfo {
        let object = js_sys::Object::new();
        let backend = if self.adapter_info.backend == wgpu::Backend::Gl { "webgl" } else { "webgpu" };
        let entries: [(&str, JsValue); 5] = [
            ("backend", backend.into()),
            ("adapter", self.adapter_info.name.as_str().into()),
            ("driver", self.adapter_info.driver.as_str().into()),
            ("width", self.picture.width().into()),
            ("height", self.picture.height().into()),
        ];
        for (key, value) in entries {
            // Setting a property of a plain object cannot fail.
            let _ = js_sys::Reflect::set(&object, &key.into(), &value);
        }
        JsValue::from(object).unchecked_into()
    }

    /// Frees the GPU's memory and lets go of the canvas. The viewer cannot be used afterwards.
    pub fn dispose(self) {
        self.picture.destroy();
        self.device.destroy();
        drop(self.canvas);
    }
}

fn read_resources(resources: &JsValue) -> BTreeMap<String, Vec<u8>> {
    let entries = match resources.dyn_ref::<js_sys::Map>() {
        Some(map) => js_sys::Array::from(&map.entries()),
        None => resources.dyn_ref::<js_sys::Object>().map(js_sys::Object::entries).unwrap_or_default(),
    };
    let pair = |entry: JsValue| {
        let entry = js_sys::Array::from(&entry);
        Some((entry.get(0).as_string()?, js_sys::Uint8Array::new(&entry.get(1)).to_vec()))
    };
    entries.iter().filter_map(pair).collect()
}
