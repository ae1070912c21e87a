//! The G-buffer in memory, and the variables that are decoded from it.

use super::{Aov, AovPixels};
use crate::colour::linear_from_srgb;
use crate::constants::DISTANCE_BACKGROUND_M;
use crate::gpu::{GpuError, readback};
use crate::octahedral::direction_from_octahedral;
use crate::view::ViewUniform;
use glam::{Vec2, Vec3};
use std::ops::Range;

/// Rows of the G-buffer of the first, unjittered frame, in memory, with the targets that only variables need. It has
/// the picture's size, whatever size the picture is shaded at. What the variable that is read does not need is empty.
#[derive(Clone, Debug)]
pub(crate) struct GbufferPixels {
    pub view: ViewUniform,
    /// What is added to positions in world space.
    pub origin_m: Vec3,
    /// The rows of the picture.
    pub rows: Range<u32>,
    pub base_color: Vec<u8>,
    pub normal: Vec<u8>,
    pub material: Vec<u8>,
    pub linear_depth: Vec<u8>,
    /// Half floats; none if no variable needs it.
    pub emission: Option<Vec<u8>>,
    /// Two integers a pixel; none if no variable needs them.
    pub ids: Option<Vec<u8>>,
    /// Two floats a pixel; none if no variable needs it.
    pub motion: Option<Vec<u8>>,
    /// A float a pixel; none if no variable needs it.
    pub occlusion_screen: Option<Vec<u8>>,
}

impl GbufferPixels {
    /// No pixels yet, of some rows of the picture.
    pub fn of_rows(view: ViewUniform, origin_m: Vec3, rows: Range<u32>) -> Self {
        let nothing = Vec::new;
        Self {
            view,
            origin_m,
            rows,
            base_color: nothing(),
            normal: nothing(),
            material: nothing(),
            linear_depth: nothing(),
            emission: None,
            ids: None,
            motion: None,
            occlusion_screen: None,
        }
    }

    /// A variable, one value for every pixel of the rows; none if the frame did not record it.
    ///
    /// # Errors
    /// There is no memory for the values.
    pub fn read(&self, aov: Aov) -> Result<Option<AovPixels>, GpuError> {
        let unit = |bytes: &[u8], at: usize| [f32::from(bytes[at]) / 255.0];
        let values = match aov {
            Aov::BaseColor => self.floats(|i| {
                [0, 1, 2].map(|channel| linear_from_srgb(f32::from(self.base_color[i * 4 + channel]) / 255.0))
            }),
            Aov::Occlusion => self.floats(|i| unit(&self.base_color, i * 4 + 3)),
            Aov::Metallic => self.floats(|i| unit(&self.material, i * 4)),
            Aov::Roughness => self.floats(|i| unit(&self.material, i * 4 + 1)),
            Aov::Depth => self.floats(|i| [self.distance_m(i).unwrap_or(f32::INFINITY)]),
            Aov::Normal => self.floats(|i| self.normal_world(i).to_array()),
            Aov::NormalView => {
                self.floats(|i| self.view.view_from_world.transform_vector3(self.normal_world(i)).to_array())
            }
            Aov::Position => self.floats(|i| self.position_world(i).to_array()),
            Aov::Emission => {
                let Some(halves) = &self.emission else { return Ok(None) };
                let scale = 1.0 / self.view.pre_exposure;
                let half = |at: usize| f32_from_half(u16::from_le_bytes([halves[at], halves[at + 1]])) * scale;
                self.floats(|i| [0, 2, 4].map(|channel| half(i * 8 + channel)))
            }
            Aov::Motion => {
                let Some(motion) = &self.motion else { return Ok(None) };
                self.floats(|i| [0, 4].map(|channel| f32::from_le_bytes(word(motion, i * 8 + channel))))
            }
            Aov::OcclusionScreen => {
                let Some(shares) = &self.occlusion_screen else { return Ok(None) };
                // One sample of few directions may lie beyond the range.
                self.floats(|i| [f32::from_le_bytes(word(shares, i * 4)).clamp(0.0, 1.0)])
            }
            Aov::ObjectId | Aov::MaterialId => {
                let Some(ids) = &self.ids else { return Ok(None) };
                self.ids(ids, if aov == Aov::ObjectId { 0 } else { 4 })
            }
            // The accumulated picture is no part of the G-buffer.
            Aov::Radiance => return Ok(None),
        };
        values.map(Some)
    }

    fn pixel_count(&self) -> usize {
        self.rows.len() * self.view.size_px.x as usize
    }

    fn floats<const N: usize>(&self, value: impl Fn(usize) -> [f32; N]) -> Result<AovPixels, GpuError> {
        let mut data = readback::reserved(self.pixel_count() * N)?;
        data.extend((0..self.pixel_count()).flat_map(value));
        Ok(AovPixels::Float { components: N as u32, data })
    }

    fn ids(&self, ids: &[u8], offset: usize) -> Result<AovPixels, GpuError> {
        let mut data = readback::reserved(self.pixel_count())?;
        data.extend((0..self.pixel_count()).map(|i| u32::from_le_bytes(word(ids, i * 8 + offset))));
        Ok(AovPixels::Id(data))
    }

    fn distance_m(&self, i: usize) -> Option<f32> {
        let distance = f32::from_le_bytes(word(&self.linear_depth, i * 4));
        (distance < DISTANCE_BACKGROUND_M).then_some(distance)
    }

    /// Zero where there is no surface.
    fn normal_world(&self, i: usize) -> Vec3 {
        if self.distance_m(i).is_none() {
            return Vec3::ZERO;
        }
        let component = |c: usize| {
            let at = i * 4 + c * 2;
            f32::from(u16::from_le_bytes([self.normal[at], self.normal[at + 1]])) / 65535.0 * 2.0 - 1.0
        };
        direction_from_octahedral(Vec2::new(component(0), component(1)))
    }

    /// Zero where there is no surface.
    fn position_world(&self, i: usize) -> Vec3 {
        let Some(distance) = self.distance_m(i) else { return Vec3::ZERO };
        let width = self.view.size_px.x as usize;
        let row = i / width + self.rows.start as usize;
        let pixel = Vec2::new((i % width) as f32 + 0.5, row as f32 + 0.5);
        let uv = pixel * self.view.inverse_size_px;
        let ndc = Vec2::new(uv.x * 2.0 - 1.0, 1.0 - uv.y * 2.0);
        let plane = (ndc - self.view.jitter_ndc) * self.view.view_from_ndc_scale;
        let plane = if self.view.orthographic > 0.5 { plane } else { plane * distance };
        self.view.world_from_view.transform_point3(plane.extend(-distance)) + self.origin_m
    }
}

fn word(bytes: &[u8], at: usize) -> [u8; 4] {
    [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]
}

/// The value of a half float; NaNs count as infinity.
pub(crate) fn f32_from_half(bits: u16) -> f32 {
    let exponent = i32::from(bits >> 10 & 31);
    let mantissa = f32::from(bits & 1023);
    let magnitude = match exponent {
        0 => mantissa * 2f32.powi(-24),
        31 => f32::INFINITY,
        _ => (1.0 + mantissa / 1024.0) * 2f32.powi(exponent - 15),
    };
    if bits & 0x8000 == 0 { magnitude } else { -magnitude }
}
