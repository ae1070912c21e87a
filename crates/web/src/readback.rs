//! Copies a picture from the GPU into memory.

use std::{cell::RefCell, rc::Rc};
use wasm_bindgen::prelude::*;
use wasm_bindgen_futures::JsFuture;

/// Rows of a texture copied to a buffer start at multiples of this.
const ROW_ALIGNMENT: u32 = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT;

/// The bytes of an `Rgba8Unorm` texture, rows from the top, without padding.
pub(crate) async fn read_rgba8(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
) -> Result<Vec<u8>, JsError> {
    let (width, height) = (texture.width(), texture.height());
    let row_bytes = width * 4;
    let padded_row_bytes = row_bytes.next_multiple_of(ROW_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("readback"),
        size: u64::from(padded_row_bytes) * u64::from(height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(padded_row_bytes),
                rows_per_image: None,
            },
        },
        texture.size(),
    );
    queue.submit([encoder.finish()]);

    let mapped = Rc::new(RefCell::new(None));
    let answer = Rc::clone(&mapped);
    buffer.slice(..).map_async(wgpu::MapMode::Read, move |result| {
        *answer.borrow_mut() = Some(result);
    });
    // In a browser `poll` does not wait, so the event loop must run between polls.
    while mapped.borrow().is_none() {
        device.poll(wgpu::PollType::Poll).map_err(|error| JsError::new(&error.to_string()))?;
        next_task().await?;
    }
    if let Some(Err(error)) = mapped.take() {
        return Err(JsError::new(&format!("the picture could not be read back: {error}")));
    }
    let view = buffer.slice(..).get_mapped_range().map_err(|error| JsError::new(&error.to_string()))?;
    Ok(view.chunks(padded_row_bytes as usize).flat_map(|row| &row[..row_bytes as usize]).copied().collect())
}

/// Lets the browser run its other tasks.
async fn next_task() -> Result<(), JsError> {
    let promise = js_sys::Promise::new(&mut |resolve, _reject| {
        if let Some(window) = web_sys::window() {
            let _ = window.set_timeout_with_callback_and_timeout_and_arguments_0(&resolve, 1);
        }
    });
    JsFuture::from(promise).await.map(drop).map_err(|_| JsError::new("the page's timer failed"))
}
