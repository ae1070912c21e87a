//! Limits of memory: what does not fit is refused with both numbers, and the process ends as it says.

#![cfg(target_os = "linux")]

mod common;

use common::{Folder, Run, has_adapter, triangle_glb};
use std::process::Command;

/// Runs the program in `folder` with an address space of so many KiB.
fn run_limited(folder: &Folder, address_space_kib: u64, args: &[&str]) -> Run {
    let script = format!("ulimit -v {address_space_kib}; exec \"$0\" \"$@\"");
    let mut command = Command::new("sh");
    command.args(["-c", &script, env!("CARGO_BIN_EXE_manypass")]).args(args).current_dir::<&std::path::Path>(folder);
    command.output().expect("a shell starts").into()
}

/// Mebibytes that a message names, in their order.
fn mebibytes(message: &str) -> Vec<u64> {
    let words: Vec<&str> = message.split_whitespace().collect();
    words.windows(2).filter(|pair| pair[1] == "MiB").filter_map(|pair| pair[0].parse().ok()).collect()
}

#[test]
fn a_limit_below_the_drivers_need_is_said_at_the_start() {
    let folder = Folder::new("memory-floor");
    folder.write("a.glb", &triangle_glb([1.0, 0.0, 0.0]));
    let run = run_limited(&folder, 300_000, &["render", "a.glb", "--size", "16x16"]).expect(3);
    assert!(
        run.stderr.starts_with("error: no graphics driver works in 292 MiB of the address space"),
        "{}",
        run.stderr
    );
    assert_eq!(folder.names(), ["a.glb"]);
}

#[test]
fn pictures_that_do_not_fit_are_refused_and_the_batch_goes_on() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("memory-picture");
    folder.write("a.glb", &triangle_glb([1.0, 0.0, 0.0]));
    folder.write("b.glb", &triangle_glb([0.0, 1.0, 0.0]));
    let floor = run_limited(&folder, 300_000, &["render", "a.glb"]).stderr;
    let floor_mib = mebibytes(&floor)[1];
    // Enough for the driver and a small picture, and by far not for a large one of all variables.
    let limit_kib = (floor_mib + 700) * 1024;
    let large = ["render", "a.glb", "b.glb", "-o", "{stem}.exr", "--aov", "all", "--samples", "1", "--size"];
    let run = run_limited(&folder, limit_kib, &[&large[..], &["4096x4096"]].concat()).expect(1);
    let errors: Vec<&str> = run.stderr.lines().filter(|line| line.starts_with("error: ")).collect();
    assert!(
        matches!(errors[..], [a, b, all] if a.starts_with("error: a.glb: a picture of 4096x4096 with 13 AOVs needs")
        && b.starts_with("error: b.glb: ") && all.contains("2 of 2 inputs failed")),
        "{}",
        run.stderr
    );
    let numbers = mebibytes(errors[0]);
    assert!(numbers.len() == 3 && numbers[0] > 1000 && numbers[1] < numbers[2], "{}", errors[0]);
    assert_eq!(numbers[2], floor_mib + 700);
    assert_eq!(folder.names(), ["a.glb", "b.glb"]);
    run_limited(&folder, limit_kib, &[&large[..], &["64x64"]].concat()).expect(0);
    assert_eq!(folder.names(), ["a.exr", "a.glb", "b.exr", "b.glb"]);
}
