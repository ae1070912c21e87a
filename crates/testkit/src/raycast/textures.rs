//! Textures: bilinear, without mips. What is finer than a pixel is averaged by the rays through it.

use glam::{DVec2, DVec4};
use manypass_scene::{Sampler, Scene, TextureRef, Wrap};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A decoded image with its sampler and its place on a UV set.
#[derive(Clone, Debug)]
pub(super) struct Texture {
    image: Arc<Texels>,
    is_srgb: bool,
    sampler: Sampler,
    uv_set: usize,
    /// Rows of the matrix that places it (`KHR_texture_transform`).
    rows: [[f64; 3]; 2],
}

#[derive(Debug)]
struct Texels {
    size: [i64; 2],
    rgba8: Vec<[u8; 4]>,
}

/// Images of a scene, each decoded once.
#[derive(Default)]
pub(super) struct Images(BTreeMap<usize, Option<Arc<Texels>>>);

impl Images {
    /// A texture of a material; none where it names none or its image cannot be shown.
    pub fn texture(&mut self, scene: &Scene, used: Option<TextureRef>, is_srgb: bool) -> Option<Texture> {
        let used = used?;
        let texture = scene.textures.get(used.texture)?;
        let image = self.0.entry(texture.image).or_insert_with(|| {
            let pixels = scene.images.get(texture.image)?.decode().ok()?;
            let rgba8 = pixels.data.chunks_exact(4).map(|texel| [texel[0], texel[1], texel[2], texel[3]]).collect();
            Some(Arc::new(Texels { size: [pixels.width, pixels.height].map(i64::from), rgba8 }))
        });
        let transform = used.transform;
        let (sin, cos) = f64::from(transform.rotation_rad).sin_cos();
        let [scale_u, scale_v] = transform.scale.to_array().map(f64::from);
        let [offset_u, offset_v] = transform.offset.to_array().map(f64::from);
        Some(Texture {
            image: image.clone()?,
            is_srgb,
            sampler: texture.sampler,
            uv_set: used.uv_set as usize,
            // Translation · rotation · scale, as the extension's text writes it out.
            rows: [[cos * scale_u, sin * scale_v, offset_u], [-sin * scale_u, cos * scale_v, offset_v]],
        })
    }
}

impl Texture {
    /// The texture at the UVs of a surface; colours are linear.
    pub fn at(&self, uvs: &[DVec2; 2]) -> DVec4 {
        let uv = uvs[self.uv_set.min(1)];
        let [u, v] = self.rows.map(|row| row[0] * uv.x + row[1] * uv.y + row[2]);
        let [width, height] = self.image.size;
        let [x, y] = [u * width as f64, v * height as f64];
        if !x.is_finite() || !y.is_finite() {
            return DVec4::ONE;
        }
        if !self.sampler.mag_linear {
            return self.texel(x.floor() as i64, y.floor() as i64);
        }
        let (left, top) = ((x - 0.5).floor(), (y - 0.5).floor());
        let (right_share, bottom_share) = (x - 0.5 - left, y - 0.5 - top);
        let (left, top) = (left as i64, top as i64);
        let row = |y: i64| self.texel(left, y).lerp(self.texel(left + 1, y), right_share);
        row(top).lerp(row(top + 1), bottom_share)
    }

    fn texel(&self, x: i64, y: i64) -> DVec4 {
        let [width, height] = self.image.size;
        let (x, y) = (wrapped(x, width, self.sampler.wrap_u), wrapped(y, height, self.sampler.wrap_v));
        let texel = self.image.rgba8[(y * width + x) as usize];
        let [red, green, blue, alpha] = texel.map(|level| f64::from(level) / 255.0);
        match self.is_srgb {
            true => DVec4::new(linear_from_srgb(red), linear_from_srgb(green), linear_from_srgb(blue), alpha),
            false => DVec4::new(red, green, blue, alpha),
        }
    }
}

fn wrapped(index: i64, size: i64, wrap: Wrap) -> i64 {
    match wrap {
        Wrap::Repeat => index.rem_euclid(size),
        Wrap::MirroredRepeat => {
            let index = index.rem_euclid(2 * size);
            index.min(2 * size - 1 - index)
        }
        Wrap::ClampToEdge => index.clamp(0, size - 1),
    }
}

/// IEC 61966-2-1.
fn linear_from_srgb(level: f64) -> f64 {
    if level <= 0.04045 { level / 12.92 } else { ((level + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use manypass_scene::{Image, ImageSource, PixelFormat, Pixels, TextureTransform};

    fn texture(sampler: Sampler, transform: TextureTransform, is_srgb: bool) -> Texture {
        let data = vec![0, 0, 0, 255, 255, 0, 0, 255, 0, 255, 0, 255, 188, 188, 188, 51];
        let pixels = Pixels { width: 2, height: 2, format: PixelFormat::Rgba8, data };
        let mut scene = Scene::default();
        scene.images.push(Image { name: String::new(), source: ImageSource::Pixels(pixels.into()) });
        scene.textures.push(manypass_scene::Texture { image: 0, sampler });
        Images::default().texture(&scene, Some(TextureRef { texture: 0, uv_set: 0, transform }), is_srgb).unwrap()
    }

    #[test]
    fn texels_are_interpolated_in_linear_light() {
        let texture = texture(Sampler::default(), TextureTransform::default(), true);
        let at = |u, v| texture.at(&[DVec2::new(u, v); 2]);
        assert_eq!(at(0.75, 0.25), DVec4::new(1.0, 0.0, 0.0, 1.0));
        // 188 of sRGB is the half of white within 0.4 %.
        assert!((at(0.75, 0.75) - DVec4::new(0.503, 0.503, 0.503, 0.2)).abs().max_element() < 1e-3);
        assert_eq!(at(0.5, 0.25), DVec4::new(0.5, 0.0, 0.0, 1.0));
        // The edges repeat: the middle of the four corners is the mean of all.
        assert!((at(0.0, 0.0) - at(0.5, 0.5)).length() < 1e-12);
    }

    #[test]
    fn edges_and_transforms_are_those_of_the_specification() {
        let sampler = Sampler { wrap_u: Wrap::MirroredRepeat, wrap_v: Wrap::ClampToEdge, ..Sampler::default() };
        let mirrored = texture(sampler, TextureTransform::default(), false);
        let at = |u, v| mirrored.at(&[DVec2::new(u, v); 2]);
        assert_eq!(at(1.25, -3.0), at(0.75, 0.25));
        assert_eq!(at(-0.25, 9.0), at(0.25, 0.75));
        // A quarter of a turn takes u to −v: with v downwards that is counter-clockwise.
        let transform = TextureTransform { rotation_rad: std::f32::consts::FRAC_PI_2, ..TextureTransform::default() };
        let turned = texture(Sampler { mag_linear: false, ..Sampler::default() }, transform, false);
        assert_eq!(turned.at(&[DVec2::new(0.25, 0.75); 2]), DVec4::new(188.0, 188.0, 188.0, 51.0) / 255.0);
    }
}
