//! Pages: buffers of one use that many things share, so that what comes and goes moves nothing else.

use super::{STAGED_BYTES, WRITE_BYTES};
use manypass_scene::turns::{Turns, give_turn};
use range_alloc::RangeAllocator;
use std::ops::Range;

/// A page is as large as that, unless what it is made for is larger, or all that is known to come is smaller.
const PAGE_BYTES: u64 = 4 << 20;

/// So many values are written between two turns: a few milliseconds.
const SLICE_UNITS: u32 = 1 << 15;

/// Where something lies: a page, and a range of units in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Place {
    pub page: usize,
    pub units: Range<u32>,
}

#[derive(Debug)]
struct Page {
    buffer: wgpu::Buffer,
    free: RangeAllocator<u32>,
}

/// What is written, but not handed to the device yet.
#[derive(Debug)]
struct PendingWrite {
    page: usize,
    offset_bytes: u64,
    bytes: Vec<u8>,
}

/// Buffers of one use, cut into units of some bytes each.
#[derive(Debug)]
pub(crate) struct Pages {
    label: &'static str,
    usage: wgpu::BufferUsages,
    unit_bytes: u64,
    pages: Vec<Option<Page>>,
    pending: Option<PendingWrite>,
    written_bytes: u64,
    staged_bytes: usize,
}

impl Pages {
    pub fn new(label: &'static str, usage: wgpu::BufferUsages, unit_bytes: usize) -> Self {
        let usage = usage | wgpu::BufferUsages::COPY_DST;
        Self {
            label,
            usage,
            unit_bytes: unit_bytes as u64,
            pages: Vec::new(),
            pending: None,
            written_bytes: 0,
            staged_bytes: 0,
        }
    }

    /// Room for `units`, of `expected` that are known to come with them. None if no buffer of this device is that
    /// large.
    pub fn take(&mut self, device: &wgpu::Device, units: u32, expected: u64) -> Option<Place> {
        let is_there = |(page, slot): (usize, &mut Option<Page>)| {
            let units = slot.as_mut()?.free.allocate_range(units).ok()?;
            Some(Place { page, units })
        };
        if let Some(place) = self.pages.iter_mut().enumerate().find_map(is_there) {
            return Some(place);
        }
        let page_units = expected.min(PAGE_BYTES / self.unit_bytes).max(u64::from(units));
        let size = (page_units * self.unit_bytes).next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT);
        if size > device.limits().max_buffer_size {
            return None;
        }
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(self.label),
            size,
            usage: self.usage,
            mapped_at_creation: false,
        });
        let mut free = RangeAllocator::new(0..page_units as u32);
        let units = free.allocate_range(units).ok()?;
        let page = self.pages.iter().position(Option::is_none).unwrap_or_else(|| {
            self.pages.push(None);
            self.pages.len() - 1
        });
        self.pages[page] = Some(Page { buffer, free });
        Some(Place { page, units })
    }

    /// Writes `values` to the beginning of `place`, at the latest when [`Self::flush`] is called. Writes that follow
    /// each other are put together up to [`WRITE_BYTES`], and larger ones are cut.
    pub fn write<T: bytemuck::NoUninit>(
        &mut self,
        queue: &wgpu::Queue,
        place: &Place,
        values: impl IntoIterator<Item = T>,
    ) {
        let offset_bytes = u64::from(place.units.start) * self.unit_bytes;
        let end_bytes = |pending: &PendingWrite| pending.offset_bytes + pending.bytes.len() as u64;
        let follows = |pending: &PendingWrite| (pending.page, end_bytes(pending)) == (place.page, offset_bytes);
        if !self.pending.as_ref().is_some_and(follows) {
            self.flush(queue);
        }
        let mut pending =
            self.pending.take().unwrap_or_else(|| PendingWrite { page: place.page, offset_bytes, bytes: Vec::new() });
        for value in values {
            if pending.bytes.len() + size_of::<T>() > WRITE_BYTES {
                let offset_bytes = end_bytes(&pending);
                self.hand_over(queue, &mut pending);
                pending.offset_bytes = offset_bytes;
            }
            pending.bytes.extend_from_slice(bytemuck::bytes_of(&value));
        }
        self.pending = Some(pending);
    }

    /// As [`Self::write`] of one value a unit; between slices of many values `turns` is asked.
    pub async fn write_in_turns<T: bytemuck::NoUninit>(
        &mut self,
        queue: &wgpu::Queue,
        place: &Place,
        mut values: impl Iterator<Item = T>,
        turns: &mut Turns<'_>,
    ) {
        let Range { mut start, end } = place.units;
        while start < end {
            let units = start..end.min(start.saturating_add(SLICE_UNITS));
            start = units.end;
            let count = units.len();
            self.write(queue, &Place { page: place.page, units }, values.by_ref().take(count));
            if start < end {
                give_turn(turns).await;
            }
        }
    }

    /// Hands what was written to the device.
    pub fn flush(&mut self, queue: &wgpu::Queue) {
        if let Some(mut pending) = self.pending.take() {
            self.hand_over(queue, &mut pending);
        }
    }

    fn hand_over(&mut self, queue: &wgpu::Queue, pending: &mut PendingWrite) {
        if let Some(Some(page)) = self.pages.get(pending.page) {
            pending.bytes.resize(pending.bytes.len().next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT as usize), 0);
            queue.write_buffer(&page.buffer, pending.offset_bytes, &pending.bytes);
            self.written_bytes += pending.bytes.len() as u64;
            self.staged_bytes += pending.bytes.len();
            if self.staged_bytes >= STAGED_BYTES {
                queue.submit([]);
                self.staged_bytes = 0;
            }
        }
        pending.bytes.clear();
    }

    /// Bytes that were handed to the device since this was last asked.
    pub fn take_written_bytes(&mut self) -> u64 {
        std::mem::take(&mut self.written_bytes)
    }

    /// Gives a place back. Its page stays until [`Self::trim`].
    pub fn give_back(&mut self, place: &Place) {
        if let Some(Some(page)) = self.pages.get_mut(place.page) {
            page.free.free_range(place.units.clone());
        }
    }

    /// Gives pages back in which nothing lies.
    pub fn trim(&mut self) {
        for slot in &mut self.pages {
            slot.take_if(|page| page.free.is_empty());
        }
        while self.pages.pop_if(|slot| slot.is_none()).is_some() {}
    }

    /// Frees all pages at once; nothing that lies in them is drawn any more.
    pub fn destroy(&self) {
        self.pages.iter().flatten().for_each(|page| page.buffer.destroy());
    }

    /// The buffer of a page.
    pub fn buffer(&self, page: usize) -> Option<&wgpu::Buffer> {
        self.pages.get(page)?.as_ref().map(|page| &page.buffer)
    }

    /// What lies at `place`.
    pub fn slice(&self, place: &Place) -> Option<wgpu::BufferSlice<'_>> {
        Some(self.buffer(place.page)?.slice(self.bytes_of(place)))
    }

    /// Where `place` lies in its buffer, in bytes.
    pub fn bytes_of(&self, place: &Place) -> Range<u64> {
        u64::from(place.units.start) * self.unit_bytes..u64::from(place.units.end) * self.unit_bytes
    }

    /// Bytes of all pages.
    pub fn bytes(&self) -> u64 {
        self.pages.iter().flatten().map(|page| page.buffer.size()).sum()
    }
}
