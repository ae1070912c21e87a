//! The tests of baking, one module a file, linked once.

mod bakes;
mod closed_forms;
mod common;
mod probes;
mod surroundings;
