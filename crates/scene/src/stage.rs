//! Stage files, `NAME.stage.toml`: what glTF cannot say of a model, or what one wants otherwise: lights, what casts
//! shadows, environment, fog and other settings.
//!
//! A stage names its model; a model knows nothing of stages. This crate reads what changes the scene. Settings are
//! those of whoever draws: they stay text here ([`Stage::text`]), whose tables [`keys::SETTINGS_TABLES`] names.
//!
//! ```
//! # use manypass_scene::{Scene, Stage};
//! let text = "model = \"lamp.glb\"\n[[lights]]\nkind = \"point\"\nposition = [0, 2, 0]\nintensity = 40\n";
//! let stage = Stage::parse("lamp.stage.toml", text)?;
//! let mut scene = Scene::default(); // That of lamp.glb.
//! stage.apply(&mut scene)?;
//! assert_eq!(scene.lights[0].intensity, 40.0);
//! let error = Stage::parse("lamp.stage.toml", "model = 5").unwrap_err().to_string();
//! assert!(error.starts_with("lamp.stage.toml:1:9: error: `5` is not a value of `model`"));
//! # Ok::<(), Box<manypass_scene::Diagnostic>>(())
//! ```

mod cameras;
mod decals;
mod entries;
mod file_name;
mod heights;
pub mod keys;
mod light_files;
mod lights;
mod load;
mod materials;
mod mirrors;
mod monitors;
mod names;
mod older;
mod overlay;
mod particles;
mod portals;
mod probes;
mod screens;
mod simulations;
mod surfaces;
mod surroundings;
mod table;
mod updates;
mod water;
mod words;

pub use entries::{Stage, read_overlay};
pub use file_name::is_stage;
pub use load::{
    LoadedStage, MAX_STAGE_BYTES, StageError, load_bytes, load_path, named_effects, named_environments, named_images,
    named_model,
};

#[cfg(test)]
mod tests;
