//! What the tests of Manypass share.
//!
//! [`compare`] says whether two pictures are the same within a stated tolerance, and shows that it would notice if they
//! were not. [`needs`] says what a machine lacks for a test. [`raycast`] is an independent reference: a small ray caster in `f64` whose BRDF is written from the papers
//! and shares no code with the renderer. [`scenes`] gives small scenes to both. This crate knows no GPU.

pub mod compare;
pub mod needs;
pub mod raycast;
pub mod scenes;
