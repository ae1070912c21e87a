//! Which boxes of decals a view draws to mark the pixels that they may change, and which surfaces they may touch.

use super::list::{Draw, DrawList};
use super::world::{Item, WorldDraws};
use crate::decals::corners_of_box;
use glam::{Mat4, Vec3, Vec4};
use manypass_scene::Aabb;
use std::ops::Range;

/// So many boxes that nobody sees are drawn rather than a draw call more.
const HIDDEN_BOXES_MAX: u32 = 8;

/// How far beyond its sides a view sees: its variables lack the jitter of a sample.
const ROOM: f32 = 1.02;

/// The boxes that a view draws, by their numbers in the table.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct DecalDraws {
    /// Those before the eye, whose fronts are drawn.
    pub before: Vec<Range<u32>>,
    /// Those that the near plane cuts, or that hold the eye, whose backs are drawn, whatever is before them.
    pub around: Vec<Range<u32>>,
}

impl DecalDraws {
    /// Those of `boxes` that a view with this matrix may see.
    pub fn new(boxes: &[Mat4], clip_from_world: &Mat4) -> Self {
        let mut draws = Self::default();
        for (number, world_from_box) in (0..).zip(boxes) {
            let clip_from_box = *clip_from_world * *world_from_box;
            let corners = corners_of_box().map(|corner| clip_from_box * corner.extend(1.0));
            let is_outside = |beyond: fn(&Vec4) -> bool| corners.iter().all(beyond);
            // Depth is reversed: it ends at 0, and the near plane is 1.
            let is_hidden = is_outside(|at| at.x < -ROOM * at.w)
                || is_outside(|at| at.x > ROOM * at.w)
                || is_outside(|at| at.y < -ROOM * at.w)
                || is_outside(|at| at.y > ROOM * at.w)
                || is_outside(|at| at.z < 0.0)
                || is_outside(|at| at.w < 0.0);
            if is_hidden {
                continue;
            }
            // A little room for rounding on the device.
            let is_cut = corners.iter().any(|at| at.w <= 0.0 || at.z > at.w * 0.999);
            let ranges = if is_cut { &mut draws.around } else { &mut draws.before };
            match ranges.last_mut() {
                Some(last) if number - last.end <= HIDDEN_BOXES_MAX && !is_cut => last.end = number + 1,
                _ => ranges.push(number..number + 1),
            }
        }
        draws
    }

    /// Whether nothing is drawn.
    pub fn is_empty(&self) -> bool {
        self.before.is_empty() && self.around.is_empty()
    }
}

/// Finds what of the draws of a view may be touched by one of `boxes`.
pub(crate) fn find_touched(list: &mut DrawList, world: &WorldDraws, boxes: &[Mat4]) {
    let places = Places::new(boxes);
    let is_touched = |item: &Item| places.touch(&item.bounds_world);
    let items_of = |draw: &Draw| {
        let items = world.items.get(draw.item as usize..).unwrap_or_default();
        // What fades has instances of its own.
        let count = items.iter().take_while(|item| !draw.fades && item.instance < draw.instances.end).count();
        items.get(..count.max(1)).unwrap_or_default()
    };
    for draw in &mut list.opaque {
        let items = items_of(draw);
        if draw.fades {
            draw.is_decaled = items.iter().any(is_touched);
            list.decaled.extend(draw.is_decaled.then(|| draw.clone()));
            continue;
        }
        let mut last: Option<Draw> = None;
        for (item, at) in items.iter().zip(draw.item..).filter(|(item, _)| is_touched(item)) {
            let instances = item.instances();
            match &mut last {
                Some(last) if last.instances.end == instances.start => {
                    last.instances.end = instances.end;
                }
                _ => list.decaled.extend(last.replace(Draw { item: at, instances, is_decaled: true, ..draw.clone() })),
            }
        }
        draw.is_decaled = last.is_some();
        list.decaled.extend(last);
    }
    for draw in list.transmissive.iter_mut().chain(&mut list.blended) {
        draw.is_decaled = items_of(draw).iter().any(is_touched);
    }
}

/// Cells across and down in which boxes are looked for.
const CELLS: usize = 32;

/// Where boxes lie, in cells across the two axes along which they are spread most.
struct Places {
    bounds: Vec<Aabb>,
    whole: Aabb,
    axes: [usize; 2],
    cells: Vec<Vec<u16>>,
}

impl Places {
    fn new(boxes: &[Mat4]) -> Self {
        let unit = Aabb { min: Vec3::splat(-0.5), max: Vec3::splat(0.5) };
        let bounds: Vec<Aabb> = boxes.iter().map(|matrix| unit.transformed(matrix)).collect();
        let whole = bounds.iter().fold(Aabb::EMPTY, |whole, bounds| whole.union(bounds));
        let extent = whole.max - whole.min;
        let thinnest = (0..3).min_by(|a, b| extent[*a].total_cmp(&extent[*b])).unwrap_or(1);
        let mut places = Self {
            bounds,
            whole,
            axes: [(thinnest + 1) % 3, (thinnest + 2) % 3],
            cells: vec![Vec::new(); CELLS * CELLS],
        };
        for number in 0..places.bounds.len() {
            for cell in places.cells_of(&places.bounds[number]) {
                places.cells[cell].push(number as u16);
            }
        }
        places
    }

    fn cells_of(&self, bounds: &Aabb) -> impl Iterator<Item = usize> + use<> {
        let [across, down] = self.axes.map(|axis| {
            let extent = (self.whole.max[axis] - self.whole.min[axis]).max(1e-6);
            // Conversion to integers cuts off what is negative.
            let cell = |at: f32| (((at - self.whole.min[axis]) / extent * CELLS as f32) as usize).min(CELLS - 1);
            cell(bounds.min[axis])..cell(bounds.max[axis]) + 1
        });
        down.flat_map(move |row| across.clone().map(move |column| row * CELLS + column))
    }

    /// Whether any of the boxes may overlap another.
    fn touch(&self, bounds: &Aabb) -> bool {
        let overlaps = |number: &u16| self.bounds.get(usize::from(*number)).is_some_and(|known| overlap(known, bounds));
        overlap(&self.whole, bounds) && self.cells_of(bounds).any(|cell| self.cells[cell].iter().any(overlaps))
    }
}

fn overlap(a: &Aabb, b: &Aabb) -> bool {
    a.min.cmple(b.max).all() && b.min.cmple(a.max).all()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_out_of_view_are_not_drawn_and_those_around_the_eye_are_drawn_otherwise() {
        let near_m = 0.1;
        let columns = [Vec4::X, Vec4::Y, Vec4::new(0.0, 0.0, 0.0, -1.0), Vec4::new(0.0, 0.0, near_m, 0.0)];
        let clip_from_world = Mat4::from_cols(columns[0], columns[1], columns[2], columns[3]);
        let at = |x: f32, z: f32| Mat4::from_translation(Vec3::new(x, 0.0, z));
        let boxes = [at(0.0, -5.0), at(40.0, -5.0), at(0.0, 5.0), at(0.5, -6.0), at(0.0, 0.0), at(0.0, -0.3)];
        let draws = DecalDraws::new(&boxes, &clip_from_world);
        // Of what lies between two that are seen nobody sees anything.
        assert!(draws.before.iter().eq([&(0..4)]) && draws.around.iter().eq([&(4..5), &(5..6)]), "{draws:?}");
        assert!(DecalDraws::new(&boxes[1..3], &clip_from_world).is_empty());
    }
}
