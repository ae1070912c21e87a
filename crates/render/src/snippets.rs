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
