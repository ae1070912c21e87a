//! All pictures of a call in one stream: video, arrays or an archive, to standard output or into a file that appears
//! whole at the end.

use crate::atomic::{self, AtomicFile, WriteError};
use crate::encode::{EncodeError, check_length};
use crate::exr_file::band_rows;
use crate::npz::Arrays;
use crate::still::{Samples, StillError};
use crate::{tar, y4m};
use manypass::{Aov, Renderer};
use std::collections::BTreeSet;
use std::time::{Duration, Instant};

/// The kinds of stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Container {
    /// YUV4MPEG2: raw video without alpha.
    Y4m,
    /// NumPy's arrays: the display, and variables as numbers.
    Npz,
    /// A tar archive of PNG or EXR files.
    Tar,
}

impl Container {
    /// The kind of a file-name extension (without its dot), in any case.
    pub fn from_extension(extension: &str) -> Option<Self> {
        match extension.to_ascii_lowercase().as_str() {
            "y4m" => Some(Self::Y4m),
            "npz" => Some(Self::Npz),
            "tar" => Some(Self::Tar),
            _ => None,
        }
    }

    /// The usual extension, without its dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Y4m => "y4m",
            Self::Npz => "npz",
            Self::Tar => "tar",
        }
    }
}

/// Why a picture could not be added to a stream.
#[derive(Debug, thiserror::Error)]
pub enum StreamError {
    /// There are no pixels.
    #[error(transparent)]
    Pixels(#[from] StillError),
    /// The pixels do not fit the stream.
    #[error(transparent)]
    Encode(#[from] EncodeError),
    /// The bytes could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A tar has no room for the name.
    #[error("a tar holds names of up to 100 bytes, and `{0}` is longer")]
    LongName(String),
    /// A tar holds no file as large.
    #[error("a tar holds files of less than 8 GiB, and `{0}` is larger")]
    LargeFile(String),
    /// Two pictures have one name.
    #[error("two pictures of the tar would be called `{0}`")]
    SameName(String),
    /// Something could not be written before, so that nothing can follow.
    #[error("the stream is broken off")]
    Broken,
}

/// A stream that takes one picture after the other. Dropped without [`Stream::finish`], it leaves no file.
#[derive(Debug)]
pub struct Stream {
    /// None is standard output.
    file: Option<AtomicFile>,
    size: (u32, u32),
    content: Content,
    picture_count: u64,
    is_broken: bool,
}

/// What a kind of stream remembers.
#[derive(Debug)]
enum Content {
    Y4m {
        /// What goes before the first picture; empty from then on.
        header: Vec<u8>,
    },
    Npz {
        arrays: Arrays,
        aovs: Vec<Aov>,
    },
    Tar {
        names: BTreeSet<String>,
    },
}

impl Stream {
    /// A stream without pictures, to `file` or, without one, to standard output. All pictures have one `size`; `aovs`
    /// are the variables of a [`Container::Npz`], others have none.
    ///
    /// # Errors
    /// If a temporary file is needed and cannot be made.
    pub fn new(
        container: Container,
        file: Option<AtomicFile>,
        size: (u32, u32),
        frames_per_second: f32,
        aovs: &[Aov],
    ) -> Result<Self, StreamError> {
        let content = match container {
            Container::Y4m => Content::Y4m { header: y4m::header(size, frames_per_second) },
            Container::Npz => Content::Npz { arrays: Arrays::new(size, aovs)?, aovs: aovs.to_vec() },
            Container::Tar => Content::Tar { names: BTreeSet::new() },
        };
        Ok(Self { file, size, content, picture_count: 0, is_broken: false })
    }

    /// Whether nothing can be added any more, because something could not be written.
    pub fn is_broken(&self) -> bool {
        self.is_broken
    }

    /// Reads the variables of the next picture where the stream holds them as numbers, band by band. Gives the time
    /// that it took to read. A picture that is not added afterwards leaves nothing.
    ///
    /// # Errors
    /// If the device was lost, a variable was not recorded, or a temporary file cannot be written.
    pub fn read_variables(&mut self, renderer: &mut Renderer) -> Result<Duration, StreamError> {
        let mut reading = Duration::ZERO;
        let Content::Npz { arrays, aovs } = &mut self.content else { return Ok(reading) };
        arrays.begin()?;
        let (width, height) = self.size;
        for (index, aov) in aovs.iter().enumerate() {
            let rows_a_band = band_rows(width, aov.info().channels.len());
            for first in (0..height).step_by(rows_a_band as usize) {
                let start = Instant::now();
                let rows = first..height.min(first.saturating_add(rows_a_band));
                let samples: Samples = renderer.read_aov_rows(*aov, rows).map_err(StillError::from)?.into();
                reading += start.elapsed();
                arrays.append(index, &samples)?;
            }
        }
        Ok(reading)
    }

    /// Adds a picture: the bytes of a file called `name` to a [`Container::Tar`], else 8-bit sRGB pixels with alpha,
    /// rows from the top.
    ///
    /// # Errors
    /// If the picture has another size or a name that cannot be, or the bytes cannot be written.
    pub fn add(&mut self, name: &str, picture: &[u8]) -> Result<(), StreamError> {
        if self.is_broken {
            return Err(StreamError::Broken);
        }
        match &mut self.content {
            Content::Y4m { header } => {
                let frame = y4m::frame(self.size, picture)?;
                let header = std::mem::take(header);
                self.put_all(&[&header, &frame])?;
            }
            Content::Npz { arrays, .. } => {
                check_length(self.size.0, self.size.1, 4, picture.len())?;
                arrays.check()?;
                arrays.end(picture)?;
            }
            Content::Tar { names } => {
                let header = tar::header(name, picture.len() as u64)?;
                if !names.insert(name.to_owned()) {
                    return Err(StreamError::SameName(name.to_owned()));
                }
                let padding = vec![0; tar::padding(picture.len())];
                self.put_all(&[&header, picture, &padding])?;
            }
        }
        self.picture_count += 1;
        Ok(())
    }

    /// Ends the stream, and puts its file in its place. Without a picture there is no file.
    ///
    /// # Errors
    /// If that fails.
    pub fn finish(self) -> Result<(), StreamError> {
        let Self { mut file, content, picture_count, is_broken, .. } = self;
        if is_broken {
            return Err(StreamError::Broken);
        }
        if picture_count == 0 {
            return Ok(());
        }
        match content {
            Content::Y4m { .. } => {}
            Content::Npz { arrays, .. } => arrays.write(|bytes| put(&mut file, bytes))?,
            Content::Tar { .. } => put(&mut file, &tar::END)?,
        }
        Ok(file.map_or(Ok(()), AtomicFile::commit)?)
    }

    /// Writes what belongs together; where a part of it fails, the stream is broken.
    fn put_all(&mut self, parts: &[&[u8]]) -> Result<(), WriteError> {
        self.is_broken = true;
        parts.iter().try_for_each(|bytes| put(&mut self.file, bytes))?;
        self.is_broken = false;
        Ok(())
    }
}

/// Writes to the file or to standard output.
fn put(file: &mut Option<AtomicFile>, bytes: &[u8]) -> Result<(), WriteError> {
    match file {
        Some(file) => file.write(bytes),
        None => atomic::write_stdout(bytes),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::path::PathBuf;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("manypass-stream-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        folder
    }

    fn stream(container: Container, folder: &std::path::Path, name: &str) -> Stream {
        let file = AtomicFile::create(&folder.join(name)).expect("created");
        Stream::new(container, Some(file), (2, 1), 24.0, &[]).expect("a stream")
    }

    #[test]
    fn a_stream_appears_whole_at_its_end() {
        let folder = folder("whole");
        for (container, bytes) in [(Container::Y4m, 55 + 3 * 12), (Container::Tar, 3 * 1024 + 1024)] {
            let name = format!("a.{}", container.extension());
            let mut open = stream(container, &folder, &name);
            for picture in ["0", "1", "2"] {
                open.add(picture, &[9; 8]).expect("added");
            }
            assert!(!folder.join(&name).exists());
            open.finish().expect("finished");
            assert_eq!(fs::metadata(folder.join(&name)).expect("there").len(), bytes, "{name}");
        }
        let mut open = stream(Container::Npz, &folder, "a.npz");
        open.add("", &[9; 8]).expect("added");
        assert!(matches!(open.add("", &[9; 4]), Err(StreamError::Encode(_))));
        open.finish().expect("finished");
        assert!(fs::read(folder.join("a.npz")).expect("there").starts_with(b"PK\x03\x04"));
        assert_eq!(fs::read_dir(&folder).expect("listed").count(), 3);
        let _ = fs::remove_dir_all(folder);
    }

    #[test]
    fn what_is_dropped_or_empty_leaves_nothing() {
        let folder = folder("dropped");
        let mut open = stream(Container::Tar, &folder, "a.tar");
        open.add("a.png", b"1").expect("added");
        assert!(matches!(open.add("a.png", b"2"), Err(StreamError::SameName(name)) if name == "a.png"));
        drop(open);
        stream(Container::Npz, &folder, "a.npz").finish().expect("empty");
        assert_eq!(fs::read_dir(&folder).expect("listed").count(), 0);
        let _ = fs::remove_dir_all(folder);
    }
}
