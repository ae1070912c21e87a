use super::*;
use crate::args::{Cli, Command};
use crate::camera::Place;
use clap::Parser;
use glam::DVec3;

fn job(flags: &[&str]) -> Result<Job, Failure> {
    let cli = Cli::try_parse_from(["manypass", "render", "a.glb"].iter().chain(flags));
    match cli.map_err(|error| Failure::usage(error, ""))?.command {
        Command::Render(args) => {
            let job = Job::new(&args, false, &["depth", "normal"])?;
            let chosen = crate::chosen::SettingsChoice::of_frame(&args.frame)?;
            let (settings, _) = chosen.settings(Settings::default(), None)?;
            job.check(&settings)?;
            check_settings(&settings)?;
            Ok(job)
        }
        _ => Err(Failure::usage("not render", "")),
    }
}

#[test]
fn lists_may_begin_with_a_minus() {
    let orbit = Place::Orbit { yaw_deg: -30.0, pitch_deg: 10.0, radius_m: Some(2.0) };
    assert_eq!(job(&["--orbit", "-30,10,2"]).expect("two words").look.camera.place, orbit);
    assert_eq!(job(&["--orbit=-30,10,2"]).expect("one word").look.camera.place, orbit);
    assert_eq!(job(&["--eye", "-1,2,-3"]).expect("eye").look.camera.place, Place::Eye(DVec3::new(-1.0, 2.0, -3.0)));
}

#[test]
fn all_variables_are_all_wherever_that_stands() {
    for list in ["all", "all,depth", "depth, all", "depth,normal,depth"] {
        assert_eq!(job(&["--aov", list]).expect(list).aovs, ["depth", "normal"], "{list}");
    }
}

#[test]
fn the_compression_of_exr_is_a_choice() {
    let compression = |flags: &[&str]| job(flags).expect("EXR").compression;
    assert_eq!(compression(&["-o", "a.exr"]), ExrCompression::Zip);
    assert_eq!(compression(&["-o", "a.exr", "--exr-compression", "none"]), ExrCompression::None);
    assert_eq!(compression(&["-o", "a.tar", "--aov", "depth", "--exr-compression", "piz"]), ExrCompression::Piz);
    for name in ExrCompression::NAMES {
        assert_eq!(Some(compression(&["-o", "a.exr", "--exr-compression", name])), ExrCompression::named(name));
    }
}

#[test]
fn what_set_changes_last_decides_what_fits_together() {
    let flags = ["-o", "a.jpg", "--background", "transparent", "--set", "background.source=ff0000"];
    assert_eq!(job(&flags).expect("a colour").format, Format::Jpg);
}

#[test]
fn conflicts_and_nonsense_are_wrong_usage() {
    let wrong: &[&[&str]] = &[
        &["--camera", "0", "--eye", "1,2,3"],
        &["--camera", "0", "--orbit", "1,2,3"],
        &["--size", "0x5"],
        &["--size", "99999x5"],
        &["-o", "a.jpg", "--background", "transparent"],
        &["--aov", "dpth"],
        &["--frames", "5..2"],
        &["--set", "background.source=transparent", "-o", "a.jpg"],
        &["--set", "render.path=forward", "--aov", "depth"],
        &["--set", "msaa.samples=4"],
        &["--path", "gouraud", "--set", "msaa.samples=4"],
        &["--path", "forward", "--set", "msaa.samples=3"],
        &["--orbit", "auto,1,1"],
        &["-o", "-"],
        &["-o", "a.y4m", "--format", "npz"],
        &["-o", "a.y4m", "--format", "png"],
        &["-o", "a.png", "--format", "tar"],
        &["-o", "a.y4m", "--aov", "depth"],
        &["-o", "a.y4m", "--background", "transparent"],
        &["-o", "a.png", "--exr-compression", "zip"],
        &["-o", "a.npz", "--exr-compression", "zip"],
        &["-o", "a.exr", "--exr-compression", "dwaa"],
        &["-o", "a.npz", "--skip-existing"],
        &["-o", "{stem}.npz"],
        &["-o", "a.glb", "--format", "tar"],
        &["-o", "out/", "--format", "tar"],
        &["-o", ".tar"],
        &["--format", "y4m"],
        &["-o", "a.gif"],
        &["--environment", "12345"],
        &["--near", "2", "--far", "1"],
        &["--fov-y", "180"],
        &["--set", "a"],
        &["--up", "0,0,0"],
    ];
    for flags in wrong {
        assert_eq!(job(flags).expect_err(&flags.join(" ")).code(), 2);
    }
}

#[test]
fn folders_become_patterns() {
    let pattern = |flags: &[&str]| match job(flags).expect("job").output {
        Output::Pattern(pattern) => pattern.text().to_owned(),
        Output::Stdout => "-".to_owned(),
        Output::Stream(place) => place.shown(),
    };
    assert_eq!(pattern(&["-o", "out/"]), "out/{stem}.png");
    // Another call may render the next frame, so even one is told apart.
    for frames in [["--frames", "7..7"], ["--turntable", "1"]] {
        assert_eq!(pattern(&frames), "{stem}_{frame:04}.png");
        assert_eq!(pattern(&[&frames[..], &["-o", "out/"]].concat()), "out/{stem}_{frame:04}.png");
        assert_eq!(pattern(&[&frames[..], &["-o", "-", "--format", "png"]].concat()), "-");
        for flags in [["-o", "one.png"], ["--contact-sheet", "one.png"], ["--dump-passes", "one"]] {
            let failure = job(&[&frames[..], &flags].concat()).expect_err("no frame");
            assert!(failure.code() == 2 && failure.hint.contains("{frame:04}"), "{failure:?}");
        }
    }
}

#[test]
fn one_stream_takes_all_pictures() {
    let frames = ["--frames", "0..47", "--camera", "all"];
    for (flags, shown, format) in [
        (&["-o", "-", "--format", "y4m"][..], "-", Format::Png),
        (&["-o", "/dev/stdout", "--format", "tar"], "-", Format::Png),
        (&["-o", "a.npz", "--aov", "all"], "a.npz", Format::Png),
        (&["-o", "a.TAR", "--aov", "depth"], "a.TAR", Format::Exr),
        (&["-o", "x.foo", "--format", "npz"], "x.foo", Format::Png),
    ] {
        let job = job(&[&frames[..], flags].concat()).expect(shown);
        let place = job.output.stream().expect("a stream");
        assert_eq!((place.shown().as_str(), job.format, job.is_one_stream), (shown, format, true));
        let names = crate::gather::Names { parent: "p".into(), stem: "s".into() };
        let look = Look { camera_name: "c".into(), ..job.look.clone() };
        let name = place.name(crate::looks::Subject { names: &names, look: &look, frame: 7 });
        assert_eq!(name, format!("s_c_0007.{}", format.extension()));
    }
    let refused = job(&["-o", "-", "--format", "png", "--frames", "0..1"]).expect_err("a sequence of files");
    assert!(["y4m", "npz", "tar"].iter().all(|name| refused.hint.contains(name)), "{refused:?}");
    assert!(job(&["-o", "a.y4m", "--turntable", "8", "--fps", "30"]).is_ok());
}

#[test]
fn flags_of_the_camera_alone_keep_the_files_camera() {
    let flags: [[&str; 2]; 6] = [
        ["--near", "0.5"],
        ["--far", "9"],
        ["--fov-y", "30"],
        ["--target", "1,2,3"],
        ["--up", "1,0,0"],
        ["--ortho-height", "2"],
    ];
    for flags in flags {
        assert_eq!(job(&flags).expect("job").look.camera.place, Place::Default, "{flags:?}");
    }
    // Whether it goes around a model or turns in a room is known with the file.
    let turntable = job(&["--turntable", "4", "--fov-y", "30"]).expect("job").look.camera;
    assert!(turntable.place == Place::Default && turntable.turns);
}

#[test]
fn a_turntable_has_frames_of_its_own_or_those_asked_for() {
    assert_eq!(job(&["--turntable", "36"]).expect("job").frames, Some((0, 35)));
    assert_eq!(job(&["--turntable", "36", "--frames", "24..48"]).expect("job").frames, Some((24, 48)));
}
