//! The looks of an input: in which variant and by which camera it is shown, each a picture of its own.

use crate::args::FrameArgs;
use crate::camera::{CameraSpec, Place, camera_name};
use crate::failure::Failure;
use crate::gather::Names;
use crate::listing::choices;
use manypass_scene::Scene;
use std::collections::BTreeSet;

/// What `--variant` and `--camera` take for every one of a file.
pub const ALL: &str = "all";

/// One variant and one camera.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Look {
    /// The variant; none is the materials that the file names.
    pub variant: Option<usize>,
    /// `{variant}`.
    pub variant_name: String,
    /// The camera.
    pub camera: CameraSpec,
    /// `{camera}`.
    pub camera_name: String,
}

/// What stands for one picture in the names of its files.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// Of its input.
    pub names: &'a Names,
    /// Its variant and camera.
    pub look: &'a Look,
    /// Its number in a sequence; 0 of a still.
    pub frame: u32,
}

/// What one input has several pictures by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PictureAxes {
    /// Every variant of the file.
    pub variants: bool,
    /// Every camera of the file, or of `--cameras`.
    pub cameras: bool,
    /// Frames of a sequence, be it one.
    pub frames: bool,
}

impl PictureAxes {
    /// What `args` ask for, but for frames.
    pub fn looks(args: &FrameArgs) -> Self {
        let is_all = |name: &Option<String>| name.as_deref() == Some(ALL);
        Self { variants: is_all(&args.variant), cameras: is_all(&args.camera), frames: false }
    }

    /// Whether only the file tells how many looks there are.
    pub fn has_looks(self) -> bool {
        self.variants || self.cameras
    }

    /// Whether one input may have several pictures.
    pub fn any(self) -> bool {
        self.has_looks() || self.frames
    }
}

/// Fails where all variants or cameras are asked for of a command that shows one.
///
/// # Errors
/// Wrong usage.
pub fn refuse_all(args: &FrameArgs) -> Result<(), Failure> {
    let several = PictureAxes::looks(args);
    let flag = match several {
        PictureAxes { variants: true, .. } => "--variant",
        PictureAxes { cameras: true, .. } => "--camera",
        _ => return Ok(()),
    };
    Err(Failure::usage(format!("`{flag} all` is only for `manypass render`"), format!("name one: {flag} NAME|INDEX")))
}

/// The look as it is typed, of files that are not asked for all.
pub fn typed(args: &FrameArgs, camera: &CameraSpec) -> Look {
    let name = |text: &Option<String>| text.as_deref().map(safe_name).unwrap_or_default();
    Look { variant: None, variant_name: name(&args.variant), camera: camera.clone(), camera_name: name(&args.camera) }
}

/// Every look of a scene that is asked for, cameras of a variant one after the other. A file without variants has its
/// own materials, called `default`, one without cameras what is seen without a flag, called `default`, too; both are
/// warned of. `views` are the cameras of `--cameras`, if there are any.
///
/// # Errors
/// If the scene has no such variant.
pub fn of_scene(
    scene: &Scene,
    args: &FrameArgs,
    camera: &CameraSpec,
    views: &[(CameraSpec, String)],
    warnings: &mut Vec<String>,
) -> Result<Vec<Look>, Failure> {
    let several = PictureAxes::looks(args);
    let typed = typed(args, camera);
    let variants: Vec<(Option<usize>, String)> = if several.variants {
        let names = distinct(scene.variants.iter().map(String::as_str).enumerate());
        names.into_iter().map(|(index, name)| (Some(index), name)).collect()
    } else {
        vec![(variant(scene, args.variant.as_deref())?, typed.variant_name)]
    };
    let cameras: Vec<(CameraSpec, String)> = if !views.is_empty() {
        views.to_vec()
    } else if several.cameras {
        let placed = scene.placed_cameras();
        let names = distinct(placed.iter().map(|(index, ..)| (*index, camera_name(scene, *index))));
        let spec = |index| CameraSpec { place: Place::OfFile(index), ..camera.clone() };
        names.into_iter().map(|(index, name)| (spec(index), name)).collect()
    } else {
        vec![(camera.clone(), typed.camera_name)]
    };
    let mut missing = |what: &str| {
        warnings.push(format!("the file has no {what}; it has one picture, called `default`"));
        "default".to_owned()
    };
    let variants = if variants.is_empty() { vec![(None, missing("variants"))] } else { variants };
    let automatic = || CameraSpec { place: Place::Default, ..camera.clone() };
    let cameras = if cameras.is_empty() { vec![(automatic(), missing("cameras"))] } else { cameras };
    let looks = variants.iter().flat_map(|(variant, variant_name)| {
        cameras.iter().map(|(camera, camera_name)| Look {
            variant: *variant,
            variant_name: variant_name.clone(),
            camera: camera.clone(),
            camera_name: camera_name.clone(),
        })
    });
    Ok(looks.collect())
}

/// The variant that is asked for by name or index; without one, surfaces have their own materials.
///
/// # Errors
/// If the file has no such variant.
pub fn variant(scene: &Scene, asked: Option<&str>) -> Result<Option<usize>, Failure> {
    let Some(asked) = asked else { return Ok(None) };
    let index = scene.variant_named(asked).ok_or_else(|| {
        let known = choices("variants", scene.variants.iter().map(String::as_str).enumerate());
        Failure::usage(format!("there is no variant `{asked}`"), known)
    })?;
    Ok(Some(index))
}

/// Names for files: those without any, and those that a file system may take for one of the others, have their index.
pub fn distinct<'a>(named: impl Iterator<Item = (usize, &'a str)>) -> Vec<(usize, String)> {
    let mut taken = BTreeSet::new();
    let mut name = |(index, name): (usize, &str)| {
        let mut name = safe_name(name);
        if name.is_empty() {
            name = index.to_string();
        }
        while !taken.insert(name.to_lowercase()) {
            name = format!("{name}-{index}");
        }
        (index, name)
    };
    named.map(&mut name).collect()
}

/// A name as a part of a file's: letters, digits, dots, minus signs and underscores; every run of others becomes one
/// minus sign.
pub fn safe_name(name: &str) -> String {
    let mut safe = String::new();
    for letter in name.chars() {
        if letter.is_alphanumeric() || matches!(letter, '.' | '_') {
            safe.push(letter);
        } else if !safe.ends_with('-') {
            safe.push('-');
        }
    }
    safe.trim_matches(['-', '.']).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_looks_are_safe_and_tell_them_apart() {
        let names = ["../a", "A", "", "Mitternacht / Größe", "a-1"];
        let names: Vec<String> = distinct(names.into_iter().enumerate()).into_iter().map(|(_, name)| name).collect();
        assert_eq!(names, ["a", "A-1", "2", "Mitternacht-Größe", "a-1-4"]);
    }

    #[test]
    fn names_of_passes_are_safe() {
        assert_eq!(safe_name("geometry > base_color"), "geometry-base_color");
        assert_eq!(safe_name("../a//b\\c:d"), "a-b-c-d");
    }
}
