//! What the frame costs, as ratios within one run: every row names its counters, and counts only if its picture is the
//! one that brute force draws.

mod antialiasing;
mod baking;
mod baseline;
mod captures;
mod decals;
mod effects;
mod environment;
mod fields;
mod growth;
mod levels;
mod limit;
mod machine;
mod measure;
mod options;
mod quality;
mod simulations;
mod stage;
mod way;
mod ways;

pub(crate) use options::{HELP, Options, TableName};

use crate::step::{cargo, check, last_json, output_of, root};
use crate::table::Report;
use anyhow::{Context, Result, ensure};
use limit::Limit;
use machine::Machine;
use manypass_testkit::needs;
use measure::{Measurements, Scene};
use std::process::Command;

/// As many maps as every tenth of 10,000 point lights needs.
const SHADOW_MAPS: &str = "shadows.maps=6000";

/// A run: what was asked for, what was measured, what is wrong.
struct Bench<'a> {
    options: &'a Options,
    measurements: Measurements,
    report: Report,
    failures: Vec<String>,
    limit: Option<Limit>,
}

/// Measures what the options name.
///
/// # Errors
/// Something could not be measured, or a picture is not that of brute force. What could be measured is printed and
/// written.
pub(crate) fn run(options: &Options) -> Result<()> {
    let built = || root().join("target/release").join(format!("manypass{}", std::env::consts::EXE_SUFFIX));
    let program = match &options.program {
        Some(program) => program.canonicalize().with_context(|| format!("{} is not there", program.display()))?,
        None => {
            check(&mut cargo(["build", "--release", "-p", "manypass-cli"]))?;
            built()
        }
    };
    let folder = root().join("target/bench");
    std::fs::create_dir_all(&folder).with_context(|| format!("making {}", folder.display()))?;
    let measurements = Measurements::new(program, folder);
    let mut bench = Bench { options, measurements, report: Report::default(), failures: Vec::new(), limit: None };
    if options.tables.contains(&TableName::Fields) {
        let limit = bench.measure_limit()?;
        println!("\nThe limit of lighting: {:.2} ns a pair of pixel and light on {}", limit.ns_per_pair, limit.adapter);
    }
    for table in &options.tables {
        if let Err(error) = bench.print(*table) {
            bench.failures.push(format!("{table:?}: {error:#}"));
        }
    }
    bench.write_markdown()?;
    ensure!(bench.failures.is_empty(), "{}", bench.failures.join("\n       "));
    Ok(())
}

impl Bench<'_> {
    fn print(&mut self, table: TableName) -> Result<()> {
        match (table, &self.options.baseline) {
            (TableName::Graph, _) => {
                println!("\nThe frame graph, one core:");
                check(cargo(["bench", "--quiet", "-p", "manypass-graph", "--bench", "plan"]).env("RUST_LOG", "off"))?;
                println!(
                    "\nA frame of 10,000 nodes with as many meshes, and of up to a million with one, outside the adapter:"
                );
                check(cargo(["bench", "--quiet", "-p", "manypass", "--bench", "nodes"]).env("RUST_LOG", "off"))
            }
            (TableName::Ways, _) => ways::print(self, false),
            (TableName::Shadows, _) => ways::print(self, true),
            (TableName::Fields, _) => fields::print(self),
            (TableName::Textures, _) => self.print_textures(),
            (TableName::Levels, _) => levels::print(self),
            (TableName::Effects, _) => effects::print(self),
            (TableName::Antialiasing, _) => antialiasing::print(self),
            (TableName::Quality, _) => quality::print(self),
            (TableName::Captures, _) => captures::print(self),
            (TableName::Decals, _) => decals::print(self),
            (TableName::Simulations, _) => simulations::print(self),
            (TableName::Environment, _) => environment::print(self),
            (TableName::Growth, _) => growth::print(self),
            (TableName::Baking, _) => baking::print(self),
            (TableName::Baseline, Some(other)) => baseline::print(self, other),
            (TableName::Baseline, None) => Ok(()),
        }
    }

    /// Whether a program was named, which need not be a release build.
    const fn is_trial(&self) -> bool {
        self.options.program.is_some()
    }

    /// Measures the limit once more; the least until now.
    fn measure_limit(&mut self) -> Result<Limit> {
        let limit = Limit::measure(self.is_trial())?.or_less(self.limit.take());
        self.limit = Some(limit.clone());
        Ok(limit)
    }

    /// The fields that are on this machine, of the numbers of lights that were asked for.
    fn field_scenes(&self, is_shadowed: bool) -> Result<Vec<(usize, Scene)>> {
        let folder = needs::assets_folder().join("lightfield");
        let mut scenes = Vec::new();
        for &lights in &self.options.lights {
            let file = folder.join(format!("lightfield_{lights}.glb"));
            if !file.is_file() {
                continue;
            }
            let mut scene = Scene::new(&format!("lightfield_{lights}"), &file.display().to_string(), (960, 540));
            if is_shadowed {
                scene.name += "-shadowed";
                scene.input = stage::write_stage(&self.measurements.folder, &file)?.display().to_string();
                scene.arguments = ["--set", "shadows.enabled=true", "--set", SHADOW_MAPS].map(str::to_owned).to_vec();
            }
            scenes.push((lights, scene));
        }
        Ok(scenes)
    }

    fn print_textures(&mut self) -> Result<()> {
        let mut command = Command::new(&self.measurements.program);
        command.args(["bench", "demo:hall", "--size", "1920x1080", "--json", "--count", "1"]);
        let result = last_json(&mut command)?;
        let mebibytes = |key: &str| {
            let bytes = result["info"][key].as_f64().unwrap_or(f64::NAN);
            format!("{:.1}", bytes / f64::from(1 << 20))
        };
        let columns = [("scene", 18), ("textures, MiB", 9), ("without sharing memory, MiB", 9)];
        self.report.begin("Textures of the plan at 1920x1080", &columns);
        self.report.row(vec!["demo:hall".into(), mebibytes("texture_bytes"), mebibytes("texture_bytes_unaliased")]);
        Ok(())
    }

    /// The adapter's name, from what was measured, or from the program.
    fn adapter(&self) -> String {
        let asked = || {
            let text = output_of(Command::new(&self.measurements.program).args(["adapters", "--json"]))?;
            let adapters: serde_json::Value = serde_json::from_str(&text).ok()?;
            adapters[0]["name"].as_str().map(str::to_owned)
        };
        let measured = self.measurements.adapter().map(str::to_owned);
        measured.or_else(asked).unwrap_or_else(|| "an unknown adapter".into())
    }

    fn write_markdown(&self) -> Result<()> {
        let Some(path) = &self.options.markdown else {
            return Ok(());
        };
        let machine = Machine::with_adapter(&self.adapter());
        let text = self.report.markdown(&format!("Measured by `cargo xtask bench` {machine}."));
        std::fs::write(path, text).with_context(|| format!("writing {}", path.display()))
    }
}
