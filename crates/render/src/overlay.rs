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
use crate::gpu::data_texture::DataTexture;
use crate::gpu::{Gpu, destroy};
use crate::resources::Textures;
use crate::view::View;
use atlas::Atlas;
use draw::{OverlayDraw, OverlayRun};
use manypass_scene::Scene;
use manypass_scene::overlay::{OVERLAY_MONITORS_MAX, Overlay, OverlayFault, OverlayShape};
use project::Projector;
use quads::{QUAD_TEXELS, Quads};
use shape::Shape;
use std::sync::Arc;

/// The most rectangles of an overlay: letters, boxes, images and parts of lines.
const QUADS_MAX: usize = 200_000;

/// Quads in a row of their table; `overlay.wgsl` has the same number.
const QUADS_A_ROW: u32 = 256;

/// The error of an overlay that cannot be drawn.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
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
    /// An item shows a monitor that is not there.
    #[error("item {item} of the overlay: the scene has no monitor called `{name}`")]
    NoMonitor {
        /// Its index.
        item: usize,
        /// The name.
        name: String,
    },
    /// There are too many monitors.
    #[error("the overlay has more than {OVERLAY_MONITORS_MAX} monitors; leave some out")]
    TooManyMonitors,
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
    /// With them the textures of the frame would take more memory than [`crate::Renderer::set_memory_budget`] allows.
    #[error(
        "the letters and images of the overlay take a texture of {side} × {side} texels; with it the textures of the frame \
         take at least {needed_bytes} bytes more, but {budget_bytes} are allowed"
    )]
    Memory {
        /// The side of their texture.
        side: u32,
        /// What is known to be needed beyond what the renderer holds already: the other textures of the frame are not
        /// all known yet.
        needed_bytes: u64,
        /// What is allowed.
        budget_bytes: u64,
    },
    /// The built-in font is missing from the program.
    #[error("there is no built-in font: build the program with the feature `text`, or draw no texts")]
    NoFont,
    /// Depth of a fisheye picture is none of one view.
    #[error("item {item} of the overlay: a fisheye picture has no depth to compare; set `depth_test` to false")]
    FisheyeDepth {
        /// Its index.
        item: usize,
    },
}

/// What a frame may allocate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Room {
    /// What is allowed, if there is a limit.
    pub budget_bytes: Option<u64>,
    /// What other textures of the frame are known to need.
    pub needed_bytes: u64,
}

impl Room {
    /// Fails if there is none for a texture of so many bytes.
    fn check(self, side: u32, bytes: u64) -> Result<(), OverlayError> {
        let needed_bytes = self.needed_bytes.saturating_add(bytes);
        match self.budget_bytes {
            Some(budget_bytes) if needed_bytes > budget_bytes => {
                Err(OverlayError::Memory { side, needed_bytes, budget_bytes })
            }
            _ => Ok(()),
        }
    }
}

/// An overlay made ready.
#[derive(Debug, Default)]
pub(crate) struct PreparedOverlay {
    /// What draws it; none where nothing of it lies in the picture.
    pub draw: Option<OverlayDraw>,
    /// Bytes that were uploaded.
    pub uploaded_bytes: u64,
    /// Bytes of the texture of letters and images, if that was made anew.
    pub texture_bytes: u64,
}

/// The names of the monitors that an overlay shows.
pub(crate) fn monitors_of_overlay(overlay: &Overlay) -> impl Iterator<Item = &str> {
    overlay.items.iter().filter_map(|item| match &item.shape {
        OverlayShape::Monitor(monitor) => Some(monitor.name.as_str()),
        _ => None,
    })
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

/// An overlay, and from where the world below it is seen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OverlayView<'v> {
    pub overlay: &'v Arc<Overlay>,
    pub camera: &'v View,
    /// Width and height of the picture.
    pub size_px: (u32, u32),
    /// That of a fisheye picture.
    pub lens: Option<FisheyeLens>,
}

impl OverlayState {
    /// Makes the overlay of `view` ready.
    ///
    /// # Errors
    /// An item cannot be drawn, all of them are too many, or there is no `room` for them.
    pub fn prepare(
        &mut self,
        (gpu, textures): (&Gpu, &Textures),
        scene: &Scene,
        view: OverlayView<'_>,
        room: Room,
    ) -> Result<PreparedOverlay, OverlayError> {
        if view.overlay.items.is_empty() {
            if let Some(former) = std::mem::take(self).ready {
                destroy(&former.atlas);
            }
            return Ok(PreparedOverlay::default());
        }
        let mut texture_bytes = 0;
        if let Some(former) = self.ready.take_if(|ready| !Arc::ptr_eq(&ready.overlay, view.overlay)) {
            destroy(&former.atlas);
        }
        let ready = match self.ready.take() {
            Some(ready) => self.ready.insert(ready),
            None => {
                let (ready, bytes) = ReadyOverlay::new(gpu, view.overlay, room)?;
                texture_bytes += bytes;
                self.ready.insert(ready)
            }
        };
        let quads = ready.quads(scene, view)?;
        if quads.texels.is_empty() {
            return Ok(PreparedOverlay { draw: None, uploaded_bytes: texture_bytes, texture_bytes });
        }
        let new = || {
            let format = wgpu::TextureFormat::Rgba32Float;
            DataTexture::new(&gpu.device, "overlay.quads", format, QUADS_A_ROW * QUAD_TEXELS as u32)
        };
        let table = self.table.get_or_insert_with(new);
        let table_bytes = table.write(&gpu.device, &gpu.queue, &quads.texels).ok_or(OverlayError::TooMany)?;
        let of_monitor = |(first, image): &(usize, usize)| (*first as u32, textures.monitor(scene, *image).cloned());
        let monitors: Vec<_> = quads.monitors.iter().map(of_monitor).collect();
        let runs = OverlayRun::all(quads.count() as u32, &monitors);
        let draw = OverlayDraw {
            quads: table.view().clone(),
            atlas: ready.atlas.clone(),
            atlas_side: [ready.atlas_side; 2],
            runs,
            tests_depth: quads.tests_depth,
        };
        // A monitor whose texture is not there is all that there is to draw.
        let draw = Some(draw).filter(|draw| !draw.runs.is_empty());
        Ok(PreparedOverlay { draw, uploaded_bytes: texture_bytes + table_bytes, texture_bytes })
    }
}

impl ReadyOverlay {
    /// Also says how many bytes its texture takes.
    fn new(gpu: &Gpu, overlay: &Arc<Overlay>, room: Room) -> Result<(Self, u64), OverlayError> {
        let mut atlas = Atlas::default();
        let mut shapes = Vec::with_capacity(overlay.items.len());
        let (mut pieces, mut monitors) = (0, 0);
        for (index, item) in overlay.items.iter().enumerate() {
            item.check().map_err(|fault| OverlayError::Item { item: index, fault })?;
            let shape = Shape::new(item, &mut atlas)?;
            pieces += shape.piece_count();
            monitors += usize::from(matches!(shape, Shape::Monitor));
            if monitors > OVERLAY_MONITORS_MAX {
                return Err(OverlayError::TooManyMonitors);
            }
            if pieces > QUADS_MAX {
                return Err(OverlayError::TooMany);
            }
            shapes.push(shape);
        }
        let side_max = gpu.capabilities.max_texture_size.min(atlas::SIDE_MAX);
        let arrangement = atlas.arrange(side_max).ok_or(OverlayError::Atlas { side: side_max })?;
        let bytes = arrangement.bytes();
        room.check(arrangement.side, bytes)?;
        let packed = atlas.pack(arrangement);
        for shape in &mut shapes {
            shape.place(&packed.places);
        }
        let atlas = packed.upload(gpu);
        Ok((Self { overlay: overlay.clone(), shapes, atlas, atlas_side: packed.side }, bytes))
    }

    /// The rectangles of a picture.
    fn quads(&self, scene: &Scene, view: OverlayView<'_>) -> Result<Quads, OverlayError> {
        if view.lens.is_some()
            && let Some(item) = self.overlay.items.iter().position(|item| item.depth_test)
        {
            return Err(OverlayError::FisheyeDepth { item });
        }
        let projector = Projector::new(view.camera, view.size_px, view.lens);
        let mut quads = Quads::default();
        let names = quads::node_names(scene, &self.overlay);
        for (index, (item, shape)) in self.overlay.items.iter().zip(&self.shapes).enumerate() {
            quads.add(&projector, (scene, &names), (index, item), shape)?;
            if quads.count() > QUADS_MAX {
                return Err(OverlayError::TooMany);
            }
        }
        Ok(quads)
    }
}
