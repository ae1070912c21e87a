//! Commands that pages show: the program takes each as it is written, and what else is called is there.

use crate::args::{Cli, Command, FrameArgs};
use crate::chosen::SettingsChoice;
use crate::failure::Failure;
use crate::job::{self, Job};
use crate::size;
use clap::Parser;
use clap::error::ErrorKind;
use manypass::Settings;
use manypass_offline::still::aov_names;
use manypass_testkit::pages::{self, Command as Shown, Snippet, root};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Where effects are that pages name without a folder.
const EFFECTS: [&str; 3] = ["", "crates/render/examples", "docs/examples/effects"];

/// A folder for effects that stand in a page alone.
struct EffectFolder(PathBuf);

impl EffectFolder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("manypass-snippets-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).expect("a folder");
        Self(path)
    }

    /// Where the effect is that a page names: in the repository, or what the page shows of WGSL first.
    fn effect(&self, name: &Path, page: &[Snippet]) -> PathBuf {
        let is_file = name.extension().is_some_and(|end| end == "wgsl");
        let known = EFFECTS.iter().map(|folder| root().join(folder).join(name)).find(|path| path.is_file());
        let shown = page.iter().find(|snippet| snippet.language == "wgsl").filter(|_| is_file);
        match (known, shown) {
            (Some(path), _) => path,
            (None, Some(snippet)) => {
                let path = self.0.join(name.file_name().unwrap_or_default());
                std::fs::write(&path, &snippet.text).expect("written");
                path
            }
            (None, None) => name.to_owned(),
        }
    }
}

impl Drop for EffectFolder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// What is wrong with a command of `page`.
fn fault(shown: &Shown, page: &[Snippet], own: &EffectFolder) -> Option<String> {
    let at_place = |message: String| format!("{}: `{}`: {message}", shown.place, shown.words.join(" "));
    let is_ours = |word: &&String| word.starts_with("docs/") || word.starts_with("crates/");
    if let Some(word) = shown.words.iter().filter(is_ours).find(|word| !root().join(word).exists()) {
        return Some(at_place(format!("there is no {word}")));
    }
    match shown.words.first().map(String::as_str) {
        Some("manypass") => {}
        Some("cargo") => return fault_of_cargo(&shown.words).map(at_place),
        _ => return Some(at_place("it is neither manypass nor cargo; call the snippet `text`".into())),
    }
    match Cli::try_parse_from(crate::words::joined(shown.words.iter().map(OsString::from))) {
        Ok(cli) => fault_of(cli.command, page, own).err().map(|failure| at_place(failure.message)),
        Err(error) if is_fine(&error, shown) => None,
        Err(error) => Some(at_place(error.to_string().lines().next().unwrap_or_default().to_owned())),
    }
}

/// Whether what the parser says is that help was asked for, or, of what is mentioned in a sentence, that something is
/// left out there or stands in capitals for any name.
fn is_fine(error: &clap::Error, shown: &Shown) -> bool {
    let stands_for_any = |word: &String| word.len() > 1 && word.chars().all(|letter| letter.is_ascii_uppercase());
    match error.kind() {
        ErrorKind::DisplayHelp => true,
        ErrorKind::MissingRequiredArgument => shown.is_mentioned,
        ErrorKind::InvalidValue => shown.is_mentioned && shown.words.iter().any(stands_for_any),
        _ => false,
    }
}

/// What is wrong with values, as far as it can be known without the files of the user's that it names.
fn fault_of(command: Command, page: &[Snippet], own: &EffectFolder) -> Result<(), Failure> {
    let own_effects = |effects: &mut Vec<PathBuf>| {
        effects.iter_mut().for_each(|effect| *effect = own.effect(effect, page));
    };
    match command {
        Command::Render(mut args) => {
            own_effects(&mut args.frame.change.effects);
            stand_in(&mut args.frame);
            let names_many =
                |input: &OsString| input.to_string_lossy().contains('*') || input.to_string_lossy().ends_with('/');
            let are_several = args.inputs.len() > 1 || args.inputs.iter().any(names_many);
            let job = Job::new(&args, are_several, &aov_names())?;
            let (settings, _) =
                SettingsChoice::of_frame(&args.frame)?.meeting_stages(true).settings(Settings::default(), None)?;
            job.check(&settings)?;
            job::check_settings(&settings)
        }
        Command::Graph(mut args) => {
            own_effects(&mut args.frame.change.effects);
            stand_in(&mut args.frame);
            job::aovs(args.frame.aov.as_deref(), &aov_names())?;
            let (settings, _) =
                SettingsChoice::of_frame(&args.frame)?.meeting_stages(true).settings(Settings::default(), None)?;
            job::check_settings(&settings)
        }
        Command::Bench(mut args) => {
            own_effects(&mut args.change.effects);
            size::parse(&args.size)?;
            SettingsChoice::of_change(&args.change)?.meeting_stages(true).settings(Settings::default(), None).map(drop)
        }
        _ => Ok(()),
    }
}

/// A folder of a cube's faces is known as one only where it is there.
fn stand_in(args: &mut FrameArgs) {
    let environment = &mut args.around.environment;
    if environment.as_ref().is_some_and(|name| name.ends_with('/')) {
        *environment = Some("cube.hdr".into());
    }
}

/// What is wrong with a command of cargo's: `xtask` has a task of that name, and a crate is where it says.
fn fault_of_cargo(words: &[String]) -> Option<String> {
    let words: Vec<&str> = words.iter().skip(1).map(String::as_str).collect();
    match words[..] {
        ["xtask", task, ..] => {
            let tasks = std::fs::read_to_string(root().join("xtask/src/main.rs")).expect("the tasks");
            (!tasks.contains(&format!("[\"{task}\""))).then(|| format!("there is no task `{task}`"))
        }
        ["install", "--path", path] => {
            (!root().join(path).join("Cargo.toml").is_file()).then(|| format!("there is no crate {path}"))
        }
        ["run", .., "-p", "manypass", "--example", name] => {
            let examples = root().join("crates/render/examples");
            let is_there = examples.join(format!("{name}.rs")).is_file() || examples.join(name).is_dir();
            (!is_there).then(|| format!("there is no example `{name}`"))
        }
        _ => Some("it is not known here; check it in fault_of_cargo".into()),
    }
}

#[test]
fn every_command_of_the_pages_is_one_of_the_program() {
    let own = EffectFolder::new("all");
    let (mut found, mut count) = (Vec::new(), 0);
    for (page, text) in pages::pages() {
        let snippets = pages::snippets(&page, &text);
        let commands = pages::commands(&page, &text);
        count += commands.len();
        found.extend(commands.iter().filter_map(|command| fault(command, &snippets, &own)));
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
    assert!(count > 120, "{count} commands");
}

#[test]
fn what_is_wrong_with_a_command_is_found_at_its_line() {
    let own = EffectFolder::new("wrong");
    let faults = |line: &str| {
        let page = format!("```sh\n{line}\n```\n");
        let commands = pages::commands("docs/a.md", &page);
        commands.iter().filter_map(|command| fault(command, &[], &own)).collect::<Vec<_>>().join("\n")
    };
    for (line, expected) in [
        ("manypass render a.glb --sise 64x64", "--sise"),
        ("manypass render a.glb --size 64", "`64` is not a size"),
        ("manypass render a.glb --set occlusion.radius=1", "occlusion.radius"),
        ("manypass render a.glb --set occlusion.radius_m=-1", "occlusion.radius_m"),
        ("manypass render a.glb --aov depht", "depht"),
        ("manypass render a.glb --effect blom", "blom"),
        ("manypass render docs/examples/pains.gltf", "there is no docs/examples/pains.gltf"),
        ("manypass draw a.glb", "draw"),
        ("manypass render", "docs/a.md:2: `manypass render`: "),
        ("cargo xtask tset", "there is no task `tset`"),
        ("rm a.glb", "neither manypass nor cargo"),
    ] {
        let found = faults(line);
        assert!(found.starts_with("docs/a.md:2: ") && found.contains(expected), "{line}: {found:?} has no {expected}");
    }
    assert_eq!(faults("manypass render a.glb --set occlusion.radius_m=1 -o - --format y4m | ffplay -   # shown"), "");
}
