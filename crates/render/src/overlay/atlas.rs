//! The texture that letters and images share.

use crate::gpu::Gpu;
use manypass_scene::Pixels;
use manypass_scene::overlay::{Coverage, Font, GlyphId};
use std::collections::HashMap;
use std::sync::Arc;

/// The largest side in texels, 64 MiB.
pub(super) const SIDE_MAX: u32 = 4096;

/// The least side.
const SIDE_MIN: u32 = 128;

/// Texels between two images.
const GAP: u32 = 1;

/// What the pen's place is rounded to, in parts of a pixel.
pub(super) const PEN_STEPS: u32 = 4;

/// Which letter it is: of a font (its place in memory, while the overlay holds it), with the bits of its size, and how
/// many steps right of a pixel's edge the pen stands.
type GlyphKey = (usize, GlyphId, u32, u32);

/// Texels to be put somewhere: display colours times alpha.
#[derive(Debug)]
struct Image {
    width: u32,
    height: u32,
    data: Vec<u8>,
}

/// Letters and images that are wanted.
#[derive(Debug)]
pub(super) struct Atlas {
    images: Vec<Image>,
    glyphs: HashMap<GlyphKey, Option<Glyph>>,
    sprites: HashMap<(usize, u32, u32), usize>,
}

/// A letter in the atlas.
#[derive(Clone, Copy, Debug)]
pub(super) struct Glyph {
    /// Which image it is.
    pub image: usize,
    /// Where its upper left corner is, in pixels from the pen on the baseline.
    pub corner_px: [i32; 2],
    /// Its width and height.
    pub size_px: [u32; 2],
}

/// The image of white texels that plain rectangles show.
pub(super) const WHITE: usize = 0;

/// Where a texel of it is in every atlas: corner and size.
pub(super) const WHITE_TEXEL: [f32; 4] = [1.0; 4];

/// The side of that image, so that neighbours are white where it is filtered.
const WHITE_SIDE: u32 = 3;

impl Default for Atlas {
    fn default() -> Self {
        let white =
            Image { width: WHITE_SIDE, height: WHITE_SIDE, data: vec![255; (4 * WHITE_SIDE * WHITE_SIDE) as usize] };
        Self { images: vec![white], glyphs: HashMap::new(), sprites: HashMap::new() }
    }
}

impl Atlas {
    fn add(&mut self, image: Image) -> usize {
        self.images.push(image);
        self.images.len() - 1
    }

    /// A letter; none of what covers nothing.
    pub fn glyph(&mut self, font: &Arc<Font>, glyph: GlyphId, size_px: f32, step: u32) -> Option<Glyph> {
        let key = (Arc::as_ptr(font) as usize, glyph, size_px.to_bits(), step);
        if let Some(known) = self.glyphs.get(&key) {
            return *known;
        }
        let coverage = font.coverage(glyph, size_px, step as f32 / PEN_STEPS as f32);
        let made = coverage.map(|Coverage { left_px, top_px, width, height, data }| {
            let data = data.into_iter().flat_map(|share| [share; 4]).collect();
            let image = self.add(Image { width, height, data });
            Glyph { image, corner_px: [left_px, top_px], size_px: [width, height] }
        });
        self.glyphs.insert(key, made);
        made
    }

    /// An image, with fewer texels where it is drawn with fewer pixels.
    pub fn sprite(&mut self, pixels: &Arc<Pixels>, size_px: [f32; 2]) -> usize {
        let side = |texels: u32, pixels: f32| texels.min((pixels.ceil() as u32).max(1));
        let (width, height) = (side(pixels.width, size_px[0]), side(pixels.height, size_px[1]));
        let key = (Arc::as_ptr(pixels) as usize, width, height);
        if let Some(known) = self.sprites.get(&key) {
            return *known;
        }
        // What is transparent has no colour, so that none of it gets into its neighbours.
        let times_alpha = |texel: &[u8]| {
            let alpha = u32::from(texel[3]);
            [0, 1, 2].map(|channel| ((u32::from(texel[channel]) * alpha + 127) / 255) as u8)
        };
        let data = pixels.data.chunks_exact(4).flat_map(|texel| {
            let [r, g, b] = times_alpha(texel);
            [r, g, b, texel[3]]
        });
        let data: Vec<u8> = data.collect();
        let resized = Pixels { data, ..Pixels::clone(&Pixels { data: Vec::new(), ..**pixels }) }.resized(width, height);
        let image = self.add(Image { width, height, data: resized.data });
        self.sprites.insert(key, image);
        image
    }

    /// Where all images lie in one square, as small a one as they fit into, in rows of images of like height. None where
    /// they do not fit.
    pub fn arrange(&self, side_max: u32) -> Option<Arrangement> {
        let mut order: Vec<usize> = (0..self.images.len()).collect();
        // White comes first, so that everybody knows where it is.
        order.sort_by_key(|index| {
            let Image { width, height, .. } = self.images[*index];
            (*index != WHITE, std::cmp::Reverse((height, width)))
        });
        let sides = (0..).map(|doublings| SIDE_MIN << doublings).take_while(|side| *side <= side_max);
        sides.into_iter().find_map(|side| Some(Arrangement { side, corners: self.corners(&order, side)? }))
    }

    /// Puts all images where they lie.
    pub fn pack(self, Arrangement { side, corners }: Arrangement) -> PackedImages {
        let mut texels = vec![0; (side * side * 4) as usize];
        for (image, [x, y]) in self.images.iter().zip(&corners) {
            let row_bytes = image.width as usize * 4;
            for (row, data) in (*y..).zip(image.data.chunks_exact(row_bytes.max(1))) {
                let first = (row * side + x) as usize * 4;
                if let Some(place) = texels.get_mut(first..first + row_bytes) {
                    place.copy_from_slice(data);
                }
            }
        }
        let place =
            |(image, [x, y]): (&Image, &[u32; 2])| [*x, *y, image.width, image.height].map(|texels| texels as f32);
        let mut places: Vec<[f32; 4]> = self.images.iter().zip(&corners).map(place).collect();
        if let Some(white) = places.get_mut(WHITE) {
            *white = WHITE_TEXEL;
        }
        PackedImages { side, texels, places }
    }

    /// The corners of images in rows, those of `order` one after the other.
    fn corners(&self, order: &[usize], side: u32) -> Option<Vec<[u32; 2]>> {
        let mut corners = vec![[0; 2]; self.images.len()];
        let (mut x, mut y, mut row_height) = (0, 0, 0);
        for index in order {
            let Image { width, height, .. } = self.images[*index];
            if x + width > side {
                (x, y, row_height) = (0, y + row_height + GAP, 0);
            }
            if x + width > side || y + height > side {
                return None;
            }
            corners[*index] = [x, y];
            (x, row_height) = (x + width + GAP, row_height.max(height));
        }
        Some(corners)
    }
}

/// Where images lie in a square.
#[derive(Debug)]
pub(super) struct Arrangement {
    pub side: u32,
    /// The upper left corner of each.
    corners: Vec<[u32; 2]>,
}

impl Arrangement {
    /// Bytes of the texture.
    pub fn bytes(&self) -> u64 {
        4 * u64::from(self.side) * u64::from(self.side)
    }
}

/// Images in a square.
#[derive(Debug)]
pub(super) struct PackedImages {
    pub side: u32,
    /// Four bytes a texel.
    pub texels: Vec<u8>,
    /// Of every image the corner and the size, in texels.
    pub places: Vec<[f32; 4]>,
}

impl PackedImages {
    /// The texture.
    pub fn upload(&self, gpu: &Gpu) -> wgpu::TextureView {
        let size = wgpu::Extent3d { width: self.side, height: self.side, depth_or_array_layers: 1 };
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("overlay.atlas"),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(self.side * 4), rows_per_image: None };
        gpu.queue.write_texture(texture.as_image_copy(), &self.texels, layout, size);
        texture.create_view(&Default::default())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use super::*;
    use manypass_scene::PixelFormat;

    #[test]
    fn images_do_not_overlap_and_what_does_not_fit_is_refused() {
        let mut atlas = Atlas::default();
        for side in 1..60u32 {
            atlas.add(Image {
                width: side,
                height: 61 - side,
                data: vec![side as u8; (side * (61 - side) * 4) as usize],
            });
        }
        let arrangement = atlas.arrange(SIDE_MAX).unwrap();
        let bytes = arrangement.bytes();
        let packed = atlas.pack(arrangement);
        assert_eq!(packed.texels.len() as u64, bytes);
        let texel = |x: f32, y: f32| packed.texels[((y as u32 * packed.side + x as u32) * 4) as usize];
        for (number, [x, y, width, height]) in packed.places.iter().enumerate().skip(1) {
            for (dx, dy) in [(0.0, 0.0), (width - 1.0, 0.0), (0.0, height - 1.0), (width - 1.0, height - 1.0)] {
                assert_eq!(usize::from(texel(x + dx, y + dy)), number);
            }
        }
        let mut atlas = Atlas::default();
        atlas.add(Image { width: 129, height: 1, data: vec![0; 516] });
        assert!(atlas.arrange(128).is_none());
    }

    #[test]
    fn sprites_have_no_more_texels_than_they_are_drawn_with_and_no_colour_where_they_are_clear() {
        // A column of opaque black beside one of clear white.
        let data = [[0, 0, 0, 255], [255, 255, 255, 0]].concat().repeat(4);
        let pixels = Arc::new(Pixels { width: 2, height: 4, format: PixelFormat::Rgba8, data });
        let mut atlas = Atlas::default();
        let image = atlas.sprite(&pixels, [1.0, 1.0]);
        assert_eq!(atlas.images[image].data, [0, 0, 0, 128]);
        let larger = atlas.sprite(&pixels, [100.0, 2.0]);
        assert_eq!((atlas.images[larger].width, atlas.images[larger].height), (2, 2));
        assert_eq!(atlas.sprite(&pixels, [0.5, 0.5]), image);
    }
}
