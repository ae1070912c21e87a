//! The archive: its parts by name, with a limit to what they unpack to.

use super::attribute::attribute;
use crate::gltf_file::{LoadError, MAX_FILE_BYTES};
use quick_xml::{Reader, events::Event};
use std::io::{Cursor, Read};
use zip::ZipArchive;

/// The part that names the model.
const RELATIONSHIPS: &str = "_rels/.rels";
/// What the model is usually called.
const USUAL_ROOT: &str = "3D/3dmodel.model";

/// What an archive of a length may unpack to. Models are text that packs to a tenth; what packs to less than a
/// hundredth is made to fill memory.
fn budget_bytes(archive_bytes: u64) -> u64 {
    ((64 << 20) + archive_bytes.saturating_mul(100)).min(MAX_FILE_BYTES)
}

pub(super) struct Package<'a> {
    archive: ZipArchive<Cursor<&'a [u8]>>,
    left_bytes: u64,
}

impl<'a> Package<'a> {
    pub(super) fn open(bytes: &'a [u8]) -> Result<Self, LoadError> {
        let archive = ZipArchive::new(Cursor::new(bytes))
            .map_err(|error| LoadError::malformed("", format!("not a 3MF file: {error}; is it cut off?")))?;
        Ok(Self { archive, left_bytes: budget_bytes(bytes.len() as u64) })
    }

    /// The name of the part that the model begins in.
    pub(super) fn root(&mut self) -> Result<String, LoadError> {
        let target = match self.archive.index_for_name(RELATIONSHIPS) {
            Some(_) => model_target(&self.read(RELATIONSHIPS)?),
            None => None,
        };
        let root = target.unwrap_or_else(|| USUAL_ROOT.into());
        if self.archive.index_for_name(&root).is_some() {
            return Ok(root);
        }
        Err(LoadError::malformed("", format!("not a 3MF file: the archive has no part \"{root}\"")))
    }

    /// The text of a part.
    pub(super) fn read(&mut self, name: &str) -> Result<String, LoadError> {
        String::from_utf8(self.read_bytes(name)?)
            .map_err(|_| LoadError::malformed(&format!("part \"{name}\""), "is not UTF-8 text"))
    }

    /// The bytes of a part.
    pub(super) fn read_bytes(&mut self, name: &str) -> Result<Vec<u8>, LoadError> {
        let wrong = |message: String| LoadError::malformed(&format!("part \"{name}\""), message);
        let file = self.archive.by_name(name).map_err(|error| wrong(error.to_string()))?;
        let mut bytes = Vec::new();
        // What the archive says of lengths is not trusted.
        let read = file.take(self.left_bytes + 1).read_to_end(&mut bytes);
        read.map_err(|error| wrong(format!("cannot be unpacked: {error}")))?;
        let left_bytes = self.left_bytes.checked_sub(bytes.len() as u64);
        self.left_bytes = left_bytes.ok_or_else(|| wrong("unpacks to more than such a file may; split it".into()))?;
        Ok(bytes)
    }
}

/// The target of the relationship to the model.
fn model_target(text: &str) -> Option<String> {
    let mut reader = Reader::from_str(text);
    loop {
        match reader.read_event().ok()? {
            Event::Start(element) | Event::Empty(element) if element.local_name().as_ref() == "Relationship" => {
                let get = |name| attribute(&element, name);
                if get("Type").is_some_and(|kind| kind.ends_with("/3dmodel")) {
                    return get("Target").map(|target| part_name(&target));
                }
            }
            Event::Eof => return None,
            _ => {}
        }
    }
}

/// The name in the archive of a part that another one names.
pub(super) fn part_name(path: &str) -> String {
    path.trim_start_matches('/').to_owned()
}
