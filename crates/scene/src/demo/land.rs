//! The land around the lake of the shore: sand with ripples that is wet at the water, and hills with ridges.

use super::builder::Demo;
use super::paint::{cloud, colors, image, normals, ridges, step, tiled};
use crate::{Mesh, Primitive, TextureRef, Wrap};
use glam::{UVec2, Vec2, Vec3};

/// Half the side of the land in metres, and the squares of a side.
const HALF_M: f32 = 48.0;
const SQUARES: u16 = 224;
/// The sides of what sand and hills repeat, in metres.
const SAND_M: f32 = 2.6;
const HILL_M: f32 = 9.0;
/// The least x and z of where sand can be wet, and the extent of that, in metres; beyond it all sand is dry.
const WET_FROM: Vec2 = Vec2::new(-12.0, -5.0);
const WET_M: Vec2 = Vec2::new(24.0, 12.0);
/// What textures leave of the colours of vertices in the mean.
const MEAN: f32 = 0.7;
/// The middle of the basin.
pub(super) const BASIN: Vec3 = Vec3::new(3.75, 0.0, 2.1);
/// Higher triangles are hills.
const HILLS_FROM_M: f32 = 1.0;

/// From 0 to 1, another number for every pair of whole ones.
pub(super) fn chance(x: f32, z: f32) -> f32 {
    let bits = (x as i32 as u32).wrapping_mul(0x8da6_b343) ^ (z as i32 as u32).wrapping_mul(0xd816_3841);
    let bits = (bits ^ bits >> 15).wrapping_mul(0x2c1b_3c6d);
    let bits = (bits ^ bits >> 12).wrapping_mul(0x297a_2d39);
    (bits >> 8) as f32 / 16_777_216.0
}

/// A smooth surface through chance numbers.
fn noise(at: Vec2) -> f32 {
    let cell = at.floor();
    let f = at - cell;
    let s = f * f * (3.0 - 2.0 * f);
    let corner = |x: f32, z: f32| chance(cell.x + x, cell.y + z);
    let row = |z: f32| corner(0.0, z) + (corner(1.0, z) - corner(0.0, z)) * s.x;
    row(0.0) + (row(1.0) - row(0.0)) * s.y
}

/// Several octaves of it, from −1 to 1.
pub(super) fn rough(at: Vec2) -> f32 {
    let octave = |i: u8| (noise(at * f32::from(1u8 << i) + 17.3 * f32::from(i)) - 0.5) * 0.5f32.powi(i.into());
    (0..5).map(octave).sum()
}

/// Ridges of three octaves, from 0 to 1.
fn ridged(at: Vec2) -> f32 {
    let octave = |i: u8| {
        let crease = 1.0 - (2.0 * noise(at * f32::from(1u8 << i) + 9.1 * f32::from(i)) - 1.0).abs();
        crease * crease * 0.5f32.powi(i32::from(i) + 1)
    };
    (0..3).map(octave).sum()
}

/// The height of the ground.
pub(super) fn height_m(x: f32, z: f32) -> f32 {
    let at = Vec2::new(x, z);
    // The bay: an ellipse about (0, −14), by how far a place is from its edge.
    let bay = Vec2::new(x / 26.0, (z + 13.0) / 15.0).length() + 0.16 * rough(at * 0.11);
    let ground = -4.0 + 4.3 * step(0.35, 1.04, bay) + 0.9 * step(1.0, 1.5, bay);
    let relief = 13.0 * (0.55 + rough(at * 0.05 + 3.0)) + 7.0 * (ridged(at * 0.09 + 5.0) - 0.35);
    let hills = step(1.35, 2.3, bay) * relief.max(0.0) * step(10.0, -16.0, z);
    let fine = 0.05 * rough(at * 0.9);
    // Flat where the basin stands.
    let away = Vec2::new(x - BASIN.x, z - BASIN.z).length();
    let flat = step(3.2, 2.0, away);
    (ground + hills + fine) * (1.0 - flat) + 0.33 * flat
}

/// Adds the land to the scene.
pub(super) fn add(shore: &mut Demo) {
    let sand = sand(shore);
    let hills = hills(shore);
    let [sand, hills] = parts(&vertices())
        .map(|(part, is_hill)| Primitive { material: Some(if is_hill { hills } else { sand }), ..part });
    let mesh = Mesh { name: "Land".into(), primitives: vec![sand, hills], ..Mesh::default() };
    shore.scene.meshes.push(mesh.into());
    shore.put(shore.scene.meshes.len() - 1, Vec3::ZERO, Vec3::ONE);
}

/// Where vertices lie: twice as close in the middle, where the camera stands, as in the mean.
fn place_m(i: u16) -> f32 {
    let at = 2.0 * f32::from(i) / f32::from(SQUARES) - 1.0;
    HALF_M * (0.5 * at + 0.5 * at * at * at)
}

/// The vertices of all of the land, row by row.
fn vertices() -> Primitive {
    let mut land = Primitive::default();
    let side = SQUARES + 1;
    let all = (0..side).flat_map(|j| (0..side).map(move |i| Vec2::new(place_m(i), place_m(j))));
    let heights: Vec<f32> = all.map(|at| height_m(at.x, at.y)).collect();
    let height = |i: u16, j: u16| heights[usize::from(j) * usize::from(side) + usize::from(i)];
    let beside = |i: u16| (i.saturating_sub(1), (i + 1).min(SQUARES));
    for j in 0..side {
        for i in 0..side {
            let (x, y, z) = (place_m(i), height(i, j), place_m(j));
            let ((left, right), (back, front)) = (beside(i), beside(j));
            let slope_x = (height(right, j) - height(left, j)) / (place_m(right) - place_m(left));
            let slope_z = (height(i, front) - height(i, back)) / (place_m(front) - place_m(back));
            let normal = Vec3::new(-slope_x, 1.0, -slope_z).normalize();
            land.positions.push([x, y, z]);
            land.normals.push(normal.to_array());
            land.tangents.push(Vec3::new(1.0, slope_x, 0.0).normalize().extend(1.0).to_array());
            land.uv0.push([x, z]);
            land.uv1.push(((Vec2::new(x, z) - WET_FROM) / WET_M).to_array());
            land.colors.push((color(Vec3::new(x, y, z), normal.y) / MEAN).extend(1.0).to_array());
        }
    }
    land
}

/// The colour of a place, by how steep it is: `up` is the height of its normal.
fn color(at: Vec3, up: f32) -> Vec3 {
    let place = Vec2::new(at.x, at.z);
    let dapple = rough(place * 0.7);
    // Patches of a few metres: pale dry sand, and lush and withered grass.
    let patch = step(-0.35, 0.35, rough(place * 0.16 + 31.0));
    let sand = Vec3::new(0.4, 0.31, 0.2).lerp(Vec3::new(0.56, 0.47, 0.34), patch) * (1.0 + 0.35 * dapple);
    let wet = sand * Vec3::new(0.42, 0.4, 0.4);
    let grass = Vec3::new(0.05, 0.09, 0.022).lerp(Vec3::new(0.15, 0.15, 0.055), patch) * (1.0 + 0.8 * dapple);
    let stone = Vec3::new(0.22, 0.205, 0.185) * (1.0 + 0.5 * rough(Vec2::new(place.x + place.y, 3.0 * at.y) * 0.5));
    let shore = wet.lerp(sand, step(0.13, 0.25, at.y + 0.05 * dapple));
    let dry = shore.lerp(grass, step(0.5, 0.95, at.y + 0.5 * dapple));
    dry.lerp(stone, step(0.84, 0.7, up + 0.12 * dapple))
}

/// Sand, and what is higher, as a part of its own; of each whether it is the hills.
fn parts(land: &Primitive) -> [(Primitive, bool); 2] {
    let side = u32::from(SQUARES) + 1;
    [false, true].map(|is_hill| {
        let mut part = Primitive::default();
        let mut known = vec![u32::MAX; land.positions.len()];
        for j in 0..u32::from(SQUARES) {
            for i in 0..u32::from(SQUARES) {
                let a = j * side + i;
                let (b, c) = (a + 1, a + side);
                for triangle in [[a, c, b], [b, c, c + 1]] {
                    let highest = triangle.iter().map(|v| land.positions[*v as usize][1]).fold(f32::MIN, f32::max);
                    if (highest > HILLS_FROM_M) == is_hill {
                        let indices = triangle.map(|vertex| copied(land, vertex as usize, &mut part, &mut known));
                        part.indices.extend(indices);
                    }
                }
            }
        }
        part.bounds = crate::Aabb::from_points(part.positions.iter().copied().map(Vec3::from));
        (part, is_hill)
    })
}

/// The index of a vertex in a part, to which it is added if it is not `known` there.
fn copied(land: &Primitive, vertex: usize, part: &mut Primitive, known: &mut [u32]) -> u32 {
    if known[vertex] == u32::MAX {
        known[vertex] = part.positions.len() as u32;
        part.positions.push(land.positions[vertex]);
        part.normals.push(land.normals[vertex]);
        part.tangents.push(land.tangents[vertex]);
        part.uv0.push(land.uv0[vertex]);
        part.uv1.push(land.uv1[vertex]);
        part.colors.push(land.colors[vertex]);
    }
    known[vertex]
}

/// Ripples that the wind made, lumps and grains, in metres.
fn sand_m(uv: Vec2) -> f32 {
    let bent = 1.5 * cloud(uv, UVec2::splat(3), 3);
    let wave = std::f32::consts::TAU * (24.0 * uv.y + bent);
    // Steeper on one side.
    let ripple = (wave + 0.5 * wave.sin()).cos();
    let is_there = step(-0.2, 0.25, cloud(uv + 0.37, UVec2::splat(2), 3));
    0.0042 * ripple * is_there + 0.03 * cloud(uv, UVec2::splat(5), 3) + 0.0016 * cloud(uv, UVec2::splat(96), 2)
}

fn sand(shore: &mut Demo) -> usize {
    let times = Vec2::splat(1.0 / SAND_M);
    let scene = &mut shore.scene;
    let relief = normals(scene, "sand relief", 512, SAND_M, sand_m);
    let grains = colors(scene, "sand", 512, |uv| {
        let grain = cloud(uv, UVec2::splat(128), 2);
        let patch = cloud(uv, UVec2::splat(4), 4);
        // Shells, bits of wood, and pebbles, a centimetre long.
        let bits = cloud(uv + 0.61, UVec2::splat(110), 1);
        let tint = Vec3::splat(MEAN * (1.0 + 0.35 * grain + 0.25 * patch));
        tint.lerp(Vec3::new(0.22, 0.2, 0.19), step(0.44, 0.48, bits)).lerp(Vec3::ONE, step(-0.455, -0.485, bits))
    });
    let wet = image(scene, "sand wetness", 128, Wrap::ClampToEdge, |uv| {
        let at = WET_FROM + uv * WET_M;
        let is_inside = uv.min(1.0 - uv).min_element() > 0.01;
        let dry = step(0.1, 0.23, height_m(at.x, at.y) + 0.05 * rough(at * 0.7));
        Vec3::new(1.0, if is_inside { 0.3 + 0.65 * dry } else { 0.95 }, 0.0)
    });
    let sand = shore.material("Sand", [1.0; 3], 0.0, 1.0);
    let material = &mut shore.scene.materials[sand];
    material.normal_texture = Some(tiled(relief, times));
    material.base_color_texture = Some(tiled(grains, times));
    material.metallic_roughness_texture = Some(TextureRef { uv_set: 1, ..wet });
    sand
}

fn hills(shore: &mut Demo) -> usize {
    let times = Vec2::splat(1.0 / HILL_M);
    let scene = &mut shore.scene;
    let height_m = |uv: Vec2| 1.1 * ridges(uv, UVec2::splat(4), 5) + 0.5 * cloud(uv, UVec2::splat(9), 4);
    let relief = normals(scene, "hills relief", 256, HILL_M, height_m);
    let cover = colors(scene, "hills", 256, |uv| {
        let patch = cloud(uv, UVec2::splat(5), 6);
        let bush = step(0.12, 0.3, cloud(uv + 0.29, UVec2::splat(18), 3));
        Vec3::splat(MEAN * (1.0 + 0.7 * patch)) * Vec3::ONE.lerp(Vec3::new(0.5, 0.62, 0.5), bush)
    });
    let hills = shore.material("Hills", [1.0; 3], 0.0, 0.95);
    let material = &mut shore.scene.materials[hills];
    material.normal_texture = Some(tiled(relief, times));
    material.base_color_texture = Some(tiled(cover, times));
    hills
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bay_is_closed_and_deep_enough_for_a_lake() {
        assert!(height_m(0.0, -13.0) < -3.5 && height_m(0.0, 4.0) > 0.2);
        // Along the edges of the lake's plane the ground is above it.
        for step in -10..=10i8 {
            let share = f32::from(step) / 10.0;
            for (x, z) in [
                (31.0 * share, -36.0),
                (31.0 * share, 8.0),
                (-31.0, -14.0 + 22.0 * share),
                (31.0, -14.0 + 22.0 * share),
            ] {
                assert!(height_m(x, z) > 0.0, "{x} {z}: {}", height_m(x, z));
            }
        }
    }

    #[test]
    fn sand_and_hills_are_all_of_the_land_and_differ_in_relief() {
        let mut shore = Demo::default();
        add(&mut shore);
        let parts = &shore.scene.meshes[0].primitives;
        let triangles: usize = parts.iter().map(|part| part.indices.len() / 3).sum();
        assert_eq!(triangles, 2 * usize::from(SQUARES) * usize::from(SQUARES));
        for part in parts {
            assert!(part.indices.iter().all(|index| (*index as usize) < part.positions.len()));
            assert!(part.uv1.len() == part.positions.len() && part.tangents.len() == part.positions.len());
            assert!(shore.scene.materials[part.material.unwrap_or_default()].normal_texture.is_some());
        }
        // Hills are steep and flat within a few metres.
        let slope = |x: f32| (height_m(x + 0.5, -42.0) - height_m(x - 0.5, -42.0)).abs();
        let slopes = (-24..=24i8).map(|x| slope(f32::from(x)));
        assert!(slopes.clone().fold(0.0, f32::max) > 0.6 && slopes.fold(f32::MAX, f32::min) < 0.1);
    }
}
