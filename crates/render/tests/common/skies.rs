//! Pictures of the environment, what is seen of them, and integrals over all of their texels, which know neither cube
//! maps, samples nor suns.

use super::plain_request;
use glam::{DVec3, Mat4, Quat, Vec3};
use manypass::{Environment, FrameRequest, Path, Renderer};
use manypass_scene::{Camera, EnvironmentMap, Node, Projection, Scene};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// A picture's radiance in all directions, for integrals over lobes: between its texels it goes evenly, as the renderer
/// has it.
pub struct Surroundings {
    size: (usize, usize),
    /// Radiance of texels, with what half floats cannot hold.
    texels: Vec<DVec3>,
    /// Squares of texels.
    blocks: Vec<Block>,
}

/// A square of texels.
struct Block {
    /// Its middle, and that of its light.
    directions: [DVec3; 2],
    solid_angle: f64,
    /// The mean.
    radiance: DVec3,
}

/// Texels along the sides of a block.
const BLOCK: usize = 8;

impl Surroundings {
    /// Of a map.
    pub fn of(map: &EnvironmentMap) -> Self {
        let size = (map.width as usize, map.height as usize);
        let mut texels: Vec<DVec3> =
            map.texels.iter().map(|[r, g, b, _]| DVec3::new(r.to_f64(), g.to_f64(), b.to_f64())).collect();
        for (index, beyond) in &map.peaks {
            texels[*index as usize] += beyond.as_dvec3();
        }
        let mut surroundings = Self { size, texels, blocks: Vec::new() };
        let (columns, rows) = (size.0.div_ceil(BLOCK), size.1.div_ceil(BLOCK));
        let block = |i: usize| {
            let (left, top) = (i % columns * BLOCK, i / columns * BLOCK);
            let (mut directions, mut all, mut sum) = ([DVec3::ZERO; 2], 0.0, DVec3::ZERO);
            for y in top..(top + BLOCK).min(size.1) {
                for x in left..(left + BLOCK).min(size.0) {
                    let solid_angle = surroundings.solid_angle(y);
                    let towards = surroundings.direction(x as f64 + 0.5, y as f64 + 0.5) * solid_angle;
                    let radiance = surroundings.texels[y * size.0 + x];
                    directions[0] += towards;
                    directions[1] += towards * radiance.element_sum();
                    all += solid_angle;
                    sum += radiance * solid_angle;
                }
            }
            let directions = directions.map(|sum| sum.normalize_or(directions[0].normalize()));
            Block { directions, solid_angle: all, radiance: sum / all }
        };
        surroundings.blocks = (0..columns * rows).map(block).collect();
        surroundings
    }

    /// The mean over all directions and colours.
    pub fn mean(&self) -> f64 {
        self.integral().element_sum() / 3.0 / (4.0 * PI)
    }

    /// The integral of radiance over all directions.
    pub fn integral(&self) -> DVec3 {
        self.blocks.iter().map(|block| block.radiance * block.solid_angle).sum()
    }

    /// Where it is brightest.
    pub fn brightest(&self) -> DVec3 {
        let luminance = |at: &usize| self.texels[*at].element_sum();
        let at = (0..self.texels.len()).max_by(|a, b| luminance(a).total_cmp(&luminance(b))).unwrap();
        self.direction((at % self.size.0) as f64 + 0.5, (at / self.size.0) as f64 + 0.5)
    }

    /// Of a place in texels.
    fn direction(&self, x: f64, y: f64) -> DVec3 {
        let (sin_around, cos_around) = (TAU * (x / self.size.0 as f64 - 0.5)).sin_cos();
        let (sin_down, cos_down) = (PI * y / self.size.1 as f64).sin_cos();
        DVec3::new(sin_down * cos_around, cos_down, sin_down * sin_around)
    }

    /// Of a texel in a row.
    fn solid_angle(&self, row: usize) -> f64 {
        let edge = |row: usize| (PI * row as f64 / self.size.1 as f64).cos();
        TAU / self.size.0 as f64 * (edge(row) - edge(row + 1))
    }

    /// Radiance at a place in texels, between the four nearest.
    fn between(&self, x: f64, y: f64) -> DVec3 {
        let (left, top) = ((x - 0.5).floor(), (y - 0.5).floor());
        let (right_share, lower_share) = (x - 0.5 - left, y - 0.5 - top);
        let (width, height) = (self.size.0 as i64, self.size.1 as i64);
        let at = |x: i64, y: i64| self.texels[(y.clamp(0, height - 1) * width + x.rem_euclid(width)) as usize];
        let (x, y) = (left as i64, top as i64);
        let row = |y: i64| at(x, y).lerp(at(x + 1, y), right_share);
        row(y).lerp(row(y + 1), lower_share)
    }

    /// The mean over the lobe of GGX about a direction, seen along it, weighted by n·l. Every part of the sphere is as
    /// small as the lobe asks for there: [`FINE`] of the length on which the lobe changes.
    pub fn reflection(&self, normal: DVec3, roughness: f64) -> DVec3 {
        const FINE: f64 = 0.15;
        let alpha = roughness * roughness;
        let a2 = alpha * alpha;
        let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
        // 1 - (n.h)² (1 - a²), with the square of half an angle's sine from the chord, which keeps its digits.
        let d = |to: DVec3| 0.25 * (to - normal).length_squared() * (1.0 - a2) + a2;
        let weight = |to: DVec3| to.dot(normal).max(0.0) / (d(to) * d(to));
        let mut add = |[to, to_light]: [DVec3; 2], solid_angle: f64, radiance: DVec3| {
            sum += radiance * (weight(to_light) * solid_angle);
            weights += weight(to) * solid_angle;
        };
        let texel = PI / self.size.1 as f64;
        let columns = self.size.0.div_ceil(BLOCK);
        for (i, block) in self.blocks.iter().enumerate() {
            let side = BLOCK as f64 * texel;
            let distance = ((block.directions[0] - normal).length() - 0.8 * side).max(0.0);
            if side < FINE * (alpha + 0.5 * distance) {
                add(block.directions, block.solid_angle, block.radiance);
                continue;
            }
            let (left, top) = (i % columns * BLOCK, i / columns * BLOCK);
            for y in top..(top + BLOCK).min(self.size.1) {
                for x in left..(left + BLOCK).min(self.size.0) {
                    let middle = self.direction(x as f64 + 0.5, y as f64 + 0.5);
                    let distance = ((middle - normal).length() - 0.8 * texel).max(0.0);
                    let steps = (texel / (FINE * (alpha + 0.5 * distance))).ceil().max(1.0);
                    let solid_angle = self.solid_angle(y);
                    if steps < 2.0 {
                        add([middle; 2], solid_angle, self.texels[y * self.size.0 + x]);
                        continue;
                    }
                    for part in 0..(steps * steps) as usize {
                        let place = |at: usize, first: usize| first as f64 + (at as f64 + 0.5) / steps;
                        let (x, y) = (place(part % steps as usize, x), place(part / steps as usize, y));
                        add([self.direction(x, y); 2], solid_angle / (steps * steps), self.between(x, y));
                    }
                }
            }
        }
        sum / weights
    }
}

/// Two soft windows and a bright floor.
pub fn room() -> EnvironmentMap {
    EnvironmentMap::from_fn("room", 512, 256, |to| {
        let window = |middle: Vec3| (40.0 * (to.dot(middle.normalize()) - 0.85)).clamp(0.0, 1.0);
        let floor = if to.y < 0.0 { Vec3::new(0.5, 0.4, 0.3) } else { Vec3::splat(0.2) };
        floor
            + Vec3::new(9.0, 8.0, 7.0) * window(Vec3::new(1.0, 0.5, 0.3))
            + Vec3::new(2.0, 3.0, 5.0) * window(Vec3::new(-0.4, 0.6, -1.0))
    })
}

/// A sky whose sun is a few texels wide and gives three quarters of all light.
pub fn sunny() -> EnvironmentMap {
    let sun = Vec3::new(0.5, 0.4, -0.7).normalize();
    EnvironmentMap::from_fn("sunny", 1024, 512, |to| {
        let sky = if to.y > 0.0 { Vec3::new(0.3, 0.5, 0.9) * (1.2 - to.y) } else { Vec3::new(0.2, 0.18, 0.1) };
        if to.dot(sun) > 0.99993 { Vec3::new(26_000.0, 24_000.0, 20_000.0) } else { sky }
    })
}

/// The pictures among the shared files.
pub const FILES: [&str; 2] = ["spruit_sunrise_1k.hdr", "lightroom_14b_approx_1k.hdr"];

/// Those made here, and those of the shared files.
pub fn maps() -> Vec<EnvironmentMap> {
    let mut maps = vec![room(), sunny()];
    if let Some(folder) = manypass_testkit::needs::assets("environments") {
        for name in FILES {
            maps.push(EnvironmentMap::decode(name, &std::fs::read(folder.join(name)).unwrap()).unwrap());
        }
    }
    maps
}

pub const SIDE: u32 = 40;

/// A scene with a camera that turns.
pub fn scene(map: EnvironmentMap, projection: Projection) -> Scene {
    let mut scene = Scene { environment: Some(Arc::new(map)), ..Scene::default() };
    scene.cameras.push(Camera { name: "camera".into(), projection, aspect: None });
    scene.add_node(None, Node { camera: Some(0), ..Node::default() });
    scene
}

pub fn radiance(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<DVec3> {
    renderer.render(scene, request).unwrap();
    let texels = renderer.read_radiance().unwrap();
    texels.chunks_exact(4).map(|p| DVec3::new(p[0].into(), p[1].into(), p[2].into())).collect()
}

pub fn request(scene: &Scene, turn: Quat, from_m: f32) -> FrameRequest {
    let mut request = plain_request(scene, (SIDE, SIDE));
    request.camera.world_from_view = Mat4::from_quat(turn) * Mat4::from_translation(Vec3::Z * from_m);
    request.settings.environment.source = Environment::File;
    request.settings.render.path = Path::Forward;
    request
}

const TURNS: [(f32, f32); 4] = [(0.3, 0.2), (2.0, -0.6), (3.7, 0.9), (5.1, -1.4)];

pub fn turns() -> impl Iterator<Item = Quat> {
    TURNS.into_iter().map(|(yaw, pitch)| Quat::from_rotation_y(yaw) * Quat::from_rotation_x(pitch))
}

/// The middle of a pixel, from −1 to 1.
pub fn place(at: usize) -> (f64, f64) {
    let side = SIDE as usize;
    let to = |i: usize| (2.0 * i as f64 + 1.0) / side as f64 - 1.0;
    (to(at % side), -to(at / side))
}
