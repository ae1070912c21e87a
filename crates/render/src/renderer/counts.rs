//! Numbers of a frame: draws that only light, and pairs of light and what it may reach.

use super::ask::ViewRequest;
use crate::aov::f32_from_half;
use crate::constants::LIGHTS_PER_BATCH;
use crate::draws::WorldDraws;
use crate::lights::LightCulling;
use crate::record::PreparedView;
use crate::render_settings::Path;
use crate::request::PairCounts;

/// Draw calls of a view that only light.
pub(super) fn light_draws(view: &PreparedView, asked: &ViewRequest, world: &WorldDraws) -> u32 {
    if !asked.kind.draws_surfaces {
        return 0;
    }
    let settings = &asked.request.settings;
    let fullscreen = |count: u32| u32::from(count > 0);
    let lit = view.lit_rectangles.len() as u32;
    match (settings.render.path, settings.lights.culling) {
        (Path::Deferred, LightCulling::Clustered | LightCulling::None) => lit,
        // Two reduce depth.
        (Path::Deferred, LightCulling::Tiled) => lit + 2 * fullscreen(lit),
        (Path::Deferred, LightCulling::Volumes | LightCulling::VolumesStencil) => {
            fullscreen(view.global_light_count) + view.volume_draws.len() as u32
        }
        (Path::ForwardBatched, _) => {
            let batches = |draw| view.most_lights_of(draw, world).div_ceil(LIGHTS_PER_BATCH).saturating_sub(1);
            view.draws.opaque.iter().map(batches).sum()
        }
        (Path::Forward | Path::Gouraud, _) => 0,
    }
}

/// Sums of the four channels of a texture of `format`, 32-bit or half floats.
#[cfg_attr(target_arch = "wasm32", allow(dead_code, reason = "a browser counts no pairs"))]
pub(super) fn sum_pairs(bytes: &[u8], format: wgpu::TextureFormat) -> PairCounts {
    let mut counts = [0f64; 4];
    if format == wgpu::TextureFormat::Rgba32Float {
        let values = bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        values.zip((0..4).cycle()).for_each(|(value, channel)| counts[channel] += f64::from(value));
    } else {
        let values = bytes.chunks_exact(2).map(|b| f32_from_half(u16::from_le_bytes([b[0], b[1]])));
        values.zip((0..4).cycle()).for_each(|(value, channel)| counts[channel] += f64::from(value));
    }
    let [pairs_visited, pairs_shaded, pairs_in_range, pairs_passed_over] = counts.map(|count| count as u64);
    PairCounts { pairs_visited, pairs_shaded, pairs_in_range, pairs_passed_over }
}
