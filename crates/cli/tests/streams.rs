//! All pictures of a call in one stream: video, arrays and archives hold what files of their own hold.

use crate::common::{Folder, Run, has_adapter, run_in, triangle_glb};
use std::collections::BTreeMap;
use std::io::{Cursor, Read};

const SIZE: (usize, usize) = (32, 18);
const COMMON: [&str; 10] =
    ["--size", "32x18", "--samples", "1", "--background", "336699", "--ground", "none", "--orbit", "20,10,6"];

/// Renders three frames of a triangle that moves, with further arguments; they succeed.
#[track_caller]
fn render(folder: &Folder, args: &[&str]) -> Run {
    folder.write("tri.glb", &triangle_glb([1.0, 0.4, 0.1]));
    let frames = ["--frames", "0..2", "--fps", "4", "--quiet"];
    run_in(folder, &[&["render", "tri.glb"][..], args, &frames, &COMMON].concat()).expect(0)
}

/// The 8-bit pixels of a picture file.
fn pixels(folder: &Folder, name: &str) -> Vec<u8> {
    image::open(folder.join(name)).expect(name).to_rgba8().into_raw()
}

#[test]
fn a_sequence_is_video_on_standard_output() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("streams-y4m");
    let stream = render(&folder, &["-o", "-", "--format", "y4m"]).stdout;
    let header = b"YUV4MPEG2 W32 H18 F4:1 Ip A1:1 C444 XCOLORRANGE=LIMITED\n";
    assert!(stream.starts_with(header), "{}", String::from_utf8_lossy(&stream[..header.len().min(stream.len())]));
    let (pixel_count, start) = (SIZE.0 * SIZE.1, b"FRAME\n".len());
    assert_eq!(stream.len(), header.len() + 3 * (start + 3 * pixel_count));
    let frame = |index: usize| &stream[header.len() + index * (start + 3 * pixel_count)..][..start + 3 * pixel_count];
    assert!((0..3).all(|index| frame(index).starts_with(b"FRAME\n")));
    assert!(frame(0) != frame(2), "the triangle moves");
    // One frame alone, as a picture.
    let alone = ["render", "tri.glb", "--frames", "0..0", "--fps", "4", "--quiet", "-o", "{frame}.png"];
    run_in(&folder, &[&alone[..], &COMMON].concat()).expect(0);
    let luma = &frame(0)[start..start + pixel_count];
    for (at, (pixel, found)) in pixels(&folder, "0.png").chunks_exact(4).zip(luma).enumerate() {
        let [red, green, blue] = [pixel[0], pixel[1], pixel[2]].map(|value| f64::from(value) / 255.0);
        let expected = 16.0 + 219.0 * (0.2126 * red + 0.7152 * green + 0.0722 * blue);
        assert!((f64::from(*found) - expected).abs() <= 1.0, "pixel {at}: {found} is not {expected}");
    }
    // A file holds the same.
    assert!(render(&folder, &["-o", "clip.y4m"]).stdout.is_empty());
    assert!(std::fs::read(folder.join("clip.y4m")).expect("written") == stream);
    assert_eq!(folder.names(), ["0.png", "clip.y4m", "tri.glb"]);
}

/// The header and the numbers of an array.
fn array(archive: &[u8], name: &str) -> (String, Vec<u8>) {
    let mut archive = zip::ZipArchive::new(Cursor::new(archive)).expect("an archive");
    let mut bytes = Vec::new();
    // Reading to the end checks the sum.
    archive.by_name(name).expect(name).read_to_end(&mut bytes).expect(name);
    assert!(bytes.starts_with(b"\x93NUMPY\x01\x00"), "{name}");
    let data = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    assert!(data.is_multiple_of(64));
    (String::from_utf8_lossy(&bytes[10..data]).trim_end().to_owned(), bytes.split_off(data))
}

#[test]
fn a_sequence_is_arrays_of_numbers() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("streams-npz");
    let flags = ["--aov", "depth,object_id,normal"];
    let stream = render(&folder, &[&["-o", "-", "--format", "npz"][..], &flags].concat()).stdout;
    render(&folder, &[&["-o", "data.npz"][..], &flags].concat());
    assert!(std::fs::read(folder.join("data.npz")).expect("written") == stream);
    render(&folder, &["-o", "{frame}.png"]);
    let shape = |kind: &str, components: usize| {
        format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': (3, 18, 32, {components}), }}")
    };
    let (header, frames) = array(&stream, "frames.npy");
    assert_eq!(header, shape("|u1", 4));
    let expected: Vec<u8> = ["0.png", "1.png", "2.png"].iter().flat_map(|name| pixels(&folder, name)).collect();
    assert!(frames == expected, "the display is that of files");
    let (header, depth) = array(&stream, "depth.npy");
    assert_eq!((header, depth.len()), (shape("<f4", 1), 3 * SIZE.0 * SIZE.1 * 4));
    let (header, ids) = array(&stream, "object_id.npy");
    assert_eq!((header, ids.len()), (shape("<u4", 1), depth.len()));
    let (header, normals) = array(&stream, "normal.npy");
    assert_eq!((header, normals.len()), (shape("<f4", 3), 3 * depth.len()));
    let mut seen = 0;
    for (depth_m, id) in depth.chunks_exact(4).zip(ids.chunks_exact(4)) {
        let depth_m = f32::from_le_bytes(depth_m.try_into().expect("four bytes"));
        let id = u32::from_le_bytes(id.try_into().expect("four bytes"));
        assert_eq!(depth_m.is_finite(), id == 1, "{depth_m} m of {id}");
        assert!(id == 0 || (4.0..8.0).contains(&depth_m), "{depth_m} m");
        seen += id;
    }
    assert!(seen > 30, "{seen} pixels of the triangle");
}

#[test]
fn a_still_is_an_array_of_one() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("streams-still");
    folder.write("tri.glb", &triangle_glb([1.0, 0.4, 0.1]));
    run_in(&folder, &[&["render", "tri.glb", "-o", "still.npz"][..], &COMMON].concat()).expect(0);
    let (header, data) = array(&std::fs::read(folder.join("still.npz")).expect("written"), "frames.npy");
    assert!(header.contains("(1, 18, 32, 4)"), "{header}");
    assert_eq!(data.len(), SIZE.0 * SIZE.1 * 4);
}

/// The files of a tar, by name; every header's sum is checked.
fn members(archive: &[u8]) -> BTreeMap<String, Vec<u8>> {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim_matches(['\0', ' ']).to_owned();
    let octal = |bytes: &[u8]| usize::from_str_radix(&text(bytes), 8).expect("octal digits");
    let (mut members, mut at) = (BTreeMap::new(), 0);
    while archive[at] != 0 {
        let header = &archive[at..at + 512];
        let sum: usize = header.iter().map(|byte| usize::from(*byte)).sum();
        let of_sum: usize = header[148..156].iter().map(|byte| usize::from(*byte)).sum();
        assert_eq!(octal(&header[148..156]), sum - of_sum + 8 * usize::from(b' '));
        assert_eq!((octal(&header[100..108]), octal(&header[136..148])), (0o644, 0), "mode and time");
        let length = octal(&header[124..136]);
        members.insert(text(&header[..100]), archive[at + 512..at + 512 + length].to_vec());
        at += 512 + length.next_multiple_of(512);
    }
    assert_eq!(archive[at..], [0; 1024]);
    members
}

#[test]
fn a_tar_holds_the_files_of_a_folder() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("streams-tar");
    for (flags, ending) in [(&["--aov", "depth"][..], "exr"), (&["--variant", "all"], "png")] {
        let out = format!("{ending}/");
        render(&folder, &[flags, &["-o", &out, "--format", ending]].concat());
        let stream = render(&folder, &[flags, &["-o", "-", "--format", "tar"]].concat()).stdout;
        let members = members(&stream);
        let mut names: Vec<String> = std::fs::read_dir(folder.join(ending))
            .expect("listed")
            .map(|entry| entry.expect("entry").file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        assert_eq!(members.keys().collect::<Vec<_>>(), names.iter().collect::<Vec<_>>());
        assert_eq!(names.len(), 3);
        for (name, bytes) in &members {
            let file = std::fs::read(folder.join(&format!("{ending}/{name}"))).expect(name);
            assert!(file == *bytes, "{name}");
        }
    }
}

#[test]
fn several_inputs_are_one_stream_and_its_report_has_lines() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("streams-batch");
    folder.write("in/a.glb", &triangle_glb([1.0, 0.0, 0.0]));
    folder.write("in/b.glb", &triangle_glb([0.0, 1.0, 0.0]));
    folder.write("in/broken.glb", b"nothing");
    let flags = ["render", "in/", "-o", "all.tar", "--report", "r.jsonl", "--quiet"];
    run_in(&folder, &[&flags[..], &COMMON].concat()).expect(1);
    let members = members(&std::fs::read(folder.join("all.tar")).expect("those that can be drawn"));
    assert_eq!(members.keys().collect::<Vec<_>>(), ["a.png", "b.png"]);
    let report = std::fs::read_to_string(folder.join("r.jsonl")).expect("a report");
    assert_eq!((report.lines().count(), report.matches("\"output\":\"all.tar\"").count()), (3, 2), "{report}");
}

#[test]
fn what_a_stream_cannot_hold_is_wrong_usage() {
    let folder = Folder::new("streams-usage");
    for (flags, said) in [
        (&["--frames", "0..1", "-o", "-", "--format", "png"][..], "--format y4m (video), npz (arrays) or tar (files)"),
        (&["--frames", "0..1", "-o", "-", "--format", "exr"], "--format y4m (video), npz (arrays) or tar (files)"),
        (&["-o", "-", "--format", "y4m", "--background", "transparent"], "y4m has no transparency"),
        (&["-o", "-", "--format", "y4m", "--aov", "depth"], "y4m holds no AOVs"),
        (&["-o", "{stem}.y4m"], "has a placeholder"),
        (&["-o", "out/", "--format", "npz"], "name the file: -o out/pictures.npz"),
        (&["-o", "a.npz", "--format", "tar"], "disagree"),
        (&["-o", "a.tar", "--skip-existing"], "--skip-existing"),
        (&["--format", "tar"], "-o - for standard output"),
        (&["-o", "-", "--format", "tar", "--report", "-"], "standard output takes the pictures or the report"),
    ] {
        let run = run_in(&folder, &[&["render", "a.glb"][..], flags].concat()).expect(2);
        assert!(run.stderr.contains(said), "{flags:?}: {}", run.stderr);
    }
    assert!(folder.names().is_empty());
}

#[cfg(unix)]
#[test]
fn a_reader_that_closes_and_an_interrupt_leave_nothing() {
    use crate::common::watch::{start, wait};
    use std::time::{Duration, Instant};
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("streams-ends");
    folder.write("tri.glb", &triangle_glb([1.0, 0.4, 0.1]));
    let script =
        "\"$0\" render tri.glb --frames 0..100000 --size 64x64 --samples 1 -o - --format y4m | head -c 9 >/dev/null";
    let mut command = std::process::Command::new("bash");
    command.args(["-c", &format!("{script}; exit ${{PIPESTATUS[0]}}"), env!("CARGO_BIN_EXE_manypass")]);
    let run: Run = command.current_dir(&*folder).output().expect("bash runs").into();
    assert!(run.code == 1 && run.stderr.contains("its reader has closed it"), "{run:?}");

    let args = ["render", "tri.glb", "--frames", "0..100000", "-o", "clip.y4m", "--quiet"];
    let child = start(&folder, &[&args[..], &COMMON].concat());
    let begun = Instant::now();
    while !folder.names().iter().any(|name| name.ends_with(".partial")) {
        assert!(begun.elapsed() < Duration::from_secs(60), "no file appears");
        std::thread::sleep(Duration::from_millis(10));
    }
    let kill = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(kill.expect("kill runs").success());
    wait(child, Duration::from_secs(60)).run.expect(130);
    assert_eq!(folder.names(), ["tri.glb"]);
}
