//! An independent ray caster in `f64`: primary rays, lights with and without size, shadows, fog. It shares no code with
//! the renderer, so that an error in one does not repeat itself in the other.
//!
//! Space, cameras, lights and units are those of glTF 2.0: right-handed, +Y up, cameras and lights look along −Z,
//! lengths in metres, candela and lux, radiance = BRDF · irradiance.
//!
//! Light is shaded by the shading normal and shadowed by geometry: a light counts where N·L > 0 and no *other* triangle
//! lies between, beyond a millionth of the scene's size. A light of some size shades as its middle does, and is as
//! strong as the share of its source that is seen.

use crate::scenes::as_rgb;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

pub mod brdf;
mod bvh;
mod camera;
mod conversion;
mod lights;
mod materials;
mod medium;
mod meshes;
mod random;
mod shading;
mod shapes;
mod textures;

pub use brdf::{AlbedoTable, Surface};
pub use camera::{Camera, Lens};
pub use lights::{Emission, Light};
pub use medium::Medium;
pub use meshes::Meshes;
pub use shapes::{Object, Shape};

use shading::{Albedos, Place, Sequence};

/// What a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Metres from the origin of the ray.
    pub distance_m: f64,
    /// Index into [`World::objects`], or of the mesh's node.
    pub object: usize,
    /// Where, in world space.
    pub position_world: DVec3,
    /// The unit normal on the side of the viewer.
    pub normal_world: DVec3,
}

/// Where the rays of a pixel go through it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelPattern {
    /// The middles of a regular grid.
    Grid,
    /// The R2 sequence (Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018) from the pixel's
    /// middle, seen through it: the points at which the samples of a picture are that moves its image by that sequence.
    /// What is smaller than a pixel makes pictures of other points incomparable.
    Sequence,
}

impl PixelPattern {
    /// The place of a ray in its pixel, from the upper left corner, from 0 to 1; a grid has `rays_per_axis²` of them.
    pub fn place(self, ray: u32, rays_per_axis: u32) -> DVec2 {
        match self {
            Self::Grid => {
                let cell = DVec2::new(f64::from(ray % rays_per_axis), f64::from(ray / rays_per_axis));
                (cell + 0.5) / f64::from(rays_per_axis)
            }
            Self::Sequence => {
                // The plastic number is the real root of x³ = x + 1.
                let plastic = 1.324_717_957_244_746_f64;
                let steps = DVec2::new(1.0 / plastic, 1.0 / (plastic * plastic));
                DVec2::ONE - (0.5 + steps * f64::from(ray)).fract()
            }
        }
    }
}

/// What the ray caster is to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Whether objects block light.
    pub shadows: bool,
    /// Shadows of lights with a size are the mean of `light_samples_per_axis²` rays to places spread over their source;
    /// with 0 every light is a point.
    pub light_samples_per_axis: u32,
    /// Whether the specular lobe is compensated for light scattered more than once between microfacets.
    pub multiple_scattering: bool,
    /// A pixel's radiance is the mean of `samples_per_axis²` rays.
    pub samples_per_axis: u32,
    /// Where the rays of a pixel go through it.
    pub pixel_pattern: PixelPattern,
    /// The light of one lamp in fog is the sum over so many places along a ray.
    pub medium_steps: u32,
    /// Chooses the random numbers that spread places.
    pub seed: u64,
}

impl Default for Options {
    /// One ray a pixel, no shadows.
    fn default() -> Self {
        Self {
            shadows: false,
            light_samples_per_axis: 4,
            multiple_scattering: true,
            samples_per_axis: 1,
            pixel_pattern: PixelPattern::Grid,
            medium_steps: 16,
            seed: 0,
        }
    }
}

/// Everything that can be seen. Where nothing is, radiance is 0.
#[derive(Clone, Debug)]
pub struct World {
    /// The objects.
    pub objects: Vec<Object>,
    /// Triangles; [`World::of_scene`] brings them.
    pub meshes: Meshes,
    /// The lights.
    pub lights: Vec<Light>,
    /// The fog.
    pub medium: Option<Medium>,
    /// The camera.
    pub camera: Camera,
}

/// A rendered picture, rows from the top. Everything but radiance belongs to the centre of the pixel, and to the first
/// surface that is not blended.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Linear Rec. 709.
    pub radiance: Vec<[f32; 3]>,
    /// Metres along the camera's −Z; infinite where nothing is.
    pub depth_view_m: Vec<f64>,
    /// World space; zero where nothing is.
    pub position_world: Vec<DVec3>,
    /// World space; zero where nothing is.
    pub normal_world: Vec<DVec3>,
    /// One more than the index into [`World::objects`], or the index of the mesh's node; 0 where nothing is.
    pub object_id: Vec<u32>,
}

/// What a ray sees.
#[derive(Clone, Copy, Debug)]
struct RayResult {
    radiance: DVec3,
    /// The first surface that is not blended.
    solid: Option<Hit>,
}

/// A pixel of a [`Frame`].
#[derive(Clone, Copy, Debug)]
struct Pixel {
    radiance: DVec3,
    hit: Option<Hit>,
}

impl World {
    /// Nothing before `camera`.
    pub fn new(camera: Camera) -> Self {
        Self { objects: Vec::new(), meshes: Meshes::default(), lights: Vec::new(), medium: None, camera }
    }

    /// The nearest of [`World::objects`] along a ray.
    pub fn nearest_hit(&self, origin_world: DVec3, direction_world: DVec3) -> Option<Hit> {
        let mut nearest: Option<Hit> = None;
        for (object, Object { shape, .. }) in self.objects.iter().enumerate() {
            let Some((distance_m, normal_world)) = shape.intersect(origin_world, direction_world) else { continue };
            if nearest.is_none_or(|hit| distance_m < hit.distance_m) {
                let position_world = origin_world + distance_m * direction_world;
                nearest = Some(Hit { distance_m, object, position_world, normal_world });
            }
        }
        nearest
    }

    /// The radiance that arrives at `origin_world` against a unit direction.
    fn seen(
        &self,
        (origin_world, direction_world): (DVec3, DVec3),
        albedos: &Albedos,
        (options, sequence): (Options, Sequence),
    ) -> RayResult {
        let behind = self.nearest_hit(origin_world, direction_world);
        let limit_m = behind.map_or(f64::INFINITY, |hit| hit.distance_m);
        let layers = self.meshes.layers(origin_world, direction_world, limit_m);
        let mut seen = RayResult { radiance: DVec3::ZERO, solid: None };
        let fog_before = |distance_m: f64| {
            self.medium.map_or(1.0, |medium| medium.transmittance(origin_world, direction_world, distance_m))
        };
        // What surfaces leave of all that lies farther away than the first of each pair.
        let mut left: Vec<(f64, f64)> = Vec::new();
        let mut share = 1.0;
        for layer in &layers {
            let (node, material, normal_world, attributes) = self.meshes.shaded(layer);
            let position_world = origin_world + layer.distance_m * direction_world;
            let (surface, is_lit) = material.surface(&attributes);
            let place = Place { position_world, normal_world, triangle: Some(layer.triangle) };
            let radiance = match is_lit {
                true => self.radiance(&place, &surface, -direction_world, albedos, (options, sequence)),
                false => surface.emission,
            };
            seen.radiance += radiance * (share * layer.coverage * fog_before(layer.distance_m));
            share *= 1.0 - layer.coverage;
            left.push((layer.distance_m, share));
            if layer.coverage >= 1.0 {
                let distance_m = layer.distance_m;
                seen.solid = Some(Hit { distance_m, object: node, position_world, normal_world });
            }
        }
        if let Some(hit) = behind.filter(|_| seen.solid.is_none()) {
            let surface = &self.objects[hit.object].surface;
            let place = Place { position_world: hit.position_world, normal_world: hit.normal_world, triangle: None };
            let radiance = self.radiance(&place, surface, -direction_world, albedos, (options, sequence));
            seen.radiance += radiance * (share * fog_before(hit.distance_m));
            seen.solid = Some(hit);
        }
        if let Some(medium) = &self.medium {
            let end_m = seen.solid.map_or(medium.far_m, |hit| hit.distance_m);
            let left_at = |at_m: f64| {
                let before = left.iter().rev().find(|(distance_m, _)| *distance_m < at_m);
                before.map_or(1.0, |(_, share)| *share)
            };
            let ray = (origin_world, direction_world, end_m);
            seen.radiance += self.scattered(medium, ray, left_at, (options, sequence));
        }
        seen
    }

    /// Renders a picture, rows at once on all processors.
    pub fn render(&self, width: usize, height: usize, options: Options) -> Frame {
        self.render_rows((width, height), 0..height, options)
    }

    /// Some rows of a picture of this width and height.
    pub fn render_rows(&self, (width, height): (usize, usize), rows: Range<usize>, options: Options) -> Frame {
        let albedos = if options.multiple_scattering { Albedos::new(self) } else { Albedos::default() };
        let next_row = AtomicUsize::new(rows.start);
        let render_rows = || {
            let mut rendered = Vec::new();
            loop {
                let row = next_row.fetch_add(1, Ordering::Relaxed);
                if row >= rows.end {
                    return rendered;
                }
                let pixel = |column| self.pixel((column, row), (width, height), &albedos, options);
                rendered.push((row, (0..width).map(pixel).collect::<Vec<_>>()));
            }
        };
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let mut rendered: Vec<(usize, Vec<Pixel>)> = std::thread::scope(|scope| {
            let workers: Vec<_> = (0..threads).map(|_| scope.spawn(render_rows)).collect();
            workers
                .into_iter()
                .flat_map(|worker| worker.join().unwrap_or_else(|e| std::panic::resume_unwind(e)))
                .collect()
        });
        rendered.sort_by_key(|(row, _)| *row);
        let pixels: Vec<Pixel> = rendered.into_iter().flat_map(|(_, pixels)| pixels).collect();
        let forward_world = self.camera.world_from_view * DVec3::NEG_Z;
        let depth = |hit: Hit| (hit.position_world - self.camera.position_world).dot(forward_world);
        let hits = || pixels.iter().map(|pixel| pixel.hit);
        Frame {
            width,
            height: rows.len(),
            radiance: pixels.iter().map(|pixel| as_rgb(pixel.radiance)).collect(),
            depth_view_m: hits().map(|hit| hit.map_or(f64::INFINITY, depth)).collect(),
            position_world: hits().map(|hit| hit.map_or(DVec3::ZERO, |hit| hit.position_world)).collect(),
            normal_world: hits().map(|hit| hit.map_or(DVec3::ZERO, |hit| hit.normal_world)).collect(),
            object_id: hits().map(|hit| hit.map_or(0, |hit| hit.object as u32 + 1)).collect(),
        }
    }

    fn pixel(
        &self,
        (column, row): (usize, usize),
        (width, height): (usize, usize),
        albedos: &Albedos,
        options: Options,
    ) -> Pixel {
        let aspect = width as f64 / height as f64;
        let ray = |offset: DVec2| {
            let uv = (DVec2::new(column as f64, row as f64) + offset) / DVec2::new(width as f64, height as f64);
            self.camera.ray(DVec2::new(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y), aspect)
        };
        let n = options.samples_per_axis.max(1);
        let mut sum = DVec3::ZERO;
        let mut middle = None;
        for sample in 0..n * n {
            let offset = options.pixel_pattern.place(sample, n);
            let sequence = [(row * width + column) as u64, u64::from(sample)];
            let seen = self.seen(ray(offset), albedos, (options, sequence));
            sum += seen.radiance;
            middle = seen.solid;
        }
        if n > 1 {
            middle = self.first_solid(ray(DVec2::splat(0.5)));
        }
        Pixel { radiance: sum / f64::from(n * n), hit: middle }
    }

    /// The first surface along a ray (origin and unit direction in world space) that is not blended. Backs of triangles
    /// that are not double-sided are not seen.
    pub fn first_solid(&self, (origin_world, direction_world): (DVec3, DVec3)) -> Option<Hit> {
        let behind = self.nearest_hit(origin_world, direction_world);
        let limit_m = behind.map_or(f64::INFINITY, |hit| hit.distance_m);
        let layers = self.meshes.layers(origin_world, direction_world, limit_m);
        let Some(layer) = layers.last().filter(|layer| layer.coverage >= 1.0) else { return behind };
        let (object, _, normal_world, _) = self.meshes.shaded(layer);
        let position_world = origin_world + layer.distance_m * direction_world;
        Some(Hit { distance_m: layer.distance_m, object, position_world, normal_world })
    }
}

/// The radiance of a Lambert surface of `albedo` at distance `height_m` right below a point light, `offset_m` aside:
/// `albedo / π · I · cos θ / d²`.
pub fn lambert_below_point_light(albedo: f64, intensity_cd: f64, height_m: f64, offset_m: f64) -> f64 {
    let distance_squared = height_m * height_m + offset_m * offset_m;
    albedo / PI * intensity_cd * (height_m / distance_squared.sqrt()) / distance_squared
}

#[cfg(test)]
mod tests;
