//! How far our pictures are from those that others publish of the same files, and from a path tracer's.

mod as_published;
mod made;
mod options;
mod pictures;
mod published;
mod scenarios;
mod traced;

pub(crate) use options::{HELP, Options};

use crate::step::{cargo, check, output_of, root};
use crate::table::Report;
use anyhow::{Context, Result, ensure};
use options::Table;
use std::path::PathBuf;
use std::process::Command;

/// A run: what was asked for, what was found, what is wrong.
struct Fidelity<'a> {
    options: &'a Options,
    program: PathBuf,
    /// What leaves out what published pictures do not have, as far as the program knows it: a floor below models, and
    /// what surfaces hide and reflect of each other in the picture.
    left_out: Vec<&'static str>,
    folder: PathBuf,
    report: Report,
    failures: Vec<String>,
}

/// Renders and compares what the options name.
///
/// # Errors
/// Something could not be rendered or compared, or we are farther off than we may be. What could be compared is printed
/// and written.
pub(crate) fn run(options: &Options) -> Result<()> {
    let program = match &options.program {
        Some(program) => program.canonicalize().with_context(|| format!("{} is not there", program.display()))?,
        None => {
            check(&mut cargo(["build", "--release", "-p", "manypass-cli"]))?;
            root().join("target/release").join(format!("manypass{}", std::env::consts::EXE_SUFFIX))
        }
    };
    let folder = options.out.clone().unwrap_or_else(|| root().join("target/fidelity"));
    std::fs::create_dir_all(&folder).with_context(|| format!("making {}", folder.display()))?;
    let help = output_of(Command::new(&program).args(["render", "--help"])).unwrap_or_default();
    let settings = output_of(Command::new(&program).arg("settings")).unwrap_or_default();
    let mut left_out = Vec::new();
    if help.contains("--ground") {
        left_out.extend(["--ground", "none"]);
    }
    if settings.contains("effects.enabled") {
        left_out.extend(["--set", "effects.enabled=false"]);
    }
    let mut run = Fidelity { options, program, left_out, folder, report: Report::default(), failures: Vec::new() };
    for table in &options.tables {
        let printed = match table {
            Table::Published => published::print(&mut run),
            Table::Traced => traced::print(&mut run),
        };
        if let Err(error) = printed {
            run.failures.push(format!("{table:?}: {error:#}"));
        }
    }
    if let Some(path) = &options.markdown {
        let text = run.report.markdown("Measured by `cargo xtask fidelity`.");
        std::fs::write(path, text).with_context(|| format!("writing {}", path.display()))?;
    }
    println!("Sheets and numbers are in {}", run.folder.display());
    ensure!(run.failures.is_empty(), "{}", run.failures.join("\n       "));
    Ok(())
}
