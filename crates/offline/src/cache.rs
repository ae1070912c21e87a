//! A folder of files that processes share, for what is dear to make.
//!
//! Files appear whole or not at all ([`crate::atomic`]), so that processes need not wait for each other. When there is
//! more than fits, those go that nobody has read for the longest time. Where the folder cannot be read or written there
//! is simply no cache.

use crate::atomic::{AtomicFile, WriteError};
use manypass::Cache;
use std::env;
use std::fs::{self, File};
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// With this variable set to anything but nothing and 0 there is no cache.
pub const NO_CACHE: &str = "MANYPASS_NO_CACHE";

/// The bytes of a folder at most.
pub const BYTES_MAX: u64 = 512 << 20;

/// What the names of its files end in.
const ENDING: &str = "cache";

/// What a killed process left of a file is of no use after so long.
const UNFINISHED_AFTER: Duration = Duration::from_secs(24 * 60 * 60);

/// A folder of files.
#[derive(Clone, Debug)]
pub struct DiskCache {
    folder: PathBuf,
    bytes_max: u64,
}

/// A file of the folder.
struct Entry {
    path: PathBuf,
    bytes: u64,
    read: SystemTime,
}

impl DiskCache {
    /// In `folder`, which is made when something is kept, with at most `bytes_max` bytes.
    pub fn new(folder: PathBuf, bytes_max: u64) -> Self {
        Self { folder, bytes_max }
    }

    /// That of the user: `manypass` in `$XDG_CACHE_HOME`, else where the system has caches. None where there is no such
    /// place, or [`NO_CACHE`] is set.
    pub fn of_user() -> Option<Self> {
        let place = |name: &str| env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
        if env::var_os(NO_CACHE).is_some_and(|value| !value.is_empty() && value != "0") {
            return None;
        }
        let of_system = || match env::consts::OS {
            "windows" => place("LOCALAPPDATA"),
            "macos" => Some(place("HOME")?.join("Library/Caches")),
            _ => Some(place("HOME")?.join(".cache")),
        };
        let folder = place("XDG_CACHE_HOME").or_else(of_system)?;
        Some(Self::new(folder.join("manypass"), BYTES_MAX))
    }

    /// Its folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.join(format!("{name}.{ENDING}"))
    }

    fn entries(&self) -> Vec<Entry> {
        let entry = |entry: fs::DirEntry| {
            let metadata = entry.metadata().ok().filter(fs::Metadata::is_file)?;
            Some(Entry { path: entry.path(), bytes: metadata.len(), read: metadata.modified().ok()? })
        };
        let Ok(folder) = fs::read_dir(&self.folder) else { return Vec::new() };
        folder.flatten().filter_map(entry).collect()
    }

    /// Makes room: those that were not read for the longest time go first. Another process may do the same.
    fn make_room(&self) {
        let is_kept = |entry: &Entry| entry.path.extension().is_some_and(|ending| ending == ENDING);
        let (mut kept, others): (Vec<Entry>, Vec<Entry>) = self.entries().into_iter().partition(is_kept);
        let is_old = |entry: &&Entry| entry.read.elapsed().is_ok_and(|age| age > UNFINISHED_AFTER);
        others.iter().filter(is_old).for_each(|entry| remove(&entry.path));
        let mut bytes: u64 = kept.iter().map(|entry| entry.bytes).sum();
        kept.sort_by_key(|entry| entry.read);
        for entry in kept {
            if bytes <= self.bytes_max {
                break;
            }
            remove(&entry.path);
            bytes -= entry.bytes;
        }
    }
}

fn remove(path: &Path) {
    // It may be gone already.
    let _ = fs::remove_file(path);
}

impl Cache for DiskCache {
    fn get(&self, name: &str) -> Option<Vec<u8>> {
        // An entry that is a link or a pipe is none of this cache's: it would block, or lead elsewhere.
        let is_entry = fs::symlink_metadata(self.path(name)).is_ok_and(|entry| entry.is_file());
        let mut file = if is_entry { File::open(self.path(name)).ok()? } else { return None };
        let bytes = file.metadata().ok()?.len();
        if bytes > self.bytes_max {
            return None;
        }
        let mut kept = Vec::with_capacity(usize::try_from(bytes).ok()?);
        file.by_ref().take(bytes).read_to_end(&mut kept).ok()?;
        // Where the folder may only be read it is as old as before.
        let now = File::options().append(true).open(self.path(name));
        let _ = now.and_then(|file| file.set_modified(SystemTime::now()));
        Some(kept)
    }

    fn put(&self, name: &str, bytes: &[u8]) {
        let write = || -> Result<(), WriteError> {
            let path = self.path(name);
            // A link would be written through.
            if fs::symlink_metadata(&path).is_ok_and(|entry| !entry.is_file()) {
                remove(&path);
                if fs::symlink_metadata(&path).is_ok() {
                    return Ok(());
                }
            }
            // Whoever reads an entry finds out whether it is whole.
            let mut file = AtomicFile::create(&path)?.unsynced();
            file.write(bytes)?;
            file.commit()
        };
        if bytes.len() as u64 <= self.bytes_max && write().is_ok() {
            self.make_room();
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use super::*;

    fn folder(name: &str) -> PathBuf {
        let folder = env::temp_dir().join(format!("manypass-cache-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        folder
    }

    #[test]
    fn what_was_not_read_for_the_longest_time_makes_room() {
        let folder = folder("room");
        let cache = DiskCache::new(folder.clone(), 250);
        assert_eq!(cache.get("a"), None);
        let age = |name: &str, secs: u64| {
            let file = File::options().append(true).open(cache.path(name)).unwrap();
            file.set_modified(SystemTime::now() - Duration::from_secs(secs)).unwrap();
        };
        cache.put("a", &[1; 100]);
        cache.put("b", &[2; 100]);
        age("a", 60);
        age("b", 30);
        // Reading it makes it the younger one.
        assert_eq!(cache.get("a"), Some(vec![1; 100]));
        cache.put("c", &[3; 100]);
        assert_eq!(["a", "b", "c"].map(|name| cache.get(name).is_some()), [true, false, true]);
        cache.put("large", &[4; 251]);
        assert_eq!(cache.get("large"), None);
        // What a killed process left.
        fs::write(folder.join(".manypass-x.partial"), [0; 10]).unwrap();
        let left = File::options().append(true).open(folder.join(".manypass-x.partial")).unwrap();
        left.set_modified(SystemTime::now() - 2 * UNFINISHED_AFTER).unwrap();
        cache.put("d", &[5; 10]);
        assert!(!folder.join(".manypass-x.partial").exists());
        fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn many_at_once_see_whole_entries() {
        let folder = folder("many");
        std::thread::scope(|scope| {
            for thread in 0..4u8 {
                let cache = DiskCache::new(folder.clone(), 40_000);
                scope.spawn(move || {
                    for i in 0..50u8 {
                        let name = format!("{}", (i + thread) % 6);
                        if let Some(bytes) = cache.get(&name) {
                            assert!(bytes.len() == 10_000 && bytes.iter().all(|byte| *byte == bytes[0]), "{name}");
                        }
                        cache.put(&name, &[thread; 10_000]);
                    }
                });
            }
        });
        let cache = DiskCache::new(folder.clone(), 40_000);
        cache.put("last", &[9; 10_000]);
        assert!(cache.entries().iter().map(|entry| entry.bytes).sum::<u64>() <= 40_000);
        fs::remove_dir_all(&folder).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn links_among_entries_are_not_written_through() {
        let folder = folder("links");
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("other"), b"of somebody").unwrap();
        let cache = DiskCache::new(folder.clone(), 1000);
        std::os::unix::fs::symlink("other", cache.path("a")).unwrap();
        let before = fs::metadata(folder.join("other")).unwrap().modified().unwrap();
        assert_eq!(cache.get("a"), None);
        cache.put("a", &[1; 10]);
        assert_eq!(cache.get("a"), Some(vec![1; 10]));
        assert_eq!(fs::read(folder.join("other")).unwrap(), b"of somebody");
        assert_eq!(fs::metadata(folder.join("other")).unwrap().modified().unwrap(), before);
        assert!(!cache.path("a").is_symlink());
        fs::remove_dir_all(&folder).unwrap();
    }

    /// Neither waits for somebody who writes or reads: a test that hangs has failed.
    #[cfg(unix)]
    #[test]
    fn pipes_among_entries_are_neither_read_nor_written() {
        let folder = folder("pipes");
        fs::create_dir_all(&folder).unwrap();
        let cache = DiskCache::new(folder.clone(), 1000);
        let made = std::process::Command::new("mkfifo").arg(cache.path("a")).status();
        assert!(made.is_ok_and(|status| status.success()), "mkfifo");
        assert_eq!(cache.get("a"), None);
        cache.put("b", &[2; 10]);
        assert!(fs::symlink_metadata(cache.path("a")).is_ok(), "room is made among files alone");
        cache.put("a", &[1; 10]);
        assert_eq!((cache.get("a"), cache.get("b")), (Some(vec![1; 10]), Some(vec![2; 10])));
        assert!(fs::symlink_metadata(cache.path("a")).is_ok_and(|entry| entry.is_file()));
        fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_place_that_cannot_be_written_is_no_cache() {
        let file = folder("file");
        fs::write(&file, b"in the way").unwrap();
        let cache = DiskCache::new(file.join("below"), 1000);
        cache.put("a", &[1]);
        assert_eq!(cache.get("a"), None);
        fs::remove_file(&file).unwrap();
    }
}
