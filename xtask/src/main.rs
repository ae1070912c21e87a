//! Set-up, demo, tests and goldens: `cargo xtask`. The web package, browser tests, bench and fidelity take long to build.
//! They are in `xtask-tools`, which is built on demand.

mod jobs;
mod programs;

use anyhow::Result;
use jobs::Extent;
use std::process::Command;
use xtask::setup;
use xtask::step::{self, Steps, Tally, cargo, root};

const HELP: &str = "\
cargo xtask COMMAND

  demo      set up, build, and render the built-in demo to demo.png and its passes to demo-passes.png
              (about 4 minutes the first time)
  test      set up what is missing, then check formatting, lints, dependencies, docs, tests, web build and browsers
              (about 35 minutes on two cores)
              --no-browser   leave out the web build and the browser tests
              --quick        while you work: formatting, lints and the tests that are fast, no browser (about 10 minutes
                             where all is built); the last line counts what it left out as skipped
  web       build the web package into target/web: module, types and page; print their sizes (about 4 minutes)
              --fast         compile sooner to a larger module, for work on the package
  browser   only the browser tests, with the web package that was built last, or, where a crate changed since, one built as
              by `web --fast` (about 12 minutes); MANYPASS_BROWSER_CASES=hall,hall-echo runs some of them
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
        ["test", "--quick"] => test_quickly(&mut steps),
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

/// What comes before the tests, of the whole run and of the quick one.
fn check_form(steps: &mut Steps) {
    steps.run("Vulkan driver", "1 s; 1 min to install", setup::vulkan);
    steps.run("Python modules", "1 s; 30 s to install", setup::python);
    steps.run("formatting", "2 s", || step::check(&mut cargo(["fmt", "--all", "--check"])));
    steps.run("lints", "3 min", || {
        step::check(&mut cargo(["clippy", "--workspace", "--all-targets", "--", "-Dwarnings"]))
    });
    steps.run("lints without features", "10 s; 40 s the first time", || {
        let package = ["clippy", "-p", "manypass-scene", "--no-default-features", "--lib", "--", "-Dwarnings"];
        step::check(&mut cargo(package))
    });
}

/// Advisories, bans, licences and sources of all dependencies, where the program for it is installed.
fn dependencies() -> Result<Tally> {
    if step::output_of(&mut cargo(["deny", "--version"])).is_none() {
        println!("    SKIPPED: cargo-deny is not installed (`cargo install cargo-deny`); tests check licences");
        return Ok(Tally { skipped: 1, ..Tally::default() });
    }
    step::check(&mut cargo(["deny", "--workspace", "check"])).map(|()| Tally::step_without(0))
}

fn test_quickly(steps: &mut Steps) {
    check_form(steps);
    steps.run_counted("quick tests", "8 min", || jobs::test(Extent::Quick));
    // Dependencies, docs, tests without features, the web package and the browser tests.
    for _ in 0..5 {
        steps.leave_out();
    }
    println!("\n*** SKIPPED: slow tests, docs and browsers (--quick). Run `cargo xtask test` before you land. ***");
}

fn test(steps: &mut Steps, with_browser: bool) {
    check_form(steps);
    steps.run_counted("dependencies", "5 s", dependencies);
    steps.run("docs", "1 min", || {
        step::check(cargo(["doc", "--no-deps", "--workspace"]).env("RUSTDOCFLAGS", "-Dwarnings"))
    });
    steps.run_counted("tests", "20 min", || jobs::test(Extent::Whole));
    steps.run("tests without features", "20 s; 1 min the first time", || {
        let program = ["test", "-p", "manypass-scene", "--no-default-features", "--test", "without_features"];
        step::check(&mut cargo(program))
    });
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
