//! Steps and programs, as `xtask` has them, and what the programs write: pictures and JSON.

use anyhow::{Context, Result, bail};
use manypass_testkit::compare::Picture;
use serde_json::Value;
use std::path::Path;
use std::process::Command;
use std::sync::{Mutex, PoisonError};
pub(crate) use xtask::step::{Steps, Tally, cargo, check, output_of, root};

/// A picture file in memory.
pub(crate) fn open_picture(path: &Path) -> Result<Picture> {
    let image = image::open(path).with_context(|| format!("reading {}", path.display()))?.to_rgba8();
    Ok(Picture::from_rgba8(image.width() as usize, image.height() as usize, image.as_raw()))
}

/// The program as the tests have it, in the repository's root. Built for itself it would have other features of its
/// dependencies, and compile them once more.
pub(crate) fn program() -> Result<Command> {
    static IS_BUILT: Mutex<bool> = Mutex::new(false);
    let mut is_built = IS_BUILT.lock().unwrap_or_else(PoisonError::into_inner);
    if !*is_built {
        check(&mut cargo(["test", "--quiet", "--workspace", "--no-run", "--test", "signals"]))?;
        *is_built = true;
    }
    let mut command = Command::new(root().join("target/debug/manypass"));
    command.current_dir(root());
    Ok(command)
}

/// The last line of a program's output that is a JSON object.
pub(crate) fn last_json(command: &mut Command) -> Result<Value> {
    let output = command.env("RUST_LOG", "off").output().with_context(|| format!("starting {command:?}"))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        // A hint may follow the error, and the driver's words may come before it.
        let error = said.lines().rfind(|line| line.starts_with("error")).unwrap_or(&said);
        bail!("{command:?} ended with {}: {}", output.status, error.trim());
    }
    let text = String::from_utf8_lossy(&output.stdout);
    let line = text.lines().rev().find(|line| line.starts_with('{'));
    let line = line.with_context(|| format!("{command:?} printed no JSON"))?;
    serde_json::from_str(line).with_context(|| format!("{command:?} printed no JSON"))
}
