//! The instances of the world on the device.

use crate::gpu::Gpu;
use crate::gpu::changes::changed_parts;
use crate::resources::Instance;
use bytemuck::Zeroable;

/// A buffer of instances that grows with them.
#[derive(Debug)]
pub(crate) struct InstanceTable {
    buffer: wgpu::Buffer,
    /// What the buffer holds.
    uploaded: Vec<Instance>,
    /// The version of all that, where it has one.
    version: Option<u64>,
}

impl InstanceTable {
    pub fn new(gpu: &Gpu) -> Self {
        Self { buffer: create(gpu, 64), uploaded: Vec::new(), version: None }
    }

    /// The buffer that is bound beside vertices.
    pub fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }

    /// As [`Self::write`], of instances that are what they were while their version is the same.
    pub fn write_version(&mut self, gpu: &Gpu, instances: &[Instance], version: Option<u64>) -> u64 {
        if version.is_some() && self.version == version {
            return 0;
        }
        let written_bytes = self.write(gpu, instances);
        self.version = version;
        written_bytes
    }

    /// Uploads those of `instances` that changed, and says how many bytes that were.
    pub fn write(&mut self, gpu: &Gpu, instances: &[Instance]) -> u64 {
        self.version = None;
        const BYTES: usize = size_of::<Instance>();
        let bytes: &[u8] = bytemuck::cast_slice(instances);
        let size = (bytes.len() as u64).max(64).next_power_of_two();
        if size > self.buffer.size() || 4 * size < self.buffer.size() {
            self.buffer = create(gpu, size);
            self.uploaded.clear();
        }
        let changed = changed_parts(bytemuck::cast_slice(&self.uploaded), bytes, BYTES);
        self.uploaded.resize(instances.len(), Instance::zeroed());
        for part in &changed {
            gpu.queue.write_buffer(&self.buffer, part.start as u64, &bytes[part.clone()]);
            let part = part.start / BYTES..part.end / BYTES;
            self.uploaded[part.clone()].copy_from_slice(&instances[part]);
        }
        changed.iter().map(|part| part.len() as u64).sum()
    }
}

fn create(gpu: &Gpu, size: u64) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("instances"),
        size,
        usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}
