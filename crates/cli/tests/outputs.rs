//! Outputs that cannot be written, pictures that are too large, and interrupts: one error, and nothing left behind.

mod common;

use common::watch::{WatchedRun, start, wait, watch};
use common::{Folder, Run, has_adapter, run_in, run_with, triangle_glb};
use std::path::Path;
use std::time::{Duration, Instant};

const SMALL: [&str; 4] = ["--size", "16x16", "--samples", "1"];

/// Renders a triangle with further arguments; the run ends with `code` and, unless that is 0, with one error.
#[track_caller]
fn render(folder: &Folder, args: &[&str], code: i32) -> Run {
    folder.write("tri.glb", &triangle_glb([1.0, 0.5, 0.0]));
    let run = run_in(folder, &[&["render", "tri.glb"], args].concat()).expect(code);
    let errors = run.stderr.lines().filter(|line| line.starts_with("error: ")).count();
    assert_eq!(errors, usize::from(code != 0), "{}", run.stderr);
    assert!(!run.stderr.contains("panicked"), "{}", run.stderr);
    run
}

#[test]
fn sizes_that_cannot_be_are_wrong_usage() {
    let folder = Folder::new("sizes");
    for size in ["0x0", "0x16", "16x0", "1000000000x1000000000", "16385x1", "-1x4", "4294967297x4", "1.5x2", "x", ""] {
        let run = render(&folder, &[&format!("--size={size}")], 2);
        assert!(run.stderr.contains("is not a size"), "{size}: {}", run.stderr);
    }
    assert_eq!(folder.names(), ["tri.glb"]);
}

#[test]
fn an_adapter_that_is_not_there_ends_with_3() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("adapter");
    let run = render(&folder, &[&SMALL[..], &["--adapter", "Voodoo 2"]].concat(), 3);
    assert!(run.stderr.contains("Voodoo 2") && run.stderr.contains("manypass adapters"), "{}", run.stderr);
    assert_eq!(folder.names(), ["tri.glb"]);
}

#[test]
fn a_place_that_cannot_be_written_is_named() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("places");
    folder.write("file", b"");
    std::fs::create_dir(folder.join("folder.png")).expect("a folder");
    let mut places = vec!["file/a.png", "folder.png/", "file/deep/"];
    if cfg!(target_os = "linux") {
        // Nobody makes files there, not even the superuser.
        places.extend(["/proc/a.png", "/proc/deep/a.png"]);
    }
    for place in places {
        let code = i32::from(place != "folder.png/");
        let run = render(&folder, &[&SMALL[..], &["-o", place]].concat(), code);
        assert!(code == 0 || run.stderr.contains("hint: "), "{}", run.stderr);
    }
    for flag in ["--report", "--contact-sheet", "--dump-passes"] {
        let run = render(&folder, &[&SMALL[..], &[flag, "file/a.png"]].concat(), 1);
        assert!(run.stderr.contains("file"), "{flag}: {}", run.stderr);
    }
    assert_eq!(folder.names(), ["file", "folder.png", "tri.glb", "tri.png"]);
    assert_eq!(std::fs::read(folder.join("file")).expect("there"), b"");
}

#[cfg(unix)]
#[test]
fn a_folder_without_permission_is_named() {
    use std::os::unix::fs::PermissionsExt;
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("permission");
    let locked = folder.join("locked");
    std::fs::create_dir(&locked).expect("a folder");
    std::fs::set_permissions(&locked, std::fs::Permissions::from_mode(0o555)).expect("locked");
    // The superuser may write everywhere.
    if std::fs::write(locked.join("probe"), b"").is_ok() {
        manypass_testkit::needs::skip("this user may write everywhere");
        return;
    }
    let run = render(&folder, &[&SMALL[..], &["-o", "locked/a.png"]].concat(), 1);
    assert!(run.stderr.contains("no permission to write locked/a.png"), "{}", run.stderr);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_named_and_its_device_stays() {
    use std::os::unix::fs::{FileTypeExt, symlink};
    use std::process::{Command, Stdio};
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("full");
    symlink("/dev/full", folder.join("full.png")).expect("linked");
    let run = render(&folder, &[&SMALL[..], &["-o", "full.png"]].concat(), 1);
    assert!(run.stderr.contains("no space left to write full.png"), "{}", run.stderr);
    assert_eq!(folder.names(), ["full.png", "tri.glb"]);
    assert!(std::fs::metadata("/dev/full").expect("there").file_type().is_char_device());

    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").expect("opened");
    let mut command = Command::new(env!("CARGO_BIN_EXE_manypass"));
    command.args(["render", "tri.glb", "-o", "-", "--format", "png"]).args(SMALL).current_dir(&*folder);
    let run: Run = command.stdout(full).stdin(Stdio::null()).output().expect("run").into();
    assert!(run.code == 1 && run.stderr.starts_with("error: no space left to write standard output"), "{run:?}");
}

#[test]
fn a_format_that_is_given_is_written_under_any_name() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("format");
    let run = render(&folder, &[&SMALL[..], &["-o", "a.foo", "--format", "png", "--aov", "depth"]].concat(), 0);
    assert!(run.stderr.is_empty(), "{}", run.stderr);
    assert_eq!(folder.names(), ["a.depth.png", "a.foo", "tri.glb"]);
    assert!(std::fs::read(folder.join("a.foo")).expect("there").starts_with(b"\x89PNG"));
}

/// What an interrupted call says.
const INTERRUPTED: &str =
    "interrupting after this step, within 2 s; once more stops at once\nerror: interrupted\nhint: ";

/// Waits until the report's temporary file is there: from then on the program has its renderer and heeds signals.
fn wait_until_it_renders(folder: &Folder) {
    let start = Instant::now();
    while !folder.names().iter().any(|name| name.ends_with(".partial")) {
        assert!(start.elapsed() < Duration::from_secs(60), "it does not start: {:?}", folder.names());
        std::thread::sleep(Duration::from_millis(10));
    }
}

#[cfg(unix)]
fn send(signal: &str, process: u32) {
    let status = std::process::Command::new("kill").args([signal, &process.to_string()]).status();
    assert!(status.expect("kill runs").success());
}

/// The folder and the run of a call that was interrupted, with `args` behind those of a slow picture. On a busy machine
/// it may not notice in time, and ends without a report: that is right, and tried again. One of twelve has to notice.
#[cfg(unix)]
fn interrupted(name: &str, signal: &str, args: &[&str], prepare: impl Fn(&Folder)) -> (Folder, Run) {
    for _ in 0..12 {
        let folder = Folder::new(name);
        prepare(&folder);
        let slow = ["render", "demo:hall", "-o", "out/a.png", "--size", "64x36", "--samples", "65536"];
        let child = start(&folder, &[&slow[..], args, &["--report", "report.json"]].concat());
        wait_until_it_renders(&folder);
        std::thread::sleep(Duration::from_millis(1000));
        send(signal, child.id());
        let WatchedRun { run, time, .. } = wait(child, Duration::from_secs(60));
        assert_eq!(run.code, 130, "{run:?}");
        assert!(folder.names().iter().all(|name| name == "report.json"), "{:?}", folder.names());
        let is_told = std::fs::read(folder.join("report.json")).is_ok_and(|report| report.len() > 2);
        if is_told || time <= Duration::from_millis(1300) {
            return (folder, run);
        }
    }
    panic!("twelve times it did not notice the signal within 1.3 s");
}

#[cfg(unix)]
#[test]
fn an_interrupt_leaves_no_partial_file() {
    if !has_adapter() {
        return;
    }
    let none: &[&str] = &[];
    for (signal, extra) in [("-INT", none), ("-TERM", none), ("-INT", &["--aov", "all"][..])] {
        let (folder, run) = interrupted(&format!("interrupt{signal}{}", extra.len()), signal, extra, |_| {});
        assert!(run.stderr.starts_with(INTERRUPTED), "{run:?}");
        // The report is whole: it says that the picture was interrupted.
        assert_eq!(folder.names(), ["report.json"]);
        let report = std::fs::read_to_string(folder.join("report.json")).expect("report");
        let report: serde_json::Value = serde_json::from_str(&report).expect("JSON");
        assert_eq!(report["error"], "interrupted");
        assert!(report["frame"].is_null() && report["version"].is_string(), "{report}");
    }
}

#[cfg(unix)]
#[test]
fn an_interrupt_keeps_the_report_of_an_earlier_call() {
    if !has_adapter() {
        return;
    }
    let earlier = |folder: &Folder| folder.write("report.json", b"{}");
    let (folder, run) = interrupted("interrupt-report", "-INT", &["--quiet"], earlier);
    assert!(run.stderr.starts_with("error: interrupted\n"), "{run:?}");
    assert_eq!(std::fs::read(folder.join("report.json")).expect("read"), b"{}");
    assert_eq!(folder.names(), ["report.json"]);
}

/// Runs a command line of the shell in `folder`, with the program as `$0`.
#[cfg(unix)]
fn shell(folder: &Folder, script: &str) -> Run {
    let mut command = std::process::Command::new("bash");
    command.args(["-c", script, env!("CARGO_BIN_EXE_manypass")]).current_dir(&**folder);
    command.output().expect("bash runs").into()
}

#[cfg(unix)]
#[test]
fn devices_pipes_and_open_files_take_pictures() {
    use std::os::unix::fs::FileTypeExt;
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("devices");
    render(&folder, &SMALL, 0);
    let expected = std::fs::read(folder.join("tri.png")).expect("written");
    let exr = b"\x76\x2f\x31\x01";
    let render = "\"$0\" render tri.glb --size 16x16 --samples 1 -o";
    for (output, name) in [
        ("/dev/null", ""),
        ("/dev/null --frames 0..1 --skip-existing", ""),
        ("/dev/stdout --format png > a.png", "a.png"),
        (">(cat > b.png) --format png; wait $!", "b.png"),
        ("/dev/fd/5 --format png 5> c.png", "c.png"),
        ("pipe.exr --aov depth", "d.exr"),
    ] {
        let before = if name == "d.exr" { "mkfifo pipe.exr && (cat pipe.exr > d.exr &) && " } else { "" };
        shell(&folder, &format!("{before}{render} {output}")).expect(0);
        let begun = Instant::now();
        let is_right = || match std::fs::read(folder.join(name)) {
            _ if name.is_empty() => true,
            Ok(bytes) if name.ends_with(".exr") => bytes.starts_with(exr),
            bytes => bytes.is_ok_and(|bytes| bytes == expected),
        };
        // What reads from the pipe ends by itself.
        while !is_right() {
            assert!(begun.elapsed() < Duration::from_secs(10), "{output}");
            std::thread::sleep(Duration::from_millis(10));
        }
    }
    shell(&folder, &format!("{render} /dev/null --aov depth")).expect(2);
    assert!(std::fs::metadata("/dev/null").expect("there").file_type().is_char_device());
    assert!(!Path::new("/dev/null.depth.png").exists());
    assert_eq!(folder.names(), ["a.png", "b.png", "c.png", "d.exr", "pipe.exr", "tri.glb", "tri.png"]);
}

#[cfg(unix)]
#[test]
fn a_limit_for_files_and_closed_readers_are_errors() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("limits");
    folder.write("tri.glb", &triangle_glb([1.0, 0.5, 0.0]));
    let render = "\"$0\" render tri.glb --size 64x64 --samples 1";
    for script in
        ["ulimit -f 1; R -o a.exr", "ulimit -f 1; R -o a.exr --aov depth", "ulimit -f 1; R --report - > r.json"]
    {
        let run = shell(&folder, &script.replace('R', render));
        let named = run.stderr.contains("ulimit -f") && run.stderr.lines().count() == 2;
        assert!(run.code == 1 && named, "{script}: {run:?}");
    }
    for script in ["R -o - --format exr | true", "R -o a.png --report - | true"] {
        let run = shell(&folder, &format!("{}; exit ${{PIPESTATUS[0]}}", script.replace('R', render)));
        assert!(run.code == 1 && run.stderr.contains("its reader has closed it"), "{script}: {run:?}");
    }
    for script in ["R --time -o 2>&1 | true", "R gone.glb -o x/ 2>/dev/full"] {
        let run = shell(&folder, &format!("{}; exit ${{PIPESTATUS[0]}}", script.replace('R', render)));
        assert!(run.code == 2 || run.code == 1, "nobody reads the errors: {script}: {run:?}");
    }
    // The shell made `r.json`; of what failed there is nothing.
    assert_eq!(folder.names(), ["a.png", "r.json", "tri.glb", "x"]);
}

#[cfg(unix)]
#[test]
fn an_interrupt_while_a_file_is_encoded_leaves_nothing() {
    if !has_adapter() {
        return;
    }
    for (signal, extra) in
        [("-INT", &["-o", "out/a.exr", "--aov", "all"][..]), ("-HUP", &["-o", "out/a.png", "--aov", "all"])]
    {
        let folder = Folder::new(&format!("encoding{signal}"));
        let args = ["render", "demo:hall", "--size", "768x768", "--samples", "1", "--light-culling", "clustered"];
        let child = start(&folder, &[&args[..], extra].concat());
        let begun = Instant::now();
        let is_encoding = || std::fs::read_dir(folder.join("out")).is_ok_and(|mut entries| entries.next().is_some());
        while !is_encoding() {
            assert!(begun.elapsed() < Duration::from_secs(60), "no file appears");
            std::thread::sleep(Duration::from_millis(1));
        }
        send(signal, child.id());
        let run = wait(child, Duration::from_secs(60)).run.expect(130);
        assert!(run.stderr.starts_with(INTERRUPTED), "{}", run.stderr);
        assert_eq!(std::fs::read_dir(folder.join("out")).expect("listed").count(), 0);
    }
}

#[cfg(unix)]
#[test]
fn an_interrupt_ends_the_wait_for_a_reader() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("reader");
    folder.write("tri.glb", &triangle_glb([1.0, 0.5, 0.0]));
    shell(&folder, "mkfifo pipe.png").expect(0);
    let child = start(&folder, &[&["render", "tri.glb", "-o", "pipe.png"], &SMALL[..]].concat());
    // The program has its picture by then; where it has not, it is stopped before it waits.
    std::thread::sleep(Duration::from_secs(2));
    send("-TERM", child.id());
    let run = wait(child, Duration::from_secs(10)).run.expect(130);
    assert!(run.stderr.starts_with("error: interrupted\nhint: "), "{}", run.stderr);
    assert_eq!(folder.names(), ["pipe.png", "tri.glb"]);
}

#[cfg(unix)]
#[test]
fn an_interrupted_batch_keeps_what_is_done() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("interrupt-batch");
    for name in ["a.glb", "b.glb"] {
        folder.write(name, &triangle_glb([1.0, 1.0, 1.0]));
    }
    let args = ["render", "a.glb", "b.glb", "-o", "out/", "--size", "16x16", "--samples", "1", "--report", "r.jsonl"];
    let frames = ["--frames", "0..100000", "--quiet"];
    let child = start(&folder, &[&args[..], &frames].concat());
    let first = folder.join("out/a_0000.png");
    let start = Instant::now();
    while !first.exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "no picture appears");
        std::thread::sleep(Duration::from_millis(10));
    }
    send("-INT", child.id());
    wait(child, Duration::from_secs(60)).run.expect(130);
    let pictures: Vec<_> =
        std::fs::read_dir(folder.join("out")).expect("listed").map(|e| e.expect("entry").path()).collect();
    assert!(pictures.iter().all(|path| is_whole(path)), "{pictures:?}");
    assert_eq!(folder.names(), ["a.glb", "b.glb", "out", "r.jsonl"]);
}

fn is_whole(path: &Path) -> bool {
    path.extension().is_some_and(|end| end == "png") && image::open(path).is_ok()
}

#[cfg(unix)]
#[test]
fn endless_standard_input_is_refused() {
    use std::io::Write;
    use std::process::{Command, Stdio};
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("endless");
    let mut command = Command::new(env!("CARGO_BIN_EXE_manypass"));
    command.args(["render", "-", "-o", "a.png"]).args(SMALL).current_dir(&*folder);
    let mut child = command.stdin(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program starts");
    let mut pipe = child.stdin.take().expect("piped");
    let block = vec![0; 1 << 20];
    // The program stops reading after a gibibyte, and then the pipe breaks.
    let written = (0..1 << 12).take_while(|_| pipe.write_all(&block).is_ok()).count();
    drop(pipe);
    let run: Run = child.wait_with_output().expect("the program ends").into();
    assert!(written < 1 << 12 && run.code == 1 && run.stderr.contains("larger than 1 GiB"), "{written}: {run:?}");
    assert!(folder.names().is_empty());
}

#[test]
fn more_samples_take_no_more_memory() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("samples");
    folder.write("tri.glb", &triangle_glb([1.0, 1.0, 1.0]));
    for (input, path) in [("tri.glb", "deferred"), ("tri.glb", "forward"), ("demo:hall", "deferred")] {
        let peak_mib = |samples| {
            let size = ["--size", "32x32", "--quiet", "--path", path];
            let args = [&["render", input, "-o", "a.png", "--samples", samples], &size[..]].concat();
            let watched = watch(&folder, &args, Duration::from_secs(60));
            watched.run.expect(0);
            watched.peak_mib
        };
        // Some memory is only taken once frames overlap; a megabyte lost with every frame would show.
        let (few, many) = (peak_mib("16"), peak_mib("112"));
        assert!(many < few + 64, "{input} {path}: {few} MiB, then {many} MiB");
    }
}

#[cfg(unix)]
#[test]
fn lists_may_be_read_in_part() {
    let folder = Folder::new("lists");
    for words in ["settings", "settings --json", "settings --schema", "settings --stage-schema"] {
        let run = shell(&folder, &format!("\"$0\" {words} | true; exit ${{PIPESTATUS[0]}}"));
        assert!(run.code == 0 && run.stderr.is_empty(), "{words}: {run:?}");
    }
    let full = shell(&folder, "\"$0\" settings > /dev/full");
    assert!(full.code == 1 && full.stderr.contains("no space left"), "{full:?}");
}

#[test]
fn a_cache_that_cannot_be_written_is_told_once() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("unwritable-cache");
    folder.write("tri.glb", &triangle_glb([1.0, 0.5, 0.0]));
    // In the way of a folder even for root, who may write into folders that are read-only for others.
    folder.write("file", b"in the way");
    // Mesa's own cache stays where it is, so that shaders need not be compiled again.
    let of_driver = format!("{}/.cache", std::env::var("HOME").unwrap_or_default());
    let notes = |place: &str, flags: &[&str]| {
        let args = [&["render", "tri.glb", "-o", "out/", "--frames", "0..1"], &SMALL[..], flags].concat();
        let place = folder.join(place).display().to_string();
        let variables =
            [("XDG_CACHE_HOME", &*place), ("MANYPASS_NO_CACHE", ""), ("MESA_SHADER_CACHE_DIR", &*of_driver)];
        let run = run_with(&folder, &args, &variables).expect(0);
        assert!(folder.join("out/tri_0001.png").exists(), "{place} {flags:?}");
        run.stderr.lines().filter(|line| line.contains("nothing is kept")).map(str::to_owned).collect::<Vec<_>>()
    };
    // What is below the folder that is named is made, where it can be.
    for place in ["file", "file/below"] {
        let told = notes(place, &["--strict"]);
        let is_clear =
            |note: &String| ["note: ", place, "XDG_CACHE_HOME", "--no-cache"].iter().all(|word| note.contains(word));
        assert!(told.len() == 1 && told.iter().all(is_clear), "{place}: {told:?}");
    }
    assert!(notes("file", &["--no-cache"]).is_empty() && notes("file", &["--quiet"]).is_empty());
    assert!(notes("absent/below", &[]).is_empty());
}
