//! What is told of frames: exposure, adapter, and what a budget of time chose.

use super::Viewer;
use crate::types::{ExposureInfo, ViewerInfo, object};
use manypass::QualityBudget;
use serde_json::Value;
use wasm_bindgen::prelude::*;
use web_time::Instant;

#[wasm_bindgen]
impl Viewer {
    /// The exposure of the last frame.
    pub fn exposure(&self) -> Option<ExposureInfo> {
        let (scene, last) = (self.scene.as_ref()?, self.last.as_ref()?);
        let average = last.metering.and_then(|metering| metering.log_average_luminance);
        let entries: [(&str, JsValue); 3] = [
            ("mode", self.options.exposure(scene).mode().into()),
            ("stops", last.exposure_stops().into()),
            ("logAverageLuminance", average.map_or(JsValue::NULL, JsValue::from)),
        ];
        Some(object(&entries).unchecked_into())
    }

    /// The radius of a ball around the model in metres; undefined while there is none.
    #[wasm_bindgen(js_name = modelRadius)]
    pub fn model_radius(&self) -> Option<f32> {
        self.scene.as_ref().map(|_| self.framing.radius_m())
    }

    /// The adapter in use, the size of the picture, and what a budget of time chose.
    pub fn info(&self) -> ViewerInfo {
        self.canvas.info(self.quality())
    }
}

impl Viewer {
    /// Tells the budget, if there is one, what the frame took that was begun at `started`: until the device has drawn it.
    pub(super) async fn take_time(&mut self, started: Instant) -> Result<(), JsError> {
        if self.budget.is_none() {
            return Ok(());
        }
        let done = self.renderer.gpu().done().await?;
        if let Some(budget) = &mut self.budget {
            budget.take(done.duration_since(started).as_secs_f64() * 1e3);
        }
        Ok(())
    }

    /// `QualityInfo` of the TypeScript section, or null.
    pub(super) fn quality(&self) -> JsValue {
        self.budget.as_ref().map_or(JsValue::NULL, info)
    }
}

fn info(budget: &QualityBudget) -> JsValue {
    let settings: Vec<(&str, JsValue)> =
        budget.changed().iter().map(|(key, value)| (key.as_str(), js_value(value))).collect();
    object(&[
        ("budgetMs", budget.budget_ms().into()),
        ("rung", budget.rung().into()),
        ("settings", object(&settings)),
        ("changes", budget.changes().into()),
        ("settledAfterFrames", budget.settled_after().into()),
        ("medianMs", budget.median_ms().map_or(JsValue::NULL, JsValue::from)),
    ])
}

fn js_value(value: &Value) -> JsValue {
    match value {
        Value::Bool(flag) => (*flag).into(),
        Value::Number(number) => number.as_f64().map_or(JsValue::NULL, JsValue::from),
        Value::String(text) => text.as_str().into(),
        Value::Array(values) => values.iter().map(js_value).collect::<js_sys::Array>().into(),
        Value::Null | Value::Object(_) => JsValue::NULL,
    }
}
