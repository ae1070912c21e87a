//! What is new in an array that the device holds already.

use std::ops::Range;

/// Parts that lie nearer to each other are written as one: a write costs more than so many bytes.
const GAP_BYTES: usize = 1024;

/// The parts of `new` in bytes, whole units each, that differ from what `old` has there.
pub(crate) fn changed_parts(old: &[u8], new: &[u8], unit_bytes: usize) -> Vec<Range<usize>> {
    let mut parts: Vec<Range<usize>> = Vec::new();
    let (common, added) = new.split_at(new.len().min(old.len()) / unit_bytes * unit_bytes);
    let mut add = |part: Range<usize>| match parts.last_mut() {
        Some(last) if part.start < last.end + GAP_BYTES => last.end = part.end,
        _ => parts.push(part),
    };
    // Most of it stays as it is: blocks are compared before their units.
    let block_bytes = (4096 / unit_bytes).max(1) * unit_bytes;
    for (index, block) in common.chunks(block_bytes).enumerate() {
        let at = index * block_bytes;
        if old[at..at + block.len()] == *block {
            continue;
        }
        for (index, unit) in block.chunks(unit_bytes).enumerate() {
            let at = at + index * unit_bytes;
            if old[at..at + unit.len()] != *unit {
                add(at..at + unit.len());
            }
        }
    }
    if !added.is_empty() {
        add(common.len()..new.len());
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_differs_is_written() {
        let old = vec![7u8; 40_000];
        assert!(changed_parts(&old, &old, 8).is_empty());
        assert!(changed_parts(&old, &old[..16], 8).is_empty());
        let mut new = old.clone();
        new[100] = 1;
        new[300] = 1;
        new[20_001] = 1;
        assert_eq!(changed_parts(&old, &new, 8), [96..304, 20_000..20_008]);
        new.extend([1; 24]);
        assert_eq!(changed_parts(&old, &new, 8), [96..304, 20_000..20_008, 40_000..40_024]);
        assert_eq!(changed_parts(&[], &new, 8), vec![0..40_024]);
    }
}
