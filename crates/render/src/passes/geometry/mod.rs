//! geometry: draws opaque and masked surfaces into the G-buffer; emission starts `radiance`, if any surface glows.
//!
//! Source: Saito & Takahashi 1990, "Comprehensible Rendering of 3-D Shapes"; the layout is `gbuffer.rs`'s.
//! Reads: materials. Writes: base_color, normal, material, radiance (alpha = coverage), depth.

use crate::gbuffer::{BASE_COLOR, MATERIAL, NORMAL, RADIANCE};
use crate::pass_info::PassInfo;
use crate::record::{DecalUse, DrawSelection, Recorder, Texels};
use crate::shader::program::ProgramError;
use manypass_graph::{ColorLoad, DepthLoad, Handle};

/// What lists of passes say of this one.
pub const PASS: PassInfo = PassInfo {
    variables: &["base_color", "occlusion", "normal", "normal_view", "metallic", "roughness"],
    effect_inputs: &["normal", "base_color", "material"],
    ..PassInfo::new("geometry")
};

/// What the pass leaves behind.
#[derive(Debug)]
pub struct Outputs {
    /// Base colour; occlusion of the material.
    pub base_color: Handle,
    /// World normal.
    pub normal: Handle,
    /// Metallic, roughness, reflectance, shading model.
    pub material: Handle,
    /// Emission; coverage. None where no surface of the world glows: `coverage` begins it then.
    pub radiance: Option<Handle>,
    /// Depth and stencil.
    pub depth: Handle,
}

/// A triangle costs as much as shading so many pixels: measured on a software adapter with a model of 15,000 triangles.
const PIXELS_PER_TRIANGLE: u64 = 32;

/// Draws what hides others into `depth` alone, if that pays, after it was loaded as `load` says; and how depth is
/// loaded afterwards. The positions of surfaces are `@invariant`, and the same depth again passes the depth test: the
/// picture is the same.
fn record_depth(
    r: &mut Recorder<'_, '_>,
    (depth, load): (Handle, DepthLoad),
) -> Result<(Handle, DepthLoad), ProgramError> {
    let pays = r.view.triangle_count() * PIXELS_PER_TRIANGLE <= r.view.pixel_count();
    if !(r.frame.gpu.capabilities.depth_first && pays) {
        return Ok((depth, load));
    }
    let mut pass = r.surfaces("geometry.depth", "geometry");
    let depth = pass.depth(depth, load);
    pass.draw_opaque(DrawSelection::Hiding)?;
    Ok((depth, DepthLoad::Keep))
}

/// What [`record_prepass`] leaves behind.
#[derive(Debug)]
pub struct Prepass {
    /// Base colour; occlusion of the material.
    pub base_color: Handle,
    /// World normal.
    pub normal: Handle,
    /// Metallic, roughness, reflectance, shading model, if it is wanted.
    pub material: Option<Handle>,
    /// Depth, with one sample a pixel.
    pub depth: Handle,
}

/// Draws opaque and masked surfaces for what is found in the picture of them before they are shaded where they are
/// drawn, with one sample a pixel. `begun` is as for [`record`], or depth of its own.
///
/// # Errors
/// A program that does not compile.
pub fn record_prepass(
    r: &mut Recorder<'_, '_>,
    begun: Option<(Handle, DepthLoad)>,
    wants_material: bool,
) -> Result<Prepass, ProgramError> {
    let begun = begun.unwrap_or_else(|| {
        let depth = r.texture("geometry.middles", r.frame.gpu.capabilities.depth_format);
        (depth, DepthLoad::Clear { depth: 0.0, stencil: 0 })
    });
    let (depth, depth_load) = record_depth(r, begun)?;
    let base_color = r.texture("geometry.base_color", BASE_COLOR);
    let normal = r.texture("geometry.normal", NORMAL);
    r.declare_texels(&normal, Texels::Direction);
    let material = wants_material.then(|| r.texture("geometry.material", MATERIAL));
    let mut pass = r.surfaces("geometry", "geometry");
    let clear = ColorLoad::Clear(wgpu::Color::TRANSPARENT);
    let outputs = Prepass {
        base_color: pass.color(base_color, clear),
        normal: pass.color(normal, clear),
        material: material.map(|material| pass.color(material, clear)),
        depth: pass.depth(depth, depth_load),
    };
    pass.draw_opaque(DrawSelection::All)?;
    Ok(outputs)
}

/// Records the passes; `begun` is depth, and how it is loaded. `fills_background` says that another pass draws all of
/// `radiance` where this one draws nothing.
///
/// # Errors
/// A program that does not compile.
pub fn record(
    r: &mut Recorder<'_, '_>,
    begun: (Handle, DepthLoad),
    fills_background: bool,
) -> Result<Outputs, ProgramError> {
    let (depth, depth_load) = record_depth(r, begun)?;
    let base_color = r.texture("geometry.base_color", BASE_COLOR);
    let normal = r.texture("geometry.normal", NORMAL);
    r.declare_texels(&normal, Texels::Direction);
    let material = r.texture("geometry.material", MATERIAL);
    // What is not opaque may glow, too.
    let glows = r.frame.world.glows || r.view.shows_first_surface;
    let radiance = glows.then(|| r.texture("radiance", RADIANCE));
    // Where samples leave tiles out, nobody looks at what lies beside the pixels of surfaces.
    let leaves_out = r.view.settled.is_some();
    let mut pass = r.surfaces("geometry", "geometry");
    let clear = ColorLoad::Clear(wgpu::Color::TRANSPARENT);
    let load = if leaves_out { ColorLoad::Discard } else { clear };
    let radiance_load = if leaves_out && fills_background { ColorLoad::Discard } else { clear };
    let outputs = Outputs {
        base_color: pass.color(base_color, load),
        normal: pass.color(normal, load),
        material: pass.color(material, load),
        // What the shader writes there without a target goes nowhere.
        radiance: radiance.map(|radiance| pass.color(radiance, radiance_load)),
        depth: pass.depth(depth, depth_load),
    };
    pass.leave_out_settled();
    // Below, where they are seen.
    pass.decals(DecalUse::LeftOut);
    pass.draw_opaque(DrawSelection::All)?;
    record_decals(r, outputs)
}

/// Lays decals over what the G-buffer holds: their boxes are drawn for the stencil alone, and the surfaces that they may
/// touch once more, at the same depth, where that is marked. So what no decal touches costs nothing, and each target
/// has its whole new value: nothing is blended, which WebGL 2 cannot do otherwise in each target.
///
/// Source: projected boxes (Kim 2012, "Screen Space Decals in Warhammer 40,000: Space Marine").
fn record_decals(r: &mut Recorder<'_, '_>, outputs: Outputs) -> Result<Outputs, ProgramError> {
    if r.view.decal_draws.is_empty() || !r.view.has_decaled() {
        return Ok(outputs);
    }
    let Outputs { base_color, normal, material, radiance, depth } = outputs;
    let depth = r.mark_decals("geometry.decals_mark", depth)?;
    let mut pass = r.surfaces("geometry.decals", "geometry");
    pass.depth_read_only(&depth);
    pass.constant("draws_again", 1);
    let outputs = Outputs {
        base_color: pass.color(base_color, ColorLoad::Keep),
        normal: pass.color(normal, ColorLoad::Keep),
        material: pass.color(material, ColorLoad::Keep),
        radiance: radiance.map(|radiance| pass.color(radiance, ColorLoad::Keep)),
        depth,
    };
    pass.draw_decaled()?;
    Ok(outputs)
}
