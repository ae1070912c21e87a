//! The device of viewers: on WebGPU all share one, with its programs and pipelines; on WebGL each canvas has its own.

use crate::blit::Blit;
use crate::canvas::FORMAT;
use crate::loss;
use manypass::{Gpu, Pipelines, Renderer};
use std::cell::{OnceCell, RefCell};
use std::rc::{Rc, Weak};
use wasm_bindgen::prelude::*;

/// A device, and what all that is drawn on it has in common.
pub(crate) struct Device {
    pub gpu: Gpu,
    pub adapter: wgpu::Adapter,
    /// What shows pictures on canvases.
    pub blit: Blit,
    /// By which viewers are told of its loss; none of WebGL, where contexts tell of theirs.
    pub number: Option<u64>,
    instance: wgpu::Instance,
    /// Of the first renderer.
    pipelines: OnceCell<Pipelines>,
}

thread_local! {
    /// The device of WebGPU, while a viewer has it.
    static SHARED: RefCell<Weak<Device>> = const { RefCell::new(Weak::new()) };
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

impl Device {
    /// A device of one of `backends`, for which the user's word is `name`, and what it draws into on `element`.
    ///
    /// # Errors
    /// There is none; the message says what to turn on.
    pub async fn bind(
        element: web_sys::HtmlCanvasElement,
        backends: wgpu::Backends,
        name: &str,
    ) -> Result<(wgpu::Surface<'static>, Rc<Self>), JsError> {
        let shared = SHARED.with_borrow(Weak::upgrade);
        let shared = shared.filter(|device| backends == wgpu::Backends::BROWSER_WEBGPU && !device.is_lost());
        let new = || {
            let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
            descriptor.backends = backends;
            wgpu::Instance::new(descriptor)
        };
        let instance = shared.as_ref().map_or_else(new, |device| device.instance.clone());
        let surface =
            instance.create_surface(wgpu::SurfaceTarget::Canvas(element)).map_err(|error| no_device(&error, name))?;
        if let Some(device) = shared {
            return Ok((surface, device));
        }
        let adapter = instance
            .request_adapter(&wgpu::RequestAdapterOptions { compatible_surface: Some(&surface), ..Default::default() })
            .await
            .map_err(|error| no_device(&error, name))?;
        let gpu = Gpu::from_adapter(&adapter).await.map_err(|error| no_device(&error, name))?;
        let is_webgl = adapter.get_info().backend == wgpu::Backend::Gl;
        let device = Rc::new(Self {
            blit: Blit::new(&gpu.device, FORMAT),
            number: (!is_webgl).then(|| loss::watch_device(&gpu.device)),
            pipelines: OnceCell::new(),
            gpu,
            adapter,
            instance,
        });
        if !is_webgl {
            SHARED.set(Rc::downgrade(&device));
        }
        Ok((surface, device))
    }

    fn is_lost(&self) -> bool {
        self.number.is_some_and(loss::is_lost)
    }

    /// A renderer that makes no program and no pipeline which another one on the device has made.
    ///
    /// # Errors
    /// As `Renderer::new`.
    pub fn renderer(&self) -> Result<Renderer, JsError> {
        let renderer = match self.pipelines.get() {
            Some(pipelines) => Renderer::with_pipelines(self.gpu.clone(), pipelines)?,
            None => Renderer::new(self.gpu.clone())?,
        };
        self.pipelines.get_or_init(|| renderer.pipelines());
        Ok(renderer)
    }
}
