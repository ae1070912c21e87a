//! The sky of the Earth, from the sun, air with haze, and ground: a picture of the environment that is computed.
//!
//! Source: Hillaire 2020, "A Scalable and Production Ready Sky and Atmosphere Rendering Technique": single scattering
//! along every ray, and the light of all further scatterings from a small table. Where it differs: the picture is made
//! once, on the CPU, and holds all directions; what air and haze scatter is kept apart from their phases, so that the
//! glow around the sun is as sharp as the picture; the ground, a plain of one colour, is lit by the sky as well; and
//! haze is given as turbidity.

mod air;
mod tables;

use crate::{EnvironmentLayout, EnvironmentLight, EnvironmentMap};
use air::{Air, GROUND_KM, Ray, phases};
use glam::{DVec3, Vec3};
use half::f16;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use tables::{InScattering, Tables};

/// What 1 in the picture stands for, in cd/m² (and of illuminance in lux): surfaces in full daylight are then as bright
/// as they are to be shown.
pub const SKY_UNIT_NIT: f32 = 32_768.0;

/// Sunlight above the air, in lux.
pub const SUN_LUX: f64 = 128_000.0;

/// Half the angle that the sun takes in the sky, in degrees.
const SUN_RADIUS_DEG: f64 = 0.2667;

/// Width and height of the picture.
const SIZE: (u32, u32) = (1024, 512);

/// How high the eye is, in km.
const EYE_KM: f64 = 0.002;

/// Directions around, from towards the sun to away from it, in which rays are followed; and steps of a ray.
const DIRECTIONS: usize = 25;
const STEPS: u32 = 40;

/// The parameters of a procedural sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// The angle of the sun above the horizon, in degrees; below 0 it has set.
    pub sun_elevation_deg: f32,
    /// Where it stands, in degrees: 0 is +Z, and it grows towards +X, as the yaw of an orbit does.
    pub sun_azimuth_deg: f32,
    /// The optical depth of air and haze straight up, divided by that of the air alone: 1 is air without haze, 2 a
    /// clear day, 6 haze (Preetham, Shirley & Smits 1999).
    pub turbidity: f32,
    /// The share of light that the ground reflects.
    pub ground_albedo: f32,
}

impl Default for Sky {
    fn default() -> Self {
        Self { sun_elevation_deg: 40.0, sun_azimuth_deg: -45.0, turbidity: 2.0, ground_albedo: 0.3 }
    }
}

impl Sky {
    /// The picture, in units of [`SKY_UNIT_NIT`], without the sun, which is its light.
    pub fn map(&self) -> EnvironmentMap {
        let albedo = DVec3::splat(f64::from(self.ground_albedo));
        let tables = Tables::new(Air::new(f64::from(self.turbidity)), albedo);
        let sun = self.sun_direction();
        let (sun_sine, sun_cosine) = f64::from(self.sun_elevation_deg).to_radians().sin_cos();
        let sunlight = SUN_LUX / f64::from(SKY_UNIT_NIT);
        let (width, height) = SIZE;
        let columns = columns(width, f64::from(sun.z.atan2(sun.x)));
        // The sun's light on the ground, and from the first row below the horizon on that of the sky.
        let mut irradiance =
            tables.sunlight(GROUND_KM, sun_sine) * (sunlight * self.visible_share() * sun_sine.max(0.0));
        let mut texels = Vec::with_capacity(width as usize * height as usize);
        for y in 0..height {
            let edge = |row: u32| (PI * f64::from(row) / f64::from(height)).cos();
            let (sine, cosine) = (FRAC_PI_2 - PI * (f64::from(y) + 0.5) / f64::from(height)).sin_cos();
            let to_sun = |around: f64| sine * sun_sine + cosine * sun_cosine * around.cos();
            let ray = Ray { radius_km: GROUND_KM + EYE_KM, cosine: sine };
            let around = |i: usize| PI * i as f64 / (DIRECTIONS - 1) as f64;
            let nodes: [InScattering; DIRECTIONS] =
                std::array::from_fn(|i| tables.scattered(ray, sun_sine, to_sun(around(i)), STEPS));
            let ground = if ray.meets_ground() { irradiance * albedo / PI } else { DVec3::ZERO };
            let mut sum = DVec3::ZERO;
            for column in &columns {
                let InScattering { rayleigh, mie, multiple, transmittance } =
                    nodes[column.node].lerp(&nodes[column.node + 1], column.share);
                let [of_air, of_haze] = phases(to_sun(column.around));
                let radiance = (rayleigh * of_air + mie * of_haze + multiple) * sunlight + transmittance * ground;
                sum += radiance;
                let [r, g, b] = radiance.to_array().map(f16::from_f64);
                texels.push([r, g, b, f16::ONE]);
            }
            if sine > 0.0 {
                irradiance += sum * (sine * TAU / f64::from(width) * (edge(y) - edge(y + 1)));
            }
        }
        EnvironmentMap {
            name: "sky".into(),
            layout: EnvironmentLayout::Equirectangular,
            width,
            height,
            texels,
            peaks: Vec::new(),
            prefiltered: None,
            irradiance: None,
            light: self.sun(&tables),
            notes: Vec::new(),
        }
    }

    fn sun_direction(&self) -> Vec3 {
        let (elevation, azimuth) = (self.sun_elevation_deg.to_radians(), self.sun_azimuth_deg.to_radians());
        Vec3::new(elevation.cos() * azimuth.sin(), elevation.sin(), elevation.cos() * azimuth.cos())
    }

    /// The share of the sun that is above the horizon: a part of a disc.
    fn visible_share(&self) -> f64 {
        let height = (f64::from(self.sun_elevation_deg) / SUN_RADIUS_DEG).clamp(-1.0, 1.0);
        0.5 + (height * (1.0 - height * height).sqrt() + height.asin()) / PI
    }

    /// Through the air; none once it has set.
    fn sun(&self, tables: &Tables) -> Option<EnvironmentLight> {
        // Its middle may be a little below the horizon, from where no light comes.
        let elevation = f64::from(self.sun_elevation_deg).max(0.0).to_radians();
        let above = tables.sunlight(GROUND_KM, elevation.sin());
        let irradiance = above * (SUN_LUX / f64::from(SKY_UNIT_NIT) * self.visible_share());
        (self.visible_share() > 0.0).then(|| EnvironmentLight {
            direction: self.sun_direction(),
            irradiance: irradiance.as_vec3(),
            half_angle_tan: SUN_RADIUS_DEG.to_radians().tan() as f32,
        })
    }
}

/// Where a column of the picture lies: the angle from the sun around, and between which directions.
struct Column {
    around: f64,
    node: usize,
    share: f64,
}

fn columns(width: u32, sun: f64) -> Vec<Column> {
    let column = |x: u32| {
        let from_sun = TAU * ((f64::from(x) + 0.5) / f64::from(width) - 0.5) - sun;
        let around = from_sun.cos().clamp(-1.0, 1.0).acos();
        let place = around / PI * (DIRECTIONS - 1) as f64;
        let node = (place as usize).min(DIRECTIONS - 2);
        Column { around, node, share: place - node as f64 }
    };
    (0..width).map(column).collect()
}
