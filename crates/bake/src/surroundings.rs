//! Pictures of what is to be seen around places, by paths.

use crate::BakeError;
use crate::emitters::{DistantLight, Emitters};
use crate::encode::{Encoding, light_file};
use crate::light_map::check_rays;
use crate::paths::{Draw, Paths};
use crate::progress::{Progress, Stage};
use crate::sampling::hash2;
use crate::surfaces::Surfaces;
use crate::tracing::{Tracer, beside};
use crate::work::{BLOCK, Keeper, keep_blocks};
use glam::Vec3;
use half::f16;
use manypass_scene::environment::{RADIANCE_MAX, equirectangular_direction_within};
use manypass_scene::surroundings::Surroundings;
use manypass_scene::{EnvironmentMap, Scene};
use std::hash::{DefaultHasher, Hasher as _};

/// Rises whenever the same scene and settings have other pictures.
const VERSION: u32 = 1;

/// The round of the first, as keepers number them; others are below it.
const ROUND_OF_SURROUNDINGS: u32 = u32::MAX - 16;

/// Width and height of a picture in texels: about as fine as what frames capture.
const SIZE: (u32, u32) = (512, 256);

/// How well pictures are found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurroundingsSettings {
    /// Rays through a texel.
    pub samples: u32,
    /// How often light is sent back, as in light maps: what is seen shows light that was sent back so often before.
    pub bounces: u32,
}

impl Default for SurroundingsSettings {
    fn default() -> Self {
        Self { samples: 64, bounces: 3 }
    }
}

/// So many surfaces in a row that are not to be seen are passed.
const PASSED_MAX: u32 = 64;

/// What stays of a scene while pictures of it are baked.
pub struct SurroundingsBaker<'a> {
    settings: SurroundingsSettings,
    surfaces: &'a Surfaces,
    emitters: Emitters<'a>,
    places: Vec<Surroundings>,
}

impl<'a> SurroundingsBaker<'a> {
    /// For places of a scene. `around` is what is seen where nothing of the scene is.
    ///
    /// # Errors
    /// Settings are out of range.
    pub fn new(
        scene: &Scene,
        surfaces: &'a Surfaces,
        around: Option<&'a dyn DistantLight>,
        places: Vec<Surroundings>,
        settings: &SurroundingsSettings,
    ) -> Result<Self, BakeError> {
        let SurroundingsSettings { samples, bounces } = *settings;
        check_rays((samples, "through a texel"), bounces)?;
        Ok(Self { settings: *settings, surfaces, emitters: Emitters::new(scene, surfaces, around), places })
    }

    /// A number that is another one for another scene, other places or settings, or another version of this crate.
    pub fn key(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        hasher.write(env!("CARGO_PKG_VERSION").as_bytes());
        hasher.write_u32(VERSION);
        hasher.write(format!("{:?}", self.settings).as_bytes());
        for Surroundings { name, position_world, region, fade_m, walls, layers, .. } in &self.places {
            hasher.write(format!("{name:?} {position_world:?} {region:?} {fade_m:?} {walls:?} {layers}").as_bytes());
        }
        self.surfaces.hash_into(&mut hasher);
        self.emitters.hash_into(&mut hasher);
        hasher.finish()
    }

    /// Finds all pictures. What `keeper` knows is not computed again.
    ///
    /// # Errors
    /// `progress` says to stop.
    pub fn run(self, progress: &dyn Progress, keeper: &dyn Keeper) -> Result<Vec<Surroundings>, BakeError> {
        let tracer = Tracer::new(self.surfaces);
        let bounces = self.settings.bounces.saturating_add(1);
        let paths = Paths { surfaces: self.surfaces, tracer: &tracer, emitters: &self.emitters, bounces };
        let count = (SIZE.0 * SIZE.1) as usize;
        let mut baked = Vec::new();
        for (number, of) in self.places.iter().enumerate() {
            let mut texels = vec![[f16::ZERO; 4]; count];
            let keeper = (keeper, ROUND_OF_SURROUNDINGS - number as u32);
            let find = |index: usize| self.texel(&paths, of, index as u32).to_array();
            let blocks = texels.chunks_mut(BLOCK);
            keep_blocks(blocks, (BLOCK, count), (progress, Stage::Surroundings), keeper, find, |texels, values| {
                for (texel, [r, g, b]) in texels.iter_mut().zip(values) {
                    let [r, g, b] = [r, g, b].map(|value| f16::from_f32(value.clamp(0.0, RADIANCE_MAX)));
                    *texel = [r, g, b, f16::ONE];
                }
            })?;
            let picture = EnvironmentMap { texels, ..EnvironmentMap::from_fn(&of.name, SIZE.0, 0, |_| Vec3::ZERO) };
            let picture = EnvironmentMap { height: SIZE.1, ..picture };
            baked.push(Surroundings { picture: Some(picture.into()), ..of.clone() });
        }
        Ok(baked)
    }

    /// Where a ray begins that passes what is in no layer that is seen.
    fn beyond_hidden(&self, paths: &Paths, of: &Surroundings, direction: Vec3) -> Vec3 {
        let mut from = of.position_world;
        for _ in 0..PASSED_MAX {
            let Some(hit) = paths.tracer.first(from, direction) else { break };
            let (placed, _) = self.surfaces.triangle(hit.spot.triangle);
            if placed.layers & of.layers != 0 {
                break;
            }
            let (position, facet, _) = self.surfaces.geometry(hit.spot);
            from = beside(position, if hit.is_behind { facet } else { -facet });
        }
        from
    }

    /// The mean radiance through a texel.
    fn texel(&self, paths: &Paths, of: &Surroundings, index: u32) -> Vec3 {
        let (x, y) = (index % SIZE.0, index / SIZE.0);
        let (seed, mut sum) = (hash2(index, 99), Vec3::ZERO);
        for sample in 0..self.settings.samples {
            let draw = Draw { sample, seed };
            let within = draw.point(0);
            let at = (x as f32 + within.x, y as f32 + within.y);
            let direction = equirectangular_direction_within(at, SIZE);
            // What shines is met by these rays alone, so that it counts as a whole.
            let from = self.beyond_hidden(paths, of, direction);
            let brought = paths.along(from, direction, 1.0, draw);
            let radiance = brought.sent_back + brought.made;
            sum += if radiance.is_finite() { radiance } else { Vec3::ZERO };
        }
        sum / self.settings.samples as f32
    }
}

/// A picture as an OpenEXR file.
///
/// # Errors
/// The encoder fails.
pub fn picture_file(picture: &EnvironmentMap) -> Result<Vec<u8>, BakeError> {
    let texels: Vec<[f32; 3]> =
        picture.texels.iter().map(|[r, g, b, _]| [r, g, b].map(|value| value.to_f32())).collect();
    Ok(light_file(Encoding::Exr, &texels, (picture.width, picture.height))?.bytes)
}
