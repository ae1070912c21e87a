//! The documentation of variables is that of the code.

use manypass_offline::aov_docs::markdown_table;
use std::path::Path;

const BEGIN: &str = "<!-- variables: written by `cargo xtask goldens` -->\n";
const END: &str = "<!-- end of variables -->\n";

#[test]
fn the_golden_table_of_variables_is_current() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/aovs.md");
    let text = std::fs::read_to_string(&path).expect("docs/aovs.md");
    let (before, rest) = text.split_once(BEGIN).expect("the table's beginning");
    let (table, after) = rest.split_once(END).expect("the table's end");
    if std::env::var_os("MANYPASS_GOLDENS").is_some_and(|value| value == "write") {
        std::fs::write(&path, format!("{before}{BEGIN}{}{END}{after}", markdown_table())).expect("written");
    } else {
        assert!(table == markdown_table(), "docs/aovs.md differs from the code: run `cargo xtask goldens`");
    }
}
