//! The largest picture of the environment that is read, in a process of its own, because it says how much memory that
//! takes.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use manypass_scene::EnvironmentMap;
use manypass_scene::environment::WIDTH_MAX;

/// A Radiance file in runs: 8.5 MB. The upper half has the radiance 1, the lower one 0.25.
fn file(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    let row = |texel: [u8; 4]| {
        let mut row = vec![2, 2, (width >> 8) as u8, width as u8];
        for channel in texel {
            let mut left = width;
            while left > 0 {
                let run = left.min(127);
                row.extend([128 + run as u8, channel]);
                left -= run;
            }
        }
        row
    };
    let [upper, lower] = [row([128, 128, 128, 129]), row([128, 128, 128, 127])];
    (0..height).for_each(|y| bytes.extend(if y < height / 2 { &upper } else { &lower }));
    bytes
}

/// What this process took at most, in bytes, where the system says so.
fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix(" kB")?.parse::<u64>().ok().map(|kibibytes| 1024 * kibibytes)
}

#[test]
fn the_largest_picture_is_made_smaller_in_bounded_memory() {
    let bytes = file(WIDTH_MAX, WIDTH_MAX / 2);
    let map = EnvironmentMap::decode("large.hdr", &bytes).unwrap();
    assert_eq!((map.width, map.height), (4096, 2048));
    assert!(map.notes[0].contains("\"large.hdr\": 16384x8192 is made smaller, 4096x2048"), "{:?}", map.notes);
    let at = |x: usize, y: usize| map.texels[y * 4096 + x][0].to_f32();
    assert_eq!([at(0, 0), at(4095, 1023), at(0, 1024), at(4095, 2047)], [1.0, 1.0, 0.25, 0.25]);
    // What is decoded is three floats a texel.
    if let Some(peak) = peak_bytes() {
        println!("{:.2} GiB", peak as f64 / f64::from(1 << 30));
        assert!(peak < (16_384 * 8192 * 12) + (256 << 20), "{peak} bytes");
    }
    let too_large = file(WIDTH_MAX * 2, 1);
    let refused = EnvironmentMap::decode("larger.hdr", &too_large).unwrap_err().to_string();
    assert!(refused.contains("32768x1 pixels cannot be read, at most 16384x8192"), "{refused}");
}

#[test]
fn the_smallest_picture_is_read() {
    let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n".to_vec();
    bytes.extend([128, 64, 32, 129]);
    let map = EnvironmentMap::decode("small.hdr", &bytes).unwrap();
    assert_eq!((map.width, map.height, map.notes.len()), (1, 1, 0));
    assert_eq!(map.texels[0].map(|value| value.to_f32()), [1.0, 0.5, 0.25, 1.0]);
}
