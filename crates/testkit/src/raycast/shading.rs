//! The radiance along a ray: surfaces in the light of all lights, and fog before them.

use super::lights::stratified;
use super::random::Random;
use super::{AlbedoTable, Light, Medium, Options, Surface, World};
use glam::DVec3;
use std::collections::BTreeMap;

/// Directional albedos by roughness.
#[derive(Debug, Default)]
pub(super) struct Albedos {
    /// By the bits of α, of surfaces whose roughness is one.
    exact: BTreeMap<u64, AlbedoTable>,
    /// By perceptual roughness in equal steps from 0 to 1; empty where nothing has a texture of it.
    steps: Vec<AlbedoTable>,
}

/// Steps of perceptual roughness between which albedos are interpolated.
const ROUGHNESS_STEPS: u32 = 32;

impl Albedos {
    /// Of all surfaces of a world.
    pub fn new(world: &World) -> Self {
        let mut albedos = Self::default();
        let of_materials = world.meshes.materials.iter().map(|material| material.constant_roughness());
        let of_objects = world.objects.iter().map(|object| Some(object.surface.roughness_perceptual));
        for roughness in of_objects.chain(of_materials) {
            match roughness {
                Some(roughness) => {
                    let alpha = with_roughness(roughness).roughness_alpha();
                    albedos.exact.entry(alpha.to_bits()).or_insert_with(|| AlbedoTable::new(alpha));
                }
                None if albedos.steps.is_empty() => {
                    let step = |i| {
                        AlbedoTable::new(with_roughness(f64::from(i) / f64::from(ROUGHNESS_STEPS)).roughness_alpha())
                    };
                    albedos.steps = (0..=ROUGHNESS_STEPS).map(step).collect();
                }
                None => {}
            }
        }
        albedos
    }

    fn get(&self, surface: &Surface, n_dot_v: f64) -> f64 {
        if let Some(table) = self.exact.get(&surface.roughness_alpha().to_bits()) {
            return table.get(n_dot_v);
        }
        let place = surface.roughness_perceptual * f64::from(ROUGHNESS_STEPS);
        let below = (place as usize).min(ROUGHNESS_STEPS as usize - 1);
        match self.steps.get(below).zip(self.steps.get(below + 1)) {
            Some((below_table, above_table)) => {
                let share = place - below as f64;
                below_table.get(n_dot_v) * (1.0 - share) + above_table.get(n_dot_v) * share
            }
            None => 1.0,
        }
    }
}

fn with_roughness(roughness_perceptual: f64) -> Surface {
    Surface { base_color: DVec3::ZERO, metallic: 0.0, roughness_perceptual, emission: DVec3::ZERO }
}

/// A place to be lit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub position_world: DVec3,
    /// The unit normal on the side of the viewer.
    pub normal_world: DVec3,
    /// The triangle that it lies on.
    pub triangle: Option<u32>,
}

/// What chooses the sequence of a ray's random numbers: pixel and ray.
pub(super) type Sequence = [u64; 2];

impl World {
    /// The share of a light's source that is seen from `place`.
    fn visibility(&self, place: &Place, light: &Light, options: Options, sequence: &[u64]) -> f64 {
        if !(options.shadows && light.casts_shadows) {
            return 1.0;
        }
        let towards = |source: Option<[f64; 2]>| {
            let (to_light, distance_m) = light.source_seen_from(place.position_world, source);
            self.passing(place, to_light, distance_m, &light.glows_around)
        };
        if options.light_samples_per_axis == 0 || !light.has_size() {
            return towards(None);
        }
        let places = stratified(options.light_samples_per_axis, Random::new(options.seed, sequence));
        let sum: f64 = places.map(|source| towards(Some(source))).sum();
        sum / f64::from(options.light_samples_per_axis.pow(2))
    }

    /// The share of a light's source that is seen from a place in free space, or on a surface.
    pub fn visibility_at(&self, light: usize, position_world: DVec3, options: Options) -> f64 {
        let place = Place { position_world, normal_world: DVec3::ZERO, triangle: None };
        let options = Options { shadows: true, ..options };
        self.lights.get(light).map_or(0.0, |light| self.visibility(&place, light, options, &[]))
    }

    /// The share of light that gets from a place to another, `distance_m` away.
    fn passing(&self, place: &Place, direction_world: DVec3, distance_m: f64, glows_around: &[usize]) -> f64 {
        // A micrometre is far above the rounding of f64 at these distances and far below what a picture shows.
        let origin_world = place.position_world + 1e-6 * place.normal_world;
        let is_blocked = self.objects.iter().any(|object| {
            object.shape.intersect(origin_world, direction_world).is_some_and(|(at_m, _)| at_m < distance_m)
        });
        if is_blocked {
            return 0.0;
        }
        self.meshes.transmittance((place.position_world, place.triangle), (direction_world, distance_m), glows_around)
    }

    /// The radiance from a surface towards `to_viewer`, a unit vector.
    pub(super) fn radiance(
        &self,
        place: &Place,
        surface: &Surface,
        to_viewer: DVec3,
        albedos: &Albedos,
        (options, sequence): (Options, Sequence),
    ) -> DVec3 {
        let normal = place.normal_world;
        let compensation = match options.multiple_scattering {
            true => surface.compensation(albedos.get(surface, normal.dot(to_viewer))),
            false => DVec3::ONE,
        };
        let mut radiance = surface.emission;
        for (index, light) in self.lights.iter().enumerate() {
            if light.is_out_of_range(place.position_world) {
                continue;
            }
            let (to_light, distance_m, irradiance) = light.arriving_at(place.position_world);
            let n_dot_l = normal.dot(to_light);
            if n_dot_l <= 0.0 || irradiance == DVec3::ZERO {
                continue;
            }
            let sequence = [sequence[0], sequence[1], index as u64];
            let visibility = self.visibility(place, light, options, &sequence);
            if visibility > 0.0 {
                let dimming =
                    self.medium.map_or(1.0, |medium| medium.dimming(place.position_world, to_light, distance_m));
                radiance += surface.brdf(normal, to_viewer, to_light, compensation)
                    * irradiance
                    * (n_dot_l * visibility * dimming);
            }
        }
        radiance
    }

    /// The light that fog scatters once into a ray of `length_m`; `left_at` is the share of it that surfaces leave
    /// uncovered before a distance.
    pub(super) fn scattered(
        &self,
        medium: &Medium,
        ray: (DVec3, DVec3, f64),
        left_at: impl Fn(f64) -> f64,
        (options, sequence): (Options, Sequence),
    ) -> DVec3 {
        let (origin_world, direction_world, _) = ray;
        let mut radiance = DVec3::ZERO;
        for (index, light) in self.lights.iter().enumerate() {
            let random = Random::new(options.seed, &[sequence[0], sequence[1], index as u64, 1]);
            for (step, event) in medium.events(light, ray, options.medium_steps, random).into_iter().enumerate() {
                let position_world = origin_world + event.distance_m * direction_world;
                let (to_light, distance_m, irradiance) = light.arriving_at(position_world);
                if irradiance == DVec3::ZERO || !irradiance.is_finite() {
                    continue;
                }
                let place = Place { position_world, normal_world: DVec3::ZERO, triangle: None };
                let sequence = [sequence[0], sequence[1], index as u64, 2 + step as u64];
                let weight = event.length_m
                    * left_at(event.distance_m)
                    * medium.transmittance(origin_world, direction_world, event.distance_m)
                    * medium.phase(to_light.dot(direction_world).clamp(-1.0, 1.0))
                    * medium.dimming(position_world, to_light, distance_m);
                if weight > 0.0 {
                    let visibility = self.visibility(&place, light, options, &sequence);
                    radiance += medium.scattering(position_world) * irradiance * (weight * visibility);
                }
            }
        }
        radiance
    }
}
