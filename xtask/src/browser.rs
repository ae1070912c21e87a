//! Runs the page in Chromium on both backends and judges the pictures.

use crate::{
    compare::{Picture, check_rejects_spoilt, difference},
    setup,
    step::{check, root},
};
use anyhow::{Context, Result, ensure};
use std::process::Command;

/// The same frame through WebGPU and WebGL 2. `run.mjs` fails on driver errors in the console.
pub(crate) fn test() -> Result<()> {
    let chromium = setup::chromium().context("no Chromium; run `cargo xtask setup`")?;
    check(Command::new("node").arg("xtask/browser/run.mjs").current_dir(root()).env("CHROMIUM", chromium))?;
    let webgpu = Picture::open(&root().join("target/browser/clear-webgpu.png"))?;
    let webgl = Picture::open(&root().join("target/browser/clear-webgl.png"))?;
    let found = difference(&webgpu, &webgl)?;
    ensure!(found.agrees(), "WebGPU and WebGL 2 differ: {found:?}");
    // A plain colour cannot show a flip or a shift; once models are drawn this runs on their pictures.
    if !webgpu.is_plain() {
        check_rejects_spoilt(&webgpu)?;
    }
    Ok(())
}
