//! Composes every variant of every shader module with WESL, and integrates the directional albedo of GGX and of sheen.
//! Cargo runs it after each change in `src`, because shaders lie beside Rust there and new ones must be found; it does
//! something only if a shader, or the script itself, is another than the last time.

use std::collections::BTreeSet;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::{env, fmt::Write as _, fs, path::Path};
use wesl::{CompileOptions, FileResolver, ManglerKind, Router, VirtualResolver, Wesl};

#[path = "src/constants.rs"]
mod constants;
#[path = "build/programs.rs"]
mod programs;

/// What can be an `override` constant of a shader is none of its axes, so that all programs together are few modules:
/// 64 for materials, lights and what they are shown by, and those of effects in the picture: 4 of `occlusion`, 7 of
/// `reflections`, 3 of `gi`, `scrub`, 2 of `taa`, `upscale`, 2 of `nearest`; `overlay`; 2 of `mirrors`; 2 of `water`; `portals`; 2 of surroundings; 3 of `particles`; `decals_mark`; `probes`, and 5 that find their light; 2 of `transmittance`; 2 of `glass`.
const MODULES_MAX: usize = 64 + 4 + 7 + 3 + 1 + 2 + 1 + 2 + 1 + 2 + 2 + 1 + 2 + 3 + 1 + 6 + 2 + 2;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=build");
    println!("cargo::rerun-if-changed=src");
    let out = env::var("OUT_DIR").expect("cargo sets OUT_DIR");
    let (stamp, inputs) = (Path::new(&out).join("inputs"), inputs(&out));
    if fs::read_to_string(&stamp).is_ok_and(|last| last == inputs) {
        return;
    }
    // What ends early leaves files of two versions behind.
    let _ = fs::remove_file(&stamp);
    write_all(&out);
    fs::write(stamp, inputs).expect("the output folder is writable");
}

/// A number of all that the output depends on: the shaders, this program, which has the constants in it, and the folder
/// `out`, whose name the list has.
fn inputs(out: &str) -> String {
    let mut hasher = DefaultHasher::new();
    out.hash(&mut hasher);
    let program = env::current_exe().and_then(|program| program.metadata()?.modified());
    program.expect("this program is a file").hash(&mut hasher);
    for shader in programs::shaders(Path::new("src")) {
        shader.hash(&mut hasher);
    }
    format!("{:016x}", hasher.finish())
}

/// Writes every variant of every program, and their list.
fn write_all(out: &str) {
    let mut list = String::from(
        "/// Every program: name, axes, and the WGSL of every variant.\npub const PROGRAMS: &[(&str, &[&str], &[&str])] = &[\n",
    );
    let mut constants = String::from(
        "/// The `override` constants that any variant of a program declares.\npub const CONSTANTS: &[(&str, &[&str])] = &[\n",
    );
    let programs = programs::declared(Path::new("src"));
    let counts: Vec<(&str, usize)> =
        programs.iter().map(|program| (&program.name[..], 1 << program.axes.len())).collect();
    let modules: usize = counts.iter().map(|(_, count)| count).sum();
    assert!(modules <= MODULES_MAX, "{modules} modules are more than {MODULES_MAX}: {counts:?}");
    for program in programs {
        let programs::Declared { name, axes, .. } = &program;
        let count = 1usize << axes.len();
        let _ = writeln!(list, "    ({name:?}, &{axes:?}, &[");
        let mut declared = BTreeSet::new();
        for variant in 0..count {
            let source =
                compose(&program, variant).unwrap_or_else(|error| panic!("{name}, variant {variant}:\n{error}"));
            let names =
                source.lines().filter_map(|line| line.trim_start().strip_prefix("override ")?.split(':').next());
            declared.extend(names.map(str::to_owned));
            let file = Path::new(out).join(format!("{name}_{variant}.wgsl"));
            fs::write(&file, source).expect("the output folder is writable");
            let _ = writeln!(list, "        include_str!({:?}),", file.display().to_string());
        }
        list.push_str("    ]),\n");
        let _ = writeln!(constants, "    ({name:?}, &{:?}),", Vec::from_iter(declared));
    }
    list.push_str("];\n");
    let _ = writeln!(list, "{constants}];");
    let prelude = compose_prelude().unwrap_or_else(|error| panic!("prelude of effects:\n{error}"));
    let _ = writeln!(list, "/// What effects find declared.\npub const EFFECT_PRELUDE: &str = {prelude:?};");
    let table = directional_albedo_table();
    let _ = writeln!(
        list,
        "/// Scale and bias of f0, and the albedo of sheen, 32 by 32, over n·v and perceptual roughness.\npub const DIRECTIONAL_ALBEDO: [[f32; 3]; {}] = {table:?};",
        table.len()
    );
    fs::write(Path::new(out).join("programs.rs"), list).expect("the output folder is writable");
}

/// Every declaration of the modules that `prelude.wgsl` imports, used or not; of constants only those which they need,
/// because every name is one that effects cannot give.
fn compose_prelude() -> Result<String, String> {
    let path = "package::effect::prelude".parse().map_err(|error| format!("{error}"))?;
    let is_wanted = |name: &str| name.starts_with("SRGB_") || ["DISTANCE_BACKGROUND_M", "RADIANCE_MAX"].contains(&name);
    composer(false, is_wanted).compile(&path).map(|result| result.to_string()).map_err(|error| error.to_string())
}

/// Finds modules in `src`, and the constants that are `wanted` in `package::constants`.
fn composer(strip: bool, wanted: impl Fn(&str) -> bool) -> Wesl<Router> {
    let mut virtual_modules = VirtualResolver::new();
    virtual_modules.add_module("package".parse().expect("a path"), constants::as_wgsl(wanted).into());
    let mut router = Router::new();
    router.mount_resolver("package::constants".parse().expect("a path"), virtual_modules);
    router.mount_fallback_resolver(FileResolver::new("src"));
    let mut wesl = Wesl::new("src").set_custom_resolver(router);
    wesl.set_mangler(ManglerKind::None);
    wesl.set_options(CompileOptions { strip, imports: true, condcomp: true, lower: false, ..Default::default() });
    wesl
}

fn compose(program: &programs::Declared, variant: usize) -> Result<String, String> {
    let programs::Declared { module, axes, features, .. } = program;
    let mut wesl = composer(true, |_| true);
    for (bit, axis) in axes.iter().enumerate() {
        wesl.set_feature(axis, variant >> bit & 1 == 1);
    }
    for feature in features {
        wesl.set_feature(feature, true);
    }
    // An axis that a module does not list is off.
    wesl.set_missing_feature_behavior(false);
    wesl.keep_all_entrypoints();
    let path = module.parse().map_err(|error| format!("{module}: {error}"))?;
    wesl.compile(&path).map(|result| result.to_string()).map_err(|error| error.to_string())
}

/// The fit of shadowing in Estevez & Kulla 2017, "Production Friendly Microfacet Sheen BRDF"; twin of `layers.wgsl`.
fn sheen_shadowing(cosine: f64, alpha: f64) -> f64 {
    let share = (1.0 - alpha) * (1.0 - alpha);
    let mix = |rough: f64, smooth: f64| rough + (smooth - rough) * share;
    let (a, b, c) = (mix(21.5473, 25.3245), mix(3.82987, 3.32435), mix(0.19823, 0.16801));
    let (d, e) = (mix(-1.97760, -1.27393), mix(-4.32054, -4.85967));
    let curve = |x: f64| a / (1.0 + b * x.max(1e-6).powf(c)) + d * x + e;
    if cosine < 0.5 { curve(cosine).exp() } else { (2.0 * curve(0.5) - curve(1.0 - cosine)).exp() }
}

/// What sheen of a perceptual roughness reflects of light from everywhere, by directions that are spread evenly.
fn sheen_albedo(n_dot_v: f64, roughness: f64) -> f64 {
    const POINTS: u32 = 4096;
    let roughness = roughness.max(0.07);
    let alpha = roughness * roughness;
    let eye = [(1.0 - n_dot_v * n_dot_v).sqrt(), 0.0, n_dot_v];
    let point = |i: u32| {
        let phi = 2.0 * std::f64::consts::PI * (f64::from(i) + 0.5) / f64::from(POINTS);
        let n_dot_l = (f64::from(i.reverse_bits()) / 4_294_967_296.0).max(1e-3);
        let sine = (1.0 - n_dot_l * n_dot_l).sqrt();
        let sum = [eye[0] + sine * phi.cos(), sine * phi.sin(), eye[2] + n_dot_l];
        let length = sum.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-9);
        let n_dot_half = sum[2] / length;
        let sine_squared = (1.0 - n_dot_half * n_dot_half).max(1e-4);
        let distribution = (2.0 + 1.0 / alpha) * sine_squared.powf(0.5 / alpha) / std::f64::consts::TAU;
        let shadowing = 1.0 + sheen_shadowing(n_dot_v, alpha) + sheen_shadowing(n_dot_l, alpha);
        distribution / (shadowing * 4.0 * n_dot_l * n_dot_v).max(1e-5) * n_dot_l
    };
    (0..POINTS).map(point).sum::<f64>() * std::f64::consts::TAU / f64::from(POINTS)
}

/// Importance-samples GGX for every texel (Karis 2013, "Real Shading in Unreal Engine 4"), with the height-correlated
/// visibility of `brdf.wgsl`. 4,096 Hammersley points keep the error below the step of the half floats that hold it.
fn directional_albedo_table() -> Vec<[f32; 3]> {
    const SIZE: u32 = constants::DIRECTIONAL_ALBEDO_SIZE;
    const POINTS: u32 = 4096;
    let mut table = Vec::new();
    for row in 0..SIZE {
        let roughness = (f64::from(row) / f64::from(SIZE - 1)).max(constants::ROUGHNESS_PERCEPTUAL_MIN.into());
        let alpha = roughness * roughness;
        let a2 = alpha * alpha;
        for column in 0..SIZE {
            let n_dot_v = (f64::from(column) / f64::from(SIZE - 1)).max(1e-4);
            let eye = [(1.0 - n_dot_v * n_dot_v).sqrt(), 0.0, n_dot_v];
            let (mut scale, mut bias) = (0.0, 0.0);
            for i in 0..POINTS {
                let phi = 2.0 * std::f64::consts::PI * (f64::from(i) + 0.5) / f64::from(POINTS);
                let u = f64::from(i.reverse_bits()) / 4_294_967_296.0;
                let cos = ((1.0 - u) / (1.0 + (a2 - 1.0) * u)).sqrt();
                let sin = (1.0 - cos * cos).max(0.0).sqrt();
                let half = [sin * phi.cos(), sin * phi.sin(), cos];
                let v_dot_h = (eye[0] * half[0] + eye[2] * half[2]).max(0.0);
                let n_dot_l = 2.0 * v_dot_h * half[2] - eye[2];
                if n_dot_l > 0.0 {
                    let light = n_dot_v * (n_dot_l * n_dot_l * (1.0 - a2) + a2).sqrt();
                    let back = n_dot_l * (n_dot_v * n_dot_v * (1.0 - a2) + a2).sqrt();
                    let weight = 0.5 / (light + back) * 4.0 * n_dot_l * v_dot_h / half[2].max(1e-9);
                    let fresnel = (1.0 - v_dot_h).powi(5);
                    scale += weight * (1.0 - fresnel);
                    bias += weight * fresnel;
                }
            }
            let ggx = [scale, bias].map(|sum| (sum / f64::from(POINTS)) as f32);
            let sheen = sheen_albedo(n_dot_v.max(1e-2), f64::from(row) / f64::from(SIZE - 1)).min(1.0);
            table.push([ggx[0], ggx[1], sheen as f32]);
        }
    }
    table
}
