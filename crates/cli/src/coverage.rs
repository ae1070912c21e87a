//! Whether a picture shows anything of its scene.

use glam::{Mat4, Vec2, Vec3};
use manypass::{Background, Environment, Fisheye, FrameRequest, Ground, RenderError, Renderer, View};
use manypass_scene::{Aabb, AlphaMode, Material, Primitive, Projection, Scene, ShadingModel, Topology};

/// What is as large as this in the picture covers the middle of a pixel.
const CERTAIN_PX: f32 = 4.0;

/// A triangle with a circle of this radius inside of it, too, however it is turned and wherever the sample lies.
const CERTAIN_RADIUS_PX: f32 = 1.0;

/// About so many triangles are looked at, evenly of all primitives: most models have a large one among the first few, and
/// the look takes less than a millisecond.
const TRIANGLES_LOOKED_AT: usize = 10_000;

/// The longer sides of the pictures in which surfaces are looked for, where the picture is no smaller: the second,
/// which is drawn if nothing is seen in the first, is bounded because nobody has asked for the memory that it takes.
const PROBES_PX: [f32; 2] = [128.0, 2048.0];

/// Whether no pixel of what `request` asks for will show a surface, although the scene has some. Most pictures need no
/// look at the device for it; where the camera sees no model whole, nor a triangle large enough, a small frame is drawn
/// without environment and shadows, and a larger one where that is empty. It is for a time at which nothing that was
/// rendered waits to be read.
///
/// # Errors
/// If the renderer fails.
pub fn is_empty(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Result<bool, RenderError> {
    let size_px = Vec2::new(request.width as f32, request.height as f32);
    let projection = PixelProjection::new(&request.camera, size_px * request.settings.render.scale);
    let surfaces: Vec<Surface> = surfaces(scene).collect();
    // A fisheye shows things elsewhere.
    let is_known = request.settings.camera.fisheye == Fisheye::None;
    let is_seen = |surface: &Surface| is_known && surface.is_solid && projection.surely_shows(&surface.bounds_world);
    let most = (TRIANGLES_LOOKED_AT / surfaces.len().max(1)).max(1);
    let shows_part =
        |surface: &Surface| surface.shape.is_some_and(|shape| projection.surely_shows_part_of(shape, most));
    let has_seen = |surface: &Surface| is_known && shows_part(surface);
    if surfaces.is_empty() || surfaces.iter().any(is_seen) || surfaces.iter().any(has_seen) {
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
                settings.environment.source = Environment::None;
                settings.shadows.enabled = false;
                settings.taa.enabled = false;
                settings
            },
            want_aovs: Vec::new(),
            previous: None,
            effects: Vec::new(),
            overlay: std::sync::Arc::default(),
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
    let is_baked = |material: &Material| material.light_map.is_some();
    !is_lit && !scene.materials.iter().any(|material| glows(material) || is_baked(material))
}

/// Something that a scene draws.
struct Surface<'s> {
    /// The box of a primitive, or of the whole mesh where that is deformed.
    bounds_world: Aabb,
    /// Whether it is drawn in any case and has volume in its own space: a plane has none however it is turned, and from
    /// behind it may not show.
    is_solid: bool,
    /// Opaque triangles that are drawn in any case, just as they are.
    shape: Option<Shape<'s>>,
}

/// Triangles in their place.
#[derive(Clone, Copy)]
struct Shape<'s> {
    primitive: &'s Primitive,
    world_from_object: &'s Mat4,
    has_backs: bool,
}

/// All that is drawn; of several levels one is, or none.
fn surfaces(scene: &Scene) -> impl Iterator<Item = Surface<'_>> + '_ {
    let of_node = move |(id, level): (_, Option<_>)| {
        let node = scene.node(id);
        let primitives = node.mesh.and_then(|mesh| scene.meshes.get(mesh)).map_or(&[][..], |mesh| &mesh.primitives);
        let is_deformed = node.skin.is_some() || primitives.iter().any(|part| !part.morph_targets.is_empty());
        let is_drawn = level.is_none();
        let whole = is_deformed.then_some(Surface { bounds_world: node.bounds_world, is_solid: is_drawn, shape: None });
        let parts = primitives.iter().filter(move |_| !is_deformed).filter(|part| !part.bounds.is_empty());
        whole.into_iter().chain(parts.map(move |part| Surface {
            bounds_world: part.bounds.transformed(&node.world_from_object),
            is_solid: is_drawn && !is_thin(&part.bounds),
            shape: shape(scene, part, &node.world_from_object).filter(|_| is_drawn),
        }))
    };
    scene.visible_levels().into_iter().flat_map(of_node).filter(|surface| !surface.bounds_world.is_empty())
}

fn shape<'s>(scene: &Scene, primitive: &'s Primitive, world_from_object: &'s Mat4) -> Option<Shape<'s>> {
    let standard = Material::default();
    let material = primitive.material.and_then(|material| scene.materials.get(material)).unwrap_or(&standard);
    let is_as_it_is = primitive.topology == Topology::Triangles
        && primitive.levels.is_empty()
        && primitive.variant_materials.is_empty()
        && material.alpha_mode == AlphaMode::Opaque;
    is_as_it_is.then_some(Shape { primitive, world_from_object, has_backs: material.double_sided })
}

fn is_thin(bounds: &Aabb) -> bool {
    let extent = bounds.max - bounds.min;
    extent.min_element() <= 0.01 * extent.max_element()
}

fn is_transparent(rgba8: &[u8]) -> bool {
    rgba8.chunks_exact(4).all(|pixel| pixel.get(3) == Some(&0))
}

/// Where a camera shows points.
struct PixelProjection {
    view_from_world: Mat4,
    /// From view space at 1 m, or anywhere for parallel rays, to pixels from the middle of the picture.
    pixels_per_extent: Vec2,
    half_size_px: Vec2,
    near_m: f32,
    far_m: f32,
    is_parallel: bool,
}

impl PixelProjection {
    fn new(camera: &View, size_px: Vec2) -> Self {
        let (near_m, far_m) = match camera.projection {
            Projection::Perspective { near_m, far_m, .. } => (near_m, far_m.unwrap_or(f32::INFINITY)),
            Projection::Orthographic { near_m, far_m, .. } => (near_m, far_m),
        };
        let half_size_px = 0.5 * size_px;
        Self {
            view_from_world: camera.world_from_view.inverse(),
            pixels_per_extent: half_size_px / camera.half_extent(size_px.x / size_px.y),
            half_size_px,
            near_m,
            far_m,
            is_parallel: camera.is_orthographic(),
        }
    }

    /// Where a point in view space is shown, in pixels from the middle of the picture, y up; none if it is not. A number
    /// that is none is not shown.
    fn position_px(&self, position_view: Vec3) -> Option<Vec2> {
        let distance_m = -position_view.z;
        let scale = if self.is_parallel { 1.0 } else { distance_m };
        let position_px = position_view.truncate() * self.pixels_per_extent / scale;
        let is_inside = position_px.abs().cmplt(self.half_size_px).all();
        (distance_m > self.near_m && distance_m < self.far_m && is_inside).then_some(position_px)
    }

    /// Whether a solid with this box shows in any case: all of it lies within the picture, and it is neither thin nor
    /// tiny.
    fn surely_shows(&self, bounds_world: &Aabb) -> bool {
        let (mut low_px, mut high_px) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for corner in bounds_world.corners() {
            let Some(position_px) = self.position_px(self.view_from_world.transform_point3(corner)) else {
                return false;
            };
            (low_px, high_px) = (low_px.min(position_px), high_px.max(position_px));
        }
        !is_thin(bounds_world) && (high_px - low_px).min_element() >= CERTAIN_PX
    }

    /// Whether one of the first `most` triangles of a shape shows in any case, unless something hides it that shows
    /// itself.
    fn surely_shows_part_of(&self, shape: Shape<'_>, most: usize) -> bool {
        let Shape { primitive: Primitive { positions, indices, .. }, world_from_object, has_backs } = shape;
        let view_from_object = self.view_from_world * *world_from_object;
        // A mirror image has its fronts on the other side.
        let front = if world_from_object.determinant() < 0.0 { -1.0 } else { 1.0 };
        let corner_px = |corner: usize| {
            let index = if indices.is_empty() { corner } else { *indices.get(corner)? as usize };
            self.position_px(view_from_object.transform_point3(Vec3::from(*positions.get(index)?)))
        };
        let count = if indices.is_empty() { positions.len() } else { indices.len() } / 3;
        (0..count.min(most)).any(|triangle| {
            let corners = [0, 1, 2].map(|corner| corner_px(3 * triangle + corner));
            let [Some(a), Some(b), Some(c)] = corners else { return false };
            let doubled_area = (b - a).perp_dot(c - a) * front;
            let perimeter = a.distance(b) + b.distance(c) + c.distance(a);
            (doubled_area > 0.0 || has_backs) && doubled_area.abs() >= CERTAIN_RADIUS_PX * perimeter
        })
    }
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
        scene.cameras.push(Camera { name: String::new(), projection, aspect: None });
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
            assert!(surfaces(&scene).count() > 0, "{has_mesh:?}");
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
        let projected = PixelProjection::new(&camera, Vec2::new(64.0, 64.0));
        let seen = |min: Vec3, max: Vec3| projected.surely_shows(&Aabb { min, max });
        assert!(seen(-Vec3::ONE, Vec3::ONE));
        assert!(!seen(-Vec3::ONE, Vec3::new(1.0, 1.0, -1.0)), "thin");
        assert!(!seen(Vec3::ZERO, Vec3::splat(0.01)), "tiny");
        assert!(!seen(-Vec3::ONE, Vec3::new(9.0, 1.0, 1.0)), "cut");
        assert!(!seen(Vec3::splat(6.0), Vec3::splat(7.0)), "behind");
        assert!(!seen(Vec3::splat(f32::NAN), Vec3::ONE), "no number");
    }

    #[test]
    fn only_large_triangles_that_face_the_camera_are_certain() {
        let projection = Projection::Perspective { fov_y_rad: 1.0, near_m: 0.1, far_m: None };
        let camera = View { world_from_view: Mat4::from_translation(Vec3::Z * 5.0), projection };
        let projected = PixelProjection::new(&camera, Vec2::new(64.0, 64.0));
        let seen = |corners: [Vec3; 3], world_from_object: &Mat4, has_backs: bool| {
            // The first is too far away to be seen.
            let positions = [Vec3::X * 99.0; 3].into_iter().chain(corners).map(Vec3::into).collect();
            let primitive = Primitive { positions, ..Primitive::default() };
            projected.surely_shows_part_of(Shape { primitive: &primitive, world_from_object, has_backs }, 2)
        };
        let front = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let (here, mirrored) = (Mat4::IDENTITY, Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0)));
        assert!(seen(front, &here, false) && seen(front, &here, true) && seen(front, &mirrored, false));
        let back = [Vec3::ZERO, Vec3::Y, Vec3::X];
        assert!(seen(back, &here, true) && !seen(back, &here, false) && !seen(back, &mirrored, false));
        assert!(!seen(front.map(|corner| corner * 0.05), &here, true), "tiny");
        assert!(!seen([Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y * 0.03], &here, true), "thin");
        assert!(!seen(front.map(|corner| corner * 9.0), &here, true), "cut");
        assert!(!seen(front.map(|corner| corner + Vec3::Z * 6.0), &here, true), "behind");
        assert!(!seen(front.map(|corner| corner * f32::NAN), &here, true), "no number");
    }

    #[test]
    fn only_opaque_triangles_are_taken_as_they_are() {
        let mut scene = leveled([true, false]);
        let count = |scene: &Scene| surfaces(scene).filter(|surface| surface.shape.is_some()).count();
        assert_eq!(count(&scene), 0, "levels");
        scene.node_mut(manypass_scene::NodeId(1)).levels = None;
        scene.update_transforms();
        assert_eq!(count(&scene), 1);
        let mesh = scene.meshes.first().unwrap().clone();
        let mut primitive = mesh.primitives.first().unwrap().clone();
        primitive.material = Some(0);
        scene.materials.push(Material { alpha_mode: AlphaMode::Blend, ..Material::default() });
        scene.meshes = vec![manypass_scene::Mesh { primitives: vec![primitive], ..Default::default() }.into()];
        assert_eq!(count(&scene), 0, "blended");
    }
}
