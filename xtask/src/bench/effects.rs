//! Effects: what each costs beside a plain copy of the picture.

use super::Bench;
use crate::step::{last_json, root};
use crate::table::{milliseconds, ratio};
use anyhow::{Context, Result};
use serde_json::Value;
use std::process::Command;

const SIZE: (u32, u32) = (1920, 1080);
/// Each is measured so often; the least counts.
const TURNS: usize = 3;
/// A copy of every pixel, and a Gaussian of the same width in two dimensions.
const COPY: &str = "xtask/bench/copy.wgsl";
const SQUARE: &str = "xtask/bench/square.wgsl";
/// The standard deviation of both blurs, of which three reach 16 pixels.
const SIGMA: &str = "5.3333";
/// How much faster the blur in rows and columns is at least.
const ROWS_MIN: f64 = 8.0;

/// A setting's key and value.
type Setting = (&'static str, &'static str);

/// The rows: what is measured, by its name or file, the name of its passes, and a setting.
const ROWS: [(&str, &str, Option<Setting>); 13] = [
    ("bloom", "bloom", None),
    ("blur", "blur", Some(("blur.sigma_px", SIGMA))),
    (SQUARE, "square", Some(("square.sigma_px", SIGMA))),
    ("dof", "dof", Some(("dof.f_stop", "0.3"))),
    ("film", "film", None),
    ("fxaa", "fxaa", None),
    ("glow", "glow", None),
    ("grade", "grade", None),
    ("lens", "lens", None),
    ("outline", "outline", None),
    ("sharpen", "sharpen", None),
    ("smaa", "smaa", None),
    ("toon", "toon", None),
];

/// What was measured of an effect, after a copy.
struct Measured {
    /// Of all its passes.
    ms: f64,
    passes: usize,
    copy_ms: f64,
    /// Bytes of the textures of the frame.
    texture_bytes: f64,
}

impl Measured {
    fn new(result: &Value, name: &str) -> Result<Self> {
        let info = &result["info"];
        let passes = info["passes"].as_array().context("no passes were measured")?;
        let of = |name: &str| -> Vec<f64> {
            let is_of = |pass: &&Value| {
                let found = pass["name"].as_str().unwrap_or_default();
                found == name || found.strip_prefix(name).is_some_and(|rest| rest.starts_with('.'))
            };
            passes.iter().filter(is_of).filter_map(|pass| pass["gpu_ms"].as_f64()).collect()
        };
        let own = of(name);
        let texture_bytes = info["texture_bytes"].as_f64().context("no bytes of textures")?;
        Ok(Self { ms: own.iter().sum(), passes: own.len(), copy_ms: of("copy").iter().sum(), texture_bytes })
    }

    fn least(self, other: Self) -> Self {
        Self { ms: self.ms.min(other.ms), copy_ms: self.copy_ms.min(other.copy_ms), ..self }
    }
}

/// Measures an effect after a copy, or the copy alone.
fn measure(bench: &Bench, name: &str, effect: Option<&str>, setting: Option<Setting>) -> Result<Measured> {
    let (width, height) = SIZE;
    let size = format!("{width}x{height}");
    let once = || {
        let mut command = Command::new(&bench.measurements.program);
        command.current_dir(root()).args(["bench", "demo:hall", "--size", &size, "--json", "--count", "1"]);
        command.args(["--effect", COPY]);
        command.args(effect.iter().flat_map(|effect| ["--effect", effect]));
        command.args(setting.iter().flat_map(|(key, value)| ["--set".to_owned(), format!("{key}={value}")]));
        Measured::new(&last_json(&mut command)?, name)
    };
    let mut least = once()?;
    for _ in 1..TURNS {
        least = least.least(once()?);
    }
    Ok(least)
}

/// Prints the table. A blur in rows and columns that is not so much faster than one in two dimensions is a failure,
/// unless the program was built for a trial.
///
/// # Errors
/// It could not be measured.
pub(super) fn print(bench: &mut Bench) -> Result<()> {
    let columns = [
        ("effect", 24),
        ("passes", 7),
        ("ms", 9),
        ("ratio to a copy", 9),
        ("textures beside the copy's, bytes a pixel", 12),
    ];
    bench.report.begin("Built-in effects, 1920x1080", &columns);
    let bare = measure(bench, "copy", None, None)?;
    let pixels = f64::from(SIZE.0) * f64::from(SIZE.1);
    let (mut rows_ms, mut square_ms) = (f64::NAN, f64::NAN);
    for (effect, name, setting) in ROWS {
        let found = measure(bench, name, Some(effect), setting)?;
        match name {
            "blur" => rows_ms = found.ms,
            "square" => square_ms = found.ms,
            _ => (),
        }
        bench.report.row(vec![
            if name == "square" { "the blur in two dimensions".into() } else { name.to_owned() },
            found.passes.to_string(),
            milliseconds(found.ms),
            ratio(found.ms / found.copy_ms),
            format!("{:.1}", (found.texture_bytes - bare.texture_bytes) / pixels),
        ]);
    }
    let faster = square_ms / rows_ms;
    bench.report.note(&format!(
        "The copy takes {} ms. Rows and columns are {} times as fast as the same Gaussian, of 16 pixels to each side, in two \
         dimensions.",
        milliseconds(bare.ms),
        ratio(faster)
    ));
    let is_fast = faster >= ROWS_MIN;
    if !is_fast && !bench.is_trial() {
        bench
            .failures
            .push(format!("Effects: the blur is {faster:.1} times as fast as in two dimensions, not {ROWS_MIN}"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn passes_of_one_effect_add_up() {
        let pass = |name: &str, gpu_ms: f64| json!({ "name": name, "gpu_ms": gpu_ms });
        let passes = [pass("copy", 1.0), pass("blur.a", 2.0), pass("blur.b.2", 3.0), pass("blurred", 9.0)];
        let result = json!({ "info": { "passes": passes, "texture_bytes": 16 } });
        let found = Measured::new(&result, "blur").expect("measured");
        assert_eq!((found.ms, found.passes, found.copy_ms, found.texture_bytes), (5.0, 2, 1.0, 16.0));
        assert!(Measured::new(&json!({ "info": {} }), "blur").is_err());
    }
}
