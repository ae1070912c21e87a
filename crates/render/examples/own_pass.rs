//! Puts a pass of one's own into the frame: the WGSL beside this file draws lines where depth or direction changes, from
//! the G-buffer, before exposure and tone curve. `cargo run --release --example own_pass -- [OUT.png]`.

use manypass::{FrameRequest, Gpu, Renderer, WgslEffect, scene};
use std::sync::Arc;

/// The uniform of `own_pass.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Style {
    line_color: [f32; 3],
    vignette: f32,
    crease_cos: f32,
    step_share: f32,
    padding: [f32; 2],
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let out = std::env::args().nth(1).unwrap_or("own_pass.png".into());
    let scene = scene::demo::hall();
    let mut renderer = Renderer::new(Gpu::headless(None)?)?;
    renderer.load(&scene)?;

    let effect = WgslEffect::new(renderer.gpu(), "own_pass.wgsl", include_str!("own_pass.wgsl"))?;
    let style =
        Style { line_color: [0.9, 0.7, 0.4], vignette: 0.6, crease_cos: 0.8, step_share: 0.05, padding: [0.0; 2] };
    effect.set_uniform("style", bytemuck::bytes_of(&style))?;

    let mut request = FrameRequest::of_scene(&scene, 640, 360);
    request.effects.push(Arc::new(effect));
    renderer.render(&scene, &request)?;
    println!("{}", renderer.plan(&scene, &request)?.to_text());
    Ok(image::save_buffer(out, &renderer.read_display()?, 640, 360, image::ColorType::Rgba8)?)
}
