//! Files that grow by whole lines, so that whoever reads one, even while it grows or after its writer was killed, finds
//! every line that is done.

use crate::atomic::{WaitGuard, WriteError, is_in_place, make_folder_of};
use std::fs::{File, OpenOptions};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// A file that grows by whole lines.
#[derive(Debug)]
pub struct LineFile {
    path: PathBuf,
    file: File,
    /// Its length up to the last whole line; none where there is nothing to cut off, as in a pipe.
    length_bytes: Option<u64>,
}

impl LineFile {
    /// Opens `path`, empties it, and makes its folder if that is missing. Links are followed; devices, pipes and open
    /// files of the process are written to as they are.
    ///
    /// # Errors
    /// If the folder cannot be made, or the file cannot be opened.
    pub fn create(path: &Path) -> Result<Self, WriteError> {
        Self::open_as(path, false)
    }

    /// Opens `path` as [`Self::create`] does, but keeps the lines that are there, and goes on after them. A last line
    /// without an end gets one.
    ///
    /// # Errors
    /// As [`Self::create`].
    pub fn open(path: &Path) -> Result<Self, WriteError> {
        Self::open_as(path, true)
    }

    fn open_as(path: &Path, keeps_lines: bool) -> Result<Self, WriteError> {
        make_folder_of(path)?;
        let failed = |source| WriteError::new(path, source);
        if is_in_place(path) {
            let _waiting = WaitGuard::begin();
            let file = OpenOptions::new().append(true).open(path).map_err(failed)?;
            return Ok(Self { path: path.to_owned(), file, length_bytes: None });
        }
        let mut options = OpenOptions::new();
        let mut file =
            options.read(keeps_lines).write(true).create(true).truncate(!keeps_lines).open(path).map_err(failed)?;
        let mut length_bytes = file.seek(SeekFrom::End(0)).map_err(failed)?;
        if length_bytes > 0 {
            let mut last = [0];
            file.seek(SeekFrom::End(-1)).and_then(|_| file.read_exact(&mut last)).map_err(failed)?;
            if last != *b"\n" {
                file.write_all(b"\n").map_err(failed)?;
                length_bytes += 1;
            }
        }
        Ok(Self { path: path.to_owned(), file, length_bytes: Some(length_bytes) })
    }

    /// Appends `line` and a line break. Where that fails, no part of the line stays.
    ///
    /// # Errors
    /// If the disk is full or fails.
    pub fn append(&mut self, line: &str) -> Result<(), WriteError> {
        let bytes = format!("{line}\n").into_bytes();
        let waiting = self.length_bytes.is_none().then(WaitGuard::begin);
        let written = self.file.write_all(&bytes);
        drop(waiting);
        if let Some(length_bytes) = &mut self.length_bytes {
            match &written {
                Ok(()) => *length_bytes += bytes.len() as u64,
                Err(_) => {
                    // The first error is the one to report.
                    let _ = self.file.set_len(*length_bytes);
                    let _ = self.file.seek(SeekFrom::Start(*length_bytes));
                }
            }
        }
        written.map_err(|source| WriteError::new(&self.path, source))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_is_there_at_once_and_old_ones_are_gone() {
        let folder = std::env::temp_dir().join(format!("manypass-lines-{}", std::process::id()));
        let path = folder.join("deep/r.jsonl");
        for _ in 0..2 {
            let mut file = LineFile::create(&path).expect("created");
            file.append("{}").expect("written");
            assert_eq!(std::fs::read_to_string(&path).expect("read"), "{}\n");
            file.append("[]").expect("written");
            assert_eq!(std::fs::read_to_string(&path).expect("read"), "{}\n[]\n");
        }
        std::fs::write(&path, "{}\n[").expect("written");
        LineFile::open(&path).expect("opened").append("2").expect("written");
        assert_eq!(std::fs::read_to_string(&path).expect("read"), "{}\n[\n2\n");
        assert!(LineFile::create(&folder).is_err());
        let _ = std::fs::remove_dir_all(folder);
    }

    #[cfg(unix)]
    #[test]
    fn opening_a_pipe_is_waiting_for_its_reader() {
        let pipe = std::env::temp_dir().join(format!("manypass-lines-pipe-{}", std::process::id()));
        let _ = std::fs::remove_file(&pipe);
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().is_ok_and(|status| status.success()));
        let path = pipe.clone();
        let writer = std::thread::spawn(move || LineFile::create(&path).and_then(|mut file| file.append("{}")));
        while !crate::atomic::is_waiting() && !writer.is_finished() {
            std::thread::yield_now();
        }
        assert!(!writer.is_finished());
        assert_eq!(std::fs::read_to_string(&pipe).expect("read"), "{}\n");
        writer.join().expect("no panic").expect("written");
        let _ = std::fs::remove_file(pipe);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_device_is_named() {
        let mut file = LineFile::create(Path::new("/dev/full")).expect("opened");
        assert!(matches!(file.append("{}"), Err(WriteError::DiskFull(_))));
    }
}
