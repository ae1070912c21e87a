//! The words that keys take, and the largest numbers: for the keys, and for who reads them.

use crate::material::LightEncoding;
use crate::particles::PARTICLES_MAX;

/// The words of `update`.
pub(super) const UPDATES: &[&str] = &["always", "once"];
/// The words of `quality`; whoever draws knows what they mean.
pub(super) const QUALITIES: &[&str] = &["low", "medium", "high", "ultra"];
/// The words of `slot`.
pub(super) const SLOTS: &[&str] = &["emission", "base_color"];
/// The words of `height_method`.
pub(super) const METHODS: &[&str] = &["bump", "parallax", "steep", "occlusion"];
/// The words of `light_map_encoding`.
pub(super) const ENCODINGS: &[&str] = &LightEncoding::NAMES;
/// The words of `normal_convention`.
pub(super) const CONVENTIONS: &[&str] = &["opengl", "directx"];
/// The most that `count` of particles may be.
pub(super) const COUNT_MAX: f64 = PARTICLES_MAX as f64;
