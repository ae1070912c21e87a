//! The documentation of variables and settings is that of the code.

use manypass_offline::{aov_docs, settings_docs};
use std::path::Path;

/// Compares the table of a page, between its comments, with that of the code; or writes it.
fn assert_current(page: &str, subject: &str, table: &str) {
    let begin = format!("<!-- {subject}: written by `cargo xtask goldens` -->\n");
    let end = format!("<!-- end of {subject} -->\n");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs").join(page);
    let text = std::fs::read_to_string(&path).expect(page);
    let (before, rest) = text.split_once(&begin).expect("the table's beginning");
    let (found, after) = rest.split_once(&end).expect("the table's end");
    if std::env::var_os("MANYPASS_GOLDENS").is_some_and(|value| value == "write") {
        std::fs::write(&path, format!("{before}{begin}{table}{end}{after}")).expect("written");
    } else {
        assert!(found == table, "docs/{page} differs from the code: run `cargo xtask goldens`");
    }
}

#[test]
fn the_golden_table_of_variables_is_current() {
    assert_current("aovs.md", "variables", &aov_docs::markdown_table());
}

#[test]
fn the_golden_table_of_settings_is_current() {
    assert_current("settings.md", "settings", &settings_docs::markdown_table());
}
