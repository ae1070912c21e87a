//! Settings as they are chosen: the defaults, the input's stage, a preset, a file, flags, then `--set`; each comes after
//! the one before.

use crate::args::{ChangeArgs, FrameArgs};
use crate::failure::{Failure, Kind};
use crate::input::Input;
use crate::older;
use crate::preset::Preset;
use crate::request::{effect_files, effect_names, program_failure, read_effect, read_text};
use manypass::settings::{SettingInput, SettingsError};
use manypass::shader::ProgramError;
use manypass::{Diagnostic, EffectFile, Quality, Settings, SettingsFile, effect};
use manypass_scene::Stage;
use manypass_scene::renamed::{NameChange, NameKind, RENAMED, renamed};
use std::path::{Path, PathBuf};

/// A flag that is a short way to a setting: its name, the key, and the value if it was given.
type Flag<'a> = (&'static str, &'static str, Option<&'a str>);

impl ChangeArgs {
    fn flags(&self) -> Vec<Flag<'_>> {
        vec![
            ("--path", "render.path", self.path.as_deref()),
            ("--light-culling", "lights.culling", self.light_culling.as_deref()),
        ]
    }
}

impl FrameArgs {
    fn flags(&self) -> Vec<Flag<'_>> {
        let environment = self.around.environment.as_deref();
        let file = environment.filter(|value| is_picture(value));
        let own = [
            ("--environment", "environment.source", if file.is_some() { Some("file") } else { environment }),
            ("--environment", "environment.file", file),
            // What a stage says of its picture's light is of that picture.
            ("--environment", "environment.irradiance_file", file.map(|_| "")),
            ("--environment", "environment.prefiltered_file", file.map(|_| "")),
            ("--environment-rotation", "environment.rotation_deg", self.around.environment_rotation.as_deref()),
            ("--environment-intensity", "environment.intensity", self.around.environment_intensity.as_deref()),
            ("--background", "background.source", self.background.as_deref()),
            ("--ground", "ground.mode", self.ground.as_deref()),
            ("--exposure", "exposure.stops", self.exposure.as_deref()),
            ("--tonemap", "tone_map.curve", self.tonemap.as_deref()),
        ];
        own.into_iter().chain(self.change.flags()).collect()
    }
}

/// Whether the value of `--environment` is a file, or a folder with the faces of a cube, and no word or colour.
fn is_picture(value: &str) -> bool {
    let end = Path::new(value).extension();
    let is_file = end.is_some_and(|end| ["hdr", "exr", "ktx2"].iter().any(|known| end.eq_ignore_ascii_case(known)));
    is_file || Path::new(value).is_dir() && Settings::default().set("environment.source", value).is_err()
}

/// What was chosen on the command line; the file of settings is read once, because a pipe cannot be read again.
pub struct SettingsChoice<'a> {
    file: Option<SettingsFile>,
    /// The folder of that file.
    folder: &'a Path,
    flags: Vec<Flag<'a>>,
    change: &'a ChangeArgs,
    /// The effects that flags name.
    given: Vec<EffectFile>,
    meets_stages: bool,
    preset: Option<Preset>,
}

impl<'a> SettingsChoice<'a> {
    /// The choice of `render` and `graph`.
    ///
    /// # Errors
    /// A file of settings that cannot be read, or is not TOML; an effect that cannot be read, or is none.
    pub fn of_frame(args: &'a FrameArgs) -> Result<Self, Failure> {
        let read = |path: &PathBuf| {
            let text = read_text(path, "name a TOML file")?;
            SettingsFile::parse(&path.display().to_string(), &text)
                .map_err(|error| file_failure(&error, &args.change.effects, ""))
        };
        let file = args.settings.as_ref().map(read).transpose()?;
        let folder = args.settings.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
        let given = effect_files(&args.change.effects)?;
        let preset = args.preset.as_deref().and_then(Preset::named);
        Ok(Self { file, folder, flags: args.flags(), change: &args.change, given, meets_stages: false, preset })
    }

    /// The choice of `bench`.
    ///
    /// # Errors
    /// An effect that cannot be read, or is none.
    pub fn of_change(args: &'a ChangeArgs) -> Result<Self, Failure> {
        let given = effect_files(&args.effects)?;
        Ok(Self {
            file: None,
            folder: Path::new(""),
            flags: args.flags(),
            change: args,
            given,
            meets_stages: false,
            preset: None,
        })
    }

    /// The same where some input is a stage, which has effects of its own.
    pub fn meeting_stages(self, meets_stages: bool) -> Self {
        Self { meets_stages, ..self }
    }

    /// The chains that `--set`, the file of settings and the stage have, in the order in which they count.
    fn layers<'l>(&'l self, stage: Option<&'l Stage>) -> Result<Vec<Layer<'l>>, Failure> {
        let here = Path::new("");
        let pairs = self.change.set.iter().filter_map(|pair| key_value(pair).ok());
        let set: Vec<(&str, SettingInput)> = pairs.map(|(key, value)| (key, value.into())).collect();
        let of_set = |key: &str| set.iter().rev().find(|(known, _)| *known == key).map(|(_, written)| written);
        if of_set("chain").is_some() && of_set("effects.chain").is_some() {
            let hint = "leave one of them out";
            return Err(Failure::usage("--set gives the chain of effects as `chain` and as `effects.chain`", hint));
        }
        let mut layers = Vec::new();
        if let Some(names) = Settings::chain_of(of_set) {
            layers.push(Layer { names, folder: here, file: None, kind: Kind::Usage });
        }
        if let Some(file) = &self.file {
            let names =
                Settings::chain_of_file(file).map_err(|error| file_failure(&error, &self.change.effects, ""))?;
            let layer = |names| Layer { names, folder: self.folder, file: Some(file.clone()), kind: Kind::Usage };
            layers.extend(names.map(layer));
        }
        if let Some(stage) = stage {
            let file = Settings::stage_settings(stage).map_err(|error| stage_failure(&error))?;
            let names = Settings::chain_of_file(&file).map_err(|error| stage_failure(&error))?;
            let folder = Path::new(stage.file()).parent().unwrap_or(here);
            layers.extend(names.map(|names| Layer { names, folder, file: Some(file), kind: Kind::Failed }));
        }
        Ok(layers)
    }

    /// The effects of the chain that counts: of `--set`, of the file of settings, or of the stage; then those of flags
    /// that it does not name.
    fn chain<'l>(&'l self, stage: Option<&'l Stage>) -> Result<ReadChain<'l>, Failure> {
        let mut layers = self.layers(stage)?.into_iter();
        let of_flags = Layer { names: Vec::new(), folder: Path::new(""), file: None, kind: Kind::Usage };
        let layer = layers.next().unwrap_or(of_flags);
        let read = |name: &str| layer.read(name, &self.given).map_err(EffectFault::Failure);
        let effects = EffectFile::chain(&layer.names, self.given.clone(), read).map_err(|unread| match unread {
            EffectFault::Failure(failure) => failure,
            EffectFault::Program(error) => layer.misplaced(&error, "list each effect once"),
        })?;
        let absent = layers.flat_map(|layer| {
            let read: Vec<_> = layer.names.iter().filter_map(|name| layer.read(name, &[]).ok()).collect();
            read
        });
        let absent = absent.filter(|file| effects.iter().all(|drawn| drawn.name() != file.name())).collect();
        Ok(ReadChain { effects, absent, layer })
    }

    /// The settings: `base`, those of the input's stage, then what was chosen; and the effects of the chain with theirs.
    ///
    /// # Errors
    /// A wrong key or value, or a setting of an effect without default and value; an effect of the chain that is not there,
    /// or reads what is not.
    pub fn settings(&self, base: Settings, stage: Option<&Stage>) -> Result<(Settings, Vec<EffectFile>), Failure> {
        let mut settings = base;
        if let Some(quality) = self.quality() {
            settings.apply_quality(quality).map_err(|error| Failure::usage(error, "report this"))?;
        }
        self.settings_over(settings, stage)
    }

    /// The older names that an input, its stage, the file of settings and `--set` use; each once.
    pub fn older_names(&self, input: &Input, stage: Option<&Stage>) -> Vec<&'static NameChange> {
        let of_pair = |pair: &String| renamed(NameKind::Setting, key_value(pair).ok()?.0);
        let mut used = older::of_input(input, stage);
        used.extend(self.file.iter().flat_map(SettingsFile::older_names));
        used.extend(self.change.set.iter().filter_map(of_pair));
        RENAMED.iter().filter(|renamed| used.contains(renamed)).collect()
    }

    /// What the picture is for, where that was said.
    pub fn preset(&self) -> Option<Preset> {
        self.preset
    }

    /// The tier that was chosen.
    pub fn quality(&self) -> Option<Quality> {
        self.change.quality.as_deref().and_then(Quality::named)
    }

    /// As [`Self::settings`], over what `tier` has in place of the tier that was chosen.
    ///
    /// # Errors
    /// As [`Self::settings`].
    pub fn settings_over(&self, tier: Settings, stage: Option<&Stage>) -> Result<(Settings, Vec<EffectFile>), Failure> {
        let mut settings = tier;
        let lists = list_hint(&self.change.effects);
        let ReadChain { mut effects, mut absent, layer } = self.chain(stage)?;
        let drawn_count = effects.len();
        effects.append(&mut absent);
        let effects = &mut effects;
        if let Some(stage) = stage {
            settings.apply_stage(stage, effects).map_err(|error| stage_failure(&error))?;
        }
        for (key, value) in self.preset.iter().flat_map(|preset| preset.table()) {
            settings.set(key, value).map_err(|error| Failure::usage(error, "report this"))?;
        }
        let pairs: Vec<(&str, &str)> = self.change.set.iter().map(|pair| key_value(pair)).collect::<Result<_, _>>()?;
        let hints: Vec<&str> = pairs.iter().map(|(key, _)| effect_hint(key, effects)).collect();
        if let Some(file) = &self.file {
            let mut hint = "";
            let mut set = |key: &str, written: &SettingInput| {
                effect::set_of_file(&mut settings, effects, key, written).inspect_err(|error| {
                    if matches!(error, SettingsError::UnknownKey { .. }) {
                        hint = effect_hint(key, effects);
                    }
                })
            };
            let applied = file.apply(&mut set);
            applied.map_err(|error| file_failure(&error, &self.change.effects, hint))?;
        }
        for (flag, key, value) in &self.flags {
            let Some(value) = value else { continue };
            settings.set(key, value).map_err(|error| flag_failure(flag, value, error))?;
        }
        effects.truncate(drawn_count);
        for ((key, value), hint) in pairs.into_iter().zip(hints) {
            match effect::set(&mut settings, effects, key, &SettingInput::from(value)) {
                // Of an effect of a stage that is still to be read.
                Err(SettingsError::UnknownKey { .. }) if !hint.is_empty() && stage.is_none() && self.meets_stages => {}
                result => {
                    result.map_err(|error| Failure::usage(error, format!("write --set KEY=VALUE; {lists}{hint}")))?;
                }
            }
        }
        if let Some(failure) = effects.iter().find_map(missing) {
            return Err(failure);
        }
        EffectFile::check_chain(effects).map_err(|error| layer.misplaced(&error, "correct the chain of effects"))?;
        Ok((settings, std::mem::take(effects)))
    }
}

/// The effects of a chain.
struct ReadChain<'l> {
    effects: Vec<EffectFile>,
    /// Those of the chains that do not count, as far as they can be read: what is said of them is no mistake.
    absent: Vec<EffectFile>,
    layer: Layer<'l>,
}

/// A chain of effects as it was written.
struct Layer<'l> {
    names: Vec<String>,
    /// From where its files are seen.
    folder: &'l Path,
    /// Where it stands, if that is a file.
    file: Option<SettingsFile>,
    /// What is wrong with it is a fault of this kind: of usage, or of an input.
    kind: Kind,
}

impl Layer<'_> {
    /// The effect of an entry that is none of `given`, nor built in.
    fn read(&self, name: &str, given: &[EffectFile]) -> Result<EffectFile, Failure> {
        let is_file = |end: &std::ffi::OsStr| ["wgsl", "cube"].iter().any(|known| end.eq_ignore_ascii_case(known));
        if Path::new(name).extension().is_some_and(is_file) {
            return read_effect(&self.folder.join(name)).map_err(|failure| match failure.located {
                None => self.refused(name, (&failure.message, &failure.hint), failure.kind),
                Some(_) => failure,
            });
        }
        let message = EffectFile::unknown_name(name, given.iter().map(EffectFile::name));
        let brackets = if name.contains(['[', ']', '"']) {
            "; --set takes bloom,film or '[\"bloom\", \"film\"]', the quotes around it for the shell"
        } else {
            ""
        };
        let hint = format!("{}; the chain also takes names of those of --effect{brackets}", effect_names());
        Err(self.refused(name, (&message, &hint), self.kind))
    }

    /// What is wrong with the entry `name`, at its place.
    fn refused(&self, name: &str, (message, hint): (&str, &str), kind: Kind) -> Failure {
        let place = self.file.as_ref().and_then(|file| Settings::refusal_in_chain(file, name, message));
        place.map_or_else(|| Failure::new(kind, message, hint), |place| Failure::located(kind, &place, hint))
    }

    /// What is wrong with effects that do not go together.
    fn misplaced(&self, error: &ProgramError, hint: &str) -> Failure {
        match error {
            ProgramError::Misplaced { pass, .. } => self.refused(pass, (&error.to_string(), hint), self.kind),
            error => program_failure(error, hint),
        }
    }
}

/// Why an effect of a chain is not there.
enum EffectFault {
    Failure(Failure),
    Program(ProgramError),
}

impl From<ProgramError> for EffectFault {
    fn from(error: ProgramError) -> Self {
        Self::Program(error)
    }
}

fn stage_failure(error: &Diagnostic) -> Failure {
    Failure::located(
        Kind::Failed,
        error,
        "correct the stage; `manypass settings` lists the keys, and with --effect NAME those of an effect",
    )
}

/// What is wrong with a file of settings.
fn file_failure(error: &Diagnostic, effects: &[PathBuf], hint: &str) -> Failure {
    Failure::located(Kind::Usage, error, format!("correct the file; {}{hint}", list_hint(effects)))
}

/// What is said of a flag's value, in words of the flag.
fn flag_failure(flag: &str, value: &str, error: SettingsError) -> Failure {
    let SettingsError::BadValue { expected, .. } = error else { return Failure::usage(error, "report this") };
    let is_environment = value == "sky" || value.ends_with(".hdr") || value.ends_with(".exr");
    let hint = if flag == "--background" && is_environment {
        format!("write --environment {value}, which is behind the model, too")
    } else {
        format!("write {expected}")
    };
    Failure::usage(format!("`{value}` is not a value of {flag}"), hint)
}

/// A setting of an effect that has no value.
fn missing(effect: &EffectFile) -> Option<Failure> {
    let (setting, missing) = effect.missing()?;
    let hint = match setting {
        Some(info) => {
            let value = info.placeholder();
            format!("add --set {}={value}, or a default above the member: `// = N in MIN..MAX`", info.key)
        }
        None => "make it of numbers and vectors, or padding (`_`, `padding`)".into(),
    };
    Some(Failure::located(Kind::Usage, missing, hint))
}

/// The key and the value of `--set`.
///
/// # Errors
/// There is no `=`.
pub fn key_value(pair: &str) -> Result<(&str, &str), Failure> {
    let parts = pair.split_once('=').map(|(key, value)| (key.trim(), value.trim()));
    parts.ok_or_else(|| Failure::usage(format!("`--set {pair}` has no `=`"), "write --set KEY=VALUE"))
}

/// The frame's own groups are known; what is in no file that was named cannot be.
fn effect_hint(key: &str, effects: &[EffectFile]) -> &'static str {
    let group = |key: &str| key.split_once('.').map(|(group, _)| group.to_owned());
    // A key without a group is none of an effect's, either.
    let is_known = Settings::declared().iter().any(|info| group(&info.key) == group(key));
    let is_given = effects.iter().any(|effect| group(key).is_some_and(|group| group == effect.name()));
    if is_known || is_given || group(key).is_none() {
        ""
    } else {
        "; settings of effects need --effect NAME|FILE.wgsl, or the effect in the chain"
    }
}

/// Where the keys are listed.
fn list_hint(effects: &[PathBuf]) -> String {
    let flags: String = effects.iter().map(|path| format!(" --effect {}", path.display())).collect();
    format!("`manypass settings{flags}` lists the keys")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::{Cli, Command};
    use clap::Parser;
    use manypass::{Background, Environment, Exposure, LightCulling, Tonemap};

    fn chosen(flags: &[&str]) -> Result<Settings, Failure> {
        let cli = Cli::try_parse_from(["manypass", "graph", "a.glb"].iter().chain(flags));
        match cli.map_err(|error| Failure::usage(error, ""))?.command {
            Command::Graph(args) => {
                SettingsChoice::of_frame(&args.frame)?.settings(Settings::default(), None).map(|(settings, _)| settings)
            }
            _ => Err(Failure::usage("not graph", "")),
        }
    }

    #[test]
    fn every_flag_is_a_short_way_to_a_setting() {
        assert_eq!(chosen(&[]).expect("defaults"), Settings::default());
        let flags = "--path forward --light-culling none --tonemap agx --environment #ff0000 --environment-intensity 2 \
                     --environment-rotation 30 --background transparent --ground none --exposure auto-1";
        let short = chosen(&flags.split_whitespace().collect::<Vec<_>>()).expect("flags");
        let set = "render.path=forward lights.culling=none tone_map.curve=agx environment.source=#ff0000 \
                   environment.intensity=2 environment.rotation_deg=30 background.source=transparent ground.mode=none \
                   exposure.stops=auto-1";
        let long: Vec<&str> = set.split_whitespace().flat_map(|pair| ["--set", pair]).collect();
        assert_eq!(short, chosen(&long).expect("settings"));
        assert_eq!(short.environment.source, Environment::Color([1.0, 0.0, 0.0]));
        assert_eq!((short.render.path, short.lights.culling), (manypass::Path::Forward, LightCulling::None));
        assert_eq!((short.tone_map.curve, short.background.source), (Tonemap::Agx, Background::Transparent));
        assert_eq!(short.exposure.stops, Exposure::Auto { compensation_stops: -1.0 });
    }

    #[test]
    fn the_docs_name_every_flag() {
        let docs = include_str!("../../../docs/settings.md");
        let place =
            docs.split("the flags that are short ways to keys").nth(1).and_then(|rest| rest.split("5. ").next());
        let place = place.expect("the list of where a value comes from");
        let cli = Cli::try_parse_from(["manypass", "graph", "a.glb"]).expect("no flags");
        let Command::Graph(args) = cli.command else { panic!("not graph") };
        for (flag, ..) in args.frame.flags() {
            assert!(place.contains(&format!("`{flag}`")), "{flag} is missing in docs/settings.md");
        }
    }

    #[test]
    fn set_comes_after_flags_whatever_their_order() {
        for flags in
            [["--set", "tone_map.curve=agx", "--tonemap", "aces"], ["--tonemap", "aces", "--set", "tone_map.curve=agx"]]
        {
            assert_eq!(chosen(&flags).expect("settings").tone_map.curve, Tonemap::Agx);
        }
    }

    #[test]
    fn nonsense_is_wrong_usage_in_words_of_the_flag() {
        for (flags, expected) in [
            (&["--environment", "12345"][..], "`12345` is not a value of --environment"),
            (&["--background", "-1"], "`-1` is not a value of --background"),
            (&["--background", "sky"], "`sky` is not a value of --background"),
            (&["--exposure", "65"], "--exposure"),
            (&["--environment-intensity", "-1"], "--environment-intensity"),
            (&["--set", "a"], "has no `=`"),
        ] {
            let flags: Vec<String> =
                crate::words::joined(["manypass", "graph", "a.glb"].iter().chain(flags).map(std::ffi::OsString::from))
                    .into_iter()
                    .skip(3)
                    .filter_map(|word| word.into_string().ok())
                    .collect();
            let failure = chosen(&flags.iter().map(String::as_str).collect::<Vec<_>>()).expect_err(expected);
            assert!(failure.code() == 2 && failure.message.contains(expected), "{failure:?}");
            let is_sky = flags.contains(&"sky".to_owned());
            assert_eq!(failure.hint.contains("--environment sky"), is_sky);
        }
    }
}
