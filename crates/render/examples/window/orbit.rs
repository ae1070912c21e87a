//! A camera that the mouse turns about the middle of a scene.

use manypass::View;
use manypass::glam::{Mat4, Vec3};
use manypass::scene::{Framing, Scene, framing::orbit_rotation};
use winit::event::{ElementState, MouseScrollDelta, WindowEvent};

pub struct Orbit {
    center_world: Vec3,
    yaw_deg: f32,
    pitch_deg: f32,
    distance_m: f32,
    cursor: (f64, f64),
    is_dragged: bool,
}

impl Orbit {
    /// At the distance from which all of `scene` is seen.
    pub fn around(scene: &Scene) -> Self {
        let framing = Framing::of_scene(scene);
        let eye = View::framing(&framing, 1.0).world_from_view.w_axis.truncate();
        let center_world = framing.center_world();
        let distance_m = eye.distance(center_world);
        Self { center_world, yaw_deg: 30.0, pitch_deg: 28.0, distance_m, cursor: (0.0, 0.0), is_dragged: false }
    }

    pub fn follow(&mut self, event: &WindowEvent) {
        match event {
            WindowEvent::MouseInput { state, .. } => self.is_dragged = *state == ElementState::Pressed,
            WindowEvent::CursorMoved { position, .. } => {
                let (x, y) = std::mem::replace(&mut self.cursor, (*position).into());
                if self.is_dragged {
                    self.yaw_deg -= 0.3 * (position.x - x) as f32;
                    self.pitch_deg = (self.pitch_deg + 0.3 * (position.y - y) as f32).clamp(-89.0, 89.0);
                }
            }
            WindowEvent::MouseWheel { delta, .. } => {
                let lines = match delta {
                    MouseScrollDelta::LineDelta(_, lines) => *lines,
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y as f32 / 40.0,
                };
                self.distance_m *= 0.9f32.powf(lines);
            }
            _ => {}
        }
    }

    pub fn world_from_view(&self) -> Mat4 {
        let rotation = orbit_rotation(self.yaw_deg, self.pitch_deg, Vec3::Y);
        let eye = self.center_world + self.distance_m * (rotation * Vec3::Z);
        Mat4::from_rotation_translation(rotation, eye)
    }
}
