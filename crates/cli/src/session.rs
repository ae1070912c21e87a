//! What every subcommand with a GPU needs: a renderer, failures, and the defaults of a request.

use crate::failure::{Failure, Kind, say, shown};
use crate::interrupt;
use crate::memory;
use manypass::shader::ProgramError;
use manypass::{Cache, Gpu, GpuError, RenderError, Renderer};
use manypass_offline::atomic::{self, WriteError};
use manypass_offline::cache::DiskCache;
use manypass_offline::still::StillError;
use std::sync::Arc;
use std::time::Instant;

/// A renderer on the adapter whose name contains `adapter`, with the user's cache if it is to have one.
///
/// # Errors
/// If there is no such adapter, or it cannot be used.
pub fn open(adapter: Option<&str>, has_cache: bool) -> Result<Renderer, Failure> {
    memory::check_driver()?;
    let gpu = Gpu::headless(adapter).map_err(|error| gpu_failure(&error))?;
    let mut renderer = Renderer::new(gpu).map_err(|error| still_failure(&error.into()))?;
    renderer.set_cache(cache(has_cache));
    Ok(renderer)
}

/// The user's cache, if there is to be one.
pub fn cache(has_cache: bool) -> Option<Arc<dyn Cache>> {
    let cache = DiskCache::of_user().filter(|_| has_cache);
    cache.map(|cache| Arc::new(cache) as Arc<dyn Cache>)
}

/// Says of a cache that cannot be written that nothing is kept. Pictures are the same without it, so that this is no
/// warning that --strict refuses.
pub fn note_cache(has_cache: bool) {
    let Some(cache) = DiskCache::of_user().filter(|_| has_cache) else { return };
    let folder = cache.folder();
    // Where no folder of caches is there at all, none is expected, unless the user names one.
    let named = std::env::var_os("XDG_CACHE_HOME").filter(|place| !place.is_empty());
    let is_named = named.is_some_and(|place| folder.starts_with(place));
    let mut places = folder.ancestors().take(if is_named { usize::MAX } else { 2 });
    if places.find(|place| place.exists()).is_some_and(|there| !memory::is_writable(there)) {
        let folder = folder.display();
        let remedy = "let XDG_CACHE_HOME name a folder that can be created, or add --no-cache";
        say(format_args!("note: the cache {folder} cannot be written, so nothing is kept there; {remedy}"));
    }
}

/// What a missing device means to the user.
pub fn gpu_failure(error: &GpuError) -> Failure {
    match error {
        GpuError::Lost(_) => Failure::new(Kind::DeviceLost, error, "try a smaller --size or another --adapter"),
        GpuError::UnknownAdapter { .. } => Failure::new(Kind::NoAdapter, error, "see `manypass adapters`"),
        GpuError::NoAdapter => Failure::new(Kind::NoAdapter, error, "install a driver, or mesa-vulkan-drivers"),
        _ => Failure::new(Kind::NoAdapter, error, "try another --adapter; see `manypass adapters`"),
    }
}

/// What a failed still means to the user.
pub fn still_failure(error: &StillError) -> Failure {
    match error {
        StillError::Stopped => interrupt::failure(),
        StillError::Render(e) if e.is_device_lost() => Failure::new(Kind::DeviceLost, error, "try a smaller --size"),
        StillError::Render(RenderError::Program(ProgramError::Simulation { .. })) => Failure::new(
            Kind::Failed,
            error,
            "correct [[simulations]] or [[particles]] of the stage; docs/simulations.md has what they take",
        ),
        StillError::Render(RenderError::Program(ProgramError::Dump { .. })) => {
            Failure::new(Kind::Failed, error, "name a folder that can be written, or leave the variable out")
        }
        StillError::Render(RenderError::Program(_)) => Failure::new(
            Kind::Failed,
            error,
            "correct the file that it names; or leave out --effect, --path or --set camera.fisheye",
        ),
        StillError::Render(RenderError::ParallelLens) => {
            Failure::new(Kind::Failed, error, "leave camera.f_stop out, or show it through another --camera")
        }
        StillError::Render(RenderError::Fisheye(_)) => {
            Failure::new(Kind::Failed, error, "leave camera.fisheye out, or show it through another --camera")
        }
        StillError::Render(RenderError::Overlay(_)) => {
            Failure::new(Kind::Failed, error, "correct the overlay, or leave it out")
        }
        StillError::Render(_) => Failure::new(Kind::Failed, error, "try a smaller --size or another --adapter"),
    }
}

/// What a failed output means to the user.
pub fn output_failure(error: impl std::fmt::Display) -> Failure {
    Failure::new(Kind::Failed, error, "check the path, the folder's permissions and its free space")
}

/// What a file that cannot be written means to the user.
pub fn write_failure(error: WriteError) -> Failure {
    match error {
        WriteError::Stopped => interrupt::failure(),
        WriteError::TooLarge(_) => {
            Failure::new(Kind::Failed, error, "raise the limit, or write a smaller picture or fewer AOVs")
        }
        WriteError::Closed(_) => Failure::new(Kind::Failed, error, "let the reader read to the end"),
        error => output_failure(error),
    }
}

/// Writes text to standard output.
///
/// # Errors
/// If the other end is closed or full.
pub fn print(text: &str) -> Result<(), Failure> {
    atomic::write_stdout(shown(text).as_bytes()).map_err(write_failure)
}

/// Writes a list to standard output, whose reader may have seen enough of it, as `head` does.
///
/// # Errors
/// If the other end is full.
pub fn list(text: &str) -> Result<(), Failure> {
    match atomic::write_stdout(shown(text).as_bytes()) {
        Err(WriteError::Closed(_)) => Ok(()),
        written => written.map_err(write_failure),
    }
}

/// Milliseconds since `start`.
pub fn ms_since(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e3
}
