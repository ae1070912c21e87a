//! A colonnade at night under more than a thousand coloured lights, whose meshes and lights are shared by many nodes.

use super::builder::Demo;
use super::shapes::{arc, cube, lathe};
use crate::{AlphaMode, Camera, Light, LightKind, Node, Projection, Scene};
use glam::{Quat, Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// Columns of a row, and metres between them.
const COLUMNS: u8 = 12;
const BAY_M: f32 = 3.0;
/// Half the distance between the rows of columns, half the width and the height of the hall, in metres.
const ROW_X_M: f32 = 3.6;
const WALL_X_M: f32 = 7.0;
const CEILING_Y_M: f32 = 7.2;
/// Where arches spring from capitals.
const SPRING_Y_M: f32 = 4.6;

/// Linear colours of the lights.
const PALETTE: [Vec3; 8] = [
    Vec3::new(1.0, 0.5, 0.14),
    Vec3::new(1.0, 0.22, 0.1),
    Vec3::new(1.0, 0.12, 0.35),
    Vec3::new(0.75, 0.15, 1.0),
    Vec3::new(0.3, 0.25, 1.0),
    Vec3::new(0.1, 0.5, 1.0),
    Vec3::new(0.08, 0.9, 0.8),
    Vec3::new(0.35, 1.0, 0.25),
];

/// A long hall at night: two rows of columns with arches, a glossy floor, a coffered ceiling, metal sculptures,
/// coloured glass, lanterns, and more than 1,000 point and spot lights. Lit surfaces have a radiance of about 0.05 to
/// 1.5, for an exposure of 0.
pub fn hall() -> Scene {
    let mut hall = Hall::default();
    hall.shell();
    hall.columns_and_arches();
    hall.sculptures();
    hall.lanterns_and_glass();
    let eye = Vec3::new(-1.3, 1.75, 19.5);
    let rotation = Quat::from_rotation_arc(Vec3::NEG_Z, Vec3::new(0.055, 0.035, -1.0).normalize());
    hall.demo.scene.cameras.push(Camera {
        name: "nave".into(),
        projection: Projection::Perspective { fov_y_rad: 0.9, near_m: 0.1, far_m: Some(200.0) },
        aspect: None,
    });
    hall.demo.scene.add_node(None, Node { translation: eye, rotation, camera: Some(0), ..Node::default() });
    hall.demo.scene.exposure_stops = Some(0.0);
    hall.demo.scene.update_transforms();
    hall.demo.scene
}

#[derive(Default)]
struct Hall {
    demo: Demo,
}

impl Hall {
    fn material(&mut self, color: [f32; 3], metallic: f32, roughness: f32) -> usize {
        self.demo.material("", color, metallic, roughness)
    }

    /// A light for many nodes.
    fn light(&mut self, color: Vec3, intensity_cd: f32, range_m: f32, kind: LightKind) -> usize {
        let range_m = Some(range_m);
        self.demo.scene.lights.push(Light {
            color_linear: color,
            intensity: intensity_cd,
            range_m,
            kind,
            ..Light::default()
        });
        self.demo.scene.lights.len() - 1
    }

    fn shine(&mut self, light: usize, translation: Vec3, direction: Vec3) {
        let rotation = Quat::from_rotation_arc(Vec3::NEG_Z, direction.normalize());
        self.demo.scene.add_node(None, Node { translation, rotation, light: Some(light), ..Node::default() });
    }

    /// A tiny glowing ball of each colour.
    fn bulbs(&mut self) -> [usize; 8] {
        PALETTE.map(|color| {
            let material = self.material([0.0; 3], 0.0, 1.0);
            self.demo.scene.materials[material].emissive_factor = 2.0 * color + 0.2;
            self.demo.mesh(lathe(&arc(1.0, 6), 10, true, TAU), material)
        })
    }

    fn shell(&mut self) {
        let dark = self.material([0.02, 0.022, 0.028], 0.0, 0.18);
        let light = self.material([0.07, 0.065, 0.06], 0.0, 0.24);
        let stone = self.material([0.45, 0.42, 0.4], 0.0, 0.75);
        let beam = self.material([0.3, 0.2, 0.13], 0.0, 0.55);
        let tiles = [self.demo.mesh(cube(), dark), self.demo.mesh(cube(), light)];
        for i in 0..14_u8 {
            for j in 0..42_u8 {
                let place = Vec3::new(f32::from(i) - 6.5, -0.05, f32::from(j) - 20.5);
                self.demo.put(tiles[usize::from((i + j) % 2)], place, Vec3::new(1.0, 0.1, 1.0));
            }
        }
        let (wall, beam) = (self.demo.mesh(cube(), stone), self.demo.mesh(cube(), beam));
        for side in [-1.0, 1.0] {
            self.demo.put(wall, Vec3::new(side * (WALL_X_M + 0.1), 3.6, 0.0), Vec3::new(0.2, 7.4, 42.0));
            self.demo.put(wall, Vec3::new(0.0, 3.6, side * 21.1), Vec3::new(14.4, 7.4, 0.2));
        }
        self.demo.put(wall, Vec3::new(0.0, CEILING_Y_M + 0.1, 0.0), Vec3::new(14.4, 0.2, 42.0));
        for i in 0..8_u8 {
            let place = Vec3::new(2.0 * f32::from(i) - 7.0, CEILING_Y_M - 0.2, 0.0);
            self.demo.put(beam, place, Vec3::new(0.25, 0.4, 42.0));
        }
        for j in 0..22_u8 {
            let place = Vec3::new(0.0, CEILING_Y_M - 0.25, 2.0 * f32::from(j) - 21.0);
            self.demo.put(beam, place, Vec3::new(14.0, 0.5, 0.25));
        }
        let coffers = [3, 4, 5].map(|color: usize| self.light(PALETTE[color], 0.25, 2.0, LightKind::Point));
        let spot = LightKind::Spot { inner_cone_rad: 0.3, outer_cone_rad: 0.7 };
        let washers = PALETTE.map(|color| self.light(color, 2.0, 4.0, spot));
        for j in 0..21_u8 {
            let z = 2.0 * f32::from(j) - 20.0;
            for i in 0..7_u8 {
                let light = coffers[usize::from((i + j) % 3)];
                self.shine(light, Vec3::new(2.0 * f32::from(i) - 6.0, CEILING_Y_M - 0.45, z), Vec3::NEG_Y);
            }
            for side in [-1.0, 1.0] {
                let place = Vec3::new(side * (WALL_X_M - 0.45), 0.1, z);
                self.shine(washers[usize::from(j / 3 + 4) % 8], place, Vec3::new(0.2 * side, 1.0, 0.0));
            }
        }
    }

    fn columns_and_arches(&mut self) {
        let marble = self.material([0.62, 0.58, 0.53], 0.0, 0.4);
        let profile = [
            (0.0, 0.0),
            (0.55, 0.0),
            (0.55, 0.25),
            (0.45, 0.32),
            (0.48, 0.42),
            (0.36, 0.5),
            (0.3, 4.1),
            (0.36, 4.15),
            (0.34, 4.22),
            (0.52, 4.42),
            (0.52, SPRING_Y_M),
            (0.0, SPRING_Y_M),
        ];
        let column = self.demo.mesh(lathe(&profile.map(Vec2::from), 40, false, TAU), marble);
        let section = [(1.15, -0.25), (1.5, -0.25), (1.5, 0.25), (1.15, 0.25), (1.15, -0.25)];
        let arch = self.demo.mesh(lathe(&section.map(Vec2::from), 32, false, PI), marble);
        let bulbs = self.bulbs();
        let string = PALETTE.map(|color| self.light(color, 0.07, 1.5, LightKind::Point));
        let floor = PALETTE.map(|color| self.light(color, 0.15, 1.6, LightKind::Point));
        let kind = LightKind::Spot { inner_cone_rad: 0.15, outer_cone_rad: 0.5 };
        let up = PALETTE.map(|color| self.light(color, 2.0, 4.0, kind));
        for i in 0..COLUMNS {
            for (side, shift) in [(-1.0, 0), (1.0, 4)] {
                let foot = Vec3::new(side * ROW_X_M, 0.0, BAY_M * (f32::from(i) - 5.5));
                let hue = (usize::from(i) + shift) % 8;
                self.demo.put(column, foot, Vec3::ONE);
                for k in 0..20_u8 {
                    let (sin, cos) = (f32::from(k) * TAU / 7.0).sin_cos();
                    let place = foot + Vec3::new(0.5 * cos, 0.7 + 0.17 * f32::from(k), 0.5 * sin);
                    self.shine(string[hue], place, Vec3::NEG_Y);
                    self.demo.put(bulbs[hue], place, Vec3::splat(0.02));
                }
                for k in 0..4_u8 {
                    let (sin, cos) = (f32::from(k) * TAU / 4.0 + 0.8).sin_cos();
                    let outward = Vec3::new(cos, 0.0, sin);
                    self.shine(up[(hue + 1) % 8], foot + 0.7 * outward + 0.05 * Vec3::Y, Vec3::Y - 0.12 * outward);
                }
                for k in 0..6_u8 {
                    let place = Vec3::new(side * 2.7, 0.12, foot.z + 0.5 * f32::from(k));
                    self.shine(floor[(hue + 2) % 8], place, Vec3::NEG_Y);
                    self.demo.put(bulbs[(hue + 2) % 8], place, Vec3::splat(0.025));
                }
                if i + 1 == COLUMNS {
                    continue;
                }
                // Turns about (1, 1, 1): the axis of the lathe, Y, becomes X, and its Z, where half a turn bulges, Y.
                let rotation = Quat::from_axis_angle(Vec3::ONE.normalize(), -TAU / 3.0);
                let translation = foot + Vec3::new(0.0, SPRING_Y_M, 0.5 * BAY_M);
                self.demo.scene.add_node(None, Node { mesh: Some(arch), translation, rotation, ..Node::default() });
                for k in 0..10_u8 {
                    let (sin, cos) = ((f32::from(k) + 0.5) * PI / 10.0).sin_cos();
                    let place = translation + Vec3::new(0.0, sin, cos) * 0.95;
                    self.shine(string[(hue + 7) % 8], place, Vec3::NEG_Y);
                    self.demo.put(bulbs[(hue + 7) % 8], place, Vec3::splat(0.02));
                }
            }
        }
    }

    fn sculptures(&mut self) {
        let stone = self.material([0.2, 0.2, 0.22], 0.0, 0.35);
        let pedestal = self.demo.mesh(cube(), stone);
        let metals = [([1.0, 0.77, 0.34], 0.22), ([0.95, 0.64, 0.54], 0.3), ([0.56, 0.57, 0.58], 0.18)];
        let metals = metals.map(|(color, roughness)| self.material(color, 1.0, roughness));
        let ring: Vec<_> = (0..=24_u8).map(|i| f32::from(i) * TAU / 24.0).collect();
        let ring: Vec<_> = ring.iter().map(|a| Vec2::new(0.38 + 0.14 * a.cos(), 0.14 * a.sin())).collect();
        let pawn = [
            (0.0, -0.5),
            (0.35, -0.5),
            (0.33, -0.4),
            (0.15, -0.25),
            (0.1, 0.1),
            (0.2, 0.15),
            (0.12, 0.2),
            (0.21, 0.35),
            (0.15, 0.5),
            (0.0, 0.56),
        ];
        let shapes = [
            lathe(&arc(0.48, 32), 64, true, TAU),
            lathe(&ring, 64, true, TAU),
            lathe(&pawn.map(Vec2::from), 48, true, TAU),
        ];
        let kind = LightKind::Spot { inner_cone_rad: 0.2, outer_cone_rad: 0.6 };
        let spots = PALETTE.map(|color| self.light(color, 2.5, 3.5, kind));
        for i in 0..10_u8 {
            let index = usize::from(i);
            let side = if i % 2 == 0 { 1.0 } else { -1.0 };
            let foot = Vec3::new(side * 1.9, 0.0, 13.5 - 3.0 * f32::from(i));
            self.demo.put(pedestal, foot + 0.45 * Vec3::Y, Vec3::new(0.8, 0.9, 0.8));
            let mesh = self.demo.mesh(shapes[index % 3].clone(), metals[(index + index / 3) % 3]);
            let rotation = if index % 3 == 1 { Quat::from_rotation_x(1.3) } else { Quat::IDENTITY };
            let translation = foot + 1.42 * Vec3::Y;
            self.demo.scene.add_node(None, Node { mesh: Some(mesh), translation, rotation, ..Node::default() });
            for k in 0..3_u8 {
                let (sin, cos) = (f32::from(k) * TAU / 3.0 + 0.5).sin_cos();
                let offset = Vec3::new(1.1 * cos, 1.0, 1.1 * sin);
                self.shine(spots[(index + 3 * usize::from(k)) % 8], translation + offset, -offset);
            }
        }
    }

    fn lanterns_and_glass(&mut self) {
        let glow = self.material([0.0; 3], 0.0, 1.0);
        self.demo.scene.materials[glow].emissive_factor = Vec3::new(3.0, 1.7, 0.7);
        let lantern = self.demo.mesh(lathe(&arc(0.13, 16), 24, true, TAU), glow);
        let light = self.light(Vec3::new(1.0, 0.62, 0.3), 4.0, 4.0, LightKind::Point);
        let glass = [0, 3, 6].map(|color: usize| {
            let material = self.material(PALETTE[color].to_array(), 0.0, 0.1);
            self.demo.scene.materials[material].alpha_mode = AlphaMode::Blend;
            self.demo.scene.materials[material].base_color_factor.w = 0.35;
            self.demo.mesh(cube(), material)
        });
        for i in 0..COLUMNS - 1 {
            let z = BAY_M * (f32::from(i) - 5.0);
            for side in [-1.0, 1.0] {
                let place = Vec3::new(side * 1.2, 3.6, z);
                self.demo.put(lantern, place, Vec3::ONE);
                self.shine(light, place, Vec3::NEG_Y);
            }
            if i % 3 == 1 {
                for (side, pane) in [(-1.0, i / 3), (1.0, i / 3 + 1)] {
                    let place = Vec3::new(side * ROW_X_M, 1.5, z);
                    self.demo.put(glass[usize::from(pane) % 3], place, Vec3::new(0.04, 2.2, 1.6));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hall_has_more_than_a_thousand_lights_and_faces_outwards() {
        let scene = hall();
        let lights = scene.nodes.iter().filter(|node| node.light.is_some()).count();
        assert!(lights > 1000, "{lights} lights");
        for primitive in scene.meshes.iter().flat_map(|mesh| &mesh.primitives) {
            for triangle in primitive.indices.chunks_exact(3) {
                let [a, b, c] = [0, 1, 2].map(|i| Vec3::from(primitive.positions[triangle[i] as usize]));
                let cross = (b - a).cross(c - a);
                let normals: Vec3 = triangle.iter().map(|&i| Vec3::from(primitive.normals[i as usize])).sum();
                assert!(normals.is_finite() && (cross.length() < 1e-6 || cross.dot(normals) > 0.0));
            }
        }
    }
}
