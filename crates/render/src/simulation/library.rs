//! The simulations that come with the renderer: files like everybody's.

use super::SimulationFile;
use crate::shader::program::ProgramError;
use manypass_scene::simulation::Program;
use manypass_scene::spelling;

/// Their names and texts.
const LIBRARY: [(&str, &str); 5] = [
    ("fluid", include_str!("../../simulations/fluid.wgsl")),
    ("gray_scott", include_str!("../../simulations/gray_scott.wgsl")),
    ("particles", include_str!("../../simulations/particles.wgsl")),
    ("ripples", include_str!("../../simulations/ripples.wgsl")),
    ("trails", include_str!("../../simulations/trails.wgsl")),
];

impl SimulationFile {
    /// The names of the simulations that come with the renderer; docs/simulations.md says what each does.
    pub fn built_in_names() -> impl Iterator<Item = &'static str> {
        LIBRARY.iter().map(|(name, _)| *name)
    }

    /// The text of a program.
    ///
    /// # Errors
    /// No simulation that comes with the renderer has its name, or as [`Self::parse`].
    pub fn of_program(program: &Program) -> Result<Self, ProgramError> {
        match program {
            Program::Text { file, text } => Self::parse(file, text),
            Program::BuiltIn(name) => match LIBRARY.iter().find(|(known, _)| known == name) {
                Some((name, text)) => Self::parse(&format!("{name}.wgsl"), text),
                None => {
                    let known: Vec<&str> = Self::built_in_names().collect();
                    let nearest = spelling::nearest(name, known.iter().copied());
                    let nearest = nearest.map(|nearest| format!("; did you mean `{nearest}`?")).unwrap_or_default();
                    let message = format!(
                        "no simulation is called so{nearest}; built in are {}; a file is named with its ending, .wgsl",
                        known.join(", ")
                    );
                    Err(ProgramError::Simulation { simulation: name.clone(), message })
                }
            },
        }
    }
}
