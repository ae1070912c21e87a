//! What a test needs of the machine, and how it says that it had nothing to look at.

use std::collections::BTreeSet;
use std::fmt::Display;
use std::io::Write;
use std::panic::Location;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// What the line of a skipped test begins with. `cargo xtask test` counts those lines as skipped, not as passed.
pub const SKIPPED: &str = "SKIPPED";

/// Says, once for every test, that it is skipped and why; the test then returns.
#[track_caller]
pub fn skip(reason: impl Display) {
    static SAID: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    // The harness names the thread of a test after the test.
    let test = std::thread::current().name().map_or_else(|| Location::caller().to_string(), str::to_owned);
    let is_first = SAID.lock().is_ok_and(|mut said| said.insert(test.clone()));
    if is_first {
        // Not through `println!`, which the harness hides where a test passes.
        let _ = writeln!(std::io::stdout().lock(), "{SKIPPED} {test}: {reason}");
    }
}

/// The folder `part` of the models that are not in the repository. Without it the test is skipped.
///
/// They are looked for in `MANYPASS_ASSETS`, else in `shared/assets` beside the repository.
#[track_caller]
pub fn assets(part: &str) -> Option<PathBuf> {
    let folder = assets_folder().join(part);
    if folder.is_dir() {
        return Some(folder);
    }
    skip(format_args!("there is no folder {}; MANYPASS_ASSETS names another place for it", folder.display()));
    None
}

/// Where the models are that are not in the repository, whether or not they are on this machine.
pub fn assets_folder() -> PathBuf {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/assets");
    std::env::var_os("MANYPASS_ASSETS").map_or_else(beside, PathBuf::from)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::Command;

    /// Runs itself again without models, in a process of its own, whose output is what `cargo xtask test` would read.
    #[test]
    fn a_test_without_its_models_says_so_once_although_it_passes() {
        const NOWHERE: &str = "no-such-folder";
        if std::env::var_os("MANYPASS_ASSETS").is_some_and(|folder| folder == NOWHERE) {
            assert!(assets("models").is_none() && assets("pictures").is_none());
            return;
        }
        let name = "needs::tests::a_test_without_its_models_says_so_once_although_it_passes";
        let mut again = Command::new(std::env::current_exe().expect("this program"));
        let output = again.args(["--exact", name]).env("MANYPASS_ASSETS", NOWHERE).output().expect("it starts");
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success() && said.contains("1 passed; 0 failed"), "{said}");
        let skipped: Vec<&str> = said.lines().filter(|line| line.contains(SKIPPED)).collect();
        assert!(
            matches!(skipped[..], [line] if line.contains(name) && line.contains("no-such-folder/models")),
            "{said}"
        );
    }
}
