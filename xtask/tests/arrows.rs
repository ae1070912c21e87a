//! The arrows between the crates, what a crate must not know, and the licences of what is linked, by `cargo metadata`.

use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

/// Every crate with the crates of this repository that it may depend on, and those that its tests may use besides.
const ARROWS: &[(&str, &[&str], &[&str])] = &[
    ("manypass-flip", &[], &[]),
    ("manypass-graph", &[], &[]),
    ("manypass-scene", &[], &["manypass-testkit"]),
    ("manypass-bake", &["manypass-scene"], &[]),
    ("manypass", &["manypass-graph", "manypass-scene"], &["manypass-testkit"]),
    ("manypass-offline", &["manypass", "manypass-scene"], &["manypass-testkit"]),
    (
        "manypass-cli",
        &["manypass", "manypass-bake", "manypass-flip", "manypass-offline", "manypass-scene", "manypass-viewer"],
        &["manypass-testkit"],
    ),
    ("manypass-viewer", &["manypass", "manypass-scene"], &["manypass-testkit"]),
    ("manypass-web", &["manypass", "manypass-scene"], &[]),
    ("manypass-testkit", &["manypass-flip", "manypass-scene"], &[]),
    ("xtask", &[], &["manypass-testkit"]),
    ("xtask-tools", &["manypass-testkit", "xtask"], &[]),
];

/// What must not be among all that a crate is linked with.
const ABSENT: &[(&str, &[&str])] = &[
    ("manypass-scene", &["wgpu", "naga", "winit"]),
    ("manypass-bake", &["wgpu", "naga", "winit", "clap"]),
    ("manypass-graph", &["gltf", "image", "manypass-scene", "winit"]),
    ("manypass-testkit", &["wgpu", "winit", "manypass"]),
    ("manypass", &["winit", "clap", "anyhow", "wesl"]),
    ("manypass-offline", &["clap", "anyhow", "winit"]),
    ("manypass-web", &["clap", "anyhow", "manypass-offline"]),
    // Whoever runs the demo waits for `xtask`'s own build first.
    ("xtask", &["manypass-testkit", "manypass-scene", "image", "wasm-bindgen-cli-support"]),
];

/// What each feature of `manypass-scene` alone links besides. `cargo xtask demo` is built without them.
const OF_FEATURES: &[(&str, &[&str])] = &[
    ("draco", &["draco-core"]),
    ("exr", &["exr"]),
    ("formats", &["ply-rs-bw", "quick-xml", "zip"]),
    ("ktx2", &["basisu", "ruzstd"]),
    ("meshopt", &["meshoptimizer-rs"]),
    ("simplify", &["meshoptimizer-rs"]),
    ("text", &["ab_glyph"]),
];

/// Licences that ask for no more than a notice, by their SPDX names.
const PERMITTED: &[&str] = &[
    "0BSD",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "ISC",
    "MIT",
    "Unicode-3.0",
    "Unlicense",
    "Zlib",
];

/// What `cargo metadata` says, without a network. None, with a message, where the target's crates are not on this
/// machine.
fn metadata(target: &str) -> Option<Value> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--offline", "--locked", "--format-version", "1", "--filter-platform", target])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo runs");
    if !output.status.success() {
        let error = String::from_utf8_lossy(&output.stderr);
        let first = error.lines().next().unwrap_or_default();
        manypass_testkit::needs::skip(format_args!("the crates for {target} are not on this machine: {first}"));
        return None;
    }
    Some(serde_json::from_slice(&output.stdout).expect("cargo writes JSON"))
}

/// The target that the tests run on, without which nothing could have been built.
fn host() -> String {
    let output = Command::new("rustc").arg("-vV").output().expect("rustc runs");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    text.lines().find_map(|line| line.strip_prefix("host: ")).expect("rustc names its host").to_owned()
}

fn list<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value[key].as_array().map_or(&[], Vec::as_slice)
}

fn text<'a>(value: &'a Value, key: &str) -> &'a str {
    value[key].as_str().unwrap_or_default()
}

fn is_local(package: &Value) -> bool {
    package["source"].is_null()
}

/// The names of everything that the package `id` is linked with: no build scripts, no tests.
fn linked_with(metadata: &Value, id: &str) -> BTreeSet<String> {
    let nodes: BTreeMap<&str, &Value> =
        list(&metadata["resolve"], "nodes").iter().map(|node| (text(node, "id"), node)).collect();
    let names: BTreeMap<&str, &str> =
        list(metadata, "packages").iter().map(|package| (text(package, "id"), text(package, "name"))).collect();
    let (mut found, mut open) = (BTreeSet::new(), vec![id]);
    while let Some(id) = open.pop() {
        for dependency in list(nodes[id], "deps") {
            let is_linked = list(dependency, "dep_kinds").iter().any(|kind| kind["kind"].is_null());
            let package = text(dependency, "pkg");
            if is_linked && found.insert(names[package].to_owned()) {
                open.push(package);
            }
        }
    }
    found
}

#[test]
fn crates_depend_along_the_arrows() {
    let metadata = metadata(&host()).expect("the crates of this machine's own target are there");
    let mut local = 0;
    for package in list(&metadata, "packages").iter().filter(|package| is_local(package)) {
        let name = text(package, "name");
        let (_, linked, tested) =
            ARROWS.iter().find(|(known, ..)| *known == name).unwrap_or_else(|| panic!("`{name}` has no arrows here"));
        local += 1;
        for dependency in list(package, "dependencies").iter().filter(|dependency| !dependency["path"].is_null()) {
            let to = text(dependency, "name");
            let is_tested = dependency["kind"] == "dev" && tested.contains(&to);
            assert!(linked.contains(&to) || is_tested, "`{name}` must not depend on `{to}`");
        }
        for (_, absent) in ABSENT.iter().filter(|(known, _)| *known == name) {
            let linked = linked_with(&metadata, text(package, "id"));
            for absent in *absent {
                assert!(!linked.contains(*absent), "`{name}` must not be linked with `{absent}`");
            }
        }
    }
    assert!(local >= 8, "{local} crates of this repository");
    // The test can fail: the renderer is linked with wgpu.
    let renderer = list(&metadata, "packages").iter().find(|package| text(package, "name") == "manypass");
    assert!(linked_with(&metadata, text(renderer.expect("manypass"), "id")).contains("wgpu"));
}

/// The names of what `manypass-scene` is linked with, with `features` alone.
fn linked_with_features(features: &str) -> BTreeSet<String> {
    let output = Command::new(env!("CARGO"))
        .args(["tree", "--offline", "--locked", "-p", "manypass-scene", "--no-default-features"])
        .args(["--features", features, "--edges", "normal", "--prefix", "none", "--format", "{p}"])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let lines = String::from_utf8_lossy(&output.stdout).into_owned();
    lines.lines().filter_map(|line| Some(line.split_once(' ')?.0.to_owned())).collect()
}

#[test]
fn features_of_the_scene_bring_their_crates_and_no_others() {
    let of_all: BTreeSet<&str> = OF_FEATURES.iter().flat_map(|(_, names)| names.iter().copied()).collect();
    let optional = |features: &str| -> BTreeSet<String> {
        let linked = linked_with_features(features);
        assert!(linked.contains("glam"), "{linked:?}");
        linked.into_iter().filter(|name| of_all.contains(name.as_str())).collect()
    };
    assert_eq!(optional(""), BTreeSet::new());
    for (feature, expected) in OF_FEATURES {
        assert_eq!(optional(feature), expected.iter().map(|name| (*name).to_owned()).collect(), "{feature}");
    }
    assert_eq!(optional("default").len(), of_all.len());
}

/// The crates above have the features of the scene, with the same names and all on by default.
#[test]
fn crates_above_pass_the_features_on() {
    let metadata = metadata(&host()).expect("the crates of this machine's own target are there");
    let features = |name: &str| -> Value {
        let packages = list(&metadata, "packages").iter();
        packages.clone().find(|package| text(package, "name") == name).expect(name)["features"].clone()
    };
    let names: Vec<&str> = OF_FEATURES.iter().map(|(name, _)| *name).collect();
    assert_eq!(list(&features("manypass-scene"), "default"), names);
    for above in ["manypass", "manypass-cli"] {
        let features = features(above);
        for name in &names {
            assert_eq!(list(&features, name), [format!("manypass-scene/{name}")], "{above}");
            assert!(list(&features, "default").contains(&Value::from(*name)), "{above}: {name}");
        }
    }
}

#[test]
fn every_dependency_has_a_permitted_licence() {
    let mut checked = 0;
    for metadata in [host().as_str(), "wasm32-unknown-unknown"].into_iter().filter_map(metadata) {
        for package in list(&metadata, "packages") {
            let (name, license) = (text(package, "name"), text(package, "license"));
            assert!(is_permitted(license), "`{name}` has the licence `{license}`");
            checked += 1;
        }
    }
    assert!(checked > 100, "{checked} packages");
}

/// `cargo deny` has its own list of licences.
#[test]
fn cargo_deny_permits_the_same_licences() {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../deny.toml")).expect("deny.toml");
    let (_, allowed) = text.split_once("allow = [").expect("licences");
    let (allowed, _) = allowed.split_once(']').expect("their end");
    let allowed: Vec<&str> = allowed.split(',').map(|name| name.trim().trim_matches('"')).collect();
    assert_eq!(
        allowed.iter().filter(|name| !name.is_empty()).collect::<Vec<_>>(),
        PERMITTED.iter().collect::<Vec<_>>()
    );
}

/// Whether an SPDX expression can be satisfied with [`PERMITTED`] alone. A slash is the older way to write OR.
fn is_permitted(expression: &str) -> bool {
    let expression = expression.replace('/', " OR ").replace('(', " ( ").replace(')', " ) ");
    let mut words: Vec<&str> = expression.split_whitespace().rev().collect();
    is_any_permitted(&mut words) && words.is_empty()
}

/// `words` is reversed; what has been read is taken from its end.
fn is_any_permitted(words: &mut Vec<&str>) -> bool {
    let mut is_permitted = are_all_permitted(words);
    while words.last() == Some(&"OR") {
        words.pop();
        is_permitted |= are_all_permitted(words);
    }
    is_permitted
}

fn are_all_permitted(words: &mut Vec<&str>) -> bool {
    let mut are_permitted = is_one_permitted(words);
    while words.last() == Some(&"AND") {
        words.pop();
        are_permitted &= is_one_permitted(words);
    }
    are_permitted
}

fn is_one_permitted(words: &mut Vec<&str>) -> bool {
    match words.pop() {
        Some("(") => {
            let is_permitted = is_any_permitted(words);
            words.pop() == Some(")") && is_permitted
        }
        Some(name) if words.last() == Some(&"WITH") => {
            words.pop();
            let exception = words.pop().unwrap_or_default();
            PERMITTED.contains(&format!("{name} WITH {exception}").as_str())
        }
        name => name.is_some_and(|name| PERMITTED.contains(&name)),
    }
}

#[test]
fn licence_expressions_are_understood() {
    for good in
        ["MIT", "GPL-3.0 OR MIT", "MIT/Apache-2.0", "Zlib AND (MIT OR GPL-2.0)", "Apache-2.0 WITH LLVM-exception"]
    {
        assert!(is_permitted(good), "{good}");
    }
    for bad in [
        "",
        "GPL-3.0",
        "MIT AND GPL-3.0",
        "(MIT",
        "MIT)",
        "Apache-2.0 WITH Other",
        "MPL-2.0",
        "(GPL-2.0 OR LGPL-2.1) AND MIT",
    ] {
        assert!(!is_permitted(bad), "{bad}");
    }
}
