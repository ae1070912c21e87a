//! Which files of the renderer may import which: what makes a pass a room of its own. `imports/tree.rs` reads them.

#[path = "imports/made_up.rs"]
mod made_up;
#[path = "imports/tokens.rs"]
mod tokens;
#[path = "imports/tree.rs"]
mod tree;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use tree::Tree;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/render/src")
}

/// All Rust files below `folder`, by their path from `root`.
fn read(root: &Path, folder: &Path, files: &mut BTreeMap<String, String>) {
    for entry in std::fs::read_dir(folder).expect("listed") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            read(root, &path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let words: Vec<_> =
                path.strip_prefix(root).expect("below").iter().map(|word| word.to_string_lossy()).collect();
            files.insert(words.join("/"), std::fs::read_to_string(&path).expect("read"));
        }
    }
}

fn renderer() -> &'static Tree {
    static TREE: OnceLock<Tree> = OnceLock::new();
    TREE.get_or_init(|| {
        let mut files = BTreeMap::new();
        read(&root(), &root(), &mut files);
        Tree::new(&files)
    })
}

/// The pass in whose folder a file lies.
fn pass_of(file: &str) -> Option<&str> {
    Some(file.strip_prefix("passes/")?.split_once('/')?.0)
}

#[test]
fn every_file_of_the_renderer_is_read() {
    let mut files = BTreeMap::new();
    read(&root(), &root(), &mut files);
    let unread: Vec<_> = files
        .keys()
        .filter(|file| !renderer().files().contains(file.as_str()) && !renderer().test_files().contains(*file))
        .collect();
    assert!(unread.is_empty(), "no module has the files {unread:?}");
    let has = |by: &str, of: &str| renderer().imports().any(|import| (import.0, import.1) == (by, of));
    assert!(has("frame.rs", "passes/geometry/mod.rs") && has("passes/geometry/mod.rs", "gbuffer.rs"));
    assert!(renderer().imports().count() > 100, "{} imports", renderer().imports().count());
}

#[test]
fn no_pass_imports_another() {
    let wrong: Vec<_> = renderer()
        .imports()
        .filter(|(by, of, _)| pass_of(by).is_some() && pass_of(of).is_some() && pass_of(by) != pass_of(of))
        .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}
