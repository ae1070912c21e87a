//! Particles: many small things that a simulation moves, such as sparks, smoke and rain.
//!
//! ```
//! # use manypass_scene::Scene;
//! # use manypass_scene::particles::{Preset, Particles};
//! # use glam::Vec3;
//! # let mut scene = Scene::default();
//! let mut rain = Particles::new("rain", Preset::Rain, 20_000);
//! rain.emit_from(Vec3::new(0.0, 6.0, 0.0), Vec3::new(8.0, 0.5, 8.0));
//! rain.simulation.seed = 5;
//! scene.particles.push(rain);
//! scene.time_secs = 3.0; // They are where they are after so many seconds.
//! ```

use crate::NodeId;
use crate::capture::LAYERS_ALL;
use crate::simulation::Simulation;
use glam::{Vec2, Vec3};

/// The most systems of particles of a scene that are drawn.
pub const SYSTEMS_MAX: usize = 16;

/// The most particles of a system.
pub const PARTICLES_MAX: u32 = 1 << 20;

/// Particles lie in the cells of a simulation, so many in a row.
pub const COLUMNS: u32 = 512;

/// How long the longest life is where the parameters do not say.
const LIFE_SECS: f32 = 2.0;

/// What they are made of, and how they move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// Glowing bits of metal that fly off, fall, bounce and fade.
    Sparks,
    /// Puffs that rise, spread, are lit and hide what is behind them.
    Smoke,
    /// Drops that fall as streaks.
    Rain,
}

impl Preset {
    /// The words that name one.
    pub const NAMES: &'static [&'static str] = &["sparks", "smoke", "rain"];

    /// The one with a name.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "sparks" => Some(Self::Sparks),
            "smoke" => Some(Self::Smoke),
            "rain" => Some(Self::Rain),
            _ => None,
        }
    }

    /// Values of the program `particles`, beside those of where they begin.
    fn parameters(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::Sparks => &[
                ("velocity_m_s", "0,2.2,0"),
                ("spread_m_s", "1.6"),
                ("life_s", "0.9,1.8"),
                ("gravity_m_s2", "9.81"),
                ("drag_per_s", "0.4"),
                ("bounce", "0.45"),
            ],
            Self::Smoke => &[
                ("velocity_m_s", "0,0.55,0"),
                ("spread_m_s", "0.12"),
                ("life_s", "3,5"),
                ("gravity_m_s2", "-0.12"),
                ("drag_per_s", "0.5"),
                ("swirl_m_s", "0.35"),
                ("swirl_m", "0.7"),
            ],
            // Drops of 2 mm fall at 6.5 m/s (Gunn & Kinzer 1949).
            Self::Rain => &[
                ("velocity_m_s", "0,-6.5,0"),
                ("spread_m_s", "0.25"),
                ("life_s", "2,2"),
                ("gravity_m_s2", "0"),
                ("bounce", "-1"),
            ],
        }
    }

    fn look(self) -> Look {
        let look = Look::default();
        match self {
            Self::Sparks => Look {
                radius_m: Vec2::new(0.007, 0.003),
                color: Vec3::new(1.0, 0.42, 0.12),
                emission: 120.0,
                opacity: 0.0,
                stretch_secs: 0.022,
                softness_m: 0.0,
                raggedness: 0.0,
            },
            Self::Smoke => Look {
                radius_m: Vec2::new(0.1, 0.42),
                color: Vec3::splat(0.72),
                opacity: 0.14,
                softness_m: 0.25,
                raggedness: 1.0,
                ..look
            },
            Self::Rain => Look {
                radius_m: Vec2::splat(0.0035),
                color: Vec3::splat(0.85),
                opacity: 0.32,
                stretch_secs: 0.02,
                softness_m: 0.0,
                ..look
            },
        }
    }
}

/// How particles look.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// Their radius at the beginning of their life and at its end, in metres.
    pub radius_m: Vec2,
    /// Their albedo, and the colour of what they emit: linear red, green and blue.
    pub color: Vec3,
    /// What they emit, times their colour: radiance in the scene's units, cd/m² where lights are lux and candela. It
    /// fades over their life.
    pub emission: f32,
    /// How much of what is behind their middle they hide, at most, from 0 to 1. What hides nothing is seen by what it emits
    /// alone.
    pub opacity: f32,
    /// For how many seconds of their way they are drawn, as in a picture that is exposed so long.
    pub stretch_secs: f32,
    /// How far before a surface they begin to fade, in metres.
    pub softness_m: f32,
    /// How ragged their edges are: from 0, where they are round, to 1, where noise takes much of their outer half.
    pub raggedness: f32,
}

impl Default for Look {
    fn default() -> Self {
        let (color, radius_m) = (Vec3::ONE, Vec2::splat(0.02));
        Self { radius_m, color, emission: 0.0, opacity: 1.0, stretch_secs: 0.0, softness_m: 0.05, raggedness: 0.0 }
    }
}

/// A system of particles.
#[derive(Clone, Debug, PartialEq)]
pub struct Particles {
    /// Its name: in the names of passes.
    pub name: String,
    /// What moves them: one whose states are `place` (metres in world space; age in seconds, below 0 where there is none)
    /// and `velocity` (m/s; the length of its life in seconds), a particle in each cell.
    pub simulation: Simulation,
    /// How they look.
    pub look: Look,
    /// A camera of the scene whose distances they meet, as the scene stands when they begin: surfaces that it sees.
    pub meets: Option<NodeId>,
    /// The layers ([`crate::Node::layers`]) of which that sees the surfaces, a bit each.
    pub layers: u32,
}

impl Particles {
    /// Particles of a preset around the origin, at most so many at once.
    pub fn new(name: impl Into<String>, preset: Preset, count: u32) -> Self {
        let name = name.into();
        let mut simulation = Simulation::built_in(name.clone(), "particles");
        let owned = |(key, value): &(&str, &str)| ((*key).to_owned(), (*value).to_owned());
        simulation.parameters = preset.parameters().iter().map(owned).collect();
        let mut particles = Self { name, simulation, look: preset.look(), meets: None, layers: LAYERS_ALL };
        particles.hold(count);
        particles
    }

    /// Gives them place for at most `count` at once.
    pub fn hold(&mut self, count: u32) {
        let count = count.clamp(1, PARTICLES_MAX);
        self.simulation.cells = Some((count.min(COLUMNS), count.div_ceil(COLUMNS)));
        self.set("count", &count.to_string());
    }

    /// Lets them begin in a box of which the middle and the extent are given, in metres.
    pub fn emit_from(&mut self, center: Vec3, size_m: Vec3) {
        self.set("center", &text(center));
        self.set("size_m", &text(size_m));
    }

    /// Sets a parameter of what moves them.
    pub fn set(&mut self, parameter: &str, value: &str) {
        self.simulation.parameters.retain(|(known, _)| known != parameter);
        self.simulation.parameters.push((parameter.into(), value.into()));
    }

    /// The longest that one lives, in seconds, by the parameter `life_s`: after so long there are as many as there will
    /// be.
    pub fn life_secs(&self) -> f32 {
        let stated = self.simulation.parameters.iter().find(|(parameter, _)| parameter == "life_s");
        let lives = stated.iter().flat_map(|(_, value)| value.split(',')).filter_map(|life| life.trim().parse().ok());
        lives.filter(|life: &f32| life.is_finite()).reduce(f32::max).unwrap_or(LIFE_SECS)
    }

    /// How many there are at once, at most.
    pub fn count(&self) -> u32 {
        let (columns, rows) = self.simulation.cells.unwrap_or((COLUMNS, 1));
        columns.saturating_mul(rows)
    }
}

fn text(vector: Vec3) -> String {
    format!("{},{},{}", vector.x, vector.y, vector.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_life_is_known() {
        let mut smoke = Particles::new("a", Preset::Smoke, 10);
        assert_eq!(smoke.life_secs(), 5.0);
        smoke.set("life_s", "8,6.5");
        assert_eq!(smoke.life_secs(), 8.0);
        smoke.simulation.parameters.clear();
        assert_eq!(smoke.life_secs(), LIFE_SECS);
    }
}
