//! Two pictures, or what was drawn of two models, and how they differ.

use super::linear::Linear;
use super::models::{Models, Placement};
use super::source::Source;
use super::variables::{self, Variables};
use crate::failure::Failure;
use manypass_flip::{ErrorMap, Exposures, FlipError, hdr, ldr};
use manypass_offline::decode::Light;
use manypass_offline::{AovLayer, CameraData};

/// Two pictures and how they differ.
#[derive(Debug)]
pub(super) struct Comparison {
    pub(super) a: Source,
    pub(super) b: Source,
    pub(super) map: ErrorMap,
    /// Of radiance alone.
    pub(super) exposures: Option<Exposures>,
    pub(super) pixels_per_degree: f32,
    /// Of radiance alone.
    pub(super) linear: Option<Linear>,
    /// Of models alone.
    pub(super) models: Option<ModelComparison>,
}

/// How two models differ.
#[derive(Debug)]
pub(super) struct ModelComparison {
    pub(super) layers: [Vec<AovLayer>; 2],
    pub(super) camera: CameraData,
    pub(super) placement: Placement,
    pub(super) variables: Variables,
}

/// Compares two pictures.
///
/// # Errors
/// Wrong usage: the two cannot be compared.
pub(super) fn pictures(a: Source, b: Source, pixels_per_degree: f32) -> Result<Comparison, Failure> {
    if a.light != b.light {
        let is = |light| if light == Light::Scene { "holds radiance" } else { "is for a display" };
        let message = format!("{} {}, but {} {}", a.name, is(a.light), b.name, is(b.light));
        return Err(Failure::usage(message, "compare EXR with EXR, or write both as PNG"));
    }
    let (size_a, size_b) = (a.picture.size(), b.picture.size());
    if size_a != size_b {
        let sized = |name: &str, (width, height): (usize, usize)| format!("{name} has {width}x{height} pixels");
        let message = format!("{}, but {}", sized(&a.name, size_a), sized(&b.name, size_b));
        return Err(Failure::usage(message, "render or scale both to one size; nothing is scaled here"));
    }
    let failed = |error: FlipError| Failure::usage(error, "see `manypass diff --help`");
    let linear = (a.light == Light::Scene).then(|| Linear::of(&a, &b));
    let (map, exposures) = match a.light {
        Light::Display => (ldr(&a.picture, &b.picture, pixels_per_degree).map_err(failed)?, None),
        Light::Scene => {
            let (map, exposures) = hdr(&a.picture, &b.picture, pixels_per_degree).map_err(failed)?;
            (map, Some(exposures))
        }
    };
    Ok(Comparison { a, b, map, exposures, pixels_per_degree, linear, models: None })
}

/// Compares what was drawn of two models.
///
/// # Errors
/// As [`pictures`].
pub(super) fn drawn(models: Models, pixels_per_degree: f32) -> Result<Comparison, Failure> {
    let variables = variables::compare(&models);
    let Models { a, b, layers, camera, placement, .. } = models;
    let compared = ModelComparison { layers, camera, placement, variables };
    Ok(Comparison { models: Some(compared), ..pictures(a, b, pixels_per_degree)? })
}
