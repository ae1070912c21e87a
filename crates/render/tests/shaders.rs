//! Every variant of every program is valid WGSL, translates to GLSL ES 3.00 (the WebGL 2 floor), keeps to the texture
//! budget, and shares its uniform layouts with Rust.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use manypass::shader::compose::{BuiltIn, PROGRAMS, embedded_bytes};
use naga::back::glsl;
use naga::back::pipeline_constants::process_overrides;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use std::collections::BTreeSet;

fn parse(name: &str, source: &str) -> (naga::Module, ModuleInfo) {
    let module =
        naga::front::wgsl::parse_str(source).unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(source)));
    let info = Validator::new(ValidationFlags::all(), Capabilities::default())
        .validate(&module)
        .unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(source)));
    (module, info)
}

/// The number of texture units that the translation takes, where `override` constants have these values, and others
/// that which they are declared with.
fn translate(
    module: &naga::Module,
    info: &ModuleInfo,
    entry: &naga::EntryPoint,
    values: &[(&str, u32)],
) -> Result<usize, String> {
    let options =
        glsl::Options { version: glsl::Version::Embedded { version: 300, is_webgl: true }, ..Default::default() };
    let pipeline =
        glsl::PipelineOptions { shader_stage: entry.stage, entry_point: entry.name.clone(), multiview: None };
    // As wgpu does when it makes a pipeline: every `override` constant becomes a value.
    let values = values.iter().map(|(name, value)| ((*name).to_owned(), f64::from(*value))).collect();
    let entry_point = Some((entry.stage, &entry.name[..]));
    let (module, info) = process_overrides(module, info, entry_point, &values).map_err(|error| error.to_string())?;
    let mut text = String::new();
    let reflection = glsl::Writer::new(&mut text, &module, &info, &options, &pipeline, Default::default())
        .and_then(|mut writer| writer.write())
        .map_err(|error| error.to_string())?;
    match LATER_FUNCTIONS.iter().find(|name| text.contains(&format!("{name}("))) {
        Some(name) => Err(format!("`{name}` came after GLSL ES 3.00")),
        None => Ok(reflection.texture_mapping.len()),
    }
}

/// Functions that naga writes without a word, and that GLSL ES 3.00 lacks; `mix` chooses no vectors of whole numbers.
const LATER_FUNCTIONS: [&str; 16] = [
    "findLSB",
    "findMSB",
    "bitCount",
    "bitfieldExtract",
    "bitfieldInsert",
    "bitfieldReverse",
    "textureGather",
    "fma",
    "mix(uvec2",
    "mix(uvec3",
    "mix(uvec4",
    "mix(ivec2",
    "mix(ivec3",
    "mix(ivec4",
    "mix(bvec3",
    "mix(bvec4",
];

/// What a stage has of textures and of samplers on every device of WebGL 2, and as many in `downlevel_webgl2_defaults`
/// of wgpu, which counts all that the layouts of a pipeline name, whether its shader reads it or not.
const UNITS_A_STAGE: usize = 16;

/// The textures and the samplers that a module names in these groups, by group and binding.
fn units(module: &naga::Module, groups: std::ops::Range<u32>) -> [BTreeSet<(u32, u32)>; 2] {
    let of = |is_counted: fn(&naga::TypeInner) -> bool| {
        let globals = module.global_variables.iter().map(|(_, global)| global);
        let counted = globals.filter(|global| is_counted(&module.types[global.ty].inner));
        let bindings = counted.filter_map(|global| global.binding).filter(|binding| groups.contains(&binding.group));
        bindings.map(|binding| (binding.group, binding.binding)).collect()
    };
    [
        of(|inner| matches!(inner, naga::TypeInner::Image { .. })),
        of(|inner| matches!(inner, naga::TypeInner::Sampler { .. })),
    ]
}

/// Built-in modules are compiled without the counters that end endless loops.
#[test]
fn every_loop_counts_up_to_a_bound_that_stays() {
    let mut loops = 0;
    for program in PROGRAMS {
        let name = program.name;
        for source in program.modules() {
            let words =
                |line: &str| line.split(|c: char| !c.is_alphanumeric() && c != '_').map(str::to_owned).collect();
            let lines: Vec<(&str, Vec<String>)> = source.lines().map(|line| (line.trim(), words(line))).collect();
            for (at, (line, words)) in lines.iter().enumerate() {
                let is_word = |word: &str| words.iter().any(|found| found == word);
                assert!(!is_word("loop") && !is_word("while"), "{name}: {line}");
                if !is_word("for") {
                    continue;
                }
                let head = line.strip_prefix("for (").and_then(|rest| rest.split_once(") {")).map(|(head, _)| head);
                let parts: Vec<&str> = head.into_iter().flat_map(|head| head.split(';')).map(str::trim).collect();
                let [first, condition, step] = parts[..] else { panic!("{name}: {line}") };
                let (counter, bound) = condition.split_once(" < ").unwrap_or_else(|| panic!("{name}: {line}"));
                let is_name = |text: &str| text.chars().all(|c| c.is_alphanumeric() || c == '_' || c == '.');
                assert!(is_name(counter) && is_name(bound) && step == format!("{counter}++"), "{name}: {line}");
                assert!(first.is_empty() || first.starts_with(&format!("var {counter} = ")), "{name}: {line}");
                // The body ends where the indentation is that of the head again.
                let indent = |at: usize| source.lines().nth(at).map_or(0, |line| line.len() - line.trim_start().len());
                let body = lines.iter().enumerate().skip(at + 1).take_while(|(i, _)| indent(*i) > indent(at));
                for (_, (inner, _)) in body {
                    let is_changed = |name: &str| {
                        let rest = inner.strip_prefix(name).map(str::trim_start);
                        rest.is_some_and(|rest| rest.starts_with(['=', '+', '-', '*', '/']) && !rest.starts_with("=="))
                            || inner.contains(&format!("&{name}"))
                    };
                    assert!(!is_changed(counter) && !is_changed(bound), "{name}: {inner}");
                }
                loops += 1;
            }
        }
    }
    assert!(loops > 100, "{loops} loops were looked at");
}

/// The blocks that a statement has.
fn blocks_of(statement: &naga::Statement) -> Vec<&naga::Block> {
    match statement {
        naga::Statement::Block(block) => vec![block],
        naga::Statement::If { accept, reject, .. } => vec![accept, reject],
        naga::Statement::Switch { cases, .. } => cases.iter().map(|case| &case.body).collect(),
        naga::Statement::Loop { body, continuing, .. } => vec![body, continuing],
        _ => Vec::new(),
    }
}

/// Whether nothing that follows a statement is ever reached.
fn leads_nowhere(statement: &naga::Statement) -> bool {
    let ends = |block: &naga::Block| block.last().is_some_and(leads_nowhere);
    match statement {
        naga::Statement::Return { .. } | naga::Statement::Break | naga::Statement::Continue => true,
        naga::Statement::Block(block) => ends(block),
        naga::Statement::If { accept, reject, .. } => ends(accept) && ends(reject),
        _ => false,
    }
}

/// Whether something in a block follows what leads nowhere.
fn has_unreachable_code(block: &naga::Block) -> bool {
    let before_last = block.split_last().map_or(&[][..], |(_, before)| before);
    before_last.iter().any(leads_nowhere) || block.iter().flat_map(blocks_of).any(has_unreachable_code)
}

/// Browsers warn of it once a shader, on the page's console.
#[test]
fn no_program_has_code_that_is_never_reached() {
    let faulty = |source: &str| {
        let module = naga::front::wgsl::parse_str(source).unwrap();
        let functions = module.functions.iter().map(|(_, function)| function);
        let functions = functions.chain(module.entry_points.iter().map(|entry| &entry.function));
        let faulty = functions.filter(|function| has_unreachable_code(&function.body));
        faulty.map(|function| function.name.clone().unwrap_or_default()).collect::<Vec<_>>()
    };
    let text = "fn after_a_block() -> f32 { { return 1.0; } return 2.0; }
        fn after_both(a: bool) -> f32 { if a { return 1.0; } else { return 2.0; } return 3.0; }
        fn after_one(a: bool) -> f32 { if a { return 1.0; } return 3.0; }";
    assert_eq!(faulty(text), ["after_a_block", "after_both"]);
    for program in PROGRAMS {
        for source in program.modules() {
            let found = faulty(&source);
            assert!(found.is_empty(), "{}: {}", program.name, found.join(", "));
        }
    }
}

/// The values that an `override` constant takes, by its name: 0 and 1, but for those that are numbers or bits.
fn values_of(name: &str) -> std::ops::RangeInclusive<u32> {
    match name {
        "curve" => 0..=5,
        "shown" => 0..=9,
        "blending" | "reflectance_model" | "sun_count" | "directed_light" => 0..=2,
        "probe_grids" | "lights_of" => 0..=4,
        "light_classes" => 0..=63,
        "side" => 1..=4,
        // Eight bits.
        "decals" => 0..=255,
        "slices" => 1..=16,
        "steps" => 1..=1024,
        "contact_steps" => 0..=64,
        // Seventeen maps and the layers above.
        "material_layers" => 0..=u32::MAX,
        _ => 0..=1,
    }
}

/// Sets of values for the constants of a module: each constant by itself at its least and greatest value and in
/// between, all at their least, all at their greatest, and sets without a pattern.
fn sets_of_values(names: &[String]) -> Vec<Vec<(&str, u32)>> {
    let all = |value: &dyn Fn(usize, &str) -> u32| {
        names.iter().enumerate().map(|(i, name)| (&name[..], value(i, name))).collect::<Vec<_>>()
    };
    let mut sets = vec![Vec::new(), all(&|_, name| *values_of(name).start()), all(&|_, name| *values_of(name).end())];
    for name in names {
        let (least, most) = values_of(name).into_inner();
        let between = (0..32).map(|bit| 1u32 << bit).chain(least..=most.min(8));
        let values: BTreeSet<u32> = between.chain([most]).filter(|value| (least..=most).contains(value)).collect();
        sets.extend(values.into_iter().map(|value| vec![(&name[..], value)]));
    }
    for turn in 0..16u32 {
        // Multiplicative hashing (Knuth 1973).
        let hash = |i: usize| (turn * 64 + i as u32 + 1).wrapping_mul(2_654_435_761) >> 7;
        sets.push(all(&|i, name| match values_of(name).into_inner() {
            (0, u32::MAX) => hash(i).wrapping_mul(hash(i + 1)),
            (least, most) => least + hash(i) % (most - least + 1),
        }));
    }
    sets
}

#[test]
fn every_variant_is_valid_and_runs_on_webgl2() {
    let (mut modules, mut translated) = (0, 0);
    for program in PROGRAMS {
        let BuiltIn { name, axes, .. } = program;
        assert_eq!(program.modules().len(), 1 << axes.len());
        for (variant, source) in program.modules().enumerate() {
            let label = format!("{name}, variant {variant} of {axes:?}");
            let (module, info) = parse(&label, &source);
            let constants: Vec<String> =
                module.overrides.iter().filter_map(|(_, constant)| constant.name.clone()).collect();
            println!("{label}: constants {}", constants.join(", "));
            for (entry, values) in module
                .entry_points
                .iter()
                .flat_map(|entry| sets_of_values(&constants).into_iter().map(move |set| (entry, set)))
            {
                match translate(&module, &info, entry, &values) {
                    Ok(count) => assert!(count <= UNITS_A_STAGE, "{label}, {}: {count} texture units", entry.name),
                    Err(error) => panic!("{label}, {} with {values:?}: no GLSL ES 3.00: {error}", entry.name),
                }
                translated += 1;
            }
            modules += 1;
        }
    }
    println!("{} programs, {modules} modules, {translated} translations", PROGRAMS.len());
    assert!(modules > 30, "{modules} modules");
}

/// An aim: half a megabyte. They were 0.47 MB when it was set; whole modules were 2.4 MB.
const EMBEDDED_BYTES_MAX: usize = 500_000;

#[test]
fn texts_of_programs_take_little_of_the_library() {
    let bytes = embedded_bytes();
    assert!(bytes <= EMBEDDED_BYTES_MAX, "{bytes} bytes; a variant that is not an axis costs none");
    // What a program without axes, and one with one, have in common is there once.
    let whole: usize = PROGRAMS.iter().flat_map(BuiltIn::modules).map(|module| module.len()).sum();
    assert!(whole > 4 * bytes, "{bytes} bytes of {whole}");
}

#[test]
fn no_variant_binds_more_textures_and_samplers_than_webgl2_has() {
    let variants = || {
        PROGRAMS.iter().flat_map(|program| {
            program.modules().enumerate().map(move |(variant, source)| {
                let label = format!("{}, variant {variant}", program.name);
                let module = naga::front::wgsl::parse_str(&source);
                (module.unwrap_or_else(|error| panic!("{label}: {}", error.emit_to_string(&source))), label)
            })
        })
    };
    // Group 0 has one layout for all programs, and counts with each, whatever of it that reads.
    let mut shared: [BTreeSet<(u32, u32)>; 2] = Default::default();
    for (module, _) in variants() {
        for (all, found) in shared.iter_mut().zip(units(&module, 0..1)) {
            all.extend(found);
        }
    }
    let [textures, samplers] = shared.map(|found| found.len());
    assert!(textures >= 6 && samplers >= 3, "{textures} textures and {samplers} samplers in group 0");
    // On WebGL 2 wgpu numbers the textures of all groups together, and has as many of them. Deformed surfaces with
    // layers exceed that.
    for program in PROGRAMS {
        let name = program.name;
        let skins = program.axes.iter().position(|axis| *axis == "skins");
        for (variant, source) in program.modules().enumerate() {
            if skins.is_some_and(|bit| variant >> bit & 1 == 1) {
                continue;
            }
            let [own, _] = units(&naga::front::wgsl::parse_str(&source).unwrap(), 1..4).map(|found| found.len());
            assert!(textures + own <= UNITS_A_STAGE, "{name}, variant {variant} binds {} textures", textures + own);
        }
    }
    let mut most = [0, 0];
    for (module, label) in variants() {
        // Group 3 is the vertex stage's alone, and the others are the fragment's.
        for groups in [1..3, 3..4] {
            let [own_textures, own_samplers] = units(&module, groups.clone()).map(|found| found.len());
            let counts = [textures + own_textures, samplers + own_samplers];
            for ((what, count), most) in ["textures", "samplers"].iter().zip(counts).zip(&mut most) {
                assert!(count <= UNITS_A_STAGE, "{label} has {count} {what} in groups 0 and {groups:?}");
                *most = count.max(*most);
            }
        }
    }
    println!("at most {} textures and {} samplers in a stage", most[0], most[1]);
}

#[test]
fn programs_are_those_that_shaders_declare() {
    let names: Vec<&str> = PROGRAMS.iter().map(|program| program.name).collect();
    assert!(names.is_sorted(), "{names:?}");
    let axes_of = |name: &str| PROGRAMS.iter().find(|known| known.name == name).map(|known| known.axes);
    assert_eq!(axes_of("meter"), Some(&[][..]));
    // What materials are made of binds nothing where there is none of it; all else about them are constants.
    assert_eq!(axes_of("geometry").unwrap(), ["textures"]);
    assert_eq!(axes_of("ids").unwrap(), ["masks"]);
    assert_eq!(axes_of("geometry_points"), Some(&[][..]));
    assert_eq!(axes_of("meter_points"), None);
    // Special materials have textures in any case, which with those of skins are more than a stage has.
    assert_eq!(axes_of("forward_layered").unwrap(), ["skins"]);
    assert_eq!(axes_of("geometry_detailed").unwrap(), ["skins"]);
    assert_eq!(axes_of("forward_relief").unwrap(), ["skins"]);
    assert_eq!(axes_of("ids_relief"), Some(&[][..]));
    const SECOND: [&str; 4] = ["_points", "_layered", "_detailed", "_relief"];
    let mut files = Vec::new();
    shader_files(&std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut files);
    let declared: usize = files.iter().map(|(_, text)| text.matches("\n// Program: ").count()).sum();
    assert_eq!(declared, names.iter().filter(|name| !SECOND.iter().any(|end| name.ends_with(end))).count());
}

#[test]
fn effects_are_valid_and_run_on_webgl2() {
    use manypass::shader::compose::EFFECT_PRELUDE;
    for (name, own) in [
        ("own_pass", include_str!("../examples/own_pass.wgsl")),
        ("prelude", "@fragment fn fs() -> @location(0) vec4f { return radiance_at(vec2i(0)); }"),
    ] {
        let (module, info) = parse(name, &format!("{own}\n{EFFECT_PRELUDE}"));
        assert_eq!(module.entry_points.len(), 1, "{name}");
        if let Err(error) = translate(&module, &info, &module.entry_points[0], &[]) {
            panic!("{name}: no GLSL ES 3.00: {error}");
        }
    }
}

/// The text of every WGSL file of the crate.
fn shader_files(folder: &std::path::Path, texts: &mut Vec<(String, String)>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            shader_files(&path, texts);
        } else if path.extension().is_some_and(|end| end == "wgsl") {
            texts.push((path.display().to_string(), std::fs::read_to_string(&path).unwrap()));
        }
    }
}

#[test]
fn shared_constants_are_declared_once() {
    let mut files = Vec::new();
    shader_files(&std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut files);
    assert!(files.len() > 20);
    let (module, _) = parse("constants", &manypass::constants::as_wgsl(|_| true));
    assert!(module.constants.len() > 10);
    for (_, constant) in module.constants.iter() {
        let name = constant.name.as_deref().unwrap();
        for (path, text) in &files {
            assert!(!text.contains(&format!("const {name}")), "{path} declares {name}");
        }
        // Otherwise it is none that shaders and Rust share.
        assert!(files.iter().any(|(_, text)| text.contains(name)), "no shader uses {name}");
    }
}
