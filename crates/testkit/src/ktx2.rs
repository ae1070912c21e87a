//! KTX2 containers as a test wants them.

/// A cube map of `side` texels a side without compression, whose levels are filled by `texel`, from the level. `format`
/// is a number of Vulkan.
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

/// A picture of `size`, whose levels hold these bytes. `format` is a number of Vulkan; with 0 the levels are blocks of
/// UASTC, sRGB with alpha.
pub fn picture(format: u32, size: [u32; 2], supercompression: u32, levels: &[&[u8]]) -> Vec<u8> {
    let descriptor = 80 + 24 * levels.len() as u32;
    let mut data = b"\xabKTX 20\xbb\r\n\x1a\n".to_vec();
    let mut words = |words: &[u32]| data.extend(words.iter().flat_map(|word| word.to_le_bytes()));
    words(&[format, 1, size[0], size[1], 0, 0, 1, levels.len() as u32, supercompression]);
    words(&[descriptor, 44, 0, 0, 0, 0, 0, 0]);
    let mut offset = descriptor + 44;
    for level in levels {
        words(&[offset, 0, level.len() as u32, 0, level.len() as u32, 0]);
        offset += level.len() as u32;
    }
    // The descriptor: UASTC (166), sRGB, blocks of 4 × 4 texels in 16 bytes, one sample with alpha.
    words(&[44, 0, 2 | (40 << 16), 166 | (1 << 8) | (2 << 16), 0x0303, 16, 0, (127 << 16) | (3 << 24), 0, 0, u32::MAX]);
    levels.iter().for_each(|level| data.extend_from_slice(level));
    data
}

/// A block of UASTC of one colour: its mode, 8, is 10111 in binary, and the four bytes follow.
pub fn solid_block([red, green, blue, alpha]: [u8; 4]) -> [u8; 16] {
    let color = u128::from(u32::from_le_bytes([red, green, blue, alpha]));
    (0b10111 | (color << 5)).to_le_bytes()
}
