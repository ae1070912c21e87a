//! Older names of stages, settings and built-in scenes: they draw the same as the names of today, and are told of once,
//! as a hint that `--strict` does not refuse.

use crate::common::{Folder, has_adapter, run_in, triangle_glb};
use manypass_scene::renamed::{NameChange, NameKind, RENAMED};

const SMALL: [&str; 8] = ["--size", "32x32", "--samples", "1", "--orbit", "0,0,4", "--target", "0,0,0"];

/// What no notice of a name is without.
const NOTICE: &str = "is now called";

fn folder(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.write("m.glb", &triangle_glb([1.0, 0.5, 0.2]));
    folder
}

/// A stage with a lamp and a reflection probe, in a list of tables called `table`, with `more` keys.
fn stage(table: &str, more: &str) -> String {
    format!(
        "model = \"m.glb\"\n[environment]\ncolor = \"404040\"\n[settings.exposure]\nstops = 0\n[[lights]]\n\
         kind = \"point\"\nposition = [0, 0, 2]\nintensity = 12\n[[{table}]]\ncenter = [0, 0, 0]\n\
         size_m = [6, 6, 6]\nposition = [0, 0, 1]\n{more}"
    )
}

/// A new row of the table has no use here yet.
fn unused(row: &NameChange) -> ! {
    panic!("say here how `{}` is used", row.older)
}

/// The arguments that use `name`, which is one of the two names of `row`: the input first.
fn using(folder: &Folder, row: &NameChange, name: &str) -> Vec<String> {
    let of_stage = |text: String| {
        folder.write("a.stage.toml", text.as_bytes());
        vec!["a.stage.toml".to_owned()]
    };
    match row.kind {
        NameKind::StageTable => of_stage(stage(name, "")),
        NameKind::StageKey(table) => {
            let keys = match row.older {
                "walls" => format!("{name} = false\n"),
                "walls_center" => format!("{name} = [0, 0, 1]\nparallax_size_m = [8, 8, 8]\n"),
                "walls_size_m" => format!("{name} = [9, 9, 9]\nparallax_center = [0, 0, 1]\n"),
                _ => unused(row),
            };
            of_stage(stage(table, &keys))
        }
        NameKind::Setting => {
            let value = if row.older == "shadows.turns" { "false" } else { unused(row) };
            [of_stage(stage("reflection_probes", "")), vec!["--set".into(), format!("{name}={value}")]].concat()
        }
        NameKind::Demo => vec![format!("demo:{name}")],
    }
}

/// Fails unless the notice of `row` was printed once for an older name, and no notice for that of today.
#[track_caller]
fn assert_told(stderr: &str, subject: &str, row: &NameChange, is_older: bool) {
    let notice = format!("hint: {subject}: {row}\n");
    assert!(notice.contains(&format!("`{}`", row.written(row.name))), "{notice}");
    assert_eq!(stderr.matches(&notice).count(), usize::from(is_older), "{notice}{stderr}");
    assert_eq!(stderr.matches(NOTICE).count(), usize::from(is_older), "{notice}{stderr}");
}

#[test]
fn older_names_plan_the_same_frame_and_are_told_of() {
    let folder = folder("older-plans");
    for row in &RENAMED {
        let plans = [row.older, row.name].map(|name| {
            let used = using(&folder, row, name);
            let used: Vec<&str> = used.iter().map(String::as_str).collect();
            let run = run_in(&folder, &[&["graph"][..], &used, &["--limits", "webgl2"]].concat()).expect(0);
            assert_told(&run.stderr, used[0], row, name == row.older);
            run.text()
        });
        assert!(plans[0] == plans[1] && !plans[0].is_empty(), "{row}");
    }
}

#[test]
fn older_names_draw_the_same_picture_and_are_no_warnings() {
    if !has_adapter() {
        return;
    }
    let folder = folder("older-pictures");
    for row in &RENAMED {
        let pictures = [(row.older, "older.png"), (row.name, "now.png")].map(|(name, file)| {
            let used = using(&folder, row, name);
            let used: Vec<&str> = used.iter().map(String::as_str).collect();
            let to_files = ["-o", file, "--report", "report.json", "--strict"];
            let run = run_in(&folder, &[&["render"][..], &used, &to_files, &SMALL].concat()).expect(0);
            assert_told(&run.stderr, used[0], row, name == row.older);
            let text = std::fs::read_to_string(folder.join("report.json")).expect("a report");
            let report: serde_json::Value = serde_json::from_str(&text).expect("JSON");
            let is_told = |key: &str| report[key].to_string().contains(NOTICE);
            assert_eq!((is_told("hints"), is_told("warnings")), (name == row.older, false), "{row}\n{report}");
            image::open(folder.join(file)).expect("a picture").to_rgba8()
        });
        assert!(pictures[0] == pictures[1], "{row}");
    }
}

#[test]
fn a_run_tells_of_a_name_once() {
    if !has_adapter() {
        return;
    }
    let folder = folder("older-batch");
    for name in ["in/a.stage.toml", "in/b.stage.toml"] {
        let text = stage("surroundings", "").replace("m.glb", "../m.glb");
        folder.write(name, format!("{text}[settings.shadows]\nturns = false\n").as_bytes());
    }
    folder.write("my.toml", b"[shadows]\nturns = false\n");
    let call = ["render", "in", "-o", "out/{stem}.png", "--settings", "my.toml"];
    let run = run_in(&folder, &[&call[..], &SMALL].concat()).expect(0);
    assert_eq!(run.stderr.matches(NOTICE).count(), 2, "a table and a setting: {}", run.stderr);
    assert!(run.stderr.contains("hint: in/a.stage.toml: `shadows.turns` is now called"), "{}", run.stderr);
    let quiet = run_in(&folder, &[&call[..], &SMALL, &["--quiet"]].concat()).expect(0);
    assert_eq!(quiet.stderr, "");
}

#[test]
fn settings_are_printed_by_the_name_of_today() {
    let folder = folder("older-settings");
    let run = run_in(&folder, &["settings", "--set", "shadows.turns=false"]).expect(0);
    assert_eq!(run.text(), "shadows.spread_over_samples = false\n");
    assert!(run.stderr.starts_with("hint: --set: `shadows.turns` is now called"), "{}", run.stderr);
    let info = run_in(&folder, &["info", "demo:surroundings"]).expect(0);
    assert!(info.stderr.starts_with("hint: demo:surroundings: `demo:surroundings` is now"), "{}", info.stderr);
}
