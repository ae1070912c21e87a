//! The canvas: binding it to an adapter, and showing pictures on it.

use crate::device::Device;
use crate::types::{ViewerInfo, object};
use manypass::Gpu;
use std::rc::Rc;
use wasm_bindgen::prelude::*;

/// Every canvas takes it; WebGPU canvases have no sRGB format, so the last shader encodes.
pub(crate) const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// A canvas and the device that draws on it.
pub(crate) struct Canvas {
    element: web_sys::HtmlCanvasElement,
    surface: wgpu::Surface<'static>,
    /// The size that `surface` was configured for.
    surface_size: Option<(u32, u32)>,
    device: Rc<Device>,
}

impl Canvas {
    /// Binds `element` to a device of one of `backends`, for which the user's word is `name`.
    ///
    /// # Errors
    /// There is none; the message says what to turn on.
    pub async fn bind(
        element: web_sys::HtmlCanvasElement,
        backends: wgpu::Backends,
        name: &str,
    ) -> Result<Self, JsError> {
        let (surface, device) = Device::bind(element.clone(), backends, name).await?;
        Ok(Self { element, surface, surface_size: None, device })
    }

    /// What it is bound to.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Whether no other canvas is bound to the device.
    pub fn is_alone(&self) -> bool {
        Rc::strong_count(&self.device) == 1
    }

    /// The canvas's element.
    pub fn element(&self) -> &web_sys::HtmlCanvasElement {
        &self.element
    }

    /// Whether it is WebGL that draws.
    pub fn is_webgl(&self) -> bool {
        self.device.adapter.get_info().backend == wgpu::Backend::Gl
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
        let adapter = self.device.adapter.get_info();
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
                .get_default_config(&self.device.adapter, size.0, size.1)
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
        self.device.blit.record(&gpu.device, &mut encoder, picture, &output.texture.create_view(&Default::default()));
        gpu.queue.submit([encoder.finish()]);
        gpu.queue.present(output);
        Ok(())
    }
}
