//! Signals, and limits of the system: one signal ends the program soon whatever it does, a pipe that it writes to stays
//! one, and few threads or a small stack end in an error or in a picture.
#![cfg(target_os = "linux")]

mod common;

use common::{Folder, Run, has_adapter, triangle_glb};
use std::io::{Read as _, Write as _};
use std::os::unix::fs::{FileTypeExt as _, PermissionsExt as _};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// The longest that the program may take to end after one signal.
const ENDS_WITHIN: Duration = Duration::from_secs(2);
/// How much longer the test waits: on a busy machine many programs end at once, each with memory to give back. What
/// ends later than [`ENDS_WITHIN`] is tried again, and has to end in time then.
const ALLOWANCE: Duration = Duration::from_secs(30);

/// Starts the program; nobody writes to its standard input, which is open until the child goes.
fn start(folder: &Folder, args: &[&str], stderr: Stdio) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_manypass"));
    command.args(args).current_dir(&**folder).env("MANYPASS_NO_CACHE", "1");
    command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(stderr).spawn().expect("the program starts")
}

fn make_pipe(path: &Path) {
    let made = Command::new("mkfifo").arg(path).status();
    assert!(made.is_ok_and(|status| status.success()), "mkfifo");
}

fn is_pipe(path: &Path) -> bool {
    std::fs::symlink_metadata(path).is_ok_and(|there| there.file_type().is_fifo())
}

/// A pipe that is full and that nobody reads: what has to be kept so that it stays, and the end to write to.
fn full_pipe() -> (std::io::PipeReader, Stdio) {
    let (reader, writer) = std::io::pipe().expect("a pipe");
    let mut filler = writer.try_clone().expect("the same pipe");
    // It waits for ever, until the reader is dropped.
    std::thread::spawn(move || while filler.write_all(&[b' '; 4096]).is_ok() {});
    (reader, writer.into())
}

/// What the slow runs read.
fn slow_inputs(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.write("tri.glb", &triangle_glb([1.0, 0.5, 0.0]));
    // One sample of this takes minutes.
    let body = "var sum = color; for (var i = 0; i < 100000; i++) { sum = sin(sum + f32(i)); } return sum;";
    let text = format!("//! pixel: f\nfn f(color: vec4f, position: vec2f) -> vec4f {{ {body} }}\n");
    folder.write("slow.wgsl", text.as_bytes());
    folder.write("long.obj", format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{}", "f 1 2 3\n".repeat(2_000_000)).as_bytes());
    folder.write("smoke.stage.toml", b"model = \"tri.glb\"\n[[particles]]\npreset = \"smoke\"\ncount = 400000\n");
    make_pipe(&folder.join("pipe.png"));
    folder
}

/// Calls that take minutes, or wait for ever.
const SLOW: [&[&str]; 9] = [
    &["render", "tri.glb", "--effect", "slow.wgsl", "--size", "1024x1024", "--report", "a.json"],
    &["render", "tri.glb", "--effect", "slow.wgsl", "--size", "1024x1024", "-o", "b.exr", "--aov", "all"],
    // Until it is read; then it is drawn slowly.
    &["render", "long.obj", "--effect", "slow.wgsl", "--size", "1024x1024"],
    &["render", "demo:hall", "-o", "c.png", "--size", "640x360", "--samples", "65536"],
    &["render", "smoke.stage.toml", "--time", "1000", "--size", "16x16", "--samples", "1"],
    &["bake", "demo:cornell", "-o", "d.glb", "--density", "512"],
    &["diff", "demo:hall", "demo:hall", "--size", "640x360", "--samples", "65536"],
    // Nobody writes to what these read, or reads what they write.
    &["render", "-", "-o", "e.png"],
    &["render", "tri.glb", "-o", "pipe.png", "--size", "8x8", "--samples", "1"],
];

/// Starts those of [`SLOW`] with the given numbers at once, and sends each one signal after four seconds. Gives how
/// long each then took; fails the test unless all end as interrupted.
fn times_to_end(folder: &Folder, numbers: &[usize]) -> Vec<(usize, Duration)> {
    let (_reader, full) = full_pipe();
    // Standard error of the first is that pipe.
    let stderr = std::iter::once(full).chain(std::iter::repeat_with(Stdio::null));
    let children: Vec<(usize, Child)> =
        numbers.iter().zip(stderr).map(|(at, stderr)| (*at, start(folder, SLOW[*at], stderr))).collect();
    std::thread::sleep(Duration::from_secs(4));
    let mut running: Vec<(usize, Child, Instant)> = Vec::new();
    for (at, child) in children {
        let signal = if at.is_multiple_of(2) { "-TERM" } else { "-HUP" };
        let sent = Instant::now();
        let status = Command::new("kill").args([signal, &child.id().to_string()]).status();
        assert!(status.is_ok_and(|status| status.success()), "{signal} {:?}", SLOW[at]);
        running.push((at, child, sent));
    }
    let (begun, mut ended) = (Instant::now(), Vec::new());
    while !running.is_empty() && begun.elapsed() < ENDS_WITHIN + ALLOWANCE {
        running.retain_mut(|(at, child, sent)| {
            let status = child.try_wait().expect("waited for");
            ended.extend(status.map(|status| (*at, status.code(), sent.elapsed())));
            status.is_none()
        });
        std::thread::sleep(Duration::from_millis(5));
    }
    let left: Vec<_> = running.iter().map(|(at, ..)| SLOW[*at]).collect();
    for (_, child, _) in &mut running {
        child.kill().and_then(|()| child.wait()).expect("killed");
    }
    assert!(left.is_empty(), "they still run after {:?}: {left:?}", begun.elapsed());
    assert!(ended.iter().all(|(_, code, _)| *code == Some(130)), "{ended:?}");
    ended.into_iter().map(|(at, _, time)| (at, time)).collect()
}

#[test]
fn one_signal_ends_it_whatever_it_does() {
    if !has_adapter() {
        return;
    }
    let folder = slow_inputs("signals");
    let before = folder.names();
    // All at once; on a busy machine those that were late again, in smaller groups.
    let mut late: Vec<(usize, Duration)> = Vec::new();
    let mut numbers: Vec<usize> = (0..SLOW.len()).collect();
    for together in [SLOW.len(), 3, 1] {
        late = numbers.chunks(together).flat_map(|chunk| times_to_end(&folder, chunk)).collect();
        late.retain(|(_, time)| *time > ENDS_WITHIN);
        numbers = late.iter().map(|(at, _)| *at).collect();
    }
    let late: Vec<_> = late.iter().map(|(at, time)| (SLOW[*at], time)).collect();
    assert!(late.is_empty(), "more than {ENDS_WITHIN:?} in each of three rounds: {late:?}");
    // What was baked stays, as blocks of which each is whole, for the next bake; and where a machine draws fast enough
    // to notice, there is a report that says so.
    let stays = |name: &String| name != "d.glb.part" && name != "a.json";
    let after: Vec<String> = folder.names().into_iter().filter(stays).collect();
    assert!(after == before && is_pipe(&folder.join("pipe.png")), "{after:?}");
}

#[test]
fn a_pipe_stays_one_whatever_is_written_and_whoever_is_killed() {
    if !has_adapter() {
        return;
    }
    let folder = slow_inputs("pipes-stay");
    // Each is read to its end.
    let bare = ["render", "tri.glb", "--size", "8x8", "--samples", "1", "-q"];
    make_pipe(&folder.join("report.json"));
    for (name, flags) in [
        ("pipe.png", &["-o", "pipe.png"][..]),
        ("report.json", &["-o", "a.png", "--report", "report.json"][..]),
        ("pipe.png", &["-o", "b.png", "--contact-sheet", "pipe.png"][..]),
    ] {
        let mut cat = Command::new("cat").arg(folder.join(name)).stdout(Stdio::piped()).spawn().expect("cat");
        let run = common::run_in(&folder, &[&bare[..], flags].concat());
        if run.code != 0 {
            let _ = cat.kill();
        }
        let came = cat.wait_with_output().expect("it ends").stdout;
        run.expect(0);
        assert!(!came.is_empty() && is_pipe(&folder.join(name)), "{flags:?}: {} bytes", came.len());
    }
    // More than a pipe holds, so that it is killed while it writes.
    make_pipe(&folder.join("pipe.exr"));
    let large = ["render", "tri.glb", "-o", "pipe.exr", "--size", "512x512", "--samples", "1", "--aov", "all"];
    let mut child = start(&folder, &large, Stdio::null());
    let (begun, begins) = std::sync::mpsc::channel();
    let path = folder.join("pipe.exr");
    std::thread::spawn(move || {
        let mut pipe = std::fs::File::open(path).expect("opened");
        let is_read = pipe.read_exact(&mut [0; 4]).is_ok();
        let _ = begun.send((pipe, is_read));
    });
    let pipe = begins.recv_timeout(Duration::from_secs(60));
    child.kill().and_then(|()| child.wait()).expect("killed");
    assert!(pipe.is_ok_and(|(_, is_read)| is_read), "nothing was written");
    assert!(is_pipe(&folder.join("pipe.exr")));
    assert!(!folder.names().iter().any(|name| name.ends_with(".partial")), "{:?}", folder.names());
}

/// Runs the program where the shell has set a limit; fails the test where it hangs, or a signal ends it.
fn limited(folder: &Folder, shell: &[&str], limit: &str, args: &str) -> Run {
    let line = format!("ulimit {limit} || exit 99; exec \"$0\" {args}");
    let mut words = [&["timeout", "-s", "KILL", "120"], shell, &["bash", "-c", line.as_str()]].concat();
    words.push(env!("CARGO_BIN_EXE_manypass"));
    let mut command = Command::new(words[0]);
    command.args(&words[1..]).current_dir(&**folder).env("MANYPASS_NO_CACHE", "1").stdin(Stdio::null());
    let run: Run = command.output().expect("it starts").into();
    let is_clear = run.code != 101 && !run.stderr.contains("panicked") && !run.stderr.contains("overflowed");
    assert!((0..=5).contains(&run.code) && is_clear, "{limit} {args}: {run:?}");
    run
}

const DRAW: &str = "render tri.glb --size 8x8 --samples 1 -q -o a.png";

#[test]
fn a_small_stack_is_an_error_or_enough() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("stacks");
    folder.write("tri.glb", &triangle_glb([1.0, 0.5, 0.0]));
    for kib in ["64", "128"] {
        let limit = format!("-s {kib}");
        let run = limited(&folder, &[], &limit, DRAW).expect(3);
        assert!(run.stderr.contains("ulimit -s") && run.stderr.contains(&format!("{kib} KiB")), "{}", run.stderr);
        // What needs no driver works.
        limited(&folder, &[], &limit, "info tri.glb").expect(0);
    }
    limited(&folder, &[], "-s 512", DRAW).expect(0);
}

#[test]
fn few_threads_are_an_error() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("threads");
    folder.write("tri.glb", &triangle_glb([1.0, 0.5, 0.0]));
    std::fs::set_permissions(&*folder, std::fs::Permissions::from_mode(0o777)).expect("allowed");
    // No limit binds root; where it cannot become another user, this one may be bound.
    let other = ["setpriv", "--reuid", "65534", "--regid", "65534", "--clear-groups"];
    let becomes = |shell: &[&str], of: &str| {
        let words = [shell, &["sh", "-c", of, env!("CARGO_BIN_EXE_manypass")]].concat();
        let run = Command::new(words[0]).args(&words[1..]).stderr(Stdio::null()).current_dir(&*folder).status();
        run.is_ok_and(|status| status.success())
    };
    let shell: &[&str] = if becomes(&other, "test -x \"$0\" && test -r tri.glb") { &other } else { &[] };
    if shell.is_empty() && becomes(&[], "test \"$(id -u)\" = 0") {
        manypass_testkit::needs::skip("root is bound by no limit of threads and cannot become another user");
        return;
    }
    for count in [1, 3, 4, 5] {
        let run = limited(&folder, shell, &format!("-u {count}"), DRAW).expect(3);
        assert!(run.stderr.contains("ulimit -u") && run.stderr.lines().count() == 2, "{count}: {}", run.stderr);
    }
    limited(&folder, shell, "-u 1", "info tri.glb").expect(0);
    limited(&folder, shell, "-u 1", "bake tri.glb -o b.glb --samples 1 --density 1 -q");
}
