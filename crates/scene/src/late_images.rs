//! Images that come after their scene, so that a model is seen before its textures are.

use crate::gltf_file::texel_budget_bytes;
use crate::{Image, ImageError, ImageSource, Scene};
use std::collections::{BTreeMap, HashSet, VecDeque};
use std::sync::Arc;

/// What those who fetch the files of a model give as the error of an image that comes later: see
/// [`ImageSource::Loading`].
pub const ON_ITS_WAY: &str = "the file is on its way";

/// The images of a scene that are still loading. Whatever their number, each is put in its place without looking at the
/// others.
#[derive(Clone, Debug, Default)]
pub struct LateImages {
    /// Those that are there, and are shown one by one.
    held: VecDeque<(usize, ImageSource)>,
    /// The images that wait for a file, by its decoded URI.
    waiting: BTreeMap<Arc<str>, Vec<usize>>,
    /// What all images that are there take as texels, and as they are in files.
    texel_bytes: u64,
    encoded_bytes: u64,
}

impl LateImages {
    /// Those that wait for a file.
    pub fn of(scene: &Scene) -> Self {
        let mut late = Self::default();
        for (index, image) in scene.images.iter().enumerate() {
            match &image.source {
                ImageSource::Loading(uri) => late.waiting.entry(uri.clone()).or_default().push(index),
                _ => {
                    let Ok((texel_bytes, encoded_bytes)) = bytes_of(image) else { continue };
                    late.texel_bytes = late.texel_bytes.saturating_add(texel_bytes);
                    late.encoded_bytes = late.encoded_bytes.saturating_add(encoded_bytes);
                }
            }
        }
        late
    }

    /// Those that wait for a file, and the bytes of all others, which are taken out of the scene, so that it is drawn
    /// without them.
    pub fn withheld(scene: &mut Scene) -> Self {
        let late = Self::of(scene);
        Self { held: scene.withhold_images().into(), ..late }
    }

    /// The decoded URIs of the files that are waited for, each once.
    pub fn missing(&self) -> impl Iterator<Item = &str> {
        self.waiting.keys().map(|uri| &**uri)
    }

    /// Whether nothing is to come any more.
    pub fn is_complete(&self) -> bool {
        self.held.is_empty() && self.waiting.is_empty()
    }

    /// Puts the bytes of a file where images of the scene wait for it. Says how many did.
    ///
    /// # Errors
    /// The file is no image, or all images together are too large; they stay as if they were on their way.
    pub fn give(&mut self, scene: &mut Scene, uri: &str, bytes: Vec<u8>) -> Result<usize, ImageError> {
        let image = Image { name: uri.to_owned(), source: ImageSource::Encoded(bytes.into()) };
        let (texel_bytes, encoded_bytes) = bytes_of(&image)?;
        let (texels, encoded) =
            (self.texel_bytes.saturating_add(texel_bytes), self.encoded_bytes.saturating_add(encoded_bytes));
        if texels > texel_budget_bytes(encoded) {
            let message = format!("the images take more than {} MiB together", texel_budget_bytes(encoded) >> 20);
            return Err(ImageError { name: uri.to_owned(), message });
        }
        let Some(waiting) = self.waiting.remove(uri) else { return Ok(0) };
        (self.texel_bytes, self.encoded_bytes) = (texels, encoded);
        for index in &waiting {
            if let Some(waiting) = scene.images.get_mut(*index) {
                waiting.source = image.source.clone();
            }
        }
        Ok(waiting.len())
    }

    /// Waits no longer for a file: what shows its image is drawn without it. Says how many images waited.
    pub fn give_up(&mut self, uri: &str) -> usize {
        self.waiting.remove(uri).map_or(0, |waiting| waiting.len())
    }

    /// Puts the next of the images that were withheld back. False if there is none left.
    pub fn show_next(&mut self, scene: &mut Scene) -> bool {
        let Some((index, source)) = self.held.pop_front() else { return false };
        if let Some(image) = scene.images.get_mut(index) {
            image.source = source;
        }
        true
    }
}

/// What an image takes as texels, and as it is in its file.
fn bytes_of(image: &Image) -> Result<(u64, u64), ImageError> {
    let (width, height) = image.dimensions()?;
    let encoded_bytes = match &image.source {
        ImageSource::Encoded(bytes) => bytes.len() as u64,
        _ => 0,
    };
    Ok((u64::from(width) * u64::from(height) * 4, encoded_bytes))
}

impl Scene {
    /// The decoded URIs of the images that are still on their way, each once.
    pub fn missing_images(&self) -> Vec<Arc<str>> {
        let mut known = HashSet::new();
        let uris = self.images.iter().filter_map(|image| match &image.source {
            ImageSource::Loading(uri) => Some(uri),
            _ => None,
        });
        uris.filter(|uri| known.insert(*uri)).cloned().collect()
    }

    /// Puts the bytes of a file where images wait for it. Says how many did. Of many files [`LateImages`] takes less
    /// time.
    ///
    /// # Errors
    /// The file is no image, or all images together are too large; they stay as if they were on their way.
    pub fn give_image(&mut self, uri: &str, bytes: Vec<u8>) -> Result<usize, ImageError> {
        LateImages::of(self).give(self, uri, bytes)
    }

    /// Takes the bytes of all images out of the scene, which is drawn without them, for whoever puts them back one by
    /// one; with the index of each.
    pub fn withhold_images(&mut self) -> Vec<(usize, ImageSource)> {
        let is_there = |(_, image): &(usize, &mut Image)| matches!(image.source, ImageSource::Encoded(_));
        let withhold = |(index, image): (usize, &mut Image)| {
            let waiting = ImageSource::Loading(format!("#{index}").into());
            (index, std::mem::replace(&mut image.source, waiting))
        };
        self.images.iter_mut().enumerate().filter(is_there).map(withhold).collect()
    }
}
