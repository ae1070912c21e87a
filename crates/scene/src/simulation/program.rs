//! What a simulation is.

use crate::NodeId;
use crate::capture::LAYERS_ALL;
use std::sync::Arc;

/// Where the text of a simulation comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Program {
    /// One that whoever draws the scene has by this name.
    BuiltIn(String),
    /// A text.
    Text {
        /// The file that it is from, for errors.
        file: String,
        /// WGSL.
        text: Arc<str>,
    },
}

/// A simulation.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulation {
    /// Its name, in reports and errors.
    pub name: String,
    /// What it does.
    pub program: Program,
    /// Width and height in cells; those of the program if none.
    pub cells: Option<(u32, u32)>,
    /// Steps in a second of the scene's time; those of the program if none.
    pub rate_hz: Option<f32>,
    /// Another number is another course of whatever chance decides.
    pub seed: u32,
    /// Values of the program's parameters by their names: numbers, with commas between those of a vector.
    pub parameters: Vec<(String, String)>,
    /// A node with a flat mesh whose rectangle the cells lie over. Without it that of the first water that shows the
    /// simulation; without either they are a square of 1 m.
    pub place: Option<NodeId>,
    /// Nodes that move through it, as spheres.
    pub bodies: Vec<NodeId>,
    /// Nodes that stand in its way, as boxes along the sides of the place.
    pub walls: Vec<NodeId>,
    /// A camera of the scene whose distances it reads at each step, as the animation that was last posed has surfaces.
    pub sees: Option<NodeId>,
    /// The layers ([`crate::Node::layers`]) of which that sees the surfaces, a bit each.
    pub layers: u32,
}

impl Simulation {
    /// As its program says, one that is built in.
    pub fn built_in(name: impl Into<String>, program: &str) -> Self {
        Self::of(name.into(), Program::BuiltIn(program.into()))
    }

    /// As its text says; `file` appears in errors.
    pub fn of_text(name: impl Into<String>, file: &str, text: &str) -> Self {
        Self::of(name.into(), Program::Text { file: file.into(), text: text.into() })
    }

    fn of(name: String, program: Program) -> Self {
        Self {
            name,
            program,
            cells: None,
            rate_hz: None,
            seed: 0,
            parameters: Vec::new(),
            place: None,
            bodies: Vec::new(),
            walls: Vec::new(),
            sees: None,
            layers: LAYERS_ALL,
        }
    }

    /// The same with the value of a parameter.
    pub fn with(mut self, parameter: &str, value: &str) -> Self {
        self.parameters.push((parameter.into(), value.into()));
        self
    }
}
