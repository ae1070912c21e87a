//! KTX2 containers as a test wants them.

/// A cube map of `side` texels a side without compression, whose levels are filled by `texel`, from the level. `format` is a number
/// of Vulkan.
pub fn cube_map(format: u32, side: u32, levels: u32, texel: impl Fn(u32) -> Vec<u8>) -> Vec<u8> {
    let mut bytes = b"\xabKTX 20\xbb\r\n\x1a\n".to_vec();
    let words = [format, 1, side, side, 0, 0, 6, levels, 0];
    words.iter().for_each(|word: &u32| bytes.extend(word.to_le_bytes()));
    bytes.resize(80, 0);
    let index_end = 80 + 24 * levels as usize;
    let mut data = Vec::new();
    for level in 0..levels {
        let count = 6 * (side >> level).max(1).pow(2);
        let of_level: Vec<u8> = (0..count).flat_map(|_| texel(level)).collect();
        for number in [index_end + data.len(), of_level.len(), of_level.len()] {
            bytes.extend((number as u64).to_le_bytes());
        }
        data.extend(of_level);
    }
    bytes.extend(data);
    bytes
}
