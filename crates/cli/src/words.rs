//! The words of the command line before and after clap reads them.

use crate::args::Cli;
use crate::failure::Failure;
use clap::{Command, CommandFactory};
use manypass_scene::formats::is_model;
use std::ffi::{OsStr, OsString};
use std::path::Path;

/// The words, with every value that begins like a negative number joined to the flag before it, so that `--near -1` is
/// read as `--near=-1` and not as an unknown flag.
pub fn joined(words: impl IntoIterator<Item = OsString>) -> Vec<OsString> {
    let program = Cli::command();
    let words: Vec<OsString> = words.into_iter().collect();
    let subcommand = words.get(1).and_then(|name| program.find_subcommand(name.to_str()?));
    let Some(subcommand) = subcommand else { return words };
    let mut result: Vec<OsString> = Vec::with_capacity(words.len());
    let mut only_values_follow = false;
    for word in words {
        only_values_follow |= word == "--";
        match result.last_mut() {
            Some(flag) if !only_values_follow && is_negative(&word) && takes_value(subcommand, flag) => {
                flag.push("=");
                flag.push(word);
            }
            _ => result.push(word),
        }
    }
    result
}

fn is_negative(word: &OsStr) -> bool {
    let Some(rest) = word.to_str().and_then(|word| word.strip_prefix('-')) else { return false };
    let is_word = ["inf", "infinity", "nan"].iter().any(|name| rest.eq_ignore_ascii_case(name));
    is_word || rest.trim_start_matches('.').starts_with(|letter: char| letter.is_ascii_digit())
}

/// Whether `word` is a flag, alone, whose value is the next word.
fn takes_value(command: &Command, word: &OsStr) -> bool {
    let Some(word) = word.to_str() else { return false };
    let mut named = command.get_arguments().filter(|argument| {
        let is_long = word.strip_prefix("--").is_some_and(|name| argument.get_long() == Some(name));
        is_long
            || word.strip_prefix('-').is_some_and(|name| argument.get_short().is_some_and(|s| name == s.to_string()))
    });
    named.any(|argument| argument.get_action().takes_values())
}

/// What clap found wrong, as one line, and its tip.
pub fn usage_failure(error: &clap::Error) -> Failure {
    let text = error.to_string();
    let relevant = text.split("\nUsage:").next().unwrap_or_default();
    let relevant = relevant.split("\nFor more information").next().unwrap_or_default();
    let (tips, lines): (Vec<&str>, Vec<&str>) =
        relevant.lines().map(str::trim).filter(|line| !line.is_empty()).partition(|line| line.starts_with("tip: "));
    let command = std::env::args_os().nth(1).and_then(|name| name.into_string().ok());
    let command = command.filter(|name| Cli::command().find_subcommand(name).is_some());
    let is_model = |word: &String| is_model(Path::new(word));
    let model = std::env::args_os().skip(1).filter_map(|word| word.into_string().ok()).find(is_model);
    let help = match (command, model) {
        (Some(name), Some(model)) if model.starts_with('-') => {
            format!("write ./{model} if that is a file; see `manypass {name} --help`")
        }
        (Some(name), _) => format!("see `manypass {name} --help`"),
        (None, Some(model)) => format!("write `manypass render {model}`; see `manypass --help`"),
        (None, None) => "see `manypass --help`".into(),
    };
    // A value that looks like a flag is seldom what was meant, and `--` would make it an input.
    let tips = tips.iter().map(|tip| tip.trim_start_matches("tip: ")).filter(|tip| !tip.starts_with("to pass '-"));
    let tips: Vec<&str> = tips.collect();
    let hint = if tips.is_empty() { help } else { format!("{}; {help}", tips.join("; ")) };
    Failure::usage(lines.join(" ").trim_start_matches("error: "), hint)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn negative_values_join_their_flags_and_other_words_stay() {
        let join = |words: &str| {
            let joined = joined(words.split(' ').map(OsString::from));
            joined.iter().map(|word| word.to_string_lossy().into_owned()).collect::<Vec<_>>().join(" ")
        };
        for (words, expected) in [
            ("m render a.glb --near -1 --size -1x4", "m render a.glb --near=-1 --size=-1x4"),
            ("m render --exposure -inf --time -.5", "m render --exposure=-inf --time=-.5"),
            ("m render -o -1.png -q -1", "m render -o=-1.png -q -1"),
            ("m render --near=-1 -2", "m render --near=-1 -2"),
            ("m render --quiet -1 --near -o", "m render --quiet -1 --near -o"),
            ("m render -- --near -1", "m render -- --near -1"),
            ("m --near -1", "m --near -1"),
            ("m", "m"),
        ] {
            assert_eq!(join(words), expected);
        }
    }
}
