//! Pixels from the device to memory.

use super::{Gpu, GpuError};
use std::ops::Range;

/// Copies the first mip of `texture` into memory: rows from the top, tightly packed.
///
/// # Errors
/// The device was lost.
pub async fn read_texture(gpu: &Gpu, texture: &wgpu::Texture) -> Result<Vec<u8>, GpuError> {
    read_rows(gpu, texture, 0..texture.height()).await
}

/// As [`read_texture`], some rows alone.
///
/// # Errors
/// The device was lost.
pub async fn read_rows(gpu: &Gpu, texture: &wgpu::Texture, rows: Range<u32>) -> Result<Vec<u8>, GpuError> {
    let (width, height) = (texture.width(), rows.end.saturating_sub(rows.start));
    if height == 0 {
        return Ok(Vec::new());
    }
    let row_bytes = width * texture.format().block_copy_size(None).unwrap_or(4);
    let padded = row_bytes.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("readback"),
        size: u64::from(padded) * u64::from(height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_texture_to_buffer(
        wgpu::TexelCopyTextureInfo { origin: wgpu::Origin3d { x: 0, y: rows.start, z: 0 }, ..texture.as_image_copy() },
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(padded), rows_per_image: None },
        },
        wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
    );
    gpu.queue.submit([encoder.finish()]);
    let pixels = match map(gpu, &buffer).await {
        Ok(()) => packed_rows(&buffer, (row_bytes as usize, padded as usize, height as usize)),
        Err(error) => Err(error),
    };
    // Browsers free what is only dropped when they collect garbage: a page that reads frames would pile up their bytes.
    buffer.destroy();
    pixels
}

/// So many rows of a mapped buffer without what fills them up to `padded_bytes`.
fn packed_rows(
    buffer: &wgpu::Buffer,
    (row_bytes, padded_bytes, rows): (usize, usize, usize),
) -> Result<Vec<u8>, GpuError> {
    let mapped = buffer.get_mapped_range(..).map_err(|error| GpuError::Lost(error.to_string()))?;
    let mut pixels = reserved(row_bytes * rows)?;
    for row in mapped.chunks_exact(padded_bytes) {
        pixels.extend_from_slice(&row[..row_bytes]);
    }
    Ok(pixels)
}

/// An empty list with room for `count` values: what grows with a picture must not end the program.
///
/// # Errors
/// There is no memory for them.
pub fn reserved<T>(count: usize) -> Result<Vec<T>, GpuError> {
    let mut values = Vec::new();
    let bytes = (count as u64).saturating_mul(size_of::<T>() as u64);
    values.try_reserve_exact(count).map_err(|_| GpuError::Memory { bytes })?;
    Ok(values)
}

/// Maps a buffer for reading, waiting in the way the platform allows.
async fn map(gpu: &Gpu, buffer: &wgpu::Buffer) -> Result<(), GpuError> {
    let state = std::sync::Arc::new(std::sync::Mutex::new(None));
    let shared = state.clone();
    buffer.map_async(wgpu::MapMode::Read, .., move |result| {
        if let Ok(mut slot) = shared.lock() {
            *slot = Some(result);
        }
    });
    loop {
        let blocking = cfg!(not(target_arch = "wasm32"));
        let poll = if blocking { wgpu::PollType::wait_indefinitely() } else { wgpu::PollType::Poll };
        gpu.device.poll(poll).map_err(|error| GpuError::Lost(error.to_string()))?;
        match state.lock().ok().and_then(|mut slot| slot.take()) {
            Some(Ok(())) => return Ok(()),
            Some(Err(error)) => return Err(GpuError::Lost(error.to_string())),
            None => yield_now().await,
        }
    }
}

/// Waits until the device has done all that was submitted, in the way the platform allows, and says when that was. WebGL
/// says it only when it is asked, which browsers do every few milliseconds.
///
/// # Errors
/// The device was lost.
pub async fn done(gpu: &Gpu) -> Result<web_time::Instant, GpuError> {
    let state = std::sync::Arc::new(std::sync::Mutex::new(None));
    let shared = state.clone();
    gpu.queue.on_submitted_work_done(move || {
        if let Ok(mut slot) = shared.lock() {
            *slot = Some(web_time::Instant::now());
        }
    });
    loop {
        let blocking = cfg!(not(target_arch = "wasm32"));
        let poll = if blocking { wgpu::PollType::wait_indefinitely() } else { wgpu::PollType::Poll };
        gpu.device.poll(poll).map_err(|error| GpuError::Lost(error.to_string()))?;
        match state.lock().ok().and_then(|mut slot| slot.take()) {
            Some(at) => return Ok(at),
            None => yield_now().await,
        }
    }
}

/// Gives the browser's event loop a turn; does nothing elsewhere.
pub async fn yield_now() {
    #[cfg(target_arch = "wasm32")]
    {
        let promise = js_sys::Promise::new(&mut |resolve, _| {
            let global = js_sys::global();
            if let Ok(timeout) = js_sys::Reflect::get(&global, &"setTimeout".into()) {
                let _ = js_sys::Function::from(timeout).call2(&global, &resolve, &1.into());
            }
        });
        let _ = wasm_bindgen_futures::JsFuture::from(promise).await;
    }
}
