//! Reading what a frame left of its views.

use super::Renderer;
use super::output::{MeansOf, Output, ViewState};
use crate::aov::{Aov, AovPixels};
use crate::gpu::{Gpu, readback};
use crate::request::RenderError;
use std::ops::Range;
use std::sync::atomic::Ordering;

/// The results of one view of the last frame, for reading.
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
        let sum = sums.get(state.latest_sum & 1).ok_or(RenderError::RadianceNotKept)?;
        let rows = rows.start.min(output.size.1)..rows.end.min(output.size.1);
        let (is_first_band, first_row) = (rows.start == 0, rows.start as f32);
        let tint = output.tint_sums.get(state.latest_sum & 1).filter(|_| state.has_tint);
        let tint_bytes = match tint {
            Some(tint) => Some(readback::read_rows(self.gpu, &tint.texture, rows.clone()).await?),
            None => None,
        };
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
            if let Some(bytes) = tint_bytes.as_ref().and_then(|bytes| bytes.chunks_exact(16).nth(at)) {
                lay_over_tinted(pixel, tint_of(bytes), (color_behind, of_background));
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
        let missing = RenderError::AovNotKept { aov };
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
        let Some(settled) = self.state.settled_texture() else { return Ok(sample_count) };
        let shares = readback::read_texture(self.gpu, settled).await?;
        let left_out: f64 = shares.iter().map(|share| f64::from(*share) / 255.0).sum();
        Ok(sample_count * (1.0 - left_out / shares.len().max(1) as f64))
    }

    /// As [`Renderer::read_adapted_stops_async`].
    ///
    /// # Errors
    /// The device was lost.
    pub async fn read_adapted_stops_async(&self) -> Result<Option<f32>, RenderError> {
        let Some(adapted) = &self.state.adapted else { return Ok(None) };
        let bytes = readback::read_texture(self.gpu, adapted).await?;
        Ok(bytes.first_chunk().map(|bytes| f32::from_le_bytes(*bytes)))
    }

    /// As [`Renderer::clamped_pixels`].
    pub fn clamped_pixels(&self) -> u64 {
        self.state.clamped_pixels.load(Ordering::Relaxed)
    }
}

/// What comes through glass of the background beside what alpha says, by channel, as its mean holds it.
fn tint_of(bytes: &[u8]) -> [f32; 3] {
    let mut tint = [0.0; 3];
    for (tint, bytes) in tint.iter_mut().zip(bytes.chunks_exact(4)) {
        *tint = f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]) - 1.0;
    }
    tint
}

/// Adds to a pixel what comes through glass of the colour behind it, or else, so that it is right over white, what alpha
/// does not say; `white` is the radiance of that.
fn lay_over_tinted(pixel: &mut [f32], tint: [f32; 3], (color_behind, white): (Option<[f32; 3]>, f32)) {
    let [r, g, b, alpha] = pixel else { return };
    // What rounding leaves of nothing is nothing.
    if tint.iter().all(|tint| tint.abs() < 1e-4) {
        return;
    }
    let mean = if color_behind.is_some() { 0.0 } else { tint.iter().sum::<f32>() / 3.0 };
    let background = color_behind.unwrap_or([white; 3]);
    for ((color, tint), background) in [r, g, b].into_iter().zip(tint).zip(background) {
        *color = (*color + (tint - mean) * background).max(0.0);
    }
    *alpha = (*alpha - mean).clamp(0.0, 1.0);
}

impl Renderer {
    /// What the view `name` of the last frame left, to be read; the only view of a frame has the empty name.
    ///
    /// # Errors
    /// No view of that name was rendered yet.
    pub fn rendered(&self, name: &str) -> Result<RenderedView<'_>, RenderError> {
        let missing = || RenderError::NotRendered { view: name.into() };
        let state = self.views.get(name).ok_or_else(missing)?;
        let output = state.output.as_ref().ok_or_else(missing)?;
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

    /// The accumulated radiance: linear RGBA, associated alpha, exposure divided out, rows from the top. Over a
    /// background colour it is opaque: the colour is the radiance that the exposure shows with that value. There is one
    /// only if the request's [`crate::Averaging`] says so, or it wants the variable.
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

    /// How many samples the pixels of the picture have on average: all, or fewer where `adaptive.threshold` let parts
    /// of it settle, whose tiles at the right and the lower edge count as whole ones.
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

    /// What the exposure of the last picture adapted to, in stops, without those that [`crate::Exposure::Auto`] has on
    /// top; none if it does not adapt (`exposure.adapt`). Nothing else waits for that.
    ///
    /// # Errors
    /// Nothing was rendered yet; or the device was lost.
    pub async fn read_adapted_stops_async(&self) -> Result<Option<f32>, RenderError> {
        self.main()?.read_adapted_stops_async().await
    }

    /// As [`Self::read_adapted_stops_async`], waiting.
    ///
    /// # Errors
    /// As [`Self::read_adapted_stops_async`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn read_adapted_stops(&self) -> Result<Option<f32>, RenderError> {
        pollster::block_on(self.read_adapted_stops_async())
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
