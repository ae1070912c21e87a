//! Images that come after the model which shows them.

use super::{Viewer, resolver};
use crate::types::{Resources, decode_uri};
use manypass::gpu::readback::yield_now;
use manypass::scene::turns::Turn;
use manypass::scene::{LateImages, ON_ITS_WAY, formats};
use std::cell::Cell;
use std::collections::HashSet;
use std::rc::Rc;
use wasm_bindgen::prelude::*;
use web_time::{Duration, Instant};

/// After so long the page has the thread: a frame at 60 a second.
const SLICE: Duration = Duration::from_millis(16);

/// Says that the page is to have the thread when a slice is over.
fn turns() -> impl FnMut() -> Option<Turn> {
    let began = Rc::new(Cell::new(Instant::now()));
    move || {
        let is_over = began.get().elapsed() >= SLICE;
        is_over.then(|| {
            let began = began.clone();
            let turn: Turn = Box::pin(async move {
                yield_now().await;
                began.set(Instant::now());
            });
            turn
        })
    }
}

#[wasm_bindgen]
impl Viewer {
    /// As `load`, but the model is there before its textures: those in the file come with `nextImage`, one at a time,
    /// and those of files at the addresses `late` with `giveImage`, or `missImage` where they cannot be had. Until then
    /// materials are drawn as without them. Reads and uploads in slices of some milliseconds, between which the page
    /// has the thread.
    ///
    /// # Errors
    /// As those of `load`, or the device was lost.
    #[wasm_bindgen(js_name = loadBeforeImages)]
    pub async fn load_before_images(
        &mut self,
        bytes: Vec<u8>,
        resources: Option<Resources>,
        late: Vec<String>,
    ) -> Result<(), JsError> {
        let loss = self.loss.clone();
        loss.or(self.load_in_turns(bytes, resources, late)).await
    }

    /// The decoded addresses of the image files that the model still waits for.
    #[wasm_bindgen(js_name = missingImages)]
    pub fn missing_images(&self) -> Vec<String> {
        self.late.missing().map(str::to_owned).collect()
    }

    /// Whether images of the model are still to come: with `nextImage`, `giveImage` or `missImage`.
    #[wasm_bindgen(js_name = waitsForImages)]
    pub fn waits_for_images(&self) -> bool {
        !self.late.is_complete()
    }

    /// Takes an image file that the model waits for. The next `render` shows it.
    ///
    /// # Errors
    /// When it is no image; the model stays without it, as after `missImage`.
    #[wasm_bindgen(js_name = giveImage)]
    pub fn give_image(&mut self, uri: &str, bytes: Vec<u8>) -> Result<(), JsError> {
        let scene = self.scene.as_mut().ok_or_else(|| JsError::new("no model is loaded"))?;
        match self.late.give(scene, uri, bytes) {
            Ok(_) => self.finish_images(),
            Err(error) => {
                self.miss_image(uri, &error.to_string())?;
                Err(error.into())
            }
        }
    }

    /// Says that an image file which the model waits for does not come, and why: materials stay without it, with a
    /// warning.
    ///
    /// # Errors
    /// When the device fails.
    #[wasm_bindgen(js_name = missImage)]
    pub fn miss_image(&mut self, uri: &str, reason: &str) -> Result<(), JsError> {
        if self.late.give_up(uri) > 0 {
            self.warnings.push(format!("image `{uri}` was not loaded, and materials do without it: {reason}"));
            self.finish_images()?;
        }
        Ok(())
    }

    /// Takes the next of the images that came with the model, so that the next `render` shows it. False if there is
    /// none left.
    ///
    /// # Errors
    /// When the device fails.
    #[wasm_bindgen(js_name = nextImage)]
    pub fn next_image(&mut self) -> Result<bool, JsError> {
        let Some(scene) = &mut self.scene else { return Ok(false) };
        let is_there = self.late.show_next(scene);
        if is_there {
            self.finish_images()?;
        }
        Ok(is_there)
    }
}

impl Viewer {
    async fn load_in_turns(
        &mut self,
        bytes: Vec<u8>,
        resources: Option<Resources>,
        late: Vec<String>,
    ) -> Result<(), JsError> {
        let mut turns = turns();
        let mut resolve = resolver(resources);
        let decoded: HashSet<String> = late.iter().map(|late| decode_uri(late)).collect();
        let late: HashSet<String> = late.into_iter().collect();
        let mut later = |uri: &str| {
            let is_late = late.contains(uri) || decoded.contains(uri);
            resolve(uri).map_err(|message| if is_late { ON_ITS_WAY.to_owned() } else { message })
        };
        let mut loaded = formats::load_bytes_in_turns(&bytes, &mut later, "the model", &mut turns).await?;
        let images = LateImages::withheld(&mut loaded.scene);
        if !self.options.simplifies() {
            self.renderer.load_in_turns(&loaded.scene, &mut turns).await?;
        }
        self.take_in_turns(loaded.scene, loaded.warnings, None, &mut turns).await?;
        self.late = images;
        Ok(())
    }

    /// Once no image is to come any more, light is metered anew, and what is wrong with them is said.
    fn finish_images(&mut self) -> Result<(), JsError> {
        let Some(scene) = self.scene.as_ref().filter(|_| self.late.is_complete()) else { return Ok(()) };
        self.renderer.load(scene)?;
        self.warnings.extend(self.renderer.warnings());
        self.metering = None;
        Ok(())
    }
}
