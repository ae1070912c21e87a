//! The built-in demos. The hall is a colonnade at night under more than a thousand coloured lights, whose meshes and
//! lights are shared by many nodes; the others show what materials can be, what maps make of flat surfaces, many small
//! things, and pictures within the picture in a room: with what their stages say.

mod builder;
mod cornell;
mod crowd;
mod doors;
mod hall;
mod laboratory;
mod land;
mod materials;
mod paint;
mod relief;
mod room;
mod sandbox;
mod shapes;
mod shore;
mod yard;

pub use cornell::cornell;
pub use crowd::crowd;
pub use doors::doors;
pub use hall::hall;
pub use laboratory::laboratory;
pub use materials::materials;
pub use relief::relief;
pub use room::{gallery, room};
pub use sandbox::sandbox;
pub use shore::shore;
pub use yard::yard;

use crate::Scene;
use crate::renamed::{NameKind, current};
use crate::stage::Stage;

/// The names of the demos.
pub const NAMES: [&str; 21] = [
    "hall",
    "materials",
    "relief",
    "crowd",
    "room",
    "monitors",
    "mirror",
    "shore",
    "water",
    "doors",
    "portals",
    "gallery",
    "reflection_probes",
    "laboratory",
    "simulations",
    "particles",
    "yard",
    "decals",
    "sandbox",
    "trails",
    "cornell",
];

/// The demo of a name, or of an older one.
pub fn named(name: &str) -> Option<Scene> {
    let name = current(NameKind::Demo, name);
    match name {
        "hall" => Some(hall()),
        "materials" => Some(materials()),
        "relief" => Some(relief()),
        "crowd" => Some(crowd()),
        "room" => Some(room()),
        "monitors" | "mirror" => staged(room(), name),
        "doors" => Some(doors()),
        "portals" => staged(doors(), name),
        "gallery" => Some(gallery()),
        "reflection_probes" => staged(gallery(), name),
        "laboratory" => Some(laboratory()),
        "simulations" | "particles" => staged(laboratory(), name),
        "yard" => Some(yard()),
        "decals" => staged(yard(), name),
        "sandbox" => Some(sandbox()),
        "trails" => staged(sandbox(), name),
        "shore" => Some(shore()),
        "cornell" => Some(cornell()),
        "water" => staged(shore(), name),
        _ => None,
    }
}

/// A scene as the stage of a demo changes it.
fn staged(mut scene: Scene, name: &str) -> Option<Scene> {
    // A test applies it.
    stage(name)?.apply(&mut scene).ok()?;
    Some(scene)
}

/// What frames of a demo need beside its scene and settings, as a stage: the room of `cornell` is lit by what its walls send
/// each other, which live probes find, the panel of `room` is a mirror, of which the picture shows too little, and the
/// balls of `gallery` reflect what lies off the picture. It is no part of [`stage`], because bakers find that light themselves, and stages of users say what is a mirror.
pub fn frame_stage(name: &str) -> Option<Stage> {
    let name = current(NameKind::Demo, name);
    let text = match name {
        "room" => "model = \"demo:room\"\n[[mirrors]]\nnode = \"Mirror\"\n",
        "gallery" => concat!(
            "model = \"demo:gallery\"\n[[mirrors]]\nnode = \"Mirror\"\n",
            "[[reflection_probes]]\nname = \"room\"\ncenter = [0, 1.5, 0]\nsize_m = [8.6, 3.5, 7.6]\n",
            "position = [0.6, 1.1, 0.6]\nparallax_center = [0, 1.5, 0]\nparallax_size_m = [8, 3, 7]\n",
        ),
        "reflection_probes" => "model = \"demo:gallery\"\n[[mirrors]]\nnode = \"Mirror\"\n",
        "cornell" => "model = \"demo:cornell\"\n[[probes]]\ncounts = [4, 4, 4]\n",
        _ => return None,
    };
    // A test reads it.
    Stage::parse(&format!("demo:{name}"), text).ok()
}

/// What a demo brings of settings, if it has any of its own: a stage without more. A stage of the user's that has a demo
/// as its model takes none of them.
pub fn stage(name: &str) -> Option<Stage> {
    let name = current(NameKind::Demo, name);
    let text = match name {
        "hall" => include_str!("demo/hall.stage.toml"),
        "room" => "model = \"demo:room\"\n[settings.exposure]\nstops = \"auto-1\"\n",
        "monitors" => include_str!("demo/monitors.stage.toml"),
        "mirror" => include_str!("demo/mirror.stage.toml"),
        "shore" => {
            "model = \"demo:shore\"\n[environment]\nsource = \"sky\"\nsun_elevation_deg = 24\nsun_azimuth_deg = -60\n[settings.exposure]\nstops = \"auto+0.2\"\n"
        }
        "water" => include_str!("demo/water.stage.toml"),
        "doors" => "model = \"demo:doors\"\n[settings.exposure]\nstops = \"auto-1\"\n",
        "portals" => include_str!("demo/portals.stage.toml"),
        "gallery" => "model = \"demo:gallery\"\n[settings.exposure]\nstops = \"auto-1.6\"\n",
        "reflection_probes" => include_str!("demo/reflection_probes.stage.toml"),
        "laboratory" => "model = \"demo:laboratory\"\n[settings.exposure]\nstops = \"auto\"\n",
        "simulations" => include_str!("demo/simulations.stage.toml"),
        "particles" => include_str!("demo/particles.stage.toml"),
        "yard" => "model = \"demo:yard\"\n[settings.exposure]\nstops = \"auto-1.3\"\n",
        "decals" => include_str!("demo/decals.stage.toml"),
        "sandbox" => "model = \"demo:sandbox\"\n[settings.exposure]\nstops = \"auto\"\n",
        "trails" => include_str!("demo/trails.stage.toml"),
        "cornell" => "model = \"demo:cornell\"\n[environment]\nsource = \"none\"\n",
        _ => return None,
    };
    // A test reads it.
    Stage::parse(&format!("demo:{name}"), text).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn demos_are_there_and_stages_name_their_models() {
        for name in NAMES {
            let stage = stage(name);
            assert_eq!(stage.is_some(), !["materials", "relief", "crowd"].contains(&name), "{name}");
            let model = match name {
                "hall" => "demo:hall",
                "laboratory" | "simulations" | "particles" => "demo:laboratory",
                "shore" | "water" => "demo:shore",
                "doors" | "portals" => "demo:doors",
                "gallery" | "reflection_probes" => "demo:gallery",
                "yard" | "decals" => "demo:yard",
                "sandbox" | "trails" => "demo:sandbox",
                "cornell" => "demo:cornell",
                _ => "demo:room",
            };
            assert!(stage.is_none_or(|stage| stage.model() == model), "{name}");
            assert!(named(name).is_some(), "{name}");
            let stages = [super::stage(name), frame_stage(name)];
            assert!(stages.iter().flatten().all(|stage| stage.older_names().is_empty()), "{name}");
            if let Some((stage, mut scene)) = frame_stage(name).zip(named(name)) {
                assert!(stage.apply(&mut scene).is_ok(), "{name}");
                assert_eq!(scene.surroundings.is_empty(), !["gallery", "reflection_probes"].contains(&name), "{name}");
            }
        }
    }
}
