//! What an adapter can do, asked once. No other code asks which platform it runs on.

use super::GpuError;
use manypass_scene::BlockFormat;

/// The compressed blocks that a device with these features samples; of several those that keep most.
pub fn block_format(features: wgpu::Features) -> Option<BlockFormat> {
    let known = [
        (wgpu::Features::TEXTURE_COMPRESSION_BC, BlockFormat::Bc7),
        (wgpu::Features::TEXTURE_COMPRESSION_ASTC, BlockFormat::Astc),
        (wgpu::Features::TEXTURE_COMPRESSION_ETC2, BlockFormat::Etc2),
    ];
    known.into_iter().find(|(feature, _)| features.contains(*feature)).map(|(_, format)| format)
}

/// What the device can do, as far as the frame cares.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Capabilities {
    /// The format of depth and stencil: 32-bit float where there is one, else 24 bits.
    pub depth_format: wgpu::TextureFormat,
    /// The largest width and height of a texture.
    pub max_texture_size: u32,
    /// Whether textures are filtered along the long side of a pixel's footprint at a bearable price. Software adapters
    /// can do it, but then drawing surfaces takes 4 to 12 times as long (Mesa 22.3.6 at an anisotropy of 4).
    pub anisotropy: bool,
    /// Whether shading costs so much beside drawing triangles that few of them are drawn twice, once for depth alone:
    /// so on software adapters, which shade whole blocks of pixels for the edge of a triangle.
    pub depth_first: bool,
    /// Textures are filtered as exactly as numbers are multiplied, and not by 1/256 of a texel.
    pub filters_exactly: bool,
    /// The format of the tiles of environments and of the texels of probes: half floats, or 32-bit floats on software adapters
    /// that filter those, because they take a quarter more instructions to filter half floats.
    pub tiles_format: wgpu::TextureFormat,
    /// Whether passes may look at the depth that they test against; on OpenGL and WebGL 2 that is feedback.
    pub samples_attached_depth: bool,
    /// Whether uniforms may have any size; otherwise (WebGL 2) it is a multiple of 16 bytes.
    pub uniforms_of_any_size: bool,
    /// Whether textures of layers may have any number of them; on OpenGL and WebGL 2, one layer is taken for a plain
    /// texture and square ones of six for a cube.
    pub arrays_of_any_length: bool,
    /// Whether a pipeline has room for the textures of layers beside those of skins and morph targets: wgpu gives those
    /// of both stages numbers of one row on OpenGL and WebGL 2, which ends at 16.
    pub layers_deform: bool,
    /// The compressed blocks that textures may keep, if the device samples any at a bearable price: software adapters
    /// unpack a block for every texel.
    pub block_format: Option<BlockFormat>,
    /// Whether 32-bit floats can be blended, so that numbers add up exactly in a target.
    pub float32_blendable: bool,
    /// Whether passes can be timed on the GPU.
    pub timestamps: bool,
    /// The limits of the device.
    pub limits: wgpu::Limits,
}

impl Capabilities {
    /// Asks the adapter.
    ///
    /// # Errors
    /// The adapter cannot render to floating-point targets (on WebGL 2: it lacks `EXT_color_buffer_float`).
    pub fn of(adapter: &wgpu::Adapter, device: &wgpu::Device) -> Result<Self, GpuError> {
        for format in [wgpu::TextureFormat::Rgba16Float, wgpu::TextureFormat::R32Float] {
            let usages = adapter.get_texture_format_features(format).allowed_usages;
            if !usages.contains(wgpu::TextureUsages::RENDER_ATTACHMENT) {
                return Err(GpuError::Incapable {
                    adapter: adapter.get_info().name,
                    missing: format!(
                        "it cannot render to {format:?} (on WebGL 2 that needs the extension EXT_color_buffer_float)"
                    ),
                });
            }
        }
        Ok(Self::of_device(adapter, device))
    }

    /// The format of a target in which numbers are added up by blending. Half floats hold whole numbers up to 2,048.
    pub(crate) fn sum_format(&self) -> wgpu::TextureFormat {
        if self.float32_blendable { wgpu::TextureFormat::Rgba32Float } else { wgpu::TextureFormat::Rgba16Float }
    }

    /// So many layers a texture has at least that is to have `count`.
    pub(crate) fn array_layers(&self, count: u32) -> u32 {
        if !self.arrays_of_any_length && (count == 1 || count.is_multiple_of(6)) { count + 1 } else { count }
    }

    /// What is enabled on the device, whose adapter can render to floating-point targets.
    pub(super) fn of_device(adapter: &wgpu::Adapter, device: &wgpu::Device) -> Self {
        let limits = device.limits();
        let depth_format = if device.features().contains(wgpu::Features::DEPTH32FLOAT_STENCIL8) {
            wgpu::TextureFormat::Depth32FloatStencil8
        } else {
            wgpu::TextureFormat::Depth24PlusStencil8
        };
        let is_software = adapter.get_info().device_type == wgpu::DeviceType::Cpu;
        let of_float32 = adapter.get_texture_format_features(wgpu::TextureFormat::Rgba32Float);
        let filters_float32 = device.features().contains(wgpu::Features::FLOAT32_FILTERABLE)
            && of_float32.flags.contains(wgpu::TextureFormatFeatureFlags::FILTERABLE)
            && of_float32.allowed_usages.contains(wgpu::TextureUsages::RENDER_ATTACHMENT);
        let tiles_format = if is_software && filters_float32 {
            wgpu::TextureFormat::Rgba32Float
        } else {
            wgpu::TextureFormat::Rgba16Float
        };
        Self {
            depth_format,
            max_texture_size: limits.max_texture_dimension_2d,
            anisotropy: !is_software
                && adapter.get_downlevel_capabilities().flags.contains(wgpu::DownlevelFlags::ANISOTROPIC_FILTERING),
            depth_first: is_software,
            filters_exactly: is_software,
            tiles_format,
            samples_attached_depth: adapter.get_info().backend != wgpu::Backend::Gl,
            uniforms_of_any_size: adapter
                .get_downlevel_capabilities()
                .flags
                .contains(wgpu::DownlevelFlags::BUFFER_BINDINGS_NOT_16_BYTE_ALIGNED),
            layers_deform: adapter.get_info().backend != wgpu::Backend::Gl,
            arrays_of_any_length: adapter.get_info().backend != wgpu::Backend::Gl,
            block_format: block_format(device.features()).filter(|_| !is_software),
            float32_blendable: device.features().contains(wgpu::Features::FLOAT32_BLENDABLE),
            timestamps: device.features().contains(wgpu::Features::TIMESTAMP_QUERY),
            limits,
        }
    }
}
