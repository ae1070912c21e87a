//! Simulations: pictures that follow from themselves, step by step, each one file in WGSL with states, steps, pictures and
//! parameters; see docs/simulations.md.
//!
//! States are pairs of textures of four 32-bit floats a cell: a pass reads what is there and writes the other one
//! (ping-pong). Steps are as long as the rate says, so that the state after a time follows from that alone, in whatever
//! frames it is looked at.

mod compiled;
mod file;
mod header;
mod library;
mod running;
mod uniforms;

pub use file::SimulationFile;
pub(crate) use running::{RunningSimulation, SimulationInputs};

/// The progress of a simulation: its steps towards the scene's time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SimulationProgress<'s> {
    /// Its name.
    pub name: &'s str,
    /// How many steps were made.
    pub done: u64,
    /// How many there are.
    pub total: u64,
}

/// The report of a simulation: its steps, and whether its values exploded.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct SimulationReport {
    /// Its name.
    pub name: String,
    /// Columns and rows.
    pub cells: (u32, u32),
    /// How many steps led to its state.
    pub steps: u64,
    /// How many passes a step has.
    pub passes: u32,
    /// Bytes of its states and pictures on the device.
    pub bytes: u64,
    /// How many numbers of its states are held at ±10⁶, because they would be larger, or no numbers at all: it
    /// exploded.
    pub held_numbers: u64,
}

/// The most steps that are made for one picture: half an hour of the usual 60 a second.
pub const STEPS_MAX: u64 = 108_000;

/// The most cells that all passes of these steps write together. A graphics card writes some 10⁹ to 10¹⁰ a second.
pub const CELLS_WRITTEN_MAX: u64 = 1 << 36;

/// How large a number of a state is at most.
pub(crate) const NUMBER_MAX: f32 = 1e6;
