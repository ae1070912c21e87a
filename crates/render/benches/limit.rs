//! The limit of lighting: a bare full-screen loop over lights in a data texture, at 960×540. It says what a pair of
//! pixel and light costs on an adapter if nothing else is done; `cargo xtask bench` holds the renderer against it.
//! `cargo bench -p manypass --bench limit`, with `-- --json` for one line of JSON.

use manypass::gpu::readback::read_texture;
use manypass::{Gpu, GpuError};
use serde_json::json;
use std::error::Error;
use std::f64::consts::PI;
use std::time::Instant;

const WIDTH: u32 = 960;
const HEIGHT: u32 = 540;
/// Two numbers of lights: what a frame costs besides the pairs falls out of the difference, and is near the first.
const FEW: usize = 4;
const MANY: usize = 64;
/// The least of so many runs of each is taken.
const RUNS: usize = 14;
/// Two more in each than the first, in which the driver compiles.
const WARM_UP_RUNS: usize = 2;
/// Half floats have eleven bits, and square roots of software adapters few more.
const TOLERANCE: f64 = 0.004;

/// Position and 1 / range²; intensity times colour.
type Light = [[f32; 4]; 2];

/// Lights above the surfaces, spread as multiples of irrational numbers are.
fn lights() -> Vec<Light> {
    (0..MANY)
        .map(|index| {
            let spread = |step: f64| (step * (index + 1) as f64).fract() as f32;
            let place = [16.0 * spread(0.618_034) - 8.0, 0.8 + 1.5 * spread(0.414_214), 9.0 * spread(0.732_051) - 4.5];
            let range_m = 6.0 + 14.0 * spread(0.236_068);
            let color = [1.0 + spread(0.645_751), 1.0 + spread(0.316_625), 1.0 + spread(0.605_551)];
            [[place[0], place[1], place[2], range_m.powi(-2)], [color[0], color[1], color[2], 0.0]]
        })
        .collect()
}

/// What draws the loop, and what it draws to.
struct Loop {
    gpu: Gpu,
    target: wgpu::Texture,
    view: wgpu::TextureView,
    pipeline: wgpu::RenderPipeline,
    /// For [`FEW`] and [`MANY`] lights.
    bindings: [wgpu::BindGroup; 2],
}

impl Loop {
    fn new(gpu: Gpu, lights: &[Light]) -> Self {
        let device = &gpu.device;
        let module = device.create_shader_module(wgpu::include_wgsl!("limit.wgsl"));
        let target = texture(device, "limit", wgpu::TextureFormat::Rgba16Float, (WIDTH, HEIGHT));
        let table = texture(device, "lights", wgpu::TextureFormat::Rgba32Float, (2 * lights.len() as u32, 1));
        let bytes: &[u8] = bytemuck::cast_slice(lights);
        let layout = wgpu::TexelCopyBufferLayout { bytes_per_row: Some(bytes.len() as u32), ..Default::default() };
        gpu.queue.write_texture(table.as_image_copy(), bytes, layout, table.size());
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("limit"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vs_screen"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("fs_lights"),
                compilation_options: Default::default(),
                targets: &[Some(target.format().into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let table = table.create_view(&Default::default());
        let bindings = [FEW, MANY].map(|count| {
            let size = uniform(&gpu, [(WIDTH as f32).to_bits(), (HEIGHT as f32).to_bits(), count as u32, 0]);
            device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("limit"),
                layout: &pipeline.get_bind_group_layout(0),
                entries: &[
                    wgpu::BindGroupEntry { binding: 0, resource: size.as_entire_binding() },
                    wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&table) },
                ],
            })
        });
        let view = target.create_view(&Default::default());
        Self { gpu, target, view, pipeline, bindings }
    }

    /// Draws once with the lights of a binding, and says how many milliseconds that took.
    fn draw(&self, bindings: &wgpu::BindGroup) -> Result<f64, GpuError> {
        let started = Instant::now();
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("limit"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, bindings, &[]);
        pass.draw(0..3, 0..1);
        drop(pass);
        self.gpu.queue.submit([encoder.finish()]);
        let waited = self.gpu.device.poll(wgpu::PollType::wait_indefinitely());
        waited.map_err(|error| GpuError::Lost(error.to_string()))?;
        self.gpu.check()?;
        Ok(started.elapsed().as_secs_f64() * 1e3)
    }

    /// The least time of a draw with few and with many lights, in milliseconds; both take turns.
    fn least_ms(&self) -> Result<[f64; 2], GpuError> {
        let mut least_ms = [f64::INFINITY; 2];
        for run in 0..WARM_UP_RUNS + RUNS {
            for (least_ms, bindings) in least_ms.iter_mut().zip(&self.bindings) {
                let ms = self.draw(bindings)?;
                if run >= WARM_UP_RUNS {
                    *least_ms = least_ms.min(ms);
                }
            }
        }
        Ok(least_ms)
    }

    /// Compares pixels of the last draw, that of many lights, with the same sum in double precision.
    fn check_sums(&self, lights: &[Light]) -> Result<(), Box<dyn Error>> {
        let bytes = pollster::block_on(read_texture(&self.gpu, &self.target))?;
        for [x, y] in [[137, 75], [480, 270], [901, 433]] {
            let start = 8 * (y * WIDTH + x) as usize;
            let expected = sum_at(x, y, lights);
            for (channel, expected) in expected.into_iter().enumerate() {
                let bytes = [bytes[start + 2 * channel], bytes[start + 2 * channel + 1]];
                let found = from_half(u16::from_le_bytes(bytes));
                if (found - expected).abs() > TOLERANCE * expected {
                    return Err(format!("pixel {x}, {y} channel {channel}: {found} drawn, {expected} computed").into());
                }
            }
        }
        Ok(())
    }
}

fn texture(
    device: &wgpu::Device,
    label: &str,
    format: wgpu::TextureFormat,
    (width, height): (u32, u32),
) -> wgpu::Texture {
    let usage = if format == wgpu::TextureFormat::Rgba32Float {
        wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST
    } else {
        wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC
    };
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

fn uniform(gpu: &Gpu, words: [u32; 4]) -> wgpu::Buffer {
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("size"),
        size: size_of_val(&words) as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    gpu.queue.write_buffer(&buffer, 0, bytemuck::bytes_of(&words));
    buffer
}

/// A normal half float.
fn from_half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 0 { 1.0 } else { -1.0 };
    let exponent = i32::from(bits >> 10 & 0x1f) - 15;
    sign * (1.0 + f64::from(bits & 0x3ff) / 1024.0) * f64::from(exponent).exp2()
}

type Vec3 = [f64; 3];

fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(a: Vec3) -> Vec3 {
    a.map(|x| x / dot(a, a).sqrt())
}

/// The radiance of a pixel, light after light, each by the formulas of glTF 2.0, appendix B.
fn sum_at(x: u32, y: u32, lights: &[Light]) -> Vec3 {
    let [u, v] = [(f64::from(x) + 0.5) / f64::from(WIDTH), (f64::from(y) + 0.5) / f64::from(HEIGHT)];
    let position = [16.0 * u - 8.0, 0.3 * (9.0 * u).sin() * (7.0 * v).cos(), 9.0 * v - 4.5];
    let normal = unit([0.4 * (23.0 * u).sin(), 1.0, 0.4 * (19.0 * v).cos()]);
    let to_eye = unit([-position[0], 6.0 - position[1], 8.0 - position[2]]);
    let albedo = [0.2 + 0.6 * u, 0.2 + 0.6 * v, 0.8 - 0.6 * u];
    let f0 = albedo.map(|albedo| 0.04 + (albedo - 0.04) * v);
    let roughness = 0.25 + 0.7 * u;
    let a2 = roughness.powi(4);
    let n_dot_v = dot(normal, to_eye);
    let mut radiance = [0.0; 3];
    for [place, color] in lights {
        let towards: Vec3 = std::array::from_fn(|axis| f64::from(place[axis]) - position[axis]);
        let distance_squared = dot(towards, towards);
        let window = (1.0 - (distance_squared * f64::from(place[3])).powi(2)).clamp(0.0, 1.0);
        let to_light = unit(towards);
        let n_dot_l = dot(normal, to_light);
        if n_dot_l <= 0.0 {
            continue;
        }
        let halfway = unit(std::array::from_fn(|axis| to_light[axis] + to_eye[axis]));
        let n_dot_h = dot(normal, halfway);
        let distribution = a2 / (PI * (n_dot_h * n_dot_h * (a2 - 1.0) + 1.0).powi(2));
        let smith = |a: f64, b: f64| a * (b * b * (1.0 - a2) + a2).sqrt();
        let visibility = 0.5 / (smith(n_dot_v, n_dot_l) + smith(n_dot_l, n_dot_v));
        for channel in 0..3 {
            let fresnel = f0[channel] + (1.0 - f0[channel]) * (1.0 - dot(to_eye, halfway)).powi(5);
            let compensation = 1.0 + 0.5 * f0[channel] * roughness;
            let reflected = (1.0 - fresnel) * albedo[channel] / PI + fresnel * distribution * visibility * compensation;
            radiance[channel] += reflected * n_dot_l * f64::from(color[channel]) * window / distance_squared;
        }
    }
    radiance
}

fn main() -> Result<(), Box<dyn Error>> {
    let lights = lights();
    let bare = Loop::new(Gpu::headless(None)?, &lights);
    let [few_ms, many_ms] = bare.least_ms()?;
    bare.check_sums(&lights)?;
    let pixels = f64::from(WIDTH) * f64::from(HEIGHT);
    let ms_per_light = (many_ms - few_ms) / (MANY - FEW) as f64;
    let ns_per_pair = ms_per_light * 1e6 / pixels;
    let fixed_ms = (few_ms - FEW as f64 * ms_per_light).max(0.0);
    let adapter = &bare.gpu.adapter.name;
    if std::env::args().any(|argument| argument == "--json") {
        println!("{}", json!({ "adapter": adapter, "ns_per_pair": ns_per_pair, "fixed_ms": fixed_ms }));
    } else {
        println!("    {ns_per_pair:.2} ns a pair of pixel and light, and {fixed_ms:.2} ms a frame, on {adapter}");
    }
    Ok(())
}
