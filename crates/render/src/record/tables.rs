//! What is bound to group 0 that is the same in every frame. `shader/frame_group.rs` says what every program finds there.

use super::bind_groups::Resource;
use crate::constants::DIRECTIONAL_ALBEDO_SIZE;
use crate::environment::picture::{EnvironmentTiles, no_tiles};
use crate::gpu::Gpu;
use crate::resources::directional_albedo_texels;
use crate::waves::waves_texture;
use std::cell::OnceCell;

/// What is the same in every frame.
#[derive(Debug)]
pub(crate) struct FrameTables {
    pub directional_albedo: wgpu::TextureView,
    pub linear_clamp: wgpu::Sampler,
    pub linear_repeat: wgpu::Sampler,
    pub nearest_clamp: wgpu::Sampler,
    pub shadow_compare: wgpu::Sampler,
    /// Of a depth texture of one texel, where there are no shadows.
    pub no_shadows: wgpu::TextureView,
    /// A texel that is of no node and no material, where nobody looks at ids.
    pub no_ids: wgpu::TextureView,
    /// A texture without light, where the environment is no picture.
    pub no_environment: wgpu::TextureView,
    studio: OnceCell<EnvironmentTiles>,
    waves: OnceCell<wgpu::TextureView>,
}

impl FrameTables {
    pub fn new(gpu: &Gpu) -> Self {
        let sampler = |label, filter, address_mode| {
            gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some(label),
                mag_filter: filter,
                min_filter: filter,
                address_mode_u: address_mode,
                address_mode_v: address_mode,
                mipmap_filter: if filter == wgpu::FilterMode::Linear {
                    wgpu::MipmapFilterMode::Linear
                } else {
                    wgpu::MipmapFilterMode::Nearest
                },
                ..Default::default()
            })
        };
        let clamp = wgpu::AddressMode::ClampToEdge;
        Self {
            directional_albedo: upload_directional_albedo(gpu),
            linear_clamp: sampler("linear_clamp", wgpu::FilterMode::Linear, clamp),
            linear_repeat: sampler("linear_repeat", wgpu::FilterMode::Linear, wgpu::AddressMode::Repeat),
            nearest_clamp: sampler("nearest_clamp", wgpu::FilterMode::Nearest, clamp),
            shadow_compare: gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("shadow_compare"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                // Depth is reversed: light reaches what is at least as near as what the map holds.
                compare: Some(wgpu::CompareFunction::GreaterEqual),
                ..Default::default()
            }),
            no_shadows: depth_texture(gpu, "no_shadows", 1).create_view(&Default::default()),
            no_ids: no_ids(gpu),
            no_environment: no_tiles(gpu),
            studio: OnceCell::new(),
            waves: OnceCell::new(),
        }
    }

    /// The tiles of the studio, made when they are first wanted.
    pub fn studio(&self, gpu: &Gpu) -> &EnvironmentTiles {
        self.studio.get_or_init(|| EnvironmentTiles::of_studio(gpu))
    }

    /// The map of water's waves, made when it is first wanted.
    pub fn waves(&self, gpu: &Gpu) -> &wgpu::TextureView {
        self.waves.get_or_init(|| waves_texture(gpu))
    }

    /// The samplers that every shader may name.
    pub fn sampler(&self, name: &str) -> Option<wgpu::Sampler> {
        match name {
            "linear_clamp" => Some(self.linear_clamp.clone()),
            "linear_repeat" => Some(self.linear_repeat.clone()),
            "nearest_clamp" => Some(self.nearest_clamp.clone()),
            _ => None,
        }
    }

    /// Group 0 with what is the view's: its uniform, the lists of lights and their shape, the environment, the shadows, and
    /// the texture of decals if they have images.
    pub fn frame_group(
        &self,
        view: [Resource; 5],
        shadows: &wgpu::TextureView,
        environment_tiles: &wgpu::TextureView,
        decals: Option<&wgpu::TextureView>,
    ) -> Vec<Resource> {
        let [view, grid, lights, lists, environment] = view;
        vec![
            view,
            Resource::Texture(decals.unwrap_or(&self.directional_albedo).clone()),
            Resource::Sampler(self.linear_clamp.clone()),
            grid,
            lights,
            lists,
            environment,
            Resource::Sampler(self.nearest_clamp.clone()),
            Resource::Texture(shadows.clone()),
            Resource::Sampler(self.shadow_compare.clone()),
            Resource::Texture(shadows.clone()),
            Resource::Texture(environment_tiles.clone()),
        ]
    }
}

/// A depth texture of `side` texels a side that shaders read.
pub(crate) fn depth_texture(gpu: &Gpu, label: &str, side: u32) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Depth32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

fn no_ids(gpu: &Gpu) -> wgpu::TextureView {
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("no_ids"),
        size: wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rg32Uint,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    texture.create_view(&Default::default())
}

/// The table of directional albedo alone, where there are no images of decals and no file brings another.
fn upload_directional_albedo(gpu: &Gpu) -> wgpu::TextureView {
    let size =
        wgpu::Extent3d { width: DIRECTIONAL_ALBEDO_SIZE, height: DIRECTIONAL_ALBEDO_SIZE, depth_or_array_layers: 1 };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("directional_albedo"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let texels = directional_albedo_texels(None);
    gpu.queue.write_texture(
        texture.as_image_copy(),
        bytemuck::cast_slice(&texels),
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(DIRECTIONAL_ALBEDO_SIZE * 8),
            rows_per_image: None,
        },
        size,
    );
    texture.create_view(&Default::default())
}
