//! Which scene of a file is shown.

use crate::failure::{Failure, Kind};
use crate::listing::choices;
use manypass_scene::Scene;

/// Shows the scene that is asked for by name or index; without one, the scene that the file names stays. What was
/// warned of the latter goes, and the same is said of the former.
///
/// # Errors
/// If the file has no such scene, or it cannot be drawn.
pub fn show(scene: &mut Scene, asked: Option<&str>, warnings: &mut Vec<String>) -> Result<(), Failure> {
    let Some(asked) = asked else { return Ok(()) };
    let unknown = |scene: &Scene| {
        Failure::usage(
            format!("there is no scene `{asked}`"),
            choices("scenes", scene.scenes.iter().map(|roots| roots.name.as_str()).enumerate()),
        )
    };
    let index = scene.scene_named(asked).ok_or_else(|| unknown(scene))?;
    scene
        .show_scene(index)
        .map_err(|error| Failure::new(Kind::Failed, error, "join its meshes, or show another --scene"))?;
    warnings.retain(|warning| !warning.contains("draws nothing"));
    if !scene.draws_anything() {
        warnings.push(format!("at \"/scenes/{index}\": the scene draws nothing; it has no visible node with a mesh"));
    }
    Ok(())
}
