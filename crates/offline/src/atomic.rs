//! Files that appear whole or not at all: written beside their place, then renamed. A link is followed, and a device or
//! a pipe is written to as it is: to rename a file over it would take it away.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// The temporary files that exist now, for [`remove_unfinished`].
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Why an output could not be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The disk or the quota is full.
    #[error("no space left to write {path}", path = .0.display())]
    DiskFull(PathBuf),
    /// The place may not be written.
    #[error("no permission to write {path}", path = .0.display())]
    Denied(PathBuf),
    /// The folder cannot be made or is no folder.
    #[error("cannot make the folder {path}: {source}", path = .path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// Anything else.
    #[error("cannot write {path}: {source}", path = .path.display())]
    Other {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
}

impl WriteError {
    fn new(path: &Path, source: io::Error) -> Self {
        match source.kind() {
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => Self::DiskFull(path.to_owned()),
            io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => Self::Denied(path.to_owned()),
            _ => Self::Other { path: path.to_owned(), source },
        }
    }
}

/// A file on its way: dropped without [`AtomicFile::commit`], it leaves nothing.
#[derive(Debug)]
pub struct AtomicFile {
    target: PathBuf,
    /// Where the bytes go until they are whole; none where they go to a device at once.
    temporary: Option<PathBuf>,
    file: Option<File>,
}

impl AtomicFile {
    /// Opens a temporary file in the folder of `target`, which is made if it is missing; or `target`, if that is a
    /// device or a pipe.
    ///
    /// # Errors
    /// If the folder cannot be made, or the file cannot be opened.
    pub fn create(target: &Path) -> Result<Self, WriteError> {
        let folder = match target.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        fs::create_dir_all(folder).map_err(|source| WriteError::Folder { path: folder.to_owned(), source })?;
        if target.is_dir() {
            let source = io::Error::new(io::ErrorKind::IsADirectory, "it is a folder");
            return Err(WriteError::new(target, source));
        }
        let failed = |source| WriteError::new(target, source);
        if fs::metadata(target).is_ok_and(|metadata| !metadata.is_file()) {
            let file = OpenOptions::new().write(true).open(target).map_err(failed)?;
            return Ok(Self { target: target.to_owned(), temporary: None, file: Some(file) });
        }
        // Only a link to something that is there can be followed; another is replaced.
        let is_link = target.is_symlink();
        let target = fs::canonicalize(target).ok().filter(|_| is_link).unwrap_or_else(|| target.to_owned());
        let name = target.file_name().unwrap_or_default().to_string_lossy();
        let temporary = target.with_file_name(format!(".{name}.{}.partial", std::process::id()));
        let file = OpenOptions::new().write(true).create(true).truncate(true).open(&temporary).map_err(failed)?;
        UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner).push(temporary.clone());
        Ok(Self { target, temporary: Some(temporary), file: Some(file) })
    }

    /// Appends `bytes`.
    ///
    /// # Errors
    /// If the disk is full or fails.
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), WriteError> {
        let Some(file) = &mut self.file else { return Ok(()) };
        file.write_all(bytes).map_err(|source| WriteError::new(&self.target, source))
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// If the bytes do not reach the disk or the file cannot be renamed.
    pub fn commit(mut self) -> Result<(), WriteError> {
        // What goes to a device has arrived; many cannot be synchronised.
        let (Some(temporary), Some(file)) = (&self.temporary, self.file.take()) else { return Ok(()) };
        let failed = |source| WriteError::new(&self.target, source);
        file.sync_all().map_err(failed)?;
        drop(file);
        fs::rename(temporary, &self.target).map_err(failed)
    }
}

impl AtomicFile {
    /// Whether one can go back in it: not where it is a device or a pipe.
    pub fn is_seekable(&self) -> bool {
        self.temporary.is_some()
    }

    /// What an error of [`io::Write`] or [`io::Seek`] means.
    pub fn failed(&self, source: io::Error) -> WriteError {
        WriteError::new(&self.target, source)
    }

    fn opened(&mut self) -> io::Result<&mut File> {
        self.file.as_mut().ok_or_else(|| io::Error::from(io::ErrorKind::NotConnected))
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.opened()?.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.opened()?.flush()
    }
}

impl io::Seek for AtomicFile {
    fn seek(&mut self, to: io::SeekFrom) -> io::Result<u64> {
        self.opened()?.seek(to)
    }
}

impl Drop for AtomicFile {
    fn drop(&mut self) {
        self.file = None;
        let Some(temporary) = &self.temporary else { return };
        // After a successful rename the temporary file is gone, and this fails as it should.
        let _ = fs::remove_file(temporary);
        UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner).retain(|path| path != temporary);
    }
}

/// Removes the temporary files of this process: for a program that is about to exit at once.
pub fn remove_unfinished() {
    for path in UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner).drain(..) {
        let _ = fs::remove_file(path);
    }
}

/// Writes a whole file.
///
/// # Errors
/// As [`AtomicFile`].
pub fn write_file(target: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    let mut file = AtomicFile::create(target)?;
    file.write(bytes)?;
    file.commit()
}

/// Writes `bytes` to standard output.
///
/// # Errors
/// If the other end is closed or full.
pub fn write_stdout(bytes: &[u8]) -> Result<(), WriteError> {
    let mut out = io::stdout().lock();
    out.write_all(bytes)
        .and_then(|()| out.flush())
        .map_err(|source| WriteError::new(Path::new("standard output"), source))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("manypass-atomic-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        folder
    }

    #[test]
    fn a_file_appears_whole_and_makes_its_folder() {
        let folder = folder("whole");
        let target = folder.join("deep/a.png");
        write_file(&target, b"abc").expect("written");
        assert_eq!(fs::read(&target).expect("read"), b"abc");
        assert_eq!(fs::read_dir(folder.join("deep")).expect("listed").count(), 1);
        let _ = fs::remove_dir_all(folder);
    }

    #[test]
    fn a_dropped_file_leaves_the_old_one_and_nothing_else() {
        let folder = folder("dropped");
        let target = folder.join("a.png");
        write_file(&target, b"old").expect("written");
        let mut file = AtomicFile::create(&target).expect("created");
        file.write(b"half").expect("written");
        assert_eq!(fs::read_dir(&folder).expect("listed").count(), 2);
        drop(file);
        assert_eq!(fs::read(&target).expect("read"), b"old");
        assert_eq!(fs::read_dir(&folder).expect("listed").count(), 1);
        let _ = fs::remove_dir_all(folder);
    }

    #[test]
    fn a_file_as_folder_and_a_folder_as_file_are_refused() {
        let folder = folder("refused");
        write_file(&folder.join("file"), b"").expect("written");
        assert!(matches!(write_file(&folder.join("file/a.png"), b""), Err(WriteError::Folder { .. })));
        assert!(write_file(&folder, b"").is_err());
        let _ = fs::remove_dir_all(folder);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn links_are_followed_and_devices_stay() {
        use std::os::unix::fs::{FileTypeExt, symlink};
        let folder = folder("links");
        write_file(&folder.join("real/a.png"), b"old").expect("written");
        symlink(folder.join("real/a.png"), folder.join("link.png")).expect("linked");
        write_file(&folder.join("link.png"), b"new").expect("written");
        assert_eq!(fs::read(folder.join("real/a.png")).expect("read"), b"new");
        assert!(folder.join("link.png").is_symlink());
        symlink("/dev/null", folder.join("null.png")).expect("linked");
        write_file(&folder.join("null.png"), b"gone").expect("written");
        assert!(fs::metadata(folder.join("null.png")).expect("there").file_type().is_char_device());
        symlink("/dev/full", folder.join("full.png")).expect("linked");
        assert!(matches!(write_file(&folder.join("full.png"), b"more"), Err(WriteError::DiskFull(_))));
        let _ = fs::remove_dir_all(folder);
    }

    #[test]
    fn a_full_disk_is_named() {
        let error = WriteError::new(Path::new("a.png"), io::Error::from(io::ErrorKind::StorageFull));
        assert_eq!(error.to_string(), "no space left to write a.png");
    }
}
