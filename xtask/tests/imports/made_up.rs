//! What the reader of imports makes of small trees that are made up, and which circles are found in small graphs.

use super::circles::{Arrows, circles};
use super::tree::Tree;
use std::collections::BTreeMap;

fn tree(files: &[(&str, &str)]) -> Tree {
    Tree::new(&files.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).collect::<BTreeMap<_, _>>())
}

/// The files that `by` imports.
fn imports_of(tree: &Tree, by: &str) -> Vec<String> {
    tree.imports().filter(|(from, ..)| *from == by).map(|(_, of, _)| of.to_owned()).collect()
}

/// A crate of `a.rs` with `text`, and of modules to import.
fn a_imports(text: &str) -> Vec<String> {
    let tree = tree(&[
        ("lib.rs", "mod a; mod b; mod c; pub mod deep; pub use deep::Exported; pub use c::*;"),
        ("a.rs", text),
        ("b.rs", "pub struct B; pub fn b() {} pub const N: u32 = 1;"),
        ("c.rs", "pub enum C { One } pub struct InGlob;"),
        ("deep/mod.rs", "mod inner; pub use inner::{Exported, Other as Renamed}; pub fn own() {}"),
        ("deep/inner.rs", "pub struct Exported; pub struct Other; pub struct Hidden;"),
    ]);
    imports_of(&tree, "a.rs")
}

#[test]
fn every_form_of_use_is_followed() {
    assert_eq!(a_imports("use crate::b::B;"), ["b.rs"]);
    assert_eq!(a_imports("use crate::{b::{self, B}, c::{C}};"), ["b.rs", "c.rs"]);
    assert_eq!(a_imports("use {crate::b, super::c::C as _};"), ["b.rs", "c.rs"]);
    assert_eq!(a_imports("pub(crate) use super::b::*;"), ["b.rs"]);
    assert_eq!(a_imports("fn f() { if true { use crate::c::C; } }"), ["c.rs"]);
    assert_eq!(
        a_imports("mod within { use super::super::b; use self::below::X; mod below { pub struct X; } }"),
        ["b.rs"]
    );
    assert_eq!(a_imports("use std::c::C; use ::b::B; use glam; use glam::b;"), [""; 0]);
    assert_eq!(
        a_imports("//! crate::b\n/// [`crate::c`]\npub struct S(&'static str); const T: &str = \"crate::b\";"),
        [""; 0]
    );
}

#[test]
fn paths_that_are_written_out_are_followed() {
    assert_eq!(a_imports("fn f(x: &crate::b::B) -> Option<super::c::C> { None }"), ["b.rs", "c.rs"]);
    assert_eq!(
        a_imports("fn f() { vec![crate::b::N; 3]; assert!(x == super::c::C::One, \"{}\", y); }"),
        ["b.rs", "c.rs"]
    );
    assert_eq!(a_imports("impl<T: Into<crate::b::B>> crate::c::C for T {}"), ["b.rs", "c.rs"]);
    assert_eq!(a_imports("macro_rules! m { () => { $crate::b::b() } }"), ["b.rs"]);
    assert_eq!(a_imports("#[derive(crate::b::Derive)] struct S;"), ["b.rs"]);
    // Through what an earlier `use` brought.
    assert_eq!(a_imports("use crate::deep; fn f() -> deep::Renamed { deep::own() }"), ["deep/inner.rs", "deep/mod.rs"]);
    assert_eq!(a_imports("fn f() { let x = y.crate_::b; 0..b; x::<u8>::c(); ::b::b(); }"), [""; 0]);
}

#[test]
fn what_is_exported_again_counts_for_where_it_is_defined() {
    assert_eq!(a_imports("use crate::deep::Exported;"), ["deep/inner.rs"]);
    assert_eq!(a_imports("use crate::Exported;"), ["deep/inner.rs"]);
    assert_eq!(a_imports("use crate::deep::Renamed;"), ["deep/inner.rs"]);
    assert_eq!(a_imports("use crate::InGlob;"), ["c.rs"]);
    assert_eq!(a_imports("use super::*; fn f(x: InGlob) {}"), ["c.rs", "lib.rs"]);
    let tree = tree(&[
        ("lib.rs", "pub mod a; pub mod b; mod c;"),
        ("a.rs", "pub use crate::b::X;"),
        ("b.rs", "pub use crate::c::X;"),
        ("c.rs", "pub struct X; use crate::a::X as Own;"),
    ]);
    assert_eq!(imports_of(&tree, "a.rs"), ["c.rs"]);
    let items: Vec<_> = tree.named().iter().map(|named| (&*named.by, &*named.of, &*named.item)).collect();
    assert_eq!(items, [("a.rs", "c.rs", "X"), ("b.rs", "c.rs", "X"), ("c.rs", "c.rs", "X")]);
}

#[test]
fn names_that_lead_to_themselves_end() {
    let tree = tree(&[
        ("lib.rs", "mod a; mod b; use glam;"),
        ("a.rs", "pub use crate::b::X; use crate::glam::Y;"),
        ("b.rs", "pub use crate::a::X; pub use crate::a::*;"),
    ]);
    assert!(tree.chain("a.rs", "b.rs").is_some());
}

#[test]
fn macros_are_found_in_the_root() {
    let tree = tree(&[
        ("lib.rs", "mod a; mod b;"),
        ("a.rs", "crate::settings! { pub struct S }"),
        ("b.rs", "#[macro_export] macro_rules! settings { ($x:tt) => {} }"),
    ]);
    assert_eq!(imports_of(&tree, "a.rs"), ["b.rs"]);
}

#[test]
fn what_only_tests_have_is_left_out() {
    let tree = tree(&[
        ("lib.rs", "mod a; mod b; mod c; #[cfg(test)] mod common;"),
        (
            "a.rs",
            "#[cfg(test)] mod tests { use crate::b::B; } #[cfg(test)] use crate::b::{B}; #[cfg(not(test))] use crate::c::C;
            #[cfg(test)] #[allow(x)] pub(crate) fn f() -> [u8; 2] { crate::b::b() } #[cfg(all(test, unix))] mod below;",
        ),
        ("b.rs", "#[cfg(target_arch = \"wasm32\")] use crate::c::C; #[cfg(test)] const X: u8 = { crate::a::f() };
            #[cfg(test)] impl<T: Iterator<Item = u8>> B for T { fn f() { crate::a::f() } } pub fn b() { crate::c::C; }"),
        ("c.rs", "pub struct C;"),
        ("common.rs", "use crate::a;"),
        ("a/below.rs", "use crate::b; mod deeper;"),
        ("a/below/deeper.rs", "use crate::b;"),
    ]);
    assert_eq!((imports_of(&tree, "a.rs"), imports_of(&tree, "b.rs")), (vec!["c.rs".into()], vec!["c.rs".into()]));
    assert_eq!(tree.files().into_iter().collect::<Vec<_>>(), ["a.rs", "b.rs", "c.rs", "lib.rs"]);
    assert_eq!(tree.test_files().iter().collect::<Vec<_>>(), ["a/below.rs", "a/below/deeper.rs", "common.rs"]);
}

#[test]
fn ways_are_found_through_others() {
    let tree = tree(&[
        ("lib.rs", "mod frame; mod passes; mod words;"),
        ("frame.rs", "use crate::passes::{one, two}; pub struct Shared; fn f() { one::record(); two::record() }"),
        ("passes/mod.rs", "pub mod one; pub mod two;"),
        ("passes/one/mod.rs", "use crate::words::Word; pub struct OneUniform;"),
        ("passes/two/mod.rs", "use super::one::OneUniform;"),
        ("words.rs", "use crate::frame::Shared; pub struct Word;"),
    ]);
    assert_eq!(
        tree.chain("passes/two/mod.rs", "frame.rs").as_deref(),
        Some(
            "passes/two/mod.rs → passes/one/mod.rs (super::one::OneUniform) → words.rs (crate::words::Word) → frame.rs \
             (crate::frame::Shared)"
        )
    );
    assert!(tree.chain("frame.rs", "frame.rs").is_some(), "a circle");
    assert!(tree.chain("passes/mod.rs", "frame.rs").is_none(), "declaring a module imports nothing");
}

fn arrows(pairs: &[(&'static str, &'static str)]) -> Arrows<'static> {
    let mut arrows = Arrows::new();
    for (by, of) in pairs {
        arrows.entry(*by).or_default().insert(*of);
    }
    arrows
}

#[test]
fn what_leads_one_way_is_no_circle() {
    assert!(circles(&arrows(&[("a", "b"), ("a", "c"), ("b", "d"), ("c", "d")])).is_empty());
}

#[test]
fn each_circle_is_found_by_its_shortest_way() {
    let two = [("a", "b"), ("b", "c"), ("c", "a"), ("c", "b"), ("d", "a"), ("e", "f"), ("f", "e"), ("c", "e")];
    assert_eq!(circles(&arrows(&two)), [vec!["a", "b", "c", "a"], vec!["e", "f", "e"]]);
}
