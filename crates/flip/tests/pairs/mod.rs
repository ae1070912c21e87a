//! Small pairs of pictures, made by code, that differ in ways that pictures differ.

use manypass_flip::Picture;

/// The size of all pairs in pixels.
pub const WIDTH: usize = 101;
/// The rows are more than a band of the comparison and no multiple of one.
pub const HEIGHT: usize = 75;

/// Two pictures: sRGB values that are whole 255ths, or radiance of high range.
#[derive(Clone, Debug)]
pub struct Pair {
    pub name: &'static str,
    pub reference: Vec<[f32; 3]>,
    pub test: Vec<[f32; 3]>,
    pub is_high_range: bool,
}

/// The pair as the crate takes it.
pub fn pictures(pair: &Pair) -> (Picture, Picture) {
    let read = if pair.is_high_range { Picture::from_linear } else { Picture::from_srgb };
    let picture = |pixels: &Vec<[f32; 3]>| read(WIDTH, HEIGHT, pixels.clone()).expect("a picture");
    (picture(&pair.reference), picture(&pair.test))
}

/// Numbers from 0 to 1 that are the same everywhere (PCG, O'Neill 2014).
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let word = (((self.0 >> 18) ^ self.0) >> 27) as u32;
        (word.rotate_right((self.0 >> 59) as u32) >> 8) as f32 / 16_777_216.0
    }
}

fn picture(mut pixel: impl FnMut(usize, usize) -> [f32; 3]) -> Vec<[f32; 3]> {
    (0..WIDTH * HEIGHT).map(|index| pixel(index % WIDTH, index / WIDTH)).collect()
}

/// Whole 255ths, as files of 8 bits hold.
fn bytes(pixels: &[[f32; 3]]) -> Vec<[f32; 3]> {
    pixels.iter().map(|rgb| rgb.map(|value| (value.clamp(0.0, 1.0) * 255.0).round() / 255.0)).collect()
}

fn gradient(x: usize, y: usize) -> [f32; 3] {
    let (u, v) = (x as f32 / (WIDTH - 1) as f32, y as f32 / (HEIGHT - 1) as f32);
    [u, v, 1.0 - 0.5 * (u + v)]
}

/// Letters of 5 by 7 dots, each dot set or not by a hash of its place.
fn text(x: usize, y: usize) -> [f32; 3] {
    let is_between = x % 6 == 5 || y % 9 > 6;
    let is_set =
        !is_between && Noise((x * 7919 + y * 104_729) as u64).next() + Noise((x + 1000 * y) as u64).next() > 1.0;
    if is_set { [0.05, 0.05, 0.1] } else { [0.95, 0.93, 0.9] }
}

fn edges(x: usize, y: usize) -> [f32; 3] {
    let (dx, dy) = (x as f32 - 50.0, y as f32 - 37.0);
    match dx * dx + dy * dy {
        d if d < 144.0 => [0.9, 0.2, 0.1],
        d if d < 676.0 => [0.1, 0.4, 0.8],
        _ if x + y < 60 => [0.95; 3],
        _ => [0.25, 0.3, 0.2],
    }
}

/// A room with a lamp: six orders of magnitude.
fn lamp(x: usize, y: usize) -> [f32; 3] {
    let (dx, dy) = (x as f32 - 30.0, y as f32 - 20.0);
    let d2 = dx * dx + dy * dy;
    if d2 < 9.0 {
        return [4000.0, 3500.0, 2500.0];
    }
    let wall = if (x / 8 + y / 8).is_multiple_of(2) { 0.8 } else { 0.15 };
    [120.0, 100.0, 70.0].map(|intensity| intensity * wall / (d2 + 4.0) + 0.002 * wall)
}

fn with_noise(pixels: &[[f32; 3]], strength: f32, seed: u64) -> Vec<[f32; 3]> {
    let mut noise = Noise(seed);
    pixels.iter().map(|rgb| rgb.map(|value| value + strength * (noise.next() - 0.5))).collect()
}

/// All of them.
pub fn pairs() -> Vec<Pair> {
    let low = |name, reference: &[[f32; 3]], test: &[[f32; 3]]| Pair {
        name,
        reference: bytes(reference),
        test: bytes(test),
        is_high_range: false,
    };
    let high = |name, reference: &[[f32; 3]], test: Vec<[f32; 3]>| Pair {
        name,
        reference: reference.to_vec(),
        test,
        is_high_range: true,
    };
    let (gradient, text_at, edges, lamp) =
        (picture(gradient), |step| picture(move |x, y| text(x + step, y)), picture(edges), picture(lamp));
    let mut noise = Noise(7);
    let speckled: Vec<_> = edges.iter().map(|&rgb| if noise.next() < 0.02 { [1.0; 3] } else { rgb }).collect();
    let tinted: Vec<_> = gradient.iter().map(|&[r, g, b]| [r * 0.9 + 0.05, g, b * 0.95]).collect();
    let mut noise = Noise(11);
    let fireflies: Vec<_> =
        lamp.iter().map(|rgb| if noise.next() < 0.01 { rgb.map(|value| value * 50.0) } else { *rgb }).collect();
    let scaled = |pixels: &[[f32; 3]], by: [f32; 3]| -> Vec<[f32; 3]> {
        pixels.iter().map(|rgb| std::array::from_fn(|c| rgb[c] * by[c])).collect()
    };
    vec![
        low("gradient-tinted", &gradient, &tinted),
        low("gradient-noise", &gradient, &with_noise(&gradient, 0.2, 3)),
        low("text-shifted", &text_at(0), &text_at(1)),
        low("edges-speckled", &edges, &speckled),
        low("edges-turned", &edges, &edges.iter().rev().copied().collect::<Vec<_>>()),
        low("green-blue", &[[0.0, 1.0, 0.0]; WIDTH * HEIGHT], &[[0.0, 0.0, 1.0]; WIDTH * HEIGHT]),
        high("lamp-dimmed", &lamp, scaled(&lamp, [0.8, 0.8, 0.8])),
        high("lamp-tinted", &lamp, scaled(&lamp, [1.1, 1.0, 0.85])),
        high("lamp-fireflies", &lamp, fireflies),
        high(
            "gradient-linear",
            &gradient,
            with_noise(&gradient, 0.1, 5).iter().map(|rgb| rgb.map(|v| v.max(0.0))).collect(),
        ),
    ]
}
