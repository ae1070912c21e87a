//! Probes: the light that arrives at places in a scene, for the surfaces between them.
//!
//! ```
//! # use manypass_scene::probes::ProbeGrid;
//! # use manypass_scene::Aabb;
//! # use glam::Vec3;
//! let room = Aabb { min: Vec3::ZERO, max: Vec3::new(8.0, 3.0, 4.0) };
//! let grid = ProbeGrid::over("room", &room, Some(0.5)).unwrap();
//! assert_eq!(grid.counts, [17, 7, 9]);
//! assert!((grid.place(0) - Vec3::splat(0.06)).length() < 0.01);
//! ```

mod harmonics;

pub use harmonics::{AmbientCube, Harmonics, harmonics};

use crate::Aabb;
use crate::capture::LAYERS_ALL;
use crate::surroundings::Region;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;
use std::sync::Arc;

/// The most probes of a grid.
pub const PROBES_MAX: usize = 16_384;

/// The most probes along an axis.
pub const PROBES_ALONG_MAX: u32 = 128;

/// The most grids of a scene that are drawn.
pub const GRIDS_MAX: usize = 4;

/// The most bounces of a grid whose light frames find.
pub const LIVE_BOUNCES_MAX: u32 = 8;

/// The outermost probes of a grid stand so far within the faces of its box, as a share of the distance between probes: faces
/// are often walls.
const INSET: f32 = 0.125;

/// How many probes a grid has about where nobody says.
const PROBES_USUAL: f32 = 2048.0;

/// The side of the octahedral map of the distances that a probe sees, in texels.
pub const DISTANCE_SIDE: usize = 12;

/// The direction of the middle of a texel of that map (Cigolle et al. 2014, "A Survey of Efficient Representations for
/// Independent Unit Vectors"), by its number: rows begin at (−1, −1).
pub fn distance_direction(texel: usize) -> Vec3 {
    let place = |at: usize| (2 * at + 1) as f32 / DISTANCE_SIDE as f32 - 1.0;
    let (x, y) = (place(texel % DISTANCE_SIDE), place(texel / DISTANCE_SIDE));
    let z = 1.0 - x.abs() - y.abs();
    let turned = |a: f32, b: f32| if z < 0.0 { (1.0 - b.abs()).copysign(a) } else { a };
    Vec3::new(turned(x, y), turned(y, x), z).normalize()
}

/// As what the light of probes is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ProbeBasis {
    /// Spherical harmonics of order 2.
    #[default]
    Harmonics,
    /// Six colours.
    AmbientCube,
}

/// The strongest small source of a probe's light. Harmonics of order 2 light what such a source shines along by a tenth of
/// its irradiance, and what faces it by 6 % too much; known for itself it lights by the cosine (Sloan 2008, "Stupid Spherical
/// Harmonics (SH) Tricks", takes the dominant light out of them).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SmallSource {
    /// Where it is, of length 1; zero if there is none.
    pub direction: Vec3,
    /// Its irradiance across that direction.
    pub irradiance: Vec3,
    /// The sine of half the angle that it takes: so far beyond a surface's horizon it still gives light.
    pub spread: f32,
}

impl SmallSource {
    /// What a white surface with a unit normal sends back of it: irradiance divided by π, of a disc of which the horizon leaves
    /// a part.
    pub fn sent_back(&self, normal: Vec3) -> Vec3 {
        let cosine = self.direction.dot(normal);
        let spread = self.spread.max(1e-6);
        let above = (cosine + spread).max(0.0);
        let share = if cosine < spread { above * above / (4.0 * spread) } else { cosine };
        self.irradiance * (share / PI)
    }
}

/// The light that arrives at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProbeLight {
    /// Radiance, with a window if it needs one, without the light of one small source, which is known for itself.
    Harmonics(Harmonics, SmallSource),
    /// Irradiance divided by π.
    AmbientCube(AmbientCube),
}

impl Default for ProbeLight {
    fn default() -> Self {
        Self::Harmonics(Harmonics::default(), SmallSource::default())
    }
}

impl ProbeLight {
    /// What arrives, of a small source and of all else, in a basis: it is windowed there.
    pub fn new(light: &Harmonics, source: SmallSource, basis: ProbeBasis) -> Self {
        match basis {
            ProbeBasis::Harmonics => Self::Harmonics(light.windowed(), source),
            ProbeBasis::AmbientCube => {
                let mut all = *light;
                all.add(source.direction, source.irradiance);
                Self::AmbientCube(AmbientCube::of(&all))
            }
        }
    }

    /// Irradiance divided by π on a surface with a unit normal.
    pub fn irradiance(&self, normal: Vec3) -> Vec3 {
        match self {
            Self::Harmonics(light, source) => light.irradiance(normal) + source.sent_back(normal),
            Self::AmbientCube(light) => light.irradiance(normal),
        }
    }

    /// Its small source, if it may have one.
    pub fn source(&self) -> SmallSource {
        match self {
            Self::Harmonics(_, source) => *source,
            Self::AmbientCube(_) => SmallSource::default(),
        }
    }

    /// Its coefficients or colours.
    pub fn colors(&self) -> &[Vec3] {
        match self {
            Self::Harmonics(light, _) => &light.0,
            Self::AmbientCube(light) => &light.0,
        }
    }
}

/// What one probe knows.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// How far it was moved, in metres, because its place was inside something.
    pub offset_m: Vec3,
    /// Whether it has light; one inside something has not.
    pub is_on: bool,
    /// The light that arrives there.
    pub light: ProbeLight,
    /// How far surfaces are from it, in metres, and the square of that, as means over the directions of the texels of an
    /// octahedral map, whose rows begin at (−1, −1); [`ProbeGrid::distance_max_m`] where there is none nearer.
    pub distances: [Vec2; DISTANCE_SIDE * DISTANCE_SIDE],
}

impl Default for Probe {
    fn default() -> Self {
        let distances = [Vec2::ZERO; DISTANCE_SIDE * DISTANCE_SIDE];
        Self { offset_m: Vec3::ZERO, is_on: false, light: ProbeLight::default(), distances }
    }
}

/// Probes in a box, as far apart along each axis, and from its faces an eighth of that.
#[derive(Clone, Debug, PartialEq)]
pub struct ProbeGrid {
    /// Its name: by it a file's light is that of a stage's grid.
    pub name: String,
    /// The box of the surfaces that have their light.
    pub region: Region,
    /// How many there are along X, Y and Z.
    pub counts: [u32; 3],
    /// Over how many metres within the box's faces the environment takes over.
    pub fade_m: f32,
    /// As what frames read their light.
    pub basis: ProbeBasis,
    /// What they know, X first, then Y, then Z; none before it was found.
    pub probes: Option<Arc<Vec<Probe>>>,
    /// How frames find their light, anew when something moves. Of `probes` they have then the places, and the light to begin
    /// with. None where the light is that of `probes` alone.
    pub live: Option<LiveProbes>,
}

/// How frames find the light of a grid: they draw what is to be seen around each probe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LiveProbes {
    /// How often a still draws what is around each, each time in the light that was found before: so often lamps' light is sent
    /// back, and that of the environment once less. 1 to [`LIVE_BOUNCES_MAX`]. A live view goes on as long as something moves,
    /// and then so often.
    pub bounces: u32,
    /// The layers that are seen ([`crate::Node::layers`]), a bit each.
    pub layers: u32,
}

impl Default for LiveProbes {
    fn default() -> Self {
        Self { bounces: 3, layers: LAYERS_ALL }
    }
}

/// Why there is no such grid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GridError {
    /// The box has no extent.
    #[error("the box of the probes has no extent")]
    Flat,
    /// They are to be no distance apart.
    #[error("probes {0} m apart; write a distance above 0")]
    Spacing(f32),
    /// There are none, or too many.
    #[error(
        "{x} x {y} x {z} probes; a grid has 1 to {PROBES_MAX}, and at most {PROBES_ALONG_MAX} along each axis",
        x = counts[0], y = counts[1], z = counts[2]
    )]
    Count {
        /// How many there would be along each axis.
        counts: [u32; 3],
    },
}

impl ProbeBasis {
    /// The words for both.
    pub const NAMES: [&str; 2] = ["harmonics", "ambient-cube"];

    /// The one of a word.
    pub fn named(word: &str) -> Option<Self> {
        match word {
            "harmonics" => Some(Self::Harmonics),
            "ambient-cube" => Some(Self::AmbientCube),
            _ => None,
        }
    }

    /// Its word.
    pub fn name(self) -> &'static str {
        let [harmonics, cube] = Self::NAMES;
        if self == Self::Harmonics { harmonics } else { cube }
    }

    /// How many coefficients or colours there are.
    pub fn colors(self) -> usize {
        if self == Self::Harmonics { 9 } else { 6 }
    }
}

impl ProbeGrid {
    /// Of a box with so many probes along each axis.
    ///
    /// # Errors
    /// The box is none, or there are too many.
    pub fn new(name: impl Into<String>, region: Region, counts: [u32; 3]) -> Result<Self, GridError> {
        let largest = region.center_world.abs().max(region.half_m).max_element();
        if !(region.half_m.min_element() > 0.0 && region.center_world.is_finite() && largest < 1e9) {
            return Err(GridError::Flat);
        }
        let is_count = |count: &u32| (1..=PROBES_ALONG_MAX).contains(count);
        if !counts.iter().all(is_count) || counts.iter().product::<u32>() as usize > PROBES_MAX {
            return Err(GridError::Count { counts });
        }
        let (fade_m, basis) = (0.0, ProbeBasis::default());
        Ok(Self { name: name.into(), region, counts, fade_m, basis, probes: None, live: None })
    }

    /// Over a box that may be flat, with probes about so far apart; so far that there are some 2,000 where nobody says.
    ///
    /// # Errors
    /// The box is empty, or there are too many.
    pub fn over(name: impl Into<String>, bounds: &Aabb, spacing_m: Option<f32>) -> Result<Self, GridError> {
        if bounds.is_empty() {
            return Err(GridError::Flat);
        }
        if let Some(spacing_m) = spacing_m.filter(|spacing_m| !(spacing_m.is_finite() && *spacing_m > 0.0)) {
            return Err(GridError::Spacing(spacing_m));
        }
        let size_m = bounds.max - bounds.min;
        // What is flat is as thick as it needs to be.
        let least_m = 1e-3 * size_m.max_element().max(1e-3);
        let size_m = size_m.max(Vec3::splat(least_m));
        let region = Region { center_world: bounds.center(), half_m: 0.5 * size_m };
        let counts_at = |spacing_m: f32| {
            (size_m / spacing_m + 0.75).round().max(Vec3::ONE).to_array().map(|count| count.min(1e6) as u32)
        };
        let counts = match spacing_m {
            Some(spacing_m) => counts_at(spacing_m),
            None => {
                let mut spacing_m = (size_m.element_product() / PROBES_USUAL).cbrt().max(1e-6);
                let is_too_many = |counts: [u32; 3]| {
                    let all: f32 = counts.iter().map(|count| *count as f32).product();
                    all > 2.0 * PROBES_USUAL || counts.iter().any(|count| *count > PROBES_ALONG_MAX)
                };
                while is_too_many(counts_at(spacing_m)) {
                    spacing_m *= 1.1;
                }
                counts_at(spacing_m)
            }
        };
        Self::new(name, region, counts)
    }

    /// How many probes there are.
    pub fn count(&self) -> usize {
        self.counts.iter().product::<u32>() as usize
    }

    /// How far they are apart along each axis, in metres.
    pub fn spacing_m(&self) -> Vec3 {
        let spaces = self.counts.map(|count| if count > 1 { count as f32 - 1.0 + 2.0 * INSET } else { 1.0 });
        2.0 * self.region.half_m / Vec3::from(spaces)
    }

    /// The place of one that was not moved, in world space.
    pub fn place(&self, index: usize) -> Vec3 {
        let [x, y, _] = self.counts.map(|count| count as usize);
        let at = [index % x, index / x % y, index / (x * y)].map(|at| at as f32);
        let middle = Vec3::from(self.counts.map(|count| 0.5 * (count - 1) as f32));
        self.region.center_world + self.spacing_m() * (Vec3::from(at) - middle)
    }

    /// Surfaces that are farther from a probe count as if they were so far, in metres: no surface that it lights is.
    pub fn distance_max_m(&self) -> f32 {
        1.5 * self.spacing_m().length()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probes_stand_within_their_box() {
        let region = Region { center_world: Vec3::new(1.0, 2.0, 3.0), half_m: Vec3::new(2.0, 1.0, 0.5) };
        let grid = ProbeGrid::new("a", region, [5, 2, 1]).unwrap();
        let spacing = Vec3::new(4.0 / 4.25, 2.0 / 1.25, 1.0);
        assert_eq!(grid.count(), 10);
        assert!((grid.spacing_m() - spacing).length() < 1e-5);
        assert!((grid.place(0) - Vec3::new(-1.0 + spacing.x / 8.0, 1.0 + spacing.y / 8.0, 3.0)).length() < 1e-5);
        assert!((grid.place(9) - Vec3::new(3.0 - spacing.x / 8.0, 3.0 - spacing.y / 8.0, 3.0)).length() < 1e-5);
    }

    #[test]
    fn a_grid_has_neither_no_nor_a_million_probes() {
        let bounds = Aabb { min: Vec3::ZERO, max: Vec3::splat(10.0) };
        let million = ProbeGrid::over("a", &bounds, Some(0.1)).unwrap_err();
        assert_eq!(
            million.to_string(),
            "101 x 101 x 101 probes; a grid has 1 to 16384, and at most 128 along each axis"
        );
        for spacing_m in [1e-30, 0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert!(ProbeGrid::over("a", &bounds, Some(spacing_m)).is_err(), "{spacing_m}");
        }
        assert_eq!(ProbeGrid::over("a", &bounds, Some(1e9)).unwrap().counts, [1, 1, 1]);
        assert_eq!(ProbeGrid::over("a", &Aabb::EMPTY, None), Err(GridError::Flat));
        for size in [Vec3::new(1.0, 1.0, 1.0), Vec3::new(100.0, 0.0, 30.0), Vec3::new(1e4, 1.0, 1.0), Vec3::ZERO] {
            let grid = ProbeGrid::over("a", &Aabb { min: Vec3::ZERO, max: size }, None).unwrap();
            assert!(grid.count() <= 4096, "{size}: {:?}", grid.counts);
        }
    }
}
