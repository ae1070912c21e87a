//! A viewer's life: it is bound to a canvas, bound again when the device was lost, and disposed of.

use super::{FrameTimes, ShownTime, Viewer};
use crate::canvas::Canvas;
use crate::loss::Loss;
use crate::options::Options;
use crate::types::BackendName;
use manypass::{
    Renderer,
    scene::{Aabb, Framing, LateImages},
};
use std::sync::Arc;
use wasm_bindgen::prelude::*;

/// Which API is to draw, and the user's word for it.
#[derive(Clone, Debug)]
pub(super) struct Backend {
    name: String,
    backends: wgpu::Backends,
}

impl Backend {
    /// A canvas keeps the first kind of context it was given, so `auto` decides before it touches one.
    async fn named(name: Option<BackendName>) -> Result<Self, JsError> {
        let name = name.and_then(|name| JsValue::from(name).as_string()).unwrap_or_else(|| "auto".to_owned());
        let backends = match name.as_str() {
            "webgpu" => wgpu::Backends::BROWSER_WEBGPU,
            "webgl" => wgpu::Backends::GL,
            "auto" if wgpu::util::is_browser_webgpu_supported().await => wgpu::Backends::BROWSER_WEBGPU,
            "auto" => wgpu::Backends::GL,
            _ => return Err(JsError::new(&format!("backend is `{name}`: expected `auto`, `webgpu` or `webgl`"))),
        };
        Ok(Self { name, backends })
    }

    /// Binds `element`, and begins to watch its device.
    async fn bind(&self, element: web_sys::HtmlCanvasElement) -> Result<(Canvas, Renderer, Loss), JsError> {
        let canvas = Canvas::bind(element, self.backends, &self.name).await?;
        let loss = Loss::watch(canvas.device().number, canvas.element());
        let renderer = canvas.device().renderer()?;
        Ok((canvas, renderer, loss))
    }
}

/// Binds `canvas`. A canvas keeps the first kind of context it was given, so `auto` decides before it touches one.
///
/// # Errors
/// When the browser has no adapter for `backend`; the message says what to turn on.
#[wasm_bindgen]
pub async fn create(canvas: web_sys::HtmlCanvasElement, backend: Option<BackendName>) -> Result<Viewer, JsError> {
    console_error_panic_hook::set_once();
    let wanted = Backend::named(backend).await?;
    let (canvas, renderer, loss) = wanted.bind(canvas).await?;
    Ok(Viewer {
        canvas,
        renderer,
        wanted,
        loss,
        scene: None,
        late: LateImages::default(),
        framing: Framing::of_bounds(&Aabb::EMPTY),
        warnings: Vec::new(),
        options: Options::default(),
        budget: None,
        effects: Vec::new(),
        last: None,
        camera_before: None,
        drawn: Vec::new(),
        metering: None,
        frame_times: FrameTimes::default(),
        time: ShownTime::new(),
        keeps_radiance: false,
        of_stage: Arc::default(),
    })
}

#[wasm_bindgen]
impl Viewer {
    /// What tells of the loss of the device that the viewer has now.
    pub fn loss(&self) -> Loss {
        self.loss.clone()
    }

    /// Binds the canvas again after its device was lost: the model, what was given to it, options and effects are as
    /// before. Simulations begin anew, and the next `render` draws.
    ///
    /// # Errors
    /// When the browser gives no device.
    pub async fn restore(&mut self) -> Result<(), JsError> {
        self.loss.happen();
        let (canvas, renderer, loss) = self.wanted.bind(self.canvas.element().clone()).await?;
        let former = (
            std::mem::replace(&mut self.canvas, canvas),
            std::mem::replace(&mut self.renderer, renderer),
            std::mem::take(&mut self.effects),
            self.last.take(),
        );
        if self.canvas.is_webgl() {
            // To a restored context the objects of before are another context's, whose deletion is an error. Their
            // memory went with the context.
            std::mem::forget(former);
        }
        self.loss = loss;
        self.forget_frame();
        self.effects = self.compiled(&self.options)?;
        self.renderer.limit_textures(self.options.textures_max_px());
        if let Some(scene) = &self.scene {
            self.renderer.load(scene)?;
        }
        Ok(())
    }

    /// Frees the GPU's memory and lets go of the canvas. The viewer cannot be used afterwards.
    pub fn dispose(self) {
        let Self { canvas, renderer, effects, last, loss, time, .. } = self;
        // It would keep the page's viewer alive.
        time.forget_listener();
        if loss.is_of_context() {
            std::mem::forget((canvas, renderer, effects, last));
        } else if canvas.is_alone() {
            renderer.gpu().device.destroy();
        } else {
            renderer.destroy();
        }
    }
}
