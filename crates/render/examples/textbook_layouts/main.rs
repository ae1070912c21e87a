//! Two layouts of deferred shading as textbooks draw them, on the frame graph, beside our own frame of the same scene:
//! `cargo run --release --example textbook_layouts -- [WIDTH HEIGHT [FRAMES]] [OUT.png]`.
//!
//! The picture has a row for each layout: on the left the layout's, on the right ours. The table says what each costs.

mod content;
mod device;
mod float_positions;
mod layout;
mod three_targets;

use content::{Content, Variety};
use float_positions::{FloatPositions, ONE_PASS_BYTES_PER_SAMPLE};
use layout::{Measured, Shot};
use manypass::graph::Limits;
use manypass::{Gpu, LightCulling, Renderer};
use three_targets::ThreeTargets;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let is_number = |argument: &String| argument.parse::<u32>().is_ok();
    let out = arguments.pop_if(|last| !is_number(last)).unwrap_or("textbook_layouts.png".into());
    let numbers: Vec<u32> = arguments.iter().map(|argument| argument.parse()).collect::<Result<_, _>>()?;
    let size = numbers.first().copied().zip(numbers.get(1).copied()).unwrap_or((960, 540));
    let frames = numbers.get(2).map_or(15, |frames| *frames as usize);
    let shot = Shot { size, frames };
    let aspect = size.0 as f32 / size.1.max(1) as f32;

    let gpu = Gpu::headless(None)?;
    let mut renderer = Renderer::new(gpu.clone())?;
    let device = &gpu.device;
    let limits = Limits::from(&device.limits());
    println!("{}, {} × {} pixels, median of {frames} frames", gpu.adapter.name, size.0, size.1);
    println!(
        "| frame | G-buffer, bytes a pixel | held | written | ms | from ours, of 255: mean | most |\n|---|---|---|---|---|---|---|"
    );

    let colours = Content::new(Variety::Colour);
    let ours = shot.ours(&mut renderer, &colours, LightCulling::Clustered)?;
    let three = shot.layout(&gpu, &ThreeTargets::new(device, &colours, aspect), limits)?;
    print_row("three targets, a pass for every light", &three, &ours);
    print_row("ours, clustered", &ours, &ours);
    let first_row = [three, ours];

    let everything = Content::new(Variety::Everything);
    let ours = shot.ours(&mut renderer, &everything, LightCulling::Clustered)?;
    // What WebGL 2 allows is planned with its limits wherever this runs.
    let two_passes = FloatPositions::new(device, &everything, aspect, false);
    let two_passes = shot.layout(&gpu, &two_passes, Limits::WEBGL2)?;
    print_row("float positions, two geometry passes", &two_passes, &ours);
    if limits.max_color_bytes_per_sample >= ONE_PASS_BYTES_PER_SAMPLE {
        let layout = FloatPositions::new(device, &everything, aspect, true);
        let one_pass = shot.layout(&gpu, &layout, limits)?;
        print_row("float positions, one geometry pass", &one_pass, &ours);
        if one_pass.rgba8 != two_passes.rgba8 {
            return Err("one geometry pass and two make different pictures".into());
        }
    }
    let volumes = shot.ours(&mut renderer, &everything, LightCulling::VolumesStencil)?;
    print_row("ours, volumes-stencil", &volumes, &ours);
    print_row("ours, clustered", &ours, &ours);

    let picture = beside(&[first_row, [two_passes, ours]], size.0);
    Ok(image::save_buffer(out, &picture, 2 * size.0, 2 * size.1, image::ColorType::Rgb8)?)
}

fn print_row(name: &str, measured: &Measured, ours: &Measured) {
    let Measured { rgba8, gbuffer_bytes, held_bytes, written_bytes, frame_ms } = measured;
    let pixels = || rgba8.chunks_exact(4).zip(ours.rgba8.chunks_exact(4));
    let differences = || pixels().flat_map(|(a, b)| a.iter().zip(b).take(3)).map(|(a, b)| a.abs_diff(*b));
    let most = differences().max().unwrap_or_default();
    let mean = differences().map(f64::from).sum::<f64>() / (rgba8.len() / 4 * 3).max(1) as f64;
    println!(
        "| {name} | {gbuffer_bytes:.1} | {held_bytes:.1} | {written_bytes:.1} | {frame_ms:.1} | {mean:.2} | {most} |"
    );
}

/// Pictures of this width in rows of two, without alpha.
fn beside(rows: &[[Measured; 2]], width_px: u32) -> Vec<u8> {
    let row_bytes = 4 * width_px as usize;
    let mut rgb8 = Vec::new();
    for [left, right] in rows {
        for (left, right) in left.rgba8.chunks_exact(row_bytes).zip(right.rgba8.chunks_exact(row_bytes)) {
            for pixel in left.chunks_exact(4).chain(right.chunks_exact(4)) {
                rgb8.extend_from_slice(&pixel[..3]);
            }
        }
    }
    rgb8
}
