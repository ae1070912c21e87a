//! The triangles of a scene in world space.

use super::bvh::{Bounds, Bvh, Crossing, Ray};
use super::materials::{Attributes, Material};
use glam::{DVec2, DVec3, DVec4};
use std::ops::ControlFlow;

/// A corner of triangles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    pub position_world: DVec3,
    /// Zero where there is none.
    pub normal_world: DVec3,
    pub tangent_world: DVec4,
    pub uvs: [DVec2; 2],
    pub color: DVec4,
}

/// A primitive of a node.
#[derive(Clone, Debug)]
pub(super) struct MeshPart {
    /// Index of the node.
    pub node: usize,
    /// Index of the material.
    pub material: usize,
    /// Whether the node keeps light off.
    pub casts_shadow: bool,
    /// The box around it.
    pub bounds_world: Bounds,
}

/// The triangles of a scene in world space, each of a part: a primitive of a node.
#[derive(Clone, Debug, Default)]
pub struct Meshes {
    pub(super) vertices: Vec<Vertex>,
    /// Corners, counter-clockwise seen from the front.
    pub(super) triangles: Vec<[u32; 3]>,
    /// The part of each triangle.
    pub(super) part_of: Vec<u32>,
    pub(super) parts: Vec<MeshPart>,
    pub(super) materials: Vec<Material>,
    bvh: Bvh,
    /// What counts as touching, in metres.
    epsilon_m: f64,
}

/// A surface that a ray meets.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layer {
    pub distance_m: f64,
    pub triangle: u32,
    /// 1 of the last one.
    pub coverage: f64,
    crossing: Crossing,
}

impl Meshes {
    /// Call this when all triangles are there.
    pub(super) fn finish(&mut self) {
        let corners: Vec<_> = self.triangles.iter().map(|corners| self.corners_of(*corners)).collect();
        self.bvh = Bvh::new(&corners);
        let bounds = self.bvh.bounds();
        // The rounding of f64 is a billion times smaller, and that of the `f32` in files a tenth of it.
        self.epsilon_m = if self.triangles.is_empty() { 0.0 } else { 1e-6 * bounds.min.distance(bounds.max) };
    }

    /// The number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    fn corners_of(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|vertex| self.vertices[vertex as usize].position_world)
    }

    fn part(&self, triangle: u32) -> (usize, &MeshPart) {
        let part = self.part_of[triangle as usize] as usize;
        (part, &self.parts[part])
    }

    fn attributes(&self, crossing: &Crossing) -> Attributes {
        let [a, b, c] = self.triangles[crossing.triangle as usize].map(|vertex| &self.vertices[vertex as usize]);
        let [u, v] = crossing.weights;
        let w = 1.0 - u - v;
        Attributes {
            normal_world: a.normal_world * w + b.normal_world * u + c.normal_world * v,
            tangent_world: (a.tangent_world * w + b.tangent_world * u + c.tangent_world * v).with_w(a.tangent_world.w),
            uvs: [0, 1].map(|set| a.uvs[set] * w + b.uvs[set] * u + c.uvs[set] * v),
            color: a.color * w + b.color * u + c.color * v,
        }
    }

    fn coverage(&self, crossing: &Crossing, material: &Material) -> f64 {
        if material.is_opaque() { 1.0 } else { material.coverage(&self.attributes(crossing)) }
    }

    /// What an eye at `origin_world` sees along a ray before `end_m`, from near to far: blended surfaces, and the first
    /// that covers all behind it. Backs of surfaces that are not double-sided are not seen.
    pub(super) fn layers(&self, origin_world: DVec3, direction_world: DVec3, end_m: f64) -> Vec<Layer> {
        let mut layers: Vec<Layer> = Vec::new();
        let mut end_m = end_m;
        self.bvh.crossings(&Ray::new(origin_world, direction_world), 0.0, end_m, |crossing| {
            let (_, part) = self.part(crossing.triangle);
            let material = &self.materials[part.material];
            if crossing.from_front || material.is_double_sided {
                let coverage = self.coverage(&crossing, material);
                let Crossing { distance_m, triangle, .. } = crossing;
                if coverage > 0.0 && !self.is_crossed_twice(&layers, &crossing) {
                    layers.push(Layer { distance_m, triangle, coverage, crossing });
                }
                if coverage >= 1.0 {
                    end_m = distance_m;
                }
            }
            ControlFlow::Continue(end_m)
        });
        layers.retain(|layer| layer.distance_m <= end_m);
        layers.sort_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
        layers
    }

    /// Whether the ray goes through the edge between a triangle that it met already and this one of the same part: they
    /// are one surface.
    fn is_crossed_twice(&self, layers: &[Layer], crossing: &Crossing) -> bool {
        layers.iter().any(|layer| {
            self.part_of[layer.triangle as usize] == self.part_of[crossing.triangle as usize]
                && (layer.distance_m - crossing.distance_m).abs() <= 1e-3 * self.epsilon_m
        })
    }

    /// Index of the node, of the material, the shading normal on the side of the viewer, and the attributes of a layer.
    pub(super) fn shaded(&self, layer: &Layer) -> (usize, &Material, DVec3, Attributes) {
        let (_, part) = self.part(layer.triangle);
        let material = &self.materials[part.material];
        let attributes = self.attributes(&layer.crossing);
        let [a, b, c] = self.corners_of(self.triangles[layer.triangle as usize]);
        let normal = material.shading_normal(&attributes, (b - a).cross(c - a).normalize());
        (part.node, material, if layer.crossing.from_front { normal } else { -normal }, attributes)
    }

    /// The share of light that gets along a ray of `length_m` from `origin_world`, which lies on the triangle `own`, to
    /// its source, around which the parts `glows_around` glow.
    ///
    /// Surfaces keep light off by 1 or, cut out, 0, blended ones by their alpha. Those that are not double-sided do so
    /// only if their front is turned to the light, as the eye sees no more of them either: a closed pane of glass
    /// weakens light as it weakens what lies behind it, once. But one that is not blended, and whose box holds the
    /// source, encloses it, whichever side is within.
    pub(super) fn transmittance(
        &self,
        (origin_world, own): (DVec3, Option<u32>),
        (direction_world, length_m): (DVec3, f64),
        glows_around: &[usize],
    ) -> f64 {
        let mut transmittance = 1.0;
        let mut blended: Vec<Layer> = Vec::new();
        let ray = Ray::new(origin_world, direction_world);
        let end_m = length_m - self.epsilon_m;
        let source_world = length_m.is_finite().then(|| origin_world + length_m * direction_world);
        self.bvh.crossings(&ray, self.epsilon_m, end_m, |crossing| {
            let (index, part) = self.part(crossing.triangle);
            let material = &self.materials[part.material];
            let faces_light = !crossing.from_front || material.is_double_sided;
            let encloses =
                || !material.is_blended() && source_world.is_some_and(|source| part.bounds_world.contains(source));
            if own == Some(crossing.triangle)
                || !(part.casts_shadow && material.casts_shadow)
                || !(faces_light || encloses())
                || glows_around.contains(&index)
            {
                return ControlFlow::Continue(end_m);
            }
            let coverage = self.coverage(&crossing, material);
            if coverage >= 1.0 {
                transmittance = 0.0;
                return ControlFlow::Break(());
            }
            if coverage > 0.0 && !self.is_crossed_twice(&blended, &crossing) {
                let Crossing { distance_m, triangle, .. } = crossing;
                blended.push(Layer { distance_m, triangle, coverage, crossing });
                transmittance *= 1.0 - coverage;
            }
            ControlFlow::Continue(end_m)
        });
        transmittance
    }

    /// Indices of parts that glow and whose box holds a place.
    pub(super) fn glowing_around(&self, position_world: DVec3) -> Vec<usize> {
        let glows =
            |part: &MeshPart| self.materials[part.material].emits() && part.bounds_world.contains(position_world);
        (0..self.parts.len()).filter(|index| glows(&self.parts[*index])).collect()
    }
}
