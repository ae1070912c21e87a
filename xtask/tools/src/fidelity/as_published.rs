//! Models that lie here in another form than the published pictures show, put right.

use anyhow::{Context, Result};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

const TRANSMISSION: &str = "KHR_materials_transmission";

/// The file of a scene's model as the published pictures have it; a copy in the folder, where it is another. Those of
/// FlightHelmet have goggles whose lenses let light through, tinted by their colour. The file that is here is older:
/// it blends them by the alpha of that colour, which also takes from what they mirror.
///
/// # Errors
/// It cannot be read or copied.
pub(super) fn as_published(name: &str, model: &Path, folder: &Path) -> Result<PathBuf> {
    if name != "FlightHelmet" {
        return Ok(model.to_owned());
    }
    let text = std::fs::read_to_string(model).with_context(|| format!("reading {}", model.display()))?;
    let mut document: Value = serde_json::from_str(&text).with_context(|| format!("reading {}", model.display()))?;
    if !lets_light_through(&mut document, "LensesMat") {
        return Ok(model.to_owned());
    }
    let from = model.parent().with_context(|| format!("{} lies in no folder", model.display()))?;
    let to = folder.join(format!("{name}.published"));
    std::fs::create_dir_all(&to).with_context(|| format!("making {}", to.display()))?;
    for list in ["buffers", "images"] {
        for uri in document[list].as_array().into_iter().flatten().filter_map(|entry| entry["uri"].as_str()) {
            let copied = std::fs::copy(from.join(uri), to.join(uri));
            copied.with_context(|| format!("copying {} to {}", from.join(uri).display(), to.display()))?;
        }
    }
    let copy = to.join(format!("{name}.gltf"));
    std::fs::write(&copy, document.to_string()).with_context(|| format!("writing {}", copy.display()))?;
    Ok(copy)
}

/// Makes glass of a material that is blended. False where there is none of this name, or it is none of these.
fn lets_light_through(document: &mut Value, name: &str) -> bool {
    let Some(materials) = document.get_mut("materials").and_then(Value::as_array_mut) else { return false };
    let is_it = |material: &&mut Value| material["name"] == name && material["alphaMode"] == "BLEND";
    let Some(material) = materials.iter_mut().find(is_it) else { return false };
    material["alphaMode"] = json!("OPAQUE");
    material["extensions"] = json!({ TRANSMISSION: { "transmissionFactor": 1 } });
    let mut used = document["extensionsUsed"].as_array().cloned().unwrap_or_default();
    used.push(json!(TRANSMISSION));
    document["extensionsUsed"] = Value::Array(used);
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_named_blended_material_becomes_glass() {
        let lens = |mode: &str| json!({ "materials": [{ "name": "Wood" }, { "name": "Lens", "alphaMode": mode }] });
        let mut document = lens("BLEND");
        assert!(lets_light_through(&mut document, "Lens"));
        let glass = json!({
            "name": "Lens",
            "alphaMode": "OPAQUE",
            "extensions": { "KHR_materials_transmission": { "transmissionFactor": 1 } },
        });
        let expected =
            json!({ "extensionsUsed": ["KHR_materials_transmission"], "materials": [{ "name": "Wood" }, glass] });
        assert_eq!(document, expected);
        for (mut other, name) in [(lens("BLEND"), "Wood"), (lens("MASK"), "Lens"), (json!({}), "Lens")] {
            let before = other.clone();
            assert!(!lets_light_through(&mut other, name));
            assert_eq!(other, before);
        }
    }
}
