//! The files of a picture: which they are, and writing them.

use crate::failure::Failure;
use crate::interrupt;
use crate::job::{Job, Output, StreamPlace};
use crate::looks::{Subject, safe_name};
use crate::pattern::Pattern;
use crate::session::{output_failure, write_failure};
use manypass::PassPicture;
use manypass_offline::atomic::AtomicFile;
use manypass_offline::sheet::{self, contact_sheet};
use manypass_offline::{Format, encode, picture_end};
use manypass_scene::input_file;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

/// The file of a picture, and of its AOVs where they have files of their own; none in a stream.
pub fn files(job: &Job, subject: Subject<'_>) -> Option<(PathBuf, Vec<PathBuf>)> {
    let Output::Pattern(pattern) = &job.output else { return None };
    let target = pattern.expand(subject, "rgba");
    let aov_file = |aov: &String| {
        let named = pattern.expand(subject, aov);
        if named == target { target.with_extension(format!("{aov}.png")) } else { named }
    };
    let aovs = if job.format == Format::Png { job.aovs.iter().map(aov_file).collect() } else { Vec::new() };
    Some((target, aovs))
}

/// The name of a picture's output in reports; `files` are its files.
pub fn shown(job: &Job, files: Option<&(PathBuf, Vec<PathBuf>)>) -> String {
    let of_stream = || job.output.stream().map_or("-".into(), StreamPlace::shown);
    files.map_or_else(of_stream, |(target, _)| target.display().to_string())
}

/// Whether a name is one that `--dump-passes` may give: `NN-NAME.png`.
pub fn is_pass_picture(name: &OsStr) -> bool {
    let name = name.to_string_lossy();
    let (number, rest) = name.split_once('-').unwrap_or_default();
    number.len() >= 2 && number.bytes().all(|digit| digit.is_ascii_digit()) && rest.ends_with(".png")
}

/// Whether a picture is there to its end. One that was cut off while it was copied is drawn again.
fn is_whole(path: &Path) -> bool {
    input_file::open(path).is_ok_and(|mut file| picture_end::is_whole(&mut file).unwrap_or(false))
}

/// Whether every file that is asked for of a picture is there. Of the pictures of its passes one is enough, since their
/// names are known only when they are drawn, but none of them may be cut off. A device is always there, and never done.
pub fn are_there(job: &Job, subject: Subject<'_>) -> bool {
    let has_passes = |folder: PathBuf| {
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        let mut passes = entries.filter(|entry| is_pass_picture(&entry.file_name())).peekable();
        passes.peek().is_some() && passes.all(|entry| is_whole(&entry.path()))
    };
    let place = |pattern: &Pattern| pattern.expand(subject, "rgba");
    files(job, subject).is_some_and(|(target, aovs)| is_whole(&target) && aovs.iter().all(|path| is_whole(path)))
        && job.contact_sheet.as_ref().map(place).is_none_or(|sheet| is_whole(&sheet))
        && job.dump_passes.as_ref().map(place).is_none_or(has_passes)
}

/// Begins a file, unless the user has said stop. If the user says so before it is in its place, nothing of it stays.
///
/// # Errors
/// If it cannot be opened, or the user has said stop.
pub fn begin(path: &Path) -> Result<AtomicFile, Failure> {
    interrupt::check()?;
    Ok(AtomicFile::create(path).map_err(write_failure)?.heeding(&interrupt::STOP))
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
        write_file(&path, &bytes)?;
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
        .map(|PassPicture { name, width, height, rgba8, legend, .. }| sheet::Entry {
            label: name,
            group: sheet::group_of_pass(name),
            width: *width,
            height: *height,
            rgba8,
            legend,
        })
        .collect();
    let (width, height, pixels) = contact_sheet(&entries).map_err(output_failure)?;
    let bytes = encode::png_rgba8(width, height, &pixels).map_err(output_failure)?;
    write_file(path, &bytes)
}

/// Writes a whole file, or nothing.
///
/// # Errors
/// If it cannot be written, or the user has said stop.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let mut file = begin(path)?;
    file.write(bytes).map_err(write_failure)?;
    file.commit().map_err(write_failure)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_passes_have_a_number() {
        for (name, expected) in [("01-a.png", true), ("100-b.c.png", true), ("1-a.png", false), ("a-b.png", false)] {
            assert_eq!(is_pass_picture(OsStr::new(name)), expected, "{name}");
        }
    }
}
