//! What the frame costs, as ratios within one run: every row names its counters, and counts only if its picture is the
//! one that brute force draws.

use crate::step::{cargo, check, open_picture, output_of, root};
use anyhow::{Context, Result, ensure};
use manypass_testkit::compare::{self, Tolerance};
use manypass_testkit::needs;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The frames of a row at most, and the milliseconds after which no more are begun.
const FRAMES: &str = "12";
const BUDGET_MS: &str = "6000";

struct Row {
    name: String,
    input: String,
    size: &'static str,
}

pub(crate) fn run() -> Result<()> {
    check(&mut cargo(["build", "--release", "-p", "manypass-cli"]))?;
    println!("\nThe frame graph, one core:");
    check(cargo(["bench", "--quiet", "-p", "manypass-graph", "--bench", "plan"]).env("RUST_LOG", "off"))?;
    println!("\nA frame of 10,000 nodes with as many meshes, outside the adapter:");
    check(cargo(["bench", "--quiet", "-p", "manypass", "--bench", "nodes"]).env("RUST_LOG", "off"))?;
    println!("\nLights, without shadows and anti-aliasing (pairs: of pixel and light):");
    println!(
        "{:18} {:>8} {:>9} {:>9} {:>9} {:>9} {:>9} {:>10} {:>9}  picture",
        "scene", "lights", "ms", "forward", "brute", "visited", "culling", "entries", "triangles"
    );
    println!(
        "{:18} {:>8} {:>9} {:>9} {:>9} {:>9} {:>9} {:>10} {:>9}",
        "", "", "median", "ratio", "ratio", "/in range", "ms", "in lists", ""
    );
    let mut failures = Vec::new();
    for row in rows() {
        if let Err(error) = print_row(&row) {
            failures.push(format!("{}: {error:#}", row.name));
        }
    }
    println!("\nTextures of the plan at 1920x1080:");
    let hd = measure(&Row { name: "hall-hd".into(), input: "demo:hall".into(), size: "1920x1080" }, &["--count", "1"])?;
    let bytes = |key: &str| hd["info"][key].as_f64().unwrap_or(0.0) / f64::from(1 << 20);
    let (aliased, unaliased) = (bytes("texture_bytes"), bytes("texture_bytes_unaliased"));
    println!("demo:hall {aliased:.1} MiB; without sharing memory {unaliased:.1} MiB");
    ensure!(failures.is_empty(), "{}", failures.join("\n       "));
    Ok(())
}

/// The demo, and the fields of lights where they are.
fn rows() -> Vec<Row> {
    let mut rows = vec![Row { name: "demo:hall".into(), input: "demo:hall".into(), size: "960x540" }];
    let folder = needs::assets_folder().join("lightfield");
    let fields = [16, 64, 256, 1024, 4096, 10_000].map(|count| (format!("lightfield_{count}"), "960x540"));
    for (name, size) in fields.into_iter().chain([("overdraw".to_owned(), "480x270")]) {
        let file = folder.join(format!("{name}.glb"));
        if file.is_file() {
            rows.push(Row { name, input: file.display().to_string(), size });
        }
    }
    if rows.len() == 1 {
        println!("    (the fields of lights are not on this machine; they are left out)");
    }
    rows
}

fn program() -> PathBuf {
    root().join("target/release").join(format!("manypass{}", std::env::consts::EXE_SUFFIX))
}

fn picture_path(row: &Row, what: &str) -> PathBuf {
    root().join("target").join(format!("bench-{}-{what}.png", row.name.replace(':', "-")))
}

fn measure(row: &Row, arguments: &[&str]) -> Result<Value> {
    let mut command = Command::new(program());
    command.args(["bench", &row.input, "--size", row.size, "--json"]).args(arguments);
    let text = output_of(&mut command).with_context(|| format!("{command:?} failed"))?;
    serde_json::from_str(text.trim()).with_context(|| format!("{command:?} printed no JSON"))
}

fn median_ms(result: &Value) -> f64 {
    let mut frames: Vec<f64> = result["frames"].as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
    frames.sort_by(f64::total_cmp);
    frames.get(frames.len() / 2).copied().unwrap_or(f64::NAN)
}

fn print_row(row: &Row) -> Result<()> {
    let [clustered, brute] = ["clustered", "brute"].map(|what| picture_path(row, what));
    let limits = ["--count", FRAMES, "--budget-ms", BUDGET_MS];
    let with_png = |path: &Path| path.display().to_string();
    let result = measure(row, &[&limits[..], &["--png", &with_png(&clustered)]].concat())?;
    let forward = measure(row, &[&limits[..], &["--path", "forward"]].concat())?;
    // A single frame, because it may take a minute.
    let one = ["--count", "1", "--budget-ms", "1", "--light-culling", "none", "--png", &with_png(&brute)];
    let brute_force = measure(row, &one)?;
    let found = compare::difference(&open_picture(&clustered)?, &open_picture(&brute)?, Tolerance::default().within);
    let info = &result["info"];
    let number = |key: &str| info[key].as_f64().unwrap_or(f64::NAN);
    let ms = median_ms(&result);
    println!(
        "{:18} {:>8} {ms:>9.1} {:>9.2} {:>9.2} {:>9.2} {:>9.2} {:>10} {:>9}  {}",
        row.name,
        number("lights"),
        median_ms(&forward) / ms,
        median_ms(&brute_force) / ms,
        number("visited_over_in_range"),
        number("culling_ms"),
        number("list_entries"),
        number("triangles"),
        if found.is_within(Tolerance::default()) { "as brute force" } else { "DIFFERS" },
    );
    for pass in info["passes"].as_array().into_iter().flatten() {
        let name = pass["name"].as_str().unwrap_or_default();
        let ms = |key: &str| pass[key].as_f64().map_or_else(|| "-".to_owned(), |ms| format!("{ms:.2}"));
        println!("    {name:16} {:>8} ms, recorded in {} ms", ms("gpu_ms"), ms("cpu_ms"));
    }
    ensure!(found.is_within(Tolerance::default()), "the picture is not that of brute force: {found}");
    Ok(())
}
