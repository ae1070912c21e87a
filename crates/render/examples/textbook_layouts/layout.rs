//! Draws a scene by a layout, and by our own frame, and measures both alike.

use crate::content::Content;
use manypass::graph::{Executor, Export, Graph, Limits, Plan, RunOptions, Target};
use manypass::{
    Background, Environment, Exposure, FrameRequest, Gpu, LightCulling, ReflectanceModel, Renderer, Tonemap,
};
use std::time::Instant;

/// Frames that are drawn before any is timed: they make textures, pipelines and bind groups.
const WARM_UP_FRAMES: usize = 2;

type Error = Box<dyn std::error::Error>;

/// A way to draw the content that it was made with.
pub trait Layout {
    /// Declares the passes of a frame; the export is the picture.
    fn declare<'f>(&'f self, graph: &mut Graph<'f>, size: (u32, u32)) -> Export;
}

/// What a frame looks like and costs.
#[derive(Debug)]
pub struct Measurement {
    /// sRGB, rows from the top.
    pub rgba8: Vec<u8>,
    /// What the passes draw surfaces to, with depth, in bytes a pixel.
    pub gbuffer_bytes: f64,
    /// All textures of the frame, in bytes a pixel.
    pub held_bytes: f64,
    /// What all passes write if each covers its targets once, in bytes a pixel.
    pub written_bytes: f64,
    /// The time in which a frame was recorded and drawn.
    pub frame_ms: f64,
}

/// How pictures are drawn.
#[derive(Clone, Copy, Debug)]
pub struct Shot {
    /// Width and height in pixels.
    pub size: (u32, u32),
}

impl Shot {
    /// Draws by a layout.
    ///
    /// # Errors
    /// A plan beyond `limits`, or a device that was lost.
    pub fn layout(&self, gpu: &Gpu, layout: &dyn Layout, limits: Limits) -> Result<Measurement, Error> {
        let mut executor = Executor::new(&gpu.device, &gpu.queue);
        let mut drawn = None;
        let frame_ms = Self::timed_ms(|| {
            let mut graph = executor.graph(limits);
            let export = layout.declare(&mut graph, self.size);
            let plan = graph.plan()?;
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            let run = executor.run(graph, &plan, &mut encoder, &RunOptions::default())?;
            gpu.queue.submit([encoder.finish()]);
            executor.end_frame(&run);
            gpu.wait();
            drawn = Some((run, export, plan));
            Ok(())
        })?;
        gpu.check()?;
        let (run, export, plan) = drawn.ok_or("no frame was drawn")?;
        let picture = run.exported(export).ok_or("the plan has no picture")?;
        let rgba8 = pollster::block_on(manypass::gpu::readback::read_texture(gpu, picture))?;
        Ok(self.measured(rgba8, &plan, frame_ms))
    }

    /// Draws by our own frame, with the reflectance that layouts have.
    ///
    /// # Errors
    /// A device that was lost.
    pub fn ours(
        &self,
        renderer: &mut Renderer,
        content: &Content,
        culling: LightCulling,
    ) -> Result<Measurement, Error> {
        let mut request = FrameRequest::of_scene(&content.scene, self.size.0, self.size.1);
        request.settings.shading.model = ReflectanceModel::BlinnPhong;
        request.settings.lights.culling = culling;
        request.settings.environment.source = Environment::None;
        request.settings.background.source = Background::Color([0.0; 3]);
        request.settings.exposure.stops = Exposure::Stops(0.0);
        request.settings.tone_map.curve = Tonemap::None;
        request.settings.tone_map.dither = 0.0;
        request.settings.shadows.enabled = false;
        request.settings.effects.enabled = false;
        renderer.load(&content.scene)?;
        let frame_ms = Self::timed_ms(|| {
            renderer.render(&content.scene, &request)?;
            renderer.wait();
            Ok(())
        })?;
        let plan = renderer.plan(&content.scene, &request)?;
        Ok(self.measured(renderer.read_display()?, &plan, frame_ms))
    }

    fn timed_ms(mut draw: impl FnMut() -> Result<(), Error>) -> Result<f64, Error> {
        for _ in 0..WARM_UP_FRAMES {
            draw()?;
        }
        let begun = Instant::now();
        draw()?;
        Ok(begun.elapsed().as_secs_f64() * 1e3)
    }

    fn measured(&self, rgba8: Vec<u8>, plan: &Plan, frame_ms: f64) -> Measurement {
        let per_pixel = |bytes: u64| bytes as f64 / (f64::from(self.size.0) * f64::from(self.size.1));
        let bytes = plan.bytes();
        Measurement {
            rgba8,
            gbuffer_bytes: per_pixel(gbuffer_bytes(plan)),
            held_bytes: per_pixel(bytes.aliased + bytes.imported),
            written_bytes: per_pixel(plan.written_bytes()),
            frame_ms,
        }
    }
}

/// The memory of what passes called `geometry` write; textures that share it count once.
fn gbuffer_bytes(plan: &Plan) -> u64 {
    let passes = plan.passes.iter().filter(|pass| pass.name.starts_with("geometry"));
    let attachments = passes.flat_map(|pass| &pass.attachments).filter(|it| it.target != Target::DepthReadOnly);
    let textures = attachments.filter_map(|attachment| plan.textures.get(attachment.texture as usize));
    let mut slots: Vec<_> = textures.map(|texture| (texture.slot, texture.desc.bytes())).collect();
    slots.sort_unstable();
    slots.dedup();
    slots.iter().map(|(_, bytes)| bytes).sum()
}
