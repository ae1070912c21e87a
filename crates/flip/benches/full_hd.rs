//! How long the comparison of two pictures of 1920×1080 pixels takes, on all threads that there are.

use manypass_flip::{PIXELS_PER_DEGREE, Picture, ldr};
use std::time::Instant;

fn main() {
    let (width, height) = (1920, 1080);
    let picture = |step: usize| {
        let value = |index: usize| (index * step % 256) as f32 / 255.0;
        let pixels = (0..width * height).map(|index| [value(index), value(index / 3), value(index / width)]);
        Picture::from_srgb(width, height, pixels.collect()).expect("a picture")
    };
    let (a, b) = (picture(3), picture(5));
    for _ in 0..3 {
        let start = Instant::now();
        let map = ldr(&a, &b, PIXELS_PER_DEGREE).expect("a map");
        println!("mean {:.6} in {:.0} ms", map.mean(), start.elapsed().as_secs_f64() * 1e3);
    }
}
