//! Bytes that wait in a file without a name until others are known. The system takes it back when the program ends,
//! however it ends.

use crate::atomic::WriteError;
use flate2::Crc;
use std::fs::{self, File, OpenOptions};
use std::hash::{BuildHasher, Hasher, RandomState};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Bytes that are read back at a time.
const COPY_BYTES: usize = 1 << 20;

/// A growing file in the folder of temporary files. What is appended counts once it is kept.
#[derive(Debug)]
pub(crate) struct Spool {
    file: File,
    /// Where it was, for messages.
    folder: PathBuf,
    kept_bytes: u64,
    kept_crc: Crc,
    new_bytes: u64,
    new_crc: Crc,
}

impl Spool {
    /// An empty one.
    ///
    /// # Errors
    /// If there is no folder of temporary files, or nothing can be written there.
    pub(crate) fn new() -> Result<Self, WriteError> {
        let folder = std::env::temp_dir();
        let file = nameless(&folder).map_err(|source| WriteError::new(&folder, source))?;
        Ok(Self { file, folder, kept_bytes: 0, kept_crc: Crc::new(), new_bytes: 0, new_crc: Crc::new() })
    }

    /// Appends bytes.
    ///
    /// # Errors
    /// If the disk is full or fails.
    pub(crate) fn append(&mut self, bytes: &[u8]) -> Result<(), WriteError> {
        self.file.write_all(bytes).map_err(|source| WriteError::new(&self.folder, source))?;
        self.new_bytes += bytes.len() as u64;
        self.new_crc.update(bytes);
        Ok(())
    }

    /// How many bytes were appended that are not kept yet.
    pub(crate) fn new_bytes(&self) -> u64 {
        self.new_bytes
    }

    /// Keeps what was appended.
    pub(crate) fn keep(&mut self) {
        self.kept_bytes += self.new_bytes;
        self.kept_crc.combine(&self.new_crc);
        self.new_bytes = 0;
        self.new_crc.reset();
    }

    /// Forgets what was appended and not kept.
    ///
    /// # Errors
    /// If the disk fails.
    pub(crate) fn forget(&mut self) -> Result<(), WriteError> {
        self.new_bytes = 0;
        self.new_crc.reset();
        self.seek(self.kept_bytes)
    }

    /// How many bytes are kept.
    pub(crate) fn kept_bytes(&self) -> u64 {
        self.kept_bytes
    }

    /// The CRC-32 of `before` and what is kept.
    pub(crate) fn crc_after(&self, before: &[u8]) -> u32 {
        let mut crc = Crc::new();
        crc.update(before);
        crc.combine(&self.kept_crc);
        crc.sum()
    }

    /// Gives all that is kept, piece by piece.
    ///
    /// # Errors
    /// If the disk fails, or `put` does.
    pub(crate) fn copy(&mut self, mut put: impl FnMut(&[u8]) -> Result<(), WriteError>) -> Result<(), WriteError> {
        self.seek(0)?;
        let mut buffer = vec![0; COPY_BYTES];
        let mut left_bytes = self.kept_bytes;
        while left_bytes > 0 {
            let piece_bytes = usize::try_from(left_bytes).unwrap_or(COPY_BYTES).min(COPY_BYTES);
            let Some(piece) = buffer.get_mut(..piece_bytes) else { return Ok(()) };
            self.file.read_exact(piece).map_err(|source| WriteError::new(&self.folder, source))?;
            put(piece)?;
            left_bytes -= piece_bytes as u64;
        }
        Ok(())
    }

    fn seek(&mut self, position: u64) -> Result<(), WriteError> {
        let sought = self.file.seek(SeekFrom::Start(position));
        sought.map(|_| ()).map_err(|source| WriteError::new(&self.folder, source))
    }
}

/// Makes a file that nobody else can open, and takes its name away.
fn nameless(folder: &Path) -> io::Result<File> {
    let mut attempts_left = 100;
    loop {
        // Its keys come from the system's source of randomness.
        let random = RandomState::new().build_hasher().finish();
        let path = folder.join(format!(".manypass-{random:016x}.spool"));
        let mut options = OpenOptions::new();
        options.read(true).write(true).create_new(true);
        #[cfg(unix)]
        {
            use std::os::unix::fs::OpenOptionsExt;
            options.mode(0o600);
        }
        match options.open(&path) {
            Ok(file) => return fs::remove_file(&path).map(|()| file),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists && attempts_left > 0 => attempts_left -= 1,
            Err(error) => return Err(error),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_comes_back_and_what_is_forgotten_does_not() {
        let mut spool = Spool::new().expect("a file");
        spool.append(b"ab").expect("appended");
        spool.keep();
        spool.append(b"gone").expect("appended");
        spool.forget().expect("forgotten");
        spool.append(b"c").expect("appended");
        assert_eq!((spool.kept_bytes(), spool.new_bytes()), (2, 1));
        spool.keep();
        let mut bytes = Vec::new();
        let put = |piece: &[u8]| {
            bytes.extend_from_slice(piece);
            Ok(())
        };
        spool.copy(put).expect("copied");
        assert_eq!(bytes, b"abc");
        let mut crc = Crc::new();
        crc.update(b"0abc");
        assert_eq!(spool.crc_after(b"0"), crc.sum());
    }
}
