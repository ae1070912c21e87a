//! Sample models that carry their own verdict: check marks where a renderer is right and crosses where it is not, and
//! shapes that have to look like others beside them. Parallel rays and light from everywhere make equal things equal
//! wherever they stand.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{ids, renderer, sample_models};
use glam::{Mat4, Quat, Vec2, Vec3};
use manypass::{Aov, Background, Environment, FrameRequest, Renderer, Tonemap, View};
use manypass_scene::{NodeId, Projection, Scene, gltf_file};
use std::f32::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

const SIDE_PX: usize = 512;
/// Smaller areas are edges of letters.
const AREA_MIN_PX: usize = 15;

type Rgb = [u8; 3];

/// The model `name`; none, with a message, where the sample models are not there.
fn load(name: &str) -> Option<Scene> {
    let folder = sample_models()?.join("Models").join(name).join("glTF-Binary");
    Some(gltf_file::load_path(&folder.join(format!("{name}.glb"))).unwrap().scene)
}

/// A model seen with parallel rays.
struct Shot {
    pixels: Vec<Rgb>,
    /// Nodes, counted from 1; 0 is the background.
    nodes: Vec<u32>,
    center: Vec3,
    height_m: f32,
}

/// Four samples a pixel of what is seen along −Z turned by `rotation`.
fn shoot(renderer: &mut Renderer, scene: &Scene, rotation: Quat) -> Shot {
    let bounds = scene.posed_bounds_world();
    let (center, radius_m) = (bounds.center(), bounds.radius_m());
    let reach = bounds.corners().map(|corner| (rotation.inverse() * (corner - center)).abs());
    let height_m = 2.1 * reach.iter().fold(0.0f32, |height, corner| height.max(corner.x).max(corner.y));
    let eye = center + rotation * Vec3::Z * 2.0 * radius_m;
    let projection = Projection::Orthographic { height_m, near_m: 0.5 * radius_m, far_m: 4.0 * radius_m };
    let view = View { world_from_view: Mat4::from_rotation_translation(rotation, eye), projection };
    let mut request = FrameRequest::new(SIDE_PX as u32, SIDE_PX as u32, view);
    request.settings.environment.source = Environment::Studio;
    request.settings.effects.enabled = false;
    request.settings.background.source = Background::Color([0.0; 3]);
    request.settings.tone_map.curve = Tonemap::None;
    request.settings.tone_map.dither = 0.0;
    request.want_aovs = vec![Aov::ObjectId];
    request.sample_count = 4;
    renderer.load(scene).unwrap();
    for sample_index in 0..request.sample_count {
        request.sample_index = sample_index;
        renderer.render(scene, &request).unwrap();
    }
    let pixels = renderer.read_display().unwrap().chunks(4).map(|p| [p[0], p[1], p[2]]).collect();
    Shot { pixels, nodes: ids(renderer.read_aov(Aov::ObjectId).unwrap()), center, height_m }
}

impl Shot {
    /// From the front: colours around a point in world space, row by row, of a square that ends `half_m` from it. They
    /// are interpolated, because the point need not be the middle of a pixel.
    fn patch(&self, at: Vec2, half_m: f32) -> Vec<Rgb> {
        let scale = SIDE_PX as f32 / self.height_m;
        let middle = (SIDE_PX as f32 - 1.0) / 2.0;
        let (x, y) = (middle + (at.x - self.center.x) * scale, middle - (at.y - self.center.y) * scale);
        let half = (half_m * scale) as i32;
        let offsets = (-half..=half).flat_map(|row| (-half..=half).map(move |column| (column as f32, row as f32)));
        offsets.map(|(column, row)| self.interpolated(x + column, y + row)).collect()
    }

    /// The colour between the middles of four pixels, which are at whole numbers.
    fn interpolated(&self, x: f32, y: f32) -> Rgb {
        let (left, top) = (x.floor() as usize, y.floor() as usize);
        let (u, v) = (x.fract(), y.fract());
        let corners = [(0, 0, (1.0 - u) * (1.0 - v)), (1, 0, u * (1.0 - v)), (0, 1, (1.0 - u) * v), (1, 1, u * v)];
        [0, 1, 2].map(|channel| {
            let of = |(dx, dy, share): (usize, usize, f32)| {
                share * f32::from(self.pixels[(top + dy) * SIDE_PX + left + dx][channel])
            };
            corners.map(of).iter().sum::<f32>().round() as u8
        })
    }

    /// The colour of the middle one of a node's pixels, in reading order of a row in the middle.
    fn middle_of(&self, node: usize) -> Rgb {
        let shown: Vec<usize> = (0..self.nodes.len()).filter(|at| self.nodes[*at] == node as u32 + 1).collect();
        assert!(shown.len() > 500, "node {node} covers {} pixels", shown.len());
        let row = shown[shown.len() / 2] / SIDE_PX;
        let in_row: Vec<usize> = shown.into_iter().filter(|at| at / SIDE_PX == row).collect();
        self.pixels[in_row[in_row.len() / 2]]
    }

    /// The mean colour of a node's pixels.
    fn mean_of(&self, node: usize) -> [f64; 3] {
        let shown =
            self.pixels.iter().zip(&self.nodes).filter(|(_, id)| **id == node as u32 + 1).map(|(pixel, _)| pixel);
        let count = shown.clone().count();
        assert!(count > 500, "node {node} covers {count} pixels");
        [0, 1, 2].map(|channel| shown.clone().map(|pixel| f64::from(pixel[channel])).sum::<f64>() / count as f64)
    }

    /// Sizes of the connected areas of pixels that `is_in`, of at least [`AREA_MIN_PX`], in reading order.
    fn areas(&self, is_in: impl Fn(Rgb) -> bool) -> Vec<usize> {
        let mut open: Vec<bool> = self.pixels.iter().map(|pixel| is_in(*pixel)).collect();
        let mut areas = Vec::new();
        for start in 0..open.len() {
            let (mut size, mut stack) = (0, vec![start]);
            while let Some(at) = stack.pop() {
                if !std::mem::take(&mut open[at]) {
                    continue;
                }
                size += 1;
                let x = at % SIDE_PX;
                let beside = [
                    (x > 0).then(|| at - 1),
                    (x + 1 < SIDE_PX).then_some(at + 1),
                    at.checked_sub(SIDE_PX),
                    (at + SIDE_PX < open.len()).then_some(at + SIDE_PX),
                ];
                stack.extend(beside.into_iter().flatten());
            }
            if size >= AREA_MIN_PX {
                areas.push(size);
            }
        }
        areas
    }

    fn count(&self, is_in: impl Fn(Rgb) -> bool) -> usize {
        self.pixels.iter().filter(|pixel| is_in(**pixel)).count()
    }
}

fn is_green([r, g, b]: Rgb) -> bool {
    g > 80 && 3 * u32::from(r.max(b)) < 2 * u32::from(g)
}

fn is_red([r, g, b]: Rgb) -> bool {
    r > 80 && 3 * u32::from(g.max(b)) < 2 * u32::from(r)
}

/// The mean absolute difference of two lists of pixels in levels.
fn mean_difference(first: &[Rgb], second: &[Rgb]) -> f64 {
    assert_eq!(first.len(), second.len());
    let sum: u64 = first.iter().zip(second).flat_map(|(a, b)| (0..3).map(|c| u64::from(a[c].abs_diff(b[c])))).sum();
    sum as f64 / (3 * first.len()) as f64
}

#[test]
fn sides_and_wrapping_pass() {
    let Some(scene) = load("TextureSettingsTest") else { return };
    let mut renderer = renderer();
    let shot = shoot(&mut renderer, &scene, Quat::IDENTITY);
    let areas = shot.areas(is_green);
    println!("TextureSettingsTest: green {areas:?}, red {}", shot.count(is_red));
    assert_eq!(shot.count(is_red), 0, "crosses");
    assert_in_pairs(&areas, 16);
    // The test can fail: clamping everywhere shows a cross or a bar, and so do back faces.
    let mut clamped = scene.clone();
    clamped.textures.iter_mut().for_each(|texture| texture.sampler.wrap_u = manypass_scene::Wrap::ClampToEdge);
    assert!(shoot(&mut renderer, &clamped, Quat::IDENTITY).areas(is_green) != areas);
    let mut double_sided = scene.clone();
    double_sided.materials.iter_mut().for_each(|material| material.double_sided = true);
    assert!(shoot(&mut renderer, &double_sided, Quat::IDENTITY).count(is_red) > 30);
}

/// Every mark is beside a sample of its own size.
fn assert_in_pairs(areas: &[usize], count: usize) {
    assert_eq!(areas.len(), count, "{areas:?}");
    let mut sorted = areas.to_vec();
    sorted.sort_unstable();
    for pair in sorted.chunks(2) {
        assert!(pair[1] as f64 <= 1.08 * pair[0] as f64, "{areas:?}");
    }
}

#[test]
fn negative_scale_passes() {
    let Some(scene) = load("NegativeScaleTest") else { return };
    let shot = shoot(&mut renderer(), &scene, Quat::IDENTITY);
    println!("NegativeScaleTest: green {:?}, red {}", shot.areas(is_green), shot.count(is_red));
    assert_eq!(shot.count(is_red), 0, "crosses");
    assert_in_pairs(&shot.areas(is_green), 6);
    // The spheres of scale 1 and −1, by their nodes: white, dark blue, metal.
    for (plain, mirrored) in [(5, 6), (11, 12), (8, 9)] {
        let (plain, mirrored) = (shot.mean_of(plain), shot.mean_of(mirrored));
        let difference = (0..3).map(|c| (plain[c] - mirrored[c]).abs()).fold(0.0, f64::max);
        assert!(difference < 1.5, "{plain:?} {mirrored:?}");
    }
}

#[test]
fn vertex_colors_pass() {
    let Some(scene) = load("VertexColorTest") else { return };
    let mut renderer = renderer();
    let shot = shoot(&mut renderer, &scene, Quat::IDENTITY);
    // Crosses of two channels show where vertex colours are passed over.
    let is_cross = |[r, g, b]: Rgb| {
        let high = [r, g, b].into_iter().filter(|level| *level > 90).count();
        high == 2 && r.min(g).min(b) < 40
    };
    println!(
        "VertexColorTest: red {:?}, green {:?}, crosses {}",
        shot.areas(is_red),
        shot.areas(is_green),
        shot.count(is_cross)
    );
    assert_in_pairs(&shot.areas(is_red), 2);
    assert_in_pairs(&shot.areas(is_green), 2);
    assert_eq!(shot.count(is_cross), 0);
    let mut colorless = scene.clone();
    colorless
        .meshes
        .iter_mut()
        .flat_map(|mesh| &mut Arc::make_mut(mesh).primitives)
        .for_each(|primitive| primitive.colors.clear());
    assert!(shoot(&mut renderer, &colorless, Quat::IDENTITY).count(is_cross) > 100, "the test can fail");
}

#[test]
fn textures_are_decoded_like_factors() {
    let mut renderer = renderer();
    let Some(scene) = load("TextureEncodingTest") else { return };
    let shot = shoot(&mut renderer, &scene, Quat::IDENTITY);
    for row in [1, 5, 9] {
        let colors = [0, 1, 2, 3].map(|column| shot.mean_of(row + column));
        println!("TextureEncodingTest: {colors:.1?}");
        for color in &colors[1..] {
            // A texture has eight bits: half a step of a dark base colour or of roughness.
            assert!((0..3).all(|c| (color[c] - colors[0][c]).abs() < 2.0), "row {row}: {colors:?}");
        }
    }
    let Some(scene) = load("TextureLinearInterpolationTest") else { return };
    let shot = shoot(&mut renderer, &scene, Quat::IDENTITY);
    let (factor, texture) = (shot.mean_of(0), shot.mean_of(1));
    println!("TextureLinearInterpolationTest: {factor:.1?} {texture:.1?}");
    // Green of 0.5 is 188; interpolated before decoding it is 128, or 0.22 of light.
    assert!((factor[1] - 188.0).abs() < 2.0 && (texture[1] - factor[1]).abs() < 3.0, "{factor:?} {texture:?}");
}

#[test]
fn alpha_modes_pass() {
    let Some(scene) = load("AlphaBlendModeTest") else { return };
    let mut renderer = renderer();
    let rotation = Quat::from_rotation_x(-0.6);
    let shot = shoot(&mut renderer, &scene, rotation);
    // The marks are thin, so that no pixel is of their colour alone.
    let is_mark = |[r, g, b]: Rgb| g > 90 && u32::from(r.max(b)) + 40 < u32::from(g);
    let is_cross = |[r, g, b]: Rgb| r > 90 && u32::from(g.max(b)) + 40 < u32::from(r);
    println!("AlphaBlendModeTest: marks {:?}, red {}", shot.areas(is_mark), shot.count(is_cross));
    assert_eq!(shot.count(is_cross), 0, "crosses");
    assert_eq!(shot.areas(is_mark).len(), 5, "two check marks, and an arrow at each of three cutoffs");
    // The test can fail: every box opaque, or every box blended.
    for alpha_mode in [manypass_scene::AlphaMode::Opaque, manypass_scene::AlphaMode::Blend] {
        let mut wrong = scene.clone();
        wrong.materials.iter_mut().for_each(|material| material.alpha_mode = alpha_mode);
        let wrong = shoot(&mut renderer, &wrong, rotation);
        println!("{alpha_mode:?}: marks {:?}, red {}", wrong.areas(is_mark), wrong.count(is_cross));
        assert!(wrong.areas(is_mark).len() != 5 || wrong.count(is_cross) > 0, "{alpha_mode:?}");
    }
}

#[test]
fn texture_coordinates_start_at_the_top_left() {
    let Some(scene) = load("TextureCoordinateTest") else { return };
    let shot = shoot(&mut renderer(), &scene, Quat::IDENTITY);
    let bounds = scene.posed_bounds_world();
    let half = 0.5 * (bounds.max - bounds.min);
    let is_dark = |pixel: &Rgb| pixel.iter().all(|level| *level < 70);
    // Yellow, orange, blue and green quarters; each has a chequered edge at the corner of the picture that it is named
    // for.
    let quarters: [(&str, f32, f32, [bool; 3]); 4] = [
        ("top left", -1.0, 1.0, [true, true, false]),
        ("top right", 1.0, 1.0, [true, false, false]),
        ("bottom left", -1.0, -1.0, [false, false, true]),
        ("bottom right", 1.0, -1.0, [false, true, false]),
    ];
    for (name, right, up, bright) in quarters {
        let at = |share: f32| shot.center.truncate() + Vec2::new(right * half.x, up * half.y) * share;
        let plain = shot.patch(at(0.35), 0.03 * half.x);
        assert!(plain.iter().all(|pixel| (0..3).all(|c| (pixel[c] > 110) == bright[c])), "{name}: {:?}", plain[0]);
        let outer = shot.patch(at(0.9), 0.06 * half.x).iter().filter(|pixel| is_dark(pixel)).count();
        assert!(outer > 5 && !plain.iter().any(is_dark), "{name}: {outer} dark pixels at the corner");
    }
}

#[test]
fn unlit_surfaces_show_their_base_color() {
    let Some(scene) = load("UnlitTest") else { return };
    let shot = shoot(&mut renderer(), &scene, Quat::IDENTITY);
    let encode = |x: f32| 255.0 * if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    let mut checked = 0;
    for (index, node) in scene.nodes.iter().enumerate() {
        let Some(material) = node.mesh.and_then(|mesh| scene.meshes[mesh].primitives[0].material) else { continue };
        let expected = scene.materials[material].base_color_factor.truncate().to_array().map(encode);
        let inside = shot.middle_of(index);
        assert!((0..3).all(|c| (f32::from(inside[c]) - expected[c]).abs() <= 1.0), "{inside:?}, expected {expected:?}");
        checked += 1;
    }
    assert_eq!(checked, 2);
}

/// How far off its target an arrow points, as the sine of an angle seen from in front of its face: the tip of the arrow
/// is the end of its long axis, so that arrow and target lie on one line.
fn misalignment(shot: &Shot, arrow: usize, target: usize) -> f64 {
    let points = |node: usize| -> Vec<glam::DVec2> {
        let shown = shot.nodes.iter().enumerate().filter(|(_, id)| **id == node as u32 + 1);
        shown.map(|(at, _)| glam::DVec2::new((at % SIDE_PX) as f64, (at / SIDE_PX) as f64)).collect()
    };
    let (arrow, target) = (points(arrow), points(target));
    assert!(arrow.len() > 100 && target.len() > 20, "{} and {} pixels", arrow.len(), target.len());
    let mean = |points: &[glam::DVec2]| points.iter().sum::<glam::DVec2>() / points.len() as f64;
    let (center, towards) = (mean(&arrow), mean(&target));
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for offset in arrow.iter().map(|point| *point - center) {
        (xx, xy, yy) = (xx + offset.x * offset.x, xy + offset.x * offset.y, yy + offset.y * offset.y);
    }
    let axis = glam::DVec2::from_angle(0.5 * f64::atan2(2.0 * xy, xx - yy));
    axis.perp_dot((towards - center).normalize()).abs()
}

#[test]
fn arrows_point_at_their_targets() {
    let Some(scene) = load("OrientationTest") else { return };
    let mut renderer = renderer();
    let node = |scene: &Scene, name: &str| scene.nodes.iter().position(|node| node.name == name).unwrap();
    let faces = [
        ("X1", Quat::from_rotation_y(FRAC_PI_2)),
        ("X2", Quat::from_rotation_y(-FRAC_PI_2)),
        ("Y1", Quat::from_rotation_x(-FRAC_PI_2)),
        ("Y2", Quat::from_rotation_x(FRAC_PI_2)),
        ("Z1", Quat::IDENTITY),
        ("Z2", Quat::from_rotation_y(PI)),
    ];
    for (name, rotation) in faces {
        let (arrow, target) = (node(&scene, &format!("Arrow{name}")), node(&scene, &format!("Target{name}")));
        let off = misalignment(&shoot(&mut renderer, &scene, rotation), arrow, target);
        println!("OrientationTest {name}: off by {off:.4}");
        assert!(off < 0.1, "{name}: off by {off}");
        // The test can fail: an arrow turned by 30° about the axis of its face.
        let mut turned = scene.clone();
        let id = NodeId(arrow as u32);
        let turn = Mat4::from_axis_angle(rotation * Vec3::Z, 0.5);
        turned.node_mut(id).matrix = Some({
            let local = turned.node(id).local_matrix();
            let place = Mat4::from_translation(local.w_axis.truncate());
            place * turn * place.inverse() * local
        });
        turned.update_transforms();
        let off = misalignment(&shoot(&mut renderer, &turned, rotation), arrow, target);
        assert!(off > 0.15, "{name}: a turned arrow is off by {off} only");
    }
}

/// Compares balls made of triangles with those of a normal map: their x, and the x of the others.
fn compare_balls(name: &str, columns: &[(f32, &[f32])]) {
    let Some(scene) = load(name) else { return };
    let shot = shoot(&mut renderer(), &scene, Quat::IDENTITY);
    // The balls have a radius of 0.1 m. Where they are steepest, a normal map of the sphere's texels has no exact
    // normals.
    let half_m = 0.065;
    let (mut worst, mut least_wrong) = (0.0f64, f64::INFINITY);
    for (geometry, others) in columns {
        for y in [-0.8, -0.4, 0.0, 0.4, 0.8] {
            let ball = shot.patch(Vec2::new(*geometry, y), half_m);
            let side = ball.len().isqrt();
            let upside_down: Vec<Rgb> = ball.chunks(side).rev().flatten().copied().collect();
            let mirrored: Vec<Rgb> = ball.chunks(side).flat_map(|row| row.iter().rev().copied()).collect();
            for x in *others {
                let other = shot.patch(Vec2::new(*x, y), half_m);
                let difference = mean_difference(&ball, &other);
                worst = worst.max(difference);
                for wrong in [&upside_down, &mirrored] {
                    least_wrong = least_wrong.min(mean_difference(&ball, wrong));
                }
                assert!(difference < 5.0, "{name}: the ball at {x}, {y} is off by {difference}");
            }
        }
    }
    println!("{name}: off by at most {worst:.2} levels on average; a ball turned round, by {least_wrong:.2} or more");
    assert!(least_wrong > 7.0, "{name}: a ball turned round is off by {least_wrong} only");
}

#[test]
fn normal_maps_look_like_geometry_with_given_tangents() {
    compare_balls("NormalTangentMirrorTest", &[(-1.275, &[-0.955, -0.629, -0.291]), (0.3, &[0.62, 0.941, 1.264])]);
}

#[test]
fn normal_maps_look_like_geometry_with_generated_tangents() {
    compare_balls("NormalTangentTest", &[(-0.96, &[-0.64]), (-0.16, &[0.16]), (0.64, &[0.96])]);
}
