//! Simulations and particles, from the command line to the file.

use crate::common::{Folder, Run, has_adapter, run_in};

const SMALL: [&str; 5] = ["--size", "64x36", "--samples", "1", "--no-cache"];

const STAGE: &str = "model = \"demo:laboratory\"\n\
    [[simulations]]\nname = \"waves\"\nprogram = \"ripples\"\ncells = [48, 32]\nbodies = [\"Ball\"]\n\
    parameters = { drops_per_s = 20 }\n\
    [[water]]\nnode = \"Water\"\nsimulation = \"waves\"\n\
    [[particles]]\npreset = \"rain\"\ncount = 500\ncenter = [0, 3, 0]\nsize_m = [3, 0, 3]\nmeets = \"Above\"\n";

fn render(folder: &Folder, args: &[&str]) -> Run {
    run_in(folder, &[&["render"], args, &SMALL].concat())
}

#[test]
fn a_time_is_the_same_picture_as_its_frame() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("simulated");
    std::fs::write(folder.join("a.stage.toml"), STAGE).expect("written");
    render(&folder, &["a.stage.toml", "--time", "2", "-o", "time.png", "--report", "time.json"]).expect(0);
    render(&folder, &["a.stage.toml", "--frames", "46..48", "-o", "f{frame}.png"]).expect(0);
    render(&folder, &["a.stage.toml", "--frames", "48..48", "-o", "alone{frame}.png"]).expect(0);
    let read = |name: &str| std::fs::read(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
    assert!(read("time.png") == read("f48.png") && read("time.png") == read("alone48.png"));
    assert!(read("f47.png") != read("f48.png"));
    let report: serde_json::Value = serde_json::from_slice(&read("time.json")).expect("JSON");
    let steps: Vec<_> =
        report["simulations"].as_array().expect("a list").iter().map(|one| (&one["name"], &one["steps"])).collect();
    assert_eq!(format!("{steps:?}"), "[(String(\"waves\"), Number(480)), (String(\"rain\"), Number(120))]");
}

#[test]
fn a_still_without_particles_gets_a_hint() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("unborn");
    let smoke = "[[particles]]\npreset = \"smoke\"\ncount = 9\ncenter = [0, 1, 0]\nsize_m = [1, 0, 1]\n";
    std::fs::write(folder.join("a.stage.toml"), format!("model = \"demo:laboratory\"\n{smoke}")).expect("written");
    std::fs::write(folder.join("b.stage.toml"), "model = \"demo:laboratory\"\n").expect("written");
    let hinted = |args: &[&str]| {
        let run = render(&folder, &[args, &["-o", "x.png"]].concat()).expect(0);
        run.stderr
            .contains("hint: a.stage.toml: its particles are born from time 0 on, and none is there yet; --time 5 ")
    };
    assert!(hinted(&["a.stage.toml"]) && hinted(&["a.stage.toml", "--time", "0"]));
    assert!(!hinted(&["b.stage.toml"]) && !hinted(&["a.stage.toml", "--time", "1"]));
}

#[test]
fn what_cannot_be_shown_says_so_and_leaves_nothing() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("unsimulated");
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).expect("written");
    write("a.stage.toml", STAGE);
    write("b.stage.toml", &STAGE.replace("drops_per_s", "drops"));
    write("c.stage.toml", &STAGE.replace("\"ripples\"", "\"own.wgsl\""));
    write("own.wgsl", "//! step: f -> a\n//! shows: waves\n\nfn f(cell: vec2i) -> vec4f { return b_at(cell); }\n");
    write("d.stage.toml", &STAGE.replace("drops_per_s = 20", "speed_m_s = 50, first_m = 0.1"));
    for (arguments, expected) in [
        (&["a.stage.toml", "--time", "1e9"][..], "`waves` cannot be shown: "),
        (&["b.stage.toml"], "drops"),
        (&["c.stage.toml"], "own.wgsl:4:37: error: "),
    ] {
        let run = render(&folder, &[arguments, &["-o", "x.png"]].concat());
        assert_ne!(run.code, 0, "{arguments:?}");
        assert!(run.stderr.contains(expected), "{}\nshould say {expected}", run.stderr);
        assert!(!folder.names().contains(&"x.png".to_owned()));
    }
    // What explodes is shown as far as it goes.
    let run = render(&folder, &["d.stage.toml", "--time", "1", "-o", "x.png"]);
    assert!(run.code == 0 && run.stderr.contains("the simulation `waves` exploded"), "{}", run.stderr);
}
