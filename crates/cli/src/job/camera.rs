//! The flags of the camera, checked.

use crate::args::FrameArgs;
use crate::camera::{AUTOMATIC, CameraSpec, Place};
use crate::failure::Failure;
use glam::{DVec3, Vec3};

/// The largest coordinate and distance: their squares, and sums of those, can still be computed.
const LARGEST: f64 = 1e15;

/// Numbers too large to be stored are read as infinity, and are out of range; no number is none.
fn is_number(number: &f32) -> bool {
    !number.is_nan()
}

fn out_of_range(flag: &str, text: &str) -> Failure {
    Failure::usage(format!("{flag} {text} is out of range"), "give numbers from -1e15 to 1e15")
}

/// Three numbers with all digits that doubles have: the model may lie far from the origin.
fn vector(text: &str, flag: &str) -> Result<DVec3, Failure> {
    let number = |text: &str| text.trim().parse().ok().filter(|number: &f64| !number.is_nan());
    let numbers: Option<Vec<f64>> = text.split(',').map(number).collect();
    match numbers.as_deref() {
        Some([x, y, z]) if [x, y, z].iter().any(|n| n.abs() > LARGEST) => Err(out_of_range(flag, text)),
        Some([x, y, z]) => Ok(DVec3::new(*x, *y, *z)),
        _ => Err(Failure::usage(format!("`{text}` is not three numbers"), format!("write {flag} X,Y,Z"))),
    }
}

/// The camera that the flags describe; it may go around on a turntable.
///
/// # Errors
/// Numbers out of range, or flags that contradict each other.
pub fn spec(args: &FrameArgs, turns: bool) -> Result<CameraSpec, Failure> {
    let mut spec = CameraSpec::default();
    let positive = |value: Option<f32>, flag: &str| match value {
        Some(value) if !(value.is_finite() && value > 0.0) => {
            Err(Failure::usage(format!("{flag} {value} is out of range"), "give a number above 0"))
        }
        value => Ok(value),
    };
    spec.place = match (&args.camera, &args.eye, &args.orbit) {
        (Some(name), _, _) if name == AUTOMATIC => Place::Automatic,
        (Some(name), _, _) => Place::Named(name.clone()),
        (_, Some(eye), _) => Place::Eye(vector(eye, "--eye")?),
        (_, _, Some(orbit)) => orbit_place(orbit)?,
        _ => Place::Default,
    };
    spec.target = args.target.as_deref().map(|text| vector(text, "--target")).transpose()?;
    spec.up = args.up.as_deref().map(|text| vector(text, "--up")).transpose()?.map(|up| up.as_vec3());
    if spec.up == Some(Vec3::ZERO) {
        return Err(Failure::usage("--up has no length", "write --up 0,1,0"));
    }
    if let Some(degrees) = positive(args.fov_y, "--fov-y")? {
        if degrees >= 180.0 {
            return Err(Failure::usage(format!("--fov-y {degrees} is out of range"), "give degrees between 0 and 180"));
        }
        spec.fov_y_rad = Some(degrees.to_radians());
    }
    spec.ortho_height_m = positive(args.ortho_height, "--ortho-height")?;
    spec.near_m = positive(args.near, "--near")?;
    spec.far_m = positive(args.far, "--far")?;
    spec.turns = turns;
    if spec.near_m.zip(spec.far_m).is_some_and(|(near, far)| near >= far) {
        return Err(Failure::usage("--near is not below --far", "give a nearer --near"));
    }
    Ok(spec)
}

fn orbit_place(text: &str) -> Result<Place, Failure> {
    let parts: Vec<&str> = text.split(',').map(str::trim).collect();
    let number = |text: &str| text.parse::<f32>().ok().filter(is_number);
    let values: Vec<f32> = parts.iter().filter_map(|part| number(part)).collect();
    if values.len() + usize::from(parts.get(2) == Some(&"auto")) == 3 && parts.len() == 3 {
        if values.iter().any(|value| f64::from(value.abs()) > LARGEST) {
            return Err(out_of_range("--orbit", text));
        }
        if values.get(2).is_some_and(|radius_m| *radius_m <= 0.0) {
            let hint = "RADIUS must be above 0, or auto: --orbit YAW,PITCH,RADIUS";
            return Err(Failure::usage(format!("--orbit {text} is out of range"), hint));
        }
    }
    let parsed = match parts[..] {
        [yaw, pitch, "auto"] => number(yaw).zip(number(pitch)).map(|(yaw, pitch)| (yaw, pitch, None)),
        [yaw, pitch, radius] => number(yaw)
            .zip(number(pitch))
            .zip(number(radius).filter(|r| *r > 0.0))
            .map(|((yaw, pitch), radius)| (yaw, pitch, Some(radius))),
        _ => None,
    };
    let (yaw_deg, pitch_deg, radius_m) = parsed.ok_or_else(|| {
        Failure::usage(format!("`{text}` is not an orbit"), "write --orbit YAW,PITCH,RADIUS; RADIUS may be auto")
    })?;
    Ok(Place::Orbit { yaw_deg, pitch_deg, radius_m })
}
