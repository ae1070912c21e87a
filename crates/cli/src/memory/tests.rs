#![allow(clippy::unwrap_used, reason = "a test may panic")]

use super::*;

const GIB: u64 = 1 << 30;

/// A system of files; removed when dropped.
struct Files(System, PathBuf);

impl Files {
    fn new(name: &str, files: &[(&str, &str)]) -> Self {
        let root = std::env::temp_dir().join(format!("manypass-memory-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&root);
        for (path, text) in files {
            let path = root.join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        Self(System { proc: root.join("proc"), cgroup: root.join("cgroup") }, root)
    }
}

impl Drop for Files {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.1);
    }
}

const MEMINFO: (&str, &str) =
    ("proc/meminfo", "MemTotal: 8388608 kB\nMemFree: 1 kB\nMemAvailable: 4194304 kB\nSwapFree: 1048576 kB\n");

#[test]
fn limits_of_the_process_are_less_what_is_used() {
    let limits = "Limit                     Soft Limit           Hard Limit           Units\n\
                  Max data size             unlimited            unlimited            bytes\n\
                  Max address space         2147483648           unlimited            bytes\n";
    let files = Files::new(
        "process",
        &[
            ("proc/self/limits", limits),
            ("proc/self/status", "VmPeak: 9 kB\nVmSize:\t 1048576 kB\nVmData: 5 kB\n"),
            MEMINFO,
        ],
    );
    let found = files.0.limits();
    let left: Vec<_> = found.iter().map(|limit| (limit.total_bytes, limit.left_bytes, limit.is_reserved)).collect();
    assert_eq!(left, [(2 * GIB, GIB, true), (8 * GIB, 5 * GIB, false)]);
}

#[test]
fn control_groups_of_both_versions_and_those_above_them_count() {
    let files = Files::new(
        "groups",
        &[
            ("proc/self/cgroup", "5:cpu:/a\n4:memory,x:/job\n0::/outer/inner\n"),
            ("cgroup/memory.max", "max\n"),
            ("cgroup/outer/memory.max", "3221225472\n"),
            ("cgroup/outer/memory.current", "2147483648\n"),
            ("cgroup/outer/memory.stat", "anon 1\ninactive_file 1073741824\n"),
            ("cgroup/outer/inner/memory.max", "max\n"),
            ("cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n"),
            ("cgroup/memory/job/memory.limit_in_bytes", "1073741824\n"),
            ("cgroup/memory/job/memory.usage_in_bytes", "536870912\n"),
        ],
    );
    let found: Vec<_> = files.0.limits().iter().map(|limit| (limit.total_bytes, limit.left_bytes)).collect();
    assert_eq!(found, [(GIB, GIB / 2), (3 * GIB, 2 * GIB)]);
    assert!(Files::new("nothing", &[]).0.limits().is_empty());
}

fn limit(name: &'static str, total_bytes: u64, left_bytes: u64, is_reserved: bool) -> Limit {
    Limit { name, total_bytes, left_bytes, is_reserved }
}

#[test]
fn the_tightest_limit_is_that_which_leaves_least() {
    let limits = [limit("space", 4 * GIB, 2 * GIB, true), limit("group", 2 * GIB, GIB, false)];
    let need = |used_bytes, reserved_bytes| Need { used_bytes, reserved_bytes };
    let found = |need| tightest(&limits, need).map(|(limit, left)| (limit.name, left)).unwrap();
    assert_eq!(found(need(GIB / 2, 0)), ("group", i128::from(GIB / 2)));
    assert_eq!(found(need(GIB / 2, 3 * GIB / 2)), ("space", 0));
    assert_eq!(found(need(3 * GIB, 0)), ("group", -2 * i128::from(GIB)));
    let failure = refusal("a picture", 3 * GIB, &limits[1], "raise it");
    assert_eq!(
        failure.message,
        "a picture needs at least 3072 MiB of memory, but 1024 MiB of the 2048 MiB of group are left"
    );
}

#[test]
fn a_driver_needs_more_on_more_cores() {
    let limits = [limit("the address space (`ulimit -v`)", GIB, GIB, true)];
    assert!(driver_fits(&limits, 2).is_ok());
    let failure = driver_fits(&limits, 16).unwrap_err();
    assert!(failure.code() == 3 && failure.message.contains("1024 MiB"), "{failure:?}");
    assert!(driver_fits(&[limit("the data segment (`ulimit -d`)", 1 << 20, 1 << 20, true)], 2).is_err());
    assert!(driver_fits(&[], 64).is_ok());
}

#[test]
fn a_file_in_the_place_of_a_folder_cannot_be_written_into() {
    let file = std::env::temp_dir().join(format!("manypass-in-the-way-{}", std::process::id()));
    std::fs::write(&file, b"a file").unwrap();
    assert!(!is_writable(&file) && !is_writable(&file.join("below")) && is_writable(&std::env::temp_dir()));
    std::fs::remove_file(&file).unwrap();
}
