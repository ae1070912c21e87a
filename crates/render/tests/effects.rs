//! Effects: what they may read, and that a wrong one is an error that names file, line and name; never a panic.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common;
use manypass::{Background, FrameRequest, Path, Renderer, Target, WgslEffect};
use manypass_testkit::compare::Picture;
use manypass_testkit::scenes;
use std::sync::Arc;

/// The whole of an effect but its body.
fn effect(renderer: &Renderer, body: &str) -> Result<WgslEffect, String> {
    let source = format!("@fragment\nfn fs(@builtin(position) position: vec4f) -> @location(0) vec4f {{\n{body}\n}}\n");
    WgslEffect::new(renderer.gpu(), "folder/mine.wgsl", &source).map_err(|error| error.to_string())
}

/// Shows red where radiance was, and says so.
#[derive(Debug)]
struct RedPass;

impl manypass::Effect for RedPass {
    fn record<'f>(
        &'f self,
        r: &mut manypass::Recorder<'_, 'f>,
        _: Option<&manypass::Gbuffer>,
        radiance: manypass::graph::Handle,
    ) -> Result<manypass::graph::Handle, manypass::shader::ProgramError> {
        let red = wgpu::Color { r: 1.0, g: 0.0, b: 0.0, a: 1.0 };
        r.legend("reddened", vec![legend_of_red()]);
        Ok(r.graph.pass("reddened").color(radiance, manypass::graph::ColorLoad::Clear(red)))
    }
}

fn legend_of_red() -> manypass::LegendEntry {
    manypass::LegendEntry { label: "what was reddened".into(), color_srgb: [255, 0, 0] }
}

#[test]
fn the_picture_of_a_pass_has_the_legend_that_the_pass_declares() {
    let scene = manypass_testkit::scenes::one_light_on_one_plane().scene;
    let mut renderer = common::renderer();
    renderer.load(&scene).unwrap();
    let mut request = common::plain_request(&scene, (16, 16));
    request.effects = vec![Arc::new(RedPass)];
    let pictures = renderer.passes(&scene, &request).unwrap();
    let (with, without): (Vec<_>, Vec<_>) = pictures.iter().partition(|picture| !picture.legend.is_empty());
    let [reddened] = &with[..] else { panic!("{} legends", with.len()) };
    assert!(reddened.name.starts_with("reddened") && reddened.legend == [legend_of_red()]);
    assert_eq!(reddened.rgba8[..4], [255, 0, 0, 255]);
    assert!(!without.is_empty());
}

#[test]
fn every_variable_of_the_frame_can_be_read() {
    let test = scenes::sun();
    let mut renderer = common::renderer();
    renderer.load(&test.scene).unwrap();
    let mut request = common::plain_request(&test.scene, (64, 48));
    let plain = picture(&mut renderer, &test.scene, &request);
    let mut seen: Vec<Picture> = Vec::new();
    for body in [
        "return vec4f(radiance_at(vec2i(position.xy)).brg, 1.0);",
        "return vec4f(surface_at(vec2i(position.xy)).normal_world * 0.5 + 0.5, 1.0);",
        "return vec4f(vec3f(0.1 * distance_at(vec2i(position.xy))), 1.0);",
        "return vec4f(surface_at(vec2i(position.xy)).base_color, 1.0);",
        "return vec4f(vec3f(textureLoad(material, vec2i(position.xy), 0).g), 1.0);",
        "return textureSampleLevel(radiance, linear_clamp, uv_from_pixel(position.yx), 0.0);",
        "return textureSampleLevel(linear_depth, nearest_clamp, uv_from_pixel(position.xy), 0.0);",
        "return vec4f(fract(position_world_from_pixel(position.xy, distance_at(vec2i(position.xy)))), 1.0);",
    ] {
        request.effects = vec![Arc::new(effect(&renderer, body).unwrap())];
        let found = picture(&mut renderer, &test.scene, &request);
        assert!(found != plain && !seen.contains(&found), "{body}");
        seen.push(found);
    }
    // A chain: swapping red and green twice gives the picture back.
    let swap = "return radiance_at(vec2i(position.xy)).grba;";
    request.effects = vec![Arc::new(effect(&renderer, swap).unwrap()), Arc::new(effect(&renderer, swap).unwrap())];
    assert_eq!(picture(&mut renderer, &test.scene, &request), plain);
    // The forward path has radiance, and no G-buffer.
    request.settings.render.path = Path::Forward;
    picture(&mut renderer, &test.scene, &request);
    request.effects =
        vec![Arc::new(effect(&renderer, "return surface_at(vec2i(position.xy)).normal_world.xyzz;").unwrap())];
    let error = renderer.render(&test.scene, &request).unwrap_err().to_string();
    assert!(error.starts_with("the effect `mine` cannot be used here: it reads `"), "{error}");
    assert!(error.contains("`normal`") || error.contains("`base_color`"), "{error}");
}

fn picture(renderer: &mut Renderer, scene: &manypass::scene::Scene, request: &FrameRequest) -> Picture {
    renderer.render(scene, request).unwrap();
    Picture::from_rgba8(request.width as usize, request.height as usize, &renderer.read_display().unwrap())
}

#[test]
fn a_wrong_effect_is_an_error_that_says_where() {
    let renderer = common::renderer();
    let gpu = renderer.gpu();
    let main = "@fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f {";
    for (source, expected) in [
        ("", "mine.wgsl:1:1: error: an effect has an entry point"),
        ("this is not WGSL", "mine.wgsl:1:1"),
        (&format!("{main}\n\n    return radianc_at(vec2i(p.xy)); }}"), "mine.wgsl:3:12"),
        (&format!("{main}\n    return vec3f(1.0); }}"), "mine.wgsl:2"),
        (&format!("{main} loop {{ }} }}"), "mine.wgsl"),
        ("@compute @workgroup_size(1) fn cs() {}", "mine.wgsl:1:32: error: the entry point `cs` is not a `@fragment`"),
        (
            &format!("{main} return vec4f(1.0); }}\n@fragment fn two() {{}}"),
            "mine.wgsl:2:14: error: `two` has to return `@location(0) vec4f`",
        ),
        ("@fragment fn fs(@location(0) uv: vec2f) -> @location(0) vec4f { return uv.xyxy; }", "takes nothing but"),
        ("@fragment fn fs() -> @location(1) vec4f { return vec4f(1.0); }", "`@location(0) vec4f`"),
        ("@fragment fn fs() -> @location(0) vec4u { return vec4u(1); }", "`@location(0) vec4f`"),
        ("@fragment fn fs() -> @builtin(frag_depth) f32 { return 1.0; }", "`@location(0) vec4f`"),
        (&format!("override x: f32;\n{main} return vec4f(x); }}"), "override"),
        (
            &format!("\n@group(1) @binding(9) var t: texture_2d<f32>;\n{main} return textureLoad(t, vec2i(0), 0); }}"),
            "mine.wgsl:2:27: error: `t` in group 1",
        ),
        (&format!("@group(7) @binding(0) var<uniform> u: f32;\n{main} return vec4f(u); }}"), "`u` in group 7"),
        (&format!("@group(2) @binding(0) var<storage> b: f32;\n{main} return vec4f(b); }}"), "mine.wgsl:1:"),
        (&format!("{main} return textureSampleLevel(linear_depth, linear_clamp, p.xy, 0.0); }}"), "cannot be filtered"),
        (&format!("var<private> radiance: f32;\n{main} return vec4f(radiance); }}"), "mine.wgsl:1"),
    ] {
        let error = WgslEffect::new(gpu, "mine.wgsl", source).map(drop).unwrap_err().to_string();
        assert!(error.starts_with("mine.wgsl:"), "{source}:\n{error}");
        assert!(error.contains(": error: ") && error.contains(expected), "{source}:\n{error}\nshould say {expected}");
    }
    gpu.check().unwrap();
}

#[test]
fn uniforms_are_set_by_name_and_size() {
    let test = scenes::sun();
    let mut renderer = common::renderer();
    renderer.load(&test.scene).unwrap();
    let source = "@group(2) @binding(1) var<uniform> tint: vec4f;
        @group(2) @binding(0) var<uniform> scale: f32;
        @fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f { return tint * scale; }";
    let effect = Arc::new(WgslEffect::new(renderer.gpu(), "tint", source).unwrap());
    assert_eq!(effect.name(), "tint");
    for (name, size, expected) in [("tnit", 16, "scale"), ("tint", 12, "16 bytes"), ("scale", 16, "4 bytes")] {
        let error = effect.set_uniform(name, &vec![0; size]).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains(expected), "{error}");
    }
    let mut request = common::plain_request(&test.scene, (8, 8));
    request.effects = vec![effect.clone()];
    let error = renderer.render(&test.scene, &request).unwrap_err().to_string();
    assert!(error.starts_with("tint:1:36: error: `tint` has neither a default nor a value"), "{error}");
    effect.set("tint.scale", "0.5").unwrap();
    effect.set_uniform("tint", bytemuck::cast_slice(&[1f32, 2.0, 3.0, 2.0])).unwrap();
    renderer.render(&test.scene, &request).unwrap();
    assert!(renderer.read_radiance().unwrap().chunks(4).all(|pixel| pixel == [0.5, 1.0, 1.5, 1.0]));
    // Another device's effect is refused.
    let mut other = common::renderer();
    other.load(&test.scene).unwrap();
    let error = other.render(&test.scene, &request).unwrap_err().to_string();
    assert!(error.contains("another device"), "{error}");
}

/// Members at offsets that only the rules of WGSL give: a vec3f starts at a multiple of 16 bytes.
const SETTINGS: &str = "//! effect many
//! reads: radiance
struct Inner {
    /// A whole number, things
    // = 3 in 0..10
    count: u32,
    // = -2
    offset: i32,
}
struct Style {
    // = 0.25 in 0..1
    first: f32,
    /// A colour, linear
    // = 0.5, 0.25, 0.125 in 0..1
    color: vec3f,
    last: f32,
    padding: vec2f,
    @align(16) @size(16) inner: Inner,
    _more: vec4f,
    // = 1, 2
    pair: vec2i,
}
@group(2) @binding(0) var<uniform> style: Style;
// = 0.75
@group(2) @binding(1) var<uniform> first: f32;
// Never used, so it needs no value.
@group(2) @binding(2) var<uniform> idle: vec4f;

@fragment
fn fs(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let whole = f32(style.inner.count) + f32(style.inner.offset) + f32(style.pair.x * style.pair.y);
    let here = radiance_at(vec2i(position.xy)) * 0.0;
    return here + select(vec4f(style.color, style.first), vec4f(first, style.last, whole, 1.0), position.x < 1.0);
}
";

#[test]
fn members_of_uniforms_are_settings_with_defaults_and_ranges() {
    let test = scenes::sun();
    let mut renderer = common::renderer();
    renderer.load(&test.scene).unwrap();
    let effect = Arc::new(WgslEffect::new(renderer.gpu(), "folder/file.wgsl", SETTINGS).unwrap());
    assert_eq!(effect.name(), "many");
    let settings = effect.settings();
    let keys: Vec<&str> = settings.iter().map(|info| &*info.key).collect();
    let expected =
        ["many.style.first", "many.color", "many.last", "many.count", "many.offset", "many.pair", "many.first"];
    assert_eq!(keys, [&expected[..], &["many.idle", "many.enabled"]].concat());
    let json = serde_json::to_value(&effect.settings()[1]).unwrap();
    let info = serde_json::json!({ "key": "many.color", "type": "vec3f", "default": [0.5, 0.25, 0.125], "min": 0.0, "max": 1.0,
        "choices": [], "unit": "linear", "needs": ["many.enabled=true"], "doc": "A colour" });
    assert_eq!(json, info);
    let json = serde_json::to_value(&effect.settings()[3]).unwrap();
    assert!(json["default"] == 3 && json["type"] == "u32" && json["unit"] == "things" && json["max"] == 10.0, "{json}");

    let mut request = common::plain_request(&test.scene, (2, 1));
    request.settings.background.source = Background::Transparent;
    request.effects = vec![effect.clone()];
    let error = renderer.render(&test.scene, &request).unwrap_err().to_string();
    assert!(error.starts_with("folder/file.wgsl:16:5: error: `last` has neither a default nor a value"), "{error}");
    effect.set("many.last", " 0.5").unwrap();
    let mut drawn = || {
        renderer.render(&test.scene, &request).unwrap();
        renderer.read_radiance().unwrap()
    };
    assert_eq!(drawn(), [0.75, 0.5, 3.0, 1.0, 0.5, 0.25, 0.125, 0.25]);
    // The whole path is a key too, so that a script can be written for files that are not there yet.
    for (key, value) in [
        ("many.style.color", "1,0.5,0"),
        ("many.style.first", "1"),
        ("many.first", "7.5"),
        ("many.style.inner.count", "10"),
        ("many.offset", "-4"),
        ("many.pair", "2,-3"),
    ] {
        effect.set(key, value).unwrap();
    }
    assert_eq!(drawn(), [7.5, 0.5, 0.0, 1.0, 1.0, 0.5, 0.0, 1.0]);
    assert_eq!(effect.values()[5], ("many.pair".into(), manypass::SettingValue::Integers(vec![2, -3])));
    for (key, value, expected) in [
        (
            "many.color",
            "1,2,3",
            "`1,2,3` is not a value of `many.color`, which takes 3 numbers with commas between, each from 0 to 1",
        ),
        ("many.color", "1", "3 numbers"),
        ("many.last", "1,1", "takes a number"),
        ("many.last", "nan", "takes a number"),
        ("many.last", "1e99", "takes a number"),
        ("many.count", "11", "a whole number from 0 to 10"),
        ("many.count", "1.5", "a whole number from 0 to 10"),
        ("many.colour", "1,1,1", "no setting is called `many.colour`; did you mean `many.color`?"),
        ("color", "1,1,1", "did you mean `many.color`?"),
        ("many.padding", "1,1", "no setting is called `many.padding`"),
    ] {
        let error = effect.set(key, value).unwrap_err().to_string();
        assert!(error.contains(expected), "{key}={value}: {error}");
    }
}

#[test]
fn an_effect_can_be_off() {
    let text = |member: &str| {
        format!(
            "struct Style {{\n// = 1 in 0..1\n{member}: f32 }}\n@group(2) @binding(0) var<uniform> style: Style;\n\
             @fragment fn fs() -> @location(0) vec4f {{ return vec4f(style.{member}); }}"
        )
    };
    let test = scenes::sun();
    let mut renderer = common::renderer();
    renderer.load(&test.scene).unwrap();
    let mut request = common::plain_request(&test.scene, (4, 4));
    let effect = Arc::new(WgslEffect::new(renderer.gpu(), "flat.wgsl", &text("strength")).unwrap());
    request.effects = vec![effect.clone()];
    let mut has_pass = || {
        let plan = renderer.plan(&test.scene, &request).unwrap();
        plan.passes.iter().any(|pass| pass.name == "flat")
    };
    assert!(has_pass());
    effect.set("flat.enabled", "false").unwrap();
    assert!(!has_pass());
    assert_eq!(effect.values().last(), Some(&("flat.enabled".into(), manypass::SettingValue::Boolean(false))));
    effect.set("flat.enabled", "true").unwrap();
    assert!(has_pass());
    assert!(effect.set("flat.enabled", "1").unwrap_err().to_string().contains("takes true or false"));
    // A member of that name is what it was.
    let own = manypass::EffectFile::parse("flat.wgsl", &text("enabled")).unwrap();
    assert!(own.settings().len() == 1 && own.settings()[0].needs.is_empty());
}

#[test]
fn the_example_and_that_of_the_docs_are_of_the_form() {
    let docs = include_str!("../../../docs/effects.md");
    let of_docs = docs.split("```wgsl\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let file = manypass::EffectFile::parse("vignette.wgsl", of_docs).unwrap();
    assert_eq!((file.name(), file.settings().len()), ("vignette", 3));
    assert_eq!(file.settings()[1].unit.as_deref(), Some("linear Rec. 709"));
    let file = manypass::EffectFile::parse("x.wgsl", include_str!("../examples/own_pass.wgsl")).unwrap();
    assert!(file.name() == "own_pass" && file.settings().len() == 5 && file.missing().is_none());
}

#[test]
fn a_wrong_default_or_header_is_refused_with_its_place() {
    let main = "@fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f { return vec4f(u.x) + radiance_at(vec2i(0)); }";
    let of_default = |default: &str| {
        format!("struct U {{\n    {default}\n    x: f32,\n}}\n@group(2) @binding(0) var<uniform> u: U;\n{main}")
    };
    for (source, expected) in [
        (of_default("// = half"), "a.wgsl:2:10: error: `half` is not a value of `x`, which takes a number"),
        (
            of_default("// = 2 in 0..1"),
            "a.wgsl:2:10: error: `2` is not a value of `x`, which takes a number from 0 to 1",
        ),
        (of_default("// = 1 in 0-1"), "`0-1` is not a range"),
        (of_default("// = 1 in 0..=1"), "`0..=1` is not a range"),
        (of_default("// = 1 in 2..0"), "`2..0` is an empty range"),
        (of_default("// = 1\n    // = 2"), "a.wgsl:3:5: error: a second default"),
        (of_default("// = 1, 2"), "`1, 2` is not a value"),
        (of_default("// ====="), ""),
        (of_default("/// Text with = signs.\n    // = -1e-3"), ""),
        (
            format!("//! reads: depth\n{}", of_default("")),
            "a.wgsl:1:5: error: the shader also reads radiance; the shader does not",
        ),
        (format!("//! reads: radiance\n{}", of_default("")), ""),
        (
            format!("//! passes: other\n{}", of_default("")),
            "a.wgsl:1:13: error: there is no `@fragment` function `other`; there is: fs",
        ),
        (format!("//! author: me\n{}", of_default("")), "a.wgsl:1:5: error: `author: me` begins with no word"),
        (of_default("// = 1").replace("x: f32", "x: f32, y: mat4x4f"), ""),
        (
            of_default("// = 1").replace("x: f32", "y: mat4x4f, x: f32"),
            "a.wgsl:2:10: error: a default stands above a member",
        ),
        (
            of_default("// = 1").replace("x: f32", "x: f32, y: array<vec4f, 99999999>"),
            "a.wgsl:5:36: error: `u` has 1600000",
        ),
        (of_default(&format!("// = 1\n    y: array<vec4f, {}1>,", "1+".repeat(100_000))), "a.wgsl:3:"),
    ] {
        match manypass::EffectFile::parse("a.wgsl", &source) {
            Ok(_) => assert!(expected.is_empty(), "{source}\nshould say {expected}"),
            Err(error) => {
                let error = error.to_string();
                assert!(!expected.is_empty() && error.contains(expected), "{source}\n{error}\nshould say {expected}");
            }
        }
    }
    let matrix = of_default("// = 1").replace("x: f32", "x: f32, y: mat4x4f");
    let file = manypass::EffectFile::parse("a.wgsl", &matrix).unwrap();
    let (setting, missing) = file.missing().unwrap();
    assert!(
        setting.is_none() && missing.to_string().contains("`y` is a `mat4x4f`, which no setting can be"),
        "{missing}"
    );
}

#[test]
fn a_target_that_cannot_be_drawn_to_is_an_error() {
    let test = scenes::sun();
    let mut renderer = common::renderer();
    renderer.load(&test.scene).unwrap();
    let texture = |format| {
        renderer.gpu().device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: 16, height: 16, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    };
    let good = texture(wgpu::TextureFormat::Bgra8Unorm);
    let good_target = Target::whole(&good);
    let outside = Target { rectangle: [8, 0, 9, 16], ..good_target.clone() };
    let empty = Target { rectangle: [0, 0, 0, 16], ..good_target.clone() };
    let wrapping = Target { rectangle: [u32::MAX, 0, 2, 16], ..good_target.clone() };
    let integers = Target::whole(&texture(wgpu::TextureFormat::Rgba8Uint));
    let request = common::plain_request(&test.scene, (16, 16));
    for target in [outside, empty, wrapping, integers] {
        let error = renderer.render_to(&test.scene, &request, &target).unwrap_err().to_string();
        assert!(error.starts_with("the target cannot be drawn to"), "{error}");
    }
    // At the same size and format without sRGB, the target holds the picture itself, blue first.
    renderer.render_to(&test.scene, &request, &good_target).unwrap();
    let found = pollster::block_on(manypass::gpu::readback::read_texture(renderer.gpu(), &good)).unwrap();
    let display = renderer.read_display().unwrap();
    for (found, shown) in found.chunks(4).zip(display.chunks(4)) {
        assert!((0..3).all(|c| found[2 - c].abs_diff(shown[c]) <= 1), "{found:?} {shown:?}");
    }
}

#[test]
fn what_effects_leave_as_no_numbers_is_counted_once_and_changes_nothing() {
    let test = scenes::one_light_on_one_plane();
    let mut renderer = common::renderer();
    renderer.load(&test.scene).unwrap();
    // Of 16 × 16 pixels 8 are no numbers and 4 are infinite.
    let source = "//! effect wrong
        @fragment fn fs(@builtin(position) position: vec4f) -> @location(0) vec4f {
            let here = radiance_at(vec2i(position.xy));
            let zero = here.a - 1.0;
            let wrong = select(1.0 / zero, zero / zero, position.x < 8.0);
            return select(here, vec4f(0.0, wrong, 0.0, 1.0), position.y < 1.0 && position.x < 12.0);
        }";
    let of_display = "//! effect late
        //! reads: display
        @fragment fn fs(@builtin(position) position: vec4f) -> @location(0) vec4f {
            let here = display_at(vec2i(position.xy));
            return select(here, vec4f(sqrt(-here.a), 0.0, 0.0, 1.0), position.y > 15.0 && position.x < 3.0);
        }";
    let compile = |name: &str, text: &str| Arc::new(WgslEffect::new(renderer.gpu(), name, text).unwrap());
    let (wrong, late) = (compile("wrong.wgsl", source), compile("late.wgsl", of_display));
    let bloom = common::built_in(&renderer, "bloom");
    let plain = common::plain_request(&test.scene, (16, 16));
    let request = |effects: &[Arc<WgslEffect>]| {
        let effects = effects.iter().map(|effect| effect.clone() as Arc<dyn manypass::Effect>).collect();
        FrameRequest { effects, ..plain.clone() }
    };
    for (effects, expected) in [
        (vec![], 0),
        (vec![bloom.clone()], 0),
        (vec![wrong.clone()], 12),
        // Scrubbed before the second, which spreads none.
        (vec![wrong.clone(), bloom.clone()], 12),
        (vec![bloom, wrong.clone()], 12),
        (vec![late.clone()], 3),
        (vec![wrong, late], 15),
    ] {
        let request = request(&effects);
        renderer.render(&test.scene, &request).unwrap();
        let picture = renderer.read_display().unwrap();
        assert_eq!(renderer.count_scrubbed(&test.scene, &request).unwrap(), expected, "{effects:?}");
        let plan = renderer.plan(&test.scene, &request).unwrap().to_text();
        assert!(!plan.contains(".count"), "{plan}");
        renderer.render(&test.scene, &request).unwrap();
        assert!(renderer.read_display().unwrap() == picture);
    }
}
