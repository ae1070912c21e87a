//! Variables of the last frame, and what its pixels show.

use super::Viewer;
use crate::types::{PickedPixel, Variable, VariableName, object};
use manypass::aov::AovPasses;
use manypass::{Aov, AovPixels, FrameRequest, Pose};
use std::sync::Arc;
use wasm_bindgen::prelude::*;

#[wasm_bindgen]
impl Viewer {
    /// A variable of the last frame, on either path: depth, normals, ids and more. `motion` is that since the frame
    /// that `render` drew before. The picture and what effects keep stay as they are, but for `radiance`, which is what
    /// `radiance()` gives.
    ///
    /// # Errors
    /// When nothing was rendered, there is no such variable, or the device failed.
    pub async fn variable(&mut self, name: VariableName) -> Result<Variable, JsError> {
        let loss = self.loss.clone();
        loss.or(self.read_variable(name)).await
    }

    /// What the last frame shows at a pixel, counted from the top left corner of the canvas's picture (not in CSS
    /// pixels); nothing where there is no surface, and outside.
    ///
    /// # Errors
    /// When nothing was rendered, or the device failed.
    pub async fn pick(&mut self, x: f64, y: f64) -> Result<Option<PickedPixel>, JsError> {
        let loss = self.loss.clone();
        loss.or(self.read_pixel(x, y)).await
    }
}

impl Viewer {
    async fn read_variable(&mut self, name: VariableName) -> Result<Variable, JsError> {
        let name = JsValue::from(name).as_string().unwrap_or_default();
        let aov = Aov::ALL.iter().copied().find(|aov| aov.name() == name).ok_or_else(|| {
            let known: Vec<&str> = Aov::ALL.iter().map(|aov| aov.name()).collect();
            JsError::new(&format!("there is no AOV `{name}`; there is: {}", known.join(", ")))
        })?;
        let pixels = if aov == Aov::Radiance {
            AovPixels::Float { components: 4, data: self.read_radiance().await? }
        } else {
            self.draw_variables(&[aov]).await?;
            self.renderer.read_aov_async(aov).await?
        };
        let (width, height) = self.last.as_ref().map_or((0, 0), |last| (last.width, last.height));
        let (channels, data): (u32, JsValue) = match &pixels {
            AovPixels::Float { components, data } => (*components, js_sys::Float32Array::from(data.as_slice()).into()),
            AovPixels::Id(data) => (1, js_sys::Uint32Array::from(data.as_slice()).into()),
        };
        let entries: [(&str, JsValue); 5] = [
            ("name", aov.name().into()),
            ("width", width.into()),
            ("height", height.into()),
            ("channels", channels.into()),
            ("data", data),
        ];
        Ok(object(&entries).unchecked_into())
    }

    async fn read_pixel(&mut self, x: f64, y: f64) -> Result<Option<PickedPixel>, JsError> {
        self.draw_variables(&[Aov::ObjectId, Aov::MaterialId, Aov::Position]).await?;
        let (Some(scene), Some(last)) = (&self.scene, &self.last) else { return Ok(None) };
        let is_inside = (0.0..f64::from(last.width)).contains(&x) && (0.0..f64::from(last.height)).contains(&y);
        if !is_inside {
            return Ok(None);
        }
        let (column, row) = (x as usize, y as u32);
        let row = async |aov: Aov| self.renderer.read_aov_rows_async(aov, row..row + 1).await;
        let id_in = |pixels: AovPixels| match pixels {
            AovPixels::Id(ids) => ids.get(column).copied().unwrap_or(0),
            AovPixels::Float { .. } => 0,
        };
        let (object_id, material_id) = (id_in(row(Aov::ObjectId).await?), id_in(row(Aov::MaterialId).await?));
        let Some(node) = (object_id as usize).checked_sub(1).and_then(|index| scene.nodes.get(index)) else {
            return Ok(None);
        };
        let material = (material_id as usize).checked_sub(1).and_then(|index| scene.materials.get(index));
        let position = match row(Aov::Position).await? {
            AovPixels::Float { data, .. } => data.get(3 * column..3 * column + 3).unwrap_or_default().to_vec(),
            AovPixels::Id(_) => Vec::new(),
        };
        let entries: [(&str, JsValue); 5] = [
            ("objectId", object_id.into()),
            ("object", node.name.as_str().into()),
            ("materialId", material_id.into()),
            ("material", material.map_or("", |material| material.name.as_str()).into()),
            ("position", js_sys::Array::from(&js_sys::Float32Array::from(position.as_slice())).into()),
        ];
        Ok(Some(object(&entries).unchecked_into()))
    }

    /// Draws `wanted` of the last frame, beside what was drawn of it before; nothing if all of it is there.
    async fn draw_variables(&mut self, wanted: &[Aov]) -> Result<(), JsError> {
        let (Some(scene), Some(last)) = (&self.scene, &self.last) else {
            return Err(JsError::new("nothing was rendered yet"));
        };
        let want_aovs = [self.drawn.as_slice(), wanted].concat();
        // What lies in the G-buffer is there as soon as any variable is.
        if !self.drawn.is_empty() && AovPasses::of(&want_aovs) == AovPasses::of(&self.drawn) {
            return Ok(());
        }
        self.drawn.clear();
        let previous = self.camera_before.map(|camera| Arc::new(Pose::capture(scene, camera)));
        let request = FrameRequest { want_aovs, previous, ..last.clone() };
        self.renderer.draw_variables_async(scene, &request).await?;
        self.drawn = request.want_aovs;
        Ok(())
    }
}
