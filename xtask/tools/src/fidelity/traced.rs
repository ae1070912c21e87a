//! The table of path-traced pictures: Mitsuba 3 (`xtask/mitsuba`) and our frame, of the same files, in linear light.

use super::Fidelity;
use super::made::{self, Subject};
use super::pictures::vector;
use super::scenarios;
use crate::step::{check, last_json, root};
use crate::table::median;
use anyhow::{Context, Result, bail};
use manypass_testkit::needs;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::Command;
use xtask::setup;

/// The samples of a pixel, ours and Mitsuba's.
const OUR_SAMPLES: &str = "64";
const SAMPLES: u32 = 64;
/// The pixels of the longer side.
const SIDE_PX: f64 = 288.0;

/// A scene: its name, its model, and its environment (none: the file's lights alone).
struct TracedScene {
    name: &'static str,
    model: Model,
    environment: Option<&'static str>,
    /// Flags of the camera, which otherwise frames the model.
    camera: &'static [&'static str],
}

/// Where a model is from.
#[derive(Clone, Copy)]
enum Model {
    /// That of the published scene of the same name, with its camera.
    Published,
    /// Below the folder of assets.
    Asset(&'static str),
    /// Written here, with lights of its own where there is no environment.
    Made(Subject),
}

const ROOM: Option<&str> = Some("environments/lightroom_14b_approx_1k.hdr");
const DAWN: Option<&str> = Some("environments/spruit_sunrise_1k.hdr");

/// A published scene under an environment.
const fn sky(name: &'static str, environment: Option<&'static str>) -> TracedScene {
    TracedScene { name, model: Model::Published, environment, camera: &[] }
}

/// A file under an environment.
const fn asset(name: &'static str, model: &'static str, environment: Option<&'static str>) -> TracedScene {
    TracedScene { name, model: Model::Asset(model), environment, camera: &[] }
}

/// A model that is written here, seen from the front.
const fn made(name: &'static str, subject: Subject, environment: Option<&'static str>) -> TracedScene {
    TracedScene {
        name,
        model: Model::Made(subject),
        environment,
        camera: &["--eye", "1.5,1,6.5", "--target", "0,0,0", "--fov-y", "32"],
    }
}

/// A file with lights of its own, without environment.
const fn lamps(name: &'static str, model: &'static str) -> TracedScene {
    asset(name, model, None)
}

const ANISOTROPY: &str = "khronos-sample-assets/Models/AnisotropyStrengthTest/glTF-Binary/AnisotropyStrengthTest.glb";
const GLOSSINESS: &str = "gltf-transform/core/test/in/BoxTextured_glTF-pbrSpecularGlossiness/BoxTextured.gltf";

/// What core glTF can say, and the extensions of which no one has published a picture that we have.
const SCENES: [TracedScene; 24] = [
    sky("Duck", ROOM),
    sky("BoxTextured", ROOM),
    sky("DamagedHelmet", DAWN),
    sky("FlightHelmet", ROOM),
    sky("Fox", ROOM),
    sky("MetalRoughSpheresNoTextures", ROOM),
    sky("NormalTangentMirrorTest", ROOM),
    sky("NormalTangentTest", DAWN),
    sky("OrientationTest", DAWN),
    sky("TextureEncodingTest", ROOM),
    sky("VertexColorTest", ROOM),
    lamps("geometry-camera-light", "playcanvas/geometry-camera-light.glb"),
    lamps("lightfield_16", "lightfield/lightfield_16.glb"),
    lamps("shadow_mapping_points", "renderling/shadow_mapping_points.glb"),
    lamps("shadow_mapping_spots", "renderling/shadow_mapping_spots.glb"),
    asset("AnisotropyStrengthTest", ANISOTROPY, ROOM),
    made("anisotropy", Subject::Anisotropy, ROOM),
    made("anisotropy", Subject::Anisotropy, None),
    made("diffuse_transmission", Subject::DiffuseTransmission, ROOM),
    made("diffuse_transmission", Subject::DiffuseTransmission, None),
    asset("BoxTextured-glossiness", GLOSSINESS, ROOM),
    made("specular_glossiness", Subject::SpecularGlossiness, ROOM),
    made("specular_glossiness", Subject::SpecularGlossiness, None),
    TracedScene {
        camera: &["--eye", "0.04,0.03,0.2", "--target", "0,0,0", "--fov-y", "35"],
        ..asset("DispersionTest", "threejs/DispersionTest.glb", ROOM)
    },
];

/// Whether a scene is path-traced.
pub(super) fn has(name: &str) -> bool {
    SCENES.iter().any(|scene| scene.name == name)
}

/// A scene whose picture of ours is there, and what Mitsuba is to draw.
struct Job {
    name: String,
    light: &'static str,
    ours: PathBuf,
    truth: PathBuf,
    direct: PathBuf,
    value: Value,
}

/// Renders ours, then Mitsuba's, compares and prints the table.
///
/// # Errors
/// There is no Mitsuba, or nothing could be rendered.
pub(super) fn print(run: &mut Fidelity) -> Result<()> {
    let python = setup::mitsuba()?;
    let assets = needs::assets_folder();
    let mut jobs = Vec::new();
    for scene in SCENES.iter().filter(|scene| run.options.wants(scene.name)) {
        match run.job(scene, &assets) {
            Ok(job) => jobs.push(job),
            Err(error) => run.failures.push(format!("{}: {error:#}", scene.name)),
        }
    }
    if jobs.is_empty() {
        return Ok(());
    }
    let list = run.folder.join("jobs.json");
    // A picture that is there was made of the same job: it is part of the file's name.
    let open: Vec<&Value> =
        jobs.iter().filter(|job| !job.truth.is_file() || !job.direct.is_file()).map(|job| &job.value).collect();
    if !open.is_empty() {
        println!("\nMitsuba draws {} of {} scenes; pictures that are there already are kept", open.len(), jobs.len());
        std::fs::write(&list, json!(open).to_string()).with_context(|| format!("writing {}", list.display()))?;
        check(setup::with_llvm(Command::new(python).arg(root().join("xtask/mitsuba/truth.py")).arg(&list)))?;
    }
    run.print_traced(&jobs)
}

impl Fidelity<'_> {
    /// Draws our picture; its report has the camera, which is Mitsuba's too.
    fn job(&self, scene: &TracedScene, assets: &Path) -> Result<Job> {
        let (light, stem) = match scene.environment {
            Some(file) if file.contains("spruit") => ("sunrise", "sunrise"),
            Some(_) => ("room", "room"),
            None => ("lamps", "lamps"),
        };
        let name = format!("{}.{stem}", scene.name);
        let ours = self.folder.join(format!("{name}.ours.exr"));
        let report = self.folder.join(format!("{name}.json"));
        let mut command = Command::new(&self.program);
        command.arg("render");
        let mut size = (SIDE_PX, (SIDE_PX * 0.5625).round());
        let model = match scene.model {
            Model::Asset(model) => assets.join(model),
            Model::Made(subject) => made::write(subject, scene.environment.is_none(), &self.folder)?,
            Model::Published => {
                let all = scenarios::read(assets)?;
                let known = all.into_iter().find(|known| known.name == scene.name).context("no such scene")?;
                let model = known.model.context("its model is not on this machine")?;
                command.args(["--eye", &vector(known.eye), "--target", &vector(known.target)]);
                command.args(["--fov-y", &known.fov_y_deg.to_string()]);
                let (width, height) = known.size_px;
                let scale = SIDE_PX / width.max(height);
                size = ((width * scale).round(), (height * scale).round());
                model
            }
        };
        command.arg(&model).args(scene.camera);
        let environment = scene.environment.map(|file| assets.join(file));
        match &environment {
            Some(file) => command.arg("--environment").arg(file),
            None => command.args(["--environment", "none"]),
        };
        command.arg("-o").arg(&ours).arg("--report").arg(&report);
        command.args(["--size", &format!("{}x{}", size.0, size.1), "--samples", OUR_SAMPLES]);
        command.args(["--background", "transparent", "--quiet"]);
        command.args(&self.left_out);
        check(command.env("RUST_LOG", "off"))?;
        let text = std::fs::read_to_string(&report).with_context(|| format!("reading {}", report.display()))?;
        let said: Value = serde_json::from_str(&text).with_context(|| format!("reading {}", report.display()))?;
        let camera = &said["camera"];
        if camera["fov_y_deg"].is_null() {
            bail!("its camera has parallel rays");
        }
        let mut value = json!({
            "model": model,
            "environment": environment,
            "world_from_view": camera["world_from_view"],
            "fov_y_deg": camera["fov_y_deg"],
            "size": [size.0 as u32, size.1 as u32],
            "samples": SAMPLES,
        });
        let hash = digest(&format!("{value}{}", scripts()?));
        let reference = |kind: &str| self.folder.join(format!("{name}.{hash:016x}.{kind}.exr"));
        let (truth, direct) = (reference("truth"), reference("direct"));
        value["truth"] = json!(truth);
        value["direct"] = json!(direct);
        Ok(Job { name: scene.name.to_owned(), light, ours, truth, direct, value })
    }

    fn print_traced(&mut self, jobs: &[Job]) -> Result<()> {
        let columns = [
            ("scene", 28),
            ("light", 8),
            ("direct: mean", 7),
            ("difference", 10),
            ("HDR-FLIP", 8),
            ("truth: mean", 7),
            ("difference", 10),
            ("HDR-FLIP", 8),
        ];
        self.report.begin("Our radiance against that of a path tracer (Mitsuba 3)", &columns);
        let (mut values, mut sums) = (Vec::new(), [const { Vec::new() }; 4]);
        for job in jobs {
            let mut cells = vec![job.name.clone(), job.light.to_owned()];
            let mut value = json!({ "name": job.name, "light": job.light });
            for (index, (kind, reference)) in [("direct", &job.direct), ("truth", &job.truth)].into_iter().enumerate() {
                let mut command = Command::new(&self.program);
                command.arg("diff").arg(reference).arg(&job.ours).arg("--json");
                command.arg("-o").arg(self.folder.join(format!("{}.{}.{kind}.png", job.name, job.light)));
                let found = match last_json(&mut command) {
                    Ok(found) => found,
                    Err(error) => {
                        self.failures.push(format!("{}: {error:#}", job.name));
                        cells.extend(["-".into(), "-".into(), "-".into()]);
                        continue;
                    }
                };
                let number = |key: &str| found["radiance"][key].as_f64().unwrap_or(f64::NAN);
                let (mean, difference) =
                    (number("mean_b") / number("mean_a"), number("mean_absolute") / number("mean_a"));
                let flip = found["flip"]["mean"].as_f64().unwrap_or(f64::NAN);
                cells.extend([format!("{mean:.3}"), format!("{:.2} %", 100.0 * difference), format!("{flip:.4}")]);
                value[kind] = json!({ "mean": mean, "difference": difference, "flip": flip });
                sums[2 * index].push(difference);
                sums[2 * index + 1].push(flip);
            }
            self.report.row(cells);
            values.push(value);
        }
        let [direct, direct_flip, truth, truth_flip] = sums.map(|numbers| median(numbers).unwrap_or(f64::NAN));
        self.report.row(vec![
            format!("median of {}", values.len()),
            String::new(),
            String::new(),
            format!("{:.2} %", 100.0 * direct),
            format!("{direct_flip:.4}"),
            String::new(),
            format!("{:.2} %", 100.0 * truth),
            format!("{truth_flip:.4}"),
        ]);
        self.report.note(
            "direct: lamps with shadows, and all of the environment whatever stands before it. truth: shadows of everything, and light \
             reflected up to four times. mean: ours divided by theirs; difference: the mean absolute difference, of their mean.",
        );
        let path = self.folder.join("traced.json");
        std::fs::write(&path, format!("{:#}\n", json!(values))).with_context(|| format!("writing {}", path.display()))
    }
}

/// What Mitsuba's pictures depend on besides the job.
fn scripts() -> Result<String> {
    let read = |name: &str| {
        let path = root().join("xtask/mitsuba").join(name);
        std::fs::read_to_string(&path).with_context(|| format!("reading {}", path.display()))
    };
    Ok(["truth.py", "surfaces.py", "reflectance.py", "glass.py", "gltf.py"]
        .into_iter()
        .map(read)
        .collect::<Result<Vec<_>>>()?
        .concat())
}

/// FNV-1a (Fowler, Noll and Vo 1991).
fn digest(text: &str) -> u64 {
    text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}
