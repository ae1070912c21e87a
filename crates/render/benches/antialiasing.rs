//! How near ways of anti-aliasing come to stills of many samples, at 480×270, while a camera moves through the demo hall
//! and around a figure that runs; how much they flicker where nothing moves; and how long a frame takes.
//! `cargo bench -p manypass --bench antialiasing`, with `-- --stride 1` against every frame, not every
//! sixth; `--ways temporal` measures those alone whose names begin so, and `--pictures FOLDER` writes
//! the last of the compared frames of each way. One line of JSON, for `cargo xtask bench`.

use glam::{Mat4, Quat, Vec3};
use manypass::scene::{Framing, Scene, demo, load_path};
use manypass::{Averaging, EffectFile, FrameRequest, Gpu, Renderer, Settings, UpscaleMethod, View, WgslEffect};
use manypass_testkit::compare::{Picture, flip, psnr_db, ssim};
use manypass_testkit::needs::assets_folder;
use serde_json::{Value, json};
use std::error::Error;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

const SIZE: (u32, u32) = (480, 270);
/// Of the move.
const FRAMES: u16 = 60;
const FRAMES_A_SECOND: f32 = 24.0;
/// Every so many of them are compared, because what they are compared with takes long.
const STRIDE: usize = 6;
const SAMPLES: u32 = 64;
/// Where nothing moves: frames before those that are compared, and how many are.
const STILL_BEFORE: usize = 32;
const STILL: usize = 13;
const FOX: &str = "khronos-sample-assets/Models/Fox/glTF-Binary/Fox.glb";

/// A way of anti-aliasing.
struct Way {
    name: &'static str,
    effect: Option<&'static str>,
    is_temporal: bool,
    scale: f32,
}

const fn way(name: &'static str, effect: Option<&'static str>, is_temporal: bool, scale: f32) -> Way {
    Way { name, effect, is_temporal, scale }
}

const WAYS: [Way; 8] = [
    way("none", None, false, 1.0),
    way("FXAA", Some("fxaa"), false, 1.0),
    way("SMAA", Some("smaa"), false, 1.0),
    way("TAA", None, true, 1.0),
    way("spatial, 67 %", None, false, 0.67),
    way("spatial, 50 %", None, false, 0.5),
    way("temporal, 67 %", None, true, 0.67),
    way("temporal, 50 %", None, true, 0.5),
];

impl Way {
    fn set(&self, settings: &mut Settings) {
        settings.render.scale = self.scale;
        settings.taa.enabled = self.is_temporal;
        settings.upscale.method = match (self.scale < 1.0, self.is_temporal) {
            (false, _) => UpscaleMethod::Bilinear,
            (true, false) => UpscaleMethod::Edges,
            (true, true) => UpscaleMethod::Temporal,
        };
    }
}

/// What is drawn, and how it moves.
struct Move {
    name: &'static str,
    scene: Scene,
    animation: Option<usize>,
    request: FrameRequest,
    /// The camera, by the share of the move.
    camera: Box<dyn Fn(f32) -> View>,
}

impl Move {
    /// Down the nave, with a turn to the right.
    fn hall() -> Self {
        let scene = demo::hall();
        let request = FrameRequest::of_scene(&scene, SIZE.0, SIZE.1);
        let first = request.camera;
        let camera = move |share: f32| {
            let step = Mat4::from_rotation_translation(
                Quat::from_rotation_y(-0.35 * share),
                Vec3::new(0.8, 0.15, -5.0) * share,
            );
            View { world_from_view: first.world_from_view * step, ..first }
        };
        Self { name: "hall", scene, animation: None, request, camera: Box::new(camera) }
    }

    /// A figure that runs, and an eighth of a turn around it.
    fn figure() -> Result<Self, Box<dyn Error>> {
        let mut scene = load_path(&assets_folder().join(FOX))?.scene;
        let animation = 2;
        let framing = Framing::of_animation(&mut scene, animation);
        let request = FrameRequest::of_scene(&scene, SIZE.0, SIZE.1);
        let first = View::framing(&framing, SIZE.0 as f32 / SIZE.1 as f32);
        let center = framing.bounds_world().center();
        let camera = move |share: f32| {
            let turn = Mat4::from_rotation_y(0.25 * std::f32::consts::PI * share);
            let around = Mat4::from_translation(center) * turn * Mat4::from_translation(-center);
            View { world_from_view: around * first.world_from_view, ..first }
        };
        let camera = Box::new(camera);
        Ok(Self { name: "skinned figure", scene, animation: Some(animation), request, camera })
    }

    /// The scene of a frame of the move, and what is asked for.
    fn at(&self, frame: u16) -> (Scene, FrameRequest) {
        let mut scene = self.scene.clone();
        if let Some(animation) = self.animation {
            scene.pose(animation, f32::from(frame) / FRAMES_A_SECOND);
            scene.update_transforms();
        }
        let camera = (self.camera)(f32::from(frame) / f32::from(FRAMES - 1));
        let request = FrameRequest { camera, averaging: Averaging::Display, ..self.request.clone() };
        (scene, request)
    }
}

fn picture(renderer: &mut Renderer) -> Result<Picture, Box<dyn Error>> {
    Ok(Picture::from_rgba8(SIZE.0 as usize, SIZE.1 as usize, &renderer.read_display()?))
}

/// A frame of `way`, and the milliseconds until it was read.
fn frame(
    renderer: &mut Renderer,
    way: &Way,
    effect: Option<&Arc<WgslEffect>>,
    (scene, request): &(Scene, FrameRequest),
) -> Result<(Picture, f64), Box<dyn Error>> {
    let mut request = FrameRequest { goes_on: true, ..request.with(|settings| way.set(settings)) };
    request.effects.extend(effect.map(|effect| effect.clone() as _));
    let started = Instant::now();
    renderer.render(scene, &request)?;
    let shown = picture(renderer)?;
    Ok((shown, 1e3 * started.elapsed().as_secs_f64()))
}

/// The same frame of many samples.
fn reference(renderer: &mut Renderer, (scene, request): &(Scene, FrameRequest)) -> Result<Picture, Box<dyn Error>> {
    for sample_index in 0..SAMPLES {
        renderer.render(scene, &FrameRequest { sample_index, sample_count: SAMPLES, ..request.clone() })?;
    }
    picture(renderer)
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0u32), |(sum, count), value| (sum + value, count + 1));
    sum / f64::from(count.max(1))
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Writes the last of some pictures into a folder, if one was named.
fn write(folder: Option<&str>, name: &str, pictures: &[Picture]) -> Result<(), Box<dyn Error>> {
    let (Some(folder), Some(last)) = (folder, pictures.last()) else { return Ok(()) };
    let path = Path::new(folder).join(format!("{}.png", name.replace(' ', "_")));
    let size = (last.width as u32, last.height as u32);
    Ok(image::save_buffer(path, last.pixels.as_flattened(), size.0, size.1, image::ColorType::Rgba8)?)
}

/// What the words of the command line ask for.
struct BenchOptions<'w> {
    stride: usize,
    /// Those whose names begin so.
    ways: Option<&'w str>,
    folder: Option<&'w str>,
}

/// Measures the ways of one move.
fn measure(renderer: &mut Renderer, of: &Move, wanted: &BenchOptions<'_>) -> Result<Value, Box<dyn Error>> {
    renderer.load(&of.scene)?;
    let frames: Vec<_> = (0..FRAMES).map(|frame| of.at(frame)).collect();
    let compared: Vec<usize> = (0..frames.len()).skip(wanted.stride - 1).step_by(wanted.stride).collect();
    let references: Vec<Picture> =
        compared.iter().map(|at| reference(renderer, &frames[*at])).collect::<Result<_, _>>()?;
    write(wanted.folder, &format!("{} reference", of.name), &references)?;
    let mut rows = Vec::new();
    for way in WAYS.iter().filter(|way| wanted.ways.is_none_or(|wanted| way.name.starts_with(wanted))) {
        let effect = match way.effect.and_then(EffectFile::built_in) {
            Some(file) => Some(Arc::new(WgslEffect::compile(renderer.gpu(), file?)?)),
            None => None,
        };
        renderer.cut();
        let mut shown = Vec::new();
        let mut times_ms = Vec::new();
        for (at, asked) in frames.iter().enumerate() {
            let (picture, ms) = frame(renderer, way, effect.as_ref(), asked)?;
            times_ms.push(ms);
            if compared.contains(&at) {
                shown.push(picture);
            }
        }
        write(wanted.folder, &format!("{} {}", of.name, way.name), &shown)?;
        let pairs = || references.iter().zip(&shown);
        renderer.cut();
        let middle = &frames[frames.len() / 2];
        for _ in 0..STILL_BEFORE {
            frame(renderer, way, effect.as_ref(), middle)?;
        }
        let still: Vec<Picture> = (0..STILL)
            .map(|_| Ok(frame(renderer, way, effect.as_ref(), middle)?.0))
            .collect::<Result<_, Box<dyn Error>>>()?;
        rows.push(json!({
            "name": way.name,
            "psnr_db": mean(pairs().map(|(a, b)| psnr_db(a, b))),
            "ssim": mean(pairs().map(|(a, b)| ssim(a, b))),
            "flip": mean(pairs().map(|(a, b)| flip(a, b).mean())),
            "flicker": mean(still.windows(2).map(|pair| flip(&pair[0], &pair[1]).mean())),
            "ms": median(times_ms),
        }));
        eprintln!("{}: {}", of.name, rows.last().unwrap_or(&Value::Null));
    }
    Ok(json!({ "name": of.name, "rows": rows, "compared": compared.len(), "frames": FRAMES }))
}

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().collect();
    let word_after = |flag: &str| words.iter().skip_while(|word| *word != flag).nth(1).map(String::as_str);
    let stride = word_after("--stride").map_or(Ok(STRIDE), str::parse)?.clamp(1, usize::from(FRAMES));
    let wanted = BenchOptions { stride, ways: word_after("--ways"), folder: word_after("--pictures") };
    let mut renderer = Renderer::new(Gpu::headless(None)?)?;
    let mut scenes = vec![measure(&mut renderer, &Move::hall(), &wanted)?];
    let mut skipped = Vec::new();
    match Move::figure() {
        Ok(figure) => scenes.push(measure(&mut renderer, &figure, &wanted)?),
        Err(error) => skipped.push(format!("the skinned figure is not measured: {error}")),
    }
    println!("{}", json!({ "scenes": scenes, "skipped": skipped, "samples": SAMPLES }));
    Ok(())
}
