//! What a bake says that it did.

use super::bakers::BakeResults;
use super::outputs::Outputs;
use glam::Vec3;
use serde_json::{Value, json};

/// What was done.
pub(super) struct Report<'a> {
    pub(super) found: &'a BakeResults,
    pub(super) outputs: &'a Outputs,
    pub(super) warnings: &'a [String],
    pub(super) ms: f64,
    pub(super) bytes: usize,
}

fn plural(count: usize) -> &'static str {
    if count == 1 { "" } else { "s" }
}

impl Report<'_> {
    /// How many probes there are, how many of them were moved, and how many are off.
    fn probes(&self) -> [usize; 3] {
        let all = || self.found.grids.iter().filter_map(|grid| grid.probes.as_ref()).flat_map(|probes| probes.iter());
        let moved = all().filter(|probe| probe.is_on && probe.offset_m != Vec3::ZERO).count();
        [all().count(), moved, all().filter(|probe| !probe.is_on).count()]
    }

    /// As JSON.
    pub(super) fn json(&self) -> Value {
        let maps = self.found.maps.as_ref().map(|maps| {
            let layout = &maps.layout;
            json!({
                "light": if maps.light.is_empty() { 0 } else { layout.page_count },
                "directions": if maps.direction.is_empty() { 0 } else { layout.page_count },
                "occlusion": if maps.occlusion.is_empty() { 0 } else { layout.page_count },
                "width": layout.width,
                "height": layout.height,
                "texels_per_m": layout.texels_per_m,
                "charts": layout.chart_count,
                "surfaces": layout.unwrapped.len(),
            })
        });
        let [count, moved, off] = self.probes();
        let grids: Vec<Value> =
            self.found.grids.iter().map(|grid| json!({ "name": grid.name, "counts": grid.counts })).collect();
        json!({
            "output": self.outputs.model,
            "stage": self.outputs.stage,
            "bytes": self.bytes,
            "maps": maps,
            "surroundings": self.found.places.len(),
            "probes": { "grids": grids, "count": count, "moved": moved, "off": off },
            "ms": self.ms,
            "warnings": self.warnings,
        })
    }

    /// As a line for people.
    pub(super) fn text(&self) -> String {
        let stage = self.outputs.stage.as_ref().map_or(String::new(), |path| format!(" and {}", path.display()));
        let of_maps = self.found.maps.as_ref().map(|maps| {
            let layout = &maps.layout;
            let each = [maps.light.is_empty(), maps.direction.is_empty(), maps.occlusion.is_empty()];
            let each = each.iter().filter(|is_empty| !**is_empty).count();
            let count = each * layout.page_count as usize;
            let (pieces, surfaces) = (layout.chart_count as usize, layout.unwrapped.len());
            format!(
                "{count} map{} of {} x {} texels, {} a metre, {pieces} piece{} of {surfaces} surface{}",
                plural(count),
                layout.width,
                layout.height,
                layout.texels_per_m,
                plural(pieces),
                plural(surfaces),
            )
        });
        let [count, moved, off] = self.probes();
        let of_probes = (count > 0).then(|| {
            let [x, y, z] = self.found.grids.first().map_or([0; 3], |grid| grid.counts);
            let place = match self.found.grids.len() {
                1 => format!("{x} x {y} x {z}"),
                grids => format!("in {grids} grids"),
            };
            format!("{count} probe{} ({place}; {moved} moved, {off} off)", plural(count))
        });
        let of_places = Some(self.found.places.len()).filter(|count| *count > 0);
        let of_places = of_places.map(|count| format!("{count} reflection probe{}", plural(count)));
        let parts: Vec<String> = of_maps.into_iter().chain(of_probes).chain(of_places).collect();
        format!("{}{stage}: {}, {:.1} s", self.outputs.model.display(), parts.join("; "), self.ms / 1e3)
    }
}
