//! Which scene of a file is shown, and where.

use crate::failure::{Failure, Kind};
use crate::listing::choices;
use manypass::Settings;
use manypass_scene::Scene;

/// Draws near the origin what lies far from it for its size ([`Scene::bring_near`]); gives whether it has moved.
pub fn bring_near(scene: &mut Scene, settings: &Settings) -> bool {
    may_move(settings) && scene.bring_near()
}

/// Whether nothing of the settings is placed in the space of the file, as the height of fog is.
pub fn may_move(settings: &Settings) -> bool {
    settings.fog.scale_height_m <= 0.0
}

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
