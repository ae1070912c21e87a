//! Grids of probes in files: `MANYPASS_probes` of the root.
//!
//! Each of `grids` has `center` and `size` in metres, `counts`, and three accessors: `light` (VEC3: 9 coefficients of
//! spherical harmonics or 6 colours a probe, as `basis` says), with harmonics `sources` (VEC4: direction and
//! spread, then irradiance and 0, of [`SmallSource`]; may be left out), `places` (VEC4: how far it was moved, and 1 if it has light),
//! and `distances` (VEC2: [`Probe::distances`]).

use super::accessor::to_f32;
use super::document::Document;
use super::error::LoadError;
use super::json::Json;
use super::write::{Numbers, Parts};
use crate::probes::{
    AmbientCube, DISTANCE_SIDE, GRIDS_MAX, Harmonics, Probe, ProbeBasis, ProbeGrid, ProbeLight, SmallSource,
};
use crate::surroundings::Region;
use glam::{Vec2, Vec3, Vec4};
use serde_json::{Value, json};
use std::sync::Arc;

const EXTENSION: &str = "MANYPASS_probes";
const DISTANCES: usize = DISTANCE_SIDE * DISTANCE_SIDE;

/// The grids of a file.
pub(super) fn read_probes(document: &mut Document) -> Result<Vec<ProbeGrid>, LoadError> {
    let Some(extension) = document.root.extension(EXTENSION)? else { return Ok(Vec::new()) };
    let grids = extension.objects("grids")?;
    if grids.len() > GRIDS_MAX {
        document.warn(&extension.at("grids"), &format!("only the first {GRIDS_MAX} grids of probes are read"));
    }
    grids.iter().take(GRIDS_MAX).map(|json| read_grid(document, json)).collect()
}

fn elements<const N: usize>(
    document: &mut Document,
    json: &Json,
    key: &str,
    count: usize,
) -> Result<Vec<[f32; N]>, LoadError> {
    let index = json.require_integer(key)?;
    let elements: Vec<[f32; N]> = document.read(index, &json.at(key), to_f32)?;
    if elements.len() != count {
        return Err(json.error(key, format!("expected an accessor of {count} elements, found {}", elements.len())));
    }
    Ok(elements)
}

fn read_grid(document: &mut Document, json: &Json) -> Result<ProbeGrid, LoadError> {
    let vector = |key: &str| -> Result<Vec3, LoadError> {
        let numbers =
            json.numbers::<3>(key)?.ok_or_else(|| json.error(key, "expected three numbers, found nothing"))?;
        Ok(Vec3::from(numbers))
    };
    let region = Region { center_world: vector("center")?, half_m: 0.5 * vector("size")? };
    let counts = vector("counts")?.to_array().map(|count| if count >= 1.0 { count.min(1e6) as u32 } else { 0 });
    let mut grid =
        ProbeGrid::new(json.name(), region, counts).map_err(|error| json.error("counts", error.to_string()))?;
    grid.fade_m = json.number_in("fade", 0.0, 0.0, f32::MAX)?;
    let word = json.string("basis")?.unwrap_or("harmonics");
    grid.basis = ProbeBasis::named(word)
        .ok_or_else(|| json.error("basis", format!("expected one of {:?}, found {word}", ProbeBasis::NAMES)))?;
    let count = grid.count();
    document.spend((count * size_of::<Probe>()) as u64, &json.pointer)?;
    let colors = elements::<3>(document, json, "light", count * grid.basis.colors())?;
    let has_sources = json.has("sources") && grid.basis == ProbeBasis::Harmonics;
    let sources = if has_sources { elements::<4>(document, json, "sources", 2 * count)? } else { Vec::new() };
    let places = elements::<4>(document, json, "places", count)?;
    let distances = elements::<2>(document, json, "distances", count * DISTANCES)?;
    let mut broken = 0;
    let mut probe = |index: usize| {
        let colors = colors.iter().skip(index * grid.basis.colors()).map(|color| Vec3::from(*color));
        let mut next = colors.take(grid.basis.colors());
        let mut color = || next.next().unwrap_or_default();
        let light = match grid.basis {
            ProbeBasis::Harmonics => {
                let [direction, irradiance] =
                    [2 * index, 2 * index + 1].map(|at| sources.get(at).copied().map(Vec4::from).unwrap_or_default());
                let source = SmallSource {
                    direction: direction.truncate().normalize_or_zero(),
                    irradiance: irradiance.truncate(),
                    spread: direction.w,
                };
                ProbeLight::Harmonics(Harmonics(std::array::from_fn(|_| color())), source)
            }
            ProbeBasis::AmbientCube => ProbeLight::AmbientCube(AmbientCube(std::array::from_fn(|_| color()))),
        };
        let place = Vec4::from(places[index]);
        let distances: [Vec2; DISTANCES] = std::array::from_fn(|at| Vec2::from(distances[index * DISTANCES + at]));
        let SmallSource { direction, irradiance, spread } = light.source();
        let has_sound_source = direction.is_finite() && irradiance.is_finite() && (0.0..=1.0).contains(&spread);
        let is_sound = has_sound_source
            && light.colors().iter().all(|color| color.is_finite())
            && place.is_finite()
            && distances.iter().all(|distance| distance.is_finite() && distance.min_element() >= 0.0);
        if !is_sound {
            broken += 1;
            return Probe::default();
        }
        Probe { offset_m: place.truncate(), is_on: place.w > 0.5, light, distances }
    };
    grid.probes = Some(Arc::new((0..count).map(&mut probe).collect()));
    if broken > 0 {
        document.warn(&json.pointer, &format!("{broken} probes hold no numbers; they are off"));
    }
    Ok(grid)
}

impl Parts {
    /// Puts grids of probes whose light is known into the file, in place of those that it has.
    pub fn put_probes(&mut self, grids: &[ProbeGrid]) {
        self.forget_root(EXTENSION);
        let written: Vec<Value> = grids.iter().filter_map(|grid| self.put_grid(grid)).collect();
        if written.is_empty() {
            return;
        }
        self.use_extension(EXTENSION);
        self.json["extensions"][EXTENSION] = json!({ "grids": written });
    }

    fn put_grid(&mut self, grid: &ProbeGrid) -> Option<Value> {
        let probes = grid.probes.as_ref()?;
        let colors: Vec<[f32; 3]> = probes.iter().flat_map(|probe| probe.light.colors()).map(Vec3::to_array).collect();
        let place = |probe: &Probe| probe.offset_m.extend(if probe.is_on { 1.0 } else { 0.0 }).to_array();
        let places: Vec<[f32; 4]> = probes.iter().map(place).collect();
        let distances: Vec<[f32; 2]> =
            probes.iter().flat_map(|probe| probe.distances).map(|distance| distance.to_array()).collect();
        let mut written = json!({
            "name": grid.name,
            "basis": grid.basis.name(),
            "center": grid.region.center_world.to_array(),
            "size": (2.0 * grid.region.half_m).to_array(),
            "counts": grid.counts,
            "fade": grid.fade_m,
            "light": self.append_accessor(Numbers::Vec3(&colors)),
            "places": self.append_accessor(Numbers::Vec4(&places)),
            "distances": self.append_accessor(Numbers::Vec2(&distances)),
        });
        if grid.basis == ProbeBasis::Harmonics {
            let of_probe = |probe: &Probe| {
                let SmallSource { direction, irradiance, spread } = probe.light.source();
                [direction.extend(spread).to_array(), irradiance.extend(0.0).to_array()]
            };
            let sources: Vec<[f32; 4]> = probes.iter().flat_map(of_probe).collect();
            written["sources"] = self.append_accessor(Numbers::Vec4(&sources)).into();
        }
        Some(written)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gltf_file::load_bytes;

    fn grid(basis: ProbeBasis) -> ProbeGrid {
        let region = Region { center_world: Vec3::new(1.0, 2.0, 3.0), half_m: Vec3::new(2.0, 1.0, 0.5) };
        let mut grid = ProbeGrid { fade_m: 0.25, basis, ..ProbeGrid::new("hall", region, [3, 2, 1]).unwrap() };
        let probe = |index: usize| {
            let mut light = Harmonics::default();
            light.add(Vec3::Y, Vec3::new(1.0, 2.0, index as f32));
            let distances = std::array::from_fn(|at| Vec2::new(at as f32, 0.5));
            Probe {
                offset_m: Vec3::splat(0.01 * index as f32),
                is_on: index != 2,
                light: ProbeLight::new(
                    &light,
                    SmallSource { direction: Vec3::Z, irradiance: Vec3::ONE, spread: 0.25 },
                    basis,
                ),
                distances,
            }
        };
        grid.probes = Some(Arc::new((0..grid.count()).map(probe).collect()));
        grid
    }

    fn loaded(parts: &Parts) -> Result<crate::LoadedScene, LoadError> {
        load_bytes(&parts.clone().to_glb().unwrap(), &mut |_| Err("none".into()), "a.glb")
    }

    #[test]
    fn grids_come_back_as_they_were() {
        let mut parts = Parts::empty();
        let grids = [grid(ProbeBasis::Harmonics), grid(ProbeBasis::AmbientCube)];
        parts.put_probes(&grids);
        parts.put_probes(&grids);
        parts.prune(&parts.clone().unreferenced());
        assert_eq!(parts.list("accessors").len(), 7);
        assert_eq!(loaded(&parts).unwrap().scene.probes, grids);
        parts.put_probes(&[]);
        assert!(parts.json.get("extensions").is_none() && parts.json.get("extensionsUsed").is_none());
    }

    #[test]
    fn wrong_grids_are_refused_and_broken_probes_are_off() {
        let mut parts = Parts::empty();
        parts.put_probes(&[grid(ProbeBasis::Harmonics)]);
        for (key, value, expected) in [
            ("counts", json!([100, 100, 100]), "100 x 100 x 100 probes; a grid has 1 to 16384"),
            ("counts", json!([0, 1, 1]), "0 x 1 x 1 probes"),
            ("counts", json!([3, 2, 2]), "expected an accessor of 108 elements, found 54"),
            ("size", json!([1, 0, 1]), "the box of the probes has no extent"),
            ("basis", json!("sg"), "found sg"),
            ("light", json!(9), "refers to accessor 9"),
        ] {
            let mut wrong = parts.clone();
            wrong.json["extensions"][EXTENSION]["grids"][0][key] = value;
            let error = loaded(&wrong).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
        let mut broken = grid(ProbeBasis::Harmonics);
        Arc::make_mut(broken.probes.as_mut().unwrap())[1].offset_m.x = f32::NAN;
        let mut parts = Parts::empty();
        parts.put_probes(&[broken]);
        let loaded = loaded(&parts).unwrap();
        assert!(
            loaded.warnings.iter().any(|warning| warning.contains("1 probes hold no numbers")),
            "{:?}",
            loaded.warnings
        );
        assert!(!loaded.scene.probes[0].probes.as_ref().unwrap()[1].is_on);
    }
}
