//! Flat mirrors: which a view shows, and what is asked of the views behind them.

use super::part::{PlannedView, settings_of, widest_range};
use super::view_kind::{Drawing, MirrorLink, MirrorView, Reflector, ViewKind};
use crate::camera_settings::{CameraSettings, Fisheye};
use crate::environment::Background;
use crate::outline::is_seen;
use crate::passes::resolve::PixelSamples;
use crate::render_settings::Path;
use crate::request::{FrameRequest, RenderError};
use crate::resources::layers::ShadedIn;
use crate::view::View;
use glam::{Mat4, Vec2, Vec3, Vec4};
use manypass_scene::capture::{MIRRORS_MAX, Mirror, Panel};
use manypass_scene::portal::{PORTALS_MAX, Portal, through};
use manypass_scene::water::WATER_MAX;
use manypass_scene::{Material, NodeId, Projection, Scene, ShadingModel};
use std::collections::BTreeSet;

/// The most views behind mirrors that a frame draws, those of mirrors within mirrors too.
pub(super) const VIEWS_MAX: usize = 64;

/// A mirror is smooth up to this perceptual roughness, if no map says otherwise.
const SMOOTH_ROUGHNESS: f32 = 0.02;

/// What is nearer to a mirror than this share of its size is cut from what it shows: its own surface.
const CUT_SHARE: f32 = 1e-4;

/// The eye is in a mirror's plane if it is nearer than this share of its size, and sees nothing of it.
const EDGE_ON_SHARE: f32 = 1e-4;

/// The largest scale.
const SCALE_MAX: f32 = 2.0;

/// How much more than the picture is drawn behind a rough mirror, which reflects what is beside it: so large a share on
/// each side.
const ROUGH_MARGIN: f32 = 0.3;

/// A mirror that is drawn, or water.
struct MirrorSurface<'s> {
    of: Reflector,
    panel: Panel,
    is_smooth: bool,
    name: &'s str,
    /// The node that it is, whose layers say who sees it.
    node: NodeId,
    scale: f32,
    layers: u32,
    quality: Option<&'s str>,
    /// Where it leads, if it is an end of a portal: the matrix, and the other end.
    through: Option<(Mat4, Panel)>,
}

impl Reflector {
    /// What it is called.
    fn kind(self) -> &'static str {
        match self {
            Self::Node(_) => "mirror",
            Self::Water(_) => "water",
            Self::Portal(..) => "portal",
        }
    }
}

impl<'s> MirrorSurface<'s> {
    /// The corners of its panel in the space that the view behind it sees: those of a mirror stay where they are.
    fn corners_behind(&self) -> [Vec3; 4] {
        let corners = self.panel.corners_world();
        match &self.through {
            None => corners,
            Some((matrix, _)) => corners.map(|corner| matrix.transform_point3(corner)),
        }
    }

    /// The view behind it, for a view of a kind: each pixel of smooth ones shows one direction, while others show what is
    /// beside, too.
    fn kind_behind(&self, viewer: &ViewKind) -> ViewKind {
        let Self { is_smooth, of, .. } = *self;
        let (shift_ndc, beyond) = viewer.shear;
        let margin = if is_smooth { 1.0 } else { 1.0 + 2.0 * ROUGH_MARGIN };
        let shear = (shift_ndc / margin, beyond);
        ViewKind {
            is_capture: true,
            is_sheared: shear != (Vec2::ZERO, 0.0),
            shear,
            outline_world: is_smooth.then(|| self.corners_behind()),
            margin,
            // What lies behind everything is what surfaces get light of; suns are lights on water with waves.
            constants: match of {
                Reflector::Water(_) if !is_smooth => &[("shows_light", 2)],
                Reflector::Water(_) | Reflector::Node(_) => &[("shows_light", 1)],
                Reflector::Portal(..) => &[],
            },
            ..ViewKind::within(Drawing::Mirror(MirrorView { is_smooth, of }))
        }
    }

    fn mirror(scene: &'s Scene, mirror: &'s Mirror) -> Option<Self> {
        let Mirror { name, node, scale, layers, quality } = mirror;
        let panel = scene.panel(*node).ok()?;
        Some(Self {
            of: Reflector::Node(*node),
            panel,
            is_smooth: is_smooth(scene, *node),
            name,
            node: *node,
            scale: *scale,
            layers: *layers,
            quality: quality.as_deref(),
            through: None,
        })
    }

    fn water(scene: &'s Scene, index: usize) -> Option<Self> {
        let water = scene.water.get(index)?;
        let panel = scene.panel(water.node).ok()?;
        Some(Self {
            of: Reflector::Water(index),
            // Its lower side reflects, too.
            panel: Panel { is_double_sided: true, ..panel },
            is_smooth: !water.has_waves(),
            name: &water.name,
            node: water.node,
            scale: water.scale,
            layers: water.layers,
            quality: water.quality.as_deref(),
            through: None,
        })
    }

    fn portal(scene: &'s Scene, (index, end): (usize, usize)) -> Option<Self> {
        let Portal { name, nodes, scale, layers, quality, .. } = scene.portals.get(index)?;
        if nodes[0] == nodes[1] {
            return None;
        }
        let [panel, other] = [end, 1 - end].map(|end| scene.panel(nodes[end]).ok());
        let (panel, other) = (panel?, other?);
        Some(Self {
            of: Reflector::Portal(index, end),
            panel: Panel { is_double_sided: false, ..panel },
            is_smooth: true,
            name,
            node: nodes[end],
            scale: *scale,
            layers: *layers,
            quality: quality.as_deref(),
            through: Some((through(&panel, &other), other)),
        })
    }
}

/// The mirrors of a scene that are drawn, and its water.
pub(super) struct Mirrors<'s> {
    all: Vec<MirrorSurface<'s>>,
    /// The largest side of a picture.
    limit_px: u32,
}

impl<'s> Mirrors<'s> {
    pub fn of(scene: &'s Scene, limit_px: u32) -> Self {
        if scene.mirrors.is_empty() && scene.water.is_empty() && scene.portals.is_empty() {
            return Self { all: Vec::new(), limit_px };
        }
        let is_drawn = |mirror: &&Mirror| scene.shows(mirror.node) && unsuited_material(scene, mirror.node).is_none();
        let known = scene.mirrors.iter().take(MIRRORS_MAX).filter(is_drawn);
        let mirrors = known.filter_map(|mirror| MirrorSurface::mirror(scene, mirror));
        let water = (0..scene.water.len().min(WATER_MAX)).filter_map(|index| MirrorSurface::water(scene, index));
        let ends = (0..scene.portals.len().min(PORTALS_MAX)).flat_map(|index| [(index, 0), (index, 1)]);
        let portals = ends.filter_map(|end| MirrorSurface::portal(scene, end));
        let others = water.chain(portals).filter(|known| scene.shows(known.node));
        let all = mirrors.chain(others).collect();
        Self { all, limit_px }
    }

    pub fn len(&self) -> usize {
        self.all.len()
    }

    /// The views behind the mirrors that `parts` show, down to `depth` mirrors within mirrors, each before whoever shows it;
    /// and the parts, which know of them. Those that are in the fewest others come first where there are too many; `drawn`
    /// counts those of the frame, and `shown` has what of them reflects.
    ///
    /// # Errors
    /// A mirror asks for a tier of quality that there is not.
    pub fn before(
        &self,
        scene: &Scene,
        parts: Vec<PlannedView>,
        depth: u32,
        (drawn, shown): (&mut usize, &mut BTreeSet<Reflector>),
    ) -> Result<Vec<PlannedView>, RenderError> {
        // Every view with the one that shows it, and how deep it is; those that are deeper follow.
        let mut all: Vec<(PlannedView, usize, u32)> = parts.into_iter().map(|part| (part, usize::MAX, 0)).collect();
        let mut next = 0;
        while next < all.len() {
            if all[next].2 < depth {
                let inner = self.behind(scene, &mut all[next].0, (&mut *drawn, &mut *shown))?;
                let level = all[next].2 + 1;
                all.extend(inner.into_iter().map(|part| (part, next, level)));
            }
            next += 1;
        }
        // Backwards each comes before whoever shows it; parts keep their order.
        let mut ordered: Vec<Vec<PlannedView>> = all.iter().map(|_| Vec::new()).collect();
        let mut done = Vec::new();
        for (at, (part, shown_by, _)) in all.into_iter().enumerate().rev() {
            let mut of_part = std::mem::take(&mut ordered[at]);
            of_part.push(part);
            match ordered.get_mut(shown_by) {
                Some(before) => before.extend(of_part),
                None => done.push(of_part),
            }
        }
        Ok(done.into_iter().rev().flatten().collect())
    }

    /// The views behind the mirrors that a part shows, which knows of them from then on.
    fn behind(
        &self,
        scene: &Scene,
        part: &mut PlannedView,
        (drawn, shown): (&mut usize, &mut BTreeSet<Reflector>),
    ) -> Result<Vec<PlannedView>, RenderError> {
        let mut parts = Vec::new();
        if !part.kind.draws_surfaces {
            return Ok(parts);
        }
        let has_reflections = part.request.settings.render.path != Path::Gouraud;
        for (at, known) in self.all.iter().enumerate() {
            let MirrorSurface { of, panel, is_smooth, name, node, .. } = known;
            let is_possible = has_reflections || known.through.is_some();
            if scene.node(*node).layers & part.request.layers == 0 || !is_possible {
                continue;
            }
            let of_viewer = (&part.request, part.kind.is_sheared);
            let Some((behind, normal_world)) = request_behind(known, self.limit_px, of_viewer)? else { continue };
            *drawn += 1;
            // Those beyond are counted, but not drawn.
            if *drawn > VIEWS_MAX {
                continue;
            }
            shown.insert(*of);
            let is_twin = |other: &&MirrorSurface<'_>| other.name == *name && other.of.kind() == of.kind();
            let twin = self.all.iter().take(at).filter(is_twin).count();
            let number = if twin > 0 { format!(".{}", twin + 1) } else { String::new() };
            let outer = if part.name.is_empty() { String::new() } else { format!("{}/", part.name) };
            let view = format!("{outer}{}/{name}{number}", of.kind());
            part.mirrors.push(MirrorLink {
                view: view.clone(),
                of: *of,
                normal_world,
                corners_world: panel.corners_world(),
                is_smooth: *is_smooth,
            });
            let kind = known.kind_behind(&part.kind);
            parts.push(PlannedView { level: part.level, ..PlannedView::new(view, behind, kind) });
        }
        Ok(parts)
    }
}

/// What is wrong with mirrors of a scene, which are drawn as other surfaces then.
pub(super) fn faults(scene: &Scene) -> Vec<String> {
    let fault = |mirror: &Mirror| {
        let what = scene.panel(mirror.node).err()?;
        Some(format!("mirror `{}` is not drawn: a mirror is flat, and its node {what}", mirror.name))
    };
    let unsuited = |mirror: &Mirror| {
        let material = unsuited_material(scene, mirror.node)?;
        let remedy = "give it an opaque material without layers, such as by `color`";
        Some(format!(
            "mirror `{}` shows no picture, because its material `{material}` blends, has layers or is unlit; {remedy}",
            mirror.name
        ))
    };
    let known = || scene.mirrors.iter().take(MIRRORS_MAX);
    let mut faults: Vec<String> = known().filter_map(fault).chain(known().filter_map(unsuited)).collect();
    if scene.mirrors.len() > MIRRORS_MAX {
        faults.push(format!("only the first {MIRRORS_MAX} of {} mirrors are drawn", scene.mirrors.len()));
    }
    faults
}

/// The name of a node's first material that the G-buffer does not hold, or that no light reaches.
fn unsuited_material(scene: &Scene, id: NodeId) -> Option<&str> {
    let mesh = scene.nodes.get(id.0 as usize)?.mesh.and_then(|mesh| scene.meshes.get(mesh))?;
    let materials = mesh.primitives.iter().filter_map(|primitive| primitive.material_in(scene.variant));
    let mut known = materials.filter_map(|material| scene.materials.get(material));
    let is_unsuited = |material: &&Material| {
        ShadedIn::of(material) != ShadedIn::Deferred || material.shading_model == ShadingModel::Unlit
    };
    known.find(is_unsuited).map(|material| material.name.as_str())
}

/// Whether every pixel of a node's surface reflects one direction.
fn is_smooth(scene: &Scene, id: NodeId) -> bool {
    let mesh = scene.node(id).mesh.and_then(|mesh| scene.meshes.get(mesh));
    let materials = mesh
        .into_iter()
        .flat_map(|mesh| &mesh.primitives)
        .map(|primitive| primitive.material_in(scene.variant).and_then(|material| scene.materials.get(material)));
    materials.flatten().all(|material| {
        let has_maps = material.metallic_roughness_texture.is_some() || material.normal_texture.is_some();
        material.roughness_factor <= SMOOTH_ROUGHNESS && !has_maps && material.height.is_none()
    })
}

/// What is asked of the view behind a mirror where `request` is asked of what shows it, and the normal of the mirror's
/// plane towards the eye. None if that sees nothing of it: it is out of sight, or turns its back or its edge.
fn request_behind(
    known: &MirrorSurface<'_>,
    limit_px: u32,
    (request, is_sheared): (&FrameRequest, bool),
) -> Result<Option<(FrameRequest, Vec3)>, RenderError> {
    let MirrorSurface { panel, is_smooth, scale, layers, quality, through, .. } = known;
    let View { world_from_view, projection } = request.camera;
    let plane = panel.plane_world();
    // The eye, or with parallel rays the direction in which it is.
    let eye = world_from_view.col(if request.camera.is_orthographic() { 2 } else { 3 });
    let height_m = plane.dot(eye) * if request.camera.is_orthographic() { panel.size_m() } else { 1.0 };
    let side = if panel.is_double_sided { height_m.signum() } else { 1.0 };
    let is_before = side * height_m > EDGE_ON_SHARE * panel.size_m();
    let aspect = request.width as f32 / request.height.max(1) as f32;
    let clip_from_view = request.camera.clip_from_view(widest_range(&request.camera), aspect, Vec2::ZERO);
    let clip_from_world = clip_from_view * world_from_view.inverse();
    let is_cut = |plane: Vec4| panel.corners_world().iter().all(|corner| plane.dot(corner.extend(1.0)) <= 0.0);
    let is_seen = is_sheared || request.samples_lens_or_shutter() || is_seen(&clip_from_world, &panel.corners_world());
    if !is_before || !is_seen || request.clip_plane_world.is_some_and(is_cut) {
        return Ok(None);
    }
    let plane = side * plane;
    let normal = plane.truncate();
    let mirrored = Mat4::from_cols(
        (Vec3::X - 2.0 * normal.x * normal).extend(0.0),
        (Vec3::Y - 2.0 * normal.y * normal).extend(0.0),
        (Vec3::Z - 2.0 * normal.z * normal).extend(0.0),
        (-2.0 * plane.w * normal).extend(1.0),
    );
    let cut = |plane: Vec4, panel: &Panel| plane - Vec4::W * (CUT_SHARE * panel.size_m());
    // What an end of a portal shows lies before the other one.
    let (world_from_view, clip_plane_world) = match through {
        None => (mirrored * world_from_view, cut(plane, panel)),
        Some((matrix, other)) => (*matrix * world_from_view, cut(other.plane_world(), other)),
    };
    // What is no scale is that of the picture.
    let scale = if *scale > 0.0 && *scale <= SCALE_MAX { *scale } else { 1.0 };
    let margin = if *is_smooth { 0.0 } else { ROUGH_MARGIN };
    // Not larger than the adapter has it, with what is drawn beside the picture, and as it is shaded.
    let largest =
        request.width.max(request.height) as f32 * (1.0 + 2.0 * margin) * request.settings.render.scale.max(1.0);
    let scale = scale.min((limit_px as f32 - 1.0) / largest);
    let sides = [request.width, request.height]
        .map(|side| ((side as f32 * scale * (1.0 + 2.0 * margin)).round() as u32).max(1));
    let widened = widened(&projection, (request.width, request.height), (sides[0], sides[1]), scale);
    let mut settings = settings_of(*quality, &request.settings)?;
    settings.render.scale = request.settings.render.scale;
    // Through the same point of the lens, whose radius goes by the field of view.
    let camera = request.settings.camera.clone();
    settings.camera = CameraSettings { f_stop: camera.f_stop / (1.0 + 2.0 * margin), fisheye: Fisheye::None, ..camera };
    settings.allow_taa(false);
    if through.is_none() {
        // What is behind everything is what surfaces get light of.
        settings.background.source = Background::Environment;
        settings.render.path = Path::Deferred;
        settings.msaa.samples = PixelSamples::default();
    }
    let behind = FrameRequest {
        width: sides[0],
        height: sides[1],
        camera: View { world_from_view, projection: widened },
        clip_plane_world: Some(clip_plane_world),
        layers: *layers,
        ..request.within(settings)
    };
    Ok(Some((behind.with_switches_resolved(), normal)))
}

/// The projection of a picture of `size` whose pixels are those of one of `of`, 1 / `scale` times as large.
fn widened(projection: &Projection, of: (u32, u32), size: (u32, u32), scale: f32) -> Projection {
    if size == of {
        return *projection;
    }
    let share = size.1 as f32 / (of.1.max(1) as f32 * scale);
    match *projection {
        Projection::Perspective { fov_y_rad, near_m, far_m } => {
            let fov_y_rad = 2.0 * ((0.5 * fov_y_rad).tan() * share).atan();
            Projection::Perspective { fov_y_rad, near_m, far_m }
        }
        Projection::Orthographic { height_m, near_m, far_m } => {
            Projection::Orthographic { height_m: height_m * share, near_m, far_m }
        }
    }
}
