//! The graphics driver's own cache on disk, and where the driver has to do without it.
//!
//! Mesa maps the index of its shader cache into memory, and that file has holes. Where the disk is full, to write into
//! a hole ends the process with SIGBUS, with --no-cache too. Source: Mesa's `src/util/disk_cache_os.c`
//! (`disk_cache_generate_cache_dir`, `disk_cache_mmap_cache_index`).

use crate::memory;
use std::ffi::OsString;
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};

/// What has to be free. The index has 65,536 keys of 20 bytes, which is 1.3 MB; the rest is room for what is written
/// meanwhile.
const LEAST_BYTES: u64 = 64 << 20;

/// The names of Mesa's folder: of the cache in many files, and of those in few.
const NAMES: [&str; 3] = ["mesa_shader_cache", "mesa_shader_cache_db", "mesa_shader_cache_sf"];

/// Switches Mesa's shader cache off for this process where its disk is nearly full.
#[allow(unsafe_code, reason = "the environment can only be changed by an unsafe call")]
pub fn spare_full_disk() {
    let place = place(|name| std::env::var_os(name), home_of_user());
    if place.is_some_and(|place| is_short(&place, memory::free_bytes)) {
        // SAFETY: `main` calls this before anything that starts a thread, so no other thread reads the environment
        // meanwhile.
        unsafe { std::env::set_var("MESA_SHADER_CACHE_DISABLE", "true") };
    }
}

/// The home that the system knows of this user. Mesa takes that one, and does not read $HOME.
fn home_of_user() -> Option<PathBuf> {
    let uid = std::fs::metadata("/proc/self").ok()?.uid();
    let users = std::fs::read("/etc/passwd").ok()?;
    home_of(&String::from_utf8_lossy(&users), uid)
}

/// The home of a user in the text of `/etc/passwd`: name, password, number, group, comment, home, shell.
fn home_of(users: &str, uid: u32) -> Option<PathBuf> {
    let home = |line: &str| {
        let fields: Vec<&str> = line.split(':').collect();
        let (number, home) = (fields.get(2)?, fields.get(5)?);
        (number.parse::<u32>() == Ok(uid) && !home.is_empty()).then(|| PathBuf::from(home))
    };
    users.lines().find_map(home)
}

/// The place for Mesa's folder. Where it cannot make that there, it has no cache.
fn place(variable: impl Fn(&str) -> Option<OsString>, home: Option<PathBuf>) -> Option<PathBuf> {
    let named = |name: &str| variable(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    // Users of a network directory are not in the system's list.
    let of_home = || home.or_else(|| named("HOME")).map(|home| home.join(".cache"));
    let variables = ["MESA_SHADER_CACHE_DIR", "MESA_GLSL_CACHE_DIR", "XDG_CACHE_HOME"];
    variables.into_iter().find_map(named).or_else(of_home)
}

/// Whether too little is free where the cache lies, or where it would be made.
fn is_short(place: &Path, free_bytes: impl Fn(&Path) -> Option<u64>) -> bool {
    // Each may be a disk of its own, or a link to another one.
    NAMES.iter().any(|name| free_bytes(&place.join(name)).is_some_and(|free| free < LEAST_BYTES))
}

#[cfg(test)]
mod tests {
    use super::*;

    const USERS: &str = "root:x:0:0:root:/root:/bin/bash\nbroken\nann:x:1000:1000:Ann,,,:/home/ann:/bin/sh\n";

    fn place_of(variables: &[(&str, &str)], uid: u32) -> Option<PathBuf> {
        let variable = |name: &str| {
            let named = variables.iter().find(|(known, _)| *known == name);
            named.map(|(_, value)| OsString::from(*value))
        };
        place(variable, home_of(USERS, uid))
    }

    #[test]
    fn the_home_of_the_system_counts_and_not_that_of_the_environment() {
        let elsewhere = ("HOME", "/elsewhere");
        for (uid, expected) in [(0, "/root/.cache"), (1000, "/home/ann/.cache"), (7, "/elsewhere/.cache")] {
            assert_eq!(place_of(&[elsewhere], uid), Some(PathBuf::from(expected)));
        }
        assert_eq!(place_of(&[], 7), None);
    }

    #[test]
    fn variables_name_the_place_before_the_home() {
        let place_of = |variables: &[(&str, &str)]| place_of(variables, 0).expect("a place");
        assert_eq!(place_of(&[("XDG_CACHE_HOME", "/x"), ("MESA_SHADER_CACHE_DIR", "/m")]), Path::new("/m"));
        assert_eq!(place_of(&[("XDG_CACHE_HOME", "/x"), ("MESA_SHADER_CACHE_DIR", "")]), Path::new("/x"));
        assert_eq!(place_of(&[("XDG_CACHE_HOME", "")]), Path::new("/root/.cache"));
    }

    #[test]
    fn the_cache_is_off_where_its_disk_is_nearly_full() {
        let free = |path: &Path| match path {
            path if path.starts_with("/full") => Some(LEAST_BYTES - 1),
            // Mesa's folder may lie on a disk of its own.
            path if path.ends_with("own/mesa_shader_cache") => Some(0),
            path if path.starts_with("/unknown") => None,
            _ => Some(LEAST_BYTES),
        };
        assert!(["/full", "/own"].iter().all(|place| is_short(Path::new(place), free)));
        assert!(!["/roomy", "/unknown"].iter().any(|place| is_short(Path::new(place), free)));
    }

    #[test]
    fn this_system_tells_what_is_free() {
        assert!(memory::free_bytes(&std::env::temp_dir()).is_some());
        assert!(memory::free_bytes(Path::new("/nowhere/at/all")).is_some(), "the disk that would hold it");
    }
}
