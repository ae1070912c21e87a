//! Variables beside the picture: drawn when somebody asks for them, with nothing else of the frame.

use super::Renderer;
use super::purpose::Purpose;
use crate::render_settings::Path;
use crate::request::{FrameRequest, RenderError};
use manypass_scene::Scene;

impl Renderer {
    /// Draws the variables that `request` wants, for [`Self::read_aov_async`], and nothing else of its frame: the
    /// picture that was rendered before, its mean and what effects keep stay as they are. So whoever shows pictures can
    /// ask for a variable of one afterwards, on the forward path too: its surfaces are those of the deferred one.
    /// [`crate::Aov::Radiance`] stays that of the picture.
    ///
    /// # Errors
    /// As [`Self::render_async`].
    pub async fn draw_variables_async(&mut self, scene: &Scene, request: &FrameRequest) -> Result<(), RenderError> {
        let mut request = request.with(|settings| {
            settings.render.path = Path::Deferred;
            // Variables are those of the middles of the picture's own pixels.
            settings.render.scale = 1.0;
        });
        request.sample_index = 0;
        request.effects.clear();
        let purpose = Purpose {
            draws_captures: false,
            draws_picture: false,
            shows_picture: false,
            keeps_variables: true,
            draws_variables_alone: true,
            ..Purpose::BESIDE
        };
        self.run(scene, &[("", &request)], &purpose).await.map(drop)
    }

    /// As [`Self::draw_variables_async`], waiting.
    ///
    /// # Errors
    /// As [`Self::render_async`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn draw_variables(&mut self, scene: &Scene, request: &FrameRequest) -> Result<(), RenderError> {
        pollster::block_on(self.draw_variables_async(scene, request))
    }
}
