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
use layout::{Measurement, Shot};
use manypass::graph::Limits;
use manypass::{Gpu, LightCulling, Renderer};
use three_targets::ThreeTargets;

type Error = Box<dyn std::error::Error>;

/// What was drawn, and which of our own frames shows the same.
struct Row {
    name: &'static str,
    measured: Measurement,
    ours: usize,
}

fn main() -> Result<(), Error> {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let is_number = |argument: &String| argument.parse::<u32>().is_ok();
    let out = arguments.pop_if(|last| !is_number(last)).unwrap_or("textbook_layouts.png".into());
    let numbers: Vec<u32> = arguments.iter().map(|argument| argument.parse()).collect::<Result<_, _>>()?;
    let size = numbers.first().copied().zip(numbers.get(1).copied()).unwrap_or((960, 540));
    let rounds = numbers.get(2).copied().unwrap_or(10);

    let gpu = Gpu::headless(None)?;
    let mut renderer = Renderer::new(gpu.clone())?;
    let shot = Shot { size };
    let mut rows = draw_all(&gpu, &mut renderer, shot)?;
    // In turns, so that what else the machine does meets all alike; it only adds to the time, so the least one counts.
    for _ in 1..rounds {
        for (row, again) in rows.iter_mut().zip(draw_all(&gpu, &mut renderer, shot)?) {
            row.measured.frame_ms = row.measured.frame_ms.min(again.measured.frame_ms);
        }
    }
    println!("{}, {} × {} pixels, fastest of {rounds} frames, in turns", gpu.adapter.name, size.0, size.1);
    println!("| frame | G-buffer, bytes a pixel | held | written | ms | from ours, of 255: mean | most |");
    println!("|---|---|---|---|---|---|---|");
    for row in &rows {
        let ours = rows.get(row.ours).unwrap_or(row);
        print_row(row.name, &row.measured, &ours.measured);
    }
    let picture = beside(&rows, size.0);
    Ok(image::save_buffer(out, &picture, 2 * size.0, 2 * size.1, image::ColorType::Rgb8)?)
}

/// Our own frames are the first two rows, of the contents of the layouts that follow.
fn draw_all(gpu: &Gpu, renderer: &mut Renderer, shot: Shot) -> Result<Vec<Row>, Error> {
    let device = &gpu.device;
    let aspect = shot.size.0 as f32 / shot.size.1.max(1) as f32;
    let limits = Limits::from(&device.limits());
    let (colours, everything) = (Content::new(Variety::Colour), Content::new(Variety::Everything));
    let mut rows = Vec::new();
    let mut add = |name, measured, ours| rows.push(Row { name, measured, ours });
    add("ours, surfaces alike but for colour", shot.ours(renderer, &colours, LightCulling::Clustered)?, 0);
    add("ours", shot.ours(renderer, &everything, LightCulling::Clustered)?, 1);
    add("ours, volumes-stencil", shot.ours(renderer, &everything, LightCulling::VolumesStencil)?, 1);
    let layout = ThreeTargets::new(device, &colours, aspect);
    add("three targets, a pass for every light", shot.layout(gpu, &layout, limits)?, 0);
    // What WebGL 2 allows is planned with its limits wherever this runs.
    let layout = FloatPositions::new(device, &everything, aspect, false);
    add("float positions, two geometry passes", shot.layout(gpu, &layout, Limits::WEBGL2)?, 1);
    if limits.max_color_bytes_per_sample >= ONE_PASS_BYTES_PER_SAMPLE {
        let layout = FloatPositions::new(device, &everything, aspect, true);
        let measured = shot.layout(gpu, &layout, limits)?;
        if rows.last().is_some_and(|two_passes| two_passes.measured.rgba8 != measured.rgba8) {
            return Err("one geometry pass and two make different pictures".into());
        }
        rows.push(Row { name: "float positions, one geometry pass", measured, ours: 1 });
    }
    Ok(rows)
}

fn print_row(name: &str, measured: &Measurement, ours: &Measurement) {
    let Measurement { rgba8, gbuffer_bytes, held_bytes, written_bytes, frame_ms } = measured;
    let pixels = || rgba8.chunks_exact(4).zip(ours.rgba8.chunks_exact(4));
    let differences = || pixels().flat_map(|(a, b)| a.iter().zip(b).take(3)).map(|(a, b)| a.abs_diff(*b));
    let most = differences().max().unwrap_or_default();
    let mean = differences().map(f64::from).sum::<f64>() / (rgba8.len() / 4 * 3).max(1) as f64;
    println!(
        "| {name} | {gbuffer_bytes:.1} | {held_bytes:.1} | {written_bytes:.1} | {frame_ms:.1} | {mean:.2} | {most} |"
    );
}

/// Of each layout its picture and ours, of this width each, without alpha.
fn beside(rows: &[Row], width_px: u32) -> Vec<u8> {
    let row_bytes = 4 * width_px as usize;
    let mut rgb8 = Vec::new();
    for layout in ["three targets", "float positions, two"] {
        let Some(row) = rows.iter().find(|row| row.name.starts_with(layout)) else { continue };
        let Some(ours) = rows.get(row.ours) else { continue };
        let lines = row.measured.rgba8.chunks_exact(row_bytes).zip(ours.measured.rgba8.chunks_exact(row_bytes));
        for pixel in lines.flat_map(|(left, right)| left.chunks_exact(4).chain(right.chunks_exact(4))) {
            rgb8.extend_from_slice(&pixel[..3]);
        }
    }
    rgb8
}
