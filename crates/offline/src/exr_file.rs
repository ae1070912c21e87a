//! OpenEXR files: the picture as layer `rgba`, and one layer for every AOV.

use crate::encode::{EncodeError, check_length};
use crate::still::{AovLayer, Samples};
use exr::prelude::*;
use std::io::Cursor;
use std::result::Result;

/// The standard names of an AOV's channels, in the order of its values.
pub fn channel_names(aov: &str, components: usize) -> Vec<&'static str> {
    let names: &[&str] = match (aov, components) {
        ("depth", 1) => &["Z"],
        (_, 1) => &["Y"],
        (_, 2) => &["X", "Y"],
        ("normal" | "normal_view" | "position", 3) => &["X", "Y", "Z"],
        (_, 3) => &["R", "G", "B"],
        _ => &["R", "G", "B", "A"],
    };
    names.to_vec()
}

/// A file of scene-linear radiance (associated alpha; none leaves the layer out) and `aovs`; floats of 32 bits, ids
/// of 32-bit integers, ZIP compression.
///
/// # Errors
/// If a layer's values do not fit the size, or there is no layer at all.
pub fn encode(width: u32, height: u32, radiance: Option<&[f32]>, aovs: &[AovLayer]) -> Result<Vec<u8>, EncodeError> {
    let mut layers: SmallVec<[Layer<AnyChannels<FlatSamples>>; 2]> = SmallVec::new();
    if let Some(radiance) = radiance {
        check_length(width, height, 4, radiance.len())?;
        layers.push(float_layer("rgba", &["R", "G", "B", "A"], width, height, radiance));
    }
    for aov in aovs {
        match &aov.samples {
            Samples::Float { components, data } => {
                check_length(width, height, *components, data.len())?;
                layers.push(float_layer(&aov.name, &channel_names(&aov.name, *components), width, height, data));
            }
            Samples::Id(ids) => {
                check_length(width, height, 1, ids.len())?;
                let channel = AnyChannel::new("Id", FlatSamples::U32(ids.clone()));
                layers.push(layer(&aov.name, width, height, std::iter::once(channel).collect()));
            }
        }
    }
    let failed = |reason: String| EncodeError::Encoder { format: "EXR", reason };
    if layers.is_empty() {
        return Err(failed("there is no layer".into()));
    }
    let size = Vec2(width as usize, height as usize);
    let file = Image::from_layers(ImageAttributes::new(IntegerBounds::from_dimensions(size)), layers);
    let mut bytes = Cursor::new(Vec::new());
    file.write().non_parallel().to_buffered(&mut bytes).map_err(|error| failed(error.to_string()))?;
    Ok(bytes.into_inner())
}

fn float_layer(
    name: &str,
    channels: &[&str],
    width: u32,
    height: u32,
    data: &[f32],
) -> Layer<AnyChannels<FlatSamples>> {
    let step = channels.len();
    let channel = |(index, channel): (usize, &&str)| {
        let values: Vec<f32> = data.iter().copied().skip(index).step_by(step).collect();
        AnyChannel::new(*channel, FlatSamples::F32(values))
    };
    layer(name, width, height, channels.iter().enumerate().map(channel).collect())
}

fn layer(
    name: &str,
    width: u32,
    height: u32,
    channels: SmallVec<[AnyChannel<FlatSamples>; 4]>,
) -> Layer<AnyChannels<FlatSamples>> {
    let name = Text::new_or_none(name).unwrap_or_else(|| Text::from("aov"));
    Layer::new(
        (width as usize, height as usize),
        LayerAttributes::named(name),
        Encoding { compression: Compression::ZIP16, ..Encoding::SMALL_LOSSLESS },
        AnyChannels::sort(channels),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_and_channels_come_back() {
        let radiance: Vec<f32> = (0..24).map(|value| value as f32 * 1000.5).collect();
        let float =
            |name: &str, components, data| AovLayer { name: name.into(), samples: Samples::Float { components, data } };
        let aovs = [
            float("normal", 3, (0..18).map(|value| value as f32 - 9.0).collect()),
            float("depth", 1, vec![1.0, 2.0, 3.0, 4.0, 5.0, f32::INFINITY]),
            AovLayer { name: "object_id".into(), samples: Samples::Id(vec![0, 1, u32::MAX, 3, 4, 16_777_217]) },
        ];
        let bytes = encode(3, 2, Some(&radiance), &aovs).expect("encoded");
        let image = read_all_flat_layers_from_memory(bytes);
        let layer = |name: &str| {
            let named = |layer: &&Layer<AnyChannels<FlatSamples>>| layer.attributes.layer_name == Some(name.into());
            image.layer_data.iter().find(named).expect("layer")
        };
        let channel = |name: &str, channel: &str| {
            let channels = &layer(name).channel_data.list;
            channels.iter().find(|c| c.name.eq(channel)).expect("channel").sample_data.clone()
        };
        assert_eq!(channel("rgba", "A"), FlatSamples::F32(radiance.iter().copied().skip(3).step_by(4).collect()));
        assert_eq!(channel("normal", "Z"), FlatSamples::F32(vec![-7.0, -4.0, -1.0, 2.0, 5.0, 8.0]));
        assert_eq!(channel("depth", "Z"), FlatSamples::F32(vec![1.0, 2.0, 3.0, 4.0, 5.0, f32::INFINITY]));
        assert_eq!(channel("object_id", "Id"), FlatSamples::U32(vec![0, 1, u32::MAX, 3, 4, 16_777_217]));
        assert!(image.layer_data.iter().all(|layer| layer.encoding.compression == Compression::ZIP16));
    }

    fn read_all_flat_layers_from_memory(bytes: Vec<u8>) -> FlatImage {
        let reader = read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
        reader.non_parallel().from_buffered(Cursor::new(bytes)).expect("read")
    }

    #[test]
    fn nothing_and_wrong_lengths_are_errors() {
        assert!(encode(1, 1, None, &[]).is_err());
        assert!(encode(2, 1, Some(&[0.0; 4]), &[]).is_err());
    }
}
