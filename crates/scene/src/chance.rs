//! Numbers by chance that are the same everywhere.

/// 0 ≤ x < 1 of two numbers: the finaliser of MurmurHash3 (Appleby 2011).
pub(crate) fn unit(a: u32, b: u32) -> f32 {
    let mut hash = a.wrapping_mul(0x9e37_79b9) ^ b.wrapping_mul(0x7feb_352d);
    hash = (hash ^ (hash >> 16)).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ (hash >> 13)).wrapping_mul(0xc2b2_ae35);
    ((hash ^ (hash >> 16)) >> 8) as f32 / (1u32 << 24) as f32
}
