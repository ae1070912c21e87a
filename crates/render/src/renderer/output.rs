//! What is kept of a view from sample to sample: the means and the picture; and reading them.

use super::{DISPLAY, Renderer};
use crate::aov::{Aov, AovPixels, AovTextures};
use crate::environment::Background;
use crate::frame::Means;
use crate::gpu::{Gpu, readback};
use crate::lights::KeptLists;
use crate::lights::Rectangle;
use crate::passes::accumulate::{Mean, SUM};
use crate::passes::adaptive::{self, Settling};
use crate::record::ViewTables;
use crate::request::{FrameRequest, RenderError};
use manypass_graph::{Graph, Handle, TextureDesc};
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Beside other means.
const MEANS_OF_RADIANCE: [&str; 2] = ["accumulate.previous_radiance", "accumulate.radiance_sum"];

/// A texture that outlives frames, with its view.
#[derive(Debug)]
struct Kept {
    texture: wgpu::Texture,
    view: wgpu::TextureView,
}

/// Textures of the output, kept from frame to frame.
#[derive(Debug)]
pub(super) struct Output {
    size: (u32, u32),
    /// The mean of display colours; of radiance where that is the only one, or of all but what glows. None, one or two textures.
    sums: Vec<Kept>,
    /// The mean of radiance beside those of the picture. None or two textures.
    radiance_sums: Vec<Kept>,
    /// The mean of what glows. None or two textures.
    glow_sums: Vec<Kept>,
    /// Which tiles of the picture are settled, and the mean of half of its samples; once they were needed.
    settling: Option<[Kept; 2]>,
    display: Kept,
}

/// What a view leaves for its next frame, and for whoever reads it.
#[derive(Debug)]
pub(super) struct ViewState {
    pub tables: ViewTables,
    /// The lists of lights that `tables` hold.
    pub lists: Option<KeptLists>,
    pub output: Option<Output>,
    /// Which of the two sums holds the last frame's.
    pub latest_sum: usize,
    /// Whether tiles of the picture were looked for that are settled.
    pub has_settled: bool,
    /// Rectangles around those that are not, if they are known.
    pub unsettled: Option<Arc<[Rectangle]>>,
    /// Of how many samples the picture of the last frame is.
    pub sample_count: u32,
    /// What the last frame left means of, and what their radiance is multiplied by.
    pub means_of: MeansOf,
    pub pre_exposure: f32,
    /// What radiance is laid over where it is read, if that is a colour, and what makes radiance of it.
    pub background_radiance: (Background, f32),
    /// Pixels that half floats clamped, as of the last time radiance was read.
    clamped_pixels: AtomicU64,
    /// What variables are made of, of the last frame that began a picture.
    pub aovs: Option<AovTextures>,
}

impl ViewState {
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            tables: ViewTables::new(gpu),
            lists: None,
            output: None,
            latest_sum: 0,
            has_settled: false,
            unsettled: None,
            sample_count: 1,
            means_of: MeansOf::Nothing,
            pre_exposure: 1.0,
            background_radiance: (Background::Transparent, 1.0),
            clamped_pixels: AtomicU64::new(0),
            aovs: None,
        }
    }

    /// The texture that says which tiles are settled, if they were looked for.
    pub fn settled_texture(&self) -> Option<&wgpu::Texture> {
        let [settled, _] = self.output.as_ref()?.settling.as_ref()?;
        self.has_settled.then_some(&settled.texture)
    }

    /// Which tiles of the picture that `sample_index` goes on with are settled, if that was looked for.
    pub fn settled(&self, sample_index: u32) -> Option<wgpu::TextureView> {
        let [settled, _] = self.output.as_ref()?.settling.as_ref()?;
        (self.has_settled && sample_index > 0).then(|| settled.view.clone())
    }
}

/// What a view's means are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MeansOf {
    /// There are none: the picture is made of the radiance of the only sample.
    Nothing,
    /// The radiance of the only sample, to be read.
    OneSample,
    /// Display colours.
    Display,
    /// Radiance.
    Radiance,
    /// Display colours, and beside them radiance.
    Both,
    /// What glows, and all else.
    Parts,
    /// The same, and beside them the radiance of all.
    PartsAndRadiance,
}

impl MeansOf {
    /// Those that a frame of `request` leaves.
    pub fn request(request: &FrameRequest) -> Self {
        let is_alone = request.sample_count <= 1 && request.sample_index == 0;
        if request.averages_parts() {
            return if request.averages_radiance() { Self::PartsAndRadiance } else { Self::Parts };
        }
        match (request.averages_display(), request.averages_radiance()) {
            (false, false) if is_alone => Self::Nothing,
            (false, true) if is_alone => Self::OneSample,
            (false, _) => Self::Radiance,
            (true, false) => Self::Display,
            (true, true) => Self::Both,
        }
    }

    /// The number of textures for the first mean, for that of radiance beside it, and for that of what glows.
    fn counts(self) -> [usize; 3] {
        match self {
            Self::Nothing => [0, 0, 0],
            Self::OneSample => [1, 0, 0],
            Self::Display | Self::Radiance => [2, 0, 0],
            Self::Both => [2, 2, 0],
            Self::Parts => [2, 0, 2],
            Self::PartsAndRadiance => [2, 2, 2],
        }
    }

    /// Whether the next sample adds to them.
    pub fn go_on(self) -> bool {
        !matches!(self, Self::Nothing | Self::OneSample)
    }
}

fn create(gpu: &Gpu, label: &str, format: wgpu::TextureFormat, (width, height): (u32, u32)) -> Kept {
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    Kept { view: texture.create_view(&Default::default()), texture }
}

/// The shapes of the textures that tell which tiles of a picture are settled.
fn settling_descs(size: (u32, u32)) -> [TextureDesc; 2] {
    [adaptive::settled_desc(size), TextureDesc::new_2d(size.0, size.1, adaptive::HALF)]
}

impl Output {
    /// Bytes of the textures that [`Self::of`] would create.
    pub fn missing_bytes(slot: Option<&Self>, size: (u32, u32), means_of: MeansOf, settles: bool) -> u64 {
        let shape = |format| TextureDesc::new_2d(size.0, size.1, format).bytes();
        let known = slot.filter(|output| output.size == size);
        let picture_bytes = if known.is_some() { 0 } else { shape(DISPLAY) };
        let held =
            known.map_or([0; 3], |output| [output.sums.len(), output.radiance_sums.len(), output.glow_sums.len()]);
        let missing: usize =
            means_of.counts().into_iter().zip(held).map(|(wanted, held)| wanted.saturating_sub(held)).sum();
        let lacks_settling = settles && known.is_none_or(|output| output.settling.is_none());
        let settling_bytes =
            if lacks_settling { settling_descs(size).map(|desc| desc.bytes()).iter().sum() } else { 0 };
        picture_bytes + missing as u64 * shape(SUM) + settling_bytes
    }

    /// Whether it is for pictures of `size`.
    pub fn is_of(&self, size: (u32, u32)) -> bool {
        self.size == size
    }

    fn new(gpu: &Gpu, size: (u32, u32), texture_size: (u32, u32)) -> Self {
        let display = create(gpu, "display", DISPLAY, texture_size);
        Self { size, sums: Vec::new(), radiance_sums: Vec::new(), glow_sums: Vec::new(), settling: None, display }
    }

    /// Adds the textures that these means take beyond those that are there.
    fn with_means(&mut self, gpu: &Gpu, means_of: MeansOf, texture_size: (u32, u32)) {
        let [sums, radiance_sums, glow_sums] = means_of.counts();
        while self.sums.len() < sums {
            self.sums.push(create(gpu, "accumulate.sum", SUM, texture_size));
        }
        while self.radiance_sums.len() < radiance_sums {
            self.radiance_sums.push(create(gpu, "accumulate.radiance_sum", SUM, texture_size));
        }
        while self.glow_sums.len() < glow_sums {
            self.glow_sums.push(create(gpu, "accumulate.glow_sum", SUM, texture_size));
        }
    }

    /// Adds the textures that tell which tiles are settled.
    fn with_settling(&mut self, gpu: &Gpu, texture_size: (u32, u32)) {
        let make = |TextureDesc { format, width, height, .. }| create(gpu, "adaptive", format, (width, height));
        self.settling.get_or_insert_with(|| settling_descs(texture_size).map(make));
    }

    /// For a plan that is never run: the shapes of pictures of `size`, with next to no memory behind them.
    pub fn planned(gpu: &Gpu, size: (u32, u32), means_of: MeansOf, settles: bool) -> Self {
        let mut output = Self::new(gpu, size, (1, 1));
        output.with_means(gpu, means_of, (1, 1));
        if settles {
            output.with_settling(gpu, (1, 1));
        }
        output
    }

    /// The textures for pictures of `size`, with those for the means. Textures of other means stay until the size changes,
    /// so that one who shows single samples and refines them in turn makes none.
    pub fn of<'a>(
        gpu: &Gpu,
        slot: &'a mut Option<Self>,
        size: (u32, u32),
        means_of: MeansOf,
        settles: bool,
    ) -> &'a Self {
        if slot.as_ref().is_some_and(|output| output.size != size) {
            *slot = None;
        }
        let output = slot.get_or_insert_with(|| Self::new(gpu, size, size));
        output.with_means(gpu, means_of, size);
        if settles {
            output.with_settling(gpu, size);
        }
        output
    }

    /// What is kept of settled tiles, in a graph.
    pub fn settling(&self, graph: &mut Graph<'_>) -> Option<Settling> {
        let [settled_desc, half_desc] = settling_descs(self.size);
        let [settled, half] = self.settling.as_ref()?;
        Some(Settling {
            settled: graph.import("adaptive.settled", settled_desc, settled.view.clone()),
            half: graph.import("adaptive.half", half_desc, half.view.clone()),
        })
    }

    /// The means in a graph; `previous` of the two textures holds that of the samples so far.
    pub fn means(&self, graph: &mut Graph<'_>, means_of: MeansOf, previous: usize) -> Means {
        let desc = TextureDesc::new_2d(self.size.0, self.size.1, SUM);
        let mut mean = |sums: &[Kept], names: [&'static str; 2]| {
            let mut import = |name, index: usize| Some(graph.import(name, desc, sums.get(index & 1)?.view.clone()));
            let previous_mean = if means_of.go_on() { import(names[0], previous) } else { None };
            Some(Mean { previous: previous_mean, next: import(names[1], 1 - (previous & 1))? })
        };
        let first = mean(&self.sums, ["accumulate.previous", "accumulate.sum"]);
        match (means_of, first) {
            (MeansOf::Nothing, _) | (_, None) => Means::None,
            (MeansOf::OneSample | MeansOf::Radiance, Some(first)) => Means::Radiance(first),
            (MeansOf::Display, Some(first)) => Means::Display(first),
            (MeansOf::Both, Some(first)) => match mean(&self.radiance_sums, MEANS_OF_RADIANCE) {
                Some(second) => Means::Both([first, second]),
                None => Means::Display(first),
            },
            (MeansOf::Parts | MeansOf::PartsAndRadiance, Some(rest)) => {
                let is_read = means_of == MeansOf::PartsAndRadiance;
                let radiance = if is_read { mean(&self.radiance_sums, MEANS_OF_RADIANCE) } else { None };
                match mean(&self.glow_sums, ["accumulate.previous_glow", "accumulate.glow_sum"]) {
                    Some(glow) => Means::Parts { rest, glow, radiance },
                    None => Means::Radiance(rest),
                }
            }
        }
    }

    /// The picture in a graph.
    pub fn display(&self, graph: &mut Graph<'_>) -> Handle {
        graph.import("display", TextureDesc::new_2d(self.size.0, self.size.1, DISPLAY), self.display.view.clone())
    }
}

/// What one view of the last frame left, to be read.
#[derive(Clone, Copy, Debug)]
pub struct RenderedView<'a> {
    gpu: &'a Gpu,
    state: &'a ViewState,
    output: &'a Output,
}

impl RenderedView<'_> {
    /// As [`Renderer::read_display_async`].
    ///
    /// # Errors
    /// The device was lost.
    pub async fn read_display_async(&self) -> Result<Vec<u8>, RenderError> {
        Ok(readback::read_texture(self.gpu, &self.output.display.texture).await?)
    }

    /// As [`Renderer::read_radiance_rows_async`].
    ///
    /// # Errors
    /// Radiance was not kept, or the device was lost.
    pub async fn read_radiance_rows_async(&self, rows: Range<u32>) -> Result<Vec<f32>, RenderError> {
        let (state, output) = (self.state, self.output);
        let sums = match state.means_of {
            MeansOf::OneSample | MeansOf::Radiance => output.sums.as_slice(),
            MeansOf::Both | MeansOf::PartsAndRadiance => &output.radiance_sums,
            MeansOf::Nothing | MeansOf::Display | MeansOf::Parts => &[],
        };
        let sum = sums.get(state.latest_sum & 1).ok_or(RenderError::Missing(
            "radiance was not kept: the request must ask for it with `averaging`, or with the variable",
        ))?;
        let rows = rows.start.min(output.size.1)..rows.end.min(output.size.1);
        let (is_first_band, first_row) = (rows.start == 0, rows.start as f32);
        let bytes = readback::read_rows(self.gpu, &sum.texture, rows).await?;
        let mut radiance = readback::reserved(bytes.len() / 4)?;
        radiance.extend(bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])));
        drop(bytes);
        let scale = 1.0 / state.pre_exposure;
        let mut clamped_pixels = 0;
        let (width, height) = (output.size.0.max(1) as usize, output.size.1 as f32);
        let (background, of_background) = state.background_radiance;
        let behind = |row: usize| {
            let color = background.color_at(1.0 - (first_row + row as f32 + 0.5) / height)?;
            Some(color.map(|value| value * of_background))
        };
        let mut color_behind = None;
        for (at, pixel) in radiance.chunks_exact_mut(4).enumerate() {
            if at % width == 0 {
                color_behind = behind(at / width);
            }
            let [r, g, b, alpha] = pixel else { continue };
            // `accumulate.wgsl` marks so what reached the limit of half floats.
            clamped_pixels += u64::from(*alpha < 0.0);
            *alpha = alpha.abs();
            for color in [&mut *r, &mut *g, &mut *b] {
                *color *= scale;
            }
            if let Some(background) = color_behind {
                let behind = 1.0 - alpha.min(1.0);
                for (color, background) in [r, g, b].into_iter().zip(background) {
                    *color += behind * background;
                }
                *alpha = 1.0;
            }
        }
        // Bands of rows are read from the top.
        let above = if is_first_band { 0 } else { state.clamped_pixels.load(Ordering::Relaxed) };
        state.clamped_pixels.store(above + clamped_pixels, Ordering::Relaxed);
        Ok(radiance)
    }

    /// As [`Renderer::read_aov_rows_async`].
    ///
    /// # Errors
    /// The view was rendered on the forward path, or without wanting the variable; or the device was lost.
    pub async fn read_aov_rows_async(&self, aov: Aov, rows: Range<u32>) -> Result<AovPixels, RenderError> {
        let missing = RenderError::Missing(
            "there is no such AOV: only the deferred path has them, and the request must name them",
        );
        match (&self.state.aovs, aov) {
            (None, _) => Err(missing),
            (Some(_), Aov::Radiance) => {
                Ok(AovPixels::Float { components: 4, data: self.read_radiance_rows_async(rows).await? })
            }
            (Some(textures), aov) => textures.read(self.gpu, aov, rows).await?.ok_or(missing),
        }
    }

    /// A view of the picture, to draw it elsewhere.
    pub fn display_view(&self) -> wgpu::TextureView {
        self.output.display.view.clone()
    }

    /// As [`Renderer::read_samples_mean_async`].
    ///
    /// # Errors
    /// The device was lost.
    pub async fn read_samples_mean_async(&self) -> Result<f64, RenderError> {
        let sample_count = f64::from(self.state.sample_count);
        let settling = self.output.settling.as_ref().filter(|_| self.state.has_settled);
        let Some([settled, _]) = settling else { return Ok(sample_count) };
        let shares = readback::read_texture(self.gpu, &settled.texture).await?;
        let left_out: f64 = shares.iter().map(|share| f64::from(*share) / 255.0).sum();
        Ok(sample_count * (1.0 - left_out / shares.len().max(1) as f64))
    }

    /// As [`Renderer::clamped_pixels`].
    pub fn clamped_pixels(&self) -> u64 {
        self.state.clamped_pixels.load(Ordering::Relaxed)
    }
}

impl Renderer {
    /// What the view `name` of the last frame left, to be read; the only view of a frame has the empty name.
    ///
    /// # Errors
    /// No view of that name was rendered yet.
    pub fn rendered(&self, name: &str) -> Result<RenderedView<'_>, RenderError> {
        let missing = RenderError::Missing("nothing was rendered yet");
        let state = self.views.get(name).ok_or(missing)?;
        let output = state.output.as_ref().ok_or(RenderError::Missing("nothing was rendered yet"))?;
        Ok(RenderedView { gpu: &self.gpu, state, output })
    }

    fn main(&self) -> Result<RenderedView<'_>, RenderError> {
        self.rendered("")
    }

    /// The accumulated picture: RGBA, sRGB, unassociated alpha, rows from the top.
    ///
    /// # Errors
    /// Nothing was rendered yet, or the device was lost.
    pub async fn read_display_async(&self) -> Result<Vec<u8>, RenderError> {
        self.main()?.read_display_async().await
    }

    /// As [`Self::read_display_async`], waiting.
    ///
    /// # Errors
    /// Nothing was rendered yet, or the device was lost.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn read_display(&mut self) -> Result<Vec<u8>, RenderError> {
        pollster::block_on(self.read_display_async())
    }

    /// A view of the accumulated picture, to draw it elsewhere; none until something was rendered.
    pub fn display_view(&self) -> Option<wgpu::TextureView> {
        self.main().ok().map(|view| view.display_view())
    }

    /// The accumulated radiance: linear RGBA, associated alpha, exposure divided out, rows from the top. Over a background
    /// colour it is opaque: the colour is the radiance that the exposure shows with that value. There is one only if the
    /// request's [`crate::Averaging`] says so, or it wants the variable.
    ///
    /// # Errors
    /// Nothing was rendered yet, or radiance was not kept, or the device was lost.
    pub async fn read_radiance_async(&self) -> Result<Vec<f32>, RenderError> {
        self.read_radiance_rows_async(0..u32::MAX).await
    }

    /// As [`Self::read_radiance_async`], some rows alone; those below the picture are left out.
    ///
    /// # Errors
    /// As [`Self::read_radiance_async`].
    pub async fn read_radiance_rows_async(&self, rows: Range<u32>) -> Result<Vec<f32>, RenderError> {
        self.main()?.read_radiance_rows_async(rows).await
    }

    /// How many pixels of the radiance that was read last are too dark, because a sample was brighter than half floats
    /// hold at the pre-exposure.
    pub fn clamped_pixels(&self) -> u64 {
        self.main().map_or(0, |view| view.clamped_pixels())
    }

    /// How many samples the pixels of the picture have on average: all, or fewer where `adaptive.threshold` let parts of it settle, whose tiles
    /// at the right and the lower edge count as whole ones.
    ///
    /// # Errors
    /// Nothing was rendered yet, or the device was lost.
    pub async fn read_samples_mean_async(&self) -> Result<f64, RenderError> {
        self.main()?.read_samples_mean_async().await
    }

    /// As [`Self::read_samples_mean_async`], waiting.
    ///
    /// # Errors
    /// As [`Self::read_samples_mean_async`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn read_samples_mean(&self) -> Result<f64, RenderError> {
        pollster::block_on(self.read_samples_mean_async())
    }

    /// As [`Self::read_radiance_async`], waiting.
    ///
    /// # Errors
    /// As [`Self::read_radiance_async`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn read_radiance(&mut self) -> Result<Vec<f32>, RenderError> {
        pollster::block_on(self.read_radiance_async())
    }

    /// A variable of the first frame, one value for every pixel of the picture; the request must have wanted it.
    ///
    /// # Errors
    /// Nothing was rendered yet, on the forward path, or without wanting the variable; or the device was lost.
    pub async fn read_aov_async(&self, aov: Aov) -> Result<AovPixels, RenderError> {
        self.read_aov_rows_async(aov, 0..u32::MAX).await
    }

    /// As [`Self::read_aov_async`], some rows alone; those below the picture are left out. So that a large picture need
    /// not be in memory as a whole.
    ///
    /// # Errors
    /// As [`Self::read_aov_async`].
    pub async fn read_aov_rows_async(&self, aov: Aov, rows: Range<u32>) -> Result<AovPixels, RenderError> {
        self.main()?.read_aov_rows_async(aov, rows).await
    }

    /// As [`Self::read_aov_async`], waiting.
    ///
    /// # Errors
    /// As [`Self::read_aov_async`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn read_aov(&mut self, aov: Aov) -> Result<AovPixels, RenderError> {
        pollster::block_on(self.read_aov_async(aov))
    }

    /// As [`Self::read_aov_rows_async`], waiting.
    ///
    /// # Errors
    /// As [`Self::read_aov_async`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn read_aov_rows(&mut self, aov: Aov, rows: Range<u32>) -> Result<AovPixels, RenderError> {
        pollster::block_on(self.read_aov_rows_async(aov, rows))
    }

    /// As [`Self::read_radiance_rows_async`], waiting.
    ///
    /// # Errors
    /// As [`Self::read_radiance_async`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn read_radiance_rows(&mut self, rows: Range<u32>) -> Result<Vec<f32>, RenderError> {
        pollster::block_on(self.read_radiance_rows_async(rows))
    }
}
