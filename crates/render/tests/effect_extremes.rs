//! Built-in effects at the ends of their settings, chains longer than anyone's, and effects in Rust that misuse the graph.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{built_in, plain_request, renderer};
use manypass::graph::{ColorLoad, DepthLoad, Graph, Handle, Limits, TextureDesc};
use manypass::settings::{Scalar, SettingType};
use manypass::shader::ProgramError;
use manypass::{
    DrawSelection, Effect, EffectFile, FrameRequest, Gbuffer, Pose, Recorder, Renderer, SettingInfo, WgslEffect,
};
use manypass_testkit::scenes;
use std::sync::Arc;

fn effect(renderer: &Renderer, source: &str) -> Arc<WgslEffect> {
    Arc::new(WgslEffect::new(renderer.gpu(), "mine.wgsl", source).unwrap_or_else(|error| panic!("{error}")))
}

/// The least and the largest value of a setting, or what is next to the largest number where there is no limit.
fn ends(info: &SettingInfo) -> [String; 2] {
    match &info.kind {
        SettingType::Boolean => ["false".into(), "true".into()],
        SettingType::Number(kind) => {
            let far = match kind.scalar {
                Scalar::F32 => [-1e38, 1e38],
                Scalar::I32 => [f64::from(i32::MIN), f64::from(i32::MAX)],
                Scalar::U32 => [0.0, f64::from(u32::MAX)],
            };
            let ends = [info.min.unwrap_or(far[0]), info.max.unwrap_or(far[1])];
            ends.map(|end| vec![end.to_string(); usize::from(kind.count)].join(","))
        }
        kind => panic!("{} is a {kind}", info.key),
    }
}

#[test]
fn built_in_effects_leave_numbers_at_the_ends_of_their_settings() {
    let scene = scenes::rows_of_spheres().scene;
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let mut request = plain_request(&scene, (33, 18));
    let mut before = request.camera;
    before.world_from_view.w_axis += 0.5 * before.world_from_view.x_axis;
    request.previous = Some(Arc::new(Pose::capture(&scene, before)));
    // All that radiance can be, black and the brightest side by side; and the picture itself.
    let drawing = effect(
        &renderer,
        "@fragment fn fs(@builtin(position) position: vec4f) -> @location(0) vec4f {
            let noise = fract(sin(dot(floor(position.xy), vec2f(12.9898, 78.233))) * vec3f(43758.5, 23421.6, 9182.1));
            let strong = select(pow(noise, vec3f(20.0)) * 20000.0, vec3f(0.0), noise < vec3f(0.3));
            let here = radiance_at(vec2i(position.xy));
            return select(vec4f(strong, noise.x), here, position.x < 12.0);
        }",
    );
    let mut drawn = 0;
    for name in EffectFile::built_in_names() {
        let tried = built_in(&renderer, name);
        request.effects = vec![drawing.clone(), tried.clone()];
        let mut draw = |what: &str| {
            let count = renderer.count_scrubbed(&scene, &request).unwrap();
            assert_eq!(count, 0, "pixels that are no numbers of {name} with {what}");
            drawn += 1;
        };
        let settings = tried.settings();
        for info in &settings {
            for end in ends(info) {
                tried.set(&info.key, &end).unwrap_or_else(|error| panic!("{error}"));
                draw(&format!("{}={end}", info.key));
            }
            tried.set(&info.key, &info.default.as_ref().unwrap().to_string()).unwrap();
        }
        // All of them at once.
        for side in [0, 1] {
            for info in settings.iter().filter(|info| info.kind != SettingType::Boolean) {
                tried.set(&info.key, &ends(info)[side]).unwrap();
            }
            draw(["all at their least", "all at their largest"][side]);
        }
    }
    assert!(drawn > 100, "{drawn} pictures");
}

#[test]
fn a_hundred_effects_that_cannot_be_drawn_together_are_drawn_one_after_the_other() {
    let scene = scenes::rows_of_spheres().scene;
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let plain = plain_request(&scene, (40, 30));
    let chain = |renderer: &Renderer, count: usize| -> Vec<Arc<dyn Effect>> {
        let of = |index: usize| -> Arc<dyn Effect> {
            effect(
                renderer,
                &format!(
                    "//! effect n{index}
                    @fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f {{
                        let beside = radiance_at(vec2i(i32(p.x) - 1, i32(p.y)));
                        return vec4f(select(beside.rgb, vec3f({index}.0), p.x < 1.0), 1.0);
                    }}"
                ),
            )
        };
        (0..count).map(of).collect()
    };
    let mut request = FrameRequest { effects: chain(&renderer, 100), ..plain };
    renderer.render(&scene, &request).unwrap();
    let found = renderer.read_radiance().unwrap();
    // Each moves all before it by a pixel, and leaves its number in the first column: the last forty are to be seen.
    for (at, pixel) in found.chunks_exact(4).enumerate() {
        assert_eq!(pixel[0], (99 - at % 40) as f32, "pixel {at}");
    }
    // They need no more memory than four of them.
    let many = renderer.plan(&scene, &request).unwrap();
    let drawn = many.passes.iter().filter(|pass| pass.name.starts_with('n')).count();
    assert!(drawn >= 100, "{}", many.to_text());
    request.effects.truncate(4);
    let few = renderer.plan(&scene, &request).unwrap();
    assert_eq!(many.bytes().aliased, few.bytes().aliased);
    assert!(many.bytes().unaliased > 10 * few.bytes().unaliased, "{:?}", many.bytes());
}

/// What an effect records, given radiance.
type Record = for<'r, 'f> fn(&mut Recorder<'r, 'f>, Handle) -> Result<Handle, ProgramError>;

/// An effect that misuses the graph.
struct Misuse(Record);

impl std::fmt::Debug for Misuse {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Misuse")
    }
}

impl Effect for Misuse {
    fn record<'f>(
        &'f self,
        r: &mut Recorder<'_, 'f>,
        _: Option<&Gbuffer>,
        radiance: Handle,
    ) -> Result<Handle, ProgramError> {
        (self.0)(r, radiance)
    }
}

const CLEAR: ColorLoad = ColorLoad::Clear(wgpu::Color::BLACK);

/// A texture of the shape of `radiance` that belongs to another frame.
fn foreign(radiance: &Handle) -> Handle {
    Graph::new(Limits::WEBGL2).texture("foreign", radiance.desc())
}

/// A pass that reads some textures and draws over another.
fn pass(r: &mut Recorder<'_, '_>, reads: &[&Handle], target: Handle, load: ColorLoad) -> Handle {
    let mut pass = r.graph.pass("misuse");
    for read in reads {
        pass.read(read);
    }
    let target = pass.color(target, load);
    pass.draw(|_| {});
    target
}

/// Draws a texture of this shape, and nothing with it.
fn drawn_beside(r: &mut Recorder<'_, '_>, radiance: Handle, desc: TextureDesc) -> Result<Handle, ProgramError> {
    let texture = r.texture_of("shape", desc);
    let texture = pass(r, &[], texture, CLEAR);
    Ok(pass(r, &[&texture], radiance, ColorLoad::Keep))
}

/// Radiance that a shader of the renderer's has copied, into a rectangle of a texture.
fn copied(
    r: &mut Recorder<'_, '_>,
    radiance: &Handle,
    desc: TextureDesc,
    rectangle: [u32; 4],
) -> Result<Handle, ProgramError> {
    let target = r.texture_of("copied", desc);
    let step = r.fullscreen("misuse", "scrub", &[]).read("radiance", radiance);
    step.leave_out_settled().within(rectangle).draw_into(target, CLEAR)
}

/// What an effect may do wrong, and what the error says.
const MISUSES: [(&str, &str, Record); 29] = [
    ("reads a texture of another frame", "another graph", |r, radiance| {
        let other = foreign(&radiance);
        Ok(pass(r, &[&other], radiance, ColorLoad::Keep))
    }),
    ("draws into a texture of another frame", "another graph", |r, radiance| {
        let other = foreign(&radiance);
        Ok(pass(r, &[&radiance], other, CLEAR))
    }),
    ("looks at a mip of a texture of another frame", "another graph", |r, radiance| {
        let other = foreign(&radiance);
        r.graph.subview(&other, 0, 0);
        Ok(radiance)
    }),
    ("exports a texture of another frame", "another graph", |r, radiance| {
        let other = foreign(&radiance);
        r.graph.export(other);
        Ok(radiance)
    }),
    ("returns a texture of another frame", "another graph", |_, radiance| Ok(foreign(&radiance))),
    ("puts another graph in the frame's place", "another graph", |r, radiance| {
        *r.graph = Graph::new(Limits::WEBGL2);
        Ok(radiance)
    }),
    ("draws into what it reads", "while it is attached", |r, radiance| {
        let mut pass = r.graph.pass("misuse");
        pass.read(&radiance);
        let radiance = pass.color(radiance, ColorLoad::Keep);
        pass.draw(|_| {});
        Ok(radiance)
    }),
    ("attaches two depths", "one depth-stencil target", |r, radiance| {
        let format = wgpu::TextureFormat::Depth32Float;
        let depths = ["near", "far"].map(|name| r.texture(name, format));
        let mut pass = r.graph.pass("misuse");
        let radiance = pass.color(radiance, ColorLoad::Keep);
        for depth in depths {
            pass.depth_stencil(depth, DepthLoad::Clear { depth: 0.0, stencil: 0 });
        }
        pass.draw(|_| {});
        Ok(radiance)
    }),
    ("attaches colours as depth", "cannot be used as", |r, radiance| {
        let mut pass = r.graph.pass("misuse");
        let radiance = pass.depth_stencil(radiance, DepthLoad::Keep);
        pass.draw(|_| {});
        Ok(radiance)
    }),
    ("shades into depth", "cannot be used as", |r, radiance| {
        let desc = TextureDesc { format: wgpu::TextureFormat::Depth32Float, ..radiance.desc() };
        copied(r, &radiance, desc, [0, 0, 1, 1])?;
        Ok(radiance)
    }),
    ("draws surfaces with colours for depth", "cannot be used as", |r, radiance| {
        let mut pass = r.surfaces("misuse", "geometry");
        pass.depth_read_only(&radiance);
        pass.draw_opaque(DrawSelection::All)?;
        Ok(radiance)
    }),
    ("draws surfaces without depth", "given no depth", |r, radiance| {
        r.surfaces("misuse", "geometry").draw_opaque(DrawSelection::All)?;
        Ok(radiance)
    }),
    ("draws a history of another size", "one size", |r, radiance| {
        let history = r.history("misuse", TextureDesc::new_2d(8, 8, radiance.desc().format));
        let mut pass = r.graph.pass("misuse");
        let radiance = pass.color(radiance, ColorLoad::Keep);
        pass.color(history.next, CLEAR);
        pass.draw(|_| {});
        Ok(radiance)
    }),
    ("asks for a history twice", "asked for twice", |r, radiance| {
        r.history("misuse", radiance.desc());
        r.history("misuse", TextureDesc::new_2d(8, 8, radiance.desc().format));
        Ok(radiance)
    }),
    ("makes a texture without width", "sizes go from 1", |r, radiance| {
        let desc = TextureDesc { width: 0, ..radiance.desc() };
        drawn_beside(r, radiance, desc)
    }),
    ("makes a texture without layers", "sizes go from 1", |r, radiance| {
        let desc = TextureDesc { layers: 0, ..radiance.desc() };
        drawn_beside(r, radiance, desc)
    }),
    ("makes a texture beyond all sizes", "sizes go from 1", |r, radiance| {
        let desc = TextureDesc { width: u32::MAX, height: u32::MAX, mips: u32::MAX, ..radiance.desc() };
        drawn_beside(r, radiance, desc)
    }),
    ("shades three samples a texel", "sizes go from 1", |r, radiance| {
        let desc = TextureDesc { samples: 3, ..radiance.desc() };
        copied(r, &radiance, desc, [0, 0, 1, 1])?;
        Ok(radiance)
    }),
    ("names a mip that there is not", "has no view of", |r, radiance| {
        r.graph.subview(&radiance, u32::MAX, 0);
        Ok(radiance)
    }),
    ("samples a flat texture as a cube", "as Cube", |r, radiance| {
        let target = r.texture_of("target", radiance.desc());
        let mut pass = r.graph.pass("misuse");
        pass.read_as(&radiance, wgpu::TextureViewDimension::Cube);
        let target = pass.color(target, CLEAR);
        pass.draw(|_| {});
        Ok(target)
    }),
    ("reads what nobody has written", "before anything writes it", |r, radiance| {
        let empty = r.texture_of("empty", radiance.desc());
        Ok(pass(r, &[&empty], radiance, ColorLoad::Keep))
    }),
    ("returns what nobody has written", "before anything writes it", |r, radiance| {
        Ok(r.texture_of("empty", radiance.desc()))
    }),
    ("exports what nobody has written", "is exported, but", |r, radiance| {
        let empty = r.texture_of("empty", radiance.desc());
        r.graph.export(empty);
        Ok(radiance)
    }),
    ("declares a pass without targets", "has no attachment", |r, radiance| {
        r.graph.pass("misuse").draw(|_| {});
        Ok(radiance)
    }),
    ("looks at what another pass reads", "has not declared", |r, radiance| {
        let target = r.texture_of("target", radiance.desc());
        let mut first = r.graph.pass("first");
        let read = first.read(&radiance);
        let target = first.color(target, CLEAR);
        first.draw(|_| {});
        let mut second = r.graph.pass("second");
        let target = second.color(target, ColorLoad::Keep);
        second.draw(move |context| assert!(context.view(read).is_none()));
        Ok(target)
    }),
    ("returns another shape", "it returns", |r, radiance| {
        let desc = TextureDesc::new_2d(8, 8, wgpu::TextureFormat::R8Unorm);
        let texture = r.texture_of("small", desc);
        let target = pass(r, &[&radiance], texture, CLEAR);
        Ok(target)
    }),
    ("draws with a program that there is not", "no program", |r, radiance| {
        r.fullscreen("misuse", "nothing", &[]).draw_into(radiance, ColorLoad::Keep)
    }),
    ("binds nothing", "which is not among", |r, radiance| {
        let target = r.texture_of("target", radiance.desc());
        r.fullscreen("misuse", "scrub", &[]).draw_into(target, CLEAR)
    }),
    ("draws beyond its target", "refused", |r, radiance| {
        let desc = radiance.desc();
        copied(r, &radiance, desc, [u32::MAX, 0, 10, 10])
    }),
];

#[test]
fn an_effect_that_misuses_the_graph_is_an_error_of_its_frame_alone() {
    let scene = scenes::rows_of_spheres().scene;
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let request = plain_request(&scene, (48, 32));
    renderer.render(&scene, &request).unwrap();
    let picture = renderer.read_display().unwrap();
    for (what, expected, record) in MISUSES {
        let misusing = FrameRequest { effects: vec![Arc::new(Misuse(record))], ..request.clone() };
        let error = renderer.render(&scene, &misusing).expect_err(what).to_string();
        assert!(error.contains(expected), "an effect that {what}: {error}");
        renderer.render(&scene, &request).unwrap_or_else(|error| panic!("after an effect that {what}: {error}"));
        assert!(renderer.read_display().unwrap() == picture, "another picture after an effect that {what}");
    }
}
