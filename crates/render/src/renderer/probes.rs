//! Probes of a frame: their texels beside the tiles of the environment, and which of them frames look around.

use crate::environment::EnvironmentUniform;
use crate::environment::picture::write_texels;
use crate::gpu::Gpu;
use crate::probes::{
    FILTERS_EXACTLY, GridPlace, PROBE_GRIDS, PROBE_SOURCES, PlacedGrid, ProbeLayout, ProbesUniform, ProbesUniforms,
    grid_texels, has_sources, most_moved_m, unlit,
};
use crate::shader::program::Constant;
use bytemuck::Zeroable as _;
use glam::Vec3;
use manypass_scene::probes::{LiveProbes, Probe, ProbeBasis, ProbeGrid};
use manypass_scene::surroundings::Region;
use std::sync::Arc;

/// The light of a live grid is written anew where the exposure has changed by so much since: half floats have no room for more.
const EXPOSURE_RATIO_MAX: f32 = 256.0;
/// And that of a still by so much.
const STILL_RATIO_MAX: f32 = 16.0;

/// The texels of probes that are on the device.
#[derive(Clone, Debug, Default)]
pub(super) struct ProbeTexels {
    layout: ProbeLayout,
    written: Vec<UploadedGrid>,
    /// The live grid that frames look into next.
    turn: usize,
    /// Whether a still has found the light that is there.
    is_of_still: bool,
}

/// What was written of a grid.
#[derive(Clone, Debug)]
struct UploadedGrid {
    region: Region,
    counts: [u32; 3],
    basis: ProbeBasis,
    probes: Option<Arc<Vec<Probe>>>,
    live: Option<LiveProbes>,
    /// What its light was divided by.
    scale: f32,
    has_sources: bool,
    moved_m: Vec3,
    /// Which of the two lights of a live grid frames read.
    light: usize,
    /// How many of its probes frames have looked around, and around how many they still do.
    done: usize,
    left: usize,
}

/// A probe that a frame looks around.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct DueProbe {
    /// Which of the known grids, and which of its probes.
    pub grid: usize,
    pub probe: usize,
}

/// The grids of a frame.
#[derive(Clone, Debug)]
pub(super) struct PlacedProbes {
    /// For radiance that is not pre-exposed.
    uniforms: ProbesUniforms,
    filters_exactly: bool,
    pub grids: Vec<PlacedGrid>,
}

impl PlacedProbes {
    fn new(gpu: &Gpu, grids: &[&ProbeGrid], corner: [u32; 2], placed: Vec<PlacedGrid>) -> Self {
        let mut uniforms = ProbesUniforms::zeroed();
        for (uniform, (grid, of)) in uniforms.iter_mut().zip(grids.iter().zip(&placed)) {
            *uniform = ProbesUniform::new(grid, corner, of);
        }
        Self { uniforms, filters_exactly: gpu.capabilities.filters_exactly, grids: placed }
    }

    /// Of a frame that is planned only.
    pub fn of_plan(gpu: &Gpu, layout: &ProbeLayout, grids: &[&ProbeGrid]) -> Self {
        let placed = layout.places.iter().zip(grids).map(|(place, grid)| PlacedGrid {
            place: *place,
            scale: 1.0,
            light: 0,
            has_sources: has_sources(grid),
            moved_m: most_moved_m(grid),
        });
        Self::new(gpu, grids, [0, 0], placed.collect())
    }

    /// Puts them into the uniform of a view's environment, whose radiance is pre-exposed.
    pub fn place(&self, uniform: &mut EnvironmentUniform, pre_exposure: f32) {
        uniform.probes = self.uniforms;
        for of in &mut uniform.probes {
            of.spacing.w *= pre_exposure;
        }
    }

    /// What pipelines know of them, and of the device.
    pub fn constants(&self) -> impl Iterator<Item = Constant> + use<> {
        let have_sources = self.grids.iter().any(|grid| grid.has_sources);
        let filters_exactly = !self.grids.is_empty() && self.filters_exactly;
        let constants = [
            (PROBE_GRIDS, self.grids.len() as u32),
            (PROBE_SOURCES, u32::from(have_sources)),
            (FILTERS_EXACTLY, u32::from(filters_exactly)),
        ];
        constants.into_iter().filter(|(_, value)| *value > 0)
    }
}

/// Where a probe is, and by how much it was moved, as the light that was found beforehand has it; none if it is off.
pub(super) fn place_of(grid: &ProbeGrid, probe: usize) -> Option<(Vec3, Vec3)> {
    let known = grid.probes.as_ref().and_then(|probes| probes.get(probe));
    let offset_m = known.map_or(Vec3::ZERO, |known| known.offset_m);
    known.is_none_or(|known| known.is_on).then(|| (grid.place(probe) + offset_m, offset_m))
}

/// The probe that frames look around as the one of a number, so that those which follow each other lie apart.
fn in_turn(done: usize, count: usize) -> usize {
    let divides = |a: usize, b: usize| {
        let (mut a, mut b) = (a, b);
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a > 1
    };
    let mut stride = (count as f64 * 0.618).round().max(1.0) as usize;
    while divides(stride, count) {
        stride += 1;
    }
    done % count * stride % count
}

impl UploadedGrid {
    fn placed(&self, place: &GridPlace) -> PlacedGrid {
        let Self { scale, light, has_sources, moved_m, .. } = *self;
        PlacedGrid { place: *place, scale, light, has_sources, moved_m }
    }

    fn is_of(&self, grid: &ProbeGrid) -> bool {
        let has_same = match (&self.probes, &grid.probes) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        };
        let has_same_places = self.region == grid.region && self.counts == grid.counts && self.basis == grid.basis;
        has_same && has_same_places && self.live == grid.live
    }
}

impl ProbeTexels {
    fn are_of(&self, grids: &[&ProbeGrid]) -> bool {
        self.written.len() == grids.len().min(self.layout.places.len())
            && self.written.iter().zip(grids).all(|(written, grid)| written.is_of(grid))
    }

    /// Whether the texels of `grids` are there, where `layout` says.
    pub fn hold(&self, layout: &ProbeLayout, grids: &[&ProbeGrid]) -> bool {
        self.are_of(grids) && self.layout == *layout
    }

    /// Of live grids those probes that a frame of a live view looks around, at most so many; all become due where `is_new`
    /// says that light is another one.
    pub fn due(&mut self, grids: &[&ProbeGrid], is_new: bool, most: usize, pre_exposure: f32) -> Vec<DueProbe> {
        // What is not there yet is written by the frame.
        if !self.are_of(grids) {
            return Vec::new();
        }
        let mut due = Vec::new();
        let grids = &grids[..self.written.len()];
        let is_kept = |written: &UploadedGrid| {
            let ratio = written.scale * pre_exposure;
            written.live.is_none() || (EXPOSURE_RATIO_MAX.recip()..EXPOSURE_RATIO_MAX).contains(&ratio)
        };
        if !self.written.iter().all(is_kept) {
            self.written.clear();
            return due;
        }
        for (written, grid) in self.written.iter_mut().zip(grids) {
            if let (true, Some(live)) = (is_new, written.live) {
                written.left = grid.count() * live.bounces.max(1) as usize;
            }
        }
        let mut passed = 0;
        while due.len() < most && passed < self.written.len() {
            let at = self.turn % self.written.len();
            self.turn += 1;
            let (written, grid) = (&mut self.written[at], grids[at]);
            passed += 1;
            while written.left > 0 {
                let probe = in_turn(written.done, grid.count());
                written.done += 1;
                written.left -= 1;
                if place_of(grid, probe).is_some() {
                    self.is_of_still = false;
                    due.push(DueProbe { grid: at, probe });
                    passed = 0;
                    break;
                }
            }
        }
        due
    }

    /// Whether a still has found all that frames are to find of light, and as it is exposed now, if that is given, but for what
    /// half floats do not feel.
    pub fn is_found(&self, grids: &[&ProbeGrid], pre_exposure: Option<f32>) -> bool {
        let is_near = |written: &UploadedGrid| {
            let is_near = |pre: f32| (STILL_RATIO_MAX.recip()..STILL_RATIO_MAX).contains(&(written.scale * pre));
            written.live.is_none() || pre_exposure.is_none_or(is_near)
        };
        let is_found = |written: &UploadedGrid| written.left == 0 && is_near(written);
        self.is_of_still && self.are_of(grids) && self.written.iter().all(is_found)
    }

    /// Whether a grid is on the device, by its index among the known ones.
    pub fn has(&self, grid: usize) -> bool {
        grid < self.written.len()
    }

    /// Whether frames of a live view have yet to look around probes.
    pub fn is_finding(&self) -> bool {
        self.written.iter().any(|written| written.left > 0)
    }

    /// Of a grid among the known ones where its texels lie, and what is known of them; none where it is not on the device.
    pub fn placed(&self, grids: &[&ProbeGrid], at: usize) -> Option<PlacedGrid> {
        let (written, place) = (self.written.get(at)?, self.layout.places.get(at)?);
        let is_there = grids.get(at).is_some_and(|grid| written.is_of(grid));
        is_there.then(|| written.placed(place))
    }

    /// Begins anew: light is that which the grids bring.
    pub fn forget(&mut self) {
        self.written.clear();
    }

    /// From now on frames read what they have found apart.
    pub fn swap(&mut self, grid: usize) {
        if let Some(written) = self.written.get_mut(grid) {
            written.light = 1 - written.light.min(1);
        }
    }

    /// A still has found all that frames are to find of light.
    pub fn finish(&mut self) {
        self.is_of_still = true;
        self.written.iter_mut().for_each(|written| written.left = 0);
    }

    /// Writes what is new of the texels of grids behind a corner of a texture. The light of live ones is divided by
    /// the inverse of `pre_exposure`.
    pub fn write(
        &mut self,
        gpu: &Gpu,
        (texture, corner): (&wgpu::Texture, [u32; 2]),
        layout: &ProbeLayout,
        grids: &[&ProbeGrid],
        pre_exposure: f32,
    ) -> PlacedProbes {
        if !self.hold(layout, grids) {
            self.written.clear();
            self.is_of_still = false;
            self.layout = layout.clone();
            let of_live = pre_exposure.recip();
            let of_live = if of_live.is_finite() && of_live > 0.0 { of_live } else { 1.0 };
            for (grid, place) in grids.iter().zip(&layout.places) {
                let scale = grid.live.map(|_| of_live);
                let texels = match &grid.probes {
                    Some(probes) => grid_texels(grid, place, probes, scale),
                    None => grid_texels(grid, place, &unlit(grid), scale),
                };
                let (width, height, light) = &texels.light;
                let lights = if grid.live.is_some() { &place.light[..] } else { &place.light[..1] };
                for [x, y] in lights {
                    write_texels(gpu, (texture, [corner[0] + x, corner[1] + y]), (*width, *height), light);
                }
                let (width, height, distances) = &texels.distances;
                let [x, y] = place.distances;
                write_texels(gpu, (texture, [corner[0] + x, corner[1] + y]), (*width, *height), distances);
                let bounces = grid.live.map_or(0, |live| live.bounces.max(1) as usize);
                self.written.push(UploadedGrid {
                    region: grid.region,
                    counts: grid.counts,
                    basis: grid.basis,
                    probes: grid.probes.clone(),
                    live: grid.live,
                    scale: texels.scale,
                    has_sources: has_sources(grid),
                    moved_m: most_moved_m(grid),
                    light: 0,
                    done: 0,
                    left: grid.count() * bounces,
                });
            }
        }
        let placed = self.written.iter().zip(&layout.places).map(|(written, place)| written.placed(place));
        PlacedProbes::new(gpu, grids, corner, placed.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::in_turn;
    use std::collections::BTreeSet;

    #[test]
    fn every_probe_has_its_turn() {
        for count in [1, 2, 3, 7, 12, 64, 100, 4096, 2584] {
            let all: BTreeSet<usize> = (0..count).map(|done| in_turn(done, count)).collect();
            assert_eq!(all.len(), count);
        }
    }
}
