//! Settings as they are chosen: the defaults, a file, flags, then `--set`; each comes after the one before.

use crate::args::{ChangeArgs, FrameArgs};
use crate::failure::{Failure, Kind};
use crate::request::read_text;
use manypass::settings::{SettingsError, Written};
use manypass::{EffectFile, Settings, SettingsFile, effect};
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
        let own = [
            ("--environment", "environment.source", self.environment.as_deref()),
            ("--environment-intensity", "environment.intensity", self.environment_intensity.as_deref()),
            ("--background", "background.source", self.background.as_deref()),
            ("--exposure", "exposure.stops", self.exposure.as_deref()),
            ("--tonemap", "tone_map.curve", self.tonemap.as_deref()),
        ];
        own.into_iter().chain(self.change.flags()).collect()
    }
}

/// The settings of `render` and `graph`; those of `effects` go to them.
///
/// # Errors
/// A file that cannot be read, a wrong key or value, or a setting of an effect without default and value.
pub fn of_frame(args: &FrameArgs, effects: &mut [EffectFile]) -> Result<Settings, Failure> {
    let chosen = Chosen { file: args.settings.as_deref(), flags: args.flags(), change: &args.change };
    chosen.settings(Settings::default(), effects)
}

/// The settings of `bench`, which begins with `base`.
///
/// # Errors
/// As [`of_frame`].
pub fn of_change(base: Settings, args: &ChangeArgs, effects: &mut [EffectFile]) -> Result<Settings, Failure> {
    Chosen { file: None, flags: args.flags(), change: args }.settings(base, effects)
}

struct Chosen<'a> {
    file: Option<&'a Path>,
    flags: Vec<Flag<'a>>,
    change: &'a ChangeArgs,
}

impl Chosen<'_> {
    fn settings(&self, mut settings: Settings, effects: &mut [EffectFile]) -> Result<Settings, Failure> {
        let lists = list_hint(&self.change.effects);
        let pairs: Vec<(&str, &str)> = self.change.set.iter().map(|pair| key_value(pair)).collect::<Result<_, _>>()?;
        let hints: Vec<&str> = pairs.iter().map(|(key, _)| effect_hint(key, effects)).collect();
        if let Some(path) = self.file {
            let text = read_text(path, "name a TOML file")?;
            let mut hint = "";
            let mut set = |key: &str, written: &Written| {
                effect::set(&mut settings, effects, key, written).inspect_err(|error| {
                    if matches!(error, SettingsError::UnknownKey { .. }) {
                        hint = effect_hint(key, effects);
                    }
                })
            };
            SettingsFile::parse(&path.display().to_string(), &text)
                .and_then(|file| file.apply(&mut set))
                .map_err(|error| Failure::located(Kind::Usage, &error, format!("correct the file; {lists}{hint}")))?;
        }
        for (flag, key, value) in &self.flags {
            let Some(value) = value else { continue };
            settings.set(key, value).map_err(|error| flag_failure(flag, value, error))?;
        }
        for ((key, value), hint) in pairs.into_iter().zip(hints) {
            effect::set(&mut settings, effects, key, &Written::from(value))
                .map_err(|error| Failure::usage(error, format!("write --set KEY=VALUE; {lists}{hint}")))?;
        }
        effects.iter().find_map(missing).map_or(Ok(settings), Err)
    }
}

/// What is said of a flag's value, in words of the flag.
fn flag_failure(flag: &str, value: &str, error: SettingsError) -> Failure {
    let SettingsError::BadValue { expected, .. } = error else { return Failure::usage(error, "report this") };
    Failure::usage(format!("`{value}` is no value of {flag}"), format!("write {expected}"))
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

fn key_value(pair: &str) -> Result<(&str, &str), Failure> {
    let parts = pair.split_once('=').map(|(key, value)| (key.trim(), value.trim()));
    parts.ok_or_else(|| Failure::usage(format!("`--set {pair}` has no `=`"), "write --set KEY=VALUE"))
}

/// The frame's own groups are known; what is in no file that was named cannot be.
fn effect_hint(key: &str, effects: &[EffectFile]) -> &'static str {
    let group = |key: &str| key.split_once('.').map(|(group, _)| group.to_owned());
    // A key without a group is none of an effect's, either.
    let is_known = Settings::declared().iter().any(|info| group(&info.key) == group(key));
    let is_given = effects.iter().any(|effect| group(key).is_some_and(|group| group == effect.name()));
    if is_known || is_given || group(key).is_none() { "" } else { "; settings of effects need --effect FILE" }
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
            Command::Graph(args) => of_frame(&args.frame, &mut []),
            _ => Err(Failure::usage("not graph", "")),
        }
    }

    #[test]
    fn every_flag_is_a_short_way_to_a_setting() {
        assert_eq!(chosen(&[]).expect("defaults"), Settings::default());
        let flags = "--path forward --light-culling none --tonemap agx --environment #ff0000 --environment-intensity 2 \
                     --background transparent --exposure auto-1";
        let short = chosen(&flags.split_whitespace().collect::<Vec<_>>()).expect("flags");
        let set = "render.path=forward lights.culling=none tone_map.curve=agx environment.source=#ff0000 \
                   environment.intensity=2 background.source=transparent exposure.stops=auto-1";
        let long: Vec<&str> = set.split_whitespace().flat_map(|pair| ["--set", pair]).collect();
        assert_eq!(short, chosen(&long).expect("settings"));
        assert_eq!(short.environment.source, Environment::Color([1.0, 0.0, 0.0]));
        assert_eq!((short.render.path, short.lights.culling), (manypass::Path::Forward, LightCulling::None));
        assert_eq!((short.tone_map.curve, short.background.source), (Tonemap::Agx, Background::Transparent));
        assert_eq!(short.exposure.stops, Exposure::Auto { compensation_stops: -1.0 });
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
            (&["--environment", "12345"][..], "`12345` is no value of --environment"),
            (&["--background", "-1"], "`-1` is no value of --background"),
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
        }
    }
}
