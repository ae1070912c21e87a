//! The scenes of the published pictures: their models, cameras, light and size.

use super::options::PREFIX;
use anyhow::{Context, Result, ensure};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Models that do not lie where the published pictures' did.
const ELSEWHERE: [(&str, &str); 2] =
    [("FlightHelmet", "bevy/FlightHelmet/FlightHelmet.gltf"), ("Sponza", "sponza/rebuilt/Sponza.gltf")];

/// Environments that could be had, and the files that stand for them.
const ENVIRONMENTS: [(&str, &str); 2] = [
    ("lightroom_14b.hdr", "environments/lightroom_14b_approx_1k.hdr"),
    ("spruit_sunrise_1k.hdr", "environments/spruit_sunrise_1k.hdr"),
];

/// Scenes whose published pictures show something else than our files, after SOURCES.md. They are listed with the
/// reason, and count for no median.
const NOT_COMPARABLE: [(&str, &str); 2] = [
    ("DamagedHelmet", "its environment, aircraft_workshop_01_1k.hdr, is not at hand"),
    ("FlightHelmet", "our textures are scaled down"),
];

/// What is rendered, and how.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Scenario {
    /// Without what all names begin with.
    pub name: String,
    /// The model's file; none if it is not on this machine.
    pub model: Option<PathBuf>,
    /// None if it could not be had.
    pub environment: Option<PathBuf>,
    /// The folder of the published pictures.
    pub published: PathBuf,
    pub target: [f64; 3],
    pub eye: [f64; 3],
    pub fov_y_deg: f64,
    /// Width and height.
    pub size_px: (f64, f64),
    /// Whether the environment is seen behind the model.
    pub shows_environment: bool,
}

impl Scenario {
    /// Why the published pictures cannot be compared with ours.
    pub fn not_comparable(&self) -> Option<&'static str> {
        NOT_COMPARABLE.iter().find(|(known, _)| *known == self.name).map(|(_, reason)| *reason)
    }

    /// A published picture of the scene.
    pub fn picture(&self, renderer: &str) -> PathBuf {
        self.published.join(format!("{renderer}-golden.thumb.webp"))
    }
}

/// All scenes of `scenarios.json` below the folder of assets.
///
/// # Errors
/// It is not there, or not what it was.
pub(super) fn read(assets: &Path) -> Result<Vec<Scenario>> {
    let folder = assets.join("goldens-render-fidelity");
    let path = folder.join("scenarios.json");
    let text = std::fs::read_to_string(&path)
        .with_context(|| format!("reading {}; MANYPASS_ASSETS names another place for the assets", path.display()))?;
    let value: Value = serde_json::from_str(&text).with_context(|| format!("reading {}", path.display()))?;
    let list = value["scenarios"].as_array().with_context(|| format!("{} has no scenarios", path.display()))?;
    list.iter().map(|entry| scenario(entry, assets).with_context(|| format!("reading {entry}"))).collect()
}

fn scenario(entry: &Value, assets: &Path) -> Result<Scenario> {
    let text = |key: &str| entry[key].as_str().with_context(|| format!("no {key}"));
    let number =
        |pointer: &str| entry.pointer(pointer).and_then(Value::as_f64).with_context(|| format!("no {pointer}"));
    let full_name = text("name")?;
    let name = full_name.strip_prefix(PREFIX).unwrap_or(full_name).to_owned();
    let target = [number("/target/x")?, number("/target/y")?, number("/target/z")?];
    let eye = eye(target, number("/orbit/theta")?, number("/orbit/phi")?, number("/orbit/radius")?);
    let lighting = text("lighting")?;
    let environment = ENVIRONMENTS.iter().find(|(known, _)| *known == lighting).map(|(_, file)| assets.join(file));
    let (eye, target) = if eye == target { (eye, ahead(target, number("/orbit/theta")?)) } else { (eye, target) };
    Ok(Scenario {
        model: model(assets, &name, text("model")?),
        environment: environment.filter(|file| file.is_file()),
        published: assets.join("goldens-render-fidelity").join(full_name),
        target,
        eye,
        fov_y_deg: number("/verticalFoV")?,
        size_px: (number("/dimensions/width")?, number("/dimensions/height")?),
        shows_environment: entry["renderSkybox"].as_bool().context("no renderSkybox")?,
        name,
    })
}

/// target + r (sin φ sin θ, cos φ, sin φ cos θ): θ is our yaw, and 90° − φ our pitch.
fn eye(target: [f64; 3], theta_deg: f64, phi_deg: f64, radius_m: f64) -> [f64; 3] {
    let (sin_theta, cos_theta) = theta_deg.to_radians().sin_cos();
    let (sin_phi, cos_phi) = phi_deg.to_radians().sin_cos();
    let direction = [sin_phi * sin_theta, cos_phi, sin_phi * cos_theta];
    std::array::from_fn(|axis| target[axis] + radius_m * direction[axis])
}

/// What a camera with an orbit of radius 0 and φ = 90° looks at: it stands on its target and looks against its
/// direction.
fn ahead(place: [f64; 3], theta_deg: f64) -> [f64; 3] {
    eye(place, theta_deg, 90.0, -1.0)
}

/// The file of a model: where the published pictures had it, or another form of it.
fn model(assets: &Path, name: &str, path: &str) -> Option<PathBuf> {
    if let Some((_, file)) = ELSEWHERE.iter().find(|(known, _)| *known == name) {
        return Some(assets.join(file)).filter(|file| file.is_file());
    }
    let published = assets.join("khronos-sample-assets").join(path);
    let folder = published.parent()?.parent()?.to_owned();
    let forms = [folder.join(format!("glTF-Binary/{name}.glb")), folder.join(format!("glTF/{name}.gltf"))];
    std::iter::once(published).chain(forms).find(|file| file.is_file())
}

/// Leaves scenes that nobody asks for.
///
/// # Errors
/// One is asked for that is none.
pub(super) fn chosen(all: Vec<Scenario>, options: &super::Options) -> Result<Vec<Scenario>> {
    for name in options.only.iter().filter(|name| !super::traced::has(name)) {
        let names = || all.iter().map(|scenario| scenario.name.as_str()).collect::<Vec<_>>().join(", ");
        ensure!(
            all.iter().any(|scenario| scenario.name == *name),
            "no scene is called `{name}`; there are {}",
            names()
        );
    }
    Ok(all.into_iter().filter(|scenario| options.wants(&scenario.name)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orbits_are_places() {
        let near = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9);
        assert!(near(eye([1.0, 2.0, 3.0], 0.0, 90.0, 2.0), [1.0, 2.0, 5.0]));
        assert!(near(eye([0.0; 3], 90.0, 90.0, 2.0), [2.0, 0.0, 0.0]));
        assert!(near(eye([0.0; 3], 0.0, 60.0, 2.0), [0.0, 1.0, 3.0_f64.sqrt()]));
        // Sponza: from the middle along −X.
        assert!(near(ahead([0.0, 1.0, 0.0], 90.0), [-1.0, 1.0, 0.0]));
    }
}
