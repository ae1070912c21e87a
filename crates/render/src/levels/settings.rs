//! Settings of levels of detail.

use crate::setting::settings;

settings! {
    /// Settings of levels of detail.
    pub struct LodSettings {
        /// Whether objects with levels of detail (`MSFT_lod`, or `lod.simplify`) are drawn at the level that fits their
        /// size in the picture. Otherwise they are drawn at the finest level. Objects without levels stay as they are.
        enabled: bool = true;
        /// Whether meshes get coarser levels of detail when a model is read. Meshes with morph targets get none.
        simplify: bool = false;
        /// The geometric error in the picture that a level of a simplified mesh may have.
        error_px: f32 = 1.0, in 0.05..=100.0, unit "px", needs "lod.enabled=true";
        /// Whether surfaces that are small in the picture have simpler materials.
        materials: bool = false;
        /// The width of a surface's bounding sphere in the picture below which it has no normal maps, relief and clear
        /// coats.
        material_px: f32 = 16.0, in 1.0..=10000.0, unit "px", needs "lod.enabled=true", needs "lod.materials=true";
        /// The width of that sphere below which the surface has no layers at all; at most `lod.material_px` counts.
        plain_px: f32 = 8.0, in 0.0..=10000.0, unit "px", needs "lod.enabled=true", needs "lod.materials=true";
        /// The width of that sphere below which textures are replaced by their mean values; at most `lod.plain_px`
        /// counts.
        untextured_px: f32 = 4.0, in 0.0..=10000.0, unit "px", needs "lod.enabled=true", needs "lod.materials=true";
        /// The share of its distance over which a level fades in, by a dither pattern; 0 switches at once.
        fade: f32 = 0.25, in 0.0..=1.0, unit "share", needs "lod.enabled=true";
        /// The distance from the eye beyond which lamps light surfaces by Lambert's model, without highlights. Their
        /// specular light becomes diffuse light. 0 keeps the full model everywhere. Materials with layers stay as they
        /// are.
        lighting_m: f32 = 0.0, in 0.0..=1e9, unit "m", needs "lod.enabled=true";
        /// The bias of levels of detail: objects count as 2 to the power of this times as large. Positive numbers show
        /// finer levels.
        bias: f32 = 0.0, in -10.0..=10.0, unit "stops", needs "lod.enabled=true";
    }
}

impl LodSettings {
    /// Whether surfaces may be drawn with less than their materials have.
    pub fn reduces_materials(&self) -> bool {
        self.enabled && self.materials
    }
}
