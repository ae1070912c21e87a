//! The last step of every picture: tone curves, and the noise that takes the place of steps of 8 bits.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::flat::flat_scene;
use crate::common::{plain_request, renderer};
use manypass::{FrameRequest, Renderer, Tonemap, WgslEffect};
use std::sync::Arc;

/// A picture whose radiance is an expression of `x`, the column's number from 0 up to 1, and `y`, that of the row.
fn picture(
    renderer: &mut Renderer,
    (width, height): (u32, u32),
    expression: &str,
    change: impl FnOnce(&mut FrameRequest),
) -> Vec<[u8; 4]> {
    let scene = flat_scene().finish();
    renderer.load(&scene).unwrap();
    let source = format!(
        "@fragment fn fs(@builtin(position) position: vec4f) -> @location(0) vec4f {{
            let x = floor(position.x) / {:?};
            let y = floor(position.y) / {:?};
            return vec4f({expression}, 1.0);
        }}",
        (width.max(2) - 1) as f32,
        (height.max(2) - 1) as f32,
    );
    let mut request = plain_request(&scene, (width, height));
    request.effects = vec![Arc::new(WgslEffect::new(renderer.gpu(), "ramp.wgsl", &source).unwrap())];
    change(&mut request);
    renderer.render(&scene, &request).unwrap();
    renderer.read_display().unwrap().as_chunks().0.to_vec()
}

const CURVES: [Tonemap; 6] =
    [Tonemap::Neutral, Tonemap::Aces, Tonemap::Agx, Tonemap::Reinhard, Tonemap::Exponential, Tonemap::None];

#[test]
fn more_light_is_never_darker() {
    let mut renderer = renderer();
    let [mut looked_at, mut all] = [CURVES.map(Tonemap::name).to_vec(), Tonemap::NAMES.to_vec()];
    looked_at.sort_unstable();
    all.sort_unstable();
    assert_eq!(looked_at, all);
    // From far below what a byte shows to 8 stops above white, in steps of a fiftieth of a stop: of grey, and of colours,
    // whose strongest channel lies in the others' way as they are brought to white.
    let colors = ["vec3f(1.0)", "vec3f(1.0, 0.05, 0.02)", "vec3f(0.05, 1.0, 0.1)", "vec3f(0.02, 0.1, 1.0)"];
    for curve in CURVES {
        for (row, color) in colors.into_iter().enumerate() {
            let ramp = format!("{color} * exp2(20.0 * x - 12.0)");
            let found = picture(&mut renderer, (1001, 1), &ramp, |request| request.settings.tone_map.curve = curve);
            for channel in 0..3 {
                let bytes: Vec<u8> = found.iter().map(|pixel| pixel[channel]).collect();
                // Half floats round the channels of a colour one by one, so that its hue trembles by less than a byte.
                let rounded = u8::from(row > 0);
                let most_before = bytes.iter().scan(0, |most, byte| Some(std::mem::replace(most, *byte.max(most))));
                let fall = most_before.zip(&bytes).position(|(most, byte)| byte.saturating_add(rounded) < most);
                assert_eq!(fall, None, "{curve:?} of {color}, channel {channel}: the column of {bytes:?}");
                // It is the ramp that is looked at.
                let is_strongest = row == 0 || channel == row - 1;
                assert!(!is_strongest || (bytes[0] <= 8 && bytes[1000] >= 240), "{curve:?}: {bytes:?}");
            }
        }
    }
}

/// IEC 61966-2-1, of 255.
fn encoded(linear: f64) -> f64 {
    255.0 * if linear <= 0.0031308 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

#[test]
fn dithering_shows_what_lies_between_two_bytes() {
    let (width, height) = (96u32, 256u32);
    let mut renderer = renderer();
    // Over 96 columns from a byte of 8 to one of about 14: without noise six bands.
    let [first, last] = [0.0024f32, 0.0044];
    let ramp = format!("vec3f({first:?} + {:?} * x)", last - first);
    // Of each column how far the mean of its bytes is from what it should show.
    let mut off = |dither: f32| {
        let found = picture(&mut renderer, (width, height), &ramp, |request| {
            request.settings.tone_map.dither = dither;
        });
        let column = |x: u32| {
            let sum: u64 = (0..height).map(|y| u64::from(found[(y * width + x) as usize][1])).sum();
            let share = f64::from(x) / f64::from(width - 1);
            sum as f64 / f64::from(height) - encoded(f64::from(first) + f64::from(last - first) * share)
        };
        (0..width).map(|x| column(x).abs()).fold(0.0, f64::max)
    };
    let (with, without) = (off(1.0), off(0.0));
    println!("columns are off by at most {with:.3}/255 with noise, {without:.3}/255 without");
    assert!(with < 0.1, "{with}");
    assert!(without > 0.4, "there are no bands to be seen: {without}");
    // Noise is of what lies between black and white alone.
    let ends = picture(&mut renderer, (32, 8), "vec3f(step(0.5, x))", |request| request.settings.tone_map.dither = 1.0);
    assert!(ends.iter().enumerate().all(|(at, pixel)| pixel[1] == if at % 32 < 16 { 0 } else { 255 }));
}
