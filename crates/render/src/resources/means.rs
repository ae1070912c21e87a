//! What a primitive shows of textures on the whole: the means of their texels over its surface.

use crate::colour::linear_from_srgb;
use glam::{Vec2, Vec3, Vec4};
use manypass_scene::{Pixels, Primitive, Sampler, Topology, Wrap};

/// So many points a primitive are looked up at least, and so many triangles at most.
const POINTS_MIN: usize = 1024;
const TRIANGLES_MAX: usize = 4096;

/// A texture on a surface.
pub(super) struct SurfaceTexture<'t> {
    /// A small mip of it.
    pub texels: &'t Pixels,
    pub is_srgb: bool,
    pub sampler: Sampler,
    /// As of `MaterialFactors::uv_rows`.
    pub rows: [Vec4; 2],
}

impl SurfaceTexture<'_> {
    /// The linear texel at UVs of the surface.
    fn texel(&self, uvs: [Vec2; 2]) -> Vec4 {
        let [row0, row1] = self.rows;
        let source = uvs[usize::from(row0.w > 0.5)].extend(1.0);
        let uv = Vec2::new(row0.truncate().dot(source), row1.truncate().dot(source));
        let Pixels { width, height, data, .. } = self.texels;
        let x = texel_of(uv.x, *width, self.sampler.wrap_u);
        let y = texel_of(uv.y, *height, self.sampler.wrap_v);
        let at = (y * width + x) as usize * 4;
        let Some(&[r, g, b, a]) = data.get(at..).and_then(|texels| texels.first_chunk()) else { return Vec4::ONE };
        let [r, g, b, a] = [r, g, b, a].map(|byte| f32::from(byte) / 255.0);
        if self.is_srgb { Vec3::new(r, g, b).map(linear_from_srgb).extend(a) } else { Vec4::new(r, g, b, a) }
    }
}

/// The texel that a coordinate lies in.
fn texel_of(coordinate: f32, size: u32, wrap: Wrap) -> u32 {
    let wrapped = match wrap {
        Wrap::Repeat => coordinate.rem_euclid(1.0),
        Wrap::MirroredRepeat => 1.0 - (coordinate.rem_euclid(2.0) - 1.0).abs(),
        Wrap::ClampToEdge => coordinate,
    };
    // What is no number becomes 0.
    ((wrapped * size as f32) as u32).min(size.saturating_sub(1))
}

/// The means of linear texels over the surface of a primitive's triangles, and their area in m²; white is what is not
/// there. None of points and lines, and where there is no area.
pub(super) fn means<const N: usize>(
    primitive: &Primitive,
    textures: &[Option<SurfaceTexture<'_>>; N],
) -> Option<([Vec4; N], f32)> {
    if primitive.topology != Topology::Triangles {
        return None;
    }
    let count = if primitive.indices.is_empty() { primitive.positions.len() } else { primitive.indices.len() } / 3;
    let points = POINTS_MIN.div_ceil(count.max(1));
    let corner =
        |at: usize| if primitive.indices.is_empty() { Some(at) } else { Some(*primitive.indices.get(at)? as usize) };
    let (mut sums, mut area) = ([Vec4::ZERO; N], 0.0f32);
    for triangle in (0..count).step_by(count.div_ceil(TRIANGLES_MAX).max(1)) {
        let corners = [0, 1, 2].map(|i| corner(3 * triangle + i).unwrap_or(usize::MAX));
        let [a, b, c] = corners.map(|at| primitive.positions.get(at).copied().map(Vec3::from));
        let (Some(a), Some(b), Some(c)) = (a, b, c) else { continue };
        let twice = (b - a).cross(c - a).length();
        if !(twice > 0.0 && twice.is_finite()) {
            continue;
        }
        area += 0.5 * twice;
        let of_corners = |uvs: &[[f32; 2]]| corners.map(|at| uvs.get(at).map_or(Vec2::ZERO, |uv| Vec2::from(*uv)));
        let uvs = [of_corners(&primitive.uv0), of_corners(&primitive.uv1)];
        for point in 0..points {
            let [s, t] = place(point);
            let uv = uvs.map(|[a, b, c]| a + (b - a) * s + (c - a) * t);
            for (sum, texture) in sums.iter_mut().zip(textures) {
                let texel = texture.as_ref().map_or(Vec4::ONE, |texture| texture.texel(uv));
                *sum += texel * (0.5 * twice / points as f32);
            }
        }
    }
    (area > 0.0).then(|| (sums.map(|sum| sum / area), area))
}

/// Points that fill a triangle evenly (Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences", R2).
fn place(index: usize) -> [f32; 2] {
    let [s, t] = [0.754_877_7, 0.569_840_3].map(|step: f32| (0.5 + step * index as f32).fract());
    if s + t > 1.0 { [1.0 - s, 1.0 - t] } else { [s, t] }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use super::*;
    use manypass_scene::{PixelFormat, primitives};

    /// Black and white columns, with a red one: the mean over a quad is known, and over its left half.
    #[test]
    fn the_mean_is_that_of_what_is_shown() {
        let data = [[0, 0, 0, 255], [255, 255, 255, 255], [255, 0, 0, 255], [255, 255, 255, 255]].concat();
        let texels = Pixels { width: 4, height: 1, format: PixelFormat::Rgba8, data };
        let mut quad = primitives::cube(Vec3::ONE);
        quad.positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        quad.indices = vec![0, 1, 2, 0, 2, 3];
        let mut mean = |width: f32, wrap_u: Wrap, scale: f32| {
            quad.uv0 = vec![[0.0, 0.0], [width, 0.0], [width, 1.0], [0.0, 1.0]];
            let rows = [Vec4::new(scale, 0.0, 0.0, 0.0), Vec4::Y];
            let sampler = Sampler { wrap_u, ..Sampler::default() };
            let laid = SurfaceTexture { texels: &texels, is_srgb: true, sampler, rows };
            let ([mean, white], area) = means(&quad, &[Some(laid), None]).unwrap();
            assert!((area - 1.0).abs() < 1e-6 && white == Vec4::ONE);
            mean
        };
        let near = |found: Vec4, r: f32, g: f32| {
            assert!((found.x - r).abs() < 0.03 && (found.y - g).abs() < 0.03, "{found}, not {r} {g}");
        };
        near(mean(1.0, Wrap::Repeat, 1.0), 0.75, 0.5);
        near(mean(0.5, Wrap::Repeat, 1.0), 0.5, 0.5);
        near(mean(2.0, Wrap::Repeat, 1.0), 0.75, 0.5);
        near(mean(2.0, Wrap::ClampToEdge, 1.0), 0.875, 0.75);
        near(mean(1.0, Wrap::Repeat, 0.25), 0.0, 0.0);
        // From the right back to the left.
        near(mean(1.25, Wrap::MirroredRepeat, 1.0), 0.8, 0.6);
        quad.topology = Topology::Lines;
        assert!(means::<0>(&quad, &[]).is_none());
    }
}
