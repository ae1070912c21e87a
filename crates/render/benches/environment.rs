//! What pictures of the environment cost: prefiltering one of 2048 by 1024, having it from a cache, and the studio.
//! `cargo bench -p manypass --bench environment`.

use glam::{Mat4, Vec3};
use manypass::scene::{Cache, EnvironmentMap, Projection, Scene};
use manypass::{Environment, FrameRequest, Gpu, Renderer, View};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// The least of so many counts: other work only makes things slower.
const TURNS: usize = 3;

/// A cache in memory, which says how much it holds.
#[derive(Debug, Default)]
struct MemoryCache(Mutex<HashMap<String, Vec<u8>>>);

impl Cache for MemoryCache {
    fn get(&self, name: &str) -> Option<Vec<u8>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get(name).cloned()
    }

    fn put(&self, name: &str, bytes: &[u8]) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(name.to_owned(), bytes.to_vec());
    }
}

/// Milliseconds until a frame with the scene's environment is whole, of a new renderer that has drawn another frame
/// before.
fn first_frame_ms(
    scene: &Scene,
    source: Environment,
    cache: Option<Arc<dyn Cache>>,
) -> Result<f64, Box<dyn std::error::Error>> {
    let mut renderer = Renderer::new(Gpu::headless(None)?)?;
    renderer.set_cache(cache);
    let projection = Projection::Perspective { fov_y_rad: 1.0, near_m: 0.1, far_m: None };
    let mut request = FrameRequest::new(16, 16, View { world_from_view: Mat4::IDENTITY, projection });
    request.settings.environment.source = Environment::None;
    let empty = Scene::default();
    renderer.load(&empty)?;
    renderer.render(&empty, &request)?;
    renderer.read_display()?;
    request.settings.environment.source = source;
    let started = Instant::now();
    renderer.load(scene)?;
    renderer.render(scene, &request)?;
    renderer.read_display()?;
    Ok(started.elapsed().as_secs_f64() * 1e3)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A sky with a sun and lamps on a grid, so that no part of it is even.
    let map = EnvironmentMap::from_fn("bench", 2048, 1024, |to| {
        let lamps = (24.0 * to).map(f32::sin).element_product().max(0.6) - 0.6;
        Vec3::new(0.3, 0.4, 0.6) * (1.0 + to.y) + Vec3::splat(20.0 * lamps + if to.x > 0.9999 { 9e3 } else { 0.0 })
    });
    let scene = Scene { environment: Some(Arc::new(map)), ..Scene::default() };
    let kept = Arc::new(MemoryCache::default());
    let least = |measure: &dyn Fn() -> Result<f64, Box<dyn std::error::Error>>| {
        (0..TURNS).try_fold(f64::MAX, |least, _| measure().map(|ms| least.min(ms)))
    };
    let cold = least(&|| first_frame_ms(&scene, Environment::File, None))?;
    first_frame_ms(&scene, Environment::File, Some(kept.clone()))?;
    let warm = least(&|| first_frame_ms(&scene, Environment::File, Some(kept.clone())))?;
    // The first in a process computes it.
    let studio_first = first_frame_ms(&Scene::default(), Environment::Studio, None)?;
    let studio = least(&|| first_frame_ms(&Scene::default(), Environment::Studio, None))?;
    let studio_added = studio_first - studio;
    let bytes: usize = kept.0.lock().unwrap_or_else(PoisonError::into_inner).values().map(Vec::len).sum();
    // One line of JSON, for `cargo xtask bench`.
    println!(
        "{{\"cold_ms\": {cold:.1}, \"cached_ms\": {warm:.1}, \"cached_bytes\": {bytes}, \"studio_ms\": {studio:.1}, \
         \"studio_added_ms\": {studio_added:.1}}}"
    );
    Ok(())
}
