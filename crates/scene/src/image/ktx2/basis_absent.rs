//! Stands in for the transcoder where the feature `ktx2` is off.

use crate::BlockFormat;

pub(super) fn texels(_bytes: &[u8]) -> Result<Vec<u8>, String> {
    Err("it holds Basis Universal or ASTC, and this program was built without the feature `ktx2`".into())
}

pub(super) const fn levels(_bytes: &[u8], _count: u32, _format: BlockFormat) -> Option<Vec<Vec<u8>>> {
    None
}
