//! Where a file is and which one it is, by whatever name, link or hard link it is called.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Component, Path, PathBuf};

/// What tells a file that is there apart, whatever its name: device and inode.
type FileId = (u64, u64);

#[cfg(unix)]
fn file_id(metadata: &fs::Metadata) -> Option<FileId> {
    use std::os::unix::fs::MetadataExt;
    Some((metadata.dev(), metadata.ino()))
}

/// The standard library does not tell here; canonical paths do.
#[cfg(not(unix))]
fn file_id(_: &fs::Metadata) -> Option<FileId> {
    None
}

/// Files by place and by identity, each with what it is.
#[derive(Debug, Default)]
pub struct KnownFiles {
    by_path: BTreeMap<PathBuf, String>,
    by_id: BTreeMap<FileId, String>,
}

impl KnownFiles {
    /// What the file at `place` is, if it is known by its path or its identity.
    pub fn get(&self, place: &Place) -> Option<&str> {
        let by_id = place.id.and_then(|id| self.by_id.get(&id));
        self.by_path.get(&place.path).or(by_id).map(String::as_str)
    }

    /// Adds a file.
    pub fn insert(&mut self, place: Place, what: String) {
        if let Some(id) = place.id {
            self.by_id.insert(id, what.clone());
        }
        self.by_path.insert(place.path, what);
    }
}

/// Where a file is or would be, without links and dots, and which one is there.
#[derive(Debug)]
pub struct Place {
    /// Without links and dots.
    pub path: PathBuf,
    id: Option<FileId>,
}

/// Finds places, and remembers those of folders.
#[derive(Debug, Default)]
pub struct Lookup {
    folders: BTreeMap<PathBuf, PathBuf>,
}

impl Lookup {
    /// Where `path` leads. Folders that are not there yet are taken as they are written.
    pub fn place(&mut self, path: &Path) -> Place {
        let id = fs::metadata(path).ok().filter(fs::Metadata::is_file).as_ref().and_then(file_id);
        let target = fs::canonicalize(path).ok().filter(|_| path.is_symlink());
        Place { path: target.map_or_else(|| self.path_without_link(path), same_case), id }
    }

    /// The place of what is not there yet.
    pub fn absent(&mut self, path: &Path) -> Place {
        Place { path: self.path_without_link(path), id: None }
    }

    /// Where `path` is, if it is no link itself.
    fn path_without_link(&mut self, path: &Path) -> PathBuf {
        let (Some(folder), Some(name)) = (path.parent(), path.file_name()) else { return same_case(resolve(path)) };
        let folder = self.folders.entry(folder.to_owned()).or_insert_with(|| resolve(folder));
        same_case(folder.join(name))
    }
}

/// Whether a regular file is there, also where an open descriptor is named.
pub fn is_file(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|metadata| metadata.is_file())
}

/// Upper and lower case name the same file on these systems, unless somebody changed that.
fn same_case(path: PathBuf) -> PathBuf {
    if cfg!(any(windows, target_os = "macos")) { path.to_string_lossy().to_lowercase().into() } else { path }
}

/// A path without links and dots, whether it is there or not.
fn resolve(path: &Path) -> PathBuf {
    let mut resolved = if path.is_absolute() { PathBuf::new() } else { std::env::current_dir().unwrap_or_default() };
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => {
                resolved.pop();
            }
            part => {
                resolved.push(part);
                if let Ok(there) = fs::canonicalize(&resolved) {
                    resolved = there;
                }
            }
        }
    }
    resolved
}
