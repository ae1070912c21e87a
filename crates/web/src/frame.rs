//! The one place where a frame is recorded.

use std::collections::BTreeMap;

/// Where the camera stands, around the middle of the model.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Orbit {
    pub yaw_deg: f32,
    pub pitch_deg: f32,
    /// Not positive: the radius that frames the whole model.
    pub radius_m: f32,
}

/// A model as it was handed over: a `.glb` or `.gltf`, and what a `.gltf` refers to by relative address.
#[derive(Default)]
pub(crate) struct Model {
    pub bytes: Vec<u8>,
    pub resources: BTreeMap<String, Vec<u8>>,
}

/// Records one frame into `target`, a display-encoded picture of `Rgba8Unorm`: the shader encodes sRGB, because WebGPU
/// canvases have no sRGB format.
pub(crate) fn record(
    encoder: &mut wgpu::CommandEncoder,
    target: &wgpu::TextureView,
    model: Option<&Model>,
    orbit: Orbit,
) {
    let loaded = model.is_some_and(|model| !model.bytes.is_empty() || !model.resources.is_empty());
    let yaw_share = f64::from(orbit.yaw_deg.rem_euclid(360.0) / 360.0);
    let pitch_share = f64::from((orbit.pitch_deg.clamp(-90.0, 90.0) + 90.0) / 180.0);
    let blue = if loaded && orbit.radius_m.is_finite() { 1.0 } else { 0.0 };
    let clear = wgpu::Color { r: yaw_share, g: pitch_share, b: blue, a: 1.0 };
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("frame.clear"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: target,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(clear), store: wgpu::StoreOp::Store },
        })],
        ..Default::default()
    });
}
