//! The uniforms of a frame: written where they are used, uploaded once.

use crate::gpu::changes::changed_parts;
use bytemuck::Pod;
use std::cell::{Cell, RefCell};

/// A page holds some hundred uniforms; most frames need one.
const PAGE_BYTES: usize = 1 << 16;

/// A uniform of this frame: a part of a buffer.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Uniform {
    pub(crate) buffer: wgpu::Buffer,
    pub(crate) offset: u64,
    pub(crate) size: u64,
}

#[derive(Debug)]
struct Page {
    buffer: wgpu::Buffer,
    bytes: Vec<u8>,
    /// What the buffer holds.
    uploaded: Vec<u8>,
}

/// Pages of uniforms. A frame that is recorded like the one before it puts each uniform where it was, so that bind
/// groups stay valid; what did not change is not uploaded again.
#[derive(Debug)]
pub(crate) struct UniformArena {
    device: wgpu::Device,
    alignment: usize,
    pages: RefCell<Vec<Page>>,
    /// The page that is filled.
    current: Cell<usize>,
}

impl UniformArena {
    pub fn new(device: &wgpu::Device) -> Self {
        let alignment = device.limits().min_uniform_buffer_offset_alignment.max(16) as usize;
        Self { device: device.clone(), alignment, pages: RefCell::default(), current: Cell::new(0) }
    }

    /// Begins a frame: what earlier ones wrote may be overwritten.
    pub fn begin(&self) {
        self.current.set(0);
        self.pages.borrow_mut().iter_mut().for_each(|page| page.bytes.clear());
    }

    /// Puts `value` into the frame.
    pub fn push<T: Pod>(&self, value: &T) -> Uniform {
        let value = bytemuck::bytes_of(value);
        let mut pages = self.pages.borrow_mut();
        let fits = |page: &Page| {
            (page.bytes.len().next_multiple_of(self.alignment) + value.len()) as u64 <= page.buffer.size()
        };
        while pages.get(self.current.get()).is_some_and(|page| !fits(page)) {
            self.current.set(self.current.get() + 1);
        }
        let index = self.current.get();
        if index == pages.len() {
            let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("uniforms"),
                size: PAGE_BYTES.max(value.len()).next_multiple_of(4) as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            pages.push(Page { buffer, bytes: Vec::new(), uploaded: Vec::new() });
        }
        let page = &mut pages[index];
        let offset = page.bytes.len().next_multiple_of(self.alignment);
        page.bytes.resize(offset, 0);
        page.bytes.extend_from_slice(value);
        Uniform { buffer: page.buffer.clone(), offset: offset as u64, size: value.len() as u64 }
    }

    /// Uploads what changed, and says how many bytes that were. Call it before the frame's commands are submitted.
    pub fn upload(&self, queue: &wgpu::Queue) -> u64 {
        let mut written = 0;
        for page in self.pages.borrow_mut().iter_mut() {
            page.bytes.resize(page.bytes.len().next_multiple_of(4), 0);
            let changed = changed_parts(&page.uploaded, &page.bytes, 4);
            for part in &changed {
                queue.write_buffer(&page.buffer, part.start as u64, &page.bytes[part.clone()]);
                written += part.len() as u64;
            }
            if !changed.is_empty() {
                page.uploaded.clone_from(&page.bytes);
            }
        }
        written
    }
}
