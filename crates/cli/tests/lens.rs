//! Depth of field and motion blur by the samples of a still, as the program draws them.

use crate::common::{Folder, Run, has_adapter, run_in, triangle_glb};
use image::RgbaImage;

/// 16 pixels a metre, and a triangle 2 m wide that moves by 2 m in a second.
const VIEW: &str = "render tri.glb --size 192x96 --ortho-height 6 --eye 1,0,9 --target 1,0,0 --background transparent";

fn render(folder: &Folder, args: &str) -> Run {
    let args: Vec<&str> = VIEW.split_whitespace().chain(args.split_whitespace()).collect();
    run_in(folder.join("").as_ref(), &args)
}

fn picture(folder: &Folder, name: &str) -> RgbaImage {
    image::open(folder.join(name)).expect("a picture").to_rgba8()
}

/// The variance of what is covered along x, in pixels.
fn variance(picture: &RgbaImage) -> f64 {
    let mean = |of: &dyn Fn(f64) -> f64| {
        let weighted = picture.enumerate_pixels().map(|(x, _, pixel)| of(f64::from(x)) * f64::from(pixel.0[3]) / 255.0);
        weighted.sum::<f64>() / coverage_px(picture)
    };
    let middle = mean(&|x| x);
    mean(&|x| (x - middle).powi(2))
}

/// How much of the picture is covered, in pixels.
fn coverage_px(picture: &RgbaImage) -> f64 {
    picture.pixels().map(|pixel| f64::from(pixel.0[3]) / 255.0).sum()
}

#[test]
fn what_moves_smears_over_as_many_pixels_as_it_moves_while_the_shutter_is_open() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("lens-shutter");
    folder.write("tri.glb", &triangle_glb([1.0, 1.0, 0.0]));
    let at = "--time 0.5 --fps 1 --samples 64 --set camera.shutter_deg";
    for (degrees, name) in [(0, "a.png"), (180, "b.png"), (360, "c.png"), (180, "again.png")] {
        let run = render(&folder, &format!("{at}={degrees} -o {name}")).expect(0);
        assert!(!run.stderr.contains("warning"), "{}", run.stderr);
    }
    let [sharp, half, whole] = ["a.png", "b.png", "c.png"].map(|name| picture(&folder, name));
    // An even smear adds a twelfth of its length's square. Half a second and a whole one, at 2 m/s.
    let smear_px = |smeared: &RgbaImage| (12.0 * (variance(smeared) - variance(&sharp))).sqrt();
    println!("{:.2} and {:.2} px", smear_px(&half), smear_px(&whole));
    assert!((smear_px(&half) - 16.0).abs() < 0.5, "{}", smear_px(&half));
    assert!((smear_px(&whole) - 32.0).abs() < 1.0, "{}", smear_px(&whole));
    for smeared in [&half, &whole] {
        assert!((coverage_px(smeared) / coverage_px(&sharp) - 1.0).abs() < 0.01, "{}", coverage_px(smeared));
    }
    assert!(half.as_raw() == picture(&folder, "again.png").as_raw());
    // A turntable turns by half of a quarter while it is open, at one time, too.
    for (degrees, name) in [(0, "d.png"), (180, "e.png")] {
        let turntable = format!("--turntable 4 --time 0.5 --samples 8 --set camera.shutter_deg={degrees} -o {name}");
        let args =
            format!("render tri.glb --size 96x96 --background transparent {turntable}").replace(".png", "{frame}.png");
        run_in(folder.join("").as_ref(), &args.split_whitespace().collect::<Vec<_>>()).expect(0);
    }
    let partly = |name: &str| picture(&folder, name).pixels().filter(|pixel| (8..248).contains(&pixel.0[3])).count();
    assert!(partly("e0.png") > 3 * partly("d0.png"), "{} {}", partly("e0.png"), partly("d0.png"));
}

#[test]
fn one_sample_has_neither_lens_nor_shutter_and_says_so() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("lens-one");
    folder.write("tri.glb", &triangle_glb([1.0, 1.0, 0.0]));
    let set = "--set camera.f_stop=2.8 --set camera.shutter_deg=180";
    render(&folder, "--time 0.5 --samples 1 -o plain.png").expect(0);
    let run = render(&folder, &format!("--time 0.5 --samples 1 {set} -o set.png")).expect(0);
    assert!(
        run.stderr.contains("camera.f_stop and camera.shutter_deg are left out: one sample is drawn"),
        "{}",
        run.stderr
    );
    assert!(picture(&folder, "plain.png").as_raw() == picture(&folder, "set.png").as_raw());
    let run = render(&folder, "--samples 4 --set camera.shutter_deg=180 -o still.png").expect(0);
    assert!(run.stderr.contains("camera.shutter_deg shows nothing"), "{}", run.stderr);
    // Parallel rays have no lens, and numbers that no lens has are refused.
    let run = render(&folder, "--samples 4 --set camera.f_stop=2.8 -o none.png").expect(1);
    assert!(run.stderr.contains("parallel rays") && run.stderr.contains("camera.f_stop"), "{}", run.stderr);
    let run = render(&folder, "--set camera.f_stop=0.01 -o none.png").expect(2);
    assert!(run.stderr.contains("takes 0 or a number from 0.1 to 1024"), "{}", run.stderr);
}
