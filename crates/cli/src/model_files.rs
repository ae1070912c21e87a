//! The models and stages of a folder, and those that a pattern matches.

use crate::failure::{Failure, Kind};
use crate::stage::leave_out_named_models;
use manypass_scene::formats::is_model;
use manypass_scene::stage::is_stage;
use std::fs;
use std::path::{Component, Path, PathBuf};

/// Whether a file's ending is that of a model or of a stage.
fn is_input(path: &Path) -> bool {
    is_stage(path) || is_model(path)
}

/// The models and stages of a folder, by name; never none.
///
/// # Errors
/// If the folder cannot be read, or there are none.
pub fn in_folder(folder: &Path, recursive: bool, warnings: &mut Vec<String>) -> Result<Vec<PathBuf>, Failure> {
    let failed = |error: &dyn std::fmt::Display, hint: &str| {
        Failure::new(Kind::Failed, format!("cannot read {}: {error}", folder.display()), hint)
    };
    let hint = "name a folder of models (.glb, .gltf, .obj, .stl, .ply, .3mf) or .stage.toml files";
    fs::read_dir(folder).map_err(|error| failed(&error, hint))?;
    let mut files = Vec::new();
    let parts: &[&str] = if recursive { &["**", "*"] } else { &["*"] };
    collect(folder, parts, &mut files, warnings);
    if files.is_empty() {
        let has_folders = entries(folder, "*", &mut Vec::new()).iter().any(|(path, _)| path.is_dir());
        let hint = if recursive || !has_folders { hint } else { "add --recursive to look into its folders, too" };
        return Err(failed(&"it holds no model", hint));
    }
    files.sort();
    leave_out_named_models(&mut files);
    Ok(files)
}

/// The models and stages that a pattern matches, by name; never none.
///
/// # Errors
/// There are none.
pub fn matching(pattern: &str, warnings: &mut Vec<String>) -> Result<Vec<PathBuf>, Failure> {
    let (start, below) = start(pattern);
    let mut parts: Vec<&str> = below.split(std::path::is_separator).filter(|part| !part.is_empty()).collect();
    // `a/**/**/b` is `a/**/b`, and `a/**` is every file below.
    parts.dedup_by(|a, b| a == b && *a == "**");
    if parts.last() == Some(&"**") {
        parts.push("*");
    }
    let mut files = Vec::new();
    collect(&start, &parts, &mut files, warnings);
    files.sort();
    files.dedup();
    if files.is_empty() {
        let message = format!("no model matches `{pattern}`");
        return Err(Failure::new(Kind::Failed, message, "* and ? stand for letters of a name, ** for any folders"));
    }
    leave_out_named_models(&mut files);
    Ok(files)
}

/// The drive and the root that a pattern begins with, such as `C:\`, `\\server\share\` or `/`, and what follows them.
fn start(pattern: &str) -> (PathBuf, &str) {
    let is_start = |part: &Component<'_>| matches!(part, Component::Prefix(_) | Component::RootDir);
    let start: PathBuf = Path::new(pattern).components().take_while(is_start).collect();
    let below = start.to_str().and_then(|start| pattern.get(start.len()..));
    (start, below.unwrap_or(pattern))
}

/// Adds the models and stages below `folder` whose path matches `parts`.
fn collect(folder: &Path, parts: &[&str], files: &mut Vec<PathBuf>, warnings: &mut Vec<String>) {
    let Some((part, rest)) = parts.split_first() else { return };
    if *part == "**" {
        collect(folder, rest, files, warnings);
        for (path, is_link) in entries(folder, "*", warnings) {
            if !is_link && path.is_dir() {
                collect(&path, parts, files, warnings);
            }
        }
        return;
    }
    let found = if part.contains(['*', '?']) {
        entries(folder, part, warnings).into_iter().map(|(path, _)| path).collect()
    } else {
        vec![folder.join(part)]
    };
    for path in found {
        if !rest.is_empty() {
            collect(&path, rest, files, warnings);
        } else if is_input(&path) && !path.is_dir() {
            // What cannot be read, such as a link to nowhere, is an input that fails, and not one that is missed.
            files.push(path);
        }
    }
}

/// What a folder holds whose name matches, and whether it is a link. A folder that is none holds nothing.
fn entries(folder: &Path, pattern: &str, warnings: &mut Vec<String>) -> Vec<(PathBuf, bool)> {
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = match fs::read_dir(here) {
        Ok(entries) => entries,
        Err(_) if !here.is_dir() => return Vec::new(),
        Err(error) => {
            let warning = format!("cannot read {}: {error}; its files are left out", here.display());
            if !warnings.contains(&warning) {
                warnings.push(warning);
            }
            return Vec::new();
        }
    };
    let named = entries.flatten().filter(|entry| matches(pattern, &entry.file_name().to_string_lossy()));
    named.map(|entry| (folder.join(entry.file_name()), entry.file_type().is_ok_and(|kind| kind.is_symlink()))).collect()
}

/// Whether a name matches a pattern of letters, `?` (one letter) and `*` (any number of them). The dot of a hidden name
/// must be there in the pattern.
fn matches(pattern: &str, name: &str) -> bool {
    if name.starts_with('.') && !pattern.starts_with('.') {
        return false;
    }
    let (pattern, name): (Vec<char>, Vec<char>) = (pattern.chars().collect(), name.chars().collect());
    let (mut at, mut name_at) = (0, 0);
    // Where to go on after the last `*`, should what follows it not match.
    let mut retry: Option<(usize, usize)> = None;
    while name_at < name.len() {
        match pattern.get(at) {
            Some('*') => {
                retry = Some((at + 1, name_at));
                at += 1;
            }
            Some(letter) if *letter == '?' || Some(letter) == name.get(name_at) => {
                at += 1;
                name_at += 1;
            }
            _ => {
                let Some((after_star, start)) = retry else { return false };
                retry = Some((after_star, start + 1));
                (at, name_at) = (after_star, start + 1);
            }
        }
    }
    pattern.get(at..).is_none_or(|rest| rest.iter().all(|letter| *letter == '*'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_match_letters_and_leave_hidden_names_out() {
        for (pattern, name) in [("*", "a.glb"), ("a?c*.glb", "abcd.glb"), ("*b*b", "abab"), ("", ""), (".*", ".a")] {
            assert!(matches(pattern, name), "{pattern} {name}");
        }
        for (pattern, name) in [("*", ".a.glb"), ("?a", ".a"), ("a?", "a"), ("*b", "abc"), ("a", "")] {
            assert!(!matches(pattern, name), "{pattern} {name}");
        }
    }

    #[test]
    fn patterns_keep_their_drive_and_root() {
        assert_eq!(start("/a/*.glb"), (PathBuf::from("/"), "a/*.glb"));
        assert_eq!(start("a/*.glb"), (PathBuf::new(), "a/*.glb"));
        assert_eq!(start("./*.glb"), (PathBuf::new(), "./*.glb"));
        if cfg!(windows) {
            assert_eq!(start(r"C:\a\*.glb"), (PathBuf::from(r"C:\"), r"a\*.glb"));
            assert_eq!(start(r"C:a\*.glb"), (PathBuf::from("C:"), r"a\*.glb"));
            assert_eq!(start(r"\\s\t\a\*.glb"), (PathBuf::from(r"\\s\t\"), r"a\*.glb"));
        }
    }
}
