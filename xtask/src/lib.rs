//! What `cargo xtask` and `xtask-tools` share: set-up, steps with names and times, and running programs.

pub mod setup;
pub mod step;
