//! Height maps that a stage gives to materials, and what it changes of those that a model brings itself.

use super::names::Pattern;
use super::table::{Source, SpannedValue, Table};
use crate::material::{HeightMap, HeightMethod};
use crate::{Diagnostic, Material, TextureRef};
use std::ops::Range;

/// The keys beside `height_map`.
const KEYS: [&str; 3] = ["height_depth_m", "height_method", "self_shadow"];

/// What a stage says of heights.
#[derive(Clone, Debug)]
pub(super) struct HeightChange {
    /// The image; without one the model's own heights are changed.
    pub image: Option<SpannedValue<String>>,
    depth_m: Option<f32>,
    method: Option<HeightMethod>,
    self_shadow: Option<bool>,
    /// Where the first key of the model's own heights stands, and that of their shadows.
    places: [Range<usize>; 2],
}

fn has_steps(method: HeightMethod) -> bool {
    matches!(method, HeightMethod::Steep | HeightMethod::Occlusion)
}

impl HeightChange {
    /// None if a table says nothing of heights.
    pub fn read(table: &Table<'_>) -> Result<Option<Self>, Box<Diagnostic>> {
        let (image, depth_m) = (table.text("height_map"), table.number("height_depth_m"));
        let Some(first) =
            KEYS.into_iter().find_map(|key| table.place(key)).or(image.as_ref().map(|map| map.range.clone()))
        else {
            return Ok(None);
        };
        if image.is_some() && depth_m.is_none() {
            let message = "`height_map` needs `height_depth_m`: how deep below the surface a height of 0 lies";
            return Err(table.fault("height_map", message));
        }
        let word = table.text("height_method").map(|word| word.value);
        let method = word.as_deref().map(|word| match word {
            "bump" => HeightMethod::Bump,
            "parallax" => HeightMethod::Parallax,
            "steep" => HeightMethod::Steep,
            _ => HeightMethod::Occlusion,
        });
        let method = method.or(image.is_some().then_some(HeightMethod::Occlusion));
        let self_shadow = table.boolean("self_shadow");
        if self_shadow == Some(true) && method.is_some_and(|method| !has_steps(method)) {
            let word = word.unwrap_or_default();
            let message = format!("`self_shadow` needs the method \"steep\" or \"occlusion\", not \"{word}\"");
            return Err(table.fault("self_shadow", message));
        }
        let places = [first.clone(), table.place("self_shadow").unwrap_or(first)];
        Ok(Some(Self { image, depth_m, method, self_shadow, places }))
    }

    /// Fails where it changes heights of materials that have none, or which they cannot be changed to.
    pub fn check<'m>(
        &self,
        source: &Source,
        materials: impl Iterator<Item = &'m Material>,
        pattern: &Pattern,
    ) -> Result<(), Box<Diagnostic>> {
        if self.image.is_some() {
            return Ok(());
        }
        let own: Vec<HeightMap> = materials.filter_map(|material| material.height).collect();
        if own.is_empty() {
            let message =
                format!("`{}` has no heights of its own: name an image of them, `height_map`", pattern.text());
            return Err(source.fault(self.places[0].clone(), message));
        }
        for height in own {
            let changed = self.of(height.texture, Some(height));
            if changed.depth_m < 0.0 && changed.method != HeightMethod::Bump {
                let message = format!(
                    "black is high in the heights of `{}`, which bend normals alone; say `height_depth_m` to have white high",
                    pattern.text()
                );
                return Err(source.fault(self.places[0].clone(), message));
            }
            if changed.self_shadow && !has_steps(changed.method) {
                let message = format!(
                    "`self_shadow` needs the method \"steep\" or \"occlusion\", which the heights of `{}` have not: say `height_method` as well",
                    pattern.text()
                );
                return Err(source.fault(self.places[1].clone(), message));
            }
        }
        Ok(())
    }

    /// Heights of a texture: the model's own as they are changed, or new ones.
    pub fn of(&self, texture: TextureRef, own: Option<HeightMap>) -> HeightMap {
        let method = self.method.or(own.map(|own| own.method)).unwrap_or(HeightMethod::Occlusion);
        let depth_m = self.depth_m.or(own.map(|own| own.depth_m)).unwrap_or_default();
        // Whoever asks for another method gets what comes with that.
        let kept = own.filter(|_| self.method.is_none()).map(|own| own.self_shadow);
        let self_shadow = self.self_shadow.or(kept).unwrap_or(method == HeightMethod::Occlusion);
        HeightMap { texture, depth_m, method, self_shadow }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]
    use crate::material::{HeightMap, HeightMethod};
    use crate::stage::Stage;
    use crate::{Material, Scene, TextureRef, TextureTransform};

    fn model(depth_m: f32) -> Scene {
        let texture = TextureRef { texture: 0, uv_set: 0, transform: TextureTransform::default() };
        let height = HeightMap { texture, depth_m, method: HeightMethod::Bump, self_shadow: false };
        let named = |name: &str, height| Material { name: name.into(), height, ..Material::default() };
        Scene { materials: vec![named("wall", Some(height)), named("water", None)], ..Scene::default() }
    }

    fn changed(depth_m: f32, name: &str, lines: &str) -> Result<Vec<Option<HeightMap>>, String> {
        let text = format!("model = \"m.obj\"\n[[materials]]\nname = \"{name}\"\n{lines}\n");
        let stage = Stage::parse("a.stage.toml", &text).map_err(|error| error.to_string())?;
        let mut scene = model(depth_m);
        stage.apply(&mut scene).map_err(|error| error.to_string())?;
        Ok(scene.materials.iter().map(|material| material.height).collect())
    }

    #[test]
    fn heights_of_the_model_become_relief() {
        let one = |lines: &str| {
            let [Some(height), None] = changed(0.5, "*", lines).unwrap()[..] else { panic!("{lines}") };
            (height.method, height.depth_m, height.self_shadow)
        };
        assert_eq!(one("height_method = \"occlusion\""), (HeightMethod::Occlusion, 0.5, true));
        assert_eq!(one("height_method = \"steep\"\nheight_depth_m = 2"), (HeightMethod::Steep, 2.0, false));
        let quiet = "height_method = \"occlusion\"\nself_shadow = false";
        assert_eq!(one(quiet), (HeightMethod::Occlusion, 0.5, false));
        assert_eq!(one("height_depth_m = 0.25"), (HeightMethod::Bump, 0.25, false));
        let turned = changed(-0.5, "wall", "height_method = \"occlusion\"\nheight_depth_m = 0.1").unwrap();
        assert_eq!(turned[0].map(|height| height.depth_m), Some(0.1));
    }

    #[test]
    fn what_heights_cannot_be_is_told_with_its_place() {
        for (depth_m, name, lines, expected) in [
            (0.5, "water", "height_method = \"steep\"", "4:17: error: `water` has no heights of its own"),
            (0.5, "wall", "self_shadow = true", "4:15: error: `self_shadow` needs the method"),
            (
                0.5,
                "wall",
                "height_method = \"bump\"\nself_shadow = true",
                "5:15: error: `self_shadow` needs the method",
            ),
            (-0.5, "wall", "height_method = \"steep\"", "4:17: error: black is high in the heights of `wall`"),
        ] {
            let error = changed(depth_m, name, lines).unwrap_err();
            assert!(error.starts_with(&format!("a.stage.toml:{expected}")), "{error}");
        }
    }
}
