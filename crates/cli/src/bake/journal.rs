//! What an interrupted bake leaves behind for the next one: OUT.glb.part.
//!
//! A line of text says of which bake it is. Records follow: a round, a block and a length, a hash of the bytes, and the
//! bytes. One that is not whole, because the machine went down, ends the file.

use crate::failure::say;
use manypass_bake::Keeper;
use manypass_scene::input_file;
use std::collections::HashMap;
use std::fs::{self, File, OpenOptions};
use std::hash::{DefaultHasher, Hasher as _};
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// The bytes before those of a record: three numbers and a hash.
const HEAD: usize = 3 * 4 + 8;

/// No block has more bytes.
const BLOCK_BYTES_MAX: u32 = 1 << 20;

/// Where the bytes of the block of a round lie, and how many they are.
type BlockIndex = HashMap<(u32, u32), (u64, usize)>;

/// What was kept, and what will be.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    known: BlockIndex,
    /// Closed where the disk takes no more.
    file: Mutex<Option<File>>,
    quiet: bool,
}

fn hash_of(bytes: &[u8]) -> u64 {
    let mut hasher = DefaultHasher::new();
    hasher.write(bytes);
    hasher.finish()
}

/// How every file begins.
const START: &str = "manypass bake ";

fn head(key: u64) -> String {
    format!("{START}{key:016x}\n")
}

/// The place of the journal of an output.
fn path_of(output: &Path) -> PathBuf {
    let mut name = output.file_name().unwrap_or_default().to_owned();
    name.push(".part");
    output.with_file_name(name)
}

/// The first bytes of a file, if it has any.
fn first_bytes(path: &Path, count: usize) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    input_file::open(path).ok()?.take(count as u64).read_to_end(&mut bytes).ok()?;
    (!bytes.is_empty()).then_some(bytes)
}

/// The records of a file that begins with `head`, and where the last whole one ends.
fn records(file: &mut File, head: &str) -> io::Result<(BlockIndex, u64)> {
    let mut known = HashMap::new();
    let mut found = vec![0; head.len()];
    let (mut reader, mut at) = (io::BufReader::new(file), head.len() as u64);
    if reader.read_exact(&mut found).is_err() || found != head.as_bytes() {
        return Ok((known, 0));
    }
    loop {
        let mut start = [0; HEAD];
        let mut bytes = Vec::new();
        if reader.read_exact(&mut start).is_err() {
            break;
        }
        let number = |at: usize| start[4 * at..4 * at + 4].try_into().map_or(0, u32::from_le_bytes);
        let (round, block, length) = (number(0), number(1), number(2));
        let hash = start[12..].try_into().map_or(0, u64::from_le_bytes);
        if length > BLOCK_BYTES_MAX {
            break;
        }
        bytes.resize(length as usize, 0);
        if reader.read_exact(&mut bytes).is_err() || hash_of(&bytes) != hash {
            break;
        }
        known.insert((round, block), (at + HEAD as u64, bytes.len()));
        at += (HEAD + bytes.len()) as u64;
    }
    Ok((known, at))
}

impl Journal {
    /// That of an output, for the bake of a key. Where it cannot be written there is none, which is said.
    pub fn open(output: &Path, key: u64, quiet: bool) -> Self {
        let path = path_of(output);
        // Of a file that is there already.
        let is_of_this = first_bytes(&path, head(key).len()).map(|bytes| bytes == head(key).as_bytes());
        let is_foreign = first_bytes(&path, START.len()).is_some_and(|bytes| bytes != START.as_bytes());
        let begun =
            if is_foreign { Err(io::Error::other("it is of another program")) } else { Self::begin(&path, key) };
        let (known, file) = match begun {
            Ok((known, file)) => (known, Some(file)),
            Err(error) => {
                if !quiet {
                    say(format_args!("note: {}: {error}; an interrupted bake will begin anew", path.display()));
                }
                (HashMap::new(), None)
            }
        };
        if let (Some(is_of_this), false) = (is_of_this, quiet) {
            match known.len() {
                0 if is_of_this => {}
                0 => say(format_args!("note: {} is of another scene or other flags; it begins anew", path.display())),
                count => say(format_args!("note: goes on from {}: {count} blocks are there", path.display())),
            }
        }
        Self { path, known, file: Mutex::new(file), quiet }
    }

    fn begin(path: &Path, key: u64) -> io::Result<(BlockIndex, File)> {
        // A device or a pipe keeps nothing, and would be removed when the bake is done.
        if fs::symlink_metadata(path).is_ok_and(|there| !there.is_file()) {
            return Err(io::Error::other("it is not a regular file"));
        }
        let mut file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path)?;
        let (known, end) = records(&mut file, &head(key))?;
        file.set_len(end)?;
        file.seek(SeekFrom::End(0))?;
        if end == 0 {
            // What a full disk takes of the line is no journal.
            file.write_all(head(key).as_bytes()).inspect_err(|_| drop(fs::remove_file(path)))?;
        }
        Ok((known, file))
    }

    /// Whether nothing was kept: then it is removed.
    pub fn remove_if_empty(self) -> bool {
        let is_open = self.file.lock().unwrap_or_else(PoisonError::into_inner).is_some();
        let is_empty = !is_open || fs::metadata(&self.path).is_ok_and(|file| file.len() <= head(0).len() as u64);
        if is_empty {
            self.remove();
        }
        is_empty
    }

    /// Where the output could not be written: what is whole stays for the next try, which is said; what the disk cut off goes.
    pub fn leave(self) {
        let is_whole = self.file.lock().unwrap_or_else(PoisonError::into_inner).is_some();
        if !is_whole {
            self.remove();
        } else if !self.quiet {
            let path = self.path.display();
            say(format_args!("note: {path} has what was computed; the same command goes on from there"));
        }
    }

    /// Removes it: what it is for is done.
    pub fn remove(self) {
        let file = self.file.into_inner().unwrap_or_else(PoisonError::into_inner);
        if file.is_some() || first_bytes(&self.path, START.len()).is_some_and(|bytes| bytes == START.as_bytes()) {
            drop(file);
            let _ = fs::remove_file(&self.path);
        }
    }
}

impl Keeper for Journal {
    fn get(&self, round: u32, block: u32) -> Option<Vec<u8>> {
        let (at, length) = *self.known.get(&(round, block))?;
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let file = file.as_mut()?;
        let mut bytes = vec![0; length];
        file.seek(SeekFrom::Start(at)).ok()?;
        let read = file.read_exact(&mut bytes);
        file.seek(SeekFrom::End(0)).ok()?;
        read.ok().map(|()| bytes)
    }

    fn put(&self, round: u32, block: u32, bytes: &[u8]) {
        let numbers = [round, block, bytes.len() as u32].map(u32::to_le_bytes).concat();
        let record = [&numbers, &hash_of(bytes).to_le_bytes()[..], bytes].concat();
        let mut slot = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(file) = slot.as_mut() else { return };
        if let Err(error) = file.write_all(&record) {
            if !self.quiet {
                let path = self.path.display();
                say(format_args!("note: {path}: {error}; the bake goes on, and will begin anew if it is interrupted"));
            }
            // It is cut off, and the output needs its room.
            *slot = None;
            let _ = fs::remove_file(&self.path);
        }
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use super::*;

    #[test]
    fn a_full_disk_leaves_no_journal_behind() {
        let folder = std::env::temp_dir().join(format!("manypass-journal-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        let output = folder.join("a.glb");
        let journal = Journal::open(&output, 7, true);
        journal.put(0, 0, &[1; 100]);
        drop(journal);
        // What was whole is there for the next bake.
        let journal = Journal::open(&output, 7, true);
        assert_eq!(journal.get(0, 0), Some(vec![1; 100]));
        // This device takes no byte, as a full disk.
        *journal.file.lock().unwrap() = Some(OpenOptions::new().write(true).open("/dev/full").unwrap());
        journal.put(0, 1, &[2; 100]);
        assert!(!path_of(&output).exists(), "it takes the room of the output as long as the bake lasts");
        // The bake goes on without one.
        journal.put(0, 2, &[3; 100]);
        assert_eq!(journal.get(0, 0), None);
        assert!(journal.remove_if_empty() && fs::read_dir(&folder).unwrap().next().is_none());
        fs::remove_dir_all(&folder).unwrap();
    }
}
