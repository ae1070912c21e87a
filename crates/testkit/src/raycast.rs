//! An independent ray caster in `f64`: primary rays, punctual lights, hard shadows. It shares no code with the renderer,
//! so that an error in one does not repeat itself in the other.
//!
//! Space, cameras, lights and units are those of glTF 2.0: right-handed, +Y up, cameras and lights look along −Z, lengths
//! in metres, candela and lux, radiance = BRDF · irradiance.

use crate::scenes::as_rgb;
use glam::{DQuat, DVec2, DVec3};
use std::f64::consts::PI;

pub mod brdf;

pub use brdf::{AlbedoTable, Surface};

/// A shape to hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A sphere, hit from outside.
    Sphere {
        /// The centre in world space.
        center_world: DVec3,
        /// The radius in metres.
        radius_m: f64,
    },
    /// A finite rectangle, hit from both sides; its normal is turned to the viewer.
    Quad {
        /// The centre in world space.
        center_world: DVec3,
        /// From the centre to the middle of one edge.
        half_u_world: DVec3,
        /// From the centre to the middle of a neighbouring edge, at a right angle to `half_u_world`.
        half_v_world: DVec3,
    },
}

/// A shape with a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Object {
    /// Where it is.
    pub shape: Shape,
    /// What it is made of.
    pub surface: Surface,
}

/// The shape of a light's emission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Emission {
    /// Parallel light in lux.
    Directional,
    /// From a point, in candela.
    Point,
    /// A cone from a point, in candela.
    Spot {
        /// Full strength within this angle from the axis, in radians.
        inner_cone_rad: f64,
        /// Nothing beyond this angle from the axis, in radians.
        outer_cone_rad: f64,
    },
}

/// A punctual light (`KHR_lights_punctual`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// The shape of its emission.
    pub emission: Emission,
    /// Where it is, in world space; of no meaning for directional light.
    pub position_world: DVec3,
    /// Whither it shines, a unit vector; of no meaning for point lights.
    pub direction_world: DVec3,
    /// Linear colour times candela or lux.
    pub intensity: DVec3,
    /// Nothing arrives beyond this distance in metres; none means only the inverse square.
    pub range_m: Option<f64>,
}

impl Light {
    /// The direction to the light, the distance to it (infinite for directional light) and the irradiance on a surface
    /// that faces it, in lux. The fall-off and the cone are those that `KHR_lights_punctual` recommends.
    pub fn arriving_at(&self, position_world: DVec3) -> (DVec3, f64, DVec3) {
        if self.emission == Emission::Directional {
            return (-self.direction_world, f64::INFINITY, self.intensity);
        }
        let offset = self.position_world - position_world;
        let distance_m = offset.length();
        let to_light = offset / distance_m;
        let window = self.range_m.map_or(1.0, |range_m| (1.0 - (distance_m / range_m).powi(4)).clamp(0.0, 1.0));
        let cone = match self.emission {
            Emission::Spot { inner_cone_rad, outer_cone_rad } => {
                let scale = 1.0 / (inner_cone_rad.cos() - outer_cone_rad.cos()).max(0.001);
                let offset = -outer_cone_rad.cos() * scale;
                ((-to_light).dot(self.direction_world) * scale + offset).clamp(0.0, 1.0).powi(2)
            }
            Emission::Directional | Emission::Point => 1.0,
        };
        (to_light, distance_m, self.intensity * (window * cone / (distance_m * distance_m)))
    }
}

/// How the camera maps space to the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// A pinhole with this vertical field of view in radians.
    Perspective {
        /// Radians from the lower to the upper edge.
        fov_y_rad: f64,
    },
    /// Parallel rays.
    Orthographic {
        /// The full height of the picture in metres.
        height_m: f64,
    },
}

/// A camera that looks along −Z of `world_from_view`, +Y up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The place in world space.
    pub position_world: DVec3,
    /// The rotation.
    pub world_from_view: DQuat,
    /// The projection.
    pub lens: Lens,
}

impl Camera {
    /// The origin and the unit direction of the ray through `position_ndc` (x right, y up, −1 to 1).
    fn ray(&self, position_ndc: DVec2, aspect: f64) -> (DVec3, DVec3) {
        match self.lens {
            Lens::Perspective { fov_y_rad } => {
                let tan = (0.5 * fov_y_rad).tan();
                let direction_view = DVec3::new(position_ndc.x * tan * aspect, position_ndc.y * tan, -1.0);
                (self.position_world, (self.world_from_view * direction_view).normalize())
            }
            Lens::Orthographic { height_m } => {
                let offset_view = DVec3::new(position_ndc.x * aspect, position_ndc.y, 0.0) * (0.5 * height_m);
                (self.position_world + self.world_from_view * offset_view, self.world_from_view * DVec3::NEG_Z)
            }
        }
    }
}

/// What a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Metres from the origin of the ray.
    pub distance_m: f64,
    /// Index into [`World::objects`].
    pub object: usize,
    /// Where, in world space.
    pub position_world: DVec3,
    /// The unit normal on the side of the viewer.
    pub normal_world: DVec3,
}

/// What the ray caster is to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Whether objects block light.
    pub shadows: bool,
    /// Whether the specular lobe is compensated for light scattered more than once between microfacets.
    pub multiple_scattering: bool,
    /// A pixel's radiance is the mean of `samples_per_axis²` rays on a regular grid.
    pub samples_per_axis: u32,
}

impl Default for Options {
    fn default() -> Self {
        Self { shadows: false, multiple_scattering: true, samples_per_axis: 1 }
    }
}

/// Everything that can be seen. Where no object is, radiance is 0.
#[derive(Clone, Debug, PartialEq)]
pub struct World {
    /// The objects.
    pub objects: Vec<Object>,
    /// The lights.
    pub lights: Vec<Light>,
    /// The camera.
    pub camera: Camera,
}

/// A rendered picture, rows from the top. Everything but radiance belongs to the centre of the pixel.
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
    /// One more than the index into [`World::objects`]; 0 where nothing is.
    pub object_id: Vec<u32>,
}

impl World {
    /// The nearest hit of a ray beyond `start_m` metres.
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

    /// The radiance from `hit` towards `to_viewer`, a unit vector. `albedos` holds one table an object.
    fn radiance(&self, hit: &Hit, to_viewer: DVec3, albedos: &[AlbedoTable], options: Options) -> DVec3 {
        let surface = &self.objects[hit.object].surface;
        let normal = hit.normal_world;
        let compensation = if options.multiple_scattering {
            surface.compensation(albedos[hit.object].get(normal.dot(to_viewer)))
        } else {
            DVec3::ONE
        };
        self.lights.iter().fold(surface.emission, |radiance, light| {
            let (to_light, distance_m, irradiance) = light.arriving_at(hit.position_world);
            let n_dot_l = normal.dot(to_light);
            if n_dot_l <= 0.0 || irradiance == DVec3::ZERO {
                return radiance;
            }
            // A micrometre is far above the rounding of f64 at these distances and far below what a picture shows.
            let origin_world = hit.position_world + 1e-6 * normal;
            if options.shadows
                && self.nearest_hit(origin_world, to_light).is_some_and(|hit| hit.distance_m < distance_m)
            {
                return radiance;
            }
            radiance + surface.brdf(normal, to_viewer, to_light, compensation) * irradiance * n_dot_l
        })
    }

    /// Renders a picture.
    pub fn render(&self, width: usize, height: usize, options: Options) -> Frame {
        let albedos: Vec<_> = self
            .objects
            .iter()
            .map(|object| {
                if options.multiple_scattering {
                    AlbedoTable::new(object.surface.roughness_alpha())
                } else {
                    AlbedoTable::default()
                }
            })
            .collect();
        let aspect = width as f64 / height as f64;
        let ray = |x: f64, y: f64| {
            self.camera.ray(DVec2::new(2.0 * x / width as f64 - 1.0, 1.0 - 2.0 * y / height as f64), aspect)
        };
        let count = width * height;
        let mut frame = Frame {
            width,
            height,
            radiance: Vec::with_capacity(count),
            depth_view_m: Vec::with_capacity(count),
            position_world: Vec::with_capacity(count),
            normal_world: Vec::with_capacity(count),
            object_id: Vec::with_capacity(count),
        };
        let n = options.samples_per_axis.max(1);
        for i in 0..count {
            let (x, y) = ((i % width) as f64, (i / width) as f64);
            let mut sum = DVec3::ZERO;
            for sample in 0..n * n {
                let offset = |index: u32| (f64::from(index) + 0.5) / f64::from(n);
                let (origin_world, direction_world) = ray(x + offset(sample % n), y + offset(sample / n));
                if let Some(hit) = self.nearest_hit(origin_world, direction_world) {
                    sum += self.radiance(&hit, -direction_world, &albedos, options);
                }
            }
            frame.radiance.push(as_rgb(sum / f64::from(n * n)));
            let (origin_world, direction_world) = ray(x + 0.5, y + 0.5);
            let hit = self.nearest_hit(origin_world, direction_world);
            let forward_world = self.camera.world_from_view * DVec3::NEG_Z;
            let depth = |hit: &Hit| (hit.position_world - self.camera.position_world).dot(forward_world);
            frame.depth_view_m.push(hit.as_ref().map_or(f64::INFINITY, depth));
            frame.position_world.push(hit.map_or(DVec3::ZERO, |hit| hit.position_world));
            frame.normal_world.push(hit.map_or(DVec3::ZERO, |hit| hit.normal_world));
            frame.object_id.push(hit.map_or(0, |hit| hit.object as u32 + 1));
        }
        frame
    }
}

impl Shape {
    /// The distance to the shape in metres and its normal on the side of the ray's origin.
    fn intersect(&self, origin_world: DVec3, direction_world: DVec3) -> Option<(f64, DVec3)> {
        match *self {
            Shape::Sphere { center_world, radius_m } => {
                let offset = origin_world - center_world;
                let half_b = offset.dot(direction_world);
                // The closest approach rather than b² − 4ac, which cancels for small, distant spheres.
                let closest = offset - half_b * direction_world;
                let discriminant = radius_m * radius_m - closest.length_squared();
                if discriminant < 0.0 {
                    return None;
                }
                let distance_m = -half_b - discriminant.sqrt();
                let normal = (offset + distance_m * direction_world) / radius_m;
                (distance_m > 0.0).then_some((distance_m, normal))
            }
            Shape::Quad { center_world, half_u_world, half_v_world } => {
                let normal = half_u_world.cross(half_v_world).normalize();
                let cos = normal.dot(direction_world);
                let distance_m = normal.dot(center_world - origin_world) / cos;
                if !distance_m.is_finite() || distance_m <= 0.0 {
                    return None;
                }
                let offset = origin_world + distance_m * direction_world - center_world;
                let u = offset.dot(half_u_world) / half_u_world.length_squared();
                let v = offset.dot(half_v_world) / half_v_world.length_squared();
                (u.abs() <= 1.0 && v.abs() <= 1.0).then_some((distance_m, if cos > 0.0 { -normal } else { normal }))
            }
        }
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
