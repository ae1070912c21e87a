//! Layers of surfaces that light comes through: those of one layer do not lie behind each other in the picture, and
//! each layer is drawn before a picture of all that lies behind it, so that one is seen through another.
//!
//! Source: Newell, Newell & Sancha 1972, "A Solution to the Hidden Surface Problem": which of two objects is nearer is
//! told by a plane between them. Where it differs: the planes are those of the boxes around objects, and nothing is
//! cut: of boxes that reach into each other one that is inside the other lies behind, else the one whose middle is
//! farther away. What lies behind itself in one mesh is no layer of its own.

use super::list::Draw;
use super::world::{Item, WorldDraws};
use crate::view::ViewUniform;
use glam::{Mat4, Vec2, Vec3};

/// So many of the nearest objects are compared with each other; what is farther away is in the farthest layer.
const COMPARED_MAX: usize = 256;

/// Boxes that reach into each other by less than this share of their depth, as tessellated bodies do that touch, lie
/// beside each other.
const REACH_SHARE: f32 = 1e-3;

/// From where objects are seen: a place, or with parallel rays the direction towards the eye.
#[derive(Clone, Copy, Debug)]
enum Eye {
    At(Vec3),
    Towards(Vec3),
}

impl Eye {
    fn of(view: &ViewUniform) -> Self {
        let world_from_view = &view.world_from_view;
        if view.orthographic > 0.5 {
            Self::Towards(world_from_view.z_axis.truncate())
        } else {
            Self::At(world_from_view.w_axis.truncate())
        }
    }

    /// Whether it is on the side of a plane that `axis` points to; unknown if the rays run along it.
    fn is_above(self, axis: Vec3, plane_m: f32) -> Option<bool> {
        match self {
            Self::At(place) => Some(axis.dot(place) > plane_m),
            Self::Towards(direction) => {
                let slope = axis.dot(direction);
                (slope.abs() > 1e-5).then_some(slope > 0.0)
            }
        }
    }
}

/// The box around an object, which need not be upright.
#[derive(Clone, Copy, Debug)]
struct Body {
    /// Which item; the two forms of one that fade into each other are never in each other's way.
    item: u32,
    center: Vec3,
    /// Half its edges.
    halves: [Vec3; 3],
    /// The corners of the rectangle around it in the picture, in NDC.
    seen: [Vec2; 2],
    /// How far its middle is along the view axis.
    distance_m: f32,
}

impl Body {
    fn new(item: u32, (center, halves): (Vec3, [Vec3; 3]), clip_from_world: &Mat4, distance_m: f32) -> Self {
        let mut seen = [Vec2::INFINITY, Vec2::NEG_INFINITY];
        for corner in 0..8_u32 {
            let side = |axis: usize| if corner >> axis & 1 == 0 { -halves[axis] } else { halves[axis] };
            let clip = *clip_from_world * (center + side(0) + side(1) + side(2)).extend(1.0);
            if clip.w <= 0.0 {
                // What reaches behind the eye may be anywhere.
                seen = [Vec2::NEG_ONE, Vec2::ONE];
                break;
            }
            let ndc = clip.truncate().truncate() / clip.w;
            seen = [seen[0].min(ndc), seen[1].max(ndc)];
        }
        // Nobody looks at what overlaps beside the picture.
        let seen = seen.map(|corner| corner.max(Vec2::NEG_ONE).min(Vec2::ONE));
        Self { item, center, halves, seen, distance_m }
    }

    fn of(index: u32, item: &Item, view: &ViewUniform) -> Self {
        let shape = match &item.extent {
            Some(extent) => (item.center, extent.0),
            None => {
                let half = 0.5 * (item.bounds_world.max - item.bounds_world.min);
                (item.bounds_world.center(), [Vec3::X * half.x, Vec3::Y * half.y, Vec3::Z * half.z])
            }
        };
        let distance_m = -view.view_from_world.transform_point3(item.center).z;
        Self::new(index, shape, &view.clip_from_world, distance_m)
    }

    /// Whether the rectangles around two of them have a part of the picture in common.
    fn overlaps(&self, other: &Self) -> bool {
        let from = self.seen[0].max(other.seen[0]);
        let to = self.seen[1].min(other.seen[1]);
        self.item != other.item && from.x < to.x && from.y < to.y
    }

    /// The normals of its sides; a flat one has one side.
    fn axes(&self) -> impl Iterator<Item = Vec3> {
        let [x, y, z] = self.halves;
        let normals = [y.cross(z), z.cross(x), x.cross(y)].map(Vec3::normalize_or_zero);
        normals.into_iter().filter(|normal| *normal != Vec3::ZERO)
    }

    /// From where to where it is along an axis.
    fn range(&self, axis: Vec3) -> (f32, f32) {
        let middle = axis.dot(self.center);
        let reach: f32 = self.halves.iter().map(|half| axis.dot(*half).abs()).sum();
        (middle - reach, middle + reach)
    }

    fn is_inside(&self, other: &Self) -> bool {
        let mut sides = 0;
        for axis in other.axes() {
            let ((from, to), (other_from, other_to)) = (self.range(axis), other.range(axis));
            let slack_m = REACH_SHARE * (other_to - other_from);
            if from < other_from - slack_m || to > other_to + slack_m {
                return false;
            }
            sides += 1;
        }
        sides == 3
    }

    /// Whether it lies behind another, if one of the two does.
    fn is_behind(&self, other: &Self, eye: Eye) -> bool {
        for axis in self.axes().chain(other.axes()) {
            let ((from, to), (other_from, other_to)) = (self.range(axis), other.range(axis));
            let slack_m = REACH_SHARE * (to - from).min(other_to - other_from);
            let (plane_m, is_below) = if to <= other_from + slack_m {
                (0.5 * (to + other_from), true)
            } else if other_to <= from + slack_m {
                (0.5 * (other_to + from), false)
            } else {
                continue;
            };
            if let Some(eye_is_above) = eye.is_above(axis, plane_m) {
                return eye_is_above == is_below;
            }
        }
        let is_inside = self.is_inside(other);
        if is_inside == other.is_inside(self) { self.distance_m > other.distance_m } else { is_inside }
    }
}

/// A number for each of `bodies`, of which farther ones come first: less than those of all that it lies behind.
fn ranks(bodies: &[Body], eye: Eye) -> Vec<usize> {
    let first = bodies.len().saturating_sub(COMPARED_MAX);
    let mut pairs = Vec::new();
    for (at, body) in bodies.iter().enumerate().skip(first) {
        for (other_at, other) in bodies.iter().enumerate().skip(at + 1).filter(|(_, other)| body.overlaps(other)) {
            // What lies behind, and what is before it.
            pairs.push(if other.is_behind(body, eye) { (other_at, at) } else { (at, other_at) });
        }
    }
    let mut ranks = vec![0; bodies.len()];
    // Each round is right for one more of those that lie behind each other; those that do so in a circle end it.
    for _ in 0..bodies.len().min(COMPARED_MAX) {
        let mut is_done = true;
        for (behind, before) in &pairs {
            if ranks[*before] <= ranks[*behind] && ranks[*behind] < bodies.len() {
                ranks[*before] = ranks[*behind] + 1;
                is_done = false;
            }
        }
        if is_done {
            break;
        }
    }
    ranks
}

/// The places of `bodies` in at most `most` layers, the farthest layer first. Where there would be more, the farthest
/// of them are one.
fn layers_of(bodies: &[Body], eye: Eye, most: u32) -> Vec<Vec<usize>> {
    let ranks = ranks(bodies, eye);
    let mut known = ranks.clone();
    known.sort_unstable();
    known.dedup();
    let merged = known.len().saturating_sub(most.max(1) as usize);
    let mut layers = vec![Vec::new(); known.len() - merged];
    for (at, rank) in ranks.into_iter().enumerate() {
        layers[known.partition_point(|known| *known < rank).saturating_sub(merged)].push(at);
    }
    layers
}

/// The layers of `draws` of which farther ones come first, in which a view draws them one after the other: at most
/// `most`, and no more than surfaces of different objects lie behind each other in the picture.
pub(crate) fn layers_of_glass(draws: &[Draw], world: &WorldDraws, view: &ViewUniform, most: u32) -> Vec<Vec<Draw>> {
    if most < 2 || draws.len() < 2 {
        return vec![draws.to_vec()];
    }
    let body = |draw: &Draw| Body::of(draw.item, &world.items[draw.item as usize], view);
    let bodies: Vec<Body> = draws.iter().map(body).collect();
    let layers = layers_of(&bodies, Eye::of(view), most);
    layers.into_iter().map(|layer| layer.into_iter().map(|at| draws[at].clone()).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec4;

    /// Upright boxes by their middles and half their sizes, seen from the origin along -Z; farther ones first.
    fn seen(boxes: &[([f32; 3], [f32; 3])]) -> Vec<Body> {
        // As wide as it is far away.
        let clip_from_world = Mat4::from_cols(Vec4::X, Vec4::Y, Vec4::NEG_W, 0.1 * Vec4::Z);
        let mut bodies: Vec<Body> = boxes
            .iter()
            .enumerate()
            .map(|(item, (center, half))| {
                let halves = [Vec3::X * half[0], Vec3::Y * half[1], Vec3::Z * half[2]];
                Body::new(item as u32, (Vec3::from(*center), halves), &clip_from_world, -center[2])
            })
            .collect();
        bodies.sort_by(|a, b| b.distance_m.total_cmp(&a.distance_m));
        bodies
    }

    /// The layers as items, those of a layer in the order of the list.
    fn layers(boxes: &[([f32; 3], [f32; 3])], most: u32) -> Vec<Vec<u32>> {
        let bodies = seen(boxes);
        let sorted = |layer: Vec<usize>| {
            let mut items: Vec<u32> = layer.into_iter().map(|at| bodies[at].item).collect();
            items.sort_unstable();
            items
        };
        layers_of(&bodies, Eye::At(Vec3::ZERO), most).into_iter().map(sorted).collect()
    }

    const BALL: [f32; 3] = [0.5; 3];

    #[test]
    fn what_lies_behind_each_other_is_in_layers_in_any_order() {
        let [near, middle, far] = [3.0, 5.0, 7.0_f32].map(|distance_m| ([0.0, 0.0, -distance_m], BALL));
        assert_eq!(layers(&[near, middle, far], 8), [[2], [1], [0]]);
        assert_eq!(layers(&[far, near, middle], 8), [[0], [2], [1]]);
        // Of three layers in two the farthest are one; in one all are.
        assert_eq!(layers(&[near, middle, far], 2), [vec![1, 2], vec![0]]);
        assert_eq!(layers(&[near, middle, far], 1), [[0, 1, 2]]);
    }

    #[test]
    fn what_lies_beside_each_other_is_one_layer() {
        let [left, right] = [-2.0, 2.0_f32].map(|x| ([x, 0.0, -5.0], BALL));
        assert_eq!(layers(&[left, right], 8), [[0, 1]]);
        // Beside the picture nobody sees that they overlap: it is 5 m wide to each side there.
        let [out, beyond] = [5.0, 7.0_f32].map(|distance_m| ([1.5 * distance_m, 0.0, -distance_m], BALL));
        assert_eq!(layers(&[out, beyond], 8), [[0, 1]]);
        // A third before one of them alone.
        assert_eq!(layers(&[left, right, ([-1.2, 0.0, -3.0], BALL)], 8), [vec![0, 1], vec![2]]);
    }

    #[test]
    fn planes_between_boxes_tell_which_is_nearer() {
        // The middle of a wide pane below a ball is nearer than the ball, and yet it is seen through the ball.
        let pane = ([0.0, -1.0, -4.0], [3.0, 0.0, 3.5]);
        let ball = ([0.0, -0.4, -5.0], BALL);
        assert_eq!(layers(&[pane, ball], 8), [[0], [1]]);
        // Seen from below it is the other way round.
        let [above, ball] = [([0.0, 1.0, -4.0], [3.0, 0.0, 3.5]), ([0.0, 1.6, -5.0], BALL)];
        assert_eq!(layers(&[above, ball], 8), [[1], [0]]);
    }

    #[test]
    fn what_is_inside_lies_behind() {
        // Its middle is nearer than that of what holds it.
        let (bottle, water) = (([0.0, 0.0, -5.0], [1.0; 3]), ([0.0, 0.0, -4.6], BALL));
        assert_eq!(layers(&[bottle, water], 8), [[1], [0]]);
        assert_eq!(layers(&[water, bottle], 8), [[0], [1]]);
    }

    #[test]
    fn parallel_rays_tell_sides_by_their_direction() {
        let clip_from_world = Mat4::from_scale(Vec3::splat(0.25));
        let halves = [Vec3::X, Vec3::Y, Vec3::Z * 0.5];
        let body =
            |item, distance_m: f32| Body::new(item, (Vec3::Z * -distance_m, halves), &clip_from_world, distance_m);
        let (far, near) = (body(0, 6.0), body(1, 3.0));
        let eye = Eye::Towards(Vec3::Z);
        assert!(far.is_behind(&near, eye) && !near.is_behind(&far, eye));
        assert_eq!(layers_of(&[far, near], eye, 8), [[0], [1]]);
    }

    #[test]
    fn many_objects_end() {
        let row: Vec<_> = (0..600).map(|i| ([0.0, 0.0, -3.0 - i as f32], BALL)).collect();
        let found = layers(&row, 4);
        assert_eq!(found.len(), 4);
        assert!(found[3] == [0] && found[2] == [1] && found[1] == [2], "{found:?}");
        // One whose place is no number is in some layer.
        let lost = |item| Body::new(item, (Vec3::NAN, [Vec3::NAN; 3]), &Mat4::IDENTITY, f32::NAN);
        assert_eq!(layers_of(&[lost(0), lost(1)], Eye::At(Vec3::ZERO), 4), [[0, 1]]);
    }
}
