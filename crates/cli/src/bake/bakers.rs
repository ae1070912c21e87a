//! What is baked: maps, probes, or both.

use crate::args::bake::BakeArgs;
use crate::failure::Failure;
use glam::Vec3;
use manypass_bake::{
    BakeError, BakeSettings, BakedMaps, Baker, DistantLight, Keeper, LayoutSettings, ProbeBaker, ProbeSettings,
    Progress, SAMPLES_MAX, Surfaces, SurroundingsBaker, SurroundingsSettings,
};
use manypass_scene::probes::{ProbeBasis, ProbeGrid};
use manypass_scene::surroundings::{Region, SURROUNDINGS_MAX, Surroundings};
use manypass_scene::{Scene, Stage};
use std::hash::{DefaultHasher, Hasher as _};

/// Rays from a probe for each of those of a texel: it looks all around.
const RAYS_OF_PROBE: u32 = 4;

/// And for each of those through a texel of what is to be seen around a place, whose neighbours are blurred together where
/// surfaces are rough.
const RAYS_FOR_PICTURES: u32 = 4;

/// What the flags ask for.
#[derive(Clone, Debug)]
pub struct BakeRequest {
    /// Maps, if there are to be any.
    pub maps: Option<BakeSettings>,
    /// Probes, and in which basis.
    pub probes: Option<(ProbeSettings, Option<ProbeBasis>)>,
    /// What is to be seen around places; whether a place is made where the scene has none.
    pub surroundings: Option<(SurroundingsSettings, bool)>,
}

impl BakeRequest {
    /// Of flags.
    ///
    /// # Errors
    /// They ask for two things that exclude each other.
    pub fn new(args: &BakeArgs) -> Result<Self, Failure> {
        let is_named = |names: &[&str]| args.what.iter().any(|what| names.contains(&what.as_str()));
        let as_emission = is_named(&["emission"]);
        if as_emission && is_named(&["lightmap", "all"]) {
            let message = "light is baked as light maps or as emission, not as both";
            return Err(Failure::usage(message, "write --what emission, or --what emission,occlusion"));
        }
        if as_emission && args.lights.is_some() {
            return Err(Failure::usage("as emission all lamps are baked", "leave --lights out"));
        }
        if args.directional && !is_named(&["lightmap", "all"]) {
            let message = "--directional is for light maps, which are not baked";
            return Err(Failure::usage(message, "add --what lightmap, or leave --directional out"));
        }
        let has_cubes = is_named(&["ambient-cubes"]);
        if has_cubes && is_named(&["probes", "all"]) {
            let message = "the light of probes is baked as spherical harmonics or as ambient cubes, not as both";
            return Err(Failure::usage(message, "write --what probes, or --what ambient-cubes"));
        }
        let maps = BakeSettings {
            layout: LayoutSettings { texels_per_m: args.density, side_max: args.side_max, padding: args.padding },
            light: as_emission || is_named(&["lightmap", "all"]),
            as_emission,
            occlusion: is_named(&["occlusion", "all"]),
            directional: args.directional,
            samples: args.samples,
            bounces: args.bounces,
            denoise: !args.no_denoise,
            occlusion_distance_m: args.occlusion_distance,
        };
        let samples = args.samples.saturating_mul(RAYS_OF_PROBE).min(SAMPLES_MAX.max(args.samples));
        let probes = ProbeSettings { samples, bounces: args.bounces };
        let samples = args.samples.div_ceil(RAYS_FOR_PICTURES);
        let pictures = SurroundingsSettings { samples, bounces: args.bounces };
        let has_probes = has_cubes || is_named(&["probes", "all"]);
        if args.probe_spacing.is_some() && !has_probes {
            return Err(Failure::usage("--probe-spacing is for probes, which are not baked", "add --what probes"));
        }
        Ok(Self {
            maps: (maps.light || maps.occlusion).then_some(maps),
            probes: has_probes.then_some((probes, has_cubes.then_some(ProbeBasis::AmbientCube))),
            surroundings: is_named(&["reflection", "all"]).then_some((pictures, is_named(&["reflection"]))),
        })
    }

    /// Whether maps are what surfaces send out.
    pub fn as_emission(&self) -> bool {
        self.maps.is_some_and(|maps| maps.as_emission)
    }

    /// The grids of a scene without their light: those that a stage or the file has, else one over all of it.
    ///
    /// # Errors
    /// There would be too many probes.
    pub fn grids(&self, scene: &Scene, stage: Option<&Stage>, args: &BakeArgs) -> Result<Vec<ProbeGrid>, Failure> {
        let Some((_, basis)) = self.probes else { return Ok(Vec::new()) };
        let mut grids = scene.probes.clone();
        if args.probe_spacing.is_some() && stage.is_some_and(Stage::has_probes) {
            let message = "--probe-spacing says another distance than [[probes]] of the stage";
            return Err(Failure::usage(message, "change spacing_m there, and leave the flag out"));
        }
        if grids.is_empty() || args.probe_spacing.is_some() {
            let grid = ProbeGrid::over("probes", &scene.bounds_world(), args.probe_spacing);
            let hint = "give --probe-spacing another distance, or say with [[probes]] of a stage where they are needed";
            grids = vec![grid.map_err(|error| Failure::usage(error, hint))?];
        }
        for grid in &mut grids {
            (grid.probes, grid.live) = (None, None);
            grid.basis = basis.unwrap_or(grid.basis);
        }
        Ok(grids)
    }
}

impl BakeRequest {
    /// Draws near the origin what lies far from it for its size, if only maps are baked: these lie on surfaces, and all
    /// else is written with its place in the file's space.
    pub fn bring_near(&self, scene: &mut Scene) {
        if self.probes.is_none() && self.surroundings.is_none() {
            scene.bring_near();
        }
    }

    /// The surroundings of a scene without their pictures: those that a stage or the file has, else, where they are asked for,
    /// a room that the whole scene is.
    pub fn places(&self, scene: &Scene) -> Vec<Surroundings> {
        let Some((_, makes_one)) = self.surroundings else { return Vec::new() };
        let mut places: Vec<Surroundings> = scene.surroundings.iter().take(SURROUNDINGS_MAX).cloned().collect();
        let bounds = scene.bounds_world();
        if places.is_empty() && makes_one && !bounds.is_empty() {
            let half_m = (0.5 * (bounds.max - bounds.min)).max(Vec3::splat(1e-3));
            places.push(Surroundings::of_room("room", Region { center_world: bounds.center(), half_m }));
        }
        places.iter_mut().for_each(|place| place.picture = None);
        places
    }
}

/// What stays of a scene while it is baked.
pub struct Bakers<'a> {
    maps: Option<Baker<'a>>,
    probes: Option<ProbeBaker<'a>>,
    surroundings: Option<SurroundingsBaker<'a>>,
}

/// What was found.
pub struct BakeResults {
    /// Maps, if they were asked for.
    pub maps: Option<BakedMaps>,
    /// Grids of probes.
    pub grids: Vec<ProbeGrid>,
    /// Places with pictures of what is to be seen around them.
    pub places: Vec<Surroundings>,
}

impl<'a> Bakers<'a> {
    /// Of a scene.
    ///
    /// # Errors
    /// As those of [`Baker::new`] and [`ProbeBaker::new`].
    pub fn new(
        scene: &Scene,
        surfaces: &'a Surfaces,
        around: Option<&'a dyn DistantLight>,
        (wanted, grids, places): (&BakeRequest, Vec<ProbeGrid>, Vec<Surroundings>),
        progress: &dyn Progress,
    ) -> Result<Self, BakeError> {
        let maps = wanted.maps.map(|maps| Baker::new(scene, surfaces, around, &maps, progress)).transpose()?;
        let probes = wanted.probes.map(|(probes, _)| ProbeBaker::new(scene, surfaces, around, grids, &probes));
        let of_places = wanted.surroundings.filter(|_| !places.is_empty());
        let surroundings =
            of_places.map(|(settings, _)| SurroundingsBaker::new(scene, surfaces, around, places, &settings));
        Ok(Self { maps, probes: probes.transpose()?, surroundings: surroundings.transpose()? })
    }

    /// A number that is another one for another scene or other settings.
    pub fn key(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        hasher.write_u64(self.maps.as_ref().map_or(0, Baker::key));
        hasher.write_u64(self.probes.as_ref().map_or(0, ProbeBaker::key));
        hasher.write_u64(self.surroundings.as_ref().map_or(0, SurroundingsBaker::key));
        hasher.finish()
    }

    /// Finds all that is asked for.
    ///
    /// # Errors
    /// `progress` says to stop.
    pub fn run(self, progress: &dyn Progress, keeper: &dyn Keeper) -> Result<BakeResults, BakeError> {
        let maps = self.maps.map(|maps| maps.run(progress, keeper)).transpose()?;
        let grids = self.probes.map(|probes| probes.run(progress, keeper)).transpose()?;
        let places = self.surroundings.map(|places| places.run(progress, keeper)).transpose()?;
        Ok(BakeResults { maps, grids: grids.unwrap_or_default(), places: places.unwrap_or_default() })
    }
}
