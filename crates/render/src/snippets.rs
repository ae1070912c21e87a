//! The Rust that pages show: doc tests, so that it compiles. A test of the program `manypass` sees that each page has
//! these lines.

/// README.md.
///
/// ```no_run
/// use manypass::{Exposure, FrameRequest, Gpu, Renderer};
///
/// let scene = manypass::scene::load_path("helmet.glb".as_ref())?.scene;
/// let mut renderer = Renderer::new(Gpu::headless(None)?)?;
/// renderer.load(&scene)?;
/// let mut request = FrameRequest::of_scene(&scene, 960, 540);
/// renderer.expose(&scene, &mut request, Exposure::of_scene(&scene))?;
/// renderer.render(&scene, &request)?;
/// let rgba8 = renderer.read_display()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Readme;

/// docs/overlay.md.
///
/// ```no_run
/// # use manypass::{FrameRequest, scene::Scene};
/// # let mut request = FrameRequest::of_scene(&Scene::default(), 960, 540);
/// use manypass::scene::overlay::{Anchor, Overlay, OverlayItem, OverlayPlace};
///
/// let title = OverlayItem::text("Helmet, draft 3", OverlayPlace::anchored(Anchor::Bottom, [0.0, -12.0].into()));
/// let lamp = OverlayItem { depth_test: true, ..OverlayItem::text("lamp", OverlayPlace::at_node("Lamp")) };
/// request.overlay = Overlay { items: vec![title, lamp] }.into();
/// ```
pub struct OverlayPage;

/// docs/stage.md.
///
/// ```no_run
/// # use manypass::FrameRequest;
/// let staged = manypass::scene::stage::load_path("hall.stage.toml".as_ref())?;
/// let mut request = FrameRequest::of_scene(&staged.scene, 960, 540);
/// request.settings.apply_stage(&staged.stage, &mut [])?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct StagePage;

/// docs/library.md, what is exported.
///
/// ```no_run
/// # #![allow(unused_imports)]
/// use manypass::{glam, graph, scene, wgpu};
/// ```
///
/// Its handles.
///
/// ```no_run
/// let mut scene = manypass::scene::load_path("room.glb".as_ref())?.scene;
/// if let Some(light) = scene.node_named("Lamp").and_then(|id| scene.light_mut(id)) {
///     light.intensity *= 2.0;
/// }
/// if let Some(paint) = scene.material_named("Paint") {
///     scene.materials[paint].base_color_factor = [0.8, 0.1, 0.1, 1.0].into();
/// }
/// scene.update_transforms();
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// Its window.
///
/// ```no_run
/// # use manypass::{FrameRequest, Gpu, Renderer, Target, scene::Scene, wgpu};
/// # fn show(window: std::sync::Arc<winit::window::Window>, scene: Scene) -> Result<(), Box<dyn std::error::Error>> {
/// # let size_px = window.inner_size().into();
/// let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
/// let surface = instance.create_surface(window)?;
/// let (gpu, config) = Gpu::for_surface(&instance, &surface, size_px)?;
/// surface.configure(&gpu.device, &config);
/// let mut renderer = Renderer::new(gpu)?;
/// if let wgpu::CurrentSurfaceTexture::Success(output) = surface.get_current_texture() {
///     let request = FrameRequest::of_scene(&scene, config.width, config.height);
///     renderer.render_to(&scene, &request, &Target::whole(&output.texture))?;
///     renderer.gpu().queue.present(output);
/// }
/// # Ok(())
/// # }
/// ```
pub struct LibraryPage;
