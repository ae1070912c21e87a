//! Settings of shadows.

use crate::setting::{choices, rounded_up, settings};

choices! {
    /// The filter of shadow edges.
    pub enum ShadowFilter {
        /// No filter: texels of the map are visible.
        Hard = "hard",
        /// Percentage-closer filtering: the mean of comparisons with texels (Reeves, Salesin & Cook 1987).
        #[default]
        Pcf = "pcf",
        /// Percentage-closer soft shadows: the penumbra follows from light and blockers (Fernando 2005). Lights without a
        /// radius have none.
        Pcss = "pcss",
    }
}

settings! {
    /// Settings of shadows.
    pub struct ShadowSettings {
        /// Whether lights cast shadows.
        enabled: bool = true;
        /// The filter of shadow edges.
        filter: ShadowFilter = ShadowFilter::Pcf, needs "shadows.enabled=true";
        /// The kernel of `pcf`: this many comparisons across and down, a texel apart, each the mean of four texels. 1
        /// is the sharpest. More make softer edges; their width depends on texels and not on the light.
        kernel: u32 = 2, in 1..=5, needs "shadows.filter=pcf";
        /// The largest width and height of the shadow atlas, the texture with all shadow maps, rounded up to a power of
        /// two. It takes four bytes a texel. It grows with the lights in view, and is smaller for small pictures.
        atlas_px: u32 = 4096, in 256..=16384, unit "px", needs "shadows.enabled=true";
        /// The width and height of each shadow map, rounded up to a power of two, at least 16. 0 follows the picture's
        /// resolution. All maps are halved until they fit into the atlas.
        map_px: u32 = 0, in 0..=8192, unit "px", needs "shadows.enabled=true";
        /// The most shadow maps of point and spot lights in a frame that stands for itself, as in `bench` and in the
        /// browser. A point light takes six, a spot one. The least important lights are left out, and counted. Stills
        /// have as many maps as their lights need.
        maps: u32 = 1024, in 0..=65536, needs "shadows.enabled=true";
        /// The most cascades of a directional light. They reach from the nearest surface to the end of the scene. Each
        /// ends four times as far away as it begins, or twice as far if four cascades are enough for that.
        cascades: u32 = 8, in 1..=8, needs "shadows.enabled=true";
        /// The split of cascades: 0 for equal steps of distance, 1 for equal ratios. With ratios texels are about as
        /// wide in the picture at all distances.
        split: f32 = 1.0, in 0.0..=1.0, needs "shadows.enabled=true";
        /// The distance from the eye up to which directional lights cast shadows; they fade out at the end. A smaller
        /// one makes shadows finer. 0 reaches to the end of the scene.
        distance_m: f32 = 0.0, in 0.0..=1e6, unit "m", needs "shadows.enabled=true";
        /// The width of a square around the middle of what is drawn. Directional lights cast shadows only in it, by one
        /// map each in place of cascades. Everything outside is lit. 0 for cascades, which follow the view.
        extent_m: f32 = 0.0, in 0.0..=1e6, unit "m", needs "shadows.enabled=true";
        /// The near plane of the shadow maps of directional lights: surfaces before it cast no shadow. It is measured
        /// from where rays enter the bounding sphere of all that is drawn. 0 fits it to the surface nearest to the
        /// light.
        near_m: f32 = 0.0, in 0.0..=1e6, unit "m", needs "shadows.enabled=true";
        /// The far plane of these maps, measured from the same place: surfaces beyond it cast no shadow. 0 fits it to
        /// the surface farthest from the light.
        far_m: f32 = 0.0, in 0.0..=1e6, unit "m", needs "shadows.enabled=true";
        /// The least texels across a shadow map as fine as the picture. Point and spot lights that need fewer are small
        /// in the picture, and cast no shadow. Below 16 a map is only border.
        min_px: f32 = 0.0, in 0.0..=16384.0, unit "px", needs "shadows.enabled=true";
        /// Whether the shadow maps of a still are spread over its samples if they do not fit into the atlas at once.
        /// Then every light casts its shadow. Otherwise the lights without room cast none, and are counted. `bench` and
        /// the browser never spread maps.
        spread_over_samples: bool = true, needs "shadows.enabled=true";
        /// The normal offset bias: a surface is moved by this along its normal before the comparison.
        bias_texels: f32 = 1.25, in 0.0..=16.0, unit "texels", needs "shadows.enabled=true";
        /// Contact shadows (screen space): the length of rays through the picture's depth, from surfaces towards lights
        /// with shadows. They darken gaps that shadow maps miss; 0 for none. Transmissive surfaces, materials with
        /// layers and fog do not change. Stills draw all samples of all pixels.
        contact_m: f32 = 0.0, in 0.0..=1e6, unit "m", needs "shadows.enabled=true", needs "render.path=deferred";
        /// The number of steps of a contact shadow's ray; every sample shifts them. Rounded up to 2, 4, 8, 16, 24, 32,
        /// 48 or 64, to limit the number of pipelines.
        contact_steps: u32 = 8, in 1..=64, needs "shadows.enabled=true";
        /// The thickness of surfaces behind their visible front for contact shadows, so that thin objects do not hide
        /// too much. Hits farther behind count less. 0 for half of `contact_m`.
        contact_thickness_m: f32 = 0.0, in 0.0..=1e6, unit "m", needs "shadows.enabled=true";
    }
}

impl ShadowSettings {
    /// Whether there are contact shadows.
    pub fn has_contact(&self) -> bool {
        self.enabled && self.contact_m > 0.0
    }

    /// The number of steps of contact shadows in shaders.
    pub fn contact_length(&self) -> u32 {
        rounded_up(self.contact_steps, &[2, 4, 8, 16, 24, 32, 48, 64])
    }
}
