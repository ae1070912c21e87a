//! What the tests of Manypass share.
//!
//! [`compare`] says whether two pictures are the same within a stated tolerance, and shows that it would notice if they
//! were not. [`needs`] says what a machine lacks for a test. [`raycast`] is an independent reference: a ray caster in
//! `f64` whose BRDF is written from the papers and shares no code with the renderer; [`radiance_file`] keeps what took
//! it long. [`shadow_edges`] knows where shadows of simple things end. [`scenes`] gives small scenes to both renderer
//! and ray caster, [`build`] puts others together, and [`ktx2`] containers; [`data_uri()`] puts them into a file's
//! text. [`growth`] writes files with very many things; [`pages`] has the
//! commands and the code that the docs show; [`sentences`] says how long and how plain a text's are. This crate knows no
//! GPU.

pub mod build;
pub mod compare;
mod data_uri;
pub mod growth;
pub mod ktx2;
pub mod needs;
pub mod pages;
pub mod radiance_file;
pub mod raycast;
pub mod scenes;
pub mod sentences;
pub mod shadow_edges;

pub use data_uri::data_uri;
