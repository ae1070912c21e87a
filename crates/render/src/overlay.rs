//! What is drawn over the finished picture, made ready: letters and images in one texture, and rectangles of it.
//!
//! [`manypass_scene::overlay`] says what there is to draw. Letters are rasterised when an overlay is new; where they go
//! is found for every picture, because cameras and nodes move.

mod atlas;
pub(crate) mod draw;
mod line;
mod project;
mod quads;
mod shape;

use crate::fisheye::FisheyeLens;
use crate::gpu::Gpu;
use crate::gpu::data_texture::DataTexture;
use crate::request::FrameRequest;
use atlas::Atlas;
use draw::OverlayDraw;
use manypass_scene::Scene;
use manypass_scene::overlay::{Overlay, OverlayFault};
use project::Projector;
use quads::{QUAD_TEXELS, Quads};
use shape::Shape;
use std::sync::Arc;

/// The most rectangles of an overlay: letters, boxes, images and parts of lines.
const QUADS_MAX: usize = 200_000;

/// Quads in a row of their table; `overlay.wgsl` has the same number.
const QUADS_A_ROW: u32 = 256;

/// Why an overlay cannot be drawn.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OverlayError {
    /// An item is none.
    #[error("item {item} of the overlay: {fault}")]
    Item {
        /// Its index.
        item: usize,
        /// What is wrong with it.
        fault: OverlayFault,
    },
    /// An item is at a node that is not there.
    #[error("item {item} of the overlay: the scene has no node called `{name}`")]
    NoNode {
        /// Its index.
        item: usize,
        /// The name.
        name: String,
    },
    /// There are too many.
    #[error("the overlay has more than {QUADS_MAX} letters, images and parts of lines; leave some out")]
    TooMany,
    /// They take too much room.
    #[error(
        "the letters and images of the overlay do not fit into a texture of {side} × {side} texels; make sprites and \
         letters smaller, or use fewer sizes of a font"
    )]
    Atlas {
        /// The largest side.
        side: u32,
    },
    /// The built-in font is missing from the program.
    #[error("the built-in font cannot be read; give texts a font of their own")]
    NoFont,
    /// Depth of a fisheye picture is none of one view.
    #[error("item {item} of the overlay: a fisheye picture has no depth to compare; set `depth_test` to false")]
    FisheyeDepth {
        /// Its index.
        item: usize,
    },
}

/// What a view keeps of its overlay from picture to picture.
#[derive(Debug, Default)]
pub(crate) struct OverlayState {
    ready: Option<ReadyOverlay>,
    table: Option<DataTexture>,
}

#[derive(Debug)]
struct ReadyOverlay {
    /// While it is held nothing else has its place in memory.
    overlay: Arc<Overlay>,
    shapes: Vec<Shape>,
    atlas: wgpu::TextureView,
    atlas_side: u32,
}

impl OverlayState {
    /// Makes the overlay of `request` ready. None where nothing of it lies in the picture. Also says how many bytes were
    /// uploaded.
    ///
    /// # Errors
    /// An item cannot be drawn, or all of them are too many.
    pub fn prepare(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
        request: &FrameRequest,
    ) -> Result<(Option<OverlayDraw>, u64), OverlayError> {
        if request.overlay.items.is_empty() {
            *self = Self::default();
            return Ok((None, 0));
        }
        let mut uploaded_bytes = 0;
        let is_known = |ready: &&ReadyOverlay| Arc::ptr_eq(&ready.overlay, &request.overlay);
        let ready = match self.ready.take().filter(|ready| is_known(&ready)) {
            Some(ready) => self.ready.insert(ready),
            None => {
                let (ready, bytes) = ReadyOverlay::new(gpu, &request.overlay)?;
                uploaded_bytes += bytes;
                self.ready.insert(ready)
            }
        };
        let quads = ready.quads(scene, request)?;
        if quads.texels.is_empty() {
            return Ok((None, uploaded_bytes));
        }
        let new = || {
            let format = wgpu::TextureFormat::Rgba32Float;
            DataTexture::new(&gpu.device, "overlay.quads", format, QUADS_A_ROW * QUAD_TEXELS as u32)
        };
        let table = self.table.get_or_insert_with(new);
        uploaded_bytes += table.write(&gpu.device, &gpu.queue, &quads.texels).ok_or(OverlayError::TooMany)?;
        let draw = OverlayDraw {
            quads: table.view().clone(),
            atlas: ready.atlas.clone(),
            atlas_side: [ready.atlas_side; 2],
            quad_count: quads.count() as u32,
            tests_depth: quads.tests_depth,
        };
        Ok((Some(draw), uploaded_bytes))
    }
}

impl ReadyOverlay {
    fn new(gpu: &Gpu, overlay: &Arc<Overlay>) -> Result<(Self, u64), OverlayError> {
        let mut atlas = Atlas::default();
        let mut shapes = Vec::with_capacity(overlay.items.len());
        let mut pieces = 0;
        for (index, item) in overlay.items.iter().enumerate() {
            item.check().map_err(|fault| OverlayError::Item { item: index, fault })?;
            let shape = Shape::new(item, &mut atlas)?;
            pieces += shape.piece_count();
            if pieces > QUADS_MAX {
                return Err(OverlayError::TooMany);
            }
            shapes.push(shape);
        }
        let side_max = gpu.capabilities.max_texture_size.min(atlas::SIDE_MAX);
        let packed = atlas.pack(side_max).ok_or(OverlayError::Atlas { side: side_max })?;
        for shape in &mut shapes {
            shape.place(&packed.places);
        }
        let bytes = packed.texels.len() as u64;
        let atlas = packed.upload(gpu);
        Ok((Self { overlay: overlay.clone(), shapes, atlas, atlas_side: packed.side }, bytes))
    }

    /// The rectangles of a picture.
    fn quads(&self, scene: &Scene, request: &FrameRequest) -> Result<Quads, OverlayError> {
        let lens = FisheyeLens::new(&request.settings.camera, (request.width, request.height));
        if lens.is_some()
            && let Some(item) = self.overlay.items.iter().position(|item| item.depth_test)
        {
            return Err(OverlayError::FisheyeDepth { item });
        }
        let projector = Projector::new(&request.camera, (request.width, request.height), lens);
        let mut quads = Quads::default();
        let names = quads::node_names(scene, &self.overlay);
        for (index, (item, shape)) in self.overlay.items.iter().zip(&self.shapes).enumerate() {
            quads.add(&projector, &names, (index, item), shape)?;
            if quads.count() > QUADS_MAX {
                return Err(OverlayError::TooMany);
            }
        }
        Ok(quads)
    }
}
