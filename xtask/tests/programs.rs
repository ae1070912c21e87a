//! Every file of tests is compiled: it is a program, or a module of one. Packages without `autotests` would leave a new
//! file out without a word.

use manypass_testkit::pages::root;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The packages as cargo knows them.
fn packages() -> Vec<Value> {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["metadata", "--format-version", "1", "--no-deps", "--offline"]).current_dir(root());
    let output = cargo.output().expect("cargo starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    metadata["packages"].as_array().expect("packages").clone()
}

/// The files of the programs with tests of a package.
fn programs(package: &Value) -> Vec<PathBuf> {
    let targets = package["targets"].as_array().expect("targets").iter();
    let tests = targets.filter(|target| target["kind"][0] == "test");
    tests.map(|target| target["src_path"].as_str().expect("a path").into()).collect()
}

/// The files of the modules that a file declares; `owns_folder` says whether they lie beside it, as those of `mod.rs`.
fn modules(file: &Path, text: &str, owns_folder: bool) -> Vec<(PathBuf, bool)> {
    let beside = file.parent().expect("a folder");
    let folder = if owns_folder { beside.to_owned() } else { file.with_extension("") };
    let (mut found, mut path) = (Vec::new(), None);
    for line in text.lines() {
        let line = line.strip_prefix("pub ").unwrap_or(line);
        if let Some(name) = line.strip_prefix("#[path = \"").and_then(|rest| rest.strip_suffix("\"]")) {
            path = Some(beside.join(name));
        } else if let Some(name) = line.strip_prefix("mod ").and_then(|rest| rest.strip_suffix(';')) {
            let nested = folder.join(name).join("mod.rs");
            let flat = folder.join(name).with_extension("rs");
            found.push(match path.take() {
                Some(path) => (path, true),
                None if nested.is_file() => (nested, true),
                None => (flat, false),
            });
        }
    }
    found
}

/// A file and all that are modules of it.
fn collect(file: &Path, owns_folder: bool, found: &mut BTreeSet<PathBuf>) {
    let text = std::fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    if found.insert(file.to_owned()) {
        for (module, owns_folder) in modules(file, &text, owns_folder) {
            collect(&module, owns_folder, found);
        }
    }
}

/// All Rust files below a folder; none where it is not there.
pub fn below(folder: &Path, files: &mut BTreeSet<PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten() {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            below(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.insert(path);
        }
    }
}

#[test]
fn every_file_of_tests_is_in_a_program() {
    let (mut lost, mut count) = (Vec::new(), 0);
    for package in packages() {
        let manifest = Path::new(package["manifest_path"].as_str().expect("a path"));
        let (mut there, mut compiled) = (BTreeSet::new(), BTreeSet::new());
        below(&manifest.parent().expect("a folder").join("tests"), &mut there);
        for program in programs(&package) {
            collect(&program, true, &mut compiled);
        }
        count += there.len();
        lost.extend(there.difference(&compiled).map(|file| file.display().to_string()));
    }
    assert!(count > 150, "{count} files");
    assert!(lost.is_empty(), "add a line `mod NAME;` to tests/all.rs, or a [[test]], for\n{}", lost.join("\n"));
}

#[test]
fn modules_are_found_where_the_compiler_looks() {
    let names = |file: &str, text: &str, owns_folder: bool| {
        let found = modules(Path::new(file), text, owns_folder);
        found.into_iter().map(|(path, owns_folder)| (path.display().to_string(), owns_folder)).collect::<Vec<_>>()
    };
    let found = names("/a/all.rs", "mod b;\n#[path = \"c/main.rs\"]\npub mod c;\nfn mod_d() {}\n", true);
    assert_eq!(found, [("/a/b.rs".to_owned(), false), ("/a/c/main.rs".to_owned(), true)]);
    assert_eq!(names("/a/b.rs", "mod d;", false), [("/a/b/d.rs".to_owned(), false)]);
}
