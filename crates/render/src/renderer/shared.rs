//! What renderers on one device share, and what one of them gives back while others go on.

use super::Renderer;
use crate::aov::AovTextures;
use crate::gpu::destroy;
#[cfg(target_arch = "wasm32")]
use crate::{gpu::Gpu, record::SurfacePipelines, request::RenderError, shader::Shaders};

/// What renderers share where none leaves its thread, and each has for itself elsewhere.
#[cfg(target_arch = "wasm32")]
pub(super) type SharedBox<T> = std::rc::Rc<T>;
/// What renderers share where none leaves its thread, and each has for itself elsewhere.
#[cfg(not(target_arch = "wasm32"))]
pub(super) type SharedBox<T> = Box<T>;

/// The programs and pipelines that renderers on one device share.
#[cfg(target_arch = "wasm32")]
#[derive(Clone)]
pub struct Pipelines {
    shaders: SharedBox<Shaders>,
    of_surfaces: SharedBox<SurfacePipelines>,
}

#[cfg(target_arch = "wasm32")]
impl Renderer {
    /// The programs and pipelines of the renderer, for others on its device.
    pub fn pipelines(&self) -> Pipelines {
        Pipelines { shaders: self.drawing.shaders.clone(), of_surfaces: self.drawing.surface_pipelines.clone() }
    }

    /// A renderer that makes no program and no pipeline which is among `pipelines`, those of `gpu`.
    ///
    /// # Errors
    /// As [`Renderer::new`].
    pub fn with_pipelines(gpu: Gpu, pipelines: &Pipelines) -> Result<Self, RenderError> {
        let mut renderer = Self::new(gpu)?;
        renderer.drawing.shaders = pipelines.shaders.clone();
        renderer.drawing.surface_pipelines = pipelines.of_surfaces.clone();
        Ok(renderer)
    }
}

impl Renderer {
    /// Gives back at once what pictures and the scene take of a device that others go on to use. To drop a renderer is
    /// not enough in browsers, which free what was dropped when they collect garbage.
    pub fn destroy(self) {
        for view in self.views.into_values() {
            view.aovs.iter().flat_map(AovTextures::all).for_each(wgpu::Texture::destroy);
            if let Some(output) = view.output {
                output.destroy();
            }
        }
        let atlas = self.shadows.atlas.iter().map(|atlas| &atlas.view);
        atlas.chain(&self.ground.texture).chain(self.surroundings.texture()).for_each(destroy);
        self.resources.destroy();
        self.executor.destroy();
    }
}
