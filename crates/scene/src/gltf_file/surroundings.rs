//! What is to be seen around places, in files: `MANYPASS_surroundings` of the root.
//!
//! Each of `places` has `name`, `position`, the box `center` and `size` of the surfaces that have it, `fade`, perhaps the box
//! `wallsCenter` and `wallsSize`, in metres, and `picture`: the buffer view of an equirectangular OpenEXR file.

use super::document::Document;
use super::error::LoadError;
use super::json::Json;
use super::write::Parts;
use crate::EnvironmentMap;
use crate::surroundings::{Region, SURROUNDINGS_MAX, Surroundings};
use glam::Vec3;
use serde_json::{Value, json};

const EXTENSION: &str = "MANYPASS_surroundings";

/// Those of a file.
pub(super) fn read_surroundings(document: &mut Document) -> Result<Vec<Surroundings>, LoadError> {
    let Some(extension) = document.root.extension(EXTENSION)? else { return Ok(Vec::new()) };
    let places = extension.objects("places")?;
    if places.len() > SURROUNDINGS_MAX {
        document.warn(&extension.at("places"), &format!("only the first {SURROUNDINGS_MAX} are read"));
    }
    places.iter().take(SURROUNDINGS_MAX).map(|json| read_place(document, json)).collect()
}

fn vector(json: &Json, key: &str) -> Result<Vec3, LoadError> {
    let numbers = json.numbers::<3>(key)?.ok_or_else(|| json.error(key, "expected three numbers, found nothing"))?;
    Ok(Vec3::from(numbers))
}

fn region(json: &Json, [center, size]: [&str; 2]) -> Result<Region, LoadError> {
    let region = Region { center_world: vector(json, center)?, half_m: 0.5 * vector(json, size)? };
    let largest = region.center_world.abs().max(region.half_m).max_element();
    if region.half_m.min_element() > 0.0 && largest < 1e9 {
        return Ok(region);
    }
    Err(json.error(size, "expected a box with three lengths above 0"))
}

fn read_place(document: &mut Document, json: &Json) -> Result<Surroundings, LoadError> {
    let own = region(json, ["center", "size"])?;
    let walls = json.has("wallsSize").then(|| region(json, ["wallsCenter", "wallsSize"])).transpose()?;
    let name = json.name();
    let (bytes, _) = document.view_bytes(json.require_integer("picture")?, &json.at("picture"))?;
    let picture = EnvironmentMap::decode(&name, bytes).map_err(|error| json.error("picture", error.message))?;
    document.spend(8 * picture.texels.len() as u64, &json.pointer)?;
    Ok(Surroundings {
        position_world: vector(json, "position")?,
        fade_m: json.number_in("fade", 0.0, 0.0, f32::MAX)?,
        walls,
        picture: Some(picture.into()),
        ..Surroundings::of_room(name, own)
    })
}

impl Parts {
    /// Puts surroundings that have a picture into the file, in place of those that it has; `encode` makes an OpenEXR file of a
    /// picture.
    ///
    /// # Errors
    /// That of `encode`.
    pub fn put_surroundings<E>(
        &mut self,
        all: &[Surroundings],
        mut encode: impl FnMut(&EnvironmentMap) -> Result<Vec<u8>, E>,
    ) -> Result<(), E> {
        self.forget_root(EXTENSION);
        let mut places: Vec<Value> = Vec::new();
        for of in all {
            let Some(picture) = &of.picture else { continue };
            let bytes = encode(picture)?;
            let mut place = json!({
                "name": of.name,
                "position": of.position_world.to_array(),
                "center": of.region.center_world.to_array(),
                "size": (2.0 * of.region.half_m).to_array(),
                "fade": of.fade_m,
                "picture": self.append_view(&bytes),
            });
            if let Some(walls) = &of.walls {
                place["wallsCenter"] = json!(walls.center_world.to_array());
                place["wallsSize"] = json!((2.0 * walls.half_m).to_array());
            }
            places.push(place);
        }
        if !places.is_empty() {
            self.use_extension(EXTENSION);
            self.json["extensions"][EXTENSION] = json!({ "places": places });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gltf_file::load_bytes;

    fn file(all: &[Surroundings], bytes: &[u8]) -> Parts {
        let mut parts = Parts::empty();
        parts.put_surroundings(all, |_| Ok::<_, ()>(bytes.to_vec())).unwrap();
        parts.prune(&parts.clone().unreferenced());
        parts
    }

    fn place() -> Surroundings {
        let room = Region { center_world: Vec3::new(1.0, 2.0, 3.0), half_m: Vec3::new(2.0, 1.0, 0.5) };
        let picture = EnvironmentMap::from_fn("hall", 4, 2, |direction| Vec3::splat(1.0 + direction.y));
        let own = Region { half_m: Vec3::splat(0.25), ..room };
        Surroundings {
            position_world: Vec3::new(1.0, 2.5, 3.0),
            region: own,
            fade_m: 0.125,
            picture: Some(picture.into()),
            ..Surroundings::of_room("hall", room)
        }
    }

    #[test]
    fn places_come_back_as_they_were() {
        // As Radiance files are read, too.
        let bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x80\x80\x80\x81\x40\x40\x40\x81";
        let parts = file(&[place()], bytes);
        let scene = load_bytes(&parts.to_glb().unwrap(), &mut |_| Err("none".into()), "a.glb").unwrap().scene;
        let [found] = &scene.surroundings[..] else { panic!("{:?}", scene.surroundings) };
        let picture = found.picture.as_ref().unwrap();
        assert_eq!((picture.width, picture.height, picture.texels[0][0].to_f32()), (2, 1, 1.0));
        assert_eq!(*found, Surroundings { picture: found.picture.clone(), ..place() });
    }

    #[test]
    fn broken_places_are_refused() {
        let parts = file(&[place()], b"no picture");
        let mut wrong = vec![(parts.clone(), "it is neither Radiance (.hdr) nor OpenEXR")];
        for (key, value, expected) in [
            ("size", json!([1, 0, 1]), "expected a box with three lengths above 0"),
            ("center", json!([1, 0]), "center"),
            ("picture", json!(7), "refers to bufferView 7"),
        ] {
            let mut parts = parts.clone();
            parts.json["extensions"][EXTENSION]["places"][0][key] = value;
            wrong.push((parts, expected));
        }
        for (parts, expected) in wrong {
            let error = load_bytes(&parts.to_glb().unwrap(), &mut |_| Err("none".into()), "a.glb").unwrap_err();
            assert!(error.to_string().contains(expected), "{error}");
        }
    }
}
