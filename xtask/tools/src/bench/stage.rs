//! Fields of lights of which every tenth casts shadows: a copy of the model whose lights have names, and a stage that
//! takes shadows from all but those.

use anyhow::{Context, Result, ensure};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Every how many lights one casts a shadow.
const STEP: usize = 10;

/// Writes `NAME-tenth.glb` and `NAME-tenth.stage.toml` into `folder`; the path of the stage. The lights of the fields
/// have no names, by which alone a stage can tell them apart, and nothing else is changed.
pub(super) fn write_stage(folder: &Path, model: &Path) -> Result<PathBuf> {
    let name = model.file_stem().unwrap_or_default().to_string_lossy();
    let bytes = std::fs::read(model).with_context(|| format!("reading {}", model.display()))?;
    let named = with_named_lights(&bytes).with_context(|| format!("naming the lights of {}", model.display()))?;
    let copy = format!("{name}-tenth.glb");
    std::fs::write(folder.join(&copy), named).with_context(|| format!("writing {copy}"))?;
    let stage = folder.join(format!("{name}-tenth.stage.toml"));
    let text = format!("model = \"{copy}\"\n\n[[lights]]\nname = \"lamp *\"\ncast = false\n");
    std::fs::write(&stage, text).with_context(|| format!("writing {}", stage.display()))?;
    Ok(stage)
}

/// A GLB file whose lights are called `caster N` if they are every tenth, and else `lamp N`.
fn with_named_lights(glb: &[u8]) -> Result<Vec<u8>> {
    let word = |at: usize| -> Option<usize> {
        let bytes: [u8; 4] = glb.get(at..at + 4)?.try_into().ok()?;
        usize::try_from(u32::from_le_bytes(bytes)).ok()
    };
    ensure!(glb.starts_with(b"glTF") && glb.get(16..20) == Some(b"JSON".as_slice()), "it is no GLB file");
    let json_end = 20 + word(12).context("the file is cut off")?;
    let mut json: Value = serde_json::from_slice(glb.get(20..json_end).context("the file is cut off")?)?;
    let lights = json.pointer_mut("/extensions/KHR_lights_punctual/lights").and_then(Value::as_array_mut);
    for (index, light) in lights.context("it has no lights")?.iter_mut().enumerate() {
        let kind = if index % STEP == 0 { "caster" } else { "lamp" };
        light["name"] = format!("{kind} {index}").into();
    }
    let mut text = serde_json::to_vec(&json)?;
    text.resize(text.len().next_multiple_of(4), b' ');
    let rest = glb.get(json_end..).unwrap_or_default();
    let mut named = b"glTF".to_vec();
    for number in [2, 20 + text.len() + rest.len(), text.len()] {
        named.extend(u32::try_from(number)?.to_le_bytes());
    }
    named.extend(b"JSON");
    named.extend(text);
    named.extend(rest);
    Ok(named)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_tenth_light_is_a_caster_and_the_rest_of_the_file_stays() {
        let lights = ["{\"type\":\"point\"}"; 12].join(",");
        let text = format!("{{\"extensions\":{{\"KHR_lights_punctual\":{{\"lights\":[{lights}]}}}}}}   ");
        let text = &text[..text.len() / 4 * 4];
        let rest = b"\x04\0\0\0BIN\0abcd";
        let length = |length: usize| u32::try_from(length).expect("a length").to_le_bytes();
        let parts: [&[u8]; 7] =
            [b"glTF", &length(2), &length(20 + text.len() + 12), &length(text.len()), b"JSON", text.as_bytes(), rest];
        let named = with_named_lights(&parts.concat()).expect("a file");
        assert_eq!(named[8..12], length(named.len()));
        assert!(named.ends_with(rest) && named.len().is_multiple_of(4));
        let text = String::from_utf8_lossy(&named);
        assert_eq!((text.matches("\"caster ").count(), text.matches("\"lamp ").count()), (2, 10));
        assert!(text.contains("caster 10") && text.contains("lamp 11"));
    }

    #[test]
    fn what_is_no_model_is_an_error() {
        for bytes in [&b""[..], b"glTF", b"glTF\x02\0\0\0\x14\0\0\0\xff\xff\xff\xffJSON"] {
            assert!(with_named_lights(bytes).is_err());
        }
    }
}
