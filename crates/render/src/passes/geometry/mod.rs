//! geometry: draws opaque and masked surfaces into the G-buffer; emission starts `radiance`.
//!
//! Source: Saito & Takahashi 1990, "Comprehensible Rendering of 3-D Shapes"; the layout is `gbuffer.rs`'s.
//! Reads: materials. Writes: base_color, normal, material, radiance (alpha = coverage), depth.

use crate::frame::Shared;
use crate::gbuffer::{BASE_COLOR, MATERIAL, NORMAL, RADIANCE};
use crate::shader::program::ProgramError;
use crate::surfaces::{self, Targets};
use manypass_graph::{ColorLoad, DepthLoad, Graph, Handle, TextureDesc};

/// What the pass leaves behind.
#[derive(Debug)]
pub struct Outputs {
    /// Base colour; occlusion of the material.
    pub base_color: Handle,
    /// World normal.
    pub normal: Handle,
    /// Metallic, roughness, reflectance, shading model.
    pub material: Handle,
    /// Emission; coverage.
    pub radiance: Handle,
    /// Depth and stencil.
    pub depth: Handle,
}

/// Records the pass.
///
/// # Errors
/// A program that does not compile.
pub fn record<'f>(graph: &mut Graph<'f>, shared: &'f Shared<'f>) -> Result<Outputs, ProgramError> {
    let (width, height) = shared.size;
    let targets = Targets {
        colors: vec![BASE_COLOR, NORMAL, MATERIAL, RADIANCE],
        blend: None,
        depth: shared.depth_format,
        depth_write: true,
    };
    let draws = surfaces::prepare(shared, "geometry", &targets, &shared.draws.opaque)?;
    let texture = |graph: &mut Graph<'f>, name, format| graph.texture(name, TextureDesc::new_2d(width, height, format));
    let base_color = texture(graph, "geometry.base_color", BASE_COLOR);
    let normal = texture(graph, "geometry.normal", NORMAL);
    let material = texture(graph, "geometry.material", MATERIAL);
    let radiance = texture(graph, "radiance", RADIANCE);
    let depth = texture(graph, "geometry.depth", shared.depth_format);
    let mut pass = graph.pass("geometry");
    let clear = ColorLoad::Clear(wgpu::Color::TRANSPARENT);
    let outputs = Outputs {
        base_color: pass.color(base_color, clear),
        normal: pass.color(normal, clear),
        material: pass.color(material, clear),
        radiance: pass.color(radiance, clear),
        depth: pass.depth_stencil(depth, DepthLoad::Clear { depth: 0.0, stencil: 0 }),
    };
    pass.draw(move |context| surfaces::draw(context, shared.resources, shared.instances, &draws));
    Ok(outputs)
}
