//! What every program finds in group 0, and what of it is the same in every frame.

use super::bind_groups::Resource;
use super::directional_albedo;
use crate::constants::DIRECTIONAL_ALBEDO_SIZE;
use crate::gpu::Gpu;
use crate::resources::environment::{EnvironmentTiles, no_tiles};
use crate::waves::waves_texture;
use manypass_scene::environment::BrdfTable;
use std::cell::OnceCell;

/// A name of group 0. Its place in the list is its binding.
#[derive(Debug)]
pub(crate) struct FrameSlot {
    pub name: &'static str,
    pub ty: wgpu::BindingType,
}

const UNIFORM: wgpu::BindingType = wgpu::BindingType::Buffer {
    ty: wgpu::BufferBindingType::Uniform,
    has_dynamic_offset: false,
    min_binding_size: None,
};

const fn texture(sample_type: wgpu::TextureSampleType) -> wgpu::BindingType {
    wgpu::BindingType::Texture { sample_type, view_dimension: wgpu::TextureViewDimension::D2, multisampled: false }
}

const fn slot(name: &'static str, ty: wgpu::BindingType) -> FrameSlot {
    FrameSlot { name, ty }
}

/// Group 0 of all programs: one layout, so that it is bound once a pass whatever is drawn. A stage has 16 textures, and
/// counts those of a layout that it does not read: here may be 6 at most.
pub(crate) const FRAME_GROUP: [FrameSlot; 12] = [
    slot("view", UNIFORM),
    // And images of decals.
    slot("directional_albedo", texture(wgpu::TextureSampleType::Float { filterable: true })),
    slot("linear_clamp", wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)),
    slot("cluster_grid", UNIFORM),
    slot("lights", texture(wgpu::TextureSampleType::Float { filterable: false })),
    slot("cluster_lights", texture(wgpu::TextureSampleType::Float { filterable: false })),
    slot("environment", UNIFORM),
    slot("nearest_clamp", wgpu::BindingType::Sampler(wgpu::SamplerBindingType::NonFiltering)),
    slot("shadow_atlas", texture(wgpu::TextureSampleType::Depth)),
    slot("shadow_compare", wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison)),
    // The same texture again: WebGL 2 has one sampler for every texture that is bound.
    slot("shadow_depths", texture(wgpu::TextureSampleType::Float { filterable: false })),
    slot("environment_tiles", texture(wgpu::TextureSampleType::Float { filterable: true })),
];

/// What a stage has of textures on WebGL 2, and on WebGPU by default.
const STAGE_TEXTURES: usize = 16;

/// How many textures a program may have in its other groups: a layout's count, whether they are read or not.
pub(crate) const OWN_TEXTURES_MAX: usize = STAGE_TEXTURES - textures_of(&FRAME_GROUP);

const fn textures_of(slots: &[FrameSlot]) -> usize {
    let (mut count, mut at) = (0, 0);
    while at < slots.len() {
        if matches!(slots[at].ty, wgpu::BindingType::Texture { .. }) {
            count += 1;
        }
        at += 1;
    }
    count
}

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

/// The table as half floats, which every backend can filter, four a texel; scale and bias are those of
/// `brdf` if there is one.
pub(crate) fn directional_albedo_texels(brdf: Option<&BrdfTable>) -> Vec<u16> {
    let last = DIRECTIONAL_ALBEDO_SIZE - 1;
    let place = |at: u32| at as f32 / last as f32;
    let texel = |(index, [scale, bias, sheen]): (u32, [f32; 3])| {
        let (column, row) = (index % DIRECTIONAL_ALBEDO_SIZE, index / DIRECTIONAL_ALBEDO_SIZE);
        let [scale, bias] = brdf.map_or([scale, bias], |brdf| brdf.at(place(column), place(row)));
        [scale, bias, sheen, 0.0].map(half_from_unit)
    };
    (0..).zip(directional_albedo::table()).flat_map(texel).collect()
}

/// That table alone, where there are no images of decals and no file brings another.
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

#[cfg(test)]
mod tests {
    use super::*;
    use half::f16;
    use manypass_testkit::radiance_file::RadiancePicture;

    /// Our own table as a file of 256 by 256 texels.
    fn exported() -> BrdfTable {
        const SIDE: usize = 256;
        let (own, last) = (Vec::from_iter(directional_albedo::table()), DIRECTIONAL_ALBEDO_SIZE as usize - 1);
        let texel = |i: usize| {
            let place = |at: usize| (at as f32 + 0.5) / SIDE as f32 * last as f32;
            let (x, y) = (place(i % SIDE), place(i / SIDE));
            let at = |x: usize, y: usize| own[y * (last + 1) + x];
            [0, 1, 2].map(|channel: usize| {
                let (left, top) = (x as usize, y as usize);
                let [above, below] = [top, top + 1].map(|row| {
                    let [a, b] = [left, left + 1].map(|column| at(column, row)[channel]);
                    a + (b - a) * x.fract()
                });
                above + (below - above) * y.fract()
            })
        };
        let pixels = (0..SIDE * SIDE).map(texel).collect();
        let bytes = RadiancePicture { width: SIDE, height: SIDE, pixels }.to_exr();
        BrdfTable::decode("own.exr", &bytes).expect("a table")
    }

    #[test]
    fn a_file_of_our_own_table_is_our_own_table() {
        let [own, read] = [None, Some(&exported())].map(directional_albedo_texels);
        let value = |bits: &u16| f16::from_bits(*bits).to_f32();
        let worst = own.iter().zip(&read).map(|(a, b)| (value(a) - value(b)).abs()).fold(0.0, f32::max);
        // A step of a byte. Our table has corners, where its texels are, which lie between those of the file.
        assert!(own.len() == read.len() && worst < 1.0 / 255.0, "{worst}");
        let flat = BrdfTable::decode("flat.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x40\0\x81");
        let flat = directional_albedo_texels(Some(&flat.expect("a table")));
        let is_kept = |(of_file, own): (&[u16], &[u16])| {
            [value(&of_file[0]), value(&of_file[1])] == [1.0, 0.5] && of_file[2..] == own[2..]
        };
        assert!(flat.chunks_exact(4).zip(own.chunks_exact(4)).all(is_kept), "the sheen stays our own");
    }

    #[test]
    fn group_0_leaves_room() {
        let is_texture = |slot: &&FrameSlot| matches!(slot.ty, wgpu::BindingType::Texture { .. });
        let count = FRAME_GROUP.iter().filter(is_texture).count();
        // A stage has 16 on WebGL 2: two are for the pass, eight for the material.
        assert!(count <= 6, "group 0 has {count} textures");
        let uniforms = FRAME_GROUP.iter().filter(|slot| slot.ty == UNIFORM).count();
        // WebGL 2 promises 12 a stage.
        assert!(uniforms <= 4, "group 0 has {uniforms} uniforms");
    }
}
