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

const CLEAR: DepthLoad = DepthLoad::Clear { depth: 0.0, stencil: 0 };

/// A triangle costs as much as shading so many pixels: measured on a software adapter with a model of 15,000 triangles.
const PIXELS_PER_TRIANGLE: u64 = 32;

/// Draws what hides others into `depth` alone, if that pays; and how depth is loaded afterwards. The positions of
/// surfaces are `@invariant`, and the same depth again passes the depth test: the picture is the same.
fn record_depth<'f>(
    graph: &mut Graph<'f>,
    shared: &'f Shared<'f>,
    depth: Handle,
) -> Result<(Handle, DepthLoad), ProgramError> {
    let (width, height) = shared.size;
    let pays = shared.draws.triangles * PIXELS_PER_TRIANGLE <= u64::from(width) * u64::from(height);
    if !(shared.gpu.capabilities.depth_first && pays) {
        return Ok((depth, CLEAR));
    }
    let targets = Targets { colors: Vec::new(), blend: None, depth: shared.depth_format, depth_write: true };
    let draws = surfaces::prepare_hiding(shared, "geometry", &targets, &shared.draws.opaque)?;
    let mut pass = graph.pass("geometry.depth");
    let depth = pass.depth_stencil(depth, CLEAR);
    pass.draw(move |context| surfaces::draw(context, shared.resources, shared.instances, &draws));
    Ok((depth, DepthLoad::Keep))
}

/// Records the passes.
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
    let depth = graph.texture("geometry.depth", TextureDesc::new_2d(width, height, shared.depth_format));
    let (depth, depth_load) = record_depth(graph, shared, depth)?;
    let texture = |graph: &mut Graph<'f>, name, format| graph.texture(name, TextureDesc::new_2d(width, height, format));
    let base_color = texture(graph, "geometry.base_color", BASE_COLOR);
    let normal = texture(graph, "geometry.normal", NORMAL);
    let material = texture(graph, "geometry.material", MATERIAL);
    let radiance = texture(graph, "radiance", RADIANCE);
    let mut pass = graph.pass("geometry");
    let clear = ColorLoad::Clear(wgpu::Color::TRANSPARENT);
    let outputs = Outputs {
        base_color: pass.color(base_color, clear),
        normal: pass.color(normal, clear),
        material: pass.color(material, clear),
        radiance: pass.color(radiance, clear),
        depth: pass.depth_stencil(depth, depth_load),
    };
    pass.draw(move |context| surfaces::draw(context, shared.resources, shared.instances, &draws));
    Ok(outputs)
}
