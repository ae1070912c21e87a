//! How much memory a scene takes when it is uploaded, from the headers of its images and the lengths of its lists.

use super::STRIDES;

use super::geometry::index_count;
use super::packing::{layer_size, wanted};
use super::vertices::is_deformed;
use crate::environment::picture::upload_bytes_of;
use manypass_scene::Scene;

/// Images that are decoded, given mips or on their way to the device at one time.
const IMAGES_IN_FLIGHT: u64 = 6;
/// Bytes of what a morph target moves at one vertex: three texels of four floats.
const MORPH_BYTES: u64 = 48;

/// Bytes that [`crate::Renderer::load`] takes at its peak, on a device whose memory is the process's.
pub fn upload_bytes(scene: &Scene) -> u64 {
    let sizes = wanted(scene).into_iter().filter_map(|source| {
        let images = source.images(scene);
        let sizes: Vec<_> = images.iter().filter_map(|image| scene.images.get(*image)?.dimensions().ok()).collect();
        let (width, height) = layer_size(&sizes)?;
        // Where light comes from lies below it.
        let layers = if source.has_layers() || source.is_light() { images.len() as u64 } else { 1 };
        // Mips add a third.
        let bytes_a_texel = if source.is_light() { 8 } else { 4 };
        Some(u64::from(width) * u64::from(height) * layers * bytes_a_texel * 4 / 3)
    });
    let (sum, largest, count) =
        sizes.fold((0, 0, 0u64), |(sum, largest, count), bytes: u64| (sum + bytes, bytes.max(largest), count + 1));
    let primitives = scene.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let [vertex_bytes, skin_bytes, _] = STRIDES;
    let geometry: u64 = primitives
        .map(|primitive| {
            let vertices = primitive.positions.len() as u64;
            // Displacements are put together, staged and kept; all else is written piece by piece.
            let per_vertex = vertex_bytes
                + if is_deformed(primitive) { skin_bytes } else { 0 }
                + 3 * MORPH_BYTES * primitive.morph_targets.len() as u64;
            vertices * per_vertex + 4 * index_count(primitive)
        })
        .sum();
    // Textures lie in blocks of the allocator that are not all full: 505 MB were measured for Sponza's 345.
    let pictures = scene.surroundings.iter().filter_map(|of| of.picture.as_ref());
    let environment: u64 = scene.environment.iter().chain(pictures).map(|map| upload_bytes_of(map)).sum();
    sum + sum * 3 / 10 + largest * count.min(IMAGES_IN_FLIGHT) + geometry + environment
}
