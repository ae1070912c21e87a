//! Small buffers and tables that every frame fills anew.

use crate::constants::{DIRECTIONAL_ALBEDO_SIZE, LIGHTS_PER_ROW, LIST_WIDTH, TABLE_WIDTH, TEXELS_PER_LIGHT};
use crate::draws::DrawList;
use crate::environment::EnvironmentUniform;
use crate::gpu::Gpu;
use crate::gpu::data_texture::DataTexture;
use crate::passes::accumulate::AccumulationUniform;
use crate::passes::lights::{ClusterLists, LightTable};
use crate::passes::motion::MotionUniform;
use crate::passes::present::PresentUniform;
use crate::passes::tone_map::ToneMapUniform;
use crate::request::FrameRequest;
use crate::view::ViewUniform;

/// Small buffers and tables that every frame fills anew.
#[derive(Debug)]
pub(crate) struct FrameBuffers {
    pub view: wgpu::Buffer,
    /// The view of variables, where the picture is shaded at another size than its own.
    pub variables_view: wgpu::Buffer,
    pub cluster_grid: wgpu::Buffer,
    pub environment: wgpu::Buffer,
    pub accumulation: wgpu::Buffer,
    pub tone_map: wgpu::Buffer,
    pub present: wgpu::Buffer,
    pub motion: wgpu::Buffer,
    pub lights: DataTexture,
    pub cluster_table: DataTexture,
    pub cluster_lights: DataTexture,
    pub instances: wgpu::Buffer,
    pub directional_albedo: wgpu::TextureView,
    pub linear_clamp: wgpu::Sampler,
    pub nearest_clamp: wgpu::Sampler,
}

impl FrameBuffers {
    pub fn new(gpu: &Gpu) -> Self {
        let uniform = |label, size: usize| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: size as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let table = |label, format, width| DataTexture::new(&gpu.device, label, format, width);
        let sampler = |label, filter| {
            gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some(label),
                mag_filter: filter,
                min_filter: filter,
                ..Default::default()
            })
        };
        Self {
            view: uniform("view", size_of::<ViewUniform>()),
            variables_view: uniform("aov.view", size_of::<ViewUniform>()),
            cluster_grid: uniform("cluster_grid", 32),
            environment: uniform("environment", size_of::<EnvironmentUniform>()),
            accumulation: uniform("accumulation", size_of::<AccumulationUniform>()),
            tone_map: uniform("tone_map", size_of::<ToneMapUniform>()),
            present: uniform("present", size_of::<PresentUniform>()),
            motion: uniform("motion", size_of::<MotionUniform>()),
            lights: table("lights", wgpu::TextureFormat::Rgba32Float, LIGHTS_PER_ROW * TEXELS_PER_LIGHT),
            cluster_table: table("cluster_table", wgpu::TextureFormat::Rg32Uint, TABLE_WIDTH),
            cluster_lights: table("cluster_lights", wgpu::TextureFormat::R16Uint, LIST_WIDTH),
            instances: create_instances(gpu, 64),
            directional_albedo: upload_directional_albedo(gpu),
            linear_clamp: sampler("linear_clamp", wgpu::FilterMode::Linear),
            nearest_clamp: sampler("nearest_clamp", wgpu::FilterMode::Nearest),
        }
    }

    #[allow(clippy::too_many_arguments, reason = "each is one of the frame's inputs, used once")]
    pub fn write(
        &mut self,
        gpu: &Gpu,
        request: &FrameRequest,
        uniform: &ViewUniform,
        environment: &EnvironmentUniform,
        table: &LightTable,
        lists: &ClusterLists,
        draws: &DrawList,
    ) {
        let queue = &gpu.queue;
        queue.write_buffer(&self.view, 0, bytemuck::bytes_of(uniform));
        queue.write_buffer(&self.cluster_grid, 0, bytemuck::bytes_of(&lists.uniform));
        queue.write_buffer(&self.environment, 0, bytemuck::bytes_of(environment));
        // The mean of the frames so far, so that the picture can be shown at any time.
        let weight = 1.0 / (request.sample_index as f32 + 1.0);
        let accumulation = AccumulationUniform {
            weight,
            keep: 1.0 - weight,
            inverse_size_px: [1.0 / request.width as f32, 1.0 / request.height as f32],
            exposure: request.display_exposure(),
            ..bytemuck::Zeroable::zeroed()
        };
        queue.write_buffer(&self.accumulation, 0, bytemuck::bytes_of(&accumulation));
        // Where the samples went through the curve, exposure did its work.
        let exposure = if request.averages_display() { 1.0 } else { request.display_exposure() };
        let tone_map = ToneMapUniform::new(request.background, request.settings.tone_map.dither, exposure);
        queue.write_buffer(&self.tone_map, 0, bytemuck::bytes_of(&tone_map));
        self.lights.write(&gpu.device, queue, &table.texels);
        self.cluster_table.write(&gpu.device, queue, &lists.table);
        self.cluster_lights.write(&gpu.device, queue, &lists.lights);
        let bytes: &[u8] = bytemuck::cast_slice(&draws.instances);
        if bytes.len() as u64 > self.instances.size() {
            self.instances = create_instances(gpu, (bytes.len() as u64).next_power_of_two());
        }
        if !bytes.is_empty() {
            queue.write_buffer(&self.instances, 0, bytes);
        }
    }

    /// Names of group 0, with what they stand for; `view` is the buffer of one of the views.
    pub fn frame_resources<'b>(&'b self, view: &'b wgpu::Buffer) -> [(&'static str, wgpu::BindingResource<'b>); 9] {
        [
            ("view", view.as_entire_binding()),
            ("directional_albedo", wgpu::BindingResource::TextureView(&self.directional_albedo)),
            ("linear_clamp", wgpu::BindingResource::Sampler(&self.linear_clamp)),
            ("cluster_grid", self.cluster_grid.as_entire_binding()),
            ("lights", wgpu::BindingResource::TextureView(self.lights.view())),
            ("cluster_table", wgpu::BindingResource::TextureView(self.cluster_table.view())),
            ("cluster_lights", wgpu::BindingResource::TextureView(self.cluster_lights.view())),
            ("environment", self.environment.as_entire_binding()),
            ("motion", self.motion.as_entire_binding()),
        ]
    }
}

fn create_instances(gpu: &Gpu, size: u64) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("instances"),
        size,
        usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// The table of `build.rs` as half floats, which every backend can filter.
fn upload_directional_albedo(gpu: &Gpu) -> wgpu::TextureView {
    let size =
        wgpu::Extent3d { width: DIRECTIONAL_ALBEDO_SIZE, height: DIRECTIONAL_ALBEDO_SIZE, depth_or_array_layers: 1 };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("directional_albedo"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rg16Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let texels: Vec<u16> =
        crate::shader::compose::DIRECTIONAL_ALBEDO.iter().flatten().map(|value| half_from_unit(*value)).collect();
    gpu.queue.write_texture(
        texture.as_image_copy(),
        bytemuck::cast_slice(&texels),
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(DIRECTIONAL_ALBEDO_SIZE * 4),
            rows_per_image: None,
        },
        size,
    );
    texture.create_view(&Default::default())
}

/// A half float of a value from 0 to 2, rounded to nearest; values below 2⁻¹⁴ become denormal.
fn half_from_unit(value: f32) -> u16 {
    let bits = value.max(0.0).to_bits();
    let exponent = (bits >> 23) as i32 - 127 + 15;
    if exponent <= 0 {
        return (value * 16_777_216.0).round() as u16;
    }
    let rounded = (bits & 0x7f_ffff) + 0x1000;
    (((exponent as u32) << 10) + (rounded >> 13)) as u16
}
