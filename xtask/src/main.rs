//! Set-up, demo, tests and goldens: `cargo xtask`. The web package, browser tests, bench and fidelity take long to build.
//! They are in `xtask-tools`, which is built on demand.

mod programs;

use anyhow::Result;
use std::process::Command;
use xtask::setup;
use xtask::step::{self, Steps, cargo, root};

const HELP: &str = "\
cargo xtask COMMAND

  demo      set up, build, and render the built-in demo to demo.png and its passes to demo-passes.png
              (about 4 minutes the first time)
  test      set up what is missing, then check formatting, lints, docs, tests, web build and browsers (about 50 minutes on two cores)
              --no-browser   leave out the web build and the browser tests
  web       build the web package into target/web: module, types and page; print their sizes (about 4 minutes)
              --fast         compile sooner to a larger module, for work on the package
  browser   only the browser tests, with the web package that was built last, or, where a crate changed since, one built as
              by `web --fast` (about 20 minutes); MANYPASS_BROWSER_CASES=hall,hall-echo runs some of them
  bench     measure every way of lighting against brute force, and the loop over lights against its limit; ratios within
              one run (about 14 minutes); `bench --help` lists its tables and options
  fidelity  render the scenes that others publish pictures of, and say how far ours are from those (about 3 minutes);
              `fidelity --help` lists its options
  goldens   write the golden pictures again; look at every change before you commit it
  setup     only set up: a Vulkan driver, the wasm target, Chromium and playwright-core, NumPy and OpenEXR

Start with `cargo xtask demo`. Every step prints its name, about how long it takes, and how long it took.
MANYPASS_WASM=debian builds for the web with Debian's compiler even where rustup's target is installed.
";

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let mut steps = Steps::default();
    match words.as_slice() {
        ["bench", ..] | ["fidelity", ..] | ["browser"] | ["web"] | ["web", "--fast"] => {
            let status = tools(&words)?.status()?;
            std::process::exit(status.code().unwrap_or(1));
        }
        [] | ["help" | "-h" | "--help", ..] | [_, "-h" | "--help"] => {
            print!("{HELP}");
            return Ok(());
        }
        ["demo"] => {
            steps.run("Vulkan driver", "1 s; 1 min to install", setup::vulkan);
            steps.run("render the demo", "4 min the first time", || {
                let view = ["--eye", "-0.9,1.5,18", "--target", "0.5,2,0", "--fov-y", "50"];
                let outputs = ["-o", "demo.png", "--contact-sheet", "demo-passes.png"];
                manypass(&[&["render", "docs/examples/nave.stage.toml"][..], &view, &outputs].concat())
            });
        }
        ["test"] => test(&mut steps, true),
        ["test", "--no-browser"] => test(&mut steps, false),
        ["goldens"] => steps.run("goldens", "3 min", || {
            step::check(cargo(["test", "--workspace", "golden"]).env("MANYPASS_GOLDENS", "write"))
        }),
        ["setup"] => {
            steps.run("Vulkan driver", "1 s; 1 min to install", setup::vulkan);
            steps.run("wasm target", "1 s; 2 min to install", || setup::wasm().map(drop));
            steps.run("browser", "1 s; 2 min to install", setup::browser);
            steps.run("Python modules", "1 s; 30 s to install", setup::python);
        }
        _ => {
            eprint!("error: unknown command `{}`\n\n{HELP}", words.join(" "));
            std::process::exit(2);
        }
    }
    steps.finish()
}

fn manypass(arguments: &[&str]) -> Result<()> {
    step::check(
        cargo(["run", "--profile", "demo", "-p", "manypass-cli", "--no-default-features", "--"]).args(arguments),
    )
}

/// The program of what needs more than `xtask` is linked with. It is built with all features that the workspace asks of
/// its dependencies, as for the tests: with those that it asks for alone, they would be compiled once more.
fn tools(arguments: &[&str]) -> Result<Command> {
    step::check(&mut cargo(["build", "--workspace", "--bin", "xtask-tools"]))?;
    let program = format!("target/debug/xtask-tools{}", std::env::consts::EXE_SUFFIX);
    let mut command = Command::new(root().join(program));
    command.args(arguments);
    Ok(command)
}

fn test(steps: &mut Steps, with_browser: bool) {
    steps.run("Vulkan driver", "1 s; 1 min to install", setup::vulkan);
    steps.run("Python modules", "1 s; 30 s to install", setup::python);
    steps.run("formatting", "2 s", || step::check(&mut cargo(["fmt", "--all", "--check"])));
    steps.run("lints", "3 min", || {
        step::check(&mut cargo(["clippy", "--workspace", "--all-targets", "--", "-Dwarnings"]))
    });
    steps.run("docs", "1 min", || {
        step::check(cargo(["doc", "--no-deps", "--workspace"]).env("RUSTDOCFLAGS", "-Dwarnings"))
    });
    steps.run_counted("tests", "30 min", programs::test);
    if with_browser {
        match tools(&["test"]) {
            Ok(mut command) => steps.run_program("web package and browser tests", &mut command),
            Err(error) => steps.run("web package and browser tests", "1 s", || Err(error)),
        }
    } else {
        // The web package, its size and the browser tests.
        steps.leave_out();
        steps.leave_out();
        steps.leave_out();
        println!(
            "\n*** SKIPPED: the web build and the browser tests (--no-browser). Run `cargo xtask test` before you land. ***"
        );
    }
}
