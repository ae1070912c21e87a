//! Brings what a fresh machine lacks.

use crate::step::{check, output_of, root};
use anyhow::{Context, Result, bail};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The target of the web package.
pub const WASM_TARGET: &str = "wasm32-unknown-unknown";

/// Which compiler builds for the web.
pub enum WasmCompiler {
    /// The current toolchain has the target.
    Rustup,
    /// Debian's `rustc-web`, which builds the standard library too.
    Debian,
}

/// A Vulkan driver, on Linux.
///
/// # Errors
/// There is none, and none can be installed.
pub fn vulkan() -> Result<()> {
    if cfg!(not(target_os = "linux")) {
        return Ok(());
    }
    let has_driver = |folder: &str| {
        std::fs::read_dir(folder)
            .is_ok_and(|entries| entries.flatten().any(|entry| entry.path().extension().is_some_and(|e| e == "json")))
    };
    if ["/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d"].into_iter().any(has_driver) {
        return Ok(());
    }
    apt_install(&["mesa-vulkan-drivers", "libvulkan1"])
        .context("no Vulkan driver: install Mesa's Vulkan drivers (lavapipe needs no GPU)")
}

/// A compiler for the web.
///
/// # Errors
/// There is none, and none can be installed.
pub fn wasm() -> Result<WasmCompiler> {
    if std::env::var_os("MANYPASS_WASM").is_some_and(|value| value == "debian") {
        return debian_wasm();
    }
    if has_wasm_target() {
        return Ok(WasmCompiler::Rustup);
    }
    if check(Command::new("rustup").args(["target", "add", WASM_TARGET]).current_dir(root())).is_ok()
        && has_wasm_target()
    {
        return Ok(WasmCompiler::Rustup);
    }
    debian_wasm()
}

fn has_wasm_target() -> bool {
    output_of(Command::new("rustc").args(["--print", "target-libdir", "--target", WASM_TARGET]).current_dir(root()))
        .is_some_and(|folder| Path::new(folder.trim()).exists())
}

fn debian_wasm() -> Result<WasmCompiler> {
    let present = ["/usr/bin/wasm-ld-19", "/usr/bin/cargo", "/usr/lib/rustlib/src/rust/library"];
    if !present.iter().all(|path| Path::new(path).exists()) {
        apt_install(&["rustc-web", "cargo-web", "rust-web-src", "lld-19"])
            .context("no wasm target: run `rustup target add wasm32-unknown-unknown`")?;
    }
    Ok(WasmCompiler::Debian)
}

/// Chromium, node and playwright-core. The latter drives a Chromium that is there and downloads none.
///
/// # Errors
/// One of them is not there and cannot be installed.
pub fn browser() -> Result<()> {
    if chromium().is_none() {
        apt_install(&["chromium"]).context("no browser: install Chromium, or set CHROMIUM to its path")?;
    }
    let major = output_of(Command::new("node").arg("--version"))
        .and_then(|version| version.trim_start_matches('v').split('.').next()?.parse::<u32>().ok());
    if major.is_none_or(|major| major < 18) || output_of(Command::new("npm").arg("--version")).is_none() {
        apt_install(&["nodejs", "npm"]).context("no node: install node 18 or newer, with npm")?;
    }
    let folder = root().join("target/browser");
    if folder.join("node_modules/playwright-core").exists() {
        return Ok(());
    }
    std::fs::create_dir_all(&folder)?;
    std::fs::write(folder.join("package.json"), "{\"private\":true}\n")?;
    check(Command::new("npm").args(["install", "--no-audit", "--no-fund", "playwright-core"]).current_dir(folder))
}

/// NumPy, OpenEXR and Pillow in an environment of their own, `target/python`, for the Python of the documentation.
/// Without them its tests are skipped, and say so.
///
/// # Errors
/// None: it is said where they cannot be installed.
pub fn python() -> Result<()> {
    let folder = root().join("target/python");
    let has_modules =
        || output_of(Command::new(folder.join("bin/python")).args(["-c", "import numpy, OpenEXR, PIL"])).is_some();
    if has_modules() {
        return Ok(());
    }
    let make = || -> Result<()> {
        check(Command::new("python3").args(["-m", "venv"]).arg(&folder))?;
        let mut pip = Command::new(folder.join("bin/python"));
        check(pip.args(["-m", "pip", "install", "-q", "numpy", "OpenEXR>=3.3", "pillow"]))
    };
    if let Err(error) = make() {
        println!(
            "    SKIPPED: no Python with NumPy, OpenEXR, Pillow ({error:#}); on Debian and Ubuntu install python3-venv"
        );
    }
    Ok(())
}

/// Where Debian's package `libllvm19` has its library.
const LLVM: &str = "/usr/lib/x86_64-linux-gnu/libLLVM.so.19.1";

/// Lets Mitsuba know of a libLLVM that is new enough: 15, which Mesa brings on Debian 12, lacks instructions that it
/// needs.
pub fn with_llvm(command: &mut Command) -> &mut Command {
    match std::env::var_os("DRJIT_LIBLLVM_PATH") {
        None if Path::new(LLVM).is_file() => command.env("DRJIT_LIBLLVM_PATH", LLVM),
        _ => command,
    }
}

/// The interpreter of an environment of its own, `target/mitsuba`, with Mitsuba 3.
///
/// # Errors
/// It cannot be installed, or finds no LLVM that is new enough.
pub fn mitsuba() -> Result<PathBuf> {
    let folder = root().join("target/mitsuba");
    let python = folder.join("bin/python");
    let has_modules = || output_of(Command::new(&python).args(["-c", "import numpy, mitsuba"])).is_some();
    if !has_modules() {
        check(Command::new("python3").args(["-m", "venv"]).arg(&folder))?;
        check(Command::new(&python).args(["-m", "pip", "install", "-q", "numpy", "mitsuba>=3.6"]))?;
    }
    // What LLVM 15 cannot compile ends the process.
    let script = "import mitsuba as m; m.set_variant('llvm_ad_rgb'); import drjit; \
                  print(drjit.minimum(drjit.maximum(m.Float([1, 2]), 0), m.Float([1, 3])))";
    let works = || output_of(with_llvm(Command::new(&python).args(["-c", script]))).is_some();
    if !works() {
        apt_install(&["libllvm19"])
            .context("Mitsuba needs libLLVM 16 or newer: install it, or set DRJIT_LIBLLVM_PATH to its file")?;
    }
    Ok(python)
}

/// The browser to test with: `CHROMIUM`, else the first known name on the path.
pub fn chromium() -> Option<String> {
    let named = std::env::var("CHROMIUM").ok();
    let known = ["chromium", "chromium-browser", "google-chrome"].map(str::to_owned);
    let path = std::env::var_os("PATH")?;
    let find = |name: String| {
        std::env::split_paths(&path)
            .map(|folder| folder.join(&name))
            .find(|file| file.is_file())?
            .to_str()
            .map(str::to_owned)
    };
    named.or_else(|| known.into_iter().find_map(find))
}

fn apt_install(packages: &[&str]) -> Result<()> {
    let list = packages.join(" ");
    if !Path::new("/etc/debian_version").exists() {
        bail!("this system is neither Debian nor Ubuntu, whose packages would be: {list}");
    }
    let is_root = output_of(Command::new("id").arg("-u")).is_some_and(|id| id.trim() == "0");
    let apt = |arguments: &[&str]| {
        let mut command = Command::new(if is_root { "env" } else { "sudo" });
        if !is_root {
            command.args(["-n", "env"]);
        }
        check(command.args(["DEBIAN_FRONTEND=noninteractive", "apt-get"]).args(arguments))
    };
    println!("    installing {list}");
    apt(&["update", "-qq"])?;
    apt(&[&["install", "-y", "-qq", "--no-install-recommends"], packages].concat())
        .with_context(|| format!("run `apt-get install {list}` as root"))
}
