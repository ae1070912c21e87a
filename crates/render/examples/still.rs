//! Renders a glTF file, or the demo, to a PNG: `cargo run --release --example still -- [MODEL.glb] [OUT.png]`.
use manypass::{Exposure, FrameRequest, Gpu, Renderer, scene};
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (model, out) = (std::env::args().nth(1), std::env::args().nth(2).unwrap_or("still.png".into()));
    let scene = model.map_or(Ok(scene::demo::hall()), |file| scene::load_path(file.as_ref()).map(|it| it.scene))?;
    let mut renderer = Renderer::new(Gpu::headless(None)?)?;
    renderer.load(&scene)?;
    let mut request = FrameRequest { sample_count: 8, ..FrameRequest::of_scene(&scene, 960, 540) };
    renderer.expose(&scene, &mut request, Exposure::of_scene(&scene))?;
    for sample_index in 0..request.sample_count {
        request.sample_index = sample_index;
        renderer.render(&scene, &request)?;
    }
    Ok(image::save_buffer(out, &renderer.read_display()?, 960, 540, image::ColorType::Rgba8)?)
}
