//! A scene that is uploaded in slices, between which others have the thread.

use super::Renderer;
use crate::request::RenderError;
use manypass_scene::Scene;
use manypass_scene::turns::Turns;

impl Renderer {
    /// As [`Renderer::load`]; after every mesh, and between slices of a large one, `turns` is asked whether others are
    /// to have the thread. No frame may be drawn before it is done, and it is to be awaited to its end: of one that is
    /// dropped before, what was uploaded keeps its room until the renderer is dropped.
    ///
    /// # Errors
    /// As [`Renderer::load`].
    pub async fn load_in_turns(&mut self, scene: &Scene, turns: &mut Turns<'_>) -> Result<(), RenderError> {
        self.resources.follow_meshes(&self.gpu, &scene.meshes, turns).await;
        self.load(scene)
    }
}

#[cfg(all(test, not(target_arch = "wasm32")))]
#[allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]
mod tests {
    use super::*;
    use crate::{FrameRequest, Gpu};
    use manypass_testkit::scenes;

    /// The picture of `scene`, uploaded at once or in turns, and how many these were.
    fn picture(scene: &Scene, is_in_turns: bool) -> (Vec<u8>, usize) {
        let former = scenes::one_light_on_one_plane().scene;
        let mut renderer = Renderer::new(Gpu::headless(None).unwrap()).unwrap();
        // Something that the scene takes the place of.
        renderer.load(&former).unwrap();
        renderer.render(&former, &FrameRequest::of_scene(&former, 48, 32)).unwrap();
        let mut asked = 0;
        let mut turns = || {
            asked += 1;
            None
        };
        if is_in_turns {
            pollster::block_on(renderer.load_in_turns(scene, &mut turns)).unwrap();
        } else {
            renderer.load(scene).unwrap();
        }
        renderer.render(scene, &FrameRequest::of_scene(scene, 48, 32)).unwrap();
        (renderer.read_display().unwrap(), asked)
    }

    #[test]
    fn a_scene_that_is_uploaded_in_slices_is_drawn_as_one() {
        let scene = scenes::rows_of_spheres().scene;
        let ((whole, _), (sliced, asked)) = (picture(&scene, false), picture(&scene, true));
        assert!(asked >= scene.meshes.len(), "{asked} turns");
        assert!(whole == sliced, "slices are drawn otherwise");
    }

    #[test]
    fn a_large_primitive_is_uploaded_in_slices() {
        let mut scene = scenes::one_light_on_one_plane().scene;
        // More indices than a slice has, of triangles that cover nothing.
        let mesh = std::sync::Arc::make_mut(&mut scene.meshes[0]);
        mesh.primitives[0].indices.extend(std::iter::repeat_n(0, 3 << 16));
        let ((whole, _), (sliced, asked)) = (picture(&scene, false), picture(&scene, true));
        assert!(asked >= scene.meshes.len() + 6, "{asked} turns");
        assert!(whole == sliced, "slices are drawn otherwise");
    }
}
