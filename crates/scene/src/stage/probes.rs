//! Grids of probes of a stage.

use super::surroundings::region;
use super::table::{Source, SpannedValue, Table, whole};
use crate::probes::{GRIDS_MAX, LiveProbes, ProbeBasis, ProbeGrid};
use crate::surroundings::Region;
use crate::{Aabb, Diagnostic, Scene};
use glam::Vec3;
use std::ops::Range;

/// An entry of `[[probes]]`.
#[derive(Clone, Debug)]
pub(super) struct ProbesEntry {
    name: String,
    region: Option<Region>,
    counts: Option<SpannedValue<[u32; 3]>>,
    spacing_m: Option<SpannedValue<f32>>,
    fade_m: Option<f32>,
    basis: Option<ProbeBasis>,
    is_live: Option<bool>,
    live: LiveProbes,
    range: Range<usize>,
}

fn counts(table: &Table<'_>) -> Result<Option<SpannedValue<[u32; 3]>>, Box<Diagnostic>> {
    let Some(counts) = table.vector("counts") else { return Ok(None) };
    let is_whole = counts.fract() == Vec3::ZERO && counts.min_element() >= 1.0 && counts.max_element() <= 1e6;
    if !is_whole {
        return Err(table.fault("counts", "`counts` has three whole numbers above 0"));
    }
    let range = table.place("counts").unwrap_or_default();
    Ok(Some(SpannedValue { value: counts.to_array().map(|count| count as u32), range }))
}

impl ProbesEntry {
    /// An error at an entry whose name an earlier one has.
    pub(super) fn check(all: &[Self], source: &Source) -> Result<(), Box<Diagnostic>> {
        let twin = all.iter().enumerate().find(|(at, entry)| all[..*at].iter().any(|other| other.name == entry.name));
        match twin {
            Some((_, Self { name, range, .. })) => {
                Err(source.fault(range.clone(), format!("two grids of probes are called `{name}`")))
            }
            None => Ok(()),
        }
    }

    pub(super) fn read(table: &Table<'_>) -> Result<Self, Box<Diagnostic>> {
        let counts = counts(table)?;
        let range = table.place("spacing_m");
        let spacing_m = table.number("spacing_m").zip(range).map(|(value, range)| SpannedValue { value, range });
        if let (Some(_), Some(_)) = (&counts, &spacing_m) {
            return Err(table.fault("spacing_m", "`counts` says already how many there are; leave out one of both"));
        }
        let is_live = table.boolean("live");
        if let (Some(false), Some(key)) = (is_live, ["bounces", "layers"].iter().find(|key| table.place(key).is_some()))
        {
            return Err(table.fault(key, format!("`{key}` is only for live probes; leave out `live = false`")));
        }
        let usual = LiveProbes::default();
        let bounces = table.number("bounces").map(|bounces| whole(table, "bounces", bounces)).transpose()?;
        let live = LiveProbes {
            bounces: bounces.unwrap_or(usual.bounces),
            layers: table.layers("layers").unwrap_or(usual.layers),
        };
        Ok(Self {
            is_live,
            live,
            name: table.text("name").map_or("probes".into(), |name| name.value),
            region: region(table, ["center", "size_m"])?,
            counts,
            spacing_m,
            fade_m: table.number("fade_m"),
            basis: table.text("basis").and_then(|word| ProbeBasis::named(&word.value)),
            range: table.range.clone(),
        })
    }

    /// Adds the grid to the scene, with the light that the file has of it, if that was found for the same places.
    ///
    /// # Errors
    /// There are too many grids, or too many probes.
    pub(super) fn apply(&self, source: &Source, scene: &mut Scene) -> Result<(), Box<Diagnostic>> {
        let is_baked = |grid: &ProbeGrid| grid.name == self.name && grid.probes.is_some();
        let baked = scene.probes.iter().position(is_baked).map(|index| (index, scene.probes.remove(index)));
        let fault = |range: &Range<usize>, message: String| Err(source.fault(range.clone(), message));
        if scene.probes.iter().any(|grid| grid.name == self.name) {
            return fault(&self.range, format!("two grids of probes are called `{}`", self.name));
        }
        if scene.probes.len() == GRIDS_MAX {
            return fault(&self.range, format!("there are more grids of probes than {GRIDS_MAX}"));
        }
        let bounds = match self.region {
            Some(Region { center_world, half_m }) => Aabb { min: center_world - half_m, max: center_world + half_m },
            None => scene.bounds_world(),
        };
        let spacing_m = self.spacing_m.as_ref().map(|spacing| spacing.value);
        let of_counts = |grid: ProbeGrid| match &self.counts {
            Some(counts) => ProbeGrid::new(grid.name, grid.region, counts.value),
            None => Ok(grid),
        };
        let grid = ProbeGrid::over(self.name.as_str(), &bounds, spacing_m).and_then(of_counts);
        match grid {
            Ok(grid) => {
                let (fade_m, basis) = (self.fade_m.unwrap_or(0.0), self.basis.unwrap_or_default());
                // Of the same places within what is rounded.
                let apart_m = |baked: &ProbeGrid| {
                    let middle_m = (baked.region.center_world - grid.region.center_world).abs();
                    middle_m.max((baked.region.half_m - grid.region.half_m).abs()).max_element()
                };
                let is_same = |baked: &ProbeGrid| {
                    baked.counts == grid.counts && apart_m(baked) < 1e-3 * grid.region.half_m.max_element()
                };
                let live = |is_usual: bool| self.is_live.unwrap_or(is_usual).then_some(self.live);
                let own = ProbeGrid { fade_m, basis, live: live(true), ..grid.clone() };
                match baked {
                    Some((index, baked)) if is_same(&baked) => {
                        let fade_m = self.fade_m.unwrap_or(baked.fade_m);
                        scene.probes.insert(index, ProbeGrid { fade_m, live: live(false), ..baked });
                    }
                    Some((index, _)) => scene.probes.insert(index, own),
                    None => scene.probes.push(own),
                }
                Ok(())
            }
            Err(error) => {
                let at_counts = self.counts.as_ref().map(|counts| &counts.range);
                let range = at_counts.or(self.spacing_m.as_ref().map(|spacing| &spacing.range)).unwrap_or(&self.range);
                fault(range, error.to_string())
            }
        }
    }
}
