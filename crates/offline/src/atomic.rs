//! Files that appear whole or not at all: written beside their place, then renamed. A link is followed. A device, a
//! pipe or an open file of the process is written to as it is: to rename a file over it would take it away.

use std::fs::{self, File, OpenOptions};
use std::hash::{BuildHasher, Hasher, RandomState};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// The temporary files that exist now, for [`remove_unfinished`].
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// How many threads are at this moment held up, or may be, by the other end of a device or a pipe.
static WAITING: AtomicUsize = AtomicUsize::new(0);

/// Why an output could not be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The disk or the quota is full.
    #[error("no space left to write {path}", path = .0.display())]
    DiskFull(PathBuf),
    /// The place may not be written.
    #[error("no permission to write {path}", path = .0.display())]
    Denied(PathBuf),
    /// The process or the file system allows no file as large.
    #[error("{path} is larger than the limit of this process or disk for a file (see `ulimit -f`)", path = .0.display())]
    TooLarge(PathBuf),
    /// Nobody reads what is written any more.
    #[error("cannot write {path}: its reader has closed it", path = .0.display())]
    Closed(PathBuf),
    /// The flag of [`AtomicFile::heeding`] was raised.
    #[error("interrupted")]
    Stopped,
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
    /// What the system's error about `path` means.
    pub fn new(path: &Path, source: io::Error) -> Self {
        if source.get_ref().is_some_and(|inner| inner.is::<Stop>()) {
            return Self::Stopped;
        }
        match source.kind() {
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => Self::DiskFull(path.to_owned()),
            io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => Self::Denied(path.to_owned()),
            io::ErrorKind::FileTooLarge => Self::TooLarge(path.to_owned()),
            io::ErrorKind::BrokenPipe => Self::Closed(path.to_owned()),
            _ => Self::Other { path: path.to_owned(), source },
        }
    }
}

/// Carries [`WriteError::Stopped`] through the writers of others.
#[derive(Debug, thiserror::Error)]
#[error("interrupted")]
struct Stop;

/// While it lives, [`is_waiting`] is true: for whoever reads or writes what another program holds the other end of.
#[derive(Debug)]
pub struct WaitGuard(());

impl WaitGuard {
    /// From now on the other end may hold this thread up.
    pub fn begin() -> Self {
        WAITING.fetch_add(1, Ordering::SeqCst);
        Self(())
    }
}

impl Drop for WaitGuard {
    fn drop(&mut self) {
        WAITING.fetch_sub(1, Ordering::SeqCst);
    }
}

/// Whether a device or a pipe may be holding up this process now, so that it would not heed a flag before its other end
/// moves.
pub fn is_waiting() -> bool {
    WAITING.load(Ordering::SeqCst) > 0
}

/// Whether `path` is written to as it is: a device, a pipe, a socket, or an open file of this process (`/dev/fd/3`).
pub fn is_in_place(path: &Path) -> bool {
    let metadata = fs::metadata(path);
    let is_descriptor = cfg!(unix)
        && ([Path::new("/dev/stdout"), Path::new("/dev/stderr")].contains(&path)
            || path.parent().is_some_and(|folder| folder == "/dev/fd" || folder == "/proc/self/fd"));
    metadata.is_ok_and(|metadata| !metadata.is_dir() && (is_descriptor || !metadata.is_file()))
}

/// Makes the folder that holds `target`, and those that hold it, where they are missing.
///
/// # Errors
/// If one cannot be made; a file in the place of one is named.
pub(crate) fn make_folder_of(target: &Path) -> Result<(), WriteError> {
    let Some(folder) = target.parent().filter(|folder| !folder.as_os_str().is_empty()) else { return Ok(()) };
    fs::create_dir_all(folder).map_err(|source| {
        let file = folder.ancestors().find(|path| path.is_file());
        let is_file = |file: &Path| {
            io::Error::new(io::ErrorKind::NotADirectory, format!("{} is a file, not a folder", file.display()))
        };
        WriteError::Folder { path: folder.to_owned(), source: file.map_or(source, is_file) }
    })
}

/// A file on its way: dropped without [`AtomicFile::commit`], it leaves nothing.
#[derive(Debug)]
pub struct AtomicFile {
    target: PathBuf,
    /// Where the bytes go until they are whole; none where they go to a device at once.
    temporary: Option<PathBuf>,
    file: Option<File>,
    stop: Option<&'static AtomicBool>,
    is_synced: bool,
}

impl AtomicFile {
    /// Opens a temporary file in the folder of `target`, which is made if it is missing; or `target`, if
    /// [`is_in_place`] says so.
    ///
    /// # Errors
    /// If the folder cannot be made, or the file cannot be opened.
    pub fn create(target: &Path) -> Result<Self, WriteError> {
        make_folder_of(target)?;
        if target.is_dir() {
            let source = io::Error::new(io::ErrorKind::IsADirectory, "it is a folder");
            return Err(WriteError::new(target, source));
        }
        let failed = |source| WriteError::new(target, source);
        if is_in_place(target) {
            let _waiting = WaitGuard::begin();
            // What stands in an open file already is not this file's to overwrite.
            let file = OpenOptions::new().append(true).open(target).map_err(failed)?;
            return Ok(Self {
                target: target.to_owned(),
                temporary: None,
                file: Some(file),
                stop: None,
                is_synced: true,
            });
        }
        // Only a link to something that is there can be followed; another is replaced.
        let is_link = target.is_symlink();
        let target = fs::canonicalize(target).ok().filter(|_| is_link).unwrap_or_else(|| target.to_owned());
        let (temporary, file) = create_temporary(&target).map_err(failed)?;
        Ok(Self { target, temporary: Some(temporary), file: Some(file), stop: None, is_synced: true })
    }

    /// The same file; once `stop` is raised, it can neither be written nor put in its place.
    #[must_use]
    pub fn heeding(mut self, stop: &'static AtomicBool) -> Self {
        self.stop = Some(stop);
        self
    }

    /// The same file, which is put in its place before its bytes have reached the disk: for what its reader checks.
    /// After a power cut a part of it may stand there.
    #[must_use]
    pub fn unsynced(mut self) -> Self {
        self.is_synced = false;
        self
    }

    /// Whether one can go back in it: not where it is a device or a pipe.
    pub fn is_seekable(&self) -> bool {
        self.temporary.is_some()
    }

    /// What an error of [`io::Write`] or [`io::Seek`] means.
    pub fn failed(&self, source: io::Error) -> WriteError {
        WriteError::new(&self.target, source)
    }

    /// Appends `bytes`.
    ///
    /// # Errors
    /// If the disk is full or fails.
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), WriteError> {
        self.write_all(bytes).map_err(|source| WriteError::new(&self.target, source))
    }

    /// Puts the file in its place.
    ///
    /// # Errors
    /// If the bytes do not reach the disk or the file cannot be renamed.
    pub fn commit(mut self) -> Result<(), WriteError> {
        let failed = |source| WriteError::new(&self.target, source);
        check(self.stop).map_err(failed)?;
        // What goes to a device has arrived; many cannot be synchronised.
        let (Some(temporary), Some(file)) = (&self.temporary, self.file.take()) else { return Ok(()) };
        if self.is_synced {
            file.sync_all().map_err(failed)?;
        }
        drop(file);
        check(self.stop).map_err(failed)?;
        // A device or a pipe that was made here meanwhile stays.
        if fs::symlink_metadata(&self.target).is_ok_and(|there| !there.is_file() && !there.is_symlink()) {
            return Err(failed(io::Error::other("a device or a pipe is there now")));
        }
        fs::rename(temporary, &self.target).map_err(failed)
    }

    /// The file, unless the flag was raised.
    fn open(&mut self) -> io::Result<&mut File> {
        check(self.stop)?;
        self.file.as_mut().ok_or_else(|| io::Error::other("it is finished"))
    }
}

/// Encoders write through this.
impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let _waiting = self.temporary.is_none().then(WaitGuard::begin);
        self.open()?.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.open()?.flush()
    }
}

impl Seek for AtomicFile {
    fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
        self.open()?.seek(position)
    }
}

fn check(stop: Option<&AtomicBool>) -> io::Result<()> {
    if stop.is_some_and(|stop| stop.load(Ordering::SeqCst)) { Err(io::Error::other(Stop)) } else { Ok(()) }
}

/// Makes a file beside `target` whose name nobody can know before and which is short, whatever the target's is. What is
/// there already, be it a link, is neither followed nor used.
fn create_temporary(target: &Path) -> io::Result<(PathBuf, File)> {
    let mut attempts_left = 100;
    loop {
        // Its keys come from the system's source of randomness.
        let random = RandomState::new().build_hasher().finish();
        let temporary = target.with_file_name(format!(".manypass-{random:016x}.partial"));
        // Held meanwhile, so that no file is missing from the list when the process ends.
        let mut unfinished = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
        match OpenOptions::new().write(true).create_new(true).open(&temporary) {
            Ok(file) => {
                unfinished.push(temporary.clone());
                return Ok((temporary, file));
            }
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists && attempts_left > 0 => attempts_left -= 1,
            Err(error) => return Err(error),
        }
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
    let _waiting = WaitGuard::begin();
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
        for name in ["file/a.png", "file/deep/a.png"] {
            let error = write_file(&folder.join(name), b"").expect_err(name);
            let expected = format!("{} is a file, not a folder", folder.join("file").display());
            assert!(matches!(error, WriteError::Folder { .. }) && error.to_string().ends_with(&expected), "{error}");
        }
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

    #[cfg(unix)]
    #[test]
    fn temporary_names_are_short_random_and_never_those_of_links() {
        let folder = folder("temporary");
        // As long as a name can be.
        let target = folder.join(format!("{}.png", "n".repeat(251)));
        let first = {
            let mut file = AtomicFile::create(&target).expect("created");
            file.write(b"abc").expect("written");
            let temporary = file.temporary.clone().expect("a temporary file");
            file.commit().expect("committed");
            temporary
        };
        assert_eq!(fs::read(&target).expect("read"), b"abc");
        let second = AtomicFile::create(&target).expect("created").temporary.clone().expect("a temporary file");
        assert_ne!(first, second);
        assert!(second.file_name().is_some_and(|name| name.len() < 64));
        let _ = fs::remove_dir_all(folder);
    }

    #[test]
    fn a_raised_flag_ends_writing_and_leaves_nothing() {
        static STOP: AtomicBool = AtomicBool::new(false);
        let folder = folder("flag");
        let open = || AtomicFile::create(&folder.join("a.png")).expect("created").heeding(&STOP);
        let mut file = open();
        file.write(b"half").expect("written");
        let other = open();
        STOP.store(true, Ordering::SeqCst);
        assert!(matches!(file.write(b"more"), Err(WriteError::Stopped)));
        assert!(matches!(other.commit(), Err(WriteError::Stopped)));
        drop(file);
        assert_eq!(fs::read_dir(&folder).expect("listed").count(), 0);
        STOP.store(false, Ordering::SeqCst);
        open().commit().expect("committed");
        let _ = fs::remove_dir_all(folder);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn open_files_are_written_to_and_not_replaced() {
        use std::os::fd::AsRawFd;
        let folder = folder("descriptor");
        write_file(&folder.join("log"), b"before,").expect("written");
        let open = OpenOptions::new().append(true).open(folder.join("log")).expect("opened");
        let path = PathBuf::from(format!("/dev/fd/{}", open.as_raw_fd()));
        assert!(is_in_place(&path) && is_in_place(Path::new("/dev/null")) && !is_in_place(&folder.join("log")));
        write_file(&path, b"after").expect("written");
        assert_eq!(fs::read(folder.join("log")).expect("read"), b"before,after");
        let _ = fs::remove_dir_all(folder);
    }

    #[test]
    fn errors_of_the_system_are_named() {
        let said = |kind| WriteError::new(Path::new("a.png"), io::Error::from(kind)).to_string();
        assert!(said(io::ErrorKind::FileTooLarge).contains("ulimit -f"));
        assert!(said(io::ErrorKind::BrokenPipe).contains("closed"));
    }
}
