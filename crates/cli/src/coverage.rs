//! Whether a picture shows anything of its scene.

use glam::{Vec2, Vec3};
use manypass::{Background, FrameRequest, Ground, RenderError, Renderer, View};
use manypass_scene::{Aabb, Material, Projection, Scene, ShadingModel};

/// What is as large as this in the picture covers the middle of a pixel.
const CERTAIN_PX: f32 = 4.0;

/// The longer sides of the pictures in which surfaces are looked for, where the picture is no smaller: the second,
/// which is drawn if nothing is seen in the first, is bounded because nobody has asked for the memory that it takes.
const PROBES_PX: [f32; 2] = [128.0, 2048.0];

/// Whether no pixel of what `request` asks for will show a surface, although the scene has some. Most pictures need no
/// look at the device for it; where the camera sees no model whole, a small frame is drawn, and a larger one where that
/// is empty. It is for a time at which nothing that was rendered waits to be read.
///
/// # Errors
/// If the renderer fails.
pub fn is_empty(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Result<bool, RenderError> {
    let size_px = Vec2::new(request.width as f32, request.height as f32);
    let mut has_surfaces = false;
    for (bounds_world, is_solid) in boxes_world(scene) {
        has_surfaces = true;
        if is_solid && is_certainly_seen(&request.camera, &bounds_world, size_px) {
            return Ok(false);
        }
    }
    if !has_surfaces {
        return Ok(false);
    }
    for probe_px in PROBES_PX {
        let scale = (probe_px / size_px.max_element()).min(1.0);
        let probe = FrameRequest {
            width: ((size_px.x * scale) as u32).max(1),
            height: ((size_px.y * scale) as u32).max(1),
            sample_index: 0,
            sample_count: 1,
            settings: {
                let mut settings = request.settings.clone();
                settings.render.scale = 1.0;
                settings.background.source = Background::Transparent;
                settings.ground.mode = Ground::None;
                settings
            },
            want_aovs: Vec::new(),
            previous: None,
            effects: Vec::new(),
            ..request.clone()
        };
        renderer.render(scene, &probe)?;
        if !is_transparent(&renderer.read_display()?) {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Whether nothing of a scene shows without an environment: no light is in it, and no surface glows or is unlit.
pub fn is_dark(scene: &Scene) -> bool {
    let is_lit = scene.visible_nodes().into_iter().any(|id| scene.node(id).light.is_some());
    let glows =
        |material: &Material| material.shading_model == ShadingModel::Unlit || material.emissive_factor != Vec3::ZERO;
    !is_lit && !scene.materials.iter().any(glows)
}

/// The boxes of what is drawn, of each primitive, or of the whole mesh where that is deformed; and whether it is drawn
/// in any case and has volume in its own space: a plane has none however it is turned, and from behind it may not show.
/// Of several levels one is drawn, or none.
fn boxes_world(scene: &Scene) -> impl Iterator<Item = (Aabb, bool)> + '_ {
    let of_node =
        |(id, level): (_, Option<_>)| {
            let node = scene.node(id);
            let primitives = node.mesh.and_then(|mesh| scene.meshes.get(mesh)).map_or(&[][..], |mesh| &mesh.primitives);
            let is_deformed = node.skin.is_some() || primitives.iter().any(|part| !part.morph_targets.is_empty());
            let is_drawn = level.is_none();
            let whole = is_deformed.then_some((node.bounds_world, is_drawn));
            let parts = primitives.iter().filter(move |_| !is_deformed).filter(|part| !part.bounds.is_empty());
            whole.into_iter().chain(parts.map(move |part| {
                (part.bounds.transformed(&node.world_from_object), is_drawn && !is_thin(&part.bounds))
            }))
        };
    scene.visible_levels().into_iter().flat_map(of_node).filter(|(bounds, _)| !bounds.is_empty())
}

fn is_thin(bounds: &Aabb) -> bool {
    let extent = bounds.max - bounds.min;
    extent.min_element() <= 0.01 * extent.max_element()
}

fn is_transparent(rgba8: &[u8]) -> bool {
    rgba8.chunks_exact(4).all(|pixel| pixel.get(3) == Some(&0))
}

/// Whether a solid with this box shows in any case: all of it lies within the picture, and it is neither thin nor tiny.
fn is_certainly_seen(camera: &View, bounds: &Aabb, size_px: Vec2) -> bool {
    if is_thin(bounds) {
        return false;
    }
    let (near_m, far_m) = match camera.projection {
        Projection::Perspective { near_m, far_m, .. } => (near_m, far_m.unwrap_or(f32::INFINITY)),
        Projection::Orthographic { near_m, far_m, .. } => (near_m, far_m),
    };
    let half_extent = camera.half_extent(size_px.x / size_px.y);
    let view_from_world = camera.world_from_view.inverse();
    let (mut low_ndc, mut high_ndc) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
    for corner in bounds.corners() {
        let position_view = view_from_world.transform_point3(corner);
        let distance_m = -position_view.z;
        let scale = if camera.is_orthographic() { 1.0 } else { distance_m };
        let ndc = position_view.truncate() / (half_extent * scale);
        // A number that is none is not inside.
        if !(distance_m > near_m && distance_m < far_m && ndc.abs().max_element() < 1.0) {
            return false;
        }
        (low_ndc, high_ndc) = (low_ndc.min(ndc), high_ndc.max(ndc));
    }
    (0.5 * (high_ndc - low_ndc) * size_px).min_element() >= CERTAIN_PX
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]
    use super::*;
    use glam::Mat4;

    /// A camera, and a node before it with the mesh of level 0, if there is one, and that of level 1.
    fn leveled(has_mesh: [bool; 2]) -> Scene {
        use manypass_scene::{Camera, Levels, Mesh, Node, NodeId, primitives};
        let mut scene = Scene::default();
        let ball = primitives::uv_sphere(1.0, 12, 6);
        scene.meshes.push(Mesh { primitives: vec![ball], ..Mesh::default() }.into());
        let projection = Projection::Perspective { fov_y_rad: 1.0, near_m: 0.1, far_m: None };
        scene.cameras.push(Camera { name: String::new(), projection });
        scene.add_node(None, Node { translation: Vec3::Z * 5.0, camera: Some(0), ..Node::default() });
        let of = |has_mesh: bool| Node { mesh: has_mesh.then_some(0), ..Node::default() };
        let fine = scene.add_node(None, of(has_mesh[0]));
        let coarse = NodeId(scene.nodes.len() as u32);
        scene.nodes.push(of(has_mesh[1]));
        // The coarser one is drawn unless the node fills the picture.
        scene.node_mut(fine).levels = Some(Levels { coarser: vec![coarse], screen_coverage: vec![0.9, 0.0] });
        scene.update_transforms();
        scene
    }

    #[test]
    fn what_is_drawn_at_one_level_alone_is_looked_for() {
        let gpu = manypass::Gpu::headless(None).unwrap();
        let mut renderer = Renderer::new(gpu).unwrap();
        for (has_mesh, expected) in [([true, false], true), ([false, true], false), ([true, true], false)] {
            let scene = leveled(has_mesh);
            assert!(boxes_world(&scene).count() > 0, "{has_mesh:?}");
            renderer.load(&scene).unwrap();
            let request = FrameRequest::of_scene(&scene, 64, 64);
            assert_eq!(is_empty(&mut renderer, &scene, &request).unwrap(), expected, "{has_mesh:?}");
        }
        // A scene that has surfaces at no level is none that is not seen.
        let scene = leveled([false, false]);
        renderer.load(&scene).unwrap();
        assert!(!is_empty(&mut renderer, &scene, &FrameRequest::of_scene(&scene, 64, 64)).unwrap());
    }

    #[test]
    fn only_solids_that_lie_whole_in_the_picture_are_certain() {
        let projection = Projection::Perspective { fov_y_rad: 1.0, near_m: 0.1, far_m: None };
        let camera = View { world_from_view: Mat4::from_translation(Vec3::Z * 5.0), projection };
        let seen = |min: Vec3, max: Vec3| is_certainly_seen(&camera, &Aabb { min, max }, Vec2::new(64.0, 64.0));
        assert!(seen(-Vec3::ONE, Vec3::ONE));
        assert!(!seen(-Vec3::ONE, Vec3::new(1.0, 1.0, -1.0)), "thin");
        assert!(!seen(Vec3::ZERO, Vec3::splat(0.01)), "tiny");
        assert!(!seen(-Vec3::ONE, Vec3::new(9.0, 1.0, 1.0)), "cut");
        assert!(!seen(Vec3::splat(6.0), Vec3::splat(7.0)), "behind");
        assert!(!seen(Vec3::splat(f32::NAN), Vec3::ONE), "no number");
    }
}
