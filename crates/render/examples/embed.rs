//! Renders into a texture of one's own, on one's own device and queue, between one's own commands: they clear the
//! texture to a colour before and draw a bar over the picture afterwards. `cargo run --release --example embed --
//! [OUT.png]`.

use manypass::{Background, FrameRequest, Gpu, Renderer, Target, scene, wgpu};

const WIDTH: u32 = 320;
const HEIGHT: u32 = 200;
/// The frame that the picture leaves free, in texels.
const BORDER: u32 = 10;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let out = std::env::args().nth(1).unwrap_or("embed.png".into());
    // What an application has already: adapter, device, queue, and a texture to show.
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&Default::default()))?;
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_features: adapter.features() & wgpu::Features::DEPTH32FLOAT_STENCIL8,
        required_limits: adapter.limits(),
        ..Default::default()
    }))?;
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("application"),
        size: wgpu::Extent3d { width: WIDTH, height: HEIGHT, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });

    // Before: the application clears its texture.
    let mut encoder = device.create_command_encoder(&Default::default());
    clear(&mut encoder, &texture, wgpu::Color { r: 0.05, g: 0.2, b: 0.6, a: 1.0 });
    queue.submit([encoder.finish()]);

    // Manypass draws within the border. Where there is no surface, the application's colour shows through.
    let mut renderer = Renderer::new(Gpu::from_device(&adapter, device.clone(), queue.clone())?)?;
    let scene = demo_ball();
    renderer.load(&scene)?;
    let (width, height) = (WIDTH - 2 * BORDER, HEIGHT - 2 * BORDER);
    let target = Target { rectangle: [BORDER, BORDER, width, height], ..Target::whole(&texture) };
    let mut request = FrameRequest::of_scene(&scene, width, height);
    request.settings.background.source = Background::Transparent;
    renderer.render_to(&scene, &request, &target)?;

    // After: the application draws over the picture, and reads the whole back.
    let bar = [255u8, 200, 0, 255].repeat(WIDTH as usize * 4);
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(WIDTH * 4), rows_per_image: None };
    let size = wgpu::Extent3d { width: WIDTH, height: 4, depth_or_array_layers: 1 };
    let origin = wgpu::Origin3d { x: 0, y: HEIGHT - 30, z: 0 };
    queue.write_texture(wgpu::TexelCopyTextureInfo { origin, ..texture.as_image_copy() }, &bar, layout, size);
    let rgba8 = pollster::block_on(manypass::gpu::readback::read_texture(renderer.gpu(), &texture))?;
    image::save_buffer(out, &rgba8, WIDTH, HEIGHT, image::ColorType::Rgba8)?;
    check(&rgba8)
}

/// A red ball under the studio.
fn demo_ball() -> scene::Scene {
    let mut scene = scene::Scene::default();
    let base_color_factor = [0.8, 0.05, 0.04, 1.0].into();
    let (metallic_factor, roughness_factor) = (0.0, 0.3);
    scene.materials.push(scene::Material {
        base_color_factor,
        metallic_factor,
        roughness_factor,
        ..Default::default()
    });
    let ball = scene::Primitive { material: Some(0), ..scene::primitives::uv_sphere(1.0, 64, 32) };
    scene.meshes.push(scene::Mesh { primitives: vec![ball], ..Default::default() }.into());
    scene.add_node(None, scene::Node { mesh: Some(0), ..Default::default() });
    scene.update_transforms();
    scene
}

fn clear(encoder: &mut wgpu::CommandEncoder, texture: &wgpu::Texture, color: wgpu::Color) {
    let view = texture.create_view(&Default::default());
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("application.clear"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: &view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(color), store: wgpu::StoreOp::Store },
        })],
        ..Default::default()
    });
}

/// The border and what is behind the ball are the application's, the bar lies over the picture, and the ball is red.
fn check(rgba8: &[u8]) -> Result<(), Box<dyn std::error::Error>> {
    let pixel = |x: u32, y: u32| {
        let at = (y * WIDTH + x) as usize * 4;
        [rgba8[at], rgba8[at + 1], rgba8[at + 2]]
    };
    let cleared = pixel(0, 0);
    let is_close = |a: [u8; 3], b: [u8; 3]| a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= 2);
    let [red, green, blue] = pixel(WIDTH / 2, HEIGHT / 2);
    let tests = [
        // 0.05, 0.2 and 0.6 of linear light.
        ("the border", is_close(cleared, [63, 124, 203]) && is_close(pixel(WIDTH - 1, HEIGHT - 1), cleared)),
        ("what shows through", is_close(pixel(BORDER + 2, BORDER + 2), cleared)),
        ("the bar", is_close(pixel(WIDTH / 2, HEIGHT - 28), [255, 200, 0])),
        ("the ball", red > 80 && red > 2 * green && red > 2 * blue),
    ];
    match tests.iter().find(|(_, is_right)| !is_right) {
        Some((what, _)) => Err(format!("{what} is wrong: middle {:?}, corner {cleared:?}", [red, green, blue]).into()),
        None => Ok(()),
    }
}
