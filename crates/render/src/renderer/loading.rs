//! A scene that is uploaded in slices, between which others have the thread.

use super::Renderer;
use crate::request::RenderError;
use manypass_scene::turns::{Turns, give_turn};
use manypass_scene::{Mesh, Scene};
use std::sync::Arc;

/// Meshes of so many vertices are uploaded between two turns, or a larger one alone: some milliseconds.
const SLICE_VERTICES: usize = 1 << 16;

/// Each slice looks at all meshes that are there: so many slices at the most, which are larger then.
const SLICES_MAX: usize = 64;

impl Renderer {
    /// As [`Renderer::load`]; after every few meshes `turns` is asked whether others are to have the thread. No frame may
    /// be drawn before it is done.
    ///
    /// # Errors
    /// As [`Renderer::load`].
    pub async fn load_in_turns(&mut self, scene: &Scene, turns: &mut Turns<'_>) -> Result<(), RenderError> {
        self.load_in_slices(scene, SLICE_VERTICES, turns).await
    }

    async fn load_in_slices(
        &mut self,
        scene: &Scene,
        slice_vertices: usize,
        turns: &mut Turns<'_>,
    ) -> Result<(), RenderError> {
        for end in ends_of_slices(&scene.meshes, slice_vertices) {
            self.resources.follow_meshes(&self.gpu, &scene.meshes[..end]);
            give_turn(turns).await;
        }
        self.load(scene)
    }
}

/// How many of the first meshes are there after each slice. None where some have morph targets, whose table would move
/// with every slice.
fn ends_of_slices(meshes: &[Arc<Mesh>], slice_vertices: usize) -> Vec<usize> {
    let is_morphed = |mesh: &Arc<Mesh>| mesh.primitives.iter().any(|part| !part.morph_targets.is_empty());
    if meshes.iter().any(is_morphed) {
        return Vec::new();
    }
    let vertices_of = |mesh: &Arc<Mesh>| mesh.primitives.iter().map(|part| part.positions.len()).sum::<usize>();
    let slice_vertices = slice_vertices.max(meshes.iter().map(vertices_of).sum::<usize>() / SLICES_MAX);
    let mut ends = Vec::new();
    let mut vertices = 0;
    for (index, mesh) in meshes.iter().enumerate() {
        vertices += vertices_of(mesh);
        if vertices >= slice_vertices {
            ends.push(index + 1);
            vertices = 0;
        }
    }
    ends
}

#[cfg(all(test, not(target_arch = "wasm32")))]
mod tests {
    use super::*;
    use crate::{FrameRequest, Gpu};
    use manypass_testkit::scenes;

    #[test]
    fn slices_end_with_the_mesh_that_fills_them() {
        let mesh = |vertices: usize| {
            let positions = vec![Default::default(); vertices];
            Arc::new(Mesh {
                primitives: vec![manypass_scene::Primitive { positions, ..Default::default() }],
                ..Mesh::default()
            })
        };
        let meshes = [3, 9, 1, 10, 2].map(mesh);
        assert_eq!(ends_of_slices(&meshes, 10), [2, 4]);
        assert_eq!(ends_of_slices(&meshes, 1), [1, 2, 3, 4, 5]);
        let many: Vec<_> = (0..1000).map(|_| mesh(100)).collect();
        assert!(ends_of_slices(&many, 1).len() <= SLICES_MAX, "each slice looks at all meshes before it");
    }

    #[test]
    fn a_scene_that_is_uploaded_in_slices_is_drawn_as_one() {
        let (former, scene) = (scenes::one_light_on_one_plane().scene, scenes::rows_of_spheres().scene);
        let picture = |slice_vertices: Option<usize>| {
            let mut renderer = Renderer::new(Gpu::headless(None).unwrap()).unwrap();
            // Something that the scene takes the place of.
            renderer.load(&former).unwrap();
            renderer.render(&former, &FrameRequest::of_scene(&former, 48, 32)).unwrap();
            let mut asked = 0;
            match slice_vertices {
                Some(slice_vertices) => {
                    let mut turns = || {
                        asked += 1;
                        None
                    };
                    pollster::block_on(renderer.load_in_slices(&scene, slice_vertices, &mut turns)).unwrap();
                }
                None => renderer.load(&scene).unwrap(),
            }
            renderer.render(&scene, &FrameRequest::of_scene(&scene, 48, 32)).unwrap();
            (renderer.read_display().unwrap(), asked)
        };
        let ((whole, _), (sliced, asked)) = (picture(None), picture(Some(1)));
        assert_eq!(asked, scene.meshes.len());
        assert!(whole == sliced, "slices are drawn otherwise");
    }
}
