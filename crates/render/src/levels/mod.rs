//! Levels of detail: which form of what is drawn a view shows, by its size in the picture.
//!
//! Source: switching where a level's error, projected onto the picture, is a pixel (Luebke et al. 2002, "Level of
//! Detail for 3D Graphics", chapter 4); two levels are faded into each other by a pattern of which either draws its own
//! pixels (screen-door transparency, as Mulder et al. 1998 have it). All is a function of the camera, so that a frame
//! depends on none before it.

mod settings;
mod surface;

pub use settings::LodSettings;
pub(crate) use surface::{SurfaceForm, SurfaceForms};

use crate::constants::FADE_STEPS;
use crate::view::View;
use glam::Vec3;
use manypass_scene::Projection;
use serde::Serialize;

/// What is shown of something that has levels: one of them, and where the next one fades in, its share of the pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Choice {
    /// 0 is the finest. One more than there are is nothing.
    pub level: u32,
    /// The share of the pixels that show the next level instead; below 1.
    pub next_share: f32,
}

impl Choice {
    /// The level that most pixels show.
    pub fn nearest(&self) -> u32 {
        self.level + u32::from(self.next_share >= 0.5)
    }

    /// Of levels that begin one after the other as something shrinks: `shrunk(i)` says how many times as small it is as
    /// where level i + 1 begins, and does not rise with i. The next one has faded in where it is `fade` smaller than
    /// that, or where the one after it begins.
    fn of(count: usize, shrunk: impl Fn(usize) -> f32, fade: f32) -> Self {
        let begun = (0..count).take_while(|index| shrunk(*index) > 1.0).count();
        let Some(last) = begun.checked_sub(1) else { return Self::default() };
        let until_next = if begun < count { shrunk(last) / shrunk(begun) } else { f32::INFINITY };
        let range = (1.0 + fade).min(until_next) - 1.0;
        let share = if range > 0.0 { (shrunk(last) - 1.0) / range } else { 1.0 };
        // As finely as the pattern of pixels has it, so that both levels agree on who draws what.
        let next_share = (share * FADE_STEPS as f32).round() / FADE_STEPS as f32;
        if next_share < 1.0 {
            Self { level: last as u32, next_share }
        } else {
            Self { level: begun as u32, next_share: 0.0 }
        }
    }
}

/// Something with levels of a file: what the ball around its finest one takes of the picture says which is shown.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    pub center: Vec3,
    pub radius_m: f32,
    /// The share of the picture's area down to which each level is shown; without an entry for the last, that always
    /// is.
    pub ends: Vec<f32>,
}

/// How a view chooses.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Chooser {
    eye_world: Vec3,
    /// Pixels of a metre, at a distance of 1 m if the projection is perspective.
    px_per_m: f32,
    is_orthographic: bool,
    picture_px: f32,
    error_px: f32,
    fade: f32,
    pub is_enabled: bool,
    /// Below so many pixels surfaces take each of [`SurfaceForm::REDUCED`]; none does so above the one before.
    reduced_px: Option<[f32; SurfaceForm::REDUCED.len()]>,
    /// Of the world's groups.
    pub groups: Vec<Choice>,
}

impl Chooser {
    /// Of a camera, for a picture of a size, whatever the size at which it is shaded.
    pub fn new(camera: &View, (width, height): (u32, u32), settings: &LodSettings, groups: &[Group]) -> Self {
        let (height_m, is_orthographic) = match camera.projection {
            Projection::Perspective { fov_y_rad, .. } => (2.0 * (0.5 * fov_y_rad).tan(), false),
            Projection::Orthographic { height_m, .. } => (height_m, true),
        };
        let mut chooser = Self {
            eye_world: camera.world_from_view.w_axis.truncate(),
            px_per_m: settings.bias.exp2() * height as f32 / height_m.max(f32::MIN_POSITIVE),
            is_orthographic,
            picture_px: width as f32 * height as f32,
            error_px: settings.error_px,
            fade: settings.fade,
            is_enabled: settings.enabled,
            reduced_px: settings.reduces_materials().then(|| {
                let LodSettings { material_px, plain_px, untextured_px, .. } = *settings;
                [material_px, material_px.min(plain_px), material_px.min(plain_px).min(untextured_px)]
            }),
            groups: Vec::new(),
        };
        chooser.groups = groups.iter().map(|group| chooser.of_group(group)).collect();
        chooser
    }

    /// Pixels of a metre at a distance from the eye.
    fn px_per_m_at(&self, distance_m: f32) -> f32 {
        if self.is_orthographic { self.px_per_m } else { self.px_per_m / distance_m.max(f32::MIN_POSITIVE) }
    }

    fn of_group(&self, group: &Group) -> Choice {
        if !self.is_enabled {
            return Choice::default();
        }
        // The outline of a ball is where lines of sight touch it: its disc is as wide as a flat one there.
        let distance_m = group.center.distance(self.eye_world);
        let outline_m = ((distance_m - group.radius_m) * (distance_m + group.radius_m)).max(0.0).sqrt();
        let radius_px = group.radius_m * self.px_per_m_at(outline_m);
        let coverage = std::f32::consts::PI * radius_px * radius_px / self.picture_px;
        // Sizes, whose squares areas are.
        let shrunk = |level: usize| (group.ends[level] / coverage.clamp(f32::MIN_POSITIVE, 1.0)).sqrt();
        let count = group.ends.iter().take_while(|end| **end > 0.0).count();
        Choice::of(count, shrunk, self.fade)
    }

    /// Whether surfaces may be drawn with less than their materials have.
    pub fn reduces_materials(&self) -> bool {
        self.reduced_px.is_some()
    }

    /// Which step of its forms a surface in a ball takes; 0 is the whole material.
    pub fn of_surface(&self, (center, radius_m): (Vec3, f32), forms: SurfaceForms) -> Choice {
        let Some(reduced_px) = self.reduced_px.filter(|_| !forms.is_empty()) else { return Choice::default() };
        let diameter_px = 2.0 * radius_m * self.px_per_m_at(center.distance(self.eye_world));
        let mut begins_px = [0.0; SurfaceForm::REDUCED.len()];
        let mut count = 0;
        for (_, px) in SurfaceForm::REDUCED.into_iter().zip(reduced_px).filter(|(form, _)| forms.has(*form)) {
            begins_px[count] = px;
            count += 1;
        }
        Choice::of(count, |step| begins_px[step] / diameter_px.max(f32::MIN_POSITIVE), self.fade)
    }

    /// Of what lies in a ball and has levels with these errors, in metres of the world.
    pub fn of_errors(&self, (center, radius_m): (Vec3, f32), errors_m: &[f32]) -> Choice {
        if !self.is_enabled {
            return Choice::default();
        }
        let px_per_m = self.px_per_m_at(center.distance(self.eye_world) - radius_m);
        Choice::of(errors_m.len(), |level| self.error_px / (errors_m[level] * px_per_m), self.fade)
    }
}

/// The count of what was drawn of one level of detail, over all meshes with levels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct LevelCount {
    /// How often primitives were drawn at it; those that fade count for both of their levels.
    pub primitives: u64,
    /// Their triangles.
    pub triangles: u64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_follow_each_other_without_a_jump() {
        let errors = [0.01, 0.02, 0.021, 0.08];
        let choice = |distance: f32| Choice::of(errors.len(), |i| distance * 0.001 / errors[i], 0.25);
        assert_eq!(choice(5.0), Choice::default());
        assert_eq!(choice(15.0), Choice { level: 1, next_share: 0.0 });
        assert_eq!(choice(1e9), Choice { level: 4, next_share: 0.0 });
        let shown = |choice: Choice| choice.level as f32 + choice.next_share;
        let mut last = shown(choice(1.0));
        for step in 0..20_000 {
            let next = shown(choice(1.0 + 0.01 * step as f32));
            assert!(next >= last && next - last < 0.03, "{step}: {last} {next}");
            last = next;
        }
        assert_eq!(choice(11.25).next_share, 0.5);
        assert_eq!((choice(11.3).nearest(), choice(11.2).nearest()), (1, 0));
        // What costs nothing is shown from the beginning.
        assert_eq!(Choice::of(2, |i| [f32::INFINITY, f32::INFINITY][i], 0.25).level, 2);
        assert_eq!(Choice::of(1, |_| 1.1, 0.0), Choice { level: 1, next_share: 0.0 });
    }

    fn camera(distance_m: f32) -> View {
        let projection = Projection::Perspective { fov_y_rad: 1.0, near_m: 0.1, far_m: None };
        View { world_from_view: glam::Mat4::from_translation(Vec3::Z * distance_m), projection }
    }

    #[test]
    fn coverage_is_the_share_of_the_picture() {
        let group = Group { center: Vec3::ZERO, radius_m: 1.0, ends: vec![0.25, 0.01] };
        let settings = LodSettings { fade: 0.0, ..LodSettings::default() };
        let chosen = |distance_m: f32, settings: &LodSettings| {
            Chooser::new(&camera(distance_m), (200, 100), settings, std::slice::from_ref(&group)).groups[0].level
        };
        // The disc of the ball is as wide as its tangent cone, whose sine is the radius by the distance.
        let distance_m = |coverage: f32| {
            let radius_px = (coverage * 200.0 * 100.0 / std::f32::consts::PI).sqrt();
            1.0 / (radius_px * 2.0 * 0.5f32.tan() / 100.0).atan().sin()
        };
        assert_eq!(chosen(0.99 * distance_m(0.25), &settings), 0);
        assert_eq!(chosen(1.01 * distance_m(0.25), &settings), 1);
        assert_eq!(chosen(0.999 * distance_m(0.01), &settings), 1);
        assert_eq!(chosen(1.001 * distance_m(0.01), &settings), 2);
        assert_eq!(chosen(1.001 * distance_m(0.01), &LodSettings { enabled: false, ..settings.clone() }), 0);
        // Twice as large is four times the area.
        let twice = LodSettings { bias: 1.0, ..settings.clone() };
        assert_eq!([0.999, 1.001].map(|times| chosen(times * distance_m(0.25 / 4.0), &twice)), [0, 1]);
        assert_eq!(chosen(0.5, &settings), 0, "within the ball");
    }

    #[test]
    fn surfaces_lose_what_they_have_step_by_step() {
        let settings = LodSettings { fade: 0.0, materials: true, plain_px: 20.0, ..LodSettings::default() };
        let px_per_m = 100.0 / (2.0 * 0.5f32.tan());
        let form = |diameter_px: f32, forms: SurfaceForms| {
            let chooser = Chooser::new(&camera(px_per_m / diameter_px), (200, 100), &settings, &[]);
            forms.at(chooser.of_surface((Vec3::ZERO, 0.5), forms).nearest())
        };
        let all = SurfaceForms::of(|_| true);
        // Layers do not outlive normal maps, whatever is asked for.
        let found = [16.1, 15.9, 4.1, 3.9].map(|px| form(px, all));
        assert_eq!(found, [SurfaceForm::Whole, SurfaceForm::Plain, SurfaceForm::Plain, SurfaceForm::Untextured]);
        let textured = SurfaceForms::of(|form| form == SurfaceForm::Untextured);
        assert_eq!([4.1, 3.9].map(|px| form(px, textured)), [SurfaceForm::Whole, SurfaceForm::Untextured]);
        assert_eq!(form(0.1, SurfaceForms::default()), SurfaceForm::Whole);
        let off = Chooser::new(&camera(1e3), (200, 100), &LodSettings::default(), &[]);
        assert_eq!(off.of_surface((Vec3::ZERO, 0.5), all), Choice::default());
    }

    #[test]
    fn a_level_begins_where_its_error_is_a_pixel() {
        let settings = LodSettings { fade: 0.0, error_px: 2.0, ..LodSettings::default() };
        let px_per_m = 100.0 / (2.0 * 0.5f32.tan());
        let level = |distance_m: f32| {
            let chooser = Chooser::new(&camera(distance_m), (200, 100), &settings, &[]);
            chooser.of_errors((Vec3::ZERO, 3.0), &[0.5, 1.0]).level
        };
        let distance_m = 3.0 + 0.5 * px_per_m / 2.0;
        assert_eq!([0.99, 1.01].map(|times| level(times * distance_m)), [0, 1]);
        assert_eq!(level(2.0), 0);
    }
}
