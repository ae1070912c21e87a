//! Settings of levels of detail.

use crate::setting::settings;

settings! {
    /// Settings of levels of detail.
    pub struct LodSettings {
        /// Whether what has levels (`MSFT_lod`, or `lod.simplify`) is shown by those that its size in the picture asks
        /// for, and not by the finest. What has none is drawn as it is.
        enabled: bool = true;
        /// Whether meshes are given coarser levels when a model is read. Those with morph targets have none.
        simplify: bool = false;
        /// Of meshes that were simplified, a level is shown from where it differs by so much in the picture.
        error_px: f32 = 1.0, in 0.05..=100.0, unit "px", needs "lod.enabled=true";
        /// Whether surfaces that are seen small are drawn with less than their materials have.
        materials: bool = false;
        /// So wide is the ball around a surface in the picture where it does without normal maps, relief and clear
        /// coats.
        material_px: f32 = 16.0, in 1.0..=10000.0, unit "px", needs "lod.enabled=true", needs "lod.materials=true";
        /// So wide is it where the surface has no layer at all any more; it counts up to `lod.material_px`.
        plain_px: f32 = 8.0, in 0.0..=10000.0, unit "px", needs "lod.enabled=true", needs "lod.materials=true";
        /// So wide is it where the means of textures take their place; it counts up to `lod.plain_px`.
        untextured_px: f32 = 4.0, in 0.0..=10000.0, unit "px", needs "lod.enabled=true", needs "lod.materials=true";
        /// Over which part of its distance a level fades in, by a pattern of pixels; 0 switches at once.
        fade: f32 = 0.25, in 0.0..=1.0, unit "share", needs "lod.enabled=true";
        /// From this distance to the eye on, surfaces reflect the light of lamps by the cheapest model, evenly to all
        /// sides (Lambert), without highlights: what they would mirror of it is diffuse light. 0 for nowhere. Materials
        /// with layers stay as they are.
        lighting_m: f32 = 0.0, in 0.0..=1e9, unit "m", needs "lod.enabled=true";
        /// What has levels is taken for 2 to the power of this times as large as it is: positive numbers show finer
        /// levels.
        bias: f32 = 0.0, in -10.0..=10.0, unit "stops", needs "lod.enabled=true";
    }
}

impl LodSettings {
    /// Whether surfaces may be drawn with less than their materials have.
    pub fn reduces_materials(&self) -> bool {
        self.enabled && self.materials
    }
}
