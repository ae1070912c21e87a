//! The tests of the scene and its readers, one module a file, linked once.

mod accessors;
mod animation_pointers;
mod assets;
mod common;
mod cube_maps;
mod draco;
mod forgiving;
mod hostile;
#[path = "inputs/main.rs"]
mod inputs;
mod instancing;
mod known_geometry;
mod known_motion;
mod known_surfaces;
mod ktx2;
mod late_images;
mod layers;
mod levels;
mod meshopt;
mod sky;
