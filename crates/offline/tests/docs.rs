//! The documentation of variables, settings and shaders is that of the code.

use manypass_offline::{aov_docs, settings_docs, stage_docs};
use std::path::{Path, PathBuf};

fn docs(page: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs").join(page)
}

fn are_written() -> bool {
    std::env::var_os("MANYPASS_GOLDENS").is_some_and(|value| value == "write")
}

/// Compares the table of a page, between its comments, with that of the code; or writes it.
fn assert_current(page: &str, subject: &str, table: &str) {
    let begin = format!("<!-- {subject}: written by `cargo xtask goldens` -->\n");
    let end = format!("<!-- end of {subject} -->\n");
    let path = docs(page);
    let text = std::fs::read_to_string(&path).expect(page);
    let (before, rest) = text.split_once(&begin).expect("the table's beginning");
    let (found, after) = rest.split_once(&end).expect("the table's end");
    if are_written() {
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

#[test]
fn the_golden_tables_of_stages_are_current() {
    assert_current("stage.md", "keys", &stage_docs::markdown_tables());
}

#[test]
fn the_golden_table_of_programs_is_current() {
    use manypass::shader::compose::PROGRAMS;
    let code = |names: &[&str]| names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(" ");
    let mut table = String::from("| program | modules | axes | constants |\n|---|---|---|---|\n");
    for program in PROGRAMS {
        let (name, modules) = (program.name, program.modules().len());
        table += &format!("| `{name}` | {modules} | {} | {} |\n", code(program.axes), code(program.constants));
    }
    let modules: usize = PROGRAMS.iter().map(|program| program.modules().len()).sum();
    table += &format!("\n{} programs, {modules} modules.\n", PROGRAMS.len());
    assert_current("shaders.md", "programs", &table);
}

#[test]
fn the_stage_of_the_page_is_the_example() {
    let read = |name: &str| std::fs::read_to_string(docs(name)).expect(name);
    assert!(read("stage.md").contains(&format!("```toml\n{}```", read("examples/hall.stage.toml"))));
}

/// Compares a whole file with what the code says, or writes it.
fn assert_whole(path: &Path, text: &str) {
    if are_written() {
        std::fs::write(path, text).expect("written");
    } else {
        let found = std::fs::read_to_string(path).expect("a file that `cargo xtask goldens` writes");
        assert!(found == text, "{} differs from the code: run `cargo xtask goldens`", path.display());
    }
}

#[test]
fn the_golden_schema_of_stages_is_current() {
    assert_whole(&docs("stage.schema.json"), &stage_docs::schema());
}

#[test]
fn the_golden_types_of_settings_are_current() {
    assert_whole(&docs("../crates/web/module/manypass_settings.d.ts"), &settings_docs::typescript());
}
