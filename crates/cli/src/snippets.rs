//! What pages show is true: each snippet is checked as its kind can be, or stands in [`UNCHECKED`] with a reason.

mod code;
mod commands;

use manypass::shader::ProgramError;
use manypass::{EffectFile, Settings, SettingsFile, SimulationFile, effect};
use manypass_scene::Stage;
use manypass_scene::renamed::NameChange;
use manypass_testkit::pages::{self, Snippet};

/// What is no code of ours, or nothing that can be read by itself: the page, how its text begins, and the reason.
const UNCHECKED: [(&str, &str, &str); 12] = [
    ("ARCHITECTURE.md", "      cli              web", "a diagram of the crates"),
    ("ARCHITECTURE.md", "shared     [environment, when new]", "a diagram of the frame"),
    ("docs/camera.md", "diameter ·", "a formula"),
    ("docs/decisions/005_programs_and_constants.md", "// Program: debug.", "comments of shaders"),
    ("docs/defaults.md", "<script type=\"module\"", "another program, from the net"),
    ("docs/diff.md", "FLIP mean", "what a command prints, with numbers of one picture"),
    ("docs/effects.md", "own_pass.wgsl:50:12", "what a command prints"),
    ("docs/exposure.md", "e' = wanted", "a formula"),
    ("docs/shaders.md", "MANYPASS_SHADER_DUMP=texts", "an environment variable, which `tests/shader_texts.rs` sets"),
    ("docs/shaders.md", "cargo run --features manypass/reload", "another build"),
    ("docs/stage.md", "night.stage.toml:4:1", "what a command prints"),
    ("docs/streams.md", "… | ffmpeg", "another program"),
];

fn all() -> Vec<Snippet> {
    pages::pages().iter().flat_map(|(page, text)| pages::snippets(page, text)).collect()
}

/// Why a snippet is not checked, if it is not.
fn reason(snippet: &Snippet) -> Option<&'static str> {
    let is_it = |(page, start, _): &&(&str, &str, &str)| snippet.page == *page && snippet.text.starts_with(*start);
    UNCHECKED.iter().find(is_it).map(|(.., reason)| *reason)
}

/// What is wrong with a snippet, with the line of its page.
fn faults(snippet: &Snippet) -> Vec<String> {
    let fault = |message: String| vec![format!("{}: {message}", snippet.place(0))];
    match snippet.language.as_str() {
        _ if reason(snippet).is_some() => Vec::new(),
        // Their commands are tested below, one by one.
        "sh" => Vec::new(),
        "toml" => check_toml(snippet).err().into_iter().collect(),
        "wgsl" => check_wgsl(snippet).err().into_iter().collect(),
        "json" => {
            serde_json::from_str::<serde_json::Value>(&snippet.text).err().map_or(vec![], |e| fault(e.to_string()))
        }
        "rust" => code::rust_faults(snippet),
        "js" => code::script_faults(snippet),
        "python" => [code::f3d_faults(snippet), code::python_faults(snippet)].concat(),
        other => fault(format!("nothing checks `{other}`; name another language, or a reason in UNCHECKED")),
    }
}

#[test]
fn every_snippet_of_the_pages_is_checked_or_has_a_reason() {
    let snippets = all();
    assert!(snippets.len() > 70, "{} snippets", snippets.len());
    let found: Vec<String> = snippets.iter().flat_map(faults).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn reasons_are_of_snippets_that_are_there() {
    let snippets = all();
    for (page, start, reason) in UNCHECKED {
        let is_there = snippets.iter().any(|snippet| snippet.page == page && snippet.text.starts_with(start));
        assert!(is_there, "{page} has no snippet that begins with {start:?}, which is {reason}");
    }
}

#[test]
fn what_is_wrong_is_found_at_its_line() {
    let of = |language: &str, text: &str| {
        let page = "docs/a.md".to_owned();
        faults(&Snippet { page, line: 7, language: language.to_owned(), text: text.to_owned() }).join("\n")
    };
    for (language, text, expected) in [
        ("toml", "model = \"a.glb\"\n[[lights]]\nkind = \"pont\"\n", "docs/a.md:9:"),
        ("toml", "[fog]\ndensity = 1\n", "docs/a.md:8:"),
        ("toml", "[render]\npath = \"backward\"\n", "docs/a.md:8:"),
        ("toml", "chain = [\"blom\"]\n", "docs/a.md:7: the effect `blom`"),
        ("wgsl", "//! pixel: f\nfn f(color: vec4f, position: vec2f) -> vec4f { return colour; }\n", "docs/a.md:8:"),
        ("wgsl", "//! reads: what nobody writes\n", "docs/a.md:7: "),
        ("json", "{", "docs/a.md:7: "),
        ("rust", "let scene = manypass::no_such_function();\n", "docs/a.md:7: "),
        ("js", "viewer.fly({ radius: 3 });\n", "`fly`"),
        ("js", "viewer.render({ radius: 3, height: 2 }); // up\nviewer.render({ up: 1 });\n", "docs/a.md:8: `up`"),
        ("python", "import f3d\no = {\"render.effect.antialiasing.enable\": True}\n", "docs/a.md:8: F3D has no option"),
        ("lua", "", "nothing checks `lua`"),
        ("", "manypass render a.glb\n", "nothing checks ``"),
    ] {
        let found = of(language, text);
        assert!(found.contains(expected), "{language} {text:?}: {found:?} has no {expected}");
    }
    assert_eq!(of("toml", "[fog]\ndensity_per_m = 1\n"), "");
    assert_eq!(of("js", "viewer.render({ radius: 3 });\n"), "");
}

/// A file of settings, or a stage: whole where it names a model.
fn check_toml(snippet: &Snippet) -> Result<(), String> {
    let text = &snippet.text;
    let is_whole = text.lines().any(|line| line.starts_with("model = "));
    let of_stage = ["[[", "[fog]", "[environment]", "[effects]", "[settings"];
    let is_stage =
        is_whole || text.lines().any(|line| of_stage.iter().any(|start| line.trim_start().starts_with(start)));
    // As many lines stand before it as in the page, so that errors name those of the page.
    let before = "\n".repeat(snippet.line.saturating_sub(2));
    let at_place = |message: String| format!("{}: {message}", snippet.place(0));
    let mut settings = Settings::default();
    if is_stage {
        let model = if is_whole { "\n" } else { "model = \"demo:hall\"\n" };
        let stage =
            Stage::parse(&snippet.page, &format!("{before}{model}{text}")).map_err(|fault| fault.to_string())?;
        let chain = Settings::stage_chain(&stage).map_err(|fault| fault.to_string())?;
        let mut effects = effects(chain).map_err(at_place)?;
        settings.apply_stage(&stage, &mut effects).map_err(|fault| fault.to_string())?;
        return no_older_names(&Settings::stage_older_names(&stage)).map_err(at_place);
    }
    let file = SettingsFile::parse(&snippet.page, &format!("{before}\n{text}")).map_err(|fault| fault.to_string())?;
    let chain = Settings::chain_of_file(&file).map_err(|fault| fault.to_string())?;
    let mut effects = effects(chain).map_err(at_place)?;
    let applied = file.apply(|key, written| effect::set_of_file(&mut settings, &mut effects, key, written));
    applied.map_err(|fault| fault.to_string())?;
    no_older_names(&file.older_names()).map_err(at_place)
}

/// Pages have the names of today.
fn no_older_names(names: &[&'static NameChange]) -> Result<(), String> {
    names.first().map_or(Ok(()), |renamed| Err(renamed.to_string()))
}

/// The effects of a chain; files of a user's own are stood in for.
fn effects(chain: Option<Vec<String>>) -> Result<Vec<EffectFile>, String> {
    const SAME: &str = "//! pixel: same\nfn same(color: vec4f, position: vec2f) -> vec4f { return color; }\n";
    let read = |name: &str| match name.ends_with(".wgsl") {
        true => EffectFile::parse(name, SAME),
        false => Err(ProgramError::Misplaced { pass: name.to_owned(), message: "it is not built in".to_owned() }),
    };
    EffectFile::chain(&chain.unwrap_or_default(), Vec::new(), read).map_err(|error| error.to_string())
}

/// An effect or a simulation as the program takes it; or a header alone, whose lines stand in a shader.
fn check_wgsl(snippet: &Snippet) -> Result<(), String> {
    if !snippet.text.contains("fn ") {
        return code::check_lines(snippet, "wgsl");
    }
    // As many lines stand before it as in the page.
    let text = format!("{}{}", "\n".repeat(snippet.line.saturating_sub(1)), snippet.text);
    if snippet.text.starts_with("//! simulation") {
        return SimulationFile::parse(&snippet.page, &text).map(drop).map_err(|error| error.to_string());
    }
    let file = EffectFile::parse(&snippet.page, &text).map_err(|error| error.to_string())?;
    file.missing().map_or(Ok(()), |(_, missing)| Err(missing.to_string()))
}
