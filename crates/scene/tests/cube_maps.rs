//! Environments in KTX2 containers: every format, levels, and what is no cube map.

use glam::Vec3;
use half::f16;
use manypass_scene::EnvironmentMap;
use manypass_testkit::ktx2::cube_map;

fn first(bytes: &[u8]) -> [f32; 3] {
    let map = EnvironmentMap::decode("a.ktx2", bytes).expect("an environment");
    let [r, g, b, _] = map.texels[0].map(f16::to_f32);
    [r, g, b]
}

#[test]
fn every_format_is_read() {
    let halves = |values: &[f32]| values.iter().flat_map(|value| f16::from_f32(*value).to_le_bytes()).collect();
    let floats = |values: &[f32]| values.iter().flat_map(|value| value.to_le_bytes()).collect();
    let words = |word: u32| word.to_le_bytes().to_vec();
    // 1.5, 3 and 0.25: exponents 15, 16 and 13, mantissas of a half, a half and nothing.
    let packed = (15 << 6 | 32) | (16 << 6 | 32) << 11 | (13 << 5) << 22;
    // In units of 2^(18 - 24).
    let shared = 96u32 | 192 << 9 | 16 << 18 | 18 << 27;
    let cases: [(u32, Vec<u8>, [f32; 3]); 8] = [
        (37, vec![255, 51, 0, 9], [1.0, 0.2, 0.0]),
        (29, vec![255, 188, 0], [1.0, 0.5029, 0.0]),
        (90, halves(&[1.5, 3.0, 0.25]), [1.5, 3.0, 0.25]),
        (97, halves(&[1.5, 3.0, 0.25, 1.0]), [1.5, 3.0, 0.25]),
        (106, floats(&[1.5, 3.0, 0.25]), [1.5, 3.0, 0.25]),
        (109, floats(&[1.5, f32::NAN, 0.25, 1.0]), [1.5, 0.0, 0.25]),
        (122, words(packed), [1.5, 3.0, 0.25]),
        (123, words(shared), [1.5, 3.0, 0.25]),
    ];
    for (format, texel, expected) in cases {
        let found = first(&cube_map(format, 4, 1, |_| texel.clone()));
        let close = found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-3);
        assert!(close, "{format}: {found:?}");
    }
}

#[test]
fn levels_are_roughness() {
    let texel = |level: u32| [level as f32, 1.0, 0.0, 1.0].iter().flat_map(|value| value.to_le_bytes()).collect();
    let map = EnvironmentMap::decode("a.ktx2", &cube_map(109, 16, 5, texel)).expect("an environment");
    let prefiltered = map.prefiltered.expect("levels");
    for (roughness, expected) in [(0.0, 0.0), (0.25, 1.0), (0.625, 2.5), (1.0, 4.0)] {
        let found = prefiltered.reflected(Vec3::new(0.6, 0.0, 0.8), roughness);
        assert!((found - Vec3::new(expected, 1.0, 0.0)).length() < 1e-5, "{roughness}: {found}");
    }
    let one = EnvironmentMap::decode("a.ktx2", &cube_map(109, 16, 1, texel)).expect("an environment");
    assert!(one.prefiltered.is_none());
}

#[test]
fn what_is_no_cube_map_is_refused() {
    let texel = |_| vec![0; 8];
    let refused = |bytes: &[u8]| EnvironmentMap::decode("a.ktx2", bytes).expect_err("refused").to_string();
    let whole = cube_map(97, 8, 4, texel);
    for length in (0..whole.len()).step_by(37) {
        assert!(EnvironmentMap::decode("a.ktx2", &whole[..length]).is_err(), "{length} bytes");
    }
    let changed = |word: usize, value: u32| {
        let mut bytes = whole.clone();
        bytes[12 + 4 * word..16 + 4 * word].copy_from_slice(&value.to_le_bytes());
        bytes
    };
    for (word, value, said) in [
        (0, 145, "format 145"),
        (2, 16, "square"),
        (2, 0, "square"),
        (6, 1, "no cube map"),
        (7, 5, "5 levels"),
        (7, u32::MAX, "levels"),
        (8, 3, "supercompression"),
    ] {
        assert!(refused(&changed(word, value)).contains(said), "{}", refused(&changed(word, value)));
    }
}
