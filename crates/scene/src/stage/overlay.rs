//! What a stage draws over the picture.

use super::table::{Source, SpannedValue, Table};
use crate::gltf_file::{MAX_FILE_BYTES, texel_budget_bytes};
use crate::overlay::{
    Anchor, Font, LinePoints, OVERLAY_MONITORS_MAX, Overlay, OverlayItem, OverlayLine, OverlayMonitor, OverlayPlace,
    OverlayShape, OverlaySprite, OverlayText, PlaceOf, TextAlign,
};
use crate::{Diagnostic, Image, ImageSource, PixelFormat, Pixels, Scene};
use glam::{Vec2, Vec3};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Keys that name a file.
pub(super) const FILES: [&str; 2] = ["sprite", "font"];

/// The keys that say what an item is.
const SHAPES: [&str; 5] = ["text", "sprite", "monitor", "points", "points_world"];

/// Keys that only some items have, and the keys of what these are.
const OF_SHAPES: [(&str, &[&str]); 10] = [
    ("size_px", &["text"]),
    ("align", &["text"]),
    ("font", &["text"]),
    ("background", &["text"]),
    ("background_opacity", &["background"]),
    ("padding_px", &["text"]),
    ("width_px", &["points", "points_world", "sprite", "monitor"]),
    ("height_px", &["sprite", "monitor"]),
    ("rotation_deg", &["sprite", "monitor"]),
    ("position", &["text", "sprite", "monitor", "points"]),
];

/// An item whose files were not read yet.
#[derive(Clone, Debug)]
pub(super) struct OverlayEntry {
    item: OverlayItem,
    sprite: Option<SpannedValue<String>>,
    font: Option<SpannedValue<String>>,
    node: Option<SpannedValue<String>>,
    monitor: Option<SpannedValue<String>>,
}

impl OverlayEntry {
    pub(super) fn read(table: &Table<'_>) -> Result<Self, Box<Diagnostic>> {
        check_keys(table)?;
        for key in FILES {
            if table.text(key).is_some_and(|name| name.value.trim().is_empty()) {
                let example = if key == "font" { "caption.ttf" } else { "logo.png" };
                return Err(table.fault(key, format!("the name of `{key}` is empty; name a file such as {example}")));
            }
        }
        let entry = Self {
            item: OverlayItem {
                color_linear: table.vector("color").unwrap_or(Vec3::ONE),
                opacity: table.number("opacity").unwrap_or(1.0),
                depth_test: table.boolean("depth_test").unwrap_or(false),
                depth_offset_m: table.number("depth_offset_m").unwrap_or(0.0),
                shape: shape(table),
                place: place(table),
            },
            sprite: table.text("sprite"),
            font: table.text("font"),
            node: table.text("node"),
            monitor: table.text("monitor"),
        };
        // What a sprite is, is known with its texels.
        if entry.sprite.is_none() {
            entry.item.check().map_err(|fault| table.fault(fault.key, fault.message))?;
        }
        Ok(entry)
    }

    /// The name of the monitor that it shows.
    pub(super) fn monitor(&self) -> Option<&str> {
        self.monitor.as_ref().map(|name| name.value.as_str())
    }

    /// The files that it names.
    pub(super) fn files(&self) -> impl Iterator<Item = &SpannedValue<String>> {
        self.sprite.iter().chain(&self.font)
    }
}

fn check_keys(table: &Table<'_>) -> Result<(), Box<Diagnostic>> {
    let has = |key: &&str| table.place(key).is_some();
    let shapes: Vec<&str> = SHAPES.into_iter().filter(has).collect();
    match shapes[..] {
        [_] => {}
        [] => {
            return Err(
                table.fault("text", "an item needs one of `text`, `sprite`, `monitor`, `points` and `points_world`")
            );
        }
        [first, second, ..] => {
            return Err(
                table.fault(second, format!("an item is one thing: `{first}` or `{second}`; write two of them"))
            );
        }
    }
    for (key, of) in OF_SHAPES {
        if table.place(key).is_some() && !of.iter().any(|shape| table.place(shape).is_some()) {
            return Err(table.fault(key, format!("`{key}` is only for items with `{}`", of.join("` or `"))));
        }
    }
    let in_world = [table.place("at_world"), table.place("node"), table.place("points_world")];
    if in_world.iter().flatten().count() > 1 {
        return Err(table.fault("at_world", "an item is in one place: `at_world`, `node` or `points_world`"));
    }
    let is_line = table.place("points").is_some() || table.place("points_world").is_some();
    if is_line && table.place("anchor").is_some() && in_world.iter().any(Option::is_some) {
        return Err(table.fault("anchor", "a line in the world has no anchor: its points say where it is"));
    }
    Ok(())
}

fn place(table: &Table<'_>) -> OverlayPlace {
    let of = match (table.vector("at_world"), table.text("node")) {
        (Some(position), _) => PlaceOf::World(position),
        (None, Some(name)) => PlaceOf::Node(name.value),
        (None, None) => PlaceOf::Picture,
    };
    let anchor = table.text("anchor").and_then(|name| Anchor::named(&name.value));
    OverlayPlace { of, offset_px: table.pair("position").unwrap_or(Vec2::ZERO), anchor }
}

fn shape(table: &Table<'_>) -> OverlayShape {
    let width_px = table.number("width_px");
    if let Some(text) = table.text("text") {
        return OverlayShape::Text(OverlayText {
            size_px: table.number("size_px").unwrap_or(16.0),
            align: table.text("align").and_then(|name| TextAlign::named(&name.value)).unwrap_or_default(),
            background: table
                .vector("background")
                .map(|color| (color, table.number("background_opacity").unwrap_or(1.0))),
            padding_px: table.number("padding_px").unwrap_or(0.0),
            // Ends of lines as other systems write them.
            ..OverlayText::new(text.value.replace("\r\n", "\n"))
        });
    }
    if let Some(monitor) = table.text("monitor") {
        return OverlayShape::Monitor(OverlayMonitor {
            name: monitor.value,
            size_px: [width_px, table.number("height_px")],
            rotation_deg: table.number("rotation_deg").unwrap_or(0.0),
        });
    }
    let points = match (table.pairs("points"), table.vectors("points_world")) {
        (Some(points), _) => Some(LinePoints::Pixels(points.to_vec())),
        (None, points) => points.map(|points| LinePoints::World(points.to_vec())),
    };
    match points {
        Some(points) => OverlayShape::Line(OverlayLine { points, width_px: width_px.unwrap_or(1.0) }),
        None => OverlayShape::Sprite(OverlaySprite {
            pixels: Arc::new(Pixels { width: 0, height: 0, format: PixelFormat::Rgba8, data: Vec::new() }),
            size_px: [width_px, table.number("height_px")],
            rotation_deg: table.number("rotation_deg").unwrap_or(0.0),
        }),
    }
}

/// The overlay of `entries`, with the files that `resolve` reads, each once.
///
/// # Errors
/// A file cannot be read, all of them take too much memory together, or `scene` has no node of a name.
pub(super) fn overlay(
    entries: &[OverlayEntry],
    source: &Source,
    scene: &Scene,
    resolve: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
) -> Result<Overlay, Box<Diagnostic>> {
    if let Some(monitor) = entries.iter().filter_map(|entry| entry.monitor.as_ref()).nth(OVERLAY_MONITORS_MAX) {
        let message = format!("{OVERLAY_MONITORS_MAX} items of an overlay may be monitors, and there are more");
        return Err(source.fault(monitor.range.clone(), message));
    }
    let mut files = OverlayFiles::default();
    let mut items = Vec::with_capacity(entries.len());
    let has_nodes = entries.iter().any(|entry| entry.node.is_some());
    let nodes = if has_nodes { scene.nodes.as_slice() } else { &[] };
    let names: HashSet<&str> = nodes.iter().map(|node| node.name.as_str()).collect();
    for entry in entries {
        let mut item = entry.item.clone();
        if let Some(node) = &entry.node
            && !names.contains(node.value.as_str())
        {
            let known = scene.nodes.iter().map(|node| node.name.as_str()).filter(|name| !name.is_empty());
            let message = format!("the model has no node called `{}`", node.value);
            return Err(source.unknown(node.range.clone(), message, &node.value, known));
        }
        if let Some(monitor) = &entry.monitor
            && !scene.monitors().any(|(_, image, _)| image.name == monitor.value)
        {
            let known = scene.monitors().map(|(_, image, _)| image.name.as_str());
            let message = format!("the stage has no monitor called `{}`", monitor.value);
            return Err(source.unknown(monitor.range.clone(), message, &monitor.value, known));
        }
        if let (OverlayShape::Sprite(sprite), Some(name)) = (&mut item.shape, &entry.sprite) {
            sprite.pixels = files.sprite(source, name, resolve)?;
            item.check().map_err(|fault| source.fault(name.range.clone(), fault.to_string()))?;
        }
        if let (OverlayShape::Text(text), Some(name)) = (&mut item.shape, &entry.font) {
            text.font = Some(files.font(source, name, resolve)?);
        }
        items.push(item);
    }
    Ok(Overlay { items })
}

/// Files that were read, by their names.
#[derive(Default)]
struct OverlayFiles {
    sprites: HashMap<String, Arc<Pixels>>,
    fonts: HashMap<String, Arc<Font>>,
    encoded_bytes: u64,
    texel_bytes: u64,
}

impl OverlayFiles {
    /// Reads a file; together they are no larger than a model.
    fn bytes(
        &mut self,
        name: &str,
        resolve: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
    ) -> Result<Vec<u8>, String> {
        let bytes = resolve(name)?;
        self.encoded_bytes += bytes.len() as u64;
        if self.encoded_bytes > MAX_FILE_BYTES {
            return Err(format!("the files of the overlay take more than {} MiB", MAX_FILE_BYTES >> 20));
        }
        Ok(bytes)
    }

    fn sprite(
        &mut self,
        source: &Source,
        name: &SpannedValue<String>,
        resolve: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
    ) -> Result<Arc<Pixels>, Box<Diagnostic>> {
        if let Some(known) = self.sprites.get(&name.value) {
            return Ok(known.clone());
        }
        let fault = |message: String| source.fault(name.range.clone(), message);
        let bytes = self.bytes(&name.value, resolve).map_err(fault)?;
        let image = Image { name: name.value.clone(), source: ImageSource::Encoded(bytes.into()) };
        if image.holds_light() {
            return Err(fault(format!("`{}` holds light, and a sprite is of display colours; name a PNG", name.value)));
        }
        let (width, height) = image.dimensions().map_err(|error| fault(error.to_string()))?;
        self.texel_bytes += u64::from(width) * u64::from(height) * 4;
        let budget_bytes = texel_budget_bytes(self.encoded_bytes);
        if self.texel_bytes > budget_bytes {
            let most = budget_bytes >> 20;
            return Err(fault(format!("the sprites of the stage take more than {most} MiB; make them smaller")));
        }
        let pixels = Arc::new(image.decode().map_err(|error| fault(error.to_string()))?);
        self.sprites.insert(name.value.clone(), pixels.clone());
        Ok(pixels)
    }

    fn font(
        &mut self,
        source: &Source,
        name: &SpannedValue<String>,
        resolve: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
    ) -> Result<Arc<Font>, Box<Diagnostic>> {
        if let Some(known) = self.fonts.get(&name.value) {
            return Ok(known.clone());
        }
        let fault = |message: String| source.fault(name.range.clone(), message);
        let bytes = self.bytes(&name.value, resolve).map_err(fault)?;
        let font = Arc::new(Font::parse(&name.value, bytes).map_err(fault)?);
        self.fonts.insert(name.value.clone(), font.clone());
        Ok(font)
    }
}
