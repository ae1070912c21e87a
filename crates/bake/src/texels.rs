//! Which place of the scene a texel of a light map is of.

use crate::fill::Light;
use crate::layout::Layout;
use crate::surfaces::{Spot, Surfaces};
use glam::{Vec2, Vec3};

/// What has no surface.
const NOBODY: u32 = u32::MAX;

/// The bit of what has one that lies inside something, where no light comes to.
const INSIDE: u32 = 1 << 31;

/// The texels of all pages, one page after the other, rows from the top.
#[derive(Debug)]
pub(crate) struct Texels<'s> {
    surfaces: &'s Surfaces,
    layout: &'s Layout,
    /// The triangle of each, or [`NOBODY`].
    owners: Vec<u32>,
}

/// A triangle in texels of its page.
#[derive(Clone, Copy, Debug)]
struct TexelTriangle {
    corners: [Vec2; 3],
}

fn perp(a: Vec2, b: Vec2) -> f32 {
    a.perp_dot(b)
}

/// The point of a segment that is nearest to another one, as a share of it.
fn nearest_on(from: Vec2, to: Vec2, point: Vec2) -> f32 {
    let along = to - from;
    ((point - from).dot(along) / along.length_squared().max(1e-20)).clamp(0.0, 1.0)
}

impl TexelTriangle {
    /// The shares of the second and third corner at a point, which may lie outside.
    fn shares(&self, point: Vec2) -> Option<Vec2> {
        let [a, b, c] = self.corners;
        let area = perp(b - a, c - a);
        (area.abs() > 1e-12).then(|| Vec2::new(perp(point - a, c - a), perp(b - a, point - a)) / area)
    }

    fn contains(&self, point: Vec2) -> bool {
        self.shares(point).is_some_and(|shares| shares.x >= 0.0 && shares.y >= 0.0 && shares.x + shares.y <= 1.0)
    }

    /// The shares at the point of the triangle that is nearest to another one.
    fn nearest_shares(&self, point: Vec2) -> Vec2 {
        if let Some(shares) = self.shares(point)
            && shares.x >= 0.0
            && shares.y >= 0.0
            && shares.x + shares.y <= 1.0
        {
            return shares;
        }
        let [a, b, c] = self.corners;
        let (on_ab, on_ac, on_bc) = (nearest_on(a, b, point), nearest_on(a, c, point), nearest_on(b, c, point));
        let candidates = [
            (a.lerp(b, on_ab), Vec2::new(on_ab, 0.0)),
            (a.lerp(c, on_ac), Vec2::new(0.0, on_ac)),
            (b.lerp(c, on_bc), Vec2::new(1.0 - on_bc, on_bc)),
        ];
        let nearest = candidates
            .into_iter()
            .min_by(|(one, _), (other, _)| one.distance_squared(point).total_cmp(&other.distance_squared(point)));
        nearest.map_or(Vec2::ZERO, |(_, shares)| shares)
    }

    /// Whether it has a part of the texel around a point.
    fn touches_texel(&self, center: Vec2) -> bool {
        let corners = self.corners.map(|corner| corner - center);
        let outside =
            |values: [f32; 3]| values.iter().all(|value| *value >= 0.5) || values.iter().all(|value| *value <= -0.5);
        if outside(corners.map(|corner| corner.x)) || outside(corners.map(|corner| corner.y)) {
            return false;
        }
        // Edges of the triangle as separating lines.
        (0..3).all(|edge| {
            let (from, to, other) = (corners[edge], corners[(edge + 1) % 3], corners[(edge + 2) % 3]);
            let normal = (to - from).perp();
            let inside = normal.dot(other - from);
            let reach = 0.5 * (normal.x.abs() + normal.y.abs());
            let center = normal.dot(-from);
            if inside >= 0.0 { center + reach > 0.0 } else { center - reach < 0.0 }
        })
    }
}

impl<'s> Texels<'s> {
    /// Finds the triangles of all texels: that which has the texel's middle, else one that has a part of it.
    pub fn new(surfaces: &'s Surfaces, layout: &'s Layout) -> Self {
        let mut texels = Self { surfaces, layout, owners: vec![NOBODY; layout.texel_count()] };
        for takes_parts in [false, true] {
            for (placed, index) in surfaces.placed.iter().zip(&layout.of_placed) {
                let Some(index) = index else { continue };
                let count = placed.indices.len() as u32 / 3;
                for triangle in placed.first_triangle..placed.first_triangle + count {
                    texels.cover(triangle, layout.unwrapped[*index as usize].page, takes_parts);
                }
            }
        }
        texels
    }

    /// The triangle of a texel, where light may come to.
    pub fn triangle(&self, index: usize) -> Option<u32> {
        self.owners.get(index).copied().filter(|owner| owner & INSIDE == 0)
    }

    /// Whether a texel has a surface, inside something or not.
    pub fn has_surface(&self, index: usize) -> bool {
        self.owners.get(index).is_some_and(|owner| *owner != NOBODY)
    }

    /// Marks those that lie inside something.
    pub fn put_inside(&mut self, inside: &[bool]) {
        let marked = self.owners.iter_mut().zip(inside).filter(|(_, inside)| **inside);
        marked.for_each(|(owner, _)| *owner |= INSIDE);
    }

    /// The normal of a triangle.
    pub fn facet(&self, triangle: u32) -> Vec3 {
        let [a, b, c] = self.surfaces.corners(triangle);
        (b - a).cross(c - a).normalize_or_zero()
    }

    fn cover(&mut self, triangle: u32, page: u32, takes_parts: bool) {
        let Some(flat) = self.flat(triangle) else { return };
        let (width, height) = (self.layout.width, self.layout.height);
        let low = flat.corners.iter().fold(Vec2::INFINITY, |low, corner| low.min(*corner)).floor().max(Vec2::ZERO);
        let high = flat.corners.iter().fold(Vec2::NEG_INFINITY, |high, corner| high.max(*corner)).ceil();
        let (columns, rows) = ((high.x as u32).min(width), (high.y as u32).min(height));
        for y in low.y as u32..rows {
            for x in low.x as u32..columns {
                let index = (page as usize * height as usize + y as usize) * width as usize + x as usize;
                if self.owners[index] != NOBODY {
                    continue;
                }
                let center = Vec2::new(x as f32, y as f32) + 0.5;
                let is_taken = if takes_parts { flat.touches_texel(center) } else { flat.contains(center) };
                if is_taken {
                    self.owners[index] = triangle;
                }
            }
        }
    }

    /// The corners of a triangle in its page, in UV.
    fn corners_uv(&self, triangle: u32) -> Option<([Vec2; 3], u32)> {
        let (placed, _) = self.surfaces.triangle(triangle);
        let of_layout = self.layout.of_placed[self.surfaces.owners[triangle as usize] as usize]?;
        let unwrapped = &self.layout.unwrapped[of_layout as usize];
        let first = 3 * (triangle - placed.first_triangle) as usize;
        let corner = |corner: usize| unwrapped.vertices[unwrapped.indices[first + corner] as usize].1;
        Some(([corner(0), corner(1), corner(2)], unwrapped.page))
    }

    fn flat(&self, triangle: u32) -> Option<TexelTriangle> {
        let size = Vec2::new(self.layout.width as f32, self.layout.height as f32);
        let (corners, _) = self.corners_uv(triangle)?;
        Some(TexelTriangle { corners: corners.map(|corner| corner * size) })
    }

    /// The chart of a triangle.
    pub fn chart(&self, triangle: u32) -> Option<u32> {
        let owner = self.surfaces.owners[triangle as usize] as usize;
        let unwrapped = &self.layout.unwrapped[self.layout.of_placed[owner]? as usize];
        unwrapped.charts.get((triangle - self.surfaces.placed[owner].first_triangle) as usize).copied()
    }

    /// A place within a texel that has a triangle; `within` is from 0 to 1 each.
    pub fn spot(&self, index: usize, within: Vec2) -> Option<Spot> {
        let triangle = self.triangle(index)?;
        let width = self.layout.width as usize;
        let (x, y) = (index % width, index / width % self.layout.height as usize);
        let shares = self.flat(triangle)?.nearest_shares(Vec2::new(x as f32, y as f32) + within);
        Some(Spot { triangle, shares })
    }

    /// Light at a spot, between the texels around it; none where its surface has no place.
    pub fn look_up(&self, light: &[impl Light], spot: Spot) -> Option<Vec3> {
        let ([a, b, c], page) = self.corners_uv(spot.triangle)?;
        let uv = a * (1.0 - spot.shares.x - spot.shares.y) + b * spot.shares.x + c * spot.shares.y;
        let (width, height) = (self.layout.width as usize, self.layout.height as usize);
        let place = uv * Vec2::new(width as f32, height as f32) - 0.5;
        let (low, part) = (place.floor(), place - place.floor());
        let at = |dx: f32, dy: f32| {
            let x = ((low.x + dx).max(0.0) as usize).min(width - 1);
            let y = ((low.y + dy).max(0.0) as usize).min(height - 1);
            light[(page as usize * height + y) * width + x].value()
        };
        let above = at(0.0, 0.0).lerp(at(1.0, 0.0), part.x);
        Some(above.lerp(at(0.0, 1.0).lerp(at(1.0, 1.0), part.x), part.y))
    }
}
