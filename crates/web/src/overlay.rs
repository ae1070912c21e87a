//! `OverlayItem` of the TypeScript section, as the text that stages have.

use wasm_bindgen::prelude::*;

/// Tables `[[overlay]]` with the keys and values of the objects in an array.
///
/// # Errors
/// It is no array of objects, or a value is none of TOML.
pub fn text_of(items: &JsValue) -> Result<String, JsError> {
    let Some(items) = items.dyn_ref::<js_sys::Array>() else {
        return Err(JsError::new("the overlay is an array of objects, such as [{ text: \"draft\" }]"));
    };
    let mut text = String::new();
    for item in items.iter() {
        let Some(item) = item.dyn_ref::<js_sys::Object>() else {
            return Err(JsError::new("an item of the overlay is an object, such as { text: \"draft\" }"));
        };
        text.push_str("[[overlay]]\n");
        for entry in js_sys::Object::entries(item).iter() {
            let entry = js_sys::Array::from(&entry);
            let (key, value) = (entry.get(0), entry.get(1));
            if !value.is_undefined() {
                text.push_str(&format!("{} = {}\n", written(&key)?, written(&value)?));
            }
        }
    }
    Ok(text)
}

/// A value as TOML writes it: JSON does so, but for numbers that are none.
fn written(value: &JsValue) -> Result<String, JsError> {
    if let Some(number) = value.as_f64().filter(|number| !number.is_finite()) {
        return Ok(if number.is_nan() { "nan".into() } else { number.to_string() });
    }
    if let Some(values) = value.dyn_ref::<js_sys::Array>() {
        let values: Vec<String> = values.iter().map(|value| written(&value)).collect::<Result<_, _>>()?;
        return Ok(format!("[{}]", values.join(", ")));
    }
    let text = js_sys::JSON::stringify(value).ok().and_then(|text| text.as_string());
    text.filter(|_| !value.is_object() && !value.is_null()).ok_or_else(|| {
        JsError::new("a value of the overlay is a text, a number, true or false, or an array of numbers")
    })
}
