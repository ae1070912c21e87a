//! One stream of all pictures of a call: its beginning and its end.

use crate::failure::{Failure, Kind};
use crate::job::{Job, StreamPlace};
use crate::output;
use crate::session::{output_failure, still_failure, write_failure};
use manypass_offline::still::aov_named;
use manypass_offline::{Stream, StreamError};

/// Begins the stream of `job` at `place`.
fn begin(place: &StreamPlace, job: &Job) -> Result<Stream, Failure> {
    let file = place.path.as_deref().map(output::begin).transpose()?;
    let aovs: Vec<_> = job.aovs.iter().filter_map(|name| aov_named(name)).collect();
    let size = (job.width, job.height);
    Stream::new(place.container, file, size, place.frames_per_second, &aovs).map_err(stream_failure)
}

/// The stream of a job that has one, which begins with its first picture.
///
/// # Errors
/// If it cannot be begun.
pub fn begun<'a>(stream: &'a mut Option<Stream>, job: &Job) -> Result<Option<&'a mut Stream>, Failure> {
    if stream.is_none() {
        *stream = job.output.stream().map(|place| begin(place, job)).transpose()?;
    }
    Ok(stream.as_mut())
}

/// Ends the stream, if there is one.
///
/// # Errors
/// If it cannot be written, or the user has said stop.
pub fn finish(stream: Option<Stream>) -> Result<(), Failure> {
    stream.map_or(Ok(()), |stream| stream.finish().map_err(stream_failure))
}

/// What a failed stream means to the user.
pub fn stream_failure(error: StreamError) -> Failure {
    match error {
        StreamError::Pixels(error) => still_failure(&error),
        StreamError::Encode(error) => output_failure(error),
        StreamError::Write(error) => write_failure(error),
        error @ (StreamError::LongName(_) | StreamError::SameName(_)) => {
            Failure::new(Kind::Failed, error, "give the input another name, or write to a folder: -o DIR/")
        }
        error @ StreamError::LargeFile(_) => {
            Failure::new(Kind::Failed, error, "write a smaller picture or fewer AOVs, or to a folder: -o DIR/")
        }
        error @ StreamError::Broken => output_failure(error),
    }
}
