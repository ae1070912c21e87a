//! Input files: the one way in which files that a user or another file names are opened.
//!
//! A regular file is read up to a limit. A device or a named pipe can have no end or never begin, and is refused. The pipe
//! behind `/dev/fd/63`, which shells put in place of `<(…)`, is read up to the limit, as long as something comes.

use std::fs::{File, Metadata};
use std::io::{self, Read};
use std::path::Path;
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::Duration;

/// So long a pipe may be silent.
const SILENCE_MAX: Duration = Duration::from_secs(30);

/// Why an input cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum InputError {
    /// What the system says.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// A folder.
    #[error("it is a folder")]
    Folder,
    /// A device, a named pipe or a socket.
    #[error("it is not a regular file, but a device or a named pipe")]
    NotRegular,
    /// More bytes than are read.
    #[error("it is larger than {mib} MiB", mib = .0 >> 20)]
    TooLarge(u64),
    /// Bytes that are no text.
    #[error("it is not UTF-8 text")]
    NoText,
    /// Nothing came out of a pipe.
    #[error("nothing came out of the pipe for {} s", SILENCE_MAX.as_secs())]
    Silent,
    /// A link that leads to another kind of file, which is not shown in errors.
    #[error("it is a link to a file that does not end in .{0}")]
    OtherEnding(String),
}

/// Opens a regular file.
///
/// # Errors
/// It is none, or cannot be opened.
pub fn open(path: &Path) -> Result<File, InputError> {
    // To open a named pipe would wait for whoever writes to it.
    check_kind(&std::fs::metadata(path)?)?;
    let file = File::open(path)?;
    // It may be another by now.
    check_kind(&file.metadata()?)?;
    Ok(file)
}

fn check_kind(metadata: &Metadata) -> Result<(), InputError> {
    match metadata {
        metadata if metadata.is_file() => Ok(()),
        metadata if metadata.is_dir() => Err(InputError::Folder),
        _ => Err(InputError::NotRegular),
    }
}

/// Whether `path` is a pipe that this process has open already: what it holds can be read once.
pub fn is_open_pipe(path: &Path) -> bool {
    let is_descriptor =
        path.parent().is_some_and(|folder| folder == Path::new("/dev/fd") || folder == Path::new("/proc/self/fd"));
    cfg!(unix) && is_descriptor && is_pipe(path)
}

#[cfg(unix)]
fn is_pipe(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt as _;
    std::fs::metadata(path).is_ok_and(|metadata| metadata.file_type().is_fifo())
}

#[cfg(not(unix))]
fn is_pipe(_: &Path) -> bool {
    false
}

/// The bytes of a file, `most_bytes` at most.
///
/// # Errors
/// It is no regular file and no pipe that is open already, has more bytes, or cannot be read.
pub fn read(path: &Path, most_bytes: u64) -> Result<Vec<u8>, InputError> {
    if is_open_pipe(path) {
        return read_pipe(File::open(path)?, most_bytes, SILENCE_MAX);
    }
    let file = open(path)?;
    let bytes = file.metadata()?.len();
    if bytes > most_bytes {
        return Err(InputError::TooLarge(most_bytes));
    }
    let mut read = Vec::with_capacity(usize::try_from(bytes).unwrap_or(0));
    // It may grow meanwhile, and files of the system say that they have no bytes.
    file.take(most_bytes + 1).read_to_end(&mut read)?;
    if read.len() as u64 > most_bytes { Err(InputError::TooLarge(most_bytes)) } else { Ok(read) }
}

/// The text of a file, `most_bytes` at most. What reads it shows its lines in errors: a link is followed only to a file with the
/// same ending.
///
/// # Errors
/// As [`read`]; or it is no text, or a link to another kind of file.
pub fn read_text(path: &Path, most_bytes: u64) -> Result<String, InputError> {
    if let Some(ending) = path.extension().filter(|_| path.is_symlink() && !is_open_pipe(path)) {
        let real = std::fs::canonicalize(path)?;
        if !real.extension().is_some_and(|real| real.eq_ignore_ascii_case(ending)) {
            return Err(InputError::OtherEnding(ending.to_string_lossy().into_owned()));
        }
    }
    String::from_utf8(read(path, most_bytes)?).map_err(|_| InputError::NoText)
}

/// Reads on a thread of its own, which is left behind where nothing comes any more.
fn read_pipe(
    mut pipe: impl Read + Send + 'static,
    most_bytes: u64,
    silence_max: Duration,
) -> Result<Vec<u8>, InputError> {
    // Few pieces at a time, so that nothing piles up before the limit is seen.
    let (sender, pieces) = sync_channel::<io::Result<Vec<u8>>>(4);
    std::thread::Builder::new().spawn(move || {
        loop {
            let mut piece = vec![0; 64 << 10];
            let read = pipe.read(&mut piece).map(|count| {
                piece.truncate(count);
                piece
            });
            let is_last = read.as_ref().map_or(true, Vec::is_empty);
            if sender.send(read).is_err() || is_last {
                return;
            }
        }
    })?;
    let mut bytes = Vec::new();
    loop {
        match pieces.recv_timeout(silence_max) {
            Ok(Ok(piece)) if piece.is_empty() => return Ok(bytes),
            Ok(piece) => bytes.extend(piece?),
            Err(RecvTimeoutError::Disconnected) => return Ok(bytes),
            Err(RecvTimeoutError::Timeout) => return Err(InputError::Silent),
        }
        if bytes.len() as u64 > most_bytes {
            return Err(InputError::TooLarge(most_bytes));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pipe_has_a_limit_in_bytes_and_in_time() {
        struct Never;
        impl Read for Never {
            fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
                std::thread::sleep(Duration::from_secs(5));
                Ok(0)
            }
        }
        let soon = Duration::from_millis(200);
        assert!(matches!(read_pipe(Never, 100, soon), Err(InputError::Silent)));
        assert!(matches!(read_pipe(io::repeat(7), 1 << 20, soon), Err(InputError::TooLarge(_))));
        assert_eq!(read_pipe(&b"abc"[..], 3, soon).expect("read"), b"abc");
    }

    #[test]
    fn files_are_read_up_to_the_limit_and_folders_are_refused() {
        let folder = std::env::temp_dir().join(format!("manypass-input-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let path = folder.join("a.wgsl");
        std::fs::write(&path, b"abc").expect("written");
        assert_eq!(read_text(&path, 3).expect("read"), "abc");
        assert!(matches!(read(&path, 2), Err(InputError::TooLarge(2))));
        assert!(matches!(read(&folder, 2), Err(InputError::Folder)));
        let _ = std::fs::remove_dir_all(folder);
    }

    #[cfg(unix)]
    #[test]
    fn a_text_that_is_a_link_has_the_ending_of_its_file() {
        use std::os::unix::fs::symlink;
        let folder = std::env::temp_dir().join(format!("manypass-linked-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).expect("a folder");
        std::fs::write(folder.join("secret"), b"password").expect("written");
        std::fs::write(folder.join("real.wgsl"), b"text").expect("written");
        symlink("secret", folder.join("a.wgsl")).expect("linked");
        symlink("real.wgsl", folder.join("b.wgsl")).expect("linked");
        assert!(matches!(read_text(&folder.join("a.wgsl"), 99), Err(InputError::OtherEnding(_))));
        assert_eq!(read_text(&folder.join("b.wgsl"), 99).expect("read"), "text");
        let _ = std::fs::remove_dir_all(folder);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn devices_are_refused() {
        assert!(matches!(read(Path::new("/dev/zero"), 100), Err(InputError::NotRegular)));
        assert!(matches!(open(Path::new("/dev/null")), Err(InputError::NotRegular)));
    }
}
