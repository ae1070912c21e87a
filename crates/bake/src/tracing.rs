//! Rays through surfaces.

use crate::surfaces::{Spot, Surfaces};
use glam::{Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::ray::{Ray, RayHit};
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;

/// Where a ray ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hit {
    pub spot: Spot,
    pub distance_m: f32,
    /// Whether it comes from behind the triangle.
    pub is_behind: bool,
}

/// Surfaces, sorted for rays.
pub(crate) struct Tracer<'s> {
    surfaces: &'s Surfaces,
    /// None of a scene without triangles.
    hierarchy: Option<Bvh2>,
    /// In the hierarchy's order, with the number of each and whether it has holes or casts no shadow.
    triangles: Vec<(RtTriangle, u32, Kind)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Kind {
    is_masked: bool,
    casts_shadow: bool,
}

/// A place just beside a surface, from which rays do not meet it again: moved along its normal by a few of the last bits
/// of its numbers (Wächter & Binder 2019, "A Fast and Robust Method for Avoiding Self-Intersection").
pub(crate) fn beside(position: Vec3, facet: Vec3) -> Vec3 {
    const BITS: f32 = 256.0;
    const NEAR_ZERO: f32 = 1.0 / 32.0;
    const NEAR_ZERO_STEP_M: f32 = 1.0 / 65_536.0;
    let moved = |value: f32, along: f32| {
        if value.abs() < NEAR_ZERO {
            return value + along * NEAR_ZERO_STEP_M;
        }
        let steps = (along * BITS) as i32;
        f32::from_bits((value.to_bits() as i32).wrapping_add(if value < 0.0 { -steps } else { steps }) as u32)
    };
    Vec3::new(moved(position.x, facet.x), moved(position.y, facet.y), moved(position.z, facet.z))
}

impl<'s> Tracer<'s> {
    /// Of surfaces.
    pub fn new(surfaces: &'s Surfaces) -> Self {
        let all: Vec<Triangle> = (0..surfaces.triangle_count() as u32)
            .map(|triangle| {
                let [v0, v1, v2] = surfaces.corners(triangle).map(Vec3A::from);
                Triangle { v0, v1, v2 }
            })
            .collect();
        if all.is_empty() {
            return Self { surfaces, hierarchy: None, triangles: Vec::new() };
        }
        let hierarchy = build_bvh2_from_tris(&all, BvhBuildParams::medium_build(), &mut Default::default());
        let kind = |triangle: u32| {
            let (placed, _) = surfaces.triangle(triangle);
            let surface = surfaces.surfacing.surface(placed.material);
            Kind { is_masked: surface.is_masked(), casts_shadow: placed.casts_shadow }
        };
        let in_order = hierarchy.primitive_indices.iter();
        let triangles = in_order.map(|index| (RtTriangle::from(&all[*index as usize]), *index, kind(*index))).collect();
        Self { surfaces, hierarchy: Some(hierarchy), triangles }
    }

    fn is_met(&self, ray: &Ray, (triangle, number, kind): &(RtTriangle, u32, Kind)) -> f32 {
        let distance = triangle.intersect(ray);
        if kind.is_masked && distance < f32::INFINITY {
            let shares = triangle.compute_barycentric(ray);
            if !self.surfaces.is_there(Spot { triangle: *number, shares }) {
                return f32::INFINITY;
            }
        }
        distance
    }

    /// The first surface along a ray with a unit direction.
    pub fn first(&self, from: Vec3, direction: Vec3) -> Option<Hit> {
        let hierarchy = self.hierarchy.as_ref()?;
        let ray = Ray::new(from.into(), direction.into(), 0.0, f32::MAX);
        let mut hit = RayHit::none();
        if !hierarchy.ray_traverse(ray, &mut hit, |ray, index| self.is_met(ray, &self.triangles[index])) {
            return None;
        }
        let (triangle, number, _) = &self.triangles[hit.primitive_id as usize];
        let is_behind = triangle.compute_normal().dot(ray.direction) > 0.0;
        let spot = Spot { triangle: *number, shares: triangle.compute_barycentric(&ray) };
        Some(Hit { spot, distance_m: hit.t, is_behind })
    }

    /// Whether no light comes from where a ray ends, because it is the back of a surface that has one side.
    pub fn is_black(&self, hit: &Hit) -> bool {
        let (placed, _) = self.surfaces.triangle(hit.spot.triangle);
        hit.is_behind && !self.surfaces.surfacing.surface(placed.material).double_sided
    }

    /// Whether nothing lies along a ray with a unit direction, up to a distance: what [`Self::first`] would meet.
    pub fn is_clear(&self, from: Vec3, direction: Vec3, distance_m: f32) -> bool {
        let Some(hierarchy) = &self.hierarchy else { return true };
        let ray = Ray::new(from.into(), direction.into(), 0.0, distance_m);
        hierarchy.ray_traverse_miss(ray, |ray, index| self.is_met(ray, &self.triangles[index]))
    }

    /// Whether nothing that casts a shadow lies along a ray with a unit direction, up to a distance.
    pub fn is_free(&self, from: Vec3, direction: Vec3, distance_m: f32) -> bool {
        let Some(hierarchy) = &self.hierarchy else { return true };
        let ray = Ray::new(from.into(), direction.into(), 0.0, distance_m);
        hierarchy.ray_traverse_miss(ray, |ray, index| {
            let of_index = &self.triangles[index];
            if of_index.2.casts_shadow { self.is_met(ray, of_index) } else { f32::INFINITY }
        })
    }
}
