//! What both layouts need of the device: buffers, and pipelines that find their bindings in the shader.

use crate::content::{Content, FrameUniform, LightVertex, SurfaceVertex};
use manypass::graph::{PassContext, ReadKey};
use manypass::scene::primitives;
use std::ops::Range;
use wgpu::util::DeviceExt as _;

/// The format of the picture, and of what adds up to it.
pub const DISPLAY: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

/// The content on the device.
pub struct Buffers {
    pub frame: wgpu::Buffer,
    surfaces: Mesh,
    lights: wgpu::Buffer,
    pub light_count: u32,
    /// Of 1 m.
    ball: Mesh,
}

struct Mesh {
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    index_count: u32,
}

impl Mesh {
    fn new(device: &wgpu::Device, label: &str, vertices: &[u8], indices: &[u32]) -> Self {
        Self {
            vertices: filled(device, label, wgpu::BufferUsages::VERTEX, vertices),
            indices: filled(device, label, wgpu::BufferUsages::INDEX, bytemuck::cast_slice(indices)),
            index_count: indices.len() as u32,
        }
    }

    fn draw(&self, render_pass: &mut wgpu::RenderPass<'_>, instances: Range<u32>) {
        render_pass.set_vertex_buffer(0, self.vertices.slice(..));
        render_pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
        render_pass.draw_indexed(0..self.index_count, 0, instances);
    }
}

fn filled(device: &wgpu::Device, label: &str, usage: wgpu::BufferUsages, contents: &[u8]) -> wgpu::Buffer {
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(label), contents, usage })
}

impl Buffers {
    /// For pictures whose width is `aspect` times their height.
    pub fn new(device: &wgpu::Device, content: &Content, aspect: f32) -> Self {
        let ball = primitives::uv_sphere(1.0, 32, 16);
        let uniform = wgpu::BufferUsages::UNIFORM;
        let vertices = bytemuck::cast_slice(&content.vertices);
        Self {
            frame: filled(device, "frame", uniform, bytemuck::bytes_of(&FrameUniform::new(aspect))),
            surfaces: Mesh::new(device, "surfaces", vertices, &content.indices),
            lights: filled(device, "lights", wgpu::BufferUsages::VERTEX, bytemuck::cast_slice(&content.lights)),
            light_count: content.lights.len() as u32,
            ball: Mesh::new(device, "ball", bytemuck::cast_slice(&ball.positions), &ball.indices),
        }
    }

    /// Draws all surfaces, each vertex beside the light of this index.
    pub fn draw_surfaces(&self, render_pass: &mut wgpu::RenderPass<'_>, light: u32) {
        render_pass.set_vertex_buffer(1, self.lights.slice(..));
        self.surfaces.draw(render_pass, light..light + 1);
    }

    /// Draws the ball around what a light reaches.
    pub fn draw_volume(&self, render_pass: &mut wgpu::RenderPass<'_>, light: u32) {
        render_pass.set_vertex_buffer(1, self.lights.slice(..));
        self.ball.draw(render_pass, light..light + 1);
    }

    /// Draws a triangle over the whole picture for a light.
    pub fn draw_fullscreen(&self, render_pass: &mut wgpu::RenderPass<'_>, light: u32) {
        render_pass.set_vertex_buffer(1, self.lights.slice(..));
        render_pass.draw(0..3, light..light + 1);
    }
}

/// What is drawn, beside a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PassGeometry {
    Surfaces,
    Volumes,
    /// Without vertices of its own.
    Fullscreen,
}

/// A pipeline, in short.
pub struct Step<'a> {
    pub drawn: PassGeometry,
    /// Entry points.
    pub vertex: &'a str,
    pub fragment: &'a str,
    pub targets: &'a [wgpu::ColorTargetState],
    pub cull_mode: Option<wgpu::Face>,
    pub depth_stencil: Option<wgpu::DepthStencilState>,
}

impl Step<'_> {
    pub fn pipeline(self, device: &wgpu::Device, module: &wgpu::ShaderModule) -> wgpu::RenderPipeline {
        let surface =
            wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x3, 3 => Float32x3, 4 => Float32x2];
        let corner = wgpu::vertex_attr_array![0 => Float32x3];
        let light = wgpu::vertex_attr_array![5 => Float32x4, 6 => Float32x4];
        let per_vertex = |array_stride: usize, attributes| wgpu::VertexBufferLayout {
            array_stride: array_stride as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes,
        };
        let own = match self.drawn {
            PassGeometry::Surfaces => Some(per_vertex(size_of::<SurfaceVertex>(), &surface[..])),
            PassGeometry::Volumes => Some(per_vertex(12, &corner[..])),
            PassGeometry::Fullscreen => None,
        };
        let lights = wgpu::VertexBufferLayout {
            array_stride: size_of::<LightVertex>() as u64,
            step_mode: wgpu::VertexStepMode::Instance,
            attributes: &light,
        };
        let targets: Vec<_> = self.targets.iter().cloned().map(Some).collect();
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(self.fragment),
            layout: None,
            vertex: wgpu::VertexState {
                module,
                entry_point: Some(self.vertex),
                compilation_options: Default::default(),
                buffers: &[own, Some(lights)],
            },
            primitive: wgpu::PrimitiveState { cull_mode: self.cull_mode, ..Default::default() },
            depth_stencil: self.depth_stencil,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module,
                entry_point: Some(self.fragment),
                compilation_options: Default::default(),
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// A target that is overwritten.
pub fn overwritten(format: wgpu::TextureFormat) -> wgpu::ColorTargetState {
    format.into()
}

/// A target that light is added to.
pub fn added_to(format: wgpu::TextureFormat) -> wgpu::ColorTargetState {
    let component = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Add,
    };
    let blend = Some(wgpu::BlendState { color: component, alpha: component });
    wgpu::ColorTargetState { format, blend, write_mask: wgpu::ColorWrites::ALL }
}

/// The frame's uniform, if the pipeline uses it, and textures by their bindings.
pub fn bind_group(
    context: &PassContext<'_, '_>,
    pipeline: &wgpu::RenderPipeline,
    frame: Option<&wgpu::Buffer>,
    textures: &[(u32, ReadKey)],
) -> wgpu::BindGroup {
    let mut entries = Vec::with_capacity(1 + textures.len());
    if let Some(buffer) = frame {
        entries.push(wgpu::BindGroupEntry { binding: 0, resource: buffer.as_entire_binding() });
    }
    for (binding, read) in textures {
        // A group that lacks what its pass has not declared is refused, as the frame is.
        let Some(view) = context.view(*read) else { continue };
        entries.push(wgpu::BindGroupEntry { binding: *binding, resource: wgpu::BindingResource::TextureView(view) });
    }
    let layout = pipeline.get_bind_group_layout(0);
    let descriptor = wgpu::BindGroupDescriptor { label: Some(context.name()), layout: &layout, entries: &entries };
    context.device.create_bind_group(&descriptor)
}

/// Sets a pipeline and its [`bind_group`].
pub fn bind(
    context: &mut PassContext<'_, '_>,
    pipeline: &wgpu::RenderPipeline,
    frame: Option<&wgpu::Buffer>,
    textures: &[(u32, ReadKey)],
) {
    let group = bind_group(context, pipeline, frame, textures);
    context.render_pass.set_pipeline(pipeline);
    context.render_pass.set_bind_group(0, &group, &[]);
}
