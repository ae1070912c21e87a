//! A window: drag to orbit, turn the wheel to zoom, resize. `cargo run --release -p manypass --example window --
//! [MODEL]` shows a file, or 1,000 moving lights. `--frames N --out PICTURE` ends after N frames and saves the last.

mod lamps;
mod orbit;

use manypass::scene::{self, Scene};
use manypass::{Exposure, FrameRequest, Gpu, Renderer, Target, wgpu};
use std::{error::Error, sync::Arc};
use wgpu::CurrentSurfaceTexture::{Suboptimal, Success};
use winit::{application::ApplicationHandler, event::WindowEvent, event_loop::ActiveEventLoop, window::Window};

struct App {
    scene: Scene,
    orbit: orbit::Orbit,
    frame: u32,
    /// After how many frames it ends, and the picture that it then saves.
    end: Option<(u32, String)>,
    shown: Option<(Arc<Window>, wgpu::Surface<'static>, wgpu::SurfaceConfiguration, Renderer, FrameRequest)>,
}

impl App {
    fn open(&mut self, events: &ActiveEventLoop) -> Result<(), Box<dyn Error>> {
        let window = Arc::new(events.create_window(Window::default_attributes().with_title("Manypass"))?);
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let surface = instance.create_surface(window.clone())?;
        let (gpu, config) = Gpu::for_surface(&instance, &surface, window.inner_size().into())?;
        surface.configure(&gpu.device, &config);
        let mut renderer = Renderer::new(gpu)?;
        let mut request = FrameRequest::of_scene(&self.scene, config.width, config.height);
        request.goes_on = true;
        renderer.expose(&self.scene, &mut request, Exposure::of_scene(&self.scene))?;
        window.request_redraw();
        self.shown = Some((window, surface, config, renderer, request));
        Ok(())
    }

    fn draw(&mut self, events: &ActiveEventLoop) -> Result<(), Box<dyn Error>> {
        let Some((window, surface, config, renderer, request)) = &mut self.shown else { return Ok(()) };
        window.request_redraw();
        let (width, height) = window.inner_size().into();
        if (config.width, config.height) != (width, height) {
            (config.width, config.height) = (u32::max(width, 1), u32::max(height, 1));
            surface.configure(&renderer.gpu().device, config);
        }
        let (Success(output) | Suboptimal(output)) = surface.get_current_texture() else {
            surface.configure(&renderer.gpu().device, config);
            return Ok(());
        };
        lamps::move_all(&mut self.scene, self.frame);
        request.camera.world_from_view = self.orbit.world_from_view();
        (request.width, request.height) = (config.width, config.height);
        renderer.render_to(&self.scene, request, &Target::whole(&output.texture))?;
        renderer.gpu().queue.present(output);
        self.frame += 1;
        if let Some((_, out)) = self.end.as_ref().filter(|(last, _)| self.frame == *last) {
            let rgba8 = renderer.read_display()?;
            image::save_buffer(out, &rgba8, config.width, config.height, image::ColorType::Rgba8)?;
            events.exit();
        }
        Ok(())
    }
}

impl ApplicationHandler for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        self.open(events).expect("a window to draw in");
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: winit::window::WindowId, event: WindowEvent) {
        self.orbit.follow(&event);
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::RedrawRequested => self.draw(events).expect("a frame"),
            _ => {}
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let after = |flag: &str| arguments.iter().skip_while(|it| *it != flag).nth(1).cloned();
    let end = after("--frames").and_then(|frames| frames.parse().ok()).zip(after("--out"));
    let model = arguments.first().filter(|it| !it.starts_with("--"));
    let scene = model.map_or(Ok(lamps::scene()), |file| scene::load_path(file.as_ref()).map(|it| it.scene))?;
    let orbit = orbit::Orbit::around(&scene);
    let mut app = App { scene, orbit, frame: 0, end, shown: None };
    Ok(winit::event_loop::EventLoop::new()?.run_app(&mut app)?)
}
