//! Monitors of a stage: what cameras of the scene see, and where it is shown.

use super::cameras::camera_called;
use super::screens::Screen;
use super::table::{Source, SpannedValue, Table};
use super::updates::update_of;
use crate::capture::{CaptureOptions, LAYERS_ALL, MONITOR_SIDE_MAX, MONITORS_MAX, Monitor, MonitorCamera};
use crate::framing::{DEFAULT_FOV_Y_RAD, look_along};
use crate::{Diagnostic, Image, Projection, Scene, Wrap};
use glam::{Mat4, Vec3};

/// The size of a picture where nobody says.
const SIZE_PX: (u32, u32) = (512, 288);
/// The nearest that a camera of a stage's own sees, in metres.
const NEAR_M: f32 = 0.01;

/// An entry of `[[monitors]]`.
#[derive(Clone, Debug)]
pub(super) struct MonitorEntry {
    name: SpannedValue<String>,
    camera: CameraSource,
    screen: Screen,
    size_px: (u32, u32),
    exposure_stops: f32,
    options: CaptureOptions,
}

/// From where it is seen.
#[derive(Clone, Debug)]
enum CameraSource {
    /// The name of a camera, or of a node.
    Named(SpannedValue<String>),
    At(MonitorCamera),
}

impl MonitorEntry {
    pub(super) fn read(table: &Table<'_>) -> Result<Self, Box<Diagnostic>> {
        let name = table.text("name").filter(|name| !name.value.trim().is_empty());
        let name = name.ok_or_else(|| table.fault("name", "a monitor needs a name"))?;
        let update = update_of(table)?;
        let layers = table.layers("layers").unwrap_or(LAYERS_ALL);
        let quality = table.text("quality").map(|word| word.value);
        Ok(Self {
            camera: seen(table)?,
            screen: Screen::read(table)?,
            size_px: size_px(table)?,
            exposure_stops: table.number("exposure_stops").unwrap_or(0.0),
            options: CaptureOptions { update, layers, quality },
            name,
        })
    }

    /// Adds its image to the scene, and puts it where it is shown. `over_picture` are the names of monitors that are
    /// shown over the picture.
    ///
    /// # Errors
    /// The model has no camera or material of a name.
    pub(super) fn apply(
        &self,
        source: &Source,
        scene: &mut Scene,
        over_picture: &[&str],
        warnings: &mut Vec<String>,
    ) -> Result<(), Box<Diagnostic>> {
        let camera = self.camera_in(source, scene)?;
        let (width, height) = self.size_px;
        let monitor = Monitor {
            exposure_stops: self.exposure_stops,
            options: self.options.clone(),
            ..Monitor::new(camera, width, height)
        };
        let name = &self.name.value;
        scene.images.push(Image::of_monitor(name, monitor));
        if !self.screen.has_materials() && !over_picture.contains(&name.as_str()) {
            warnings.push(format!(
                "nothing shows the monitor `{name}`: give it `material`, or an [[overlay]] that names it"
            ));
        }
        self.screen.show_last_image(source, scene, (&format!("the monitor `{name}`"), Wrap::ClampToEdge), warnings)
    }

    fn camera_in(&self, source: &Source, scene: &Scene) -> Result<MonitorCamera, Box<Diagnostic>> {
        match &self.camera {
            CameraSource::At(camera) => Ok(*camera),
            CameraSource::Named(name) => Ok(MonitorCamera::Node(camera_called(source, scene, name)?)),
        }
    }
}

fn size_px(table: &Table<'_>) -> Result<(u32, u32), Box<Diagnostic>> {
    let Some(size) = table.pair("size_px") else { return Ok(SIZE_PX) };
    let is_side = |side: f32| side.fract() == 0.0 && (1.0..=MONITOR_SIDE_MAX as f32).contains(&side);
    if is_side(size.x) && is_side(size.y) {
        return Ok((size.x as u32, size.y as u32));
    }
    let message = format!("`size_px` is a width and a height, whole numbers from 1 to {MONITOR_SIDE_MAX}");
    Err(table.fault("size_px", message))
}

/// From where a monitor is seen.
fn seen(table: &Table<'_>) -> Result<CameraSource, Box<Diagnostic>> {
    let place = |key: &str| table.vector(key);
    let of_place = ["position", "target", "fov_deg"].into_iter().find(|key| table.place(key).is_some());
    match (table.text("camera"), of_place) {
        (Some(_), Some(key)) => Err(table.fault(key, format!("`camera` says from where already; leave out `{key}`"))),
        (Some(name), None) => Ok(CameraSource::Named(name)),
        (None, _) => {
            let (Some(position), Some(target)) = (place("position"), place("target")) else {
                let message = "a monitor needs `camera`, a camera of the model, or `position` and `target`";
                return Err(table.source.fault(table.range.clone(), message));
            };
            let rotation = look_along(target - position, Vec3::Y);
            let fault =
                || table.fault("target", "`position` and `target` are the same point, which gives no direction");
            let rotation = rotation.ok_or_else(fault)?;
            let fov_y_rad = table.number("fov_deg").map_or(DEFAULT_FOV_Y_RAD, f32::to_radians);
            Ok(CameraSource::At(MonitorCamera::Fixed {
                world_from_view: Mat4::from_rotation_translation(rotation, position),
                projection: Projection::Perspective { fov_y_rad, near_m: NEAR_M, far_m: None },
            }))
        }
    }
}

/// Whether all of them are possible together.
///
/// # Errors
/// There are too many, or two have one name.
pub(super) fn check(monitors: &[MonitorEntry], source: &Source) -> Result<(), Box<Diagnostic>> {
    if let Some(monitor) = monitors.get(MONITORS_MAX) {
        let message = format!("there are {} [[monitors]], and {MONITORS_MAX} are possible", monitors.len());
        return Err(source.fault(monitor.name.range.clone(), message));
    }
    for (at, monitor) in monitors.iter().enumerate() {
        if monitors.iter().take(at).any(|known| known.name.value == monitor.name.value) {
            let message = format!("two monitors are called `{}`", monitor.name.value);
            return Err(source.fault(monitor.name.range.clone(), message));
        }
    }
    Ok(())
}
