//! The canvas: binding it to an adapter, and showing pictures on it.

use crate::blit::Blit;
use crate::types::{ViewerInfo, object};
use manypass::Gpu;
use wasm_bindgen::prelude::*;

/// Every canvas takes it; WebGPU canvases have no sRGB format, so the last shader encodes.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// A canvas and the adapter that draws on it.
pub(crate) struct Canvas {
    element: web_sys::HtmlCanvasElement,
    surface: wgpu::Surface<'static>,
    /// The size that `surface` was configured for.
    surface_size: Option<(u32, u32)>,
    adapter: wgpu::Adapter,
    blit: Blit,
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

impl Canvas {
    /// Binds `element` to an adapter of one of `backends`, for which the user's word is `name`; and a device of it.
    ///
    /// # Errors
    /// There is none; the message says what to turn on.
    pub async fn bind(
        element: web_sys::HtmlCanvasElement,
        backends: wgpu::Backends,
        name: &str,
    ) -> Result<(Self, Gpu), JsError> {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = backends;
        let instance = wgpu::Instance::new(descriptor);
        let surface = instance
            .create_surface(wgpu::SurfaceTarget::Canvas(element.clone()))
            .map_err(|error| no_device(&error, name))?;
        let adapter = instance
            .request_adapter(&wgpu::RequestAdapterOptions { compatible_surface: Some(&surface), ..Default::default() })
            .await
            .map_err(|error| no_device(&error, name))?;
        let gpu = Gpu::from_adapter(&adapter).await.map_err(|error| no_device(&error, name))?;
        let blit = Blit::new(&gpu.device, FORMAT);
        Ok((Self { element, surface, surface_size: None, adapter, blit }, gpu))
    }

    /// The canvas's element.
    pub fn element(&self) -> &web_sys::HtmlCanvasElement {
        &self.element
    }

    /// Whether it is WebGL that draws.
    pub fn is_webgl(&self) -> bool {
        self.adapter.get_info().backend == wgpu::Backend::Gl
    }

    /// Width and height in pixels, at least 1.
    pub fn size(&self) -> (u32, u32) {
        (self.element.width().max(1), self.element.height().max(1))
    }

    /// Width over height.
    pub fn aspect(&self) -> f32 {
        let (width, height) = self.size();
        width as f32 / height as f32
    }

    /// The adapter in use, and the size of the picture, with what is to be said of quality.
    pub fn info(&self, quality: JsValue) -> ViewerInfo {
        let adapter = self.adapter.get_info();
        let backend = if self.is_webgl() { "webgl" } else { "webgpu" };
        let (width, height) = self.size();
        let entries: [(&str, JsValue); 6] = [
            ("backend", backend.into()),
            ("adapter", adapter.name.as_str().into()),
            ("driver", adapter.driver.as_str().into()),
            ("width", width.into()),
            ("height", height.into()),
            ("quality", quality),
        ];
        object(&entries).unchecked_into()
    }

    /// Shows `picture`, which is display-encoded and of the canvas's size.
    ///
    /// # Errors
    /// The adapter cannot draw on the canvas, or it gives nothing to draw into.
    pub fn show(&mut self, gpu: &Gpu, picture: &wgpu::TextureView) -> Result<(), JsError> {
        let size = self.size();
        if self.surface_size != Some(size) {
            let mut configuration = self
                .surface
                .get_default_config(&self.adapter, size.0, size.1)
                .ok_or_else(|| JsError::new("this canvas cannot be drawn on by the adapter"))?;
            configuration.format = FORMAT;
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
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        self.blit.record(&gpu.device, &mut encoder, picture, &output.texture.create_view(&Default::default()));
        gpu.queue.submit([encoder.finish()]);
        gpu.queue.present(output);
        Ok(())
    }
}
