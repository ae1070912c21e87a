//! Arrays in textures, wrapped in two dimensions: the form in which every backend, WebGL 2 too, can read long lists.

/// A texture that holds an array of texels, row after row, and grows when the array does.
#[derive(Debug)]
pub struct DataTexture {
    label: &'static str,
    format: wgpu::TextureFormat,
    width: u32,
    texture: wgpu::Texture,
    view: wgpu::TextureView,
}

impl DataTexture {
    /// An array of `format`, `width` texels a row. The width is part of the contract with the shader that reads it.
    pub fn new(device: &wgpu::Device, label: &'static str, format: wgpu::TextureFormat, width: u32) -> Self {
        let texture = Self::create(device, label, format, width, 1);
        let view = texture.create_view(&Default::default());
        Self { label, format, width, texture, view }
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

    /// Replaces the array. Returns false, and keeps the former one, if the device cannot hold so many rows.
    pub fn write<T: bytemuck::Pod>(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, texels: &[T]) -> bool {
        let row_len = self.width as usize * self.texel_bytes() / size_of::<T>();
        let rows = texels.len().div_ceil(row_len.max(1)) as u32;
        if rows > device.limits().max_texture_dimension_2d {
            return false;
        }
        if rows > self.texture.height() {
            self.texture = Self::create(device, self.label, self.format, self.width, rows.next_power_of_two());
            self.view = self.texture.create_view(&Default::default());
        }
        let full_rows = texels.len() / row_len.max(1);
        let (whole, rest) = texels.split_at(full_rows * row_len);
        if !whole.is_empty() {
            self.write_rows(queue, 0, full_rows as u32, self.width, bytemuck::cast_slice(whole));
        }
        if !rest.is_empty() {
            let width = (size_of_val(rest) / self.texel_bytes()) as u32;
            self.write_rows(queue, full_rows as u32, 1, width, bytemuck::cast_slice(rest));
        }
        true
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
