//! Runs the page in Chromium on both backends and judges the pictures against the native ones.

mod cases;
mod judge;
mod made;
mod turn;
mod variables;

use crate::step::{Tally, check, program, root};
use anyhow::{Context, Result, anyhow, ensure};
use cases::{CASES, Case, GROUPS};
use manypass_testkit::needs;
use serde_json::json;
use std::{path::PathBuf, process::Command};
use xtask::setup;

/// Their names in the address of the page and in files.
const BACKENDS: [&str; 2] = ["webgpu", "webgl"];

/// The same frames natively, through WebGPU and through WebGL 2. `run.mjs` fails on driver errors in the console.
/// Models that are not on this machine are skipped.
pub(crate) fn test() -> Result<Tally> {
    let chromium = setup::chromium().context("no Chromium; run `cargo xtask setup`")?;
    let assets = needs::assets_folder();
    let wanted = std::env::var("MANYPASS_BROWSER_CASES").ok();
    let is_wanted = |name: &str| wanted.as_ref().is_none_or(|wanted| wanted.split(',').any(|word| word == name));
    let cases: Vec<&Case> = CASES.iter().filter(|case| is_wanted(case.name)).collect();
    let mut found: Vec<(&Case, String)> = Vec::new();
    for case in &cases {
        found.extend(case.input(&assets)?.map(|input| (*case, input)));
    }
    let missing = cases.len() - found.len();
    if missing > 0 {
        println!("    {missing} of {} models are not on this machine and are skipped", cases.len());
    }
    ensure!(!found.is_empty(), "no model to draw");

    let told: Vec<_> = found
        .iter()
        .map(|(case, input)| {
            let (options, effects) = case.page()?;
            let variables = case.has_variables.then(variables::page);
            Ok(json!({ "name": case.name, "model": input, "width": case.size.0, "height": case.size.1,
                "groups": GROUPS.contains(&case.name), "variant": case.variant, "options": options, "effects": effects, "overlay": case.overlay()?, "time": case.time_secs,
                "variables": variables, "frames": case.frames, "settles": case.settles, "orbits": case.orbits() }))
        })
        .collect::<Result<_>>()?;
    let mut node = Command::new("node");
    node.args(["xtask/browser/run.mjs", &serde_json::to_string(&told)?]).current_dir(root()).env("CHROMIUM", chromium);
    // Both are often busy with one thread.
    let browser = std::thread::spawn(move || check(&mut node));
    let native = draw_all_natively(&found);
    let browser = browser.join().map_err(|_| anyhow!("the thread that waits for the browser panicked"))?;
    native?;

    let mut failures = Vec::new();
    for (case, _) in &found {
        if let Err(error) = judge::judge(case) {
            failures.push(format!("{}: {error:#}", case.name));
        }
    }
    ensure!(failures.is_empty(), "{}", failures.join("\n       "));
    browser?;
    Ok(Tally::step_without(missing as i64))
}

fn draw_all_natively(found: &[(&Case, String)]) -> Result<()> {
    for (case, input) in found {
        draw_natively(case, input, "native", &[])?;
        for (index, settings) in case.without.iter().enumerate() {
            draw_natively(case, input, &without(index), settings)?;
        }
    }
    if found.iter().any(|(case, _)| case.has_variables) {
        variables::draw_natively()?;
    }
    Ok(())
}

/// What a picture without what its case is for is called, and its report.
fn without(index: usize) -> String {
    format!("without-{index}")
}

/// Draws a case with the program, `settings` after its own.
fn draw_natively(case: &Case, input: &str, what: &str, settings: &[(&str, &str)]) -> Result<()> {
    let size = format!("{}x{}", case.size.0, case.size.1);
    let input = case.native_input(input)?;
    let mut command = program()?;
    command.args(["render", &input, "--size", &size]).args(case.arguments());
    command.args(settings.iter().flat_map(|(key, value)| ["--set".to_owned(), format!("{key}={value}")]));
    let report = picture(case, what).with_extension("json");
    command.args(["--samples", "1", "--quiet", "--report"]).arg(report).arg("-o");
    if case.frames == 1 {
        return check(command.arg(picture(case, what)));
    }
    let last = case.frames - 1;
    let frames = picture(case, &format!("{what}-{{frame}}"));
    check(command.arg(&frames).args(["--frames", &format!("0..{last}")]))?;
    let shown = picture(case, &format!("{what}-{last}"));
    std::fs::rename(&shown, picture(case, what)).with_context(|| format!("renaming {}", shown.display()))
}

fn picture(case: &Case, what: &str) -> PathBuf {
    root().join(format!("target/browser/{}-{what}.png", case.name))
}
