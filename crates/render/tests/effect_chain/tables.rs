//! Tables of colours as effects.

use super::drawn;
use manypass::{Effect, EffectFile, WgslEffect};
use std::sync::Arc;

/// A table of colours of so many along each side, or a curve.
fn cube(size: usize, is_solid: bool, color: impl Fn([f32; 3]) -> [f32; 3]) -> String {
    let at = |index: usize| index as f32 / (size - 1) as f32;
    let count = if is_solid { size.pow(3) } else { size };
    let places = (0..count).map(|index| {
        if is_solid { [at(index % size), at(index / size % size), at(index / size / size)] } else { [at(index); 3] }
    });
    let lines: String = places.map(color).map(|[r, g, b]| format!("{r} {g} {b}\n")).collect();
    format!("TITLE \"test\"\n# A remark.\nLUT_{}D_SIZE {size}\n{lines}", if is_solid { 3 } else { 1 })
}

#[test]
fn a_table_of_colours_changes_what_displays_show() {
    let (mut renderer, scene, mut request) = drawn();
    request.settings.tone_map.dither = 0.0;
    let mut picture = |cubes: &[(&str, String)]| {
        let table = |(file, text): &(&str, String)| {
            Arc::new(WgslEffect::new(renderer.gpu(), file, text).unwrap_or_else(|error| panic!("{error}")))
                as Arc<dyn Effect>
        };
        request.effects = cubes.iter().map(table).collect();
        renderer.render(&scene, &request).unwrap();
        renderer.read_display().unwrap()
    };
    let plain = picture(&[]);
    let most = |found: &[u8], expected: &dyn Fn(&[u8]) -> [f32; 3]| {
        let pixels = found.chunks_exact(4).zip(plain.chunks_exact(4));
        let off = pixels.map(|(found, plain)| {
            let expected = expected(plain);
            (0..3).map(|i| (f32::from(found[i]) - expected[i]).abs()).fold(0.0, f32::max)
        });
        off.fold(0.0, f32::max)
    };
    let same = |p: &[u8]| [p[0], p[1], p[2]].map(f32::from);
    for (size, is_solid) in [(2, true), (17, true), (33, true), (2, false), (4096, false)] {
        let found = picture(&[("2 same.cube", cube(size, is_solid, |color| color))]);
        assert!(most(&found, &same) <= 1.0, "{size} {is_solid}");
    }
    // Linear in the channels: exact within a tetrahedron of any of the six kinds.
    let mixed = |[r, g, b]: [f32; 3]| [0.5 * g + 0.25 * b, 1.0 - r, 0.2 * r + 0.7 * b];
    let found = picture(&[("mixed.cube", cube(5, true, mixed))]);
    let expected =
        |p: &[u8]| mixed([p[0], p[1], p[2]].map(|value| f32::from(value) / 255.0)).map(|value| value * 255.0);
    assert!(most(&found, &expected) <= 1.5, "{}", most(&found, &expected));
    let found = picture(&[
        ("a.cube", cube(5, true, |[r, g, b]| [g, b, r])),
        ("b.CUBE", cube(9, false, |[r, ..]| [1.0 - r; 3])),
    ]);
    let expected = |p: &[u8]| [p[1], p[2], p[0]].map(|value| 255.0 - f32::from(value));
    assert!(most(&found, &expected) <= 1.5, "{}", most(&found, &expected));
    let plan = renderer.plan(&scene, &request).unwrap().to_text();
    assert!(plan.contains("a+b"), "{plan}");
    let domain = cube(3, true, |color| color).replace("LUT_3D", "DOMAIN_MIN 0 0 0\nDOMAIN_MAX 0.5 0.5 0.5\nLUT_3D");
    let mut wide = EffectFile::parse("wide.cube", &domain).unwrap();
    wide.set("wide.strength", "0.5").unwrap();
    assert!(
        EffectFile::parse("wide.cube", "LUT_3D_SIZE 2\n").unwrap_err().to_string().starts_with("wide.cube:1:1: error")
    );
}
