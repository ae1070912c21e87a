//! Pictures in OpenEXR files (.exr).

use super::map::{CheckSize, UncheckedPicture};
use exr::meta::header::Header;
use exr::prelude::{ReadChannels, ReadLayers, read};
use std::io::Cursor;

/// What is wrong with an OpenEXR file, in words.
pub fn exr_fault(error: &exr::error::Error) -> String {
    match error {
        // What the decoder makes of the end of a file.
        exr::error::Error::Invalid(message) if message.contains("missing bytes") => {
            "the file ends early, is it cut off?".into()
        }
        error => error.to_string(),
    }
}

/// What is wrong if no part of an OpenEXR file has the channels R, G and B.
pub fn missing_channels(parts: &[Header]) -> Option<String> {
    let names = |part: &Header| part.channels.list.iter().map(|channel| channel.name.to_string()).collect::<Vec<_>>();
    let has_all = |part: &Header| {
        let names = names(part);
        ["R", "G", "B"].iter().all(|name| names.iter().any(|found| found == name))
    };
    if parts.iter().any(has_all) {
        return None;
    }
    let found: Vec<String> = parts.iter().flat_map(names).take(NAMED_MAX).collect();
    Some(format!("expected the channels R, G and B in one part, and it has {}", found.join(", ")))
}

/// So many channels are named.
const NAMED_MAX: usize = 12;

/// Width and height of a file, from its header; of one with several parts the first one's.
pub(super) fn size(bytes: &[u8]) -> Result<(u32, u32), String> {
    let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|error| exr_fault(&error))?;
    meta.headers.first().map(size_of).ok_or_else(|| "it has no part".to_owned())
}

fn size_of(part: &Header) -> (u32, u32) {
    let side = |side: usize| u32::try_from(side).unwrap_or(u32::MAX);
    (side(part.layer_size.0), side(part.layer_size.1))
}

pub(super) fn decode_exr(bytes: &[u8], check_size: CheckSize) -> Result<UncheckedPicture, String> {
    let failed = |error: exr::error::Error| exr_fault(&error);
    let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(failed)?;
    meta.headers.iter().map(size_of).try_for_each(|(width, height)| check_size(width, height))?;
    if let Some(message) = missing_channels(&meta.headers) {
        return Err(message);
    }
    let reader = read().no_deep_data().largest_resolution_level().rgb_channels(
        |size, _| (size.0, vec![[0.0f32; 3]; size.0 * size.1]),
        |(width, pixels), position, (r, g, b): (f32, f32, f32)| {
            if let Some(pixel) = pixels.get_mut(position.1 * *width + position.0) {
                *pixel = [r, g, b];
            }
        },
    );
    let image = reader.first_valid_layer().all_attributes().non_parallel().from_buffered(Cursor::new(bytes));
    let layer = image.map_err(failed)?.layer_data;
    let side = |side: usize| u32::try_from(side).unwrap_or(u32::MAX);
    Ok(UncheckedPicture { width: side(layer.size.0), height: side(layer.size.1), rgb: layer.channel_data.pixels.1 })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use super::*;
    use exr::prelude::{SpecificChannels, WritableImage};

    #[test]
    fn what_lacks_colours_or_an_end_says_so() {
        let message = |bytes: &[u8]| decode_exr(bytes, |_, _| Ok(())).err();
        let mut grey = Cursor::new(Vec::new());
        let channel =
            SpecificChannels::build().with_channel("Y").with_pixel_fn(|_: exr::prelude::Vec2<usize>| (0.5f32,));
        exr::prelude::Image::from_channels((4, 2), channel).write().to_buffered(&mut grey).unwrap();
        let said = message(grey.get_ref()).unwrap();
        assert_eq!(said, "expected the channels R, G and B in one part, and it has Y");
        let mut whole = Cursor::new(Vec::new());
        let channels = SpecificChannels::rgb(|_: exr::prelude::Vec2<usize>| (1.0f32, 2.0f32, 3.0f32));
        exr::prelude::Image::from_channels((4, 2), channels).write().to_buffered(&mut whole).unwrap();
        let whole = whole.into_inner();
        assert_eq!(message(&whole), None);
        for length in [5, 100, whole.len() / 2, whole.len() - 1] {
            let said = message(&whole[..length]).unwrap();
            assert!(said.contains("the file ends early"), "{length} of {}: {said}", whole.len());
        }
    }
}
