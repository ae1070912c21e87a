//! The Cornell box: a white room with a red and a green wall under a lamp, all of it matte, to see what light does
//! between surfaces (after Goral et al. 1984, "Modeling the Interaction of Light Between Diffuse Surfaces").

use super::builder::{Demo, pose};
use crate::material::Specular;
use crate::primitives::{cube, plane};
use crate::{Camera, Node, Projection, Scene, TexturedFactor};
use glam::{Quat, Vec3};
use std::f32::consts::FRAC_PI_2;

/// Half the width, depth and height of the room in metres.
const HALF_M: f32 = 1.0;

/// A room of 2 m that is open at its front, with a small box (`Box.Small`) and a tall one (`Box.Tall`) in it. A panel
/// in the ceiling (`Lamp`) shines, and there is no other light: without light maps or probes the room is dark but for
/// that.
pub fn cornell() -> Scene {
    let mut place = Demo::default();
    let projection = Projection::Perspective { fov_y_rad: 0.68, near_m: 0.05, far_m: None };
    place.scene.cameras.push(Camera { name: "Main".into(), projection, aspect: None });
    let eye = Vec3::new(0.0, HALF_M, 4.0);
    place.scene.add_node(None, Node { name: "Main".into(), camera: Some(0), ..pose(eye, Vec3::new(0.0, HALF_M, 0.0)) });
    let matte = |place: &mut Demo, name: &str, color: [f32; 3]| {
        let material = place.material(name, color, 0.0, 1.0);
        place.scene.materials[material].specular =
            Some(Specular { weight: TexturedFactor::new(0.0), ..Specular::default() });
        material
    };
    let white = matte(&mut place, "White", [0.73, 0.73, 0.73]);
    let red = matte(&mut place, "Red", [0.63, 0.06, 0.05]);
    let green = matte(&mut place, "Green", [0.14, 0.45, 0.09]);
    let lamp = matte(&mut place, "Lamp", [0.0; 3]);
    place.scene.materials[lamp].emissive_factor = Vec3::new(26.0, 18.5, 9.2);

    let [wall, left, right] = [white, red, green].map(|material| place.mesh(plane(2.0 * HALF_M), material));
    let turned = |name: &str, mesh: usize, translation: Vec3, rotation: Quat| Node {
        name: name.into(),
        mesh: Some(mesh),
        translation,
        rotation,
        ..Node::default()
    };
    let of_walls = [
        turned("Floor", wall, Vec3::ZERO, Quat::IDENTITY),
        turned("Ceiling", wall, Vec3::new(0.0, 2.0 * HALF_M, 0.0), Quat::from_rotation_x(2.0 * FRAC_PI_2)),
        turned("Back", wall, Vec3::new(0.0, HALF_M, -HALF_M), Quat::from_rotation_x(FRAC_PI_2)),
        turned("Left", left, Vec3::new(-HALF_M, HALF_M, 0.0), Quat::from_rotation_z(-FRAC_PI_2)),
        turned("Right", right, Vec3::new(HALF_M, HALF_M, 0.0), Quat::from_rotation_z(FRAC_PI_2)),
    ];
    of_walls.into_iter().for_each(|node| {
        place.scene.add_node(None, node);
    });
    let [small, tall] = [0.6, 1.2].map(|height| place.mesh(cube(Vec3::new(0.6, height, 0.6)), white));
    place.scene.add_node(None, turned("Box.Small", small, Vec3::new(0.36, 0.3, 0.34), Quat::from_rotation_y(-0.29)));
    place.scene.add_node(None, turned("Box.Tall", tall, Vec3::new(-0.34, 0.6, -0.3), Quat::from_rotation_y(0.3)));
    let panel = place.mesh(plane(1.0), lamp);
    let panel = Node {
        scale: Vec3::new(0.5, 1.0, 0.4),
        ..turned("Lamp", panel, Vec3::new(0.0, 1.99, 0.0), Quat::from_rotation_x(2.0 * FRAC_PI_2))
    };
    place.scene.add_node(None, panel);
    place.scene.exposure_stops = Some(0.0);
    place.scene.update_transforms();
    place.scene
}
