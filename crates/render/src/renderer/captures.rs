//! Which monitors a frame shows, and what is asked of the views of their cameras.

use super::Renderer;
use super::part::{PlannedView, settings_of, widest_range};
use super::view_kind::{Drawing, MonitorView, ViewKind};
use crate::draws::may_show;
use crate::overlay::monitors_of_overlay;
use crate::request::{Averaging, FrameRequest, RenderError};
use crate::resources::{monitor_fits, monitors_of};
use crate::view::View;
use glam::Vec2;
use manypass_scene::capture::{MONITORS_MAX, Monitor, Update};
use manypass_scene::{Aabb, Image, Scene};
use std::collections::{BTreeMap, BTreeSet};

impl MonitorView {
    /// It is a picture of its own within others.
    fn kind(self, request: &FrameRequest) -> ViewKind {
        ViewKind {
            is_capture: true,
            // Those of a live view are not drawn in all of its frames.
            has_means: !request.goes_on && request.sample_count > 1,
            keeps_border: true,
            ..ViewKind::within(Drawing::Monitor(self))
        }
    }
}

/// When monitors were last drawn.
#[derive(Clone, Debug, Default)]
pub(super) struct CaptureState {
    /// Counts frames.
    frame: u64,
    /// The frame that drew what the monitor of an image of a size shows.
    drawn: BTreeMap<(usize, u32, u32), u64>,
}

impl CaptureState {
    /// What is forgotten where textures are made anew.
    pub fn clear(&mut self) {
        self.drawn.clear();
    }

    /// Of the monitors that a frame shows those that it draws anew: all of a still.
    fn take_turns<'m>(
        &mut self,
        request: &FrameRequest,
        shown: &BTreeSet<usize>,
        monitor_of: impl Fn(usize) -> Option<&'m Monitor>,
    ) -> BTreeSet<usize> {
        let Self { frame, drawn } = self;
        *frame += 1;
        let mut due: Vec<(u64, (usize, u32, u32))> = Vec::new();
        for image in shown {
            let Some(monitor) = monitor_of(*image) else { continue };
            let key = (*image, monitor.width, monitor.height);
            let last = drawn.get(&key).copied();
            let is_due = !request.goes_on
                || last.is_none_or(|last| match monitor.options.update {
                    Update::Always => true,
                    Update::Every(frames) => *frame - last >= u64::from(frames.max(1)),
                    Update::Once => false,
                });
            if is_due {
                due.push((last.unwrap_or(0), key));
            }
        }
        // Those that wait longest come first.
        due.sort_unstable();
        let most = request.settings.captures.per_frame as usize;
        due.truncate(if most == 0 || !request.goes_on { usize::MAX } else { most });
        drawn.extend(due.iter().map(|(_, key)| (*key, *frame)));
        due.into_iter().map(|(_, (image, ..))| image).collect()
    }
}

/// Where the monitors of a scene are to be seen.
struct Screens<'s> {
    /// The images by their names.
    names: BTreeMap<&'s str, usize>,
    /// The images of those that are drawn.
    images: Vec<usize>,
    /// The box around a surface that shows one, its layers, and the image.
    surfaces: Vec<(Aabb, u32, usize)>,
}

impl<'s> Screens<'s> {
    fn of(scene: &'s Scene) -> Option<Self> {
        let images: Vec<usize> = scene.monitors().map(|(image, ..)| image).take(MONITORS_MAX).collect();
        if images.is_empty() {
            return None;
        }
        let of_material: Vec<Vec<usize>> =
            scene.materials.iter().enumerate().map(|material| monitors_of(scene, material)).collect();
        let mut surfaces = Vec::new();
        for (id, _) in scene.visible_levels() {
            let node = scene.node(id);
            let Some(mesh) = node.mesh.and_then(|mesh| scene.meshes.get(mesh)) else { continue };
            let own = mesh.primitives.iter().filter_map(|primitive| primitive.material_in(scene.variant));
            let coarser = |index: usize| {
                let material = scene.materials.get(index).and_then(|material| material.levels.as_ref());
                let levels: Vec<usize> = material.map_or_else(Vec::new, |levels| levels.coarser.clone());
                std::iter::once(index).chain(levels)
            };
            let shown: BTreeSet<usize> =
                own.flat_map(coarser).filter_map(|material| of_material.get(material)).flatten().copied().collect();
            surfaces.extend(shown.into_iter().map(|image| (node.bounds_world, node.layers, image)));
        }
        // Of several that have one name the first counts.
        let mut names = BTreeMap::new();
        for (image, Image { name, .. }, _) in scene.monitors() {
            names.entry(name.as_str()).or_insert(image);
        }
        Some(Self { names, images, surfaces })
    }

    /// The images of the monitors that a view may see.
    fn seen_in(&self, request: &FrameRequest, is_sheared: bool) -> BTreeSet<usize> {
        let sees_all = is_sheared || request.samples_lens_or_shutter();
        let aspect = request.width as f32 / request.height.max(1) as f32;
        let clip_from_view = request.camera.clip_from_view(widest_range(&request.camera), aspect, Vec2::ZERO);
        let clip_from_world = clip_from_view * request.camera.world_from_view.inverse();
        let is_cut = |bounds: &Aabb| {
            request
                .clip_plane_world
                .is_some_and(|plane| bounds.corners().iter().all(|at| plane.dot(at.extend(1.0)) < 0.0))
        };
        let is_seen = |(bounds, layers, _): &&(Aabb, u32, usize)| {
            layers & request.layers != 0 && (sees_all || may_show(&clip_from_world, bounds)) && !is_cut(bounds)
        };
        let on_surfaces = self.surfaces.iter().filter(is_seen).map(|(.., image)| *image);
        let over_picture = monitors_of_overlay(&request.overlay).filter_map(|name| self.names.get(name));
        on_surfaces.chain(over_picture.copied()).filter(|image| self.images.contains(image)).collect()
    }
}

/// What is asked of the view of a monitor's camera where `request` is asked of the picture; nothing if it has none.
fn request_of(scene: &Scene, monitor: &Monitor, request: &FrameRequest) -> Result<Option<FrameRequest>, RenderError> {
    let Some((world_from_view, projection)) = monitor.seen_from(scene) else { return Ok(None) };
    let camera = View { world_from_view, projection };
    if !world_from_view.is_finite() || !camera.half_extent(1.0).is_finite() {
        return Ok(None);
    }
    let of_monitor = FrameRequest {
        width: monitor.width,
        height: monitor.height,
        camera,
        clip_plane_world: None,
        layers: monitor.options.layers,
        // Of a live view screens show samples one by one.
        averaging: match request.goes_on || request.needs_mean_of_radiance() {
            true => Averaging::Radiance,
            false => Averaging::Display,
        },
        ..request.within(settings_of(monitor.options.quality.as_deref(), &request.settings)?)
    };
    Ok(Some(of_monitor.with_switches_resolved()))
}

impl Renderer {
    /// The views of monitors that `parts` show, and how many it leaves out.
    pub(super) fn monitors(
        &self,
        scene: &Scene,
        parts: &[PlannedView],
        state: &mut CaptureState,
    ) -> Result<(Vec<PlannedView>, u32), RenderError> {
        let Some(first) = parts.first().map(|part| &part.request) else { return Ok(Default::default()) };
        let Some(screens) = Screens::of(scene) else { return Ok(Default::default()) };
        let monitor_of = |image: usize| {
            let known = scene.images.get(image)?;
            Some((image, known.name.as_str(), known.monitor()?))
        };
        let mut requests = BTreeMap::new();
        for (image, name, monitor) in screens.images.iter().filter_map(|image| monitor_of(*image)) {
            if monitor_fits(&self.gpu, (monitor.width, monitor.height))
                && let Some(request) = request_of(scene, monitor, first)?
            {
                requests.insert(image, (name, monitor, request));
            }
        }
        let is_there = |image: &usize| requests.contains_key(image);
        let seen_by = |image: &usize| match requests.get(image) {
            Some((.., request)) => screens.seen_in(request, false).into_iter().filter(is_there).collect(),
            None => BTreeSet::new(),
        };
        let seen: BTreeSet<usize> =
            parts.iter().flat_map(|part| screens.seen_in(&part.request, part.kind.is_sheared)).collect();
        let mut levels: Vec<BTreeSet<usize>> = vec![seen.into_iter().filter(is_there).collect()];
        let part = |image: usize, level: u32, darkens: &BTreeSet<usize>| {
            let (name, monitor, request) = requests.get(&image)?;
            let view = MonitorView {
                image,
                level,
                darkens: darkens.iter().copied().collect(),
                exposure_stops: monitor.exposure_stops,
            };
            // Two may have one name.
            let twin = requests.range(..image).filter(|(_, (other, ..))| other == name).count();
            let name = if twin > 0 { format!("{name}.{}", twin + 1) } else { (*name).to_owned() };
            let inner = if level > 0 { format!("/{}", level + 1) } else { String::new() };
            let part = PlannedView::new(format!("monitor/{name}{inner}"), request.clone(), view.kind(request));
            Some(PlannedView { level: Some(level), ..part })
        };
        let is_known = |(image, width, height): &(usize, u32, u32)| {
            requests.get(image).is_some_and(|(_, monitor, _)| (monitor.width, monitor.height) == (*width, *height))
        };
        state.drawn.retain(|key, _| is_known(key));
        let depth = first.settings.captures.depth.max(1) as usize;
        while levels.len() < depth {
            let inner: BTreeSet<usize> = levels.last().into_iter().flatten().flat_map(seen_by).collect();
            if inner.is_empty() {
                break;
            }
            levels.push(inner);
        }
        let shown: BTreeSet<usize> = levels.iter().flatten().copied().collect();
        let due = state.take_turns(first, &shown, |image| requests.get(&image).map(|(_, monitor, _)| *monitor));
        let deepest = levels.len() - 1;
        let left_out = (screens.images.len() - due.len()) as u32;
        let mut monitors = Vec::new();
        for (level, images) in levels.iter().enumerate().rev() {
            for image in images.intersection(&due) {
                // What is shown and not drawn anew stays as it is.
                let is_dark = |seen: &usize| level == deepest && (due.contains(seen) || !shown.contains(seen));
                let darkens = seen_by(image).into_iter().filter(is_dark).collect();
                monitors.extend(part(*image, level as u32, &darkens));
            }
        }
        Ok((monitors, left_out))
    }
}
