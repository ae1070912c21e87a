//! Arrays in textures, wrapped in two dimensions: the form in which every backend, WebGL 2 too, can read long lists.

use super::changes::changed_parts;

/// A texture that holds an array of texels, row after row, and grows when the array does.
#[derive(Debug)]
pub struct DataTexture {
    label: &'static str,
    format: wgpu::TextureFormat,
    width: u32,
    texture: wgpu::Texture,
    view: wgpu::TextureView,
    /// What [`Self::write_changed`] put there.
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

    /// Replaces the array, writing what is new of it, and says how many bytes that were. One that the device cannot
    /// hold is `None`, and the former one stays.
    pub fn write<T: bytemuck::Pod>(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, texels: &[T]) -> Option<u64> {
        let count = (std::mem::size_of_val(texels) / self.texel_bytes()) as u32;
        self.fit(device, queue, count, 0)?;
        Some(self.write_changed(queue, 0, texels))
    }

    /// Gives the texture the size that so many texels need, of which the first `kept` stay what they are; the others
    /// are to be written. Says how many bytes had to be written again, or `None` if the device cannot hold as many.
    pub fn fit(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, texels: u32, kept: u32) -> Option<u64> {
        let rows = texels.div_ceil(self.width);
        if rows > device.limits().max_texture_dimension_2d {
            return None;
        }
        let height = self.texture.height();
        if rows <= height && 4 * rows.max(1).next_power_of_two() >= height {
            return Some(0);
        }
        self.resize(device, texels);
        let mut uploaded = std::mem::take(&mut self.uploaded);
        uploaded.truncate(kept as usize * self.texel_bytes());
        self.write_at(queue, 0, &uploaded);
        self.uploaded = uploaded;
        Some(self.uploaded.len() as u64)
    }

    /// Writes what is new of the array from the texel `first` on, where there is room for it, and says how many bytes
    /// that were.
    pub fn write_changed<T: bytemuck::Pod>(&mut self, queue: &wgpu::Queue, first: u32, texels: &[T]) -> u64 {
        let bytes: &[u8] = bytemuck::cast_slice(texels);
        let texel_bytes = self.texel_bytes();
        let begin = first as usize * texel_bytes;
        // What was never written is zero.
        self.uploaded.resize(self.uploaded.len().max(begin), 0);
        let (_, known) = self.uploaded.split_at(begin);
        let changed = changed_parts(known, bytes, texel_bytes);
        for part in &changed {
            self.write_at(queue, first + (part.start / texel_bytes) as u32, &bytes[part.clone()]);
        }
        if !changed.is_empty() {
            let beyond = self.uploaded.split_off((begin + bytes.len()).min(self.uploaded.len()));
            self.uploaded.truncate(begin);
            self.uploaded.extend_from_slice(bytes);
            self.uploaded.extend(beyond);
        }
        changed.iter().map(|part| part.len() as u64).sum()
    }

    /// Makes room for an array of so many texels, whose values are then unknown, and says how many there is room for.
    /// They must fit the device.
    pub fn resize(&mut self, device: &wgpu::Device, texels: u32) -> u32 {
        let most_rows = device.limits().max_texture_dimension_2d;
        let rows = texels.div_ceil(self.width).max(1).next_power_of_two().min(most_rows);
        if rows != self.texture.height() {
            self.texture = Self::create(device, self.label, self.format, self.width, rows);
            self.view = self.texture.create_view(&Default::default());
        }
        rows * self.width
    }

    /// Writes `texels` from the texel `first` on, where there is room for them.
    pub fn write_at<T: bytemuck::Pod>(&mut self, queue: &wgpu::Queue, first: u32, texels: &[T]) {
        let mut bytes: &[u8] = bytemuck::cast_slice(texels);
        let (mut x, mut y) = (first % self.width, first / self.width);
        while !bytes.is_empty() {
            let texels = (bytes.len() / self.texel_bytes()) as u32;
            // The rest of a row that was begun, or whole rows, or the beginning of the last.
            let (width, rows) = if x > 0 || texels < self.width {
                (texels.min(self.width - x), 1)
            } else {
                (self.width, texels / self.width)
            };
            let (now, later) = bytes.split_at((width * rows) as usize * self.texel_bytes());
            self.write_rows(queue, (x, y), rows, width, now);
            (x, y, bytes) = (0, y + rows, later);
        }
    }

    /// Its rows.
    pub fn rows(&self) -> u32 {
        self.texture.height()
    }

    /// Bytes of the texture.
    pub fn bytes(&self) -> u64 {
        u64::from(self.texture.width()) * u64::from(self.texture.height()) * self.texel_bytes() as u64
    }

    fn write_rows(&self, queue: &wgpu::Queue, (x, y): (u32, u32), rows: u32, width: u32, bytes: &[u8]) {
        queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture: &self.texture,
                mip_level: 0,
                origin: wgpu::Origin3d { x, y, z: 0 },
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
