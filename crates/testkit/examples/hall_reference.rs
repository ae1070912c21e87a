//! Writes what the ray caster sees of the built-in hall: direct light and emission, every light shadowed, no environment.
//!
//! `cargo run --release -p manypass-testkit --example hall_reference -- OUT.exr [WIDTH HEIGHT [RAYS]] [unshadowed]`
//!
//! Without numbers this is the reference of the tests: 240 × 135 pixels of 16 rays each.

use manypass_testkit::radiance_file::RadiancePicture;
use manypass_testkit::raycast::{Camera, Options, World};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let path = arguments.first().ok_or("the file to write is missing")?;
    let numbers: Vec<usize> = arguments.iter().filter_map(|argument| argument.parse().ok()).collect();
    let (width, height) = match numbers[..] {
        [] => (240, 135),
        [width, height, ..] if width > 0 && height > 0 => (width, height),
        _ => return Err("the size is not two numbers".into()),
    };
    let rays = numbers.get(2).copied().unwrap_or(16);
    let shadows = !arguments.iter().any(|argument| argument == "unshadowed");
    let scene = manypass_scene::demo::hall();
    let world = World::of_scene(&scene, Camera::of_scene(&scene).ok_or("the hall has no camera")?);
    println!("{} triangles, {} lights", world.meshes.triangle_count(), world.lights.len());
    let glowing = world.lights.iter().filter(|light| !light.glows_around.is_empty()).count();
    println!("{glowing} lights are not shadowed by what glows around them");
    let started = std::time::Instant::now();
    let options = Options { shadows, samples_per_axis: (rays as f64).sqrt().round() as u32, ..Options::default() };
    let frame = world.render(width, height, options);
    let bytes = RadiancePicture { width, height, pixels: frame.radiance }.to_exr();
    println!("{:.1} s, {} bytes", started.elapsed().as_secs_f64(), bytes.len());
    std::fs::write(path, bytes)?;
    Ok(())
}
