//! Builds the web package.

use crate::step::{Tally, cargo, output_of, root};
use anyhow::{Context, Result, ensure};
use std::{
    io::{BufRead, BufReader, IsTerminal},
    path::{Path, PathBuf},
    process::{Command, Stdio},
    time::SystemTime,
};
use xtask::setup::{self, WASM_TARGET, WasmCompiler};

/// How the module is compiled.
#[derive(Clone, Copy)]
pub(crate) enum Size {
    /// The profile `web`: as small as possible.
    Small,
    /// The profile `dev`: after a change in less time, for work on the web package.
    Fast,
}

/// What becomes of the compiler's warnings.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Warnings {
    /// They are shown: another compiler may find others, and the package is good nevertheless.
    Shown,
    /// The build fails.
    Refused,
}

fn folder() -> PathBuf {
    root().join("target/web")
}

/// Whether there is a package of the sources as they are.
pub(crate) fn is_current() -> bool {
    let changed = |path: &Path| path.metadata().and_then(|metadata| metadata.modified()).ok();
    let built = ["index.html", "manypass_web.js", "manypass_raw.js", "manypass_raw_bg.wasm"]
        .map(|name| changed(&folder().join(name)));
    let oldest = built.into_iter().min().flatten();
    oldest.is_some() && oldest >= newest_below(&root().join("crates"))
}

/// When a file in `folder`, or below it, was last changed.
fn newest_below(folder: &Path) -> Option<SystemTime> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let changed = entries.filter_map(|entry| match entry.metadata() {
        Ok(metadata) if metadata.is_dir() => newest_below(&entry.path()),
        metadata => metadata.and_then(|metadata| metadata.modified()).ok(),
    });
    changed.max()
}

/// Writes `target/web`: JavaScript, types, wasm and the page.
pub(crate) fn build(size: Size, warnings: Warnings) -> Result<()> {
    let (profile, profile_folder) = match size {
        Size::Small => ("web", "web"),
        Size::Fast => ("dev", "debug"),
    };
    let arguments = ["build", "-p", "manypass-web", "--lib", "--target", WASM_TARGET, "--profile", profile];
    // Folders of their own: Debian's compiler is another version and would rebuild everything each time, and a native
    // build that runs meanwhile would have to be waited for.
    let target = match setup::wasm()? {
        WasmCompiler::Rustup => {
            let target = root().join("target/wasm-rustup");
            // Nothing reads line numbers of a wasm module.
            let mut command = cargo(arguments);
            compile(command.arg("--target-dir").arg(&target).env("CARGO_PROFILE_DEV_DEBUG", "none"), warnings)?;
            target
        }
        WasmCompiler::Debian => {
            let target = root().join("target/wasm-debian");
            // It is older than the workspace's, and its warnings are none of ours.
            compile(
                Command::new("/usr/bin/cargo")
                    .args(arguments)
                    .args(["-Zbuild-std=std,panic_abort", "--target-dir"])
                    .arg(&target)
                    .current_dir(root())
                    .env("RUSTC", "/usr/bin/rustc")
                    .env("RUSTC_BOOTSTRAP", "1")
                    .env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER", "wasm-ld-19")
                    .env_remove("RUSTUP_TOOLCHAIN"),
                Warnings::Shown,
            )?;
            target
        }
    };
    let module = target.join(WASM_TARGET).join(profile_folder).join("manypass_web.wasm");
    let folder = folder();
    std::fs::create_dir_all(&folder)?;
    wasm_bindgen_cli_support::Bindgen::new()
        .input_path(&module)
        .web(true)?
        .typescript(true)
        // What pages import stands around it: crates/web/module.
        .out_name("manypass_raw")
        .omit_default_module_path(false)
        .generate(&folder)
        .with_context(|| format!("writing the bindings of {}", module.display()))?;
    for part in ["crates/web/module", "crates/web/page"] {
        for entry in std::fs::read_dir(root().join(part))? {
            let entry = entry?;
            std::fs::copy(entry.path(), folder.join(entry.file_name()))?;
        }
    }
    for entry in std::fs::read_dir(&folder)? {
        let entry = entry?;
        let raw = std::fs::read(entry.path())?;
        let compressed = compressed_len(&entry.path()).map_or(String::new(), |bytes| format!(", {bytes} with brotli"));
        println!("    target/web/{}: {} bytes{compressed}", entry.file_name().display(), raw.len());
    }
    Ok(())
}

/// Runs cargo and shows what the compiler says. Cargo tells of warnings each time, also of what it compiled before.
fn compile(command: &mut Command, warnings: Warnings) -> Result<()> {
    let format = if std::io::stderr().is_terminal() { "json-diagnostic-rendered-ansi" } else { "json" };
    command.args(["--message-format", format]).stdout(Stdio::piped());
    let mut child = command.spawn().with_context(|| format!("starting {command:?}"))?;
    let mut has_warnings = false;
    for line in BufReader::new(child.stdout.take().context("no output to read")?).lines() {
        let line: serde_json::Value = serde_json::from_str(&line?)?;
        let message = &line["message"];
        if let Some(rendered) = message["rendered"].as_str() {
            eprint!("{rendered}");
        }
        has_warnings |= message["level"] == "warning";
    }
    let status = child.wait()?;
    ensure!(status.success(), "{command:?} ended with {status}");
    ensure!(!has_warnings || warnings == Warnings::Shown, "the compiler has warnings; they are above");
    Ok(())
}

/// The module in the package has at most so many bytes. Both ceilings are 3 % above what it had when they were set:
/// 8.87 MB, and 2.37 MB with brotli. Who needs more says here why.
const MODULE_BYTES_MAX: u64 = 9_130_000;
/// And so many as servers send it.
const MODULE_BROTLI_BYTES_MAX: u64 = 2_443_000;

/// Whether the module that was built is as small as it was. Other compilers than the workspace's make others.
pub(crate) fn check_size() -> Result<Tally> {
    if matches!(setup::wasm()?, WasmCompiler::Debian) {
        println!("    left out: the ceilings are those of the workspace's compiler");
        return Ok(Tally { skipped: 1, ..Tally::default() });
    }
    let path = folder().join("manypass_raw_bg.wasm");
    let bytes = path.metadata().with_context(|| format!("reading {}", path.display()))?.len();
    ensure!(bytes <= MODULE_BYTES_MAX, "{bytes} bytes of wasm are more than {MODULE_BYTES_MAX}");
    let Some(brotli) = compressed_len(&path) else {
        println!("    left out: node is not there, which compresses");
        return Ok(Tally::step_without(1));
    };
    ensure!(brotli <= MODULE_BROTLI_BYTES_MAX, "{brotli} bytes with brotli are more than {MODULE_BROTLI_BYTES_MAX}");
    println!("    {bytes} bytes of {MODULE_BYTES_MAX}, with brotli {brotli} of {MODULE_BROTLI_BYTES_MAX}");
    Ok(Tally::step_without(0))
}

/// The size after brotli, as servers send it; none without node.
fn compressed_len(path: &Path) -> Option<u64> {
    let script = "const fs = require('fs');\
        console.log(require('zlib').brotliCompressSync(fs.readFileSync(process.argv[1])).length)";
    output_of(Command::new("node").args(["-e", script]).arg(path))?.trim().parse().ok()
}
