//! Images and how textures sample them. Images stay encoded until somebody asks for their texels, so that few are
//! decoded at a time.

mod halved;
mod jpeg;
mod ktx2;
mod light;
mod texels;

pub use texels::{BlockFormat, Blocks, HalfFloats, MAX_IMAGE_SIZE_TEXELS};

use crate::capture::Monitor;
use crate::environment::light_size;
use crate::ktx2::{DeclaredColors, is_ktx2};
use std::io::Cursor;
use std::sync::Arc;
use texels::MAX_DECODE_BYTES;

/// The source of an image's texels.
#[derive(Clone, Debug)]
pub enum ImageSource {
    /// A PNG, JPEG, WebP or KTX2 file, or of light that was baked a Radiance or OpenEXR file, whole.
    Encoded(Arc<[u8]>),
    /// Texels made by code.
    Pixels(Arc<Pixels>),
    /// The file at a decoded URI, whose bytes are on their way: until they are there, materials are drawn as without
    /// the texture. [`crate::Scene::give_image`] puts them here.
    Loading(Arc<str>),
    /// What a camera of the scene sees, frame by frame: only who draws the scene knows its texels.
    Monitor(Arc<Monitor>),
    /// A picture that a simulation makes: only who draws the scene knows its texels.
    Simulation(Arc<SimulatedImage>),
}

impl ImageSource {
    /// The bytes that it is held in; 0 while they are on their way, and of what is drawn.
    pub fn bytes(&self) -> u64 {
        match self {
            Self::Encoded(bytes) => bytes.len() as u64,
            Self::Pixels(pixels) => pixels.data.len() as u64,
            Self::Loading(_) | Self::Monitor(_) | Self::Simulation(_) => 0,
        }
    }
}

/// A picture that a simulation makes.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SimulatedImage {
    /// Index into [`crate::Scene::simulations`].
    pub simulation: usize,
    /// Which of its pictures.
    pub picture: String,
}

impl Image {
    /// The picture `picture` of a simulation, an index into [`crate::Scene::simulations`].
    pub fn of_simulation(name: impl Into<String>, simulation: usize, picture: &str) -> Self {
        let image = SimulatedImage { simulation, picture: picture.into() };
        Self { name: name.into(), source: ImageSource::Simulation(image.into()) }
    }
}

/// The layout of decoded texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelFormat {
    /// Four bytes a texel: red, green, blue, alpha.
    Rgba8,
}

/// Decoded texels, rows from the top, tightly packed.
#[derive(Clone, Debug, PartialEq)]
pub struct Pixels {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// The layout of `data`.
    pub format: PixelFormat,
    /// `width · height` texels.
    pub data: Vec<u8>,
}

impl Pixels {
    /// The same image in another size, filtered linearly.
    pub fn resized(self, width: u32, height: u32) -> Self {
        if (self.width, self.height) == (width, height) {
            return self;
        }
        let format = self.format;
        let Some(image) = image::RgbaImage::from_raw(self.width, self.height, self.data) else {
            return Self { width, height, format, data: vec![255; width as usize * height as usize * 4] };
        };
        let data = image::imageops::resize(&image, width, height, image::imageops::FilterType::Triangle).into_raw();
        Self { width, height, format, data }
    }
}

/// Heights of 16 bits, rows from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Heights {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// `width · height` of them, 65,535 the highest.
    pub data: Vec<u16>,
}

impl Heights {
    /// The same in another size, filtered linearly.
    pub fn resized(self, width: u32, height: u32) -> Self {
        if (self.width, self.height) == (width, height) {
            return self;
        }
        let image = ::image::ImageBuffer::<::image::Luma<u16>, _>::from_raw(self.width, self.height, self.data);
        let Some(image) = image else {
            return Self { width, height, data: vec![u16::MAX; width as usize * height as usize] };
        };
        let data = ::image::imageops::resize(&image, width, height, ::image::imageops::FilterType::Triangle).into_raw();
        Self { width, height, data }
    }
}

/// An image of the scene. Whether its colours are sRGB or linear depends on the material slot that uses it.
#[derive(Clone, Debug)]
pub struct Image {
    /// The name or the URI in the file, for messages; empty if it has none.
    pub name: String,
    /// Where the texels come from.
    pub source: ImageSource,
}

/// The wrap mode of texture coordinates beyond the edge of an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Wrap {
    /// The image repeats.
    #[default]
    Repeat,
    /// Every other repetition is mirrored.
    MirroredRepeat,
    /// The edge goes on.
    ClampToEdge,
}

/// The wrap and filter modes of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Sampler {
    /// Beyond the edge in u.
    pub wrap_u: Wrap,
    /// Beyond the edge in v.
    pub wrap_v: Wrap,
    /// Whether magnification interpolates.
    pub mag_linear: bool,
    /// Whether minification interpolates between texels.
    pub min_linear: bool,
    /// How minification uses the mip chain: none = never, `Some(false)` = the nearest level, `Some(true)` = between
    /// two.
    pub mip_linear: Option<bool>,
}

impl Default for Sampler {
    fn default() -> Self {
        Self { wrap_u: Wrap::Repeat, wrap_v: Wrap::Repeat, mag_linear: true, min_linear: true, mip_linear: Some(true) }
    }
}

/// An image together with the way it is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Texture {
    /// Index into [`crate::Scene::images`].
    pub image: usize,
    /// How it is sampled.
    pub sampler: Sampler,
}

/// The largest width and height in a file: what is larger is broken.
const MAX_STORED_SIZE_TEXELS: u32 = 1 << 20;

/// Why an image cannot be decoded.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "image \"{name}\": {message}; expected PNG, JPEG, WebP or KTX2, or of baked light Radiance or OpenEXR, of at most 16384 by 16384 texels"
)]
pub struct ImageError {
    /// The image's name.
    pub name: String,
    /// What went wrong.
    pub message: String,
}

impl Image {
    fn error(&self, message: impl ToString) -> ImageError {
        ImageError { name: self.name.clone(), message: message.to_string() }
    }

    fn reader<'a>(&self, bytes: &'a [u8]) -> Result<::image::ImageReader<Cursor<&'a [u8]>>, ImageError> {
        let reader = ::image::ImageReader::new(Cursor::new(bytes)).with_guessed_format();
        let mut reader = reader.map_err(|error| self.error(error))?;
        if reader.format().is_none() {
            return Err(self.error("the format is not known"));
        }
        let mut limits = ::image::Limits::default();
        limits.max_image_width = Some(MAX_STORED_SIZE_TEXELS);
        limits.max_image_height = Some(MAX_STORED_SIZE_TEXELS);
        limits.max_alloc = Some(MAX_DECODE_BYTES);
        reader.limits(limits);
        Ok(reader)
    }

    /// Width and height in texels, from the header alone. An image above [`MAX_IMAGE_SIZE_TEXELS`] is halved until it fits
    /// if it is a PNG, JPEG or WebP, and else an error.
    pub fn dimensions(&self) -> Result<(u32, u32), ImageError> {
        let stored = self.stored_dimensions()?;
        Ok(halved::size(stored, halved::times(stored)))
    }

    /// What is said of an image that is halved until it fits.
    pub fn size_warning(&self) -> Option<String> {
        let (width, height) = self.stored_dimensions().ok()?;
        let times = halved::times((width, height));
        let (to_width, to_height) = halved::size((width, height), times);
        (times > 0).then(|| {
            format!(
                "it has {width} by {height} texels, and {MAX_IMAGE_SIZE_TEXELS} a side are possible; it is halved to \
                 {to_width} by {to_height}"
            )
        })
    }

    /// Width and height in the file.
    fn stored_dimensions(&self) -> Result<(u32, u32), ImageError> {
        let mut most = MAX_IMAGE_SIZE_TEXELS;
        let (width, height) = match &self.source {
            ImageSource::Pixels(pixels) => (pixels.width, pixels.height),
            ImageSource::Encoded(bytes) if is_ktx2(bytes) => {
                ktx2::dimensions(bytes).map_err(|message| self.error(message))?
            }
            ImageSource::Encoded(bytes) if self.holds_light() => {
                light_size(bytes).map_err(|message| self.error(message))?
            }
            ImageSource::Encoded(bytes) => {
                most = MAX_STORED_SIZE_TEXELS;
                self.reader(bytes)?.into_dimensions().map_err(|error| self.error(error))?
            }
            ImageSource::Loading(_) => return Err(self.error("it is still on its way")),
            ImageSource::Monitor(monitor) => (monitor.width, monitor.height),
            ImageSource::Simulation(_) => {
                return Err(self.error("only who draws a simulation knows the size of its pictures"));
            }
        };
        if width == 0 || height == 0 || width.max(height) > most {
            return Err(self.error(format!("it has {width} by {height} texels")));
        }
        Ok((width, height))
    }

    /// What is said of an image whose file declares other colours than it is read as: sRGB with the primaries of
    /// Rec. 709, or linear data. Files in KTX2 containers are looked at alone.
    pub fn color_warning(&self, is_srgb: bool) -> Option<String> {
        let ImageSource::Encoded(bytes) = &self.source else { return None };
        let declared = DeclaredColors::of(bytes).filter(|_| is_ktx2(bytes))?.other_than(is_srgb)?;
        let (read, remedy) = match is_srgb {
            true => ("sRGB with the primaries of Rec. 709, as textures of colour are", "convert the image to that"),
            false => ("linear data, as its texture is", "write the container anew as linear if its texels are"),
        };
        Some(format!("it declares {declared}, and is read as {read}; {remedy}"))
    }

    /// All levels as blocks of a format, the largest first, where the image can become such without loss of much: a
    /// Basis Universal file that brings every level down to one texel, and whose sides are whole blocks; else none.
    pub fn transcode(&self, format: BlockFormat) -> Option<Vec<Blocks>> {
        let ImageSource::Encoded(bytes) = &self.source else { return None };
        let (width, height) = self.dimensions().ok()?;
        let is_whole = width.is_multiple_of(BlockFormat::SIDE) && height.is_multiple_of(BlockFormat::SIDE);
        let fits = u64::from(width) * u64::from(height) * 4 <= MAX_DECODE_BYTES;
        (is_ktx2(bytes) && is_whole && fits).then(|| ktx2::transcode(bytes, format)).flatten()
    }

    /// Red as heights: all bits of an image that has 16 a channel, and of others eight. Takes at most 512 MiB while it
    /// decodes.
    pub fn decode_heights(&self) -> Result<Heights, ImageError> {
        if let ImageSource::Encoded(bytes) = &self.source
            && !is_ktx2(bytes)
        {
            let (width, height) = self.stored_dimensions()?;
            if u64::from(width) * u64::from(height) * 8 > MAX_DECODE_BYTES {
                return Err(self.error("it takes more than 512 MiB"));
            }
            let decoded = self.reader(bytes)?.decode().map_err(|error| self.error(error))?;
            let data = match decoded {
                ::image::DynamicImage::ImageLuma16(image) => image.into_raw(),
                other => other.into_rgba16().pixels().map(|texel| texel.0[0]).collect(),
            };
            let (data, (width, height)) = halved::until_it_fits(data, (width, height), 1);
            return Ok(Heights { width, height, data });
        }
        let Pixels { width, height, data, .. } = self.decode()?;
        let data = data.chunks_exact(4).map(|texel| u16::from(texel[0]) * 257).collect();
        Ok(Heights { width, height, data })
    }

    /// The texels with eight bits a channel. Takes at most 512 MiB while it decodes.
    pub fn decode(&self) -> Result<Pixels, ImageError> {
        let bytes = match &self.source {
            ImageSource::Pixels(pixels) => return Ok(Pixels::clone(pixels)),
            ImageSource::Encoded(bytes) => bytes,
            ImageSource::Loading(_) => return Err(self.error("it is still on its way")),
            ImageSource::Monitor(_) => return Err(self.error("it is what a monitor shows, which has no file")),
            ImageSource::Simulation(_) => return Err(self.error("it is a picture of a simulation, which has no file")),
        };
        let (width, height) = self.stored_dimensions()?;
        if u64::from(width) * u64::from(height) * 4 > MAX_DECODE_BYTES {
            return Err(self.error("it takes more than 512 MiB"));
        }
        if is_ktx2(bytes) {
            let data = ktx2::decode(bytes).map_err(|message| self.error(message))?;
            return Ok(Pixels { width, height, format: PixelFormat::Rgba8, data });
        }
        let data = match jpeg::decode((width, height), bytes) {
            Some(data) => data,
            None => self.reader(bytes)?.decode().map_err(|error| self.error(error))?.into_rgba8().into_raw(),
        };
        let (data, (width, height)) = halved::until_it_fits(data, (width, height), 4);
        Ok(Pixels { width, height, format: PixelFormat::Rgba8, data })
    }
}
