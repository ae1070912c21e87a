//! Settings of shadows.

use crate::setting::{choices, rounded_up, settings};

choices! {
    /// How the edge of a shadow is filtered.
    pub enum ShadowFilter {
        /// Not at all: texels of the map are seen.
        Hard = "hard",
        /// The mean of comparisons with the texels around (Reeves, Salesin & Cook 1987).
        #[default]
        Pcf = "pcf",
        /// The same over a penumbra as wide as the light and what blocks it make it (Fernando 2005). Lights without a
        /// radius have none.
        Pcss = "pcss",
    }
}

settings! {
    /// Settings of shadows.
    pub struct ShadowSettings {
        /// Whether lights cast shadows.
        enabled: bool = true;
        /// How the edge of a shadow is filtered.
        filter: ShadowFilter = ShadowFilter::Pcf, needs "shadows.enabled=true";
        /// The kernel of `pcf`: so many comparisons across and as many down, a texel apart, each the mean of four texels.
        /// 1 is the sharpest; more make softer edges, whose width is that of texels and not of the light.
        kernel: u32 = 2, in 1..=5, needs "shadows.filter=pcf";
        /// The greatest width and height of the texture that holds all shadow maps, rounded up to a power of two; it
        /// takes four bytes a texel. It grows with what the lights in view want, and is smaller for small pictures.
        atlas_px: u32 = 4096, in 256..=16384, unit "px", needs "shadows.enabled=true";
        /// The map size: how many texels wide and high each shadow map of a light is, rounded up to a power of two, at
        /// least 16. 0 for as many as the picture asks for. All are halved until the atlas has room for them.
        map_px: u32 = 0, in 0..=8192, unit "px", needs "shadows.enabled=true";
        /// The most shadow maps of lights at a place in a frame that stands for itself, as in `bench` and in the
        /// browser: six for a point light, one for a spot. Those of the lights that matter least are left out, and
        /// counted. Stills have as many as their lights need.
        maps: u32 = 1024, in 0..=65536, needs "shadows.enabled=true";
        /// The most shadow maps of a directional light, each for a part of the view's depth. As many are taken as make each
        /// end four times as far away as it begins, from the nearest surface to the end of the scene; or twice, if four do.
        cascades: u32 = 8, in 1..=8, needs "shadows.enabled=true";
        /// Where one of them ends and the next begins: 0 for equal steps of distance, 1 for equal ratios, which leave
        /// texels about as wide in the picture at all distances.
        split: f32 = 1.0, in 0.0..=1.0, needs "shadows.enabled=true";
        /// How far from the eye directional lights cast shadows, which are finer for it, and fade out at the end; 0 for
        /// as far as the scene reaches.
        distance_m: f32 = 0.0, in 0.0..=1e6, unit "m", needs "shadows.enabled=true";
        /// The width of the square around the middle of what is drawn within which directional lights cast shadows, by
        /// one map each in place of cascades; beyond it all is lit. 0 for cascades, which follow the view.
        extent_m: f32 = 0.0, in 0.0..=1e6, unit "m", needs "shadows.enabled=true";
        /// The near plane of the shadow maps of directional lights: what lies before it casts no shadow. It is this far
        /// from where their rays enter the ball around all that is drawn. 0 for what is nearest to the light.
        near_m: f32 = 0.0, in 0.0..=1e6, unit "m", needs "shadows.enabled=true";
        /// Their far plane, from the same place: what lies beyond it casts no shadow. 0 for what is farthest from the
        /// light.
        far_m: f32 = 0.0, in 0.0..=1e6, unit "m", needs "shadows.enabled=true";
        /// A light at a place casts no shadow where a map as fine as the picture would have fewer texels a side than this: it
        /// is seen too small. Below 16 a map is nothing but border.
        min_px: f32 = 0.0, in 0.0..=16384.0, unit "px", needs "shadows.enabled=true";
        /// Whether the shadow maps of a still are spread over its samples where they do not fit into the atlas at once: then
        /// every light casts its shadow. Otherwise, and always in `bench` and in the browser, the lights without room cast
        /// none, and are counted.
        spread_over_samples: bool = true, needs "shadows.enabled=true";
        /// Texels by which a surface is moved along its normal before it is compared with a map.
        bias_texels: f32 = 1.25, in 0.0..=16.0, unit "texels", needs "shadows.enabled=true";
        /// How far from a surface towards each light that casts shadows the picture is searched for what hides that
        /// light, so that gaps which shadow maps miss are dark; 0 for not at all. Glass, materials with layers and fog
        /// stay what they are; stills draw all samples of all pixels.
        contact_m: f32 = 0.0, in 0.0..=1e6, unit "m", needs "shadows.enabled=true", needs "render.path=deferred";
        /// In how many places of the picture such a search looks; other ones in every sample. Rounded up to 2, 4, 8, 16,
        /// 24, 32, 48 or 64, so that a slider makes few pipelines.
        contact_steps: u32 = 8, in 1..=64, needs "shadows.enabled=true";
        /// How far surfaces are taken to go on behind what is seen of them, so that thin things hide no more than they
        /// do; the farther behind, the less that counts. 0 for half of `contact_m`.
        contact_thickness_m: f32 = 0.0, in 0.0..=1e6, unit "m", needs "shadows.enabled=true";
    }
}

impl ShadowSettings {
    /// Whether the picture is searched for shadows that maps miss.
    pub fn has_contact(&self) -> bool {
        self.enabled && self.contact_m > 0.0
    }

    /// In how many places shaders look for them.
    pub fn contact_length(&self) -> u32 {
        rounded_up(self.contact_steps, &[2, 4, 8, 16, 24, 32, 48, 64])
    }
}
