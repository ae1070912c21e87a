//! Kinds of views: pictures, and the views within them. What depends on the kind is answered here, by the file that makes
//! views of that kind.

use super::probes::DueProbe;
use crate::fisheye::{Face, FisheyeFaces};
use crate::shader::program::Constant;
use glam::{Vec2, Vec3};
use manypass_scene::NodeId;

/// What is to be known of a view because of its kind. Each kind is a difference to [`Self::picture`].
#[derive(Clone, Debug)]
pub(super) struct ViewKind {
    /// What it is recorded as.
    pub drawing: Drawing,
    /// Whether it is within a picture, over which nothing is laid.
    pub is_within: bool,
    /// Whether the numbers of a frame count it among pictures within pictures.
    pub is_capture: bool,
    /// Whether it draws surfaces. If not, it is put together from views before it, and shaded at the picture's own size.
    pub draws_surfaces: bool,
    /// Whether it may see what is beside the frustum of its camera.
    pub is_sheared: bool,
    /// By how much its picture is moved, and how far it then reaches beyond its frustum, in metres a metre.
    pub shear: (Vec2, f32),
    /// Whether its samples are averaged.
    pub has_means: bool,
    /// The corners of a rectangle, one after the other, if nothing is shown of it beside that.
    pub outline_world: Option<[Vec3; 4]>,
    /// How many times as wide what it draws is as what the view shows that it is drawn for.
    pub margin: f32,
    /// Constants of its pipelines.
    pub constants: &'static [Constant],
    /// Whether what is far from its eye may be lit more simply.
    pub simplifies_far_light: bool,
    /// Whether surfaces are drawn from behind, too.
    pub shows_backs: bool,
    /// Whether it is a side of what is around a probe. Shadow maps then serve all directions.
    pub is_around: bool,
    /// Whether the shadow catcher may keep the border of its picture free of shadow.
    pub keeps_border: bool,
    /// Which captured light reaches what it shows.
    pub captured_light: CapturedLight,
    /// How often its reflection probe was captured before in this frame, if it is a side of one.
    pub bounce: Option<u32>,
}

/// Which captured light reaches surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CapturedLight {
    /// None: it is being captured.
    None,
    /// That of irradiance probes.
    Irradiance,
    /// That of irradiance probes and reflection probes.
    All,
}

/// What a view is recorded as. Only `record.rs`, and files that make views of a kind, ask for it.
#[derive(Clone, Debug)]
pub(super) enum Drawing {
    /// A picture.
    Picture,
    /// A view that the picture of a fisheye is put together from, which follows it.
    Face(Face),
    /// The picture of a fisheye, put together from the views before it.
    Fisheye(FisheyeFaces),
    /// What a monitor's camera sees, which views after it show.
    Monitor(MonitorView),
    /// What is behind a mirror or water, or through a portal, which the view after it shows.
    Mirror(MirrorView),
    /// A side of a reflection probe, which views after it have as their environment.
    Side(SideView),
    /// A side of what is around an irradiance probe, which views after it have the light of.
    Probe(ProbeSide),
}

impl ViewKind {
    /// A picture.
    pub fn picture() -> Self {
        Self {
            drawing: Drawing::Picture,
            is_within: false,
            is_capture: false,
            draws_surfaces: true,
            is_sheared: false,
            shear: (Vec2::ZERO, 0.0),
            has_means: true,
            outline_world: None,
            margin: 1.0,
            constants: &[],
            simplifies_far_light: true,
            shows_backs: false,
            is_around: false,
            keeps_border: true,
            captured_light: CapturedLight::All,
            bounce: None,
        }
    }

    /// A view within pictures, which is drawn anew whenever it is shown, and without the means of samples.
    pub fn within(drawing: Drawing) -> Self {
        Self { drawing, is_within: true, has_means: false, keeps_border: false, ..Self::picture() }
    }
}

/// What a monitor's camera sees.
#[derive(Clone, Debug)]
pub(super) struct MonitorView {
    /// The index of the monitor's image.
    pub image: usize,
    /// In how many other pictures it is seen.
    pub level: u32,
    /// The monitors that are dark where it sees them, because they would be too deep.
    pub darkens: Vec<usize>,
    /// By how many stops it is exposed more than the picture.
    pub exposure_stops: f32,
}

/// What reflects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Reflector {
    /// The mesh of a node.
    Node(NodeId),
    /// A surface of water of the scene, by its index.
    Water(usize),
    /// A portal of the scene, by its index, and one of its ends: it reflects nothing, but has a view behind it as mirrors
    /// have.
    Portal(usize, usize),
}

/// What a view shows of a mirror.
#[derive(Clone, Debug)]
pub(super) struct MirrorLink {
    /// The name of the view behind it.
    pub view: String,
    pub of: Reflector,
    /// The unit normal of its plane, towards the eye.
    pub normal_world: Vec3,
    pub corners_world: [Vec3; 4],
    pub is_smooth: bool,
}

/// The view behind a mirror.
#[derive(Clone, Copy, Debug)]
pub(super) struct MirrorView {
    pub is_smooth: bool,
    /// What shows it.
    pub of: Reflector,
}

/// A side of the pictures around a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct SideView {
    /// How often they were captured before, in this frame.
    pub bounce: u32,
    /// Which surroundings.
    pub index: usize,
    /// Which face of a cube map.
    pub face: usize,
}

/// A side of what is to be seen around a probe.
#[derive(Clone, Copy, Debug)]
pub(super) struct ProbeSide {
    pub of: DueProbe,
    pub face: usize,
    /// Whether what is found is read by later frames alone.
    pub is_apart: bool,
}
