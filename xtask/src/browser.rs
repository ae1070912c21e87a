//! Runs the page in Chromium on both backends and judges the pictures against the native ones.

use crate::{
    setup,
    step::{Tally, cargo, check, open_picture, root},
};
use anyhow::{Context, Result, ensure};
use manypass_testkit::{
    compare::{self, Difference, Picture, Tolerance},
    needs,
};
use std::{
    path::{Path, PathBuf},
    process::Command,
};

/// A model that is drawn natively and in the browser.
struct Case {
    name: &'static str,
    /// `demo:NAME`, or a file below the shared assets.
    model: &'static str,
    size: (u32, u32),
    way: Way,
}

/// How a model is drawn.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Way {
    Deferred,
    Forward,
    /// With an effect that has a setting and reads what it made in the frame before.
    Echo,
}

/// The effect of [`Way::Echo`].
const ECHO: &str = "xtask/browser/echo.wgsl";

/// The cases whose lights are also drawn in eight groups that must add up.
const GROUPS: [&str; 2] = ["hall", "lightfield_10000"];
const SQUARE: (u32, u32) = (256, 256);
const WIDE: (u32, u32) = (320, 180);

const fn case(name: &'static str, model: &'static str, size: (u32, u32)) -> Case {
    Case { name, model, size, way: Way::Deferred }
}

const CASES: [Case; 13] = [
    Case { way: Way::Echo, ..case("hall-echo", "demo:hall", WIDE) },
    Case { way: Way::Forward, ..case("hall-forward", "demo:hall", WIDE) },
    case("hall", "demo:hall", WIDE),
    case("shadow_mapping_spots", "renderling/shadow_mapping_spots.glb", SQUARE),
    case("lightfield_1024", "lightfield/lightfield_1024.glb", (960, 540)),
    case("lightfield_10000", "lightfield/lightfield_10000.glb", (960, 540)),
    case("DamagedHelmet", "", SQUARE),
    case("BoxTextured", "", SQUARE),
    case("NormalTangentMirrorTest", "", SQUARE),
    case("AlphaBlendModeTest", "", SQUARE),
    case("CesiumMan", "", SQUARE),
    case("MorphStressTest", "", SQUARE),
    case("TextureSettingsTest", "", SQUARE),
];

impl Case {
    /// The flags of the command line.
    fn arguments(&self) -> &'static [&'static str] {
        match self.way {
            Way::Deferred => &[],
            Way::Forward => &["--path", "forward"],
            Way::Echo => &["--effect", ECHO, "--set", "echo.share=0.25"],
        }
    }

    /// What the page is told: options of `configure`, and effects.
    fn page(&self) -> Result<(serde_json::Value, serde_json::Value)> {
        let effect = || -> Result<serde_json::Value> {
            let source = std::fs::read_to_string(root().join(ECHO))?;
            Ok(serde_json::json!([{ "file": ECHO, "source": source, "settings": { "echo.share": 0.25 } }]))
        };
        Ok(match self.way {
            Way::Deferred => (serde_json::json!({}), serde_json::json!([])),
            Way::Forward => (serde_json::json!({ "path": "forward" }), serde_json::json!([])),
            Way::Echo => (serde_json::json!({}), effect()?),
        })
    }

    /// What the command line and the browser are given; none if this machine does not have the model.
    fn input(&self, assets: &Path) -> Option<String> {
        if self.model.starts_with("demo:") {
            return Some(self.model.to_owned());
        }
        let name = self.name;
        let path = match self.model {
            "" => assets.join(format!("khronos-sample-assets/Models/{name}/glTF-Binary/{name}.glb")),
            model => assets.join(model),
        };
        path.is_file().then(|| path.display().to_string())
    }
}

/// The same frames natively, through WebGPU and through WebGL 2. `run.mjs` fails on driver errors in the console.
/// Models that are not on this machine are skipped.
pub(crate) fn test() -> Result<Tally> {
    let chromium = setup::chromium().context("no Chromium; run `cargo xtask setup`")?;
    let assets = needs::assets_folder();
    let wanted = std::env::var("MANYPASS_BROWSER_CASES").ok();
    let is_wanted = |name: &str| wanted.as_ref().is_none_or(|wanted| wanted.split(',').any(|word| word == name));
    let cases: Vec<&Case> = CASES.iter().filter(|case| is_wanted(case.name)).collect();
    let found: Vec<(&Case, String)> = cases.iter().filter_map(|case| Some((*case, case.input(&assets)?))).collect();
    let missing = cases.len() - found.len();
    if missing > 0 {
        println!("    {missing} of {} models are not on this machine and are skipped", cases.len());
    }
    ensure!(!found.is_empty(), "no model to draw");

    for (case, input) in &found {
        let size = format!("{}x{}", case.size.0, case.size.1);
        let arguments = ["run", "--quiet", "-p", "manypass-cli", "--", "render", input, "--size", &size];
        let report = picture(case, "native").with_extension("json");
        let mut command = cargo(arguments);
        command.args(case.arguments());
        command.args(["--samples", "1", "--quiet", "--report"]).arg(report).arg("-o").arg(picture(case, "native"));
        check(&mut command)?;
    }
    let cases: Vec<_> = found
        .iter()
        .map(|(case, input)| {
            let (options, effects) = case.page()?;
            Ok(serde_json::json!({ "name": case.name, "model": input, "width": case.size.0, "height": case.size.1,
                "groups": GROUPS.contains(&case.name), "options": options, "effects": effects }))
        })
        .collect::<Result<_>>()?;
    let browser = check(
        Command::new("node")
            .args(["xtask/browser/run.mjs", &serde_json::to_string(&cases)?])
            .current_dir(root())
            .env("CHROMIUM", chromium),
    );

    let mut failures = Vec::new();
    for (case, _) in &found {
        if let Err(error) = judge(case) {
            failures.push(format!("{}: {error:#}", case.name));
        }
    }
    ensure!(failures.is_empty(), "{}", failures.join("\n       "));
    browser?;
    Ok(Tally::step_without(missing as i64))
}

fn picture(case: &Case, what: &str) -> PathBuf {
    root().join(format!("target/browser/{}-{what}.png", case.name))
}

fn difference(a: &Picture, b: &Picture) -> Result<Difference> {
    let sizes = [a, b].map(|picture| (picture.width, picture.height));
    ensure!(sizes[0] == sizes[1], "the sizes differ: {sizes:?}");
    Ok(compare::difference(a, b, Tolerance::RASTERIZERS.within))
}

/// Backends may meter a scene this far apart.
const EXPOSURE_TOLERANCE_STOPS: f64 = 0.02;

/// What is wrong with the exposures that were metered, if anything.
fn exposure_fault(case: &Case) -> Result<Option<String>> {
    let read = |path: PathBuf| -> Result<serde_json::Value> { Ok(serde_json::from_slice(&std::fs::read(path)?)?) };
    let native = read(picture(case, "native").with_extension("json"))?["exposure"]["stops"].as_f64();
    for backend in ["webgpu", "webgl"] {
        let path = root().join(format!("target/browser/{}-{backend}-exposure.json", case.name));
        let found = read(path)?["stops"].as_f64();
        let is_same = native.zip(found).is_some_and(|(a, b)| (a - b).abs() <= EXPOSURE_TOLERANCE_STOPS);
        if !is_same {
            return Ok(Some(format!("{backend} takes an exposure of {found:?} stops, native {native:?}")));
        }
    }
    Ok(None)
}

/// Prints every difference before it fails at one.
fn judge(case: &Case) -> Result<()> {
    let native = open_picture(&picture(case, "native"))?;
    for (name, spoilt) in compare::mutations(&native) {
        let found = difference(&native, &spoilt)?;
        ensure!(!found.is_within(Tolerance::RASTERIZERS), "the comparison would accept the picture {name}: {found}");
    }
    let mut refused = Vec::new();
    for backend in ["webgpu", "webgl"] {
        let drawn = open_picture(&picture(case, backend))?;
        let found = difference(&native, &drawn)?;
        println!("    {:24} {backend:6} against native: {found}", case.name);
        if !found.is_within(Tolerance::RASTERIZERS) {
            refused.push(format!("{backend} differs from native: {found}"));
        }
        // A screenshot is composited by the browser, but without scaling and in sRGB.
        let shown = difference(&drawn, &open_picture(&picture(case, &format!("{backend}-canvas")))?)?;
        // The echo grew with the frame in between.
        if case.way != Way::Echo && !shown.is_within(Tolerance::default()) {
            refused.push(format!("the canvas does not show the picture on {backend}: {shown}"));
        }
    }
    refused.extend(exposure_fault(case)?);
    // One rasterizer stands behind both, so here nothing but rounding may differ.
    let [webgpu, webgl] = ["webgpu", "webgl"].map(|backend| open_picture(&picture(case, backend)));
    let between = difference(&webgpu?, &webgl?)?;
    if !between.is_within(Tolerance::default()) {
        refused.push(format!("webgl differs from webgpu: {between}"));
    }
    ensure!(refused.is_empty(), "{}", refused.join("; "));
    Ok(())
}
