//! Probes from their texels: what frames have found.

use super::DISTANCE_MAX_M;
use crate::constants::{PROBE_DISTANCE_SIDE, PROBE_HEIGHT};
use glam::{Vec2, Vec3, Vec4};
use manypass_scene::probes::{AmbientCube, Harmonics, Probe, ProbeBasis, ProbeGrid, ProbeLight, SmallSource};
use std::f32::consts::PI;

/// The probe of a grid whose texels `texel` gives by column and row: those of its light from `light` on, multiplied by
/// `scale`, and the map of its distances with its border from `distances` on. The twin of [`super::grid_texels`].
pub(crate) fn read_probe(
    grid: &ProbeGrid,
    [light, distances]: [[u32; 2]; 2],
    scale: f32,
    texel: impl Fn(u32, u32) -> Vec4,
) -> Probe {
    let at = |x: u32, y: u32| texel(light[0] + x, light[1] + y);
    let color = |x: u32, y: u32| at(x, y).truncate() * scale;
    let (place, of_source) = (at(0, PROBE_HEIGHT - 1), at(1, PROBE_HEIGHT - 1));
    let found = match grid.basis {
        // Of the blocks of x and y the first has both above 0, the last none.
        ProbeBasis::AmbientCube => ProbeLight::AmbientCube(AmbientCube([
            color(0, 0),
            color(6, 0),
            color(1, 1),
            color(7, 1),
            color(8, 0),
            color(10, 0),
        ])),
        ProbeBasis::Harmonics => {
            // Of each kind the block in which all signs are above 0.
            let (difference, half_xy) = (color(0, 0), color(1, 0));
            let (squares, half_z, constant) = (color(8, 0) / 3.0, color(9, 0), color(9, 1));
            let (half_xz, half_x, half_yz, half_y) = (color(12, 0), color(13, 0), color(12, 1), color(13, 1));
            let halves = [half_y, half_z, half_x, half_xy, half_yz].map(|half| 2.0 * half);
            let [y, z, x, xy, yz] = halves;
            let polynomial = [constant + squares, y, z, x, xy, yz, squares, 2.0 * half_xz, difference];
            let irradiance = PI * Vec3::new(at(0, 0).w, at(8, 0).w, at(12, 0).w) * scale;
            let source = SmallSource { direction: of_source.truncate(), irradiance, spread: of_source.w };
            let source = if irradiance == Vec3::ZERO { SmallSource::default() } else { source };
            ProbeLight::Harmonics(Harmonics::of_irradiance_polynomial(&polynomial), source)
        }
    };
    let distance = |at: u32| {
        let (x, y) = (at % PROBE_DISTANCE_SIDE, at / PROBE_DISTANCE_SIDE);
        let found = texel(distances[0] + 1 + x, distances[1] + 1 + y);
        let (mean, deviation) = (found.x.min(DISTANCE_MAX_M), found.y);
        Vec2::new(mean, mean * mean + deviation * deviation)
    };
    Probe {
        offset_m: place.truncate(),
        is_on: place.w > 0.5,
        light: found,
        distances: std::array::from_fn(|at| distance(at as u32)),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{ProbeLayout, grid_texels};
    use super::*;
    use manypass_scene::surroundings::Region;

    #[test]
    fn probes_come_back_from_their_texels() {
        let region = Region { center_world: Vec3::ZERO, half_m: Vec3::ONE };
        let mut light = Harmonics::default();
        light.add(Vec3::new(0.6, 0.0, 0.8), Vec3::new(3.0, 2.0, 1.0));
        light.add(Vec3::NEG_Y, Vec3::new(0.0, 1.0, 4.0));
        let direction = Vec3::new(-0.48, 0.6, -0.64);
        let source = SmallSource { direction, irradiance: Vec3::new(5.0, 6.0, 7.0), spread: 0.25 };
        for basis in [ProbeBasis::Harmonics, ProbeBasis::AmbientCube] {
            let grid = ProbeGrid { basis, ..ProbeGrid::new("grid", region, [3, 2, 5]).expect("a grid") };
            let mut probes = vec![Probe::default(); grid.count()];
            let distances = std::array::from_fn(|at| Vec2::new(at as f32, (at * at + 4) as f32));
            let known = ProbeLight::new(&light, source, basis);
            let offset_m = Vec3::new(0.25, -0.125, 0.5);
            probes[23] = Probe { offset_m, is_on: true, light: known, distances };
            let layout = ProbeLayout::new(&[&grid]);
            let place = layout.places[0];
            let texels = grid_texels(&grid, &place, &probes, None);
            let read = |index: usize| {
                read_probe(&grid, place.of_probe(&grid, index, 0), texels.scale, |x, y| {
                    let ((width, _, of), top) = match y >= place.light[0][1] {
                        true => (&texels.light, place.light[0][1]),
                        false => (&texels.distances, place.distances[1]),
                    };
                    Vec4::from(of[((y - top) * width + x) as usize].map(f32::from))
                })
            };
            assert!(!read(22).is_on);
            let found = read(23);
            assert!(found.is_on && found.offset_m == offset_m);
            for normal in [Vec3::X, Vec3::NEG_Y, direction, -direction] {
                let (found, known) = (found.light.irradiance(normal), known.irradiance(normal));
                assert!((found - known).abs().max_element() < 0.01, "{basis:?} {normal}: {found} is not {known}");
            }
            for (found, known) in found.distances.iter().zip(&distances) {
                assert!((*found - *known).abs().max_element() <= 2e-3 * known.max_element(), "{found} {known}");
            }
        }
    }
}
