//! Images that a file names, each read once.

use super::parts::Parts;
use crate::gltf_file::{MAX_FILE_BYTES, texel_budget_bytes};
use crate::{Image, ImageSource, Sampler, Texture};
use std::collections::HashMap;

/// The images of a scene that is being made, by name.
#[derive(Debug, Default)]
pub(super) struct ImageFiles {
    /// None where the image cannot be read.
    images: HashMap<String, Option<usize>>,
    encoded_bytes: u64,
    texel_bytes: u64,
}

impl ImageFiles {
    /// The index of the image called `name`. One that cannot be read is warned of, once, and is none.
    pub(super) fn image(
        &mut self,
        name: &str,
        parts: &mut Parts,
        resolve: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
    ) -> Option<usize> {
        if let Some(known) = self.images.get(name) {
            return *known;
        }
        let read = resolve(name).and_then(|bytes| self.checked(name, bytes));
        let index = match read {
            Ok(image) => {
                parts.scene.images.push(image);
                Some(parts.scene.images.len() - 1)
            }
            Err(message) => {
                parts.warn(format!("texture \"{name}\": {message}; materials do without it"));
                None
            }
        };
        let warning = index.and_then(|index| parts.scene.images.get(index)?.size_warning());
        if let Some(warning) = warning {
            parts.warn(format!("texture \"{name}\": {warning}"));
        }
        self.images.insert(name.to_owned(), index);
        index
    }

    /// The image, if all together do not take too much.
    fn checked(&mut self, name: &str, bytes: Vec<u8>) -> Result<Image, String> {
        let encoded_bytes = self.encoded_bytes + bytes.len() as u64;
        let image = Image { name: name.to_owned(), source: ImageSource::Encoded(bytes.into()) };
        let (width, height) = image.dimensions().map_err(|error| error.message)?;
        let texel_bytes = self.texel_bytes + u64::from(width) * u64::from(height) * 4;
        let budget_bytes = texel_budget_bytes(encoded_bytes);
        if texel_bytes > budget_bytes || encoded_bytes > MAX_FILE_BYTES {
            return Err(format!("the images take more than {} MiB together; make them smaller", budget_bytes >> 20));
        }
        (self.encoded_bytes, self.texel_bytes) = (encoded_bytes, texel_bytes);
        Ok(image)
    }
}

/// The index of the texture that samples an image so.
pub(super) fn texture(parts: &mut Parts, image: usize, sampler: Sampler) -> usize {
    let texture = Texture { image, sampler };
    let textures = &mut parts.scene.textures;
    textures.iter().position(|other| *other == texture).unwrap_or_else(|| {
        textures.push(texture);
        textures.len() - 1
    })
}
