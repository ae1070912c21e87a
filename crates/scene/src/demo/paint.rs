//! What demos paint surfaces with: noise that repeats, and square images of colours and of normals.

use crate::chance::unit;
use crate::{Image, ImageSource, PixelFormat, Pixels, Sampler, Scene, Texture, TextureRef, TextureTransform, Wrap};
use glam::{UVec2, Vec2, Vec3};

/// Smooth noise from 0 to 1 through another number at every corner (Perlin 1985, "value noise"); it repeats after `period`
/// corners.
pub(super) fn noise(at: Vec2, period: UVec2) -> f32 {
    let cell = at.floor();
    let share = at - cell;
    let share = share * share * (3.0 - 2.0 * share);
    let first = cell.rem_euclid(period.as_vec2()).as_uvec2();
    let next = UVec2::new((first.x + 1) % period.x, (first.y + 1) % period.y);
    let row = |y: u32| unit(first.x, y) + (unit(next.x, y) - unit(first.x, y)) * share.x;
    row(first.y) + (row(next.y) - row(first.y)) * share.y
}

/// Octaves of noise from −1 to 1, each half as strong and as long as the one before; at UVs, which it repeats after, the first
/// has `period` corners.
pub(super) fn cloud(uv: Vec2, period: UVec2, octaves: u8) -> f32 {
    let octave = |i: u8| {
        let corners = period * (1u32 << i);
        (noise(uv * corners.as_vec2(), corners) - 0.5) * 0.5f32.powi(i.into())
    };
    (0..octaves).map(octave).sum()
}

/// Ridges from 0 to 1, in so many octaves: as [`cloud`], with creases where noise is in the middle (Musgrave 1994).
pub(super) fn ridges(uv: Vec2, period: UVec2, octaves: u8) -> f32 {
    let octave = |i: u8| {
        let corners = period * (1u32 << i);
        let crease = 1.0 - (2.0 * noise(uv * corners.as_vec2(), corners) - 1.0).abs();
        crease * crease * 0.5f32.powi(i32::from(i) + 1)
    };
    (0..octaves).map(octave).sum()
}

/// From 0 to 1, smooth at both ends.
pub(super) fn step(from: f32, to: f32, at: f32) -> f32 {
    let t = ((at - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// An image of `side` texels, whose channels from 0 to 1 are what `value` gives at UVs.
pub(super) fn image(scene: &mut Scene, name: &str, side: u16, wrap: Wrap, value: impl Fn(Vec2) -> Vec3) -> TextureRef {
    let mut data = Vec::with_capacity(4 * usize::from(side) * usize::from(side));
    for y in 0..side {
        for x in 0..side {
            let uv = (Vec2::new(f32::from(x), f32::from(y)) + 0.5) / f32::from(side);
            let texel = (value(uv).clamp(Vec3::ZERO, Vec3::ONE) * 255.0).round();
            data.extend([texel.x as u8, texel.y as u8, texel.z as u8, 255]);
        }
    }
    let (width, height) = (u32::from(side), u32::from(side));
    let pixels = Pixels { width, height, format: PixelFormat::Rgba8, data };
    scene.images.push(Image { name: name.into(), source: ImageSource::Pixels(pixels.into()) });
    let sampler = Sampler { wrap_u: wrap, wrap_v: wrap, ..Sampler::default() };
    scene.textures.push(Texture { image: scene.images.len() - 1, sampler });
    TextureRef { texture: scene.textures.len() - 1, uv_set: 0, transform: TextureTransform::default() }
}

/// An image of colours: `albedo` is linear.
pub(super) fn colors(scene: &mut Scene, name: &str, side: u16, albedo: impl Fn(Vec2) -> Vec3) -> TextureRef {
    image(scene, name, side, Wrap::Repeat, |uv| albedo(uv).max(Vec3::ZERO).map(|linear| linear.powf(1.0 / 2.2)))
}

/// The normals of heights: `height_m` gives them at UVs of a tile of `tile_m` metres a side.
pub(super) fn normals(
    scene: &mut Scene,
    name: &str,
    side: u16,
    tile_m: f32,
    height_m: impl Fn(Vec2) -> f32,
) -> TextureRef {
    let share = 1.0 / f32::from(side);
    let at = |x: u16, y: u16| height_m((Vec2::new(f32::from(x), f32::from(y)) + 0.5) * share);
    let heights: Vec<f32> = (0..side).flat_map(|y| (0..side).map(move |x| (x, y))).map(|(x, y)| at(x, y)).collect();
    let height = |x: u16, y: u16| heights[usize::from(y % side) * usize::from(side) + usize::from(x % side)];
    let per_m = 0.5 * f32::from(side) / tile_m;
    image(scene, name, side, Wrap::Repeat, |uv| {
        let (x, y) = ((uv.x * f32::from(side)) as u16, (uv.y * f32::from(side)) as u16);
        let (left, right) = (height(x + side - 1, y), height(x + 1, y));
        let (above, below) = (height(x, y + side - 1), height(x, y + 1));
        // V points down, and Y of normals up.
        0.5 * Vec3::new((left - right) * per_m, (below - above) * per_m, 1.0).normalize() + 0.5
    })
}

/// The same texture, so many times over the UV square.
pub(super) fn tiled(texture: TextureRef, times: Vec2) -> TextureRef {
    TextureRef { transform: TextureTransform { scale: times, ..TextureTransform::default() }, ..texture }
}

/// Four square slabs of stone in a tile of 2 m: their colours, around 0.8, and their normals.
pub(super) fn slabs(scene: &mut Scene) -> [TextureRef; 2] {
    // Metres from the nearest joint, and a number of the slab.
    let slab = |uv: Vec2| {
        let at = 2.0 * uv;
        let (cell, share) = (at.floor(), at - at.floor());
        (share.min(1.0 - share).min_element(), unit(cell.x as u32, cell.y as u32 + 7))
    };
    let color = colors(scene, "slabs", 256, |uv| {
        let (to_joint_m, tone) = slab(uv);
        let stain = 1.0 + 0.35 * cloud(uv, UVec2::splat(4), 6);
        Vec3::splat((0.72 + 0.16 * tone) * stain * (0.55 + 0.45 * step(0.004, 0.014, to_joint_m)))
    });
    let relief = normals(scene, "slabs relief", 256, 2.0, |uv| {
        0.008 * step(0.0, 0.02, slab(uv).0) + 0.01 * cloud(uv, UVec2::splat(6), 5)
    });
    [color, relief]
}

/// Plaster, as [`slabs`].
pub(super) fn plaster(scene: &mut Scene) -> [TextureRef; 2] {
    let color = colors(scene, "plaster", 256, |uv| Vec3::splat(0.8 * (1.0 + 0.22 * cloud(uv, UVec2::splat(3), 6))));
    let relief = normals(scene, "plaster relief", 256, 2.0, |uv| 0.004 * cloud(uv, UVec2::splat(8), 5));
    [color, relief]
}

/// Covers a material with colours and normals, so many times over the UV square.
pub(super) fn cover(scene: &mut Scene, material: usize, [color, relief]: [TextureRef; 2], times: Vec2) {
    let material = &mut scene.materials[material];
    material.base_color_texture = Some(tiled(color, times));
    material.normal_texture = Some(tiled(relief, times));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_repeats_and_normals_of_a_slope_lean_down_it() {
        let period = UVec2::new(5, 3);
        for at in [Vec2::new(0.3, 0.7), Vec2::new(4.9, 2.2)] {
            assert!((noise(at, period) - noise(at + Vec2::new(5.0, -3.0), period)).abs() < 1e-4);
            assert!((cloud(at, period, 4) - cloud(at + 1.0, period, 4)).abs() < 1e-3);
        }
        // Rises to the right and downwards, so that it leans to the left and upwards.
        let mut scene = Scene::default();
        normals(&mut scene, "slope", 16, 1.0, |uv| 0.5 * uv.x + 0.25 * uv.y);
        let ImageSource::Pixels(pixels) = &scene.images[0].source else { panic!("pixels") };
        let texel = &pixels.data[4 * (8 * 16 + 8)..][..3];
        let normal = Vec3::new(-0.5, 0.25, 1.0).normalize();
        for (found, expected) in texel.iter().zip(normal.to_array()) {
            assert!((f32::from(*found) / 127.5 - 1.0 - expected).abs() < 0.01, "{texel:?}");
        }
    }
}
