//! Items as rectangles of a picture, as the pass draws them.

use super::OverlayError;
use super::atlas::WHITE_TEXEL;
use super::line::{LinePart, parts};
use super::project::Projector;
use super::shape::{Piece, Shape};
use crate::colour::srgb_from_linear;
use glam::{DVec2, Vec2, Vec3};
use manypass_scene::capture::Monitor;
use manypass_scene::overlay::{Anchor, LinePoints, Overlay, OverlayItem, OverlayLine, OverlayShape, PlaceOf};
use manypass_scene::{Image, Scene};
use std::collections::HashMap;

/// Texels of a rectangle; `overlay.wgsl` says what they hold.
pub(super) const QUAD_TEXELS: usize = 6;

/// Rectangles of a picture, in the order in which they are drawn.
#[derive(Debug, Default)]
pub(super) struct Quads {
    pub texels: Vec<[f32; 4]>,
    /// Whether one of them may be hidden.
    pub tests_depth: bool,
    /// Those that show monitors: the first rectangle, and the index of the image. Ascending.
    pub monitors: Vec<(usize, usize)>,
}

/// Where an item is: the point that its offset is told from, and how near that is if depth is compared.
struct Base {
    place_px: Vec2,
    nearness: f32,
}

/// The world positions of the nodes that the overlay names, by these names.
pub(super) fn node_names<'s>(scene: &'s Scene, overlay: &Overlay) -> HashMap<&'s str, Vec3> {
    let mut names = HashMap::new();
    if overlay.items.iter().any(|item| matches!(item.place.of, PlaceOf::Node(_))) {
        for node in &scene.nodes {
            names.entry(node.name.as_str()).or_insert_with(|| node.world_from_object.w_axis.truncate());
        }
    }
    names
}

/// The place of a coordinate that counts from the right or the lower edge if it is below 0.
fn from_edges(place_px: Vec2, size_px: Vec2) -> Vec2 {
    place_px + Vec2::select(place_px.cmplt(Vec2::ZERO), size_px, Vec2::ZERO)
}

fn tint(color_linear: Vec3, opacity: f32) -> [f32; 4] {
    let [r, g, b] = color_linear.to_array().map(|linear| srgb_from_linear(linear.clamp(0.0, 1.0)));
    [r, g, b, opacity]
}

impl Quads {
    pub fn count(&self) -> usize {
        self.texels.len() / QUAD_TEXELS
    }

    /// Adds the rectangles of an item; none where it is at a place that the camera does not see.
    pub fn add(
        &mut self,
        projector: &Projector,
        (scene, names): (&Scene, &HashMap<&str, Vec3>),
        (index, item): (usize, &OverlayItem),
        shape: &Shape,
    ) -> Result<(), OverlayError> {
        if item.opacity <= 0.0 {
            return Ok(());
        }
        let place = &item.place;
        let position_world = match &place.of {
            PlaceOf::Picture => None,
            PlaceOf::World(position_world) => Some(*position_world),
            PlaceOf::Node(name) => {
                let missing = || OverlayError::NoNode { item: index, name: name.clone() };
                Some(*names.get(name.as_str()).ok_or_else(missing)?)
            }
        };
        let base = match position_world {
            None => None,
            Some(position_world) => {
                let Some(seen) = projector.picture(projector.view(position_world)) else { return Ok(()) };
                let nearness = projector.nearness(seen.distance_m - item.depth_offset_m);
                Some(Base { place_px: seen.place_px, nearness })
            }
        };
        match (shape, &item.shape) {
            (Shape::Pieces { size_px, pieces, is_whole }, _) => {
                let corner_px = corner(projector.size_px, item, base.as_ref(), *size_px);
                let corner_px = if *is_whole { (corner_px + 0.001).round() } else { corner_px };
                let nearness = base.map(|base| base.nearness).filter(|_| item.depth_test);
                for piece in pieces {
                    self.add_piece(projector.size_px, item, piece, corner_px, nearness);
                }
            }
            (Shape::Line, OverlayShape::Line(line)) => match &line.points {
                LinePoints::Pixels(points) => self.add_line_px(projector, item, line, points, base.as_ref()),
                LinePoints::World(points) => self.add_line_world(projector, item, line, points),
            },
            (Shape::Monitor, OverlayShape::Monitor(monitor)) => {
                let is_named = |(_, image, _): &(usize, &Image, &Monitor)| image.name == monitor.name;
                let missing = || OverlayError::NoMonitor { item: index, name: monitor.name.clone() };
                let (image, _, known) = scene.monitors().find(is_named).ok_or_else(missing)?;
                let texels = (known.width, known.height);
                let size_px = monitor.drawn_size_px(texels);
                let piece = Piece::of_monitor(size_px, texels, monitor.rotation_deg);
                let corner_px = corner(projector.size_px, item, base.as_ref(), size_px);
                let corner_px = if piece.rotation_rad == 0.0 { (corner_px + 0.001).round() } else { corner_px };
                let nearness = base.map(|base| base.nearness).filter(|_| item.depth_test);
                let first = self.count();
                self.add_piece(projector.size_px, item, &piece, corner_px, nearness);
                if self.count() > first {
                    self.monitors.push((first, image));
                }
            }
            (Shape::Line | Shape::Monitor, _) => {}
        }
        Ok(())
    }

    fn add_piece(&mut self, size_px: Vec2, item: &OverlayItem, piece: &Piece, corner: Vec2, nearness: Option<f32>) {
        let middle = corner + piece.corner_px + 0.5 * piece.size_px;
        let direction = Vec2::from_angle(piece.rotation_rad);
        let half = 0.5 * piece.size_px;
        let origin = middle - direction * half.x - direction.perp() * half.y;
        let reach = if piece.rotation_rad == 0.0 { half } else { Vec2::splat(half.length()) } + 1.0;
        let is_seen = (middle + reach).cmpgt(Vec2::ZERO).all() && (middle - reach).cmplt(size_px).all();
        if !is_seen || piece.size_px.min_element() <= 0.0 {
            return;
        }
        let (color, opacity) = match &item.shape {
            OverlayShape::Text(text) if piece.is_background => text.background.unwrap_or((Vec3::ZERO, 0.0)),
            _ => (item.color_linear, 1.0),
        };
        let near = nearness.unwrap_or(0.0);
        self.tests_depth |= nearness.is_some();
        self.texels.extend([
            [origin.x, origin.y, direction.x, direction.y],
            [piece.size_px.x, piece.size_px.y, near, near],
            piece.texels,
            tint(color, item.opacity * opacity),
            [0.0, 0.0, 0.0, f32::from(nearness.is_some())],
            [0.0, 0.0, -1.0, 0.0],
        ]);
    }

    /// A line in the picture, or told from a place in it.
    fn add_line_px(
        &mut self,
        projector: &Projector,
        item: &OverlayItem,
        line: &OverlayLine,
        points: &[Vec2],
        base: Option<&Base>,
    ) {
        let offset_px = item.place.offset_px;
        let place = |point: &Vec2| match (base, item.place.anchor) {
            (Some(base), _) => base.place_px + offset_px + *point,
            (None, Some(anchor)) => anchor.share() * projector.size_px + offset_px + *point,
            (None, None) => from_edges(*point, projector.size_px) + offset_px,
        };
        let points: Vec<DVec2> = points.iter().map(|point| place(point).as_dvec2()).collect();
        let near = base.map(|base| f64::from(base.nearness)).filter(|_| item.depth_test);
        let nearness = near.map(|near| vec![near; points.len()]);
        self.add_parts(projector, item, line, &points, nearness.as_deref());
    }

    /// A line in the world, of which what lies before the near plane is left out.
    fn add_line_world(&mut self, projector: &Projector, item: &OverlayItem, line: &OverlayLine, points: &[Vec3]) {
        let near_m = projector.near_m() * 1.000_1;
        let of_view: Vec<Vec3> = points.iter().map(|point| projector.view(*point)).collect();
        let (mut run, mut nearness) = (Vec::new(), Vec::new());
        let put = |point: Vec3, run: &mut Vec<DVec2>, nearness: &mut Vec<f64>| {
            let Some(seen) = projector.picture(point) else { return false };
            run.push(seen.place_px.as_dvec2());
            nearness.push(f64::from(projector.nearness(seen.distance_m - item.depth_offset_m)));
            true
        };
        for pair in of_view.windows(2) {
            let (mut a, mut b) = (pair[0], pair[1]);
            let is_before = |point: Vec3| !projector.is_fisheye() && -point.z < near_m;
            let crossing = || a + (b - a) * ((near_m + a.z) / (a.z - b.z));
            match (is_before(a), is_before(b)) {
                (true, true) => continue,
                (true, false) => a = crossing(),
                (false, true) => b = crossing(),
                (false, false) => {}
            }
            let goes_on = !run.is_empty() && !is_before(pair[0]);
            if !goes_on {
                self.add_parts(projector, item, line, &run, item.depth_test.then_some(&nearness[..]));
                run.clear();
                nearness.clear();
                put(a, &mut run, &mut nearness);
            }
            if !put(b, &mut run, &mut nearness) || is_before(pair[1]) {
                self.add_parts(projector, item, line, &run, item.depth_test.then_some(&nearness[..]));
                run.clear();
                nearness.clear();
            }
        }
        self.add_parts(projector, item, line, &run, item.depth_test.then_some(&nearness[..]));
    }

    /// The parts of a line through `points`, which are as near as `nearness` says if depth is compared.
    fn add_parts(
        &mut self,
        projector: &Projector,
        item: &OverlayItem,
        line: &OverlayLine,
        points: &[DVec2],
        nearness: Option<&[f64]>,
    ) {
        let color = tint(item.color_linear, item.opacity);
        let of_picture = projector.size_px.as_dvec2();
        for (first, last, part) in parts(points, f64::from(line.width_px), of_picture) {
            let LinePart { origin_px, direction, length_px, along, planes } = part;
            let near = nearness.map(|nearness| along.map(|t| nearness[first] + (nearness[last] - nearness[first]) * t));
            self.tests_depth |= near.is_some();
            let [near0, near1] = near.unwrap_or_default();
            let [begin, end] = planes.map(|plane| plane.as_vec3());
            self.texels.extend([
                [origin_px.x as f32, origin_px.y as f32, direction.x as f32, direction.y as f32],
                [length_px as f32, line.width_px, near0 as f32, near1 as f32],
                WHITE_TEXEL,
                color,
                [begin.x, begin.y, begin.z, f32::from(nearness.is_some())],
                [end.x, end.y, end.z, 0.0],
            ]);
        }
    }
}

/// The upper left corner of an item of a size.
fn corner(size_px: Vec2, item: &OverlayItem, base: Option<&Base>, item_px: Vec2) -> Vec2 {
    let place = &item.place;
    match (base, place.anchor) {
        (Some(base), anchor) => base.place_px + place.offset_px - anchor.unwrap_or(Anchor::Center).share() * item_px,
        (None, Some(anchor)) => anchor.share() * (size_px - item_px) + place.offset_px,
        (None, None) => {
            let is_far = place.offset_px.cmplt(Vec2::ZERO);
            place.offset_px + Vec2::select(is_far, size_px - item_px, Vec2::ZERO)
        }
    }
}
