//! Puts a pass of one's own into the frame: the WGSL beside this file draws lines where depth or direction changes, from
//! the G-buffer, before exposure and tone curve. `cargo run --release --example own_pass -- [OUT.png]`.

use manypass::{FrameRequest, Gpu, Renderer, WgslEffect, scene};
use std::sync::Arc;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let out = std::env::args().nth(1).unwrap_or("own_pass.png".into());
    let scene = scene::demo::hall();
    let mut renderer = Renderer::new(Gpu::headless(None)?)?;
    renderer.load(&scene)?;

    // The file gives every setting its default and its range; those that nobody sets keep the default.
    let effect = WgslEffect::new(renderer.gpu(), "own_pass.wgsl", include_str!("own_pass.wgsl"))?;
    effect.set("own_pass.line_color", "0.9, 0.7, 0.4")?;
    for (key, value) in effect.values() {
        println!("{key} = {value}");
    }

    let mut request = FrameRequest::of_scene(&scene, 640, 360);
    request.effects.push(Arc::new(effect));
    renderer.render(&scene, &request)?;
    println!("{}", renderer.plan(&scene, &request)?.to_text());
    Ok(image::save_buffer(out, &renderer.read_display()?, 640, 360, image::ColorType::Rgba8)?)
}
