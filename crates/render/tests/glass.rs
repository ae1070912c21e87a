//! Glass that is seen through glass, and bodies that bend light where it enters and where it leaves. Right values are
//! closed forms: where rays through a ball, a slab and a sheet meet a card whose colours tell places.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{plain_request, renderer};
use glam::{Quat, Vec3, Vec4};
use manypass::gpu::Floor;
use manypass::{Background, Exposure, FrameRequest, Gpu, Path, PixelSamples, Renderer};
use manypass_scene::material::{Specular, TexturedFactor, Volume};
use manypass_scene::{Aabb, Material, Node, Primitive, Projection, Scene, ShadingModel, primitives};
use manypass_testkit::build::{SceneBuilder, at};
use std::f32::consts::FRAC_PI_2;

const FOV_Y_RAD: f32 = 0.7;
const EYE: Vec3 = Vec3::new(0.0, 0.0, 5.0);
const IOR: f32 = 1.5;

/// The card is as wide and high, and so far behind the middle.
const CARD_M: f32 = 5.0;
const CARD_Z_M: f32 = -1.5;

/// Glass that reflects nothing, so that its colour alone is what comes through.
fn glass(color: [f32; 3], thickness_m: f32) -> Material {
    Material {
        base_color_factor: Vec3::from(color).extend(1.0),
        metallic_factor: 0.0,
        roughness_factor: 0.0,
        specular: Some(Specular { weight: TexturedFactor::new(0.0), ..Specular::default() }),
        transmission: Some(TexturedFactor::new(1.0)),
        volume: (thickness_m > 0.0)
            .then(|| Volume { thickness: TexturedFactor::new(thickness_m), ..Volume::default() }),
        ..Material::default()
    }
}

const CLEAR: [f32; 3] = [1.0; 3];
const RED: [f32; 3] = [0.9, 0.2, 0.1];

fn view() -> SceneBuilder {
    let projection = Projection::Perspective { fov_y_rad: FOV_Y_RAD, near_m: 0.1, far_m: None };
    SceneBuilder::new(EYE, Vec3::ZERO, projection)
}

/// A plane that faces the eye.
fn upright(z_m: f32) -> Node {
    Node { rotation: Quat::from_rotation_x(FRAC_PI_2), ..at(Vec3::Z * z_m) }
}

fn unlit() -> Material {
    Material { shading_model: ShadingModel::Unlit, base_color_factor: Vec4::ONE, ..Material::default() }
}

/// A card behind everything, whose red rises to the right and green upwards.
fn card() -> Primitive {
    let mut card = primitives::plane(CARD_M);
    // Once it is upright, its z points down.
    let color = |[x, _, z]: &[f32; 3]| [0.5 + x / CARD_M, 0.5 - z / CARD_M, 0.25, 1.0];
    card.colors = card.positions.iter().map(color).collect();
    card
}

/// The place on the card that has a colour.
fn place_of(pixel: &[f32]) -> Vec3 {
    Vec3::new((pixel[0] - 0.5) * CARD_M, (pixel[1] - 0.5) * CARD_M, CARD_Z_M)
}

fn request(scene: &Scene, side: u32) -> FrameRequest {
    plain_request(scene, (side, side)).with(|settings| settings.exposure.stops = Exposure::Stops(0.0))
}

fn radiance_of(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<f32> {
    renderer.load(scene).unwrap();
    renderer.render(scene, request).unwrap();
    renderer.read_radiance().unwrap()
}

/// The direction of the ray through a pixel.
fn ray(x: u32, y: u32, side: u32) -> Vec3 {
    let half = (0.5 * FOV_Y_RAD).tan();
    let ndc = |at: u32| (2.0 * at as f32 + 1.0) / side as f32 - 1.0;
    Vec3::new(ndc(x) * half, -ndc(y) * half, -1.0).normalize()
}

/// Snell's law in vectors: how a ray goes on where a normal is against it.
fn bent(ray: Vec3, normal: Vec3, ratio: f32) -> Vec3 {
    let cosine = -normal.dot(ray);
    let squared = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    ratio * ray + (ratio * cosine - squared.sqrt()) * normal
}

/// Where a ray meets a plane at a height.
fn at_height(origin: Vec3, ray: Vec3, z_m: f32) -> Vec3 {
    origin + ray * ((z_m - origin.z) / ray.z)
}

/// Where a ray through a ball around the origin meets the card; none beside the ball, and at its edge.
fn through_ball(ray: Vec3, radius_m: f32) -> Option<Vec3> {
    let toward = -EYE.dot(ray);
    let aside_squared = EYE.length_squared() - toward * toward;
    let sine_squared = aside_squared / (radius_m * radius_m);
    if sine_squared > 0.64 {
        return None;
    }
    let enters = EYE + ray * (toward - (radius_m * radius_m - aside_squared).sqrt());
    let inside = bent(ray, enters / radius_m, 1.0 / IOR);
    let leaves = enters - 2.0 * inside.dot(enters) * inside;
    Some(at_height(leaves, bent(inside, -leaves / radius_m, IOR), CARD_Z_M))
}

/// Where a ray through a slab that is turned about its middle meets the card; none where it does not go through both
/// faces.
fn through_slab(ray: Vec3, half_m: Vec3, rotation: Quat) -> Option<Vec3> {
    let (origin, local) = (rotation.inverse() * EYE, rotation.inverse() * ray);
    let enters = at_height(origin, local, half_m.z);
    let leaves = at_height(enters, bent(local, Vec3::Z, 1.0 / IOR), -half_m.z);
    let is_in = |place: Vec3| place.x.abs() < 0.8 * half_m.x && place.y.abs() < 0.8 * half_m.y;
    (is_in(enters) && is_in(leaves)).then(|| at_height(rotation * leaves, ray, CARD_Z_M))
}

/// A body whose front is flat and whose back is a roof: its ridge is the line x = 0 at this height, and its faces rise
/// from there at an angle towards the eye.
const RIDGE_Z_M: f32 = -0.6;
const SLOPE_RAD: f32 = 0.576;
const ROOF_FRONT_Z_M: f32 = 0.2;

fn roof() -> Primitive {
    const HALF_M: f32 = 0.8;
    let eaves_z_m = RIDGE_Z_M + HALF_M * SLOPE_RAD.tan();
    let mut roof = Primitive::default();
    let mut face = |normal: Vec3, [from, to]: [[f32; 2]; 2]| {
        let first = roof.positions.len() as u32;
        let corners = [(from, -HALF_M), (to, -HALF_M), (to, HALF_M), (from, HALF_M)];
        roof.positions.extend(corners.map(|([x, z], y)| [x, y, z]));
        roof.normals.extend([normal.to_array(); 4]);
        roof.indices.extend([0, 1, 2, 0, 2, 3].map(|corner| first + corner));
    };
    let (sine, cosine) = SLOPE_RAD.sin_cos();
    face(Vec3::Z, [[-HALF_M, ROOF_FRONT_Z_M], [HALF_M, ROOF_FRONT_Z_M]]);
    face(Vec3::X, [[HALF_M, ROOF_FRONT_Z_M], [HALF_M, eaves_z_m]]);
    face(Vec3::new(sine, 0.0, -cosine), [[HALF_M, eaves_z_m], [0.0, RIDGE_Z_M]]);
    face(Vec3::new(-sine, 0.0, -cosine), [[0.0, RIDGE_Z_M], [-HALF_M, eaves_z_m]]);
    face(Vec3::NEG_X, [[-HALF_M, eaves_z_m], [-HALF_M, ROOF_FRONT_Z_M]]);
    roof.bounds = Aabb::from_points(roof.positions.iter().copied().map(Vec3::from));
    roof
}

/// Where a ray through the middle of the roof meets the card if it leaves by its left face, and by its right one.
fn through_roof(ray: Vec3, node: &Node) -> Option<[Vec3; 2]> {
    let back = node.rotation.inverse();
    let (origin, local) = (back * (EYE - node.translation), back * ray);
    let enters = at_height(origin, local, ROOF_FRONT_Z_M);
    let inside = bent(local, Vec3::Z, 1.0 / IOR);
    let (sine, cosine) = SLOPE_RAD.sin_cos();
    let leaving_by = |side: f32| {
        let normal = Vec3::new(side * sine, 0.0, -cosine);
        let leaves = enters + inside * ((Vec3::Z * RIDGE_Z_M - enters).dot(normal) / inside.dot(normal));
        let direction = node.rotation * bent(inside, -normal, IOR);
        at_height(node.translation + node.rotation * leaves, direction, CARD_Z_M)
    };
    (enters.x.abs() < 0.3 && enters.y.abs() < 0.5).then(|| [-1.0, 1.0].map(leaving_by))
}

/// Compares where rays of a picture meet the card with where they should; gives how many are compared, and by how much
/// they are beside the straight ones at least and at most.
fn compare(found: &[f32], side: u32, what: &str, expected: impl Fn(Vec3) -> Option<Vec3>) -> (u32, [f32; 2]) {
    let (mut count, mut shifts) = (0, [f32::INFINITY, 0.0_f32]);
    for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
        let ray = ray(x, y, side);
        let Some(expected) = expected(ray) else { continue };
        let found = place_of(&found[4 * (y * side + x) as usize..]);
        let off_m = found.distance(expected);
        assert!(off_m < 0.03, "{what}, pixel {x}, {y}: {found}, not {expected}");
        let shift = found.distance(at_height(EYE, ray, CARD_Z_M));
        shifts = [shifts[0].min(shift), shifts[1].max(shift)];
        count += 1;
    }
    (count, shifts)
}

/// Something before the card.
fn before_card(body: Primitive, material: Material, node: Node) -> Scene {
    let mut builder = view();
    builder.put(card(), unlit(), upright(CARD_Z_M));
    builder.put(body, material, node);
    builder.finish()
}

#[test]
fn a_ball_of_glass_shows_what_lies_behind_upside_down() {
    let (side, radius_m) = (96, 0.5);
    let mut renderer = renderer();
    // What its thickness is said to be does not matter, only its shape.
    for (thickness_m, path, samples) in [
        (1.0, Path::Deferred, PixelSamples::One),
        (0.2, Path::Deferred, PixelSamples::One),
        (1.0, Path::Forward, PixelSamples::Four),
    ] {
        let ball = primitives::uv_sphere(radius_m, 64, 32);
        let scene = before_card(ball, glass(CLEAR, thickness_m), at(Vec3::ZERO));
        let request =
            request(&scene, side).with(|settings| (settings.render.path, settings.msaa.samples) = (path, samples));
        let found = radiance_of(&mut renderer, &scene, &request);
        let what = format!("{path:?}, {thickness_m} m");
        let (count, _) = compare(&found, side, &what, |ray| through_ball(ray, radius_m));
        assert!(count > 200, "{what}: {count} pixels");
        // Upside down: to the right of the middle what is on the left, and below what is above.
        let place = place_of(&found[4 * (54 * side + 54) as usize..]);
        assert!(place.x < -0.2 && place.y > 0.2, "{what}: {place}");
    }
}

#[test]
fn a_slab_shifts_what_lies_behind() {
    let side = 64;
    let mut renderer = renderer();
    let (half_m, rotation) = (Vec3::new(0.8, 0.8, 0.25), Quat::from_rotation_y(0.5));
    let slab = Node { rotation, ..at(Vec3::ZERO) };
    let scene = before_card(primitives::cube(2.0 * half_m), glass(CLEAR, 0.5), slab);
    let found = radiance_of(&mut renderer, &scene, &request(&scene, side));
    let (count, shifts) = compare(&found, side, "slab", |ray| through_slab(ray, half_m, rotation));
    // 0.09 m at 0.5 radians.
    assert!(count > 100 && shifts[0] > 0.04 && shifts[1] < 0.16, "{count} {shifts:?}");
    // A sheet has no back: it is as if there was one as far behind it as its thickness says.
    let sheet = Node { rotation: rotation * Quat::from_rotation_x(FRAC_PI_2), ..at(rotation * Vec3::Z * half_m.z) };
    let scene = before_card(primitives::plane(1.6), glass(CLEAR, 0.5), sheet);
    let found = radiance_of(&mut renderer, &scene, &request(&scene, side));
    let (count, _) = compare(&found, side, "sheet", |ray| through_slab(ray, half_m, rotation));
    assert!(count > 100, "{count}");
    // Without thickness nothing is bent.
    let scene = before_card(primitives::cube(2.0 * half_m), glass(CLEAR, 0.0), Node { rotation, ..at(Vec3::ZERO) });
    let found = radiance_of(&mut renderer, &scene, &request(&scene, side));
    let straight = |ray: Vec3| through_slab(ray, half_m, rotation).map(|_| at_height(EYE, ray, CARD_Z_M));
    assert!(compare(&found, side, "thin", straight).0 > 100);
}

#[test]
fn where_two_backs_meet_one_of_them_bends_the_ray() {
    let side = 64;
    let mut renderer = renderer();
    // Beside the middle and turned, so that rays meet the back anywhere between the middles of pixels.
    let node = Node { rotation: Quat::from_rotation_z(0.15), ..at(Vec3::X * 0.57) };
    let scene = before_card(roof(), glass(CLEAR, 0.5), node.clone());
    let found = radiance_of(&mut renderer, &scene, &request(&scene, side));
    let mut counts = [0; 2];
    for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
        let Some(expected) = through_roof(ray(x, y, side), &node) else { continue };
        let found = place_of(&found[4 * (y * side + x) as usize..]);
        let off_m = expected.map(|expected| found.distance(expected));
        let face = usize::from(off_m[1] < off_m[0]);
        // A mean of both was up to 0.3 m beside, in every tenth of these pixels.
        assert!(off_m[face] < 0.03, "pixel {x}, {y}: {found}, neither of {expected:?}");
        counts[face] += 1;
    }
    assert!(counts.iter().all(|count| *count > 50), "{counts:?}");
}

/// Balls one behind the other before a white card, or before nothing, in this order of nodes: their middles, their
/// radii and colours.
fn balls(has_card: bool, balls: &[(Vec3, f32, [f32; 3])]) -> Scene {
    let mut builder = view();
    for (center, radius_m, color) in balls {
        let ball = primitives::uv_sphere(*radius_m, 48, 24);
        builder.put(ball, glass(*color, 2.0 * radius_m), at(*center));
    }
    if has_card {
        builder.put(primitives::plane(12.0), unlit(), upright(-3.0));
    }
    builder.finish()
}

const NEAR: (Vec3, f32, [f32; 3]) = (Vec3::ZERO, 0.5, CLEAR);
const FAR: (Vec3, f32, [f32; 3]) = (Vec3::new(0.0, 0.0, -1.5), 0.5, RED);
const INNER: (Vec3, f32, [f32; 3]) = (Vec3::ZERO, 0.25, RED);

/// So that the ray through the middle goes straight through all balls.
const ODD: u32 = 33;

fn middle(picture: &[f32]) -> [f32; 4] {
    *picture[4 * (ODD / 2 * ODD + ODD / 2) as usize..].first_chunk().unwrap()
}

#[test]
fn a_red_ball_of_glass_is_seen_through_another_in_any_order() {
    let mut renderer = renderer();
    let mean = RED.iter().sum::<f32>() / 3.0;
    let [r, g, b] = RED;
    let cut_out = RED.map(|share| (share - mean).max(0.0));
    for (what, has_card, background, expected) in [
        ("card", true, Background::Color([0.0; 3]), [r, g, b, 1.0]),
        ("colour", false, Background::Color([0.5, 0.75, 1.0]), [0.5 * r, 0.75 * g, b, 1.0]),
        ("nothing", false, Background::Transparent, [cut_out[0], cut_out[1], cut_out[2], 1.0 - mean]),
    ] {
        for (path, other) in [(Path::Deferred, FAR), (Path::Forward, FAR), (Path::Deferred, INNER)] {
            let pictures = [[NEAR, other], [other, NEAR]].map(|order| {
                let scene = balls(has_card, &order);
                let request = request(&scene, ODD).with(|settings| {
                    (settings.render.path, settings.background.source) = (path, background);
                });
                radiance_of(&mut renderer, &scene, &request)
            });
            let found = middle(&pictures[0]);
            let off = (0..4).map(|c| (found[c] - expected[c]).abs()).fold(0.0, f32::max);
            assert!(off < 4e-3, "{what}, {path:?}, at {}: {found:?}, not {expected:?}", other.0);
            let differ = pictures[0].iter().zip(&pictures[1]).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(differ < 1e-3, "{what}, {path:?}, at {}: {differ} with nodes in another order", other.0);
        }
    }
    // With one layer what lies behind the nearer ball is none.
    let scene = balls(true, &[NEAR, FAR]);
    let request = request(&scene, ODD).with(|settings| settings.transparency.refractive_layers = 1);
    assert!(middle(&radiance_of(&mut renderer, &scene, &request))[1] > 0.99);
}

/// The passes of a frame that draw glass, or are drawn for it.
fn glass_passes(renderer: &mut Renderer, scene: &Scene, layers: Option<u32>) -> Vec<String> {
    renderer.load(scene).unwrap();
    let request = request(scene, 64).with(|settings| {
        settings.background.source = Background::Environment;
        settings.transparency.refractive_layers = layers.unwrap_or(settings.transparency.refractive_layers);
    });
    let plan = renderer.plan(scene, &request).unwrap();
    let is_of_glass = |name: &str| {
        ["transmissive", "glass", "behind"].iter().any(|begin| name.starts_with(begin)) && !name.contains(".halve.")
    };
    plan.passes.iter().map(|pass| pass.name.to_string()).filter(|name| is_of_glass(name)).collect()
}

#[test]
fn layers_of_glass_cost_something_where_objects_overlap_alone() {
    let mut renderer = Renderer::new(Gpu::without_adapter(Floor::WebGl2).unwrap()).unwrap();
    let layer = |suffix: &str| {
        let of_bodies = ["linear_depth", "distances", "backs"].map(|step| format!("glass{suffix}.{step}"));
        let [first, last] = [format!("behind{suffix}.copy"), format!("transmissive{suffix}")];
        [vec![first], of_bodies.to_vec(), vec![last]].concat()
    };
    let beside = [(Vec3::X, 0.5, CLEAR), (Vec3::NEG_X, 0.5, RED), (Vec3::new(0.0, 1.0, -2.0), 0.5, RED)];
    for layers in [None, Some(1), Some(8)] {
        let found = glass_passes(&mut renderer, &balls(true, &beside), layers);
        assert_eq!(found, layer(""), "{layers:?}");
    }
    let row = [NEAR, FAR, (Vec3::Z, 0.5, RED), (Vec3::NEG_Z * 2.5, 0.5, RED), (Vec3::Z * 2.0, 0.5, RED)];
    let all = [layer(".far.4"), layer(".far.3"), layer(".far.2"), layer(".far"), layer("")];
    for (layers, count) in [(None, 4), (Some(8), 5), (Some(2), 2), (Some(1), 1)] {
        let found = glass_passes(&mut renderer, &balls(true, &row), layers);
        assert_eq!(found, all[5 - count..].concat(), "{layers:?}");
    }
    // What has no thickness takes no look at backs.
    let mut builder = view();
    builder.put(primitives::plane(1.0), glass(RED, 0.0), upright(0.0));
    builder.put(primitives::plane(1.0), glass(RED, 0.0), upright(-1.0));
    let found = glass_passes(&mut renderer, &builder.finish(), None);
    assert_eq!(found, ["behind.far.copy", "transmissive.far", "behind.copy", "transmissive"]);
}
