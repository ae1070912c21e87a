//! Particles of a stage.

use super::cameras::camera_called;
use super::simulations::{is_file, program_of};
use super::table::{Source, SpannedValue, Table, whole};
use crate::particles::{Particles, Preset, SYSTEMS_MAX};
use crate::simulation::Simulation;
use crate::{Diagnostic, Scene};
use std::ops::Range;

/// How many there are where nobody says.
const COUNT: u32 = 10_000;

/// An entry of `[[particles]]`.
#[derive(Clone, Debug)]
pub(super) struct ParticlesEntry {
    particles: Particles,
    program: Option<SpannedValue<String>>,
    meets: Option<SpannedValue<String>>,
    range: Range<usize>,
}

impl ParticlesEntry {
    pub(super) fn read(table: &Table<'_>) -> Result<Self, Box<Diagnostic>> {
        let preset = table.text("preset").and_then(|word| Preset::named(&word.value));
        let preset = preset.ok_or_else(|| table.fault("preset", "`preset` is missing"))?;
        let name = table.text("name").map(|name| name.value).filter(|name| !name.trim().is_empty());
        let of_preset = Preset::NAMES.iter().find(|name| Preset::named(name) == Some(preset)).copied();
        let count = table.number("count").map(|count| whole(table, "count", count)).transpose()?;
        let name = name.unwrap_or_else(|| of_preset.unwrap_or_default().into());
        let mut particles = Particles::new(name, preset, count.unwrap_or(COUNT));
        let (center, size_m) = (table.vector("center"), table.vector("size_m"));
        if size_m.is_some_and(|size_m| size_m.min_element() < 0.0) {
            return Err(table.fault("size_m", "`size_m` is an extent along X, Y and Z, each at least 0"));
        }
        particles.emit_from(center.unwrap_or_default(), size_m.unwrap_or_default());
        if let Some(rate) = table.number("rate_per_s") {
            particles.set("rate_per_s", &rate.to_string());
        }
        for (parameter, value) in table.values("parameters").unwrap_or_default() {
            particles.set(parameter, value);
        }
        particles.simulation.rate_hz = table.number("rate_hz");
        let seed = table.number("seed").map(|seed| whole(table, "seed", seed)).transpose()?;
        particles.simulation.seed = seed.unwrap_or(0);
        let look = &mut particles.look;
        if let Some(radius_m) = table.pair("radius_m") {
            if radius_m.min_element() < 0.0 {
                return Err(table.fault("radius_m", "`radius_m` is a radius at first and one at last, none below 0"));
            }
            look.radius_m = radius_m;
        }
        look.color = table.vector("color").unwrap_or(look.color);
        look.emission = table.number("emission").unwrap_or(look.emission);
        look.opacity = table.number("opacity").unwrap_or(look.opacity);
        look.stretch_secs = table.number("stretch_s").unwrap_or(look.stretch_secs);
        look.softness_m = table.number("softness_m").unwrap_or(look.softness_m);
        look.raggedness = table.number("raggedness").unwrap_or(look.raggedness);
        particles.layers = table.layers("layers").unwrap_or(particles.layers);
        let (program, meets) = (table.text("program"), table.text("meets"));
        Ok(Self { particles, program, meets, range: table.range.clone() })
    }

    /// The file that it names.
    pub(super) fn file(&self) -> Option<&str> {
        self.program.as_ref().map(|program| program.value.as_str()).filter(|file| is_file(file))
    }

    /// Adds them to the scene; `text_of` gives files by their names.
    ///
    /// # Errors
    /// The model has no camera of that name, the file cannot be read, or there are too many.
    pub(super) fn apply(
        &self,
        source: &Source,
        scene: &mut Scene,
        text_of: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
    ) -> Result<(), Box<Diagnostic>> {
        let mut particles = self.particles.clone();
        let name = &particles.name;
        if scene.particles.iter().any(|known| known.name == *name) {
            let message = format!("two systems of particles are called `{name}`; give one of them another `name`");
            return Err(source.fault(self.range.clone(), message));
        }
        if scene.particles.len() == SYSTEMS_MAX {
            let message = format!("there are more systems of particles than {SYSTEMS_MAX}");
            return Err(source.fault(self.range.clone(), message));
        }
        if let Some(program) = &self.program {
            particles.simulation.program = match is_file(&program.value) {
                true => program_of(source, program, text_of)?,
                false => Simulation::built_in("", &program.value).program,
            };
        }
        if let Some(meets) = &self.meets {
            particles.meets = Some(camera_called(source, scene, meets)?);
        }
        scene.particles.push(particles);
        Ok(())
    }
}
