//! Exposure that goes on from frame to frame: where it comes to rest, how it gets there, and what it leaves alone.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{plain_request, renderer};
use manypass::{Adaptation, Averaging, Exposure, FrameRequest, MeteringPattern, Renderer, WgslEffect};
use manypass_scene::Scene;
use manypass_testkit::scenes;
use std::sync::Arc;

const SIZE: (u32, u32) = (96, 64);
const TO_LIGHT_S: f32 = 0.4;
const TO_DARK_S: f32 = 1.2;

/// One lamp over a plane, so many stops stronger.
fn lamp(stops: f32) -> Scene {
    let mut scene = scenes::one_light_on_one_plane().scene;
    scene.lights.iter_mut().for_each(|light| light.intensity *= stops.exp2());
    scene
}

/// A picture of a sequence, under the lights of `scene` alone; radiance can be read.
fn request(scene: &Scene, size: (u32, u32)) -> FrameRequest {
    let request = plain_request(scene, size).with(|settings| {
        settings.exposure.stops = Exposure::AUTO;
        settings.exposure.adapt = true;
        (settings.exposure.adapt_to_light_s, settings.exposure.adapt_to_dark_s) = (TO_LIGHT_S, TO_DARK_S);
    });
    FrameRequest { adaptation: Adaptation::Begins, ..request }
}

fn after(request: &FrameRequest, secs: f32) -> FrameRequest {
    FrameRequest { adaptation: Adaptation::After { secs }, ..request.clone() }
}

/// Draws a frame, and gives the stops that it adapted to.
fn stops(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> f32 {
    renderer.render(scene, request).unwrap();
    renderer.read_adapted_stops().unwrap().expect("exposure adapts")
}

/// The stops that bring what was drawn to mid grey: of pixels that are not black the mean of logarithms.
fn wanted_stops(renderer: &mut Renderer, pattern: MeteringPattern, (width, height): (u32, u32)) -> f64 {
    let radiance = renderer.read_radiance().unwrap();
    let shorter = f64::from(width.min(height));
    let (mut weights, mut sum) = (0.0, 0.0);
    for (index, texel) in radiance.chunks_exact(4).enumerate() {
        let [r, g, b, alpha] = [0, 1, 2, 3].map(|at| f64::from(texel[at]));
        let luminance = (0.2126 * r + 0.7152 * g + 0.0722 * b) / alpha.max(1e-6);
        let (x, y) = (index as u32 % width, index as u32 / width);
        let from_middle =
            (f64::from(x) + 0.5 - f64::from(width) / 2.0).hypot(f64::from(y) + 0.5 - f64::from(height) / 2.0);
        let of_place = match pattern {
            MeteringPattern::Average => 1.0,
            MeteringPattern::Centre => (-0.5 * (from_middle / (shorter / 4.0).max(1.0)).powi(2)).exp(),
            MeteringPattern::Spot => f64::from(u8::from(from_middle <= (shorter / 10.0).max(1.0))),
        };
        if luminance > 0.0 {
            weights += of_place * alpha;
            sum += of_place * alpha * luminance.log2();
        }
    }
    0.18f64.log2() - sum / weights
}

#[test]
fn a_first_frame_is_adapted_whatever_its_size_and_pattern() {
    let mut renderer = renderer();
    let scene = lamp(5.0);
    renderer.load(&scene).unwrap();
    for size in [SIZE, (1, 1), (8, 8), (9, 7), (257, 3), (1, 4096), (700, 513)] {
        for pattern in [MeteringPattern::Average, MeteringPattern::Centre, MeteringPattern::Spot] {
            let request = request(&scene, size).with(|settings| settings.exposure.metering = pattern);
            let found = stops(&mut renderer, &scene, &request);
            let wanted = wanted_stops(&mut renderer, pattern, size);
            assert!((f64::from(found) - wanted).abs() < 0.01, "{size:?} {pattern:?}: {found}, not {wanted}");
            assert!(found < -1.0, "{size:?} {pattern:?}: strong light takes little exposure, and no {found} stops");
        }
    }
}

#[test]
fn patterns_look_at_the_middle() {
    let mut renderer = renderer();
    let scene = lamp(0.0);
    renderer.load(&scene).unwrap();
    let mut of = |pattern| {
        let request = request(&scene, SIZE).with(|settings| settings.exposure.metering = pattern);
        stops(&mut renderer, &scene, &request)
    };
    let [average, centre, spot] =
        [MeteringPattern::Average, MeteringPattern::Centre, MeteringPattern::Spot].map(&mut of);
    // The lamp shines on the middle of the picture.
    assert!(average > centre + 0.1 && centre > spot + 0.1, "{average} {centre} {spot}");
}

#[test]
fn a_step_of_four_stops_is_met_along_the_curve() {
    let mut renderer = renderer();
    for (first, second, time_s) in [(0.0, 4.0, TO_LIGHT_S), (4.0, 0.0, TO_DARK_S)] {
        let (before, now) = (lamp(first), lamp(second));
        renderer.load(&before).unwrap();
        let begin = request(&before, SIZE);
        let from = stops(&mut renderer, &before, &begin);
        let to = from + first - second;
        for frame in 1..=60u32 {
            let secs = 1.0 / 30.0;
            let found = stops(&mut renderer, &now, &after(&begin, secs));
            let expected = to + (from - to) * (-(frame as f32) * secs / time_s).exp();
            assert!((found - expected).abs() < 0.01 * 4.0, "{frame}: {found}, not {expected}");
        }
    }
}

#[test]
fn the_picture_is_exposed_by_what_it_adapted_to() {
    let mut renderer = renderer();
    let (before, now) = (lamp(0.0), lamp(-4.0));
    renderer.load(&before).unwrap();
    for compensation_stops in [0.0, 1.0] {
        let begin =
            request(&before, SIZE).with(|settings| settings.exposure.stops = Exposure::Auto { compensation_stops });
        // Half floats hold radiance at any level that was metered.
        let mut begin = begin;
        let exposure = begin.settings.exposure.stops;
        renderer.expose(&before, &mut begin, exposure).unwrap();
        stops(&mut renderer, &before, &begin);
        for _ in 0..3 {
            let found = stops(&mut renderer, &now, &after(&begin, 0.5));
            let radiance = renderer.read_radiance().unwrap();
            let display = renderer.read_display().unwrap();
            let mut is_shown = false;
            for at in [SIZE.0 * 32 + 48, SIZE.0 * 50 + 30].map(|index| 4 * index as usize) {
                let linear = radiance[at + 1] * (found + compensation_stops).exp2();
                let encoded =
                    255.0 * if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
                assert!(
                    (f32::from(display[at + 1]) - encoded.min(255.0)).abs() <= 1.5,
                    "{encoded}: {:?}",
                    display[at + 1]
                );
                is_shown |= (4.0..255.0).contains(&encoded);
            }
            assert!(is_shown, "the test shows nothing");
        }
    }
}

#[test]
fn the_number_of_frames_does_not_matter() {
    let mut renderer = renderer();
    let (before, now) = (lamp(1.0), lamp(5.0));
    renderer.load(&before).unwrap();
    let begin = request(&before, (32, 32));
    let mut after_one_second = |frames: u32| {
        stops(&mut renderer, &before, &begin);
        let each = after(&begin, 0.6 / frames as f32);
        (0..frames).map(|_| stops(&mut renderer, &now, &each)).last().unwrap()
    };
    let found = [2, 10, 60, 240].map(&mut after_one_second);
    assert!(found.iter().all(|stops| (stops - found[0]).abs() < 2e-3), "{found:?}");
    // A long time is all the way, and no time, or what is none, nothing.
    let first = stops(&mut renderer, &before, &begin);
    assert_eq!([0.0, -3.0, f32::NAN].map(|secs| stops(&mut renderer, &now, &after(&begin, secs))), [first; 3]);
    let last = stops(&mut renderer, &now, &after(&begin, f32::INFINITY));
    assert!((first - last - 4.0).abs() < 0.02, "{first} {last}");
}

#[test]
fn what_does_not_change_does_not_flicker() {
    let mut renderer = renderer();
    let scene = lamp(3.3);
    renderer.load(&scene).unwrap();
    let begin = request(&scene, SIZE);
    let first = stops(&mut renderer, &scene, &begin);
    let picture = renderer.read_display().unwrap();
    for frame in 0..40 {
        let found = stops(&mut renderer, &scene, &after(&begin, 1.0 / 60.0));
        assert_eq!((found, renderer.read_display().unwrap() == picture), (first, true), "{frame}");
    }
}

#[test]
fn what_shows_no_light_keeps_what_was_and_nothing_leaves_the_limits() {
    let mut renderer = renderer();
    let scene = lamp(4.0);
    let mut dark = scene.clone();
    dark.lights.iter_mut().for_each(|light| light.intensity = 0.0);
    renderer.load(&scene).unwrap();
    let begin = request(&scene, SIZE);
    assert_eq!(stops(&mut renderer, &dark, &begin), 0.0, "nothing says otherwise");
    let first = stops(&mut renderer, &scene, &begin);
    assert_eq!(stops(&mut renderer, &dark, &after(&begin, 10.0)), first);
    for (strength, expected) in [(1e30, -6.0), (1e-3, 5.0)] {
        let mut other = scene.clone();
        other.lights.iter_mut().for_each(|light| light.intensity *= strength);
        let within = begin.with(|settings| {
            (settings.exposure.adapt_min_stops, settings.exposure.adapt_max_stops) = (-6.0, 5.0);
        });
        assert_eq!(stops(&mut renderer, &other, &after(&within, 1e6)), expected, "{strength}");
        assert!(stops(&mut renderer, &other, &after(&begin, 1e6)).abs() <= 24.0);
    }
    // Pixels that are no numbers, or infinite.
    let source = "@fragment fn fs(@builtin(position) position: vec4f) -> @location(0) vec4f {
        let here = radiance_at(vec2i(position.xy));
        let zero = here.a - 1.0;
        let wrong = select(1.0 / zero, zero / zero, position.x < 8.0);
        return select(here, vec4f(wrong, wrong, wrong, 1.0), position.x < 16.0);
    }";
    let effect = Arc::new(WgslEffect::new(renderer.gpu(), "wrong.wgsl", source).unwrap());
    let wrong = FrameRequest { effects: vec![effect], ..begin.clone() };
    let found = stops(&mut renderer, &scene, &wrong);
    assert!(found.is_finite() && found.abs() <= 24.0 && (found - first).abs() < 4.0, "{found}, not about {first}");
    assert!(stops(&mut renderer, &scene, &after(&begin, 1e6)) == first, "and nothing of it stays");
}

#[test]
fn samples_of_a_still_have_one_exposure_and_those_of_a_live_view_go_on() {
    let mut renderer = renderer();
    let (before, now) = (lamp(0.0), lamp(4.0));
    renderer.load(&before).unwrap();
    let begin = FrameRequest { sample_count: 4, averaging: Averaging::Display, ..request(&before, SIZE) };
    for goes_on in [false, true] {
        let begin = FrameRequest { goes_on, ..begin.clone() };
        let first = stops(&mut renderer, &before, &begin);
        let each = after(&begin, 0.1);
        let found: Vec<f32> = (0..4)
            .map(|sample_index| stops(&mut renderer, &now, &FrameRequest { sample_index, ..each.clone() }))
            .collect();
        let expected = |frames: f32| first - 4.0 * (1.0 - (-frames * 0.1 / TO_LIGHT_S).exp());
        for (at, found) in found.iter().enumerate() {
            let expected = expected(if goes_on { at as f32 + 1.0 } else { 1.0 });
            assert!((found - expected).abs() < 0.05, "{goes_on} {at}: {found}, not {expected}");
        }
    }
}

#[test]
fn a_cut_begins_anew() {
    let mut renderer = renderer();
    let (before, now) = (lamp(0.0), lamp(6.0));
    renderer.load(&before).unwrap();
    let begin = request(&before, SIZE);
    let first = stops(&mut renderer, &before, &begin);
    renderer.cut();
    let found = stops(&mut renderer, &now, &after(&begin, 1e-3));
    assert!((first - found - 6.0).abs() < 0.02, "{first} {found}");
    // And so does what follows a picture of its own.
    renderer.render(&before, &FrameRequest { adaptation: Adaptation::Still, ..begin.clone() }).unwrap();
    assert_eq!(renderer.read_adapted_stops().unwrap(), None);
    assert_eq!(stops(&mut renderer, &before, &after(&begin, 1e-3)), first);
}

#[test]
fn nothing_changes_where_nobody_asks() {
    let mut renderer = renderer();
    let scene = lamp(7.0);
    renderer.load(&scene).unwrap();
    let mut picture = |adapt: bool, adaptation: Adaptation| {
        let mut request = request(&scene, SIZE).with(|settings| settings.exposure.adapt = adapt);
        renderer.expose(&scene, &mut request, Exposure::AUTO).unwrap();
        let request = FrameRequest { adaptation, ..request };
        let plan = renderer.plan(&scene, &request).unwrap().to_text();
        renderer.render(&scene, &request).unwrap();
        (renderer.read_display().unwrap(), plan)
    };
    let still = picture(false, Adaptation::Still);
    assert!(!still.1.contains("meter"), "{}", still.1);
    assert!(picture(true, Adaptation::Still) == still, "a still is exposed as it was metered");
    assert!(picture(false, Adaptation::After { secs: 1.0 }) == still);
    let adapted = picture(true, Adaptation::Begins);
    assert!(adapted.1.contains("meter.luminance.12x8") && adapted.0 != still.0, "{}", adapted.1);
}

#[test]
fn settings_that_mean_nothing_are_refused() {
    let mut settings = manypass::Settings::default();
    for key in ["exposure.adapt_to_light_s", "exposure.adapt_to_dark_s"] {
        for value in ["0", "-1", "nan", "inf", "1e9"] {
            let error = settings.set(key, value).unwrap_err().to_string();
            assert!(error.contains(key) && error.contains("from 0.01 to 3600"), "{error}");
        }
    }
    assert!(settings.set("exposure.metering", "matrix").unwrap_err().to_string().contains("average, centre or spot"));
    settings.set("exposure.adapt", "true").unwrap();
    settings.set("exposure.adapt_min_stops", "3").unwrap();
    settings.set("exposure.adapt_max_stops", "2").unwrap();
    let error = settings.check().unwrap_err().to_string();
    assert!(error.contains("exposure.adapt_min_stops") && error.contains("adapt_max_stops, which is 2"), "{error}");
    settings.set("exposure.adapt_max_stops", "3").unwrap();
    assert_eq!(settings.check(), Ok(()));
    settings.set("exposure.stops", "2").unwrap();
    let error = settings.check().unwrap_err().to_string();
    assert_eq!(error, "`exposure.adapt=true` needs `exposure.stops=auto`, which is `a number of stops`");
}
