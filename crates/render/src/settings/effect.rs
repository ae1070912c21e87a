//! Settings of the chain of effects.

use crate::setting::settings;

settings! {
    /// Settings of the chain of effects.
    pub struct EffectSettings {
        /// Whether post-processing is drawn: the chain, ambient occlusion and all other screen-space passes. It turns
        /// nothing on that is off.
        enabled: bool = true;
        /// The effects in the order in which they are drawn: names of built-in effects, of effects that are given
        /// (`--effect`), or files (`NAME.wgsl`). Effects on radiance come before those on display colours.
        chain: Vec<String> = Vec::new(), needs "effects.enabled=true";
        /// Whether effects whose file names a cheaper one (`//! fallback: NAME`) are replaced by it.
        fallbacks: bool = false, needs "effects.enabled=true";
    }
}
