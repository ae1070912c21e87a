//! What is wrong with a text that a user wrote. It lies in the crate of scenes, which reads stage files.

pub use manypass_scene::Diagnostic;
