//! Settings of the chain of effects.

use crate::setting::settings;

settings! {
    /// Settings of the chain of effects.
    pub struct EffectSettings {
        /// Whether there are effects: those of the chain, ambient occlusion and whatever else looks at the picture once it
        /// is there. What is off stays off.
        enabled: bool = true;
        /// Effects in the order in which they are drawn: names of built-in ones, of those given beside it, or files
        /// (`NAME.wgsl`). Those on radiance come before those on display colours.
        chain: Vec<String> = Vec::new(), needs "effects.enabled=true";
        /// Whether effects whose file names a cheaper one (`//! fallback: NAME`) are drawn as that.
        fallbacks: bool = false, needs "effects.enabled=true";
    }
}
