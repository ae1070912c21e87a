//! The files of a picture: which they are, and writing them.

use crate::failure::Failure;
use crate::job::Job;
use crate::pattern::{Output, expand, expand_with};
use crate::session::output_failure;
use manypass::PassPicture;
use manypass_offline::sheet::{self, contact_sheet};
use manypass_offline::{Format, atomic, encode};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The file of a picture, and of its AOVs where they have files of their own; none on standard output.
pub fn files(job: &Job, stem: &str, frame: u32) -> Option<(PathBuf, Vec<PathBuf>)> {
    let Output::Pattern(pattern) = &job.output else { return None };
    let target = expand(pattern, stem, frame, "rgba");
    let aov_file = |aov: &String| {
        let named = expand(pattern, stem, frame, aov);
        if named == target { target.with_extension(format!("{aov}.png")) } else { named }
    };
    let aovs = if job.format == Format::Png { job.aovs.iter().map(aov_file).collect() } else { Vec::new() };
    Some((target, aovs))
}

/// Fails if two pictures would be written to the same file. `extra` are further patterns, one file or folder a picture;
/// `single` are files that are written once. Frames are not counted out: two of them differ where `{frame}` stands.
///
/// # Errors
/// Wrong usage.
pub fn check_distinct(job: &Job, stems: &[String], extra: &[&Path], single: &[&Path]) -> Result<(), Failure> {
    let same = |text: &str| {
        let message = format!("two pictures would be written to {text}");
        Err(Failure::usage(message, "use {stem} and {frame:04} in the name"))
    };
    // No path holds this letter, so it can stand for the frame.
    let any_frame = |_: usize| "\0".to_owned();
    let is_sequence = job.frames.is_some_and(|(first, last)| first != last);
    let mut seen: BTreeSet<PathBuf> = single.iter().map(|path| path.to_path_buf()).collect();
    let mut patterns: Vec<(String, &str)> = extra.iter().map(|p| (p.to_string_lossy().into_owned(), "rgba")).collect();
    if let Output::Pattern(pattern) = &job.output {
        patterns.push((pattern.clone(), "rgba"));
        if job.format == Format::Png {
            patterns.extend(job.aovs.iter().map(|aov| (pattern.clone(), aov.as_str())));
        }
    }
    for stem in stems {
        for (pattern, aov) in &patterns {
            let mut path = PathBuf::from(expand_with(pattern, stem, aov, any_frame));
            if *aov != "rgba" && path == expand_with(pattern, stem, "rgba", any_frame) {
                path = path.with_extension(format!("{aov}.png"));
            }
            let shown = path.to_string_lossy().replace('\0', "{frame}");
            let is_same_in_all_frames = is_sequence && !path.to_string_lossy().contains('\0');
            if is_same_in_all_frames || !seen.insert(path) {
                return same(&shown);
            }
        }
    }
    Ok(())
}

/// Writes `NN-NAME.png` for every target of every pass; gives their paths.
///
/// # Errors
/// If one cannot be written.
pub fn write_passes(folder: &Path, pictures: &[PassPicture]) -> Result<Vec<String>, Failure> {
    let mut paths = Vec::with_capacity(pictures.len());
    for (index, picture) in pictures.iter().enumerate() {
        let path = folder.join(format!("{:02}-{}.png", index + 1, safe_name(&picture.name)));
        let bytes = encode::png_rgba8(picture.width, picture.height, &picture.rgba8).map_err(output_failure)?;
        atomic::write_file(&path, &bytes).map_err(output_failure)?;
        paths.push(path.display().to_string());
    }
    Ok(paths)
}

/// Writes every target of every pass into one picture.
///
/// # Errors
/// If it cannot be written.
pub fn write_sheet(path: &Path, pictures: &[PassPicture]) -> Result<(), Failure> {
    let entries: Vec<sheet::Entry<'_>> = pictures
        .iter()
        .map(|PassPicture { name, width, height, rgba8 }| sheet::Entry {
            label: name,
            width: *width,
            height: *height,
            rgba8,
        })
        .collect();
    let (width, height, pixels) = contact_sheet(&entries).map_err(output_failure)?;
    let bytes = encode::png_rgba8(width, height, &pixels).map_err(output_failure)?;
    atomic::write_file(path, &bytes).map_err(output_failure)
}

/// Letters, digits, dots, minus signs and underscores; every run of others becomes one minus sign.
fn safe_name(name: &str) -> String {
    let mut safe = String::new();
    for letter in name.chars() {
        if letter.is_ascii_alphanumeric() || matches!(letter, '.' | '_') {
            safe.push(letter);
        } else if !safe.ends_with('-') {
            safe.push('-');
        }
    }
    safe.trim_matches(['-', '.']).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_passes_are_safe() {
        assert_eq!(safe_name("geometry > base_color"), "geometry-base_color");
        assert_eq!(safe_name("../a//b\\c:d"), "a-b-c-d");
    }
}
