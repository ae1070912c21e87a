//! Images that come after their scene, so that a model is seen before its textures are.

use crate::gltf_file::texel_budget_bytes;
use crate::{Image, ImageError, ImageSource, Scene};
use std::sync::Arc;

/// What those who fetch the files of a model give as the error of an image that comes later: see [`ImageSource::Loading`].
pub const ON_ITS_WAY: &str = "the file is on its way";

impl Scene {
    /// The decoded URIs of the images that are still on their way, each once.
    pub fn missing_images(&self) -> Vec<Arc<str>> {
        let mut missing: Vec<Arc<str>> = Vec::new();
        for image in &self.images {
            if let ImageSource::Loading(uri) = &image.source
                && !missing.contains(uri)
            {
                missing.push(uri.clone());
            }
        }
        missing
    }

    /// Puts the bytes of a file where images wait for it. Says how many did.
    ///
    /// # Errors
    /// The file is no image, or all images together are too large; they stay as if they were on their way.
    pub fn give_image(&mut self, uri: &str, bytes: Vec<u8>) -> Result<usize, ImageError> {
        let waits = |image: &&mut Image| matches!(&image.source, ImageSource::Loading(of) if **of == *uri);
        let image = Image { name: uri.to_owned(), source: ImageSource::Encoded(bytes.into()) };
        let texel_bytes = |image: &Image| image.dimensions().map(|(w, h)| u64::from(w) * u64::from(h) * 4);
        let encoded_bytes = |image: &Image| match &image.source {
            ImageSource::Encoded(bytes) => bytes.len() as u64,
            _ => 0,
        };
        let others = self.images.iter().filter_map(|image| Some((texel_bytes(image).ok()?, encoded_bytes(image))));
        let own = (texel_bytes(&image)?, encoded_bytes(&image));
        let (texels, encoded) = others.fold(own, |sum, image| (sum.0 + image.0, sum.1 + image.1));
        if texels > texel_budget_bytes(encoded) {
            let message = format!("the images take more than {} MiB together", texel_budget_bytes(encoded) >> 20);
            return Err(ImageError { name: uri.to_owned(), message });
        }
        Ok(self.images.iter_mut().filter(waits).map(|waiting| waiting.source = image.source.clone()).count())
    }

    /// Takes the bytes of all images out of the scene, which is drawn without them, for whoever puts them back one by one; with
    /// the index of each.
    pub fn withhold_images(&mut self) -> Vec<(usize, ImageSource)> {
        let is_there = |(_, image): &(usize, &mut Image)| matches!(image.source, ImageSource::Encoded(_));
        let withhold = |(index, image): (usize, &mut Image)| {
            let waiting = ImageSource::Loading(format!("#{index}").into());
            (index, std::mem::replace(&mut image.source, waiting))
        };
        self.images.iter_mut().enumerate().filter(is_there).map(withhold).collect()
    }
}
