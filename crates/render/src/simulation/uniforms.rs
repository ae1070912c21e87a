//! What the passes of a simulation know: uniforms, and the surfaces that a camera of the scene sees.

use super::compiled::STATE;
use crate::gpu::Gpu;
use glam::{IVec2, Mat4, Vec2, Vec3};
use manypass_scene::simulation::{BODIES_MAX, SEEN_SIDE, SeenSurfaces};

/// What a simulation knows of its bodies at a step.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct BodyUniform {
    pub middle_m: Vec3,
    pub radius_m: f32,
    pub half_m: Vec3,
    pub is_wall: f32,
    pub before_m: Vec3,
    pub padding: f32,
}

/// The uniform of `prelude.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
pub(super) struct SimulationUniform {
    pub cells: IVec2,
    pub cell_m: Vec2,
    pub step: u32,
    pub step_secs: f32,
    pub time_secs: f32,
    pub seed: u32,
    pub body_count: u32,
    pub padding_a: u32,
    pub padding_b: Vec2,
    pub bodies: [BodyUniform; BODIES_MAX],
    pub world_from_place: Mat4,
}

/// The uniform of `surfaces.wgsl`; a test compares the two layouts.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
struct SeenUniform {
    view_from_world: Mat4,
    half_extent: Vec2,
    is_orthographic: f32,
    is_there: f32,
}

/// What a camera of the scene sees, for simulations that read it.
#[derive(Debug)]
pub(super) struct CameraView {
    pub uniform: wgpu::Buffer,
    pub surfaces: wgpu::TextureView,
}

impl CameraView {
    pub fn new(gpu: &Gpu, seen: Option<&SeenSurfaces>) -> Self {
        let side = if seen.is_some() { SEEN_SIDE } else { 1 };
        let size = wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 };
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("surfaces"),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: STATE,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let uniform = uniform_buffer(gpu, &SeenUniform::default());
        let made = Self { uniform, surfaces: texture.create_view(&Default::default()) };
        made.write(gpu, seen);
        made
    }

    /// Replaces what is seen, by as much as there was.
    pub fn write(&self, gpu: &Gpu, seen: Option<&SeenSurfaces>) {
        let texture = self.surfaces.texture();
        let side = texture.width();
        let nothing = [[0.0, 1.0, 0.0, f32::INFINITY]];
        let texels = seen.map_or(&nothing[..], |seen| &seen.texels);
        let is_there = seen.filter(|_| texels.len() == (side * side) as usize);
        let uniform = is_there.map(|seen| SeenUniform {
            view_from_world: seen.view_from_world,
            half_extent: seen.half,
            is_orthographic: if seen.is_orthographic { 1.0 } else { 0.0 },
            is_there: 1.0,
        });
        gpu.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&uniform.unwrap_or_default()));
        if is_there.is_some() {
            let layout =
                wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(16 * side), rows_per_image: Some(side) };
            gpu.queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(texels), layout, texture.size());
        }
    }
}

pub(super) fn uniform_buffer<T: bytemuck::NoUninit>(gpu: &Gpu, value: &T) -> wgpu::Buffer {
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("simulation"),
        size: size_of::<T>() as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    gpu.queue.write_buffer(&buffer, 0, bytemuck::bytes_of(value));
    buffer
}

#[cfg(test)]
mod tests {
    use super::super::SimulationFile;
    use super::*;
    use manypass_scene::simulation::Simulation;
    use std::mem::offset_of;

    #[test]
    fn the_uniforms_have_one_layout() {
        let file = SimulationFile::of_program(&Simulation::built_in("a", "particles").program).expect("built in");
        let members = |name: &str| {
            let of_name = |(_, ty): &(_, &naga::Type)| ty.name.as_deref() == Some(name);
            let (_, ty) = file.module.types.iter().find(of_name).expect("declared");
            let naga::TypeInner::Struct { members, span } = &ty.inner else { panic!("{name} is not a struct") };
            let members =
                members.iter().map(|member| (member.name.clone().unwrap_or_default(), member.offset as usize));
            (members.collect::<Vec<_>>(), *span as usize)
        };
        macro_rules! layout {
            ($type:ty, $($field:ident),+) => {
                (vec![$((stringify!($field).to_owned(), offset_of!($type, $field))),+], size_of::<$type>())
            };
        }
        assert_eq!(members("Body"), layout!(BodyUniform, middle_m, radius_m, half_m, is_wall, before_m, padding));
        #[rustfmt::skip]
        let expected = layout!(
            SimulationUniform, cells, cell_m, step, step_secs, time_secs, seed, body_count, padding_a, padding_b, bodies, world_from_place
        );
        assert_eq!(members("Simulation"), expected);
        assert_eq!(members("Seen"), layout!(SeenUniform, view_from_world, half_extent, is_orthographic, is_there));
    }
}
