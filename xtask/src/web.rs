//! Builds the web package.

use crate::{
    setup::{self, WASM_TARGET, WasmCompiler},
    step::{cargo, check, root},
};
use anyhow::{Context, Result};
use std::process::Command;

/// Writes `target/web`: JavaScript, types, wasm and the page.
pub(crate) fn build() -> Result<()> {
    let arguments = ["build", "-p", "manypass-web", "--lib", "--target", WASM_TARGET, "--profile", "web"];
    // A folder of its own: Debian's compiler is another version, and would rebuild everything each time.
    let target = match setup::wasm()? {
        WasmCompiler::Rustup => {
            check(&mut cargo(arguments))?;
            root().join("target")
        }
        WasmCompiler::Debian => {
            let target = root().join("target/wasm-web");
            check(
                Command::new("/usr/bin/cargo")
                    .args(arguments)
                    .args(["-Zbuild-std=std,panic_abort", "--target-dir"])
                    .arg(&target)
                    .current_dir(root())
                    .env("RUSTC", "/usr/bin/rustc")
                    .env("RUSTC_BOOTSTRAP", "1")
                    .env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER", "wasm-ld-19")
                    .env_remove("RUSTUP_TOOLCHAIN"),
            )?;
            target
        }
    };
    let module = target.join(WASM_TARGET).join("web/manypass_web.wasm");
    let folder = root().join("target/web");
    std::fs::create_dir_all(&folder)?;
    wasm_bindgen_cli_support::Bindgen::new()
        .input_path(&module)
        .web(true)?
        .typescript(true)
        .generate(&folder)
        .with_context(|| format!("writing the bindings of {}", module.display()))?;
    let page = root().join("crates/web/page");
    for entry in std::fs::read_dir(&page)? {
        let entry = entry?;
        std::fs::copy(entry.path(), folder.join(entry.file_name()))?;
    }
    for entry in std::fs::read_dir(&folder)? {
        let entry = entry?;
        println!("    target/web/{}: {} bytes", entry.file_name().display(), entry.metadata()?.len());
    }
    Ok(())
}
