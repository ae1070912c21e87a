//! What is said of effects that cannot be drawn.

use super::{READER, WRITER, drawn, effects};
use manypass::EffectFile;

fn error(sources: &[&str]) -> String {
    let files: Vec<EffectFile> = sources.iter().map(|source| EffectFile::parse("mine.wgsl", source).unwrap()).collect();
    EffectFile::check_chain(&files).unwrap_err().to_string()
}

#[test]
fn what_cannot_be_read_is_said() {
    let other = |name: &str, reads: &str, texture: &str| {
        let variable = reads.replace('.', "_");
        format!(
            "//! effect {name}
            //! reads: {reads}
            //! passes: fs_a -> {texture}, fs_b
            @fragment fn fs_a(@builtin(position) p: vec4f) -> @location(0) vec4f {{ return textureLoad({variable}, vec2i(0), 0); }}
            @fragment fn fs_b(@builtin(position) p: vec4f) -> @location(0) vec4f {{ return textureLoad({texture}, vec2i(0), 0); }}"
        )
    };
    let (a, b) = (other("a", "b.y", "x"), other("b", "a.x", "y"));
    let circle = error(&[&a, &b]);
    assert!(circle.contains("a reads of b reads of a"), "{circle}");
    let alone = error(&[READER]);
    assert!(alone.contains("`reader`") && alone.contains("no effect `writer`"), "{alone}");
    let wrong = error(&[&other("c", "writer.whole", "x"), WRITER]);
    assert!(wrong.contains("`writer` writes no texture `whole`; it writes: half"), "{wrong}");
    let off: Vec<EffectFile> = [WRITER, READER]
        .iter()
        .map(|source| {
            let mut file = EffectFile::parse("mine.wgsl", source).unwrap();
            if source == &WRITER {
                file.set("writer.enabled", "false").unwrap();
            }
            file
        })
        .collect();
    let off = EffectFile::check_chain(&off).unwrap_err().to_string();
    assert!(off.contains("`writer` is off; set writer.enabled=true, or reader.enabled=false"), "{off}");
    let display = "//! effect shown
        //! reads: display, writer.half
        @fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f {
            return display_at(vec2i(p.xy)) + textureLoad(writer_half, vec2i(0), 0);
        }";
    let sides = error(&[WRITER, display]);
    assert!(sides.contains("two sides of the tone curve"), "{sides}");
    let parse = |source: &str| EffectFile::parse("mine.wgsl", source).unwrap_err().to_string();
    let main = "@fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f";
    for (source, expected) in [
        ("//! pixel: no\nfn f() {}".to_owned(), "mine.wgsl:1:12: error: there is no function `no`"),
        ("//! pixel: 2d".to_owned(), "mine.wgsl:1:12: error: this is not the name of a function"),
        (
            "//! pixel: f\nfn f(c: vec4f) -> vec4f { return c; }".to_owned(),
            "mine.wgsl:2:4: error: `f` is not a pixel function",
        ),
        (
            "//! pixel: f\nfn f(c: vec4f, p: vec2f) -> vec4f { return radiance_at(vec2i(p)); }".to_owned(),
            "mine.wgsl:2:4: error: `f` reads `radiance`",
        ),
        (
            format!("//! pixel: f\nfn f(c: vec4f, p: vec2f) -> vec4f {{ return c; }}\n{main} {{ return vec4f(1.0); }}"),
            "has neither `//! passes:` nor `@fragment` functions",
        ),
        (
            format!("{main} {{ var x = 0.0;\n  loop {{ x += 1.0; }}\n return vec4f(x); }}"),
            "mine.wgsl:2:3: error: this loop never ends",
        ),
        (
            format!(
                "fn f() {{ var i = 0; loop {{ loop {{ i++; if i > 4 {{ break; }} }} }} }}\n{main} {{ f(); return vec4f(1.0); }}"
            ),
            "mine.wgsl:1:21: error: this loop never ends",
        ),
        (format!("{main} {{\n  while true {{ }}\n return p; }}"), "mine.wgsl:2:3: error: this loop never ends"),
        (format!("{main} {{ for (var i = 0; 1 < 2; i++) {{ }} return p; }}"), "error: this loop never ends"),
        (format!("const GO_ON = true;\n{main} {{ while GO_ON {{ }} return p; }}"), "error: this loop never ends"),
        (format!("{main} {{ loop {{ if false {{ break; }} }} return p; }}"), "error: this loop never ends"),
        (
            format!("{main} {{ var i = 0; loop {{ i++; continuing {{ break if false; }} }} return p; }}"),
            "error: this loop never ends",
        ),
        (format!("//! reads: glow.\n{main} {{ return vec4f(1.0); }}"), "there is no `glow.` to read"),
        (
            format!("//! reads: glow.wide\nvar<private> glow_wide: f32;\n{main} {{ return vec4f(glow_wide); }}"),
            "is called `glow_wide` in the shader, which is declared already",
        ),
        (
            format!("{main} {{ return textureLoad(occlusion, vec2i(0), 0); }}"),
            "`//! reads: occlusion` (or `motion`, or `ids`) in the header declares it",
        ),
    ] {
        let found = parse(&source);
        assert!(found.contains(expected), "{source}\n{found}\nshould say {expected}");
    }
    for body in [
        "loop { if p.x > 1.0 { break; } }",
        "for (;;) { switch i32(p.x) { default { return p; } } }",
        "while p.x > 2.0 { }",
        "while true { if p.x > 1.0 { break; } }",
        "while true { return p; }",
        "for (var i = 0; true; i++) { if i > 4 { break; } }",
        "while false { }",
        "var i = 0; loop { i++; continuing { break if i > 4; } }",
    ] {
        EffectFile::parse("mine.wgsl", &format!("{main} {{ {body} return p; }}"))
            .unwrap_or_else(|error| panic!("{error}"));
    }
}

#[test]
fn a_word_too_many_in_reads_is_a_warning_and_asks_nothing_of_the_frame() {
    let (mut renderer, scene, mut request) = drawn();
    let main =
        "@fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f { return radiance_at(vec2i(p.xy)); }";
    let exact = format!("//! reads: radiance\n{main}");
    let needless = format!("//! reads: radiance, ids, glow.wide\n{main}");
    assert!(EffectFile::parse("mine.wgsl", &exact).unwrap().warnings().is_empty());
    assert_eq!(
        EffectFile::parse("mine.wgsl", &needless).unwrap().warnings(),
        [
            "mine.wgsl:1:5: the shader does not read ids, glow.wide; `//! reads: radiance` is right, and the line may be left out"
        ]
    );
    // Neither is there an effect `glow`, nor are ids drawn.
    let [exact, needless] = [exact, needless].map(|source| {
        request.effects = effects(&renderer, &[&source]);
        renderer.plan(&scene, &request).unwrap().to_text()
    });
    assert_eq!(exact, needless);
    renderer.render(&scene, &request).unwrap();
}
