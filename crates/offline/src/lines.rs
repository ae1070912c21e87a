//! Files that grow by whole lines, so that whoever reads one, even while it grows or after its writer was killed, finds
//! every line that is done.

use crate::atomic::{WriteError, is_in_place};
use std::fs::{self, File, OpenOptions};
use std::io::{Seek, SeekFrom, Write};
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
        if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
            fs::create_dir_all(folder).map_err(|source| WriteError::Folder { path: folder.to_owned(), source })?;
        }
        let is_in_place = is_in_place(path);
        let mut options = OpenOptions::new();
        let options = if is_in_place { options.append(true) } else { options.write(true).create(true).truncate(true) };
        let file = options.open(path).map_err(|source| WriteError::new(path, source))?;
        Ok(Self { path: path.to_owned(), file, length_bytes: (!is_in_place).then_some(0) })
    }

    /// Appends `line` and a line break. Where that fails, no part of the line stays.
    ///
    /// # Errors
    /// If the disk is full or fails.
    pub fn append(&mut self, line: &str) -> Result<(), WriteError> {
        let bytes = format!("{line}\n").into_bytes();
        let written = self.file.write_all(&bytes);
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
            assert_eq!(fs::read_to_string(&path).expect("read"), "{}\n");
            file.append("[]").expect("written");
            assert_eq!(fs::read_to_string(&path).expect("read"), "{}\n[]\n");
        }
        assert!(LineFile::create(&folder).is_err());
        let _ = fs::remove_dir_all(folder);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_device_is_named() {
        let mut file = LineFile::create(Path::new("/dev/full")).expect("opened");
        assert!(matches!(file.append("{}"), Err(WriteError::DiskFull(_))));
    }
}
