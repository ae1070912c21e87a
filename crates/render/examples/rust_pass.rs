//! An effect in Rust, with a target, a history and pipelines of its own: what glows leaves an afterimage that fades
//! from frame to frame. `cargo run --release -p manypass --example rust_pass -- [OUT.png]`.

use manypass::graph::{ColorLoad, Handle, TextureDesc};
use manypass::scene::{Material, Node, Primitive, Scene, primitives};
use manypass::shader::ProgramError;
use manypass::{Background, Effect, FrameRequest, Gbuffer, Gpu, Recorder, Renderer, glam, wgpu};
use std::sync::Arc;

/// The passes' shaders.
const WGSL: &str = include_str!("rust_pass.wgsl");

#[derive(Debug)]
struct Afterimage {
    keep: wgpu::RenderPipeline,
    show: wgpu::RenderPipeline,
}

impl Afterimage {
    fn new(device: &wgpu::Device) -> Self {
        let source = wgpu::ShaderSource::Wgsl(WGSL.into());
        let module = &device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
        let pipeline = |entry_point: &str| {
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(entry_point),
                layout: None,
                vertex: wgpu::VertexState {
                    module,
                    entry_point: Some("vs_screen"),
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                primitive: Default::default(),
                depth_stencil: None,
                multisample: Default::default(),
                fragment: Some(wgpu::FragmentState {
                    module,
                    entry_point: Some(entry_point),
                    compilation_options: Default::default(),
                    // Radiance is in half floats.
                    targets: &[Some(wgpu::TextureFormat::Rgba16Float.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        Self { keep: pipeline("fs_keep"), show: pipeline("fs_show") }
    }
}

impl Effect for Afterimage {
    fn record<'f>(
        &'f self,
        r: &mut Recorder<'_, 'f>,
        _: Option<&Gbuffer>,
        radiance: Handle,
    ) -> Result<Handle, ProgramError> {
        let whole = radiance.desc();
        let half = TextureDesc { width: whole.width.div_ceil(2), height: whole.height.div_ceil(2), ..whole };
        let history = r.history("afterimage.history", half);
        // The first frame has no history yet.
        let previous = if history.is_first { &radiance } else { &history.previous };
        let kept = pass(r, "afterimage.keep", &self.keep, [&radiance, previous], history.next);
        let shown = r.texture_of("afterimage", whole);
        Ok(pass(r, "afterimage.show", &self.show, [&radiance, &kept], shown))
    }
}

/// A full-screen pass that reads two textures. The graph finds out when they live, and what has to be stored.
fn pass<'f>(
    r: &mut Recorder<'_, 'f>,
    name: &'static str,
    pipeline: &'f wgpu::RenderPipeline,
    read: [&Handle; 2],
    target: Handle,
) -> Handle {
    let mut pass = r.graph.pass(name);
    let read = read.map(|handle| pass.read(handle));
    let target = pass.color(target, ColorLoad::Discard);
    pass.draw(move |context| {
        let [Some(a), Some(b)] = read.map(|read| context.view(read)) else { return };
        let entry =
            |binding, view| wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::TextureView(view) };
        let (layout, entries) = (&pipeline.get_bind_group_layout(0), &[entry(0, a), entry(1, b)]);
        let group = context.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries });
        context.render_pass.set_pipeline(pipeline);
        context.render_pass.set_bind_group(0, &group, &[]);
        context.render_pass.draw(0..3, 0..1);
    });
    target
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let out = std::env::args().nth(1).unwrap_or("rust_pass.png".into());
    let mut scene = Scene::default();
    let glow = scene.add_material(Material { emissive_factor: glam::Vec3::new(1.0, 0.4, 0.1), ..Default::default() });
    let ball = scene.add_mesh(Primitive { material: Some(glow), ..primitives::uv_sphere(0.5, 48, 24) });
    let ball = scene.add_node(None, Node { mesh: Some(ball), ..Default::default() });
    scene.update_transforms();

    let mut renderer = Renderer::new(Gpu::headless(None)?)?;
    let mut request = FrameRequest { goes_on: true, ..FrameRequest::of_scene(&scene, 320, 180) };
    request.settings.background.source = Background::Color([0.0; 3]);
    request.effects = vec![Arc::new(Afterimage::new(&renderer.gpu().device))];
    request.camera.world_from_view = glam::Mat4::from_translation(glam::Vec3::new(0.0, 0.0, 5.0));
    // The ball comes from the left and ends in the middle.
    for frame in 0..=12 {
        scene.node_mut(ball).translation.x = (frame - 12) as f32 * 0.2;
        scene.update_transforms();
        renderer.render(&scene, &request)?;
    }
    Ok(image::save_buffer(out, &renderer.read_display()?, 320, 180, image::ColorType::Rgba8)?)
}
