//! The texture of decals' images, beside the table of directional albedo.
//!
//! Images lie on powers of two, each a multiple of its own size away from the corner, so that mips of the whole are mips of
//! each, and no texel of a level holds two images. Colours are linear and times alpha, so that what is transparent has
//! no colour when texels are averaged.

use super::directional_albedo::directional_albedo_texels;
use super::textures::{Address, address_of};
use crate::colour::linear_from_srgb;
use crate::constants::DIRECTIONAL_ALBEDO_SIZE;
use crate::gpu::Gpu;
use half::f16;
use manypass_scene::environment::BrdfTable;
use manypass_scene::{Image, Pixels, Scene};
use std::collections::BTreeMap;
use std::sync::{Arc, LazyLock};

/// The largest side of an image of a decal in texels; larger ones are halved.
const IMAGES_SIDE_MAX: u32 = 1024;

/// The most texels of all images together: 256 MiB.
const TEXELS_MAX: u64 = 32 << 20;

/// So many levels there are beside the first.
const MIPS: u32 = 7;

/// What an image is read as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum ImageUse {
    /// sRGB, with alpha.
    Color,
    /// Numbers.
    Data,
}

/// Half floats, four a texel, rows from the top.
#[derive(Debug)]
struct Texels {
    width: u32,
    height: u32,
    data: Vec<[f32; 4]>,
}

/// Where the images of decals lie.
#[derive(Debug, Default)]
pub(crate) struct DecalAtlas {
    /// None where there are no images, and no table but the renderer's own.
    view: Option<wgpu::TextureView>,
    bytes: u64,
    /// x, y, width and height in texels, by the image's index.
    places: BTreeMap<(usize, ImageUse), [u32; 4]>,
    /// What it was made of, which tells images apart as long as somebody holds on to them.
    made_of: Vec<(ImageUse, Address, Image)>,
    /// The largest side of an image that it was made for.
    side_max: u32,
    /// The table of the scene that it holds.
    brdf: Option<Arc<BrdfTable>>,
    warnings: Vec<String>,
}

impl DecalAtlas {
    /// Makes it anew if the images of decals are others, none of them larger than `side_max` texels. Gives the bytes that
    /// were uploaded if so.
    pub fn follow(&mut self, gpu: &Gpu, scene: &Scene, side_max: u32) -> Option<u64> {
        let wanted = wanted(scene);
        let side_max = side_max.clamp(1, IMAGES_SIDE_MAX);
        let images = wanted.iter().filter_map(|(index, of)| Some((*of, scene.images.get(*index)?)));
        let known = self.made_of.iter().map(|(of, address, _)| (*of, *address));
        let is_same = images.clone().map(|(of, image)| (of, address_of(image))).eq(known);
        let has_same_table = self.brdf.as_ref().map(Arc::as_ptr) == scene.brdf.as_ref().map(Arc::as_ptr);
        if is_same && has_same_table && self.side_max == side_max && self.places.keys().eq(wanted.iter()) {
            return None;
        }
        let made_of = images.map(|(of, image)| (of, address_of(image), image.clone())).collect();
        let brdf = scene.brdf.clone();
        *self = Self { made_of, side_max, brdf, ..Self::new(gpu, scene, &wanted, side_max) };
        Some(self.bytes)
    }

    fn new(gpu: &Gpu, scene: &Scene, wanted: &[(usize, ImageUse)], side_max: u32) -> Self {
        let mut warnings = Vec::new();
        let mut images: Vec<((usize, ImageUse), Texels)> = Vec::new();
        for (index, of) in wanted {
            let Some(image) = scene.images.get(*index) else { continue };
            let decoded = image.decode().map_err(|error| error.to_string());
            match decoded.and_then(|pixels| texels(&pixels, *of, side_max).ok_or("it has no texels".into())) {
                Ok(texels) => images.push(((*index, *of), texels)),
                Err(error) => warnings.push(format!("a decal does without its image `{}`: {error}", image.name)),
            }
        }
        let texture_max = gpu.capabilities.max_texture_size;
        let (mut arranged, mut is_halved) = (arrange(&images, texture_max), false);
        let is_small = |(_, texels): &(_, Texels)| texels.width.max(texels.height) == 1;
        while arranged.is_none() && !images.iter().all(is_small) {
            images.iter_mut().for_each(|(_, texels)| *texels = half(texels));
            (arranged, is_halved) = (arrange(&images, texture_max), true);
        }
        if is_halved {
            warnings.push("the images of decals are too many for one texture, and halved until they fit".into());
        }
        let places: BTreeMap<(usize, ImageUse), [u32; 4]> = wanted.iter().map(|key| (*key, [0; 4])).collect();
        let mut atlas = Self { places, warnings, ..Self::default() };
        if let Some(arranged) = arranged.filter(|_| !images.is_empty() || scene.brdf.is_some()) {
            for ((key, texels), [x, y]) in images.iter().zip(&arranged.corners) {
                atlas.places.insert(*key, [*x, *y, texels.width, texels.height]);
            }
            let (view, bytes) = upload(gpu, images, &arranged, scene.brdf.as_deref());
            (atlas.view, atlas.bytes) = (Some(view), bytes);
        }
        atlas
    }

    /// Where an image lies: x, y, width, height in texels. None where it has none.
    pub fn place(&self, image: usize, of: ImageUse) -> Option<[u32; 4]> {
        self.places.get(&(image, of)).copied().filter(|[.., width, _]| *width > 0)
    }

    /// The texture, whose lowest rows are the table of directional albedo; none without images and a table of a file.
    pub fn view(&self) -> Option<&wgpu::TextureView> {
        self.view.as_ref()
    }

    /// Bytes of the texture.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// What could not be shown.
    pub fn warnings(&self) -> impl Iterator<Item = &String> {
        self.warnings.iter()
    }
}

/// The images of all decals, each once for what it is read as, in the order of their indices.
fn wanted(scene: &Scene) -> Vec<(usize, ImageUse)> {
    // Those that share a look mostly follow each other.
    let mut last = None;
    let mut wanted = Vec::new();
    for decal in &scene.decals {
        let address = Arc::as_ptr(&decal.look);
        if last.replace(address) == Some(address) {
            continue;
        }
        let look = &decal.look;
        let images = [
            (look.color_image, ImageUse::Color),
            (look.emission_image, ImageUse::Color),
            (look.normal_image, ImageUse::Data),
            (look.rough_metal_image, ImageUse::Data),
        ];
        wanted.extend(images.into_iter().filter_map(|(image, of)| Some((image?, of))));
    }
    wanted.retain(|(image, _)| *image < scene.images.len());
    wanted.sort_unstable();
    wanted.dedup();
    wanted
}

static LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| linear_from_srgb(byte as f32 / 255.0)));

/// An image in linear light, with sides that are powers of two; none if it lacks texels.
fn texels(pixels: &Pixels, of: ImageUse, side_max: u32) -> Option<Texels> {
    let &Pixels { width, height, .. } = pixels;
    if width.min(height) == 0 || pixels.data.len() as u64 != 4 * u64::from(width) * u64::from(height) {
        return None;
    }
    let texel = |bytes: &[u8]| {
        let share = |at: usize| f32::from(bytes[at]) / 255.0;
        let alpha = share(3);
        match of {
            ImageUse::Color => {
                let [r, g, b] = [0, 1, 2].map(|at| LINEAR[usize::from(bytes[at])] * alpha);
                [r, g, b, alpha]
            }
            ImageUse::Data => [share(0), share(1), share(2), alpha],
        }
    };
    // Means of squares at once, because floats of all of a large image would take four times its memory.
    let halvings = (0..32).find(|halvings| width.max(height) >> halvings <= side_max).unwrap_or(31);
    let [reduced_width, reduced_height] = [width, height].map(|side| (side >> halvings).max(1));
    let mean = |x: u32, y: u32| {
        let along = |at: u32, size: u32| (at << halvings)..((at + 1) << halvings).min(size);
        let mut sum = [0.0; 4];
        for row in along(y, height) {
            for column in along(x, width) {
                let first = (row as usize * width as usize + column as usize) * 4;
                sum.iter_mut().zip(texel(&pixels.data[first..first + 4])).for_each(|(sum, value)| *sum += value);
            }
        }
        let count = along(y, height).len() * along(x, width).len();
        sum.map(|sum| sum / count as f32)
    };
    let rows = (0..reduced_height).flat_map(|y| (0..reduced_width).map(move |x| (x, y)));
    let data = rows.map(|(x, y)| mean(x, y)).collect();
    let texels = Texels { width: reduced_width, height: reduced_height, data };
    let side = |side: u32| side.next_power_of_two().min(1 << side_max.max(1).ilog2());
    Some(resized(texels, side(reduced_width), side(reduced_height)))
}

/// The same image with other sides, filtered linearly.
fn resized(texels: Texels, width: u32, height: u32) -> Texels {
    if (texels.width, texels.height) == (width, height) {
        return texels;
    }
    let at = |x: u32, y: u32| texels.data[(y * texels.width + x) as usize];
    // The two texels around a place along a side, and how much of the second there is.
    let around = |place: u32, size: u32, from: u32| {
        let place = ((place as f32 + 0.5) * from as f32 / size as f32 - 0.5).max(0.0);
        let first = (place as u32).min(from - 1);
        (first, (first + 1).min(from - 1), place - first as f32)
    };
    let mix = |a: [f32; 4], b: [f32; 4], share: f32| std::array::from_fn(|at| a[at] + (b[at] - a[at]) * share);
    let mut data = Vec::with_capacity((width * height) as usize);
    for y in 0..height {
        let (y0, y1, share_y) = around(y, height, texels.height);
        for x in 0..width {
            let (x0, x1, share_x) = around(x, width, texels.width);
            let [above, below] = [y0, y1].map(|y| mix(at(x0, y), at(x1, y), share_x));
            data.push(mix(above, below, share_y));
        }
    }
    Texels { width, height, data }
}

/// The image at half its size.
fn half(texels: &Texels) -> Texels {
    let (width, height) = ((texels.width / 2).max(1), (texels.height / 2).max(1));
    let at = |x: u32, y: u32| {
        let (x, y) = (x.min(texels.width - 1), y.min(texels.height - 1));
        texels.data[(y * texels.width + x) as usize]
    };
    let mut data = Vec::with_capacity((width * height) as usize);
    for y in 0..height {
        for x in 0..width {
            let four = [at(2 * x, 2 * y), at(2 * x + 1, 2 * y), at(2 * x, 2 * y + 1), at(2 * x + 1, 2 * y + 1)];
            data.push(std::array::from_fn(|channel| four.iter().map(|texel| texel[channel]).sum::<f32>() / 4.0));
        }
    }
    Texels { width, height, data }
}

/// Where images lie in the texture.
struct Arrangement {
    width: u32,
    height: u32,
    /// The upper left corner of each.
    corners: Vec<[u32; 2]>,
}

/// Where images lie. None where they do not fit.
fn arrange<K>(images: &[(K, Texels)], texture_max: u32) -> Option<Arrangement> {
    let area: u64 = images.iter().map(|(_, texels)| u64::from(texels.width) * u64::from(texels.height)).sum();
    let widest = images.iter().map(|(_, texels)| texels.width).max().unwrap_or(1);
    let width = (area as f64).sqrt() as u32;
    let width = width.next_power_of_two().max(widest).max(DIRECTIONAL_ALBEDO_SIZE).min(texture_max);
    let mut order: Vec<usize> = (0..images.len()).collect();
    order.sort_by_key(|at| std::cmp::Reverse((images[*at].1.height, images[*at].1.width)));
    let mut corners = vec![[0; 2]; images.len()];
    let (mut x, mut y, mut shelf) = (0, 0, 0);
    for at in order {
        let Texels { width: wide, height: high, .. } = images[at].1;
        // Lower ones begin a shelf of their own, so that each lies on a multiple of its width.
        if x + wide > width || high < shelf {
            (x, y) = (0, y + shelf);
        }
        (corners[at], shelf) = ([x, y], high);
        x += wide;
    }
    let step = 1 << MIPS;
    let height = (y + shelf + DIRECTIONAL_ALBEDO_SIZE).next_multiple_of(step);
    let fits = height <= texture_max && widest <= texture_max && u64::from(width) * u64::from(height) <= TEXELS_MAX;
    fits.then_some(Arrangement { width, height, corners })
}

/// The texture with all of its levels, and their bytes.
fn upload<K>(
    gpu: &Gpu,
    images: Vec<(K, Texels)>,
    Arrangement { width, height, corners }: &Arrangement,
    brdf: Option<&BrdfTable>,
) -> (wgpu::TextureView, u64) {
    let (width, height) = (*width, *height);
    let mip_level_count = (MIPS + 1).min(width.ilog2() + 1);
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("decals"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let write = |level: u32, [x, y]: [u32; 2], (width, height): (u32, u32), texels: &[u16]| {
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture: &texture,
                mip_level: level,
                origin: wgpu::Origin3d { x, y, z: 0 },
                aspect: wgpu::TextureAspect::All,
            },
            bytemuck::cast_slice(texels),
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(width * 8), rows_per_image: None },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
    };
    for ((_, mut texels), [x, y]) in images.into_iter().zip(corners) {
        for level in 0..mip_level_count {
            let halves: Vec<u16> = texels.data.iter().flatten().map(|value| f16::from_f32(*value).to_bits()).collect();
            write(level, [x >> level, y >> level], (texels.width, texels.height), &halves);
            if texels.width == 1 || texels.height == 1 {
                // What is finer than a texel of a level is not looked up there.
                break;
            }
            texels = half(&texels);
        }
    }
    let side = DIRECTIONAL_ALBEDO_SIZE;
    write(0, [0, height - side], (side, side), &directional_albedo_texels(brdf));
    let texels: u64 = (0..mip_level_count).map(|level| u64::from(width >> level) * u64::from(height >> level)).sum();
    (texture.create_view(&Default::default()), texels * 8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use manypass_scene::PixelFormat;

    fn image(width: u32, height: u32) -> ((), Texels) {
        ((), Texels { width, height, data: vec![[0.0; 4]; (width * height) as usize] })
    }

    #[test]
    fn images_lie_beside_each_other_on_multiples_of_their_sides() {
        let images: Vec<_> = [(64, 16), (256, 256), (32, 128), (128, 128), (16, 64), (64, 64), (1, 1), (512, 4)]
            .map(|(width, height)| image(width, height))
            .into();
        let Arrangement { width, height, corners } = arrange(&images, 4096).expect("they fit");
        assert_eq!(height % (1 << MIPS), 0);
        let rectangles: Vec<[u32; 4]> =
            images.iter().zip(&corners).map(|((_, t), [x, y])| [*x, *y, x + t.width, y + t.height]).collect();
        for (at, [x0, y0, x1, y1]) in rectangles.iter().enumerate() {
            assert!(*x1 <= width && *y1 + DIRECTIONAL_ALBEDO_SIZE <= height);
            assert_eq!((x0 % (x1 - x0), y0 % (y1 - y0)), (0, 0));
            let is_apart = |other: &[u32; 4]| *x1 <= other[0] || other[2] <= *x0 || *y1 <= other[1] || other[3] <= *y0;
            assert!(rectangles[at + 1..].iter().all(is_apart), "{rectangles:?}");
        }
        // Too many for a texture.
        assert!(arrange(&(0..20).map(|_| image(1024, 1024)).collect::<Vec<_>>(), 2048).is_none());
    }

    #[test]
    fn texels_are_linear_and_times_alpha() {
        let pixels = Pixels {
            width: 3,
            height: 1,
            format: PixelFormat::Rgba8,
            data: [[255, 0, 188, 255], [255, 255, 255, 0], [0, 255, 0, 51]].concat(),
        };
        let color = texels(&pixels, ImageUse::Color, 1024).expect("texels");
        assert_eq!((color.width, color.height), (4, 1));
        assert!((color.data[0][2] - 0.503).abs() < 1e-2 && color.data[0][0] == 1.0);
        // Nothing of the white that is transparent.
        assert!(color.data.iter().all(|[r, g, b, a]| r.max(*g).max(*b) <= *a + 1e-6));
        let data = texels(&pixels, ImageUse::Data, 2).expect("texels");
        assert_eq!((data.width, data.height), (1, 1));
        assert!((data.data[0][0] - 1.0).abs() < 1e-6 && (data.data[0][3] - 0.5).abs() < 1e-6);
        // Not as many as it says, or none.
        assert!(texels(&Pixels { width: 4, ..pixels.clone() }, ImageUse::Data, 64).is_none());
        assert!(texels(&Pixels { width: 0, data: Vec::new(), ..pixels }, ImageUse::Data, 64).is_none());
    }
}
