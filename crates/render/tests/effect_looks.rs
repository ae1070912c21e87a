//! Properties of the built-in effects that are taste: film, glow and sharper edges.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::flat::flat_scene;
use crate::common::{built_in_with, plain_request, renderer};
use manypass::{Effect, FrameRequest, Renderer, WgslEffect};
use manypass_scene::Scene;
use std::sync::Arc;

/// Pictures that effects make of an expression of `p`, the place of the pixel's middle, which gives radiance.
struct EffectPictures {
    renderer: Renderer,
    scene: Scene,
    size: (u32, u32),
}

impl EffectPictures {
    fn new(size: (u32, u32)) -> Self {
        let (mut renderer, scene) = (renderer(), flat_scene().finish());
        renderer.load(&scene).unwrap();
        Self { renderer, scene, size }
    }

    fn draw(&mut self, expression: &str, effects: &[(&str, &[&str])]) {
        let source = format!(
            "@fragment fn fs(@builtin(position) position: vec4f) -> @location(0) vec4f {{
                let p = position.xy;
                return vec4f({expression}, 1.0);
            }}"
        );
        let drawing = WgslEffect::new(self.renderer.gpu(), "drawing.wgsl", &source);
        let mut all: Vec<Arc<dyn Effect>> = vec![Arc::new(drawing.unwrap_or_else(|error| panic!("{error}")))];
        for (name, settings) in effects {
            all.push(built_in_with(&self.renderer, name, settings));
        }
        let request = FrameRequest { effects: all, ..plain_request(&self.scene, self.size) };
        self.renderer.render(&self.scene, &request).unwrap();
    }

    fn display(&mut self, expression: &str, effects: &[(&str, &[&str])]) -> Vec<[u8; 4]> {
        self.draw(expression, effects);
        self.renderer.read_display().unwrap().as_chunks().0.to_vec()
    }

    fn radiance(&mut self, expression: &str, effects: &[(&str, &[&str])]) -> Vec<[f32; 4]> {
        self.draw(expression, effects);
        self.renderer.read_radiance().unwrap().as_chunks().0.to_vec()
    }
}

/// IEC 61966-2-1, of 255.
fn encoded(linear: f64) -> f64 {
    255.0 * if linear <= 0.0031308 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Film that does nothing but what the settings say.
const PLAIN_FILM: [&str; 4] = ["tint=1,1,1", "vignette=0", "saturation=1", "grain=0"];

#[test]
fn film_without_colour_is_grey_and_corners_fall_dark_by_the_square_of_the_distance() {
    let (width, height) = (90usize, 60usize);
    let mut drawn = EffectPictures::new((width as u32, height as u32));
    let film = |settings: &[&'static str]| [&PLAIN_FILM[..], settings].concat();
    let colors = "vec3f(0.6 * p.x / 90.0, 0.5 * p.y / 60.0, 0.3)";
    let grey = drawn.display(colors, &[("film", &film(&["saturation=0"]))]);
    for (at, pixel) in grey.iter().enumerate() {
        let [x, y] = [at % width, at / width].map(|place| place as f64 + 0.5);
        // The luminance of Rec. 709.
        let expected = encoded(0.2126 * 0.6 * x / 90.0 + 0.7152 * 0.5 * y / 60.0 + 0.0722 * 0.3);
        assert!(pixel[0] == pixel[1] && pixel[1] == pixel[2], "{pixel:?} at {x}, {y}");
        assert!((f64::from(pixel[1]) - expected).abs() < 1.0, "{pixel:?} at {x}, {y}, not {expected}");
    }
    let same = drawn.display(colors, &[("film", &film(&[]))]);
    let plain = drawn.display(colors, &[]);
    let far = same.as_flattened().iter().zip(plain.as_flattened()).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
    assert!(far <= 1, "a film that does nothing: {far}");
    // The corners lose what the setting says, the middle nothing, and the middles of the sides half of it.
    for vignette in [0.35, 0.8] {
        let setting = format!("vignette={vignette}");
        let dark = drawn.display("vec3f(0.5)", &[("film", &[&PLAIN_FILM[..], &[setting.as_str()]].concat())]);
        for (at, pixel) in dark.iter().enumerate() {
            let [u, v] = [((at % width) as f64 + 0.5) / 90.0, ((at / width) as f64 + 0.5) / 60.0];
            let of_corner = ((2.0 * u - 1.0).powi(2) + (2.0 * v - 1.0).powi(2)) / 2.0;
            let expected = encoded(0.5 * (1.0 - vignette * of_corner));
            assert!((f64::from(pixel[1]) - expected).abs() < 1.0, "{pixel:?} at {u}, {v}, not {expected}");
        }
    }
}

#[test]
fn grain_has_its_deviation_in_the_middle_tones_and_no_mean() {
    let (width, height) = (160u32, 128u32);
    let mut drawn = EffectPictures::new((width, height));
    let film = [&PLAIN_FILM[..3], &["grain=5"]].concat();
    let plain = drawn.display("vec3f(0.25)", &[]);
    let grained = drawn.display("vec3f(0.25)", &[("film", &film)]);
    let change = |at: usize| f64::from(grained[at][1]) - encoded(0.25);
    let count = grained.len() as f64;
    let mean = (0..grained.len()).map(change).sum::<f64>() / count;
    let deviation = ((0..grained.len()).map(|at| (change(at) - mean).powi(2)).sum::<f64>() / count).sqrt();
    println!("grain of 5/255: mean {mean:.3}/255, standard deviation {deviation:.3}/255");
    // 20,480 pixels leave a mean of 0.035 by chance.
    assert!(mean.abs() < 0.2, "{mean}");
    assert!((deviation / 5.0 - 1.0).abs() < 0.05, "{deviation}");
    assert!(plain.iter().all(|pixel| pixel == &plain[0]));
    // No pixel knows of the next: rows and columns have no pattern.
    for step in [1, width as usize] {
        let pairs = (0..grained.len() - step).map(|at| (change(at) - mean) * (change(at + step) - mean));
        let likeness = pairs.sum::<f64>() / count / deviation.powi(2);
        assert!(likeness.abs() < 0.04, "{likeness} at {step}");
    }
    // Black and white have none.
    for (value, byte) in [("vec3f(0.0)", 0), ("vec3f(1.0)", 255)] {
        let found = drawn.display(value, &[("film", &film)]);
        assert!(found.iter().all(|pixel| pixel[..3] == [byte; 3]), "{value}");
    }
}

#[test]
fn glow_adds_light_around_what_is_brighter_than_its_threshold_alone() {
    let size = 128usize;
    let mut drawn = EffectPictures::new((size as u32, size as u32));
    let spot = |radiance: f32| format!("vec3f(select(0.1, {radiance:?}, all(abs(p - 64.0) < vec2f(8.0))))");
    // Below the threshold nothing changes.
    for radiance in [0.5, 0.79] {
        let plain = drawn.radiance(&spot(radiance), &[]);
        assert!(drawn.radiance(&spot(radiance), &[("glow", &["strength=1"])]) == plain, "{radiance}");
    }
    let plain = drawn.radiance(&spot(2.0), &[]);
    let found = drawn.radiance(&spot(2.0), &[("glow", &[])]);
    let added = |at: usize| f64::from(found[at][1] - plain[at][1]);
    assert!((0..found.len()).all(|at| added(at) >= 0.0), "light is added");
    let [near, far] = [64 * size + 76, 64 * size + 2].map(added);
    assert!(near > 0.02 && far < 1e-3, "{near} {far}");
    // A quarter of what the spot has above the threshold of 0.8, wherever it goes.
    let sum: f64 = (0..found.len()).map(added).sum();
    let expected = 0.25 * 256.0 * (2.0 - 0.8);
    assert!((sum / expected - 1.0).abs() < 0.02, "{sum}, not {expected}");
}

#[test]
fn sharpening_leaves_flat_areas_alone_and_makes_edges_steeper() {
    let (width, height) = (64usize, 16usize);
    let mut drawn = EffectPictures::new((width as u32, height as u32));
    // Over four columns from dark to bright.
    let edge = "vec3f(mix(0.1, 0.5, smoothstep(30.0, 34.0, p.x)))";
    let plain = drawn.display(edge, &[]);
    let steepest = |picture: &[[u8; 4]]| {
        let row = &picture[8 * width..9 * width];
        row.windows(2).map(|pair| pair[1][1].abs_diff(pair[0][1])).max().unwrap()
    };
    let mut steps = vec![steepest(&plain)];
    for strength in ["strength=0.1", "strength=0.6", "strength=1"] {
        let sharp = drawn.display(edge, &[("sharpen", &[strength])]);
        for (at, (found, before)) in sharp.iter().zip(&plain).enumerate() {
            let is_flat = !(29..35).contains(&(at % width));
            assert!(!is_flat || found == before, "{found:?} of {before:?} in column {}", at % width);
        }
        steps.push(steepest(&sharp));
    }
    println!("the steepest step of an edge is {steps:?}");
    assert!(f64::from(steps[2]) > 1.1 * f64::from(steps[0]) && steps.is_sorted(), "{steps:?}");
    assert!(steps[3] > steps[1], "{steps:?}");
}
