//! Which files of the command line and of the scene import one another in a circle, and what arguments and jobs may know.

#[path = "imports/tokens.rs"]
#[allow(clippy::duplicate_mod, reason = "imports.rs reads the renderer with it")]
mod tokens;
#[path = "imports/tree.rs"]
#[allow(clippy::duplicate_mod, dead_code, reason = "imports.rs reads the renderer with it, and asks for more")]
mod tree;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use tree::Tree;

/// Files of the scene that lie in circles: a scene holds what asks the scene. The list may only become shorter.
const CIRCLES_OF_SCENE: &[&str] = &["animation.rs", "animation/property.rs", "node.rs", "nodes.rs", "skins.rs"];

/// All Rust files below `folder`, by their path from `root`. Stand-ins for what a feature leaves out are not read: a
/// module has the file of its name.
fn read(root: &Path, folder: &Path, files: &mut BTreeMap<String, String>) {
    for entry in std::fs::read_dir(folder).expect("listed") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            read(root, &path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") && !is_stand_in(&path) {
            let below = path.strip_prefix(root).expect("below").to_string_lossy().replace('\\', "/");
            // A program begins at another file than a library.
            let name = if below == "main.rs" { "lib.rs".to_owned() } else { below };
            files.insert(name, std::fs::read_to_string(&path).expect("read"));
        }
    }
}

fn is_stand_in(file: &Path) -> bool {
    file.file_stem().is_some_and(|name| name.to_string_lossy().ends_with("absent"))
}

/// The modules of the crate in `folder`.
fn tree_of(folder: &str) -> Tree {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(folder);
    let mut files = BTreeMap::new();
    read(&root, &root, &mut files);
    let tree = Tree::new(&files);
    let is_read = |file: &&String| tree.files().contains(file.as_str()) || tree.test_files().contains(*file);
    let unread: Vec<_> = files.keys().filter(|file| !is_read(file)).collect();
    assert!(unread.is_empty(), "no module has the files {unread:?}");
    assert!(tree.imports().count() > 100, "{} imports", tree.imports().count());
    tree
}

/// The files that import themselves, by others.
fn in_circles(tree: &Tree) -> BTreeSet<&str> {
    let mut imports: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for (by, of, _) in tree.imports() {
        imports.entry(by).or_default().push(of);
    }
    let comes_back = |start: &str| {
        let (mut seen, mut open) = (BTreeSet::new(), vec![start]);
        while let Some(file) = open.pop() {
            open.extend(imports.get(file).into_iter().flatten().filter(|next| seen.insert(**next)));
        }
        seen.contains(start)
    };
    tree.files().into_iter().filter(|file| comes_back(file)).collect()
}

#[test]
fn no_files_of_the_command_line_import_one_another() {
    let tree = tree_of("crates/cli/src");
    let circles: Vec<_> = in_circles(&tree).into_iter().filter_map(|file| tree.chain(file, file)).collect();
    assert!(circles.is_empty(), "{circles:#?}");
}

/// Arguments → job (validated) → run.
#[test]
fn arguments_know_no_job_and_jobs_know_nothing_of_running() {
    const RUN: [&str; 8] =
        ["interrupt.rs", "memory.rs", "output.rs", "places.rs", "render.rs", "run.rs", "session.rs", "stream.rs"];
    let tree = tree_of("crates/cli/src");
    let of_arguments = tree.reach("args.rs");
    let knows: Vec<_> =
        of_arguments.keys().filter(|file| !file.starts_with("args/") && **file != "preset.rs").collect();
    assert!(knows.is_empty(), "arguments know {knows:?}");
    assert!(of_arguments.contains_key("args/frame.rs"));
    let of_job = tree.reach("job.rs");
    assert!(of_job.contains_key("args/frame.rs") && of_job.contains_key("job/output.rs"));
    for file in RUN {
        assert!(tree.files().contains(file), "there is no {file}");
        assert!(!of_job.contains_key(file), "{:?}", tree.chain("job.rs", file));
    }
}

#[test]
fn no_more_files_of_the_scene_import_one_another() {
    let tree = tree_of("crates/scene/src");
    let circles = in_circles(&tree);
    let listed: BTreeSet<&str> = CIRCLES_OF_SCENE.iter().copied().collect();
    let more: Vec<_> = circles.difference(&listed).filter_map(|file| tree.chain(file, file)).collect();
    assert!(more.is_empty(), "{more:#?}");
    let fewer: Vec<_> = listed.difference(&circles).collect();
    assert!(fewer.is_empty(), "no circle has {fewer:?} any more: take them off the list");
}

#[test]
fn circles_are_found() {
    let files = [
        ("lib.rs", "mod a; mod b; mod c; mod d;"),
        ("a.rs", "use crate::b::B; pub struct A;"),
        ("b.rs", "use crate::c::C; pub struct B;"),
        ("c.rs", "use crate::a::A; pub struct C;"),
        ("d.rs", "use crate::a::A; use crate::d::inner::Inner; mod inner;"),
        ("d/inner.rs", "pub struct Inner;"),
    ];
    let tree = Tree::new(&files.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).collect());
    assert_eq!(in_circles(&tree).into_iter().collect::<Vec<_>>(), ["a.rs", "b.rs", "c.rs"]);
}
