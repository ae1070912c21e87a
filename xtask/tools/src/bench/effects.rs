//! Effects: what each costs beside a plain copy of the picture, and what it reads, writes and holds.

use super::Bench;
use crate::step::{last_json, root};
use crate::table::{milliseconds, ratio};
use anyhow::{Context, Result};
use serde_json::Value;
use std::process::Command;

const SIZE: (u32, u32) = (1920, 1080);
/// Each is measured so often; the least counts.
const TURNS: usize = 3;
/// The same with `--quick`, which shows that everything can be measured.
const QUICK_SIZE: (u32, u32) = (320, 180);
const QUICK_TURNS: usize = 1;
/// A copy of every pixel, and a Gaussian of the same width in two dimensions.
const COPY: &str = "xtask/bench/copy.wgsl";
const SQUARE: &str = "xtask/bench/square.wgsl";
/// The standard deviation of both blurs, of which three reach 16 pixels.
const SIGMA: &str = "5.3333";
/// How much faster the blur in rows and columns is at least, and occlusion at half the size.
const ROWS_MIN: f64 = 8.0;
const HALF_MIN: f64 = 6.0;

/// Files that are written for the table: a table of colours, a picture with text over it, and one with a sun, whose
/// shadows reach far.
const LOOK: &str = "look.cube";
const LABELS: &str = "labels.stage.toml";
const SUN: &str = "sun.stage.toml";
const LABELS_TEXT: &str = "model = \"demo:hall\"\n[[overlay]]\ntext = \"The hall\\nfrom the gate\"\nanchor = \"bottom-left\"\nposition = [12, -12]\nsize_px = 32\nbackground = \"101820\"\n";
const SUN_TEXT: &str =
    "model = \"demo:materials\"\n[[lights]]\nkind = \"directional\"\ndirection = [-1, -2, -1]\nintensity = 3\n";

/// A setting's key and value.
type Setting = (&'static str, &'static str);

/// What every frame of the table leaves out unless a row asks for it, so that passes of others are not in its way.
const BASE: [Setting; 3] =
    [("shadows.enabled", "false"), ("occlusion.enabled", "false"), ("reflections.enabled", "false")];
const STUDIO: &[Setting] = &[("environment.source", "studio")];
const HALF: &[Setting] = &[("render.scale", "0.5")];
const METERED: &[Setting] = &[("exposure.stops", "auto")];
const SHADOWS: &[Setting] = &[("shadows.enabled", "true")];

/// A row of the table.
#[derive(Clone, Copy, Debug)]
struct Row {
    name: &'static str,
    /// An effect's name or file.
    effect: Option<&'static str>,
    /// The passes that it adds, with those whose names go on after a dot.
    passes: &'static [&'static str],
    /// A pass that is there without it, too, and takes longer with it.
    longer: Option<&'static str>,
    settings: &'static [Setting],
    /// The settings of the frame beside which it is measured.
    beside: &'static [Setting],
    input: &'static str,
    /// Whether frames follow each other.
    is_live: bool,
}

const ROW: Row = Row {
    name: "",
    effect: None,
    passes: &[],
    longer: None,
    settings: &[],
    beside: &[],
    input: "demo:hall",
    is_live: false,
};

/// An effect with one setting at most.
const fn effect(name: &'static str, passes: &'static [&'static str], settings: &'static [Setting]) -> Row {
    Row { name, effect: Some(name), passes, settings, ..ROW }
}

/// What is switched by settings, over an even environment.
const fn lit(name: &'static str, passes: &'static [&'static str], settings: &'static [Setting]) -> Row {
    Row { name, passes, settings, beside: STUDIO, ..ROW }
}

const BLUR_ROWS: &str = "blur";
const BLUR_SQUARE: &str = "the blur in two dimensions";
const OCCLUSION_HALF: &str = "occlusion, half the size";
const OCCLUSION_TEXTBOOK: &str = "occlusion, 64 points, full size (ssao)";

#[rustfmt::skip] // A row a line.
const ROWS: [Row; 27] = [
    effect("bloom", &["bloom"], &[]),
    effect(BLUR_ROWS, &["blur"], &[("blur.sigma_px", SIGMA)]),
    Row { name: BLUR_SQUARE, ..effect(SQUARE, &["square"], &[("square.sigma_px", SIGMA)]) },
    effect("dof", &["dof"], &[("dof.f_stop", "0.3")]),
    effect("film", &["film"], &[]),
    effect("fxaa", &["fxaa"], &[]),
    effect("glow", &["glow"], &[]),
    effect("grade", &["grade"], &[]),
    effect("lens", &["lens"], &[]),
    effect("motion_blur", &["motion_blur", "motion"], &[]),
    effect("outline", &["outline"], &[]),
    effect("sharpen", &["sharpen"], &[]),
    effect("smaa", &["smaa"], &[]),
    effect("toon", &["toon"], &[]),
    Row { name: "table of 33 colours a side", effect: Some(LOOK), passes: &["look"], ..ROW },
    lit(OCCLUSION_HALF, &["occlusion"], &[("occlusion.enabled", "true"), ("occlusion.resolution", "half")]),
    lit("occlusion, 64 texels, full size", &["occlusion"], &[("occlusion.enabled", "true"), ("occlusion.resolution", "full"), ("occlusion.slices", "4")]),
    lit(OCCLUSION_TEXTBOOK, &["occlusion"], &[("occlusion.enabled", "true"), ("occlusion.resolution", "full"), ("occlusion.slices", "4"), ("occlusion.method", "ssao")]),
    lit("reflections, half the size", &["reflections"], &[("reflections.enabled", "true"), ("reflections.resolution", "half")]),
    lit("reflections, full size", &["reflections"], &[("reflections.enabled", "true"), ("reflections.resolution", "full")]),
    lit("gi", &["gi"], &[("gi.enabled", "true")]),
    Row { name: "contact shadows of one sun", longer: Some("direct"), settings: &[("shadows.contact_m", "0.2")], beside: SHADOWS, input: SUN, ..ROW },
    Row { name: "taa", passes: &["taa", "motion"], settings: &[("taa.enabled", "true")], is_live: true, ..ROW },
    Row { name: "upscale along edges, from 50 %", passes: &["upscale"], settings: &[("upscale.method", "edges")], beside: HALF, is_live: true, ..ROW },
    Row { name: "upscale over time, from 50 %", passes: &["taa", "motion"], settings: &[("taa.enabled", "true"), ("upscale.method", "temporal")], beside: HALF, is_live: true, ..ROW },
    Row { name: "exposure that adapts", passes: &["meter"], settings: &[("exposure.adapt", "true")], beside: METERED, is_live: true, ..ROW },
    Row { name: "overlay, two lines of text", passes: &["overlay"], input: LABELS, ..ROW },
];

/// What was measured of a row, after a copy.
#[derive(Clone, Debug, Default)]
struct Measurement {
    /// Of all its passes.
    ms: f64,
    passes: usize,
    copy_ms: f64,
    /// Bytes that its passes read and write.
    read_bytes: f64,
    written_bytes: f64,
    /// Bytes of the textures of the frame, and of those that outlive it.
    texture_bytes: f64,
}

impl Measurement {
    fn new(result: &Value, names: &[&str]) -> Result<Self> {
        let info = &result["info"];
        let passes = info["passes"].as_array().context("no passes were measured")?;
        let is_of = |pass: &Value, name: &str| {
            let found = pass["name"].as_str().unwrap_or_default();
            found == name || found.strip_prefix(name).is_some_and(|rest| rest.starts_with('.'))
        };
        let own: Vec<_> = passes.iter().filter(|pass| names.iter().any(|name| is_of(pass, name))).collect();
        let sum = |key: &str| own.iter().filter_map(|pass| pass[key].as_f64()).sum();
        let number = |key: &str| info[key].as_f64().with_context(|| format!("no {key}"));
        Ok(Self {
            ms: sum("gpu_ms"),
            passes: own.len(),
            copy_ms: passes.iter().filter(|pass| is_of(pass, "copy")).filter_map(|pass| pass["gpu_ms"].as_f64()).sum(),
            read_bytes: sum("read_bytes"),
            written_bytes: sum("written_bytes"),
            texture_bytes: number("texture_bytes")? + number("texture_bytes_imported")?,
        })
    }

    fn least(self, other: &Self) -> Self {
        Self { ms: self.ms.min(other.ms), copy_ms: self.copy_ms.min(other.copy_ms), ..self }
    }

    /// What is more here than in a frame without it.
    fn more_than(self, other: &Self) -> Self {
        Self {
            ms: self.ms - other.ms,
            read_bytes: self.read_bytes - other.read_bytes,
            written_bytes: self.written_bytes - other.written_bytes,
            ..self
        }
    }
}

/// The settings of a frame: those of the base, those of `beside`, and a row's own, the later over the earlier.
fn settings_of(beside: &[Setting], own: &[Setting]) -> Vec<Setting> {
    let mut settings: Vec<Setting> = Vec::new();
    for setting in BASE.iter().chain(beside).chain(own) {
        settings.retain(|(key, _)| key != &setting.0);
        settings.push(*setting);
    }
    settings
}

impl Bench<'_> {
    const fn effects_size(&self) -> (u32, u32) {
        if self.options.is_quick { QUICK_SIZE } else { SIZE }
    }

    /// The path of a file that was written for the table; other names as they are.
    fn effects_file(&self, name: &str) -> String {
        if [LOOK, LABELS, SUN].contains(&name) {
            return self.measurements.folder.join(name).display().to_string();
        }
        name.to_owned()
    }

    /// Measures a row after a copy, or, without it, the frame beside which it stands.
    fn measure_effect(&self, row: &Row, is_with: bool) -> Result<Measurement> {
        let (width, height) = self.effects_size();
        let size = format!("{width}x{height}");
        let settings = settings_of(row.beside, if is_with { row.settings } else { &[] });
        let names: Vec<&str> = row.passes.iter().chain(&row.longer).copied().collect();
        let once = || {
            let mut command = Command::new(&self.measurements.program);
            command.current_dir(root()).arg("bench").arg(self.effects_file(row.input));
            // The demo's own effects are none of what is measured.
            command.args(["--size", &size, "--json", "--count", "1", "--set", "chain=", "--effect", COPY]);
            command.args(row.is_live.then_some("--live"));
            if let Some(effect) = row.effect.filter(|_| is_with) {
                command.arg("--effect").arg(self.effects_file(effect));
            }
            command.args(settings.iter().flat_map(|(key, value)| ["--set".to_owned(), format!("{key}={value}")]));
            Measurement::new(&last_json(&mut command)?, &names)
        };
        let mut least = once()?;
        for _ in 1..if self.options.is_quick { QUICK_TURNS } else { TURNS } {
            least = least.least(&once()?);
        }
        Ok(least)
    }
}

/// A table of 33 colours a side that changes nothing.
fn identity_cube() -> String {
    let mut text = "LUT_3D_SIZE 33\n".to_owned();
    let share = |i: u8| f32::from(i) / 32.0;
    for (b, g, r) in (0..33).flat_map(|b| (0..33).flat_map(move |g| (0..33).map(move |r| (b, g, r)))) {
        text += &format!("{} {} {}\n", share(r), share(g), share(b));
    }
    text
}

/// Prints the table. A blur in rows and columns that is not so much faster than one in two dimensions is a failure, and
/// so is occlusion at half the size, unless the program was built for a trial.
///
/// # Errors
/// It could not be measured.
pub(super) fn print(bench: &mut Bench) -> Result<()> {
    let folder = bench.measurements.folder.clone();
    for (name, text) in [(LOOK, identity_cube()), (LABELS, LABELS_TEXT.into()), (SUN, SUN_TEXT.into())] {
        std::fs::write(folder.join(name), text).with_context(|| format!("writing {name}"))?;
    }
    let columns = [
        ("effect", 38),
        ("passes", 7),
        ("ms", 9),
        ("ratio to a copy", 9),
        ("bytes read a pixel", 9),
        ("bytes written a pixel", 9),
        ("textures beside the frame's, bytes a pixel", 12),
    ];
    let (width, height) = bench.effects_size();
    bench.report.begin(&format!("Effects, {width}x{height}"), &columns);
    let pixels = f64::from(width) * f64::from(height);
    let per_pixel = |bytes: f64| format!("{:.1}", bytes / pixels);
    let bare = bench.measure_effect(&Row { passes: &["copy"], ..ROW }, false)?;
    let mut times_ms = Vec::new();
    for row in &ROWS {
        let beside = bench.measure_effect(row, false)?;
        let mut found = bench.measure_effect(row, true)?;
        let texture_bytes = found.texture_bytes - beside.texture_bytes;
        if row.longer.is_some() {
            found = found.more_than(&beside);
        }
        anyhow::ensure!(found.passes > 0, "{} has no passes", row.name);
        // Where surfaces are drawn smaller the copy is smaller, too.
        let copy_ms = if row.beside == HALF { bare.copy_ms } else { found.copy_ms };
        times_ms.push((row.name, found.ms));
        bench.report.row(vec![
            row.name.to_owned(),
            if row.longer.is_some() { "within one".into() } else { found.passes.to_string() },
            milliseconds(found.ms),
            ratio(found.ms / copy_ms),
            per_pixel(found.read_bytes),
            per_pixel(found.written_bytes),
            per_pixel(texture_bytes),
        ]);
    }
    let ms_of = |name: &str| times_ms.iter().find(|(known, _)| *known == name).map_or(f64::NAN, |(_, ms)| *ms);
    let rows_faster = ms_of(BLUR_SQUARE) / ms_of(BLUR_ROWS);
    let half_faster = ms_of(OCCLUSION_TEXTBOOK) / ms_of(OCCLUSION_HALF);
    bench.report.note(&format!(
        "The copy takes {} ms, and reads and writes {} and {} bytes a pixel. What is read counts each texture or view that \
         a pass samples once, as a whole, and what is written each target once. Rows and columns are {} times as fast as \
         the same Gaussian, of 16 pixels to each side, in two dimensions; occlusion at half the size is {} times as fast as \
         at full size with 64 points.",
        milliseconds(bare.ms),
        per_pixel(bare.read_bytes),
        per_pixel(bare.written_bytes),
        ratio(rows_faster),
        ratio(half_faster)
    ));
    let said = failures(rows_faster, half_faster);
    if !bench.is_trial() && !bench.options.is_quick {
        bench.failures.extend(said);
    }
    Ok(())
}

/// What is wrong with how much faster the blur and occlusion are than their textbook versions.
fn failures(rows_faster: f64, half_faster: f64) -> Vec<String> {
    let of = |what: &str, faster: f64, least: f64| {
        // What could not be measured is no number, and a failure.
        let is_fast = faster >= least;
        (!is_fast).then(|| format!("Effects: {what} is {faster:.1} times as fast as its textbook version, not {least}"))
    };
    let blur = of("the blur in rows and columns", rows_faster, ROWS_MIN);
    blur.into_iter().chain(of("occlusion at half the size", half_faster, HALF_MIN)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn passes_of_one_effect_add_up() {
        let pass =
            |name: &str, gpu_ms: f64| json!({ "name": name, "gpu_ms": gpu_ms, "read_bytes": 8, "written_bytes": 4 });
        let passes = [pass("copy", 1.0), pass("blur.a", 2.0), pass("blur.b.2", 3.0), pass("blurred", 9.0)];
        let result = json!({ "info": { "passes": passes, "texture_bytes": 16, "texture_bytes_imported": 4 } });
        let found = Measurement::new(&result, &["blur"]).expect("measured");
        assert_eq!((found.ms, found.passes, found.copy_ms, found.texture_bytes), (5.0, 2, 1.0, 20.0));
        assert_eq!((found.read_bytes, found.written_bytes), (16.0, 8.0));
        let both = Measurement::new(&result, &["blur", "blurred"]).expect("measured");
        assert_eq!((both.ms, both.passes), (14.0, 3));
        assert_eq!(both.more_than(&found).ms, 9.0);
        assert!(Measurement::new(&json!({ "info": {} }), &["blur"]).is_err());
    }

    #[test]
    fn later_settings_take_the_place_of_earlier_ones() {
        let settings = settings_of(SHADOWS, &[("occlusion.enabled", "true")]);
        let expected = [("reflections.enabled", "false"), ("shadows.enabled", "true"), ("occlusion.enabled", "true")];
        assert_eq!(settings, expected);
    }

    #[test]
    fn every_built_in_effect_has_a_row() {
        let library = root().join("crates/render/effects");
        for entry in std::fs::read_dir(library).expect("the effects") {
            let file = entry.expect("an entry").file_name().into_string().expect("a name");
            let name = file.trim_end_matches(".wgsl");
            assert!(ROWS.iter().any(|row| row.effect == Some(name)), "{name} has no row");
        }
    }

    #[test]
    fn what_is_hardly_faster_than_its_textbook_version_is_a_failure() {
        assert_eq!(failures(8.1, 6.1), [""; 0]);
        let said = failures(7.0, f64::NAN);
        assert!(said.len() == 2 && said[0].contains("7.0 times") && said[1].contains("occlusion"), "{said:?}");
    }
}
