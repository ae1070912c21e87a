//! Judges the pictures of the browser against the native ones.

use super::cases::Case;
use super::{BACKENDS, picture, variables, without};
use crate::step::{open_picture, root};
use anyhow::{Context, Result, ensure};
use manypass_testkit::compare::{self, Difference, Picture, Tolerance};
use std::path::PathBuf;

fn difference(a: &Picture, b: &Picture) -> Result<Difference> {
    let sizes = [a, b].map(|picture| (picture.width, picture.height));
    ensure!(sizes[0] == sizes[1], "the sizes differ: {sizes:?}");
    Ok(compare::difference(a, b, Tolerance::RASTERIZERS.within))
}

/// What is wrong with the exposures that were metered, if anything.
fn exposure_fault(case: &Case) -> Result<Option<String>> {
    // Of several frames the last one has the last line.
    let read = |path: PathBuf| -> Result<serde_json::Value> {
        let bytes = std::fs::read(path)?;
        let values = serde_json::Deserializer::from_slice(&bytes).into_iter();
        Ok(values.last().context("there is no report")??)
    };
    let native = read(picture(case, "native").with_extension("json"))?["exposure"]["stops"].as_f64();
    for backend in BACKENDS {
        let path = root().join(format!("target/browser/{}-{backend}-exposure.json", case.name));
        let found = read(path)?["stops"].as_f64();
        let is_same = native.zip(found).is_some_and(|(a, b)| (a - b).abs() <= case.exposure_within_stops);
        if !is_same {
            return Ok(Some(format!("{backend} takes an exposure of {found:?} stops, native {native:?}")));
        }
    }
    Ok(None)
}

/// Prints every difference before it fails at one.
pub(super) fn judge(case: &Case) -> Result<()> {
    let native = open_picture(&picture(case, "native"))?;
    for (name, spoilt) in compare::mutations(&native) {
        let found = difference(&native, &spoilt)?;
        ensure!(!found.is_within(case.tolerance), "the comparison would accept the picture {name}: {found}");
    }
    for (index, settings) in case.without.iter().enumerate() {
        let found = difference(&native, &open_picture(&picture(case, &without(index)))?)?;
        println!("    {:24} native with {settings:?}: {found}", case.name);
        ensure!(!found.is_within(case.tolerance), "the comparison would accept the picture with {settings:?}: {found}");
    }
    let mut refused = Vec::new();
    for backend in BACKENDS {
        let drawn = open_picture(&picture(case, backend))?;
        let found = difference(&native, &drawn)?;
        println!("    {:24} {backend:6} against native: {found}", case.name);
        if !found.is_within(case.tolerance) {
            refused.push(format!("{backend} differs from native: {found}"));
        }
        // A screenshot is composited by the browser, but without scaling and in sRGB.
        let shown = difference(&drawn, &open_picture(&picture(case, &format!("{backend}-canvas")))?)?;
        // The echo grew with the frame in between, and so did a mean of frames.
        if case.echo.is_none() && case.frames == 1 && !shown.is_within(Tolerance::default()) {
            refused.push(format!("the canvas does not show the picture on {backend}: {shown}"));
        }
    }
    refused.extend(exposure_fault(case)?);
    if case.has_variables {
        refused.extend(variables::faults(case.name)?);
    }
    // One rasterizer stands behind both, so here nothing but rounding may differ.
    let [webgpu, webgl] = BACKENDS.map(|backend| open_picture(&picture(case, backend)));
    let between = difference(&webgpu?, &webgl?)?;
    if !between.is_within(Tolerance::default()) {
        refused.push(format!("webgl differs from webgpu: {between}"));
    }
    ensure!(refused.is_empty(), "{}", refused.join("; "));
    Ok(())
}
