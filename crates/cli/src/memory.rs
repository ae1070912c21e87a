//! Memory: what the process may still take, by every limit that the system holds it to, and what a picture will take.
//!
//! The limits are those of Linux; elsewhere nothing is refused beforehand.

use crate::failure::{Failure, Kind};
use crate::job::Job;
use crate::threads;
use manypass::{AdapterSummary, FrameRequest, OverlayError, RenderError};
use manypass_offline::memory;
use manypass_offline::still::StillError;
use std::path::{Path, PathBuf};

/// The least address space with which Mesa 22.3.6 on two cores draws 16 × 16 pixels: with 700,000 KiB it ends the
/// process with a signal or hangs, in `LLVM` or when it starts threads; with 800,000 KiB it never did in 20 runs.
const DRIVER_ADDRESS_SPACE_BYTES: u64 = 800_000 * 1024;
/// What every further core adds: measured 572 MB for six more threads of the driver, of which 64 MiB each are
/// reserved for its allocations.
const DRIVER_ADDRESS_SPACE_PER_CORE_BYTES: u64 = 96_000_000;
/// The driver starts no more threads than this.
const DRIVER_CORES_MAX: u64 = 16;
/// The least data segment for the same: with 60,000 KiB there was no device, with 100,000 KiB there always was.
const DRIVER_DATA_BYTES: u64 = 100_000 * 1024;
/// What the driver takes to compile the shaders of a frame and to draw it, whatever its size: 45 MB measured for one
/// material, 105 MB for the 25 of Sponza; of the address space 150 MB.
const DRAW: Need = Need { used_bytes: 112 << 20, reserved_bytes: 48 << 20 };
/// What every thread that decodes images reserves of the address space; there are up to four.
const DECODER_ADDRESS_SPACE_BYTES: u64 = 64 << 20;
const DECODERS_MAX: u64 = 4;
/// Bytes of a shaded pixel for the pictures of all passes: their copies, and what is shown of them; 156 were measured.
const PASSES_BYTES_PER_PIXEL: u64 = 170;
/// Bytes of a shaded pixel for the report's count of pairs.
const PAIRS_BYTES_PER_PIXEL: u64 = 48;

/// What is free for this user on the disk that holds `folder`, or will hold it.
#[cfg(target_os = "linux")]
#[allow(unsafe_code, reason = "the system's function for it takes a place to write to")]
#[allow(clippy::useless_conversion, reason = "the numbers of the structure have other widths on other machines")]
pub fn free_bytes(folder: &Path) -> Option<u64> {
    use std::os::unix::ffi::OsStrExt as _;
    let there = folder.ancestors().find(|path| path.exists())?;
    let path = std::ffi::CString::new(there.as_os_str().as_bytes()).ok()?;
    let mut disk = std::mem::MaybeUninit::<libc::statvfs>::zeroed();
    // SAFETY: the path ends with a zero, and the structure is as large as the function expects; zeroes are valid for it.
    let disk = unsafe {
        if libc::statvfs(path.as_ptr(), disk.as_mut_ptr()) != 0 {
            return None;
        }
        disk.assume_init()
    };
    u64::from(disk.f_bavail).checked_mul(u64::from(disk.f_frsize))
}

/// Whether `folder` is a folder that this user may write into.
#[cfg(unix)]
#[allow(unsafe_code, reason = "what a user may do with a folder is told by a function of the system")]
pub fn is_writable(folder: &Path) -> bool {
    use std::os::unix::ffi::OsStrExt as _;
    let path = std::ffi::CString::new(folder.as_os_str().as_bytes());
    // SAFETY: the path ends with a zero.
    let is_allowed = path.is_ok_and(|path| unsafe { libc::access(path.as_ptr(), libc::W_OK | libc::X_OK) == 0 });
    // Root may write anything; a file in the place of a folder holds no entries all the same.
    is_allowed && folder.is_dir()
}

/// Whether `folder` is a folder that this user may write into.
#[cfg(not(unix))]
pub fn is_writable(folder: &Path) -> bool {
    std::fs::metadata(folder).is_ok_and(|folder| folder.is_dir() && !folder.permissions().readonly())
}

/// Something that holds the process to a number of bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Limit {
    /// What it is, and by what it can be raised.
    name: &'static str,
    /// The limit itself.
    total_bytes: u64,
    /// What is left of it.
    left_bytes: u64,
    /// Whether reserved memory counts, whether it is used or not.
    is_reserved: bool,
}

/// Where the system tells of its limits.
#[derive(Debug)]
struct System {
    proc: PathBuf,
    cgroup: PathBuf,
}

impl System {
    fn this() -> Self {
        Self { proc: "/proc".into(), cgroup: "/sys/fs/cgroup".into() }
    }

    fn limits(&self) -> Vec<Limit> {
        let mut limits = Vec::new();
        limits.extend(self.process_limit("Max address space", "VmSize", "the address space (`ulimit -v`)", true));
        limits.extend(self.process_limit("Max data size", "VmData", "the data segment (`ulimit -d`)", true));
        limits.extend(self.cgroups());
        limits.extend(self.free());
        limits
    }

    /// A limit of `/proc/self/limits`, less what `/proc/self/status` says is used.
    fn process_limit(&self, limit: &str, used: &str, name: &'static str, is_reserved: bool) -> Option<Limit> {
        let limits = std::fs::read_to_string(self.proc.join("self/limits")).ok()?;
        let line = limits.lines().find_map(|line| line.strip_prefix(limit))?;
        let total_bytes: u64 = line.split_whitespace().next()?.parse().ok()?;
        let used_bytes = kib_field(&self.proc.join("self/status"), used)?;
        Some(Limit { name, total_bytes, left_bytes: total_bytes.saturating_sub(used_bytes), is_reserved })
    }

    /// The limits of the control groups that hold the process, of both versions; those further up hold it too.
    fn cgroups(&self) -> Vec<Limit> {
        let Ok(groups) = std::fs::read_to_string(self.proc.join("self/cgroup")) else { return Vec::new() };
        let mut limits = Vec::new();
        for line in groups.lines() {
            let mut parts = line.splitn(3, ':');
            let (Some(_), Some(controllers), Some(path)) = (parts.next(), parts.next(), parts.next()) else { continue };
            let (root, max, used, cache) = if controllers.is_empty() {
                (self.cgroup.clone(), "memory.max", "memory.current", "inactive_file")
            } else if controllers.split(',').any(|controller| controller == "memory") {
                let used = "memory.usage_in_bytes";
                (self.cgroup.join("memory"), "memory.limit_in_bytes", used, "total_inactive_file")
            } else {
                continue;
            };
            // In a container the path may be that outside of it; then only the root is there.
            for folder in Path::new(path.trim_start_matches('/')).ancestors().map(|path| root.join(path)) {
                limits.extend(cgroup_limit(&folder, max, used, cache));
            }
        }
        limits
    }

    fn free(&self) -> Option<Limit> {
        let file = self.proc.join("meminfo");
        let swap_bytes = kib_field(&file, "SwapFree").unwrap_or(0);
        Some(Limit {
            name: "the machine's memory",
            total_bytes: kib_field(&file, "MemTotal")?,
            left_bytes: kib_field(&file, "MemAvailable")? + swap_bytes,
            is_reserved: false,
        })
    }
}

/// A line `NAME:  123 kB` of a file of the system, in bytes.
fn kib_field(file: &Path, name: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let rest = text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':'))?;
    rest.split_whitespace().next()?.parse::<u64>().ok()?.checked_mul(1024)
}

fn cgroup_limit(folder: &Path, max: &str, used: &str, cache: &str) -> Option<Limit> {
    let number = |file: &str| std::fs::read_to_string(folder.join(file)).ok()?.trim().parse::<u64>().ok();
    // No limit is `max`, or the largest multiple of a page.
    let total_bytes = number(max).filter(|bytes| *bytes < 1 << 60)?;
    // Files that were read count as used, but give way.
    let stat = std::fs::read_to_string(folder.join("memory.stat")).unwrap_or_default();
    let cached: u64 = stat.lines().find_map(|line| line.strip_prefix(cache)?.trim().parse().ok()).unwrap_or_default();
    let used_bytes = number(used)?.saturating_sub(cached);
    Some(Limit {
        name: "its control group (the container's memory)",
        total_bytes,
        left_bytes: total_bytes.saturating_sub(used_bytes),
        is_reserved: false,
    })
}

/// What something takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Need {
    /// Bytes that are used.
    used_bytes: u64,
    /// Bytes that are reserved of the address space beyond them.
    reserved_bytes: u64,
}

impl Need {
    fn of(self, limit: &Limit) -> u64 {
        self.used_bytes + if limit.is_reserved { self.reserved_bytes } else { 0 }
    }
}

/// The limit that leaves the least beyond `need`, and by how much; it is negative if it does not fit.
fn tightest(limits: &[Limit], need: Need) -> Option<(&Limit, i128)> {
    let left = |limit: &Limit| i128::from(limit.left_bytes) - i128::from(need.of(limit));
    limits.iter().map(|limit| (limit, left(limit))).min_by_key(|(_, left)| *left)
}

/// Whole MiB, rounded up.
fn mib(bytes: u64) -> u64 {
    bytes.div_ceil(1 << 20)
}

/// What is too much: both numbers, and what to do.
fn refusal(what: &str, need_bytes: u64, limit: &Limit, hint: &str) -> Failure {
    let (need, left, total, name) = (mib(need_bytes), limit.left_bytes >> 20, limit.total_bytes >> 20, limit.name);
    Failure::new(
        Kind::Failed,
        format!("{what} needs at least {need} MiB of memory, but {left} MiB of the {total} MiB of {name} are left"),
        hint,
    )
}

/// Fails where the process has less than what the driver needs to draw anything at all: it would end the process, or
/// hang.
///
/// # Errors
/// A limit of memory, stacks or threads is lower than that.
pub fn check_driver() -> Result<(), Failure> {
    driver_fits(&System::this().limits(), cores())?;
    threads::check()
}

/// Whether the process has a limit of its own, below what the machine has.
pub fn is_limited() -> bool {
    let system = System::this();
    let of_machine = system.free().map_or(0, |free| free.total_bytes);
    system.limits().iter().any(|limit| limit.total_bytes < of_machine)
}

fn cores() -> u64 {
    std::thread::available_parallelism().map_or(1, usize::from) as u64
}

fn driver_fits(limits: &[Limit], cores: u64) -> Result<(), Failure> {
    let further_cores = cores.min(DRIVER_CORES_MAX).saturating_sub(2);
    for limit in limits {
        let floor_bytes = match limit.name {
            name if name.contains("ulimit -v") => {
                DRIVER_ADDRESS_SPACE_BYTES + further_cores * DRIVER_ADDRESS_SPACE_PER_CORE_BYTES
            }
            _ => DRIVER_DATA_BYTES,
        };
        if limit.total_bytes < floor_bytes {
            let (total, floor, name) = (limit.total_bytes >> 20, mib(floor_bytes), limit.name);
            return Err(Failure::new(
                Kind::NoAdapter,
                format!("no graphics driver works in {total} MiB of {name}: one takes about {floor} MiB"),
                format!("raise the limit to {floor} MiB plus the memory of the scene and the picture"),
            ));
        }
    }
    Ok(())
}

/// Whether the textures of an adapter lie in the memory of the process.
fn shares_memory(adapter: &AdapterSummary) -> bool {
    adapter.device_type == "Software"
}

/// Fails if the scene will not fit.
///
/// # Errors
/// With both numbers.
pub fn check_scene(scene: &manypass_scene::Scene, adapter: &AdapterSummary) -> Result<(), Failure> {
    if !shares_memory(adapter) {
        return Ok(());
    }
    let decoders = (cores() + 1).min(DECODERS_MAX + 1);
    let need =
        Need { used_bytes: manypass::upload_bytes(scene), reserved_bytes: decoders * DECODER_ADDRESS_SPACE_BYTES };
    match tightest(&System::this().limits(), need) {
        Some((limit, left)) if left < 0 => {
            let hint = "raise the limit, or make the model's textures smaller";
            Err(refusal("the scene", need.of(limit), limit, hint))
        }
        _ => Ok(()),
    }
}

/// What the textures of a picture may take, and by which limit.
#[derive(Clone, Debug)]
pub struct Budget {
    limit: Limit,
    /// What the picture takes beside textures.
    host_bytes: u64,
    /// What its textures may take; none if they lie elsewhere.
    pub texture_bytes: Option<u64>,
}

const PICTURE_HINT: &str = "raise the limit, or choose a smaller --size, fewer --aov or a smaller render.scale";
const OVERLAY_HINT: &str = "raise the limit, or make sprites and letters of the overlay smaller";

fn named(job: &Job) -> String {
    let aovs = if job.aovs.is_empty() { String::new() } else { format!(" with {} AOVs", job.aovs.len()) };
    format!("a picture of {}x{}{aovs}", job.width, job.height)
}

/// What is left for the textures of a picture; none if nothing limits the process.
///
/// # Errors
/// What the picture takes beside them is too much by itself.
pub fn budget(
    job: &Job,
    request: &FrameRequest,
    adapter: &AdapterSummary,
    shows_passes: bool,
    reports: bool,
) -> Result<Option<Budget>, Failure> {
    let limits = System::this().limits();
    let need = Need { used_bytes: host_bytes(job, request, shows_passes, reports), reserved_bytes: 0 }
        .plus(if shares_memory(adapter) { DRAW } else { Need::default() });
    let Some((limit, left)) = tightest(&limits, need) else { return Ok(None) };
    let host_bytes = need.of(limit);
    let texture_bytes = u64::try_from(left).ok();
    if !shares_memory(adapter) && texture_bytes.is_none() {
        return Err(refusal(&named(job), host_bytes, limit, PICTURE_HINT));
    }
    // If nothing is left for textures, the renderer says how much they take, so that the message has the whole number.
    let texture_bytes = shares_memory(adapter).then_some(texture_bytes.unwrap_or(0));
    Ok(Some(Budget { limit: limit.clone(), host_bytes, texture_bytes }))
}

impl Need {
    fn plus(self, other: Self) -> Self {
        Self {
            used_bytes: self.used_bytes + other.used_bytes,
            reserved_bytes: self.reserved_bytes + other.reserved_bytes,
        }
    }
}

impl Budget {
    /// The picture's failure, if the renderer refused its textures, or that of what is drawn over it.
    pub fn failure(&self, job: &Job, error: &StillError) -> Option<Failure> {
        let (needed_bytes, what, hint) = match error {
            StillError::Render(RenderError::Memory { needed_bytes, .. }) => (needed_bytes, named(job), PICTURE_HINT),
            StillError::Render(RenderError::Overlay(OverlayError::Memory { side, needed_bytes, .. })) => {
                let atlas = format!("{} whose overlay fills a texture of {side}x{side}", named(job));
                (needed_bytes, atlas, OVERLAY_HINT)
            }
            _ => return None,
        };
        Some(refusal(&what, self.host_bytes.saturating_add(*needed_bytes), &self.limit, hint))
    }
}

/// What a picture takes beside the textures of its frame: what is kept of its first sample, then at the moment that
/// takes most what is read and written, or what is shown of its passes.
fn host_bytes(job: &Job, request: &FrameRequest, shows_passes: bool, reports: bool) -> u64 {
    let (width, height, aovs) = (job.width, job.height, request.want_aovs.as_slice());
    let scale = f64::from(request.settings.render.scale);
    let shaded_pixels = (f64::from(width) * f64::from(height) * scale * scale) as u64;
    let passes = if shows_passes { shaded_pixels * PASSES_BYTES_PER_PIXEL } else { 0 };
    let pairs = if reports { shaded_pixels * PAIRS_BYTES_PER_PIXEL } else { 0 };
    let delivery = memory::delivery_bytes(job.format, width, height, aovs, job.is_one_stream);
    memory::kept_bytes(width, height, aovs) + [delivery, passes, pairs].into_iter().max().unwrap_or(0)
}

#[cfg(test)]
mod tests;
