//! The headers of OpenEXR files: what they say besides the pixels, as bytes that are the same for the same input.

use crate::camera::CameraData;
use crate::manifest;
use exr::meta::attribute::{self, AttributeValue, Chromaticities, SampleType};
use exr::meta::header::{Header, LayerAttributes};
use exr::meta::{MetaData, magic_number};
use exr::prelude::*;
use std::io::Write;

/// How the pixels of a file are packed. Each way gives back every bit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ExrCompression {
    /// Deflate, 16 rows at a time.
    #[default]
    Zip,
    /// Deflate, row by row, for readers that go from row to row.
    Zips,
    /// Runs of equal bytes, row by row: quick, and of use for flat areas.
    Rle,
    /// Wavelets and Huffman codes, 32 rows at a time: for noise.
    Piz,
    /// As they are.
    None,
}

impl ExrCompression {
    /// The words for all of them.
    pub const NAMES: [&str; 5] = ["zip", "zips", "rle", "piz", "none"];

    /// The one of a word.
    pub fn named(word: &str) -> Option<Self> {
        match word {
            "zip" => Some(Self::Zip),
            "zips" => Some(Self::Zips),
            "rle" => Some(Self::Rle),
            "piz" => Some(Self::Piz),
            "none" => Some(Self::None),
            _ => None,
        }
    }

    /// As headers say it.
    pub(crate) fn of_header(self) -> Compression {
        match self {
            Self::Zip => Compression::ZIP16,
            Self::Zips => Compression::ZIP1,
            Self::Rle => Compression::RLE,
            Self::Piz => Compression::PIZ,
            Self::None => Compression::Uncompressed,
        }
    }

    /// The rows of a block.
    pub(crate) fn block_rows(self) -> u32 {
        self.of_header().scan_lines_per_block() as u32
    }
}

/// What the header of a picture says besides its size and channels.
#[derive(Clone, Debug, Default)]
pub struct PictureInfo {
    /// How its pixels are packed.
    pub compression: ExrCompression,
    /// Its camera.
    pub camera: Option<CameraData>,
    /// The number of its frame.
    pub frame: Option<u32>,
    /// The time of its frame in seconds.
    pub time_secs: Option<f32>,
    /// Frames a second.
    pub frames_per_second: Option<f32>,
    /// The stops that a picture for the display would be exposed by; the values in the file are without.
    pub exposure_stops: Option<f32>,
    /// JSON of the names of `object_id`, by [`manifest::object_ids`].
    pub object_ids: Option<String>,
    /// JSON of the names of `material_id`, by [`manifest::material_ids`].
    pub material_ids: Option<String>,
}

/// A part of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExrPart {
    /// The name of the layer.
    pub name: String,
    /// The names of the channels, in the order of a pixel's values.
    pub channels: Vec<&'static str>,
    /// Whether the values are whole numbers of 32 bits, against floats of 32 bits.
    pub is_id: bool,
}

/// The primaries and the white point of Rec. ITU-R BT.709.
const REC_709: Chromaticities =
    Chromaticities { red: Vec2(0.64, 0.33), green: Vec2(0.3, 0.6), blue: Vec2(0.15, 0.06), white: Vec2(0.3127, 0.329) };

/// Text that is ASCII, as all texts here are; what is not is left out.
fn text(value: &str) -> Text {
    Text::new_or_none(value).unwrap_or_else(|| Text::from(""))
}

/// The header of every part.
pub(crate) fn headers(width: u32, height: u32, parts: &[ExrPart], info: &PictureInfo) -> Vec<Header> {
    let size = (width as usize, height as usize);
    let mut shared = ImageAttributes::with_size(size);
    shared.chromaticities = Some(REC_709);
    let encoding = info.compression.of_header();
    let header = |(index, part): (usize, &ExrPart)| {
        let sample_type = if part.is_id { SampleType::U32 } else { SampleType::F32 };
        let mut names = part.channels.clone();
        // Readers expect channels in this order.
        names.sort_unstable();
        let channel = |name: &&str| ChannelDescription::new(text(name), sample_type, !part.is_id);
        Header::new(text(&part.name), size, names.iter().map(channel).collect())
            .with_encoding(encoding, exr::meta::BlockDescription::ScanLines, LineOrder::Increasing)
            .with_shared_attributes(shared.clone())
            .with_attributes(layer_attributes(part, index == 0, info))
    };
    parts.iter().enumerate().map(header).collect()
}

fn layer_attributes(part: &ExrPart, is_first: bool, info: &PictureInfo) -> LayerAttributes {
    let mut attributes = LayerAttributes::named(text(&part.name));
    attributes.software_name = Some(text(concat!("manypass ", env!("CARGO_PKG_VERSION"))));
    let mut add = |name: &str, value: AttributeValue| {
        attributes.other.insert(text(name), value);
    };
    add("manypass/version", AttributeValue::Text(text(env!("CARGO_PKG_VERSION"))));
    if let Some(frame) = info.frame {
        add("manypass/frame", AttributeValue::I32(i32::try_from(frame).unwrap_or(i32::MAX)));
    }
    if let Some(time_secs) = info.time_secs {
        add("manypass/time_secs", AttributeValue::F32(time_secs));
    }
    if let Some(stops) = info.exposure_stops {
        add("manypass/exposure_stops", AttributeValue::F32(stops));
    }
    for (name, manifest) in [("object_id", &info.object_ids), ("material_id", &info.material_ids)] {
        // The first part's header is the one that simple readers look at.
        if let Some(manifest) = manifest.as_ref().filter(|_| is_first || part.name == name) {
            add(&format!("manypass/{name}/manifest"), AttributeValue::Text(text(manifest)));
        }
    }
    if let Some(camera) = &info.camera {
        let [x, y, z] = camera.eye_world_m.map(|value| value as f32);
        add("manypass/eye", AttributeValue::FloatVec3((x, y, z)));
        let json = serde_json::to_value(camera).map(|value| manifest::ascii(&value)).unwrap_or_default();
        add("manypass/camera", AttributeValue::Text(text(&json)));
        attributes.world_to_camera = Some(camera.exr_world_to_camera());
        attributes.world_to_normalized_device = camera.exr_world_to_ndc();
        attributes.horizontal_field_of_view = camera.fov_x_deg.map(|degrees| degrees as f32);
        attributes.vertical_field_of_view = camera.fov_y_deg.map(|degrees| degrees as f32);
        attributes.near_clip_plane = Some(camera.near_m as f32);
        attributes.far_clip_plane = Some(camera.far_m.map_or(f32::INFINITY, |far| far as f32));
        attributes.screen_window_width = camera.exr_screen_window_width();
    }
    attributes.frames_per_second = info.frames_per_second.map(rational);
    attributes
}

/// Frames a second as whole numbers, to a thousandth.
pub(crate) fn rational(frames_per_second: f32) -> (i32, u32) {
    let thousandths = (f64::from(frames_per_second) * 1000.0).round() as i32;
    let divisor = [1000, 500, 250, 125, 100, 50, 25, 20, 10, 5, 4, 2].into_iter().find(|n| thousandths % n == 0);
    let divisor = divisor.unwrap_or(1);
    (thousandths / divisor, 1000 / divisor.unsigned_abs())
}

/// Writes everything before the offset tables. The encoder of `exr` writes attributes of its users in the order of a hash
/// map, which changes from run to run; here they are sorted by name.
///
/// # Errors
/// A header that OpenEXR does not allow, or a writer that fails.
pub(crate) fn write(headers: &[Header], out: &mut impl Write) -> exr::error::UnitResult {
    let requirements = MetaData::validate(headers, true)?;
    magic_number::write(out)?;
    requirements.write(out)?;
    for header in headers {
        let mut attributes: Vec<_> = header.all_named_attributes().collect();
        attributes.sort_by(|a, b| a.0.cmp(b.0));
        for (name, value) in &attributes {
            attribute::write(name, value, out)?;
        }
        out.write_all(&[0])?;
    }
    if requirements.has_multiple_layers {
        out.write_all(&[0])?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::rational;

    #[test]
    fn rates_are_fractions() {
        assert_eq!([24.0, 29.97, 12.5, 0.125].map(rational), [(24, 1), (2997, 100), (25, 2), (1, 8)]);
    }
}
