// Numbers that look like chance and are the same on every run.

// The finaliser of MurmurHash3.
fn mixed(bits: u32) -> u32 {
    var hash = (bits ^ (bits >> 16u)) * 0x85ebca6bu;
    hash = (hash ^ (hash >> 13u)) * 0xc2b2ae35u;
    return hash ^ (hash >> 16u);
}

// 0 ≤ x < 1.
fn unit_from_bits(bits: u32) -> f32 {
    return f32(bits >> 8u) / 16777216.0;
}

// Another number for every pixel and salt.
fn seed_of_pixel(position_px: vec2f, salt: u32) -> u32 {
    let pixel = vec2u(position_px);
    return mixed((pixel.x * 0x8da6b343u) ^ (pixel.y * 0xd8163841u) ^ mixed(salt));
}

// 0 ≤ x, y < 1: any samples that follow each other lie evenly in the square, by the inverses of the plastic number and of
// its square (Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences").
fn plastic_turn(sample_index: u32) -> vec2f {
    return fract(f32(sample_index) * vec2f(0.7548777, 0.5698403));
}

// 0 ≤ x < 1: spread evenly over any few pixels side by side (Jimenez 2014, "Next Generation Post Processing in Call of
// Duty: Advanced Warfare"), and over the samples of a pixel (by the golden ratio).
fn gradient_noise(position_px: vec2f, sample_index: u32) -> f32 {
    let noise = fract(52.9829189 * fract(dot(floor(position_px), vec2f(0.06711056, 0.00583715))));
    return fract(noise + f32(sample_index) * 0.61803398875);
}

// `reverseBits`, which WebGL 2 has not.
fn bits_reversed(bits: u32) -> u32 {
    var out = ((bits >> 1u) & 0x55555555u) | ((bits & 0x55555555u) << 1u);
    out = ((out >> 2u) & 0x33333333u) | ((out & 0x33333333u) << 2u);
    out = ((out >> 4u) & 0x0f0f0f0fu) | ((out & 0x0f0f0f0fu) << 4u);
    out = ((out >> 8u) & 0x00ff00ffu) | ((out & 0x00ff00ffu) << 8u);
    return (out >> 16u) | (out << 16u);
}

// Flips every bit by a hash of the bits below it (Laine & Karras 2011): of reversed bits, Owen's scrambling.
fn bits_scrambled(bits: u32, seed: u32) -> u32 {
    var out = bits + seed;
    out ^= out * 0x6c50b47cu;
    out ^= out * 0xb82f1e52u;
    out ^= out * 0xc7afe638u;
    return out ^ (out * 0x8d22f6e6u);
}

// 0 ≤ x < 1. Of 2ⁿ samples one lies in each 2ⁿ-th part, in another order for every seed, so that what two seeds give is
// as good as independent (Burley 2020, "Practical Hash-based Owen Scrambling": the first dimension of Sobol's sequence,
// scrambled, of a shuffled index).
fn stratified(sample_index: u32, seed: u32) -> f32 {
    let shuffled = bits_reversed(bits_scrambled(bits_reversed(sample_index), seed));
    return unit_from_bits(bits_reversed(bits_scrambled(shuffled, mixed(seed))));
}
