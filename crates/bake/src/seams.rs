//! Where a smooth surface was cut, both sides of the cut show the same light.
//!
//! Texels of the two sides lie on different grids, so that what is between them differs along the cut, and the eye sees
//! such a line. Along every cut the texels of both sides are moved towards each other by as little as it takes, over and
//! over (after Iwanicki 2013, "Lighting Technology of The Last of Us"; the projections are Kaczmarz's, 1937).

use crate::layout::{Layout, UnwrappedPrimitive};
use crate::surfaces::{Surfaces, WorldPrimitive};
use glam::{Vec2, Vec3};
use std::collections::HashMap;

/// How often all cuts are gone along.
const ROUNDS: usize = 12;

/// How much of a difference is taken away at a time.
const RELAXATION: f32 = 0.7;

/// Places at which the two sides are compared, for each texel along a cut.
const PLACES_PER_TEXEL: f32 = 2.0;

/// Normals with a smaller cosine between them belong to a hard edge, where light may differ.
const COSINE_MIN: f32 = 0.9;

/// A cut: where its two ends lie on one side and on the other, in texels of all pages.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seam {
    sides: [[Vec2; 2]; 2],
    /// The first texel of the page that has both.
    first: usize,
}

/// An end of an edge, by the bits of its position.
type End = [u32; 3];

fn end(position: Vec3) -> End {
    // Both zeros are one place.
    position.to_array().map(|part| (part + 0.0).to_bits())
}

/// An edge of a triangle on one side of a cut.
#[derive(Clone, Copy)]
struct Edge {
    uv: [Vec2; 2],
    normals: [Vec3; 2],
    chart: u32,
}

/// All cuts through smooth surfaces.
pub(crate) fn seams(surfaces: &Surfaces, layout: &Layout) -> Vec<Seam> {
    let of_placed = surfaces.placed.iter().zip(&layout.of_placed);
    let unwrapped = of_placed.filter_map(|(placed, of)| Some((placed, &layout.unwrapped[(*of)? as usize])));
    unwrapped.flat_map(|(placed, unwrapped)| of_surface(placed, unwrapped, layout)).collect()
}

fn of_surface(placed: &WorldPrimitive, unwrapped: &UnwrappedPrimitive, layout: &Layout) -> Vec<Seam> {
    let size = Vec2::new(layout.width as f32, layout.height as f32);
    let first = unwrapped.page as usize * layout.width as usize * layout.height as usize;
    let mut open: HashMap<[End; 2], Edge> = HashMap::new();
    let mut seams = Vec::new();
    let triangles = placed.indices.chunks_exact(3).zip(unwrapped.indices.chunks_exact(3)).zip(&unwrapped.charts);
    for ((corners, of_map), chart) in triangles {
        for (from, to) in [(0, 1), (1, 2), (2, 0)] {
            let vertex = |at: usize| corners[at] as usize;
            let ends = [from, to].map(|at| end(placed.positions[vertex(at)]));
            let normals = [from, to].map(|at| placed.normals.get(vertex(at)).copied().unwrap_or(Vec3::ZERO));
            let uv = [from, to].map(|at| unwrapped.vertices[of_map[at] as usize].1 * size);
            let edge = Edge { uv, normals, chart: *chart };
            // The neighbour goes along it the other way.
            let Some(other) = open.remove(&[ends[1], ends[0]]) else {
                open.insert(ends, edge);
                continue;
            };
            let other_uv = [other.uv[1], other.uv[0]];
            let is_smooth = edge.normals[0].dot(other.normals[1]) > COSINE_MIN
                && edge.normals[1].dot(other.normals[0]) > COSINE_MIN;
            let is_cut = edge.chart != other.chart || other_uv != uv;
            if is_smooth && is_cut {
                seams.push(Seam { sides: [uv, other_uv], first });
            }
        }
    }
    seams
}

/// The four texels around a place, and the share of each.
fn around(place: Vec2, (width, height): (usize, usize)) -> [(usize, f32); 4] {
    let place = place - 0.5;
    let (low, part) = (place.floor(), place - place.floor());
    let texel = |dx: f32, dy: f32| {
        let x = ((low.x + dx).max(0.0) as usize).min(width - 1);
        let y = ((low.y + dy).max(0.0) as usize).min(height - 1);
        let share = (if dx == 0.0 { 1.0 - part.x } else { part.x }) * (if dy == 0.0 { 1.0 - part.y } else { part.y });
        (y * width + x, share)
    };
    [texel(0.0, 0.0), texel(1.0, 0.0), texel(0.0, 1.0), texel(1.0, 1.0)]
}

/// Brings the light on both sides of cuts together. Pages are `size` texels wide and high. No number becomes less than
/// `least`.
pub(crate) fn stitch<const N: usize>(light: &mut [[f32; N]], seams: &[Seam], size: (usize, usize), least: f32) {
    for _ in 0..ROUNDS {
        for seam in seams {
            let [one, other] = seam.sides;
            let length = (one[1] - one[0]).length().max((other[1] - other[0]).length());
            let count = (length * PLACES_PER_TEXEL).ceil().clamp(1.0, 65_536.0) as usize;
            for step in 0..=count {
                let share = step as f32 / count as f32;
                let texels = [one, other].map(|side| around(side[0].lerp(side[1], share), size));
                join(light, texels, seam.first, least);
            }
        }
    }
}

/// Moves the texels around two places so that what is at both is more alike.
fn join<const N: usize>(light: &mut [[f32; N]], texels: [[(usize, f32); 4]; 2], first: usize, least: f32) {
    let squares: f32 = texels.iter().flatten().map(|(_, share)| share * share).sum();
    let mut apart = [0.0; N];
    for (side, sign) in texels.iter().zip([1.0, -1.0]) {
        for (texel, share) in side {
            let light = light.get(first + texel).copied().unwrap_or([0.0; N]);
            apart.iter_mut().zip(light).for_each(|(apart, light)| *apart += sign * share * light);
        }
    }
    for (side, sign) in texels.iter().zip([-1.0, 1.0]) {
        for (texel, share) in side {
            let Some(light) = light.get_mut(first + texel) else { continue };
            let scale = sign * share * RELAXATION / squares.max(1e-6);
            light.iter_mut().zip(apart).for_each(|(light, apart)| *light = (*light + scale * apart).max(least));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_sides_of_a_cut_come_together_and_what_is_far_from_it_stays() {
        // Two charts side by side in one page, which meet along their inner edges.
        let size = (16, 8);
        let mut light: Vec<[f32; 1]> = (0..128).map(|index| [if index % 16 < 8 { 1.0 } else { 2.0 }]).collect();
        let side = |x: f32| [Vec2::new(x, 1.0), Vec2::new(x, 7.0)];
        let seam = Seam { sides: [side(5.3), side(11.2)], first: 0 };
        stitch(&mut light, &[seam], size, 0.0);
        for y in [1.5, 4.0, 6.5] {
            let at =
                |x: f32| around(Vec2::new(x, y), size).iter().map(|(at, share)| light[*at][0] * share).sum::<f32>();
            assert!((at(5.3) - at(11.2)).abs() < 0.02, "{} and {}", at(5.3), at(11.2));
        }
        assert_eq!((light[4 * 16 + 1], light[4 * 16 + 14]), ([1.0], [2.0]));
    }
}
