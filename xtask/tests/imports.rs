//! Which files of the renderer may import which: what makes a pass a room of its own. `imports/tree.rs` reads them.

mod circles;
mod made_up;
mod tokens;
mod tree;

use circles::{Arrows, circles};
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

/// The folder of a pass, or the module at the top with all that lies below it. `lib.rs` is in none: it declares them.
fn folder_of(file: &str) -> Option<&str> {
    if let Some(pass) = pass_of(file) {
        return Some(&file[.."passes/".len() + pass.len()]);
    }
    let first = file.split_once('/').map_or_else(|| file.strip_suffix(".rs"), |(folder, _)| Some(folder));
    first.filter(|folder| *folder != "lib")
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
    assert!(has("frame.rs", "passes/background/mod.rs") && has("passes/geometry/mod.rs", "gbuffer.rs"));
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

/// What can be read from the top of `frame.rs` downwards: nothing below it may lead back.
#[test]
fn no_file_lies_in_a_circle_with_the_frame() {
    let circles: Vec<_> = renderer()
        .reach("frame.rs")
        .into_keys()
        .filter(|file| *file != "frame.rs")
        .filter_map(|file| renderer().chain(file, "frame.rs"))
        .collect();
    assert!(circles.is_empty(), "`frame.rs` imports, by others or itself, what imports it: {circles:#?}");
}

/// What passes import, by others or themselves, is their vocabulary. It knows no pass: not even the one that imports
/// it.
#[test]
fn the_vocabulary_of_passes_imports_no_pass() {
    // With a pass that imports it, for the message.
    let mut vocabulary: BTreeMap<&str, &str> = BTreeMap::new();
    for pass in renderer().files().into_iter().filter(|file| pass_of(file).is_some()) {
        let words = renderer().reach(pass).into_keys().filter(|file| pass_of(file).is_none());
        vocabulary.extend(words.map(|word| (word, pass)));
    }
    assert!(vocabulary.contains_key("gbuffer.rs") && vocabulary.contains_key("view.rs"), "{vocabulary:?}");
    let wrong: Vec<_> = renderer()
        .imports()
        .filter(|(by, of, _)| vocabulary.contains_key(by) && pass_of(of).is_some())
        .map(|(by, of, written)| {
            let chain = renderer().chain(vocabulary[by], by).unwrap_or_default();
            format!("{by} imports {of} ({written}), and a pass imports it: {chain}")
        })
        .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Who imports whom among what `group_of` makes of files, and the circles there, each with the imports that make it up.
fn circles_of(group_of: impl Fn(&str) -> Option<&str>) -> (Arrows<'static>, Vec<Vec<String>>) {
    let mut imports = BTreeMap::new();
    let mut arrows = Arrows::new();
    for (by, of, written) in renderer().imports() {
        let (Some(from), Some(to)) = (group_of(by), group_of(of)) else { continue };
        if from != to {
            imports.entry((from, to)).or_insert((by, of, written));
            arrows.entry(from).or_default().insert(to);
        }
    }
    let steps = |circle: Vec<&str>| {
        let step = |pair: &[&str]| {
            let (by, of, written) = imports.get(&(pair[0], pair[1])).copied().unwrap_or_default();
            format!("{} → {}: {by} imports {of} ({written})", pair[0], pair[1])
        };
        circle.windows(2).map(step).collect()
    };
    let found = circles(&arrows).into_iter().map(steps).collect();
    (arrows, found)
}

/// Folders can be read one after the other, each with those that it imports. What two of them need lies below both.
#[test]
fn no_folders_lie_in_a_circle() {
    let (arrows, found) = circles_of(folder_of);
    let has = |from: &str, to: &str| arrows.get(from).is_some_and(|all| all.contains(to));
    assert!(has("frame", "passes/background") && has("passes/geometry", "gbuffer") && has("draws", "lights"));
    assert!(found.is_empty(), "folders import each other in a circle: {found:#?}");
}

/// So can the files that carry out a frame. `renderer.rs` is left out: it has the type whose methods they are.
#[test]
fn no_files_below_the_renderer_lie_in_a_circle() {
    let (arrows, found) = circles_of(|file| file.starts_with("renderer/").then_some(file));
    assert!(arrows.get("renderer/submit.rs").is_some_and(|all| all.contains("renderer/record.rs")), "{arrows:?}");
    assert!(found.is_empty(), "files import each other in a circle: {found:#?}");
}

#[test]
fn nothing_outside_the_folder_of_a_pass_names_its_uniforms() {
    let of_passes = || renderer().named().iter().filter(|named| pass_of(&named.of).is_some());
    let uniforms = || of_passes().filter(|named| named.item.ends_with("Uniform"));
    assert!(uniforms().count() > 0, "no pass has a uniform");
    let wrong: Vec<_> = uniforms()
        .filter(|named| pass_of(&named.by) != pass_of(&named.of))
        .map(|named| format!("{} names {} of {}", named.by, named.item, named.of))
        .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// What depends on the kind of a view is asked of `ViewKind`. Kinds themselves are known to the files that make views of
/// one, and to the file that records views.
#[test]
fn kinds_of_views_are_known_where_they_are_made_and_recorded() {
    const KNOW_KINDS: [&str; 7] = [
        "renderer/captures.rs",
        "renderer/fisheye.rs",
        "renderer/live_probes.rs",
        "renderer/mirrors.rs",
        "renderer/record_view.rs",
        "renderer/surroundings.rs",
        "renderer/view_kind.rs",
    ];
    let by: Vec<&str> = renderer()
        .named()
        .iter()
        .filter(|named| named.of == "renderer/view_kind.rs" && named.item == "Drawing")
        .map(|named| named.by.as_str())
        .collect();
    assert!(by.contains(&"renderer/record_view.rs"), "nothing records views: {by:?}");
    let wrong: Vec<_> = by.into_iter().filter(|file| !KNOW_KINDS.contains(file)).collect();
    assert!(wrong.is_empty(), "{wrong:?} ask what kind a view is; `ViewKind` is to answer what they need");
}
