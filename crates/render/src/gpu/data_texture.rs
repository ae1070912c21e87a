//! Arrays in textures, wrapped in two dimensions: the form in which every backend, WebGL 2 too, can read long lists.

/// A texture that holds an array of texels, row after row, and grows when the array does.
#[derive(Debug)]
pub struct DataTexture {
    label: &'static str,
    format: wgpu::TextureFormat,
    width: u32,
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    /// What [`Self::write`] put there.
    uploaded: Vec<u8>,
}

impl DataTexture {
    /// An array of `format`, `width` texels a row. The width is part of the contract with the shader that reads it.
    pub fn new(device: &wgpu::Device, label: &'static str, format: wgpu::TextureFormat, width: u32) -> Self {
        let texture = Self::create(device, label, format, width, 1);
        let view = texture.create_view(&Default::default());
        Self { label, format, width, texture, view, uploaded: Vec::new() }
    }

    fn create(
        device: &wgpu::Device,
        label: &str,
        format: wgpu::TextureFormat,
        width: u32,
        height: u32,
    ) -> wgpu::Texture {
        device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        })
    }

    /// Replaces the array if it is another one, and says how many bytes that wrote. One that the device cannot hold is
    /// `None`, and the former one stays.
    pub fn write<T: bytemuck::Pod>(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, texels: &[T]) -> Option<u64> {
        let bytes: &[u8] = bytemuck::cast_slice(texels);
        if self.uploaded.starts_with(bytes) {
            return Some(0);
        }
        let written = self.fill(device, queue, texels)?;
        self.uploaded.clear();
        self.uploaded.extend_from_slice(bytes);
        Some(written)
    }

    /// As [`Self::write`], of what is written once: no copy is kept to compare with.
    pub fn fill<T: bytemuck::Pod>(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, texels: &[T]) -> Option<u64> {
        let bytes: &[u8] = bytemuck::cast_slice(texels);
        self.uploaded = Vec::new();
        let row_bytes = self.width as usize * self.texel_bytes();
        let rows = bytes.len().div_ceil(row_bytes) as u32;
        if rows > device.limits().max_texture_dimension_2d {
            return None;
        }
        if rows > self.texture.height() {
            self.texture = Self::create(device, self.label, self.format, self.width, rows.next_power_of_two());
            self.view = self.texture.create_view(&Default::default());
        }
        let full_rows = bytes.len() / row_bytes;
        let (whole, rest) = bytes.split_at(full_rows * row_bytes);
        if !whole.is_empty() {
            self.write_rows(queue, 0, full_rows as u32, self.width, whole);
        }
        if !rest.is_empty() {
            self.write_rows(queue, full_rows as u32, 1, (rest.len() / self.texel_bytes()) as u32, rest);
        }
        Some(bytes.len() as u64)
    }

    fn write_rows(&self, queue: &wgpu::Queue, first: u32, rows: u32, width: u32, bytes: &[u8]) {
        queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture: &self.texture,
                mip_level: 0,
                origin: wgpu::Origin3d { x: 0, y: first, z: 0 },
                aspect: wgpu::TextureAspect::All,
            },
            bytes,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(width * self.texel_bytes() as u32),
                rows_per_image: None,
            },
            wgpu::Extent3d { width, height: rows, depth_or_array_layers: 1 },
        );
    }

    fn texel_bytes(&self) -> usize {
        self.format.block_copy_size(None).unwrap_or(4) as usize
    }

    /// The view that shaders read.
    pub fn view(&self) -> &wgpu::TextureView {
        &self.view
    }
}
