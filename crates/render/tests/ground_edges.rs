//! Edges on the ground: where its map ends, seen through glass, and those of shadows in wide pictures.
//!
//! These need an adapter; the software one will do.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::renderer;
use crate::common::shadows::light;
use glam::{Mat4, Quat, Vec3, Vec4};
use manypass::{Averaging, Background, Environment, FrameRequest, Ground, Tonemap, View};
use manypass_scene::material::Specular;
use manypass_scene::{AlphaMode, LightKind, Material, Node, Projection, Scene, TexturedFactor, primitives};
use manypass_testkit::build::{SceneBuilder, at, grey};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_6};

const SIZE: (u32, u32) = (160, 120);
/// So many rows of a picture from the top lie above the box.
const ROWS_ABOVE: usize = 56;

/// A box of 1 m behind a pane that casts no shadow. Through the pane the automatic camera sees the box, and behind it
/// over 20 m of ground; the map of that ends a few metres behind the box.
fn behind_pane(pane: Material) -> Scene {
    let mut builder = SceneBuilder::default();
    builder.put(primitives::cube(Vec3::ONE), grey(0.8), at(Vec3::new(0.0, 0.5, 0.0)));
    let specular = Some(Specular { weight: TexturedFactor::new(0.0), ..Specular::default() });
    let pane = Material { metallic_factor: 0.0, roughness_factor: 0.0, specular, casts_shadow: false, ..pane };
    let node = Node { rotation: Quat::from_rotation_y(FRAC_PI_6), ..at(Vec3::new(0.4, 1.51, 0.9)) };
    builder.put(primitives::cube(Vec3::new(2.5, 3.0, 0.02)), pane, node);
    builder.finish()
}

fn glass(color: Vec3) -> Material {
    Material {
        base_color_factor: color.extend(1.0),
        transmission: Some(TexturedFactor::new(1.0)),
        ..Material::default()
    }
}

#[test]
fn no_step_shows_through_glass_where_the_map_of_the_ground_ends() {
    let mut renderer = renderer();
    let nothing = Material { base_color_factor: Vec4::ZERO, alpha_mode: AlphaMode::Blend, ..Material::default() };
    for background in [Background::Color([1.0; 3]), Background::Environment] {
        // Red and green, with all else at its default.
        let mut seen = |pane: Material, ground: Ground| {
            let scene = behind_pane(pane);
            let request = FrameRequest::of_scene(&scene, SIZE.0, SIZE.1).with(|settings| {
                settings.background.source = background;
                settings.ground.mode = ground;
                settings.tone_map.dither = 0.0;
            });
            renderer.render(&scene, &request).unwrap();
            let pixels = renderer.read_display().unwrap();
            pixels.chunks_exact(4).map(|pixel| [i32::from(pixel[0]), i32::from(pixel[1])]).collect::<Vec<_>>()
        };
        let clear = seen(glass(Vec3::ONE), Ground::Auto);
        let bare = seen(nothing.clone(), Ground::Auto);
        let open = seen(nothing.clone(), Ground::None);
        let red = seen(glass(Vec3::new(1.0, 0.2, 0.2)), Ground::Auto);
        // What the shadow takes under glass.
        let taken = Vec::from_iter(open.iter().zip(&clear).map(|(open, clear)| open[0] - clear[0]));
        let under = Vec::from_iter(red.iter().map(|[red, green]| red - green > 30));
        let dark = taken.iter().zip(&under).filter(|(taken, under)| **under && **taken > 5).count();
        let under_count = under.iter().filter(|under| **under).count();
        // As measured 1,007 of 10,968.
        assert!(under_count > 8000 && dark > 500, "{background:?}: {dark} dark of {under_count}: nothing to look at");
        // None, as measured.
        let apart = clear.iter().zip(&bare).filter(|(clear, bare)| (clear[0] - bare[0]).abs() > 1).count();
        assert!(apart <= 10, "{background:?}: clear glass shows in {apart} pixels");
        // One level, as measured.
        let width = SIZE.0 as usize;
        let step = |a: usize, b: usize| if under[a] && under[b] { (taken[a] - taken[b]).abs() } else { 0 };
        let steps = (0..width * ROWS_ABOVE).map(|pixel| step(pixel, pixel + 1).max(step(pixel, pixel + width)));
        let most = steps.max().unwrap();
        assert!(most <= 2, "{background:?}: a step of {most} levels behind the box");
    }
}

/// Metres that wide pictures show from left to right.
const WIDE_M: f32 = 8.0;
/// By how much the box is turned whose shadow they show.
const TURN_RAD: f32 = 0.5;

/// Of a strip so many pixels wide, from above, the edge of the shadow of a box on a white floor: its place in each row,
/// where half of the light comes, and its mean width from a tenth to nine tenths of the light, in pixels.
fn shadow_edge(width: u32) -> (Vec<f32>, f32) {
    const ROWS: u32 = 16;
    let mut builder = SceneBuilder::default();
    let node = Node { rotation: Quat::from_rotation_y(TURN_RAD), ..at(Vec3::new(-1.0, 0.5, 0.0)) };
    builder.put(primitives::cube(Vec3::ONE), grey(0.8), node);
    builder.light(light(LightKind::Directional, 3.0), Vec3::ZERO, Vec3::new(1.0, -1.0, 0.0));
    let scene = builder.finish();
    let rotation = Quat::from_rotation_x(-FRAC_PI_2);
    let world_from_view = Mat4::from_rotation_translation(rotation, Vec3::Y * 20.0);
    let height_m = WIDE_M * ROWS as f32 / width as f32;
    let projection = Projection::Orthographic { height_m, near_m: 0.1, far_m: 40.0 };
    let mut request = FrameRequest {
        averaging: Averaging::Both,
        ground_height_m: Some(0.0),
        ..FrameRequest::new(width, ROWS, View { world_from_view, projection })
    };
    request.settings.environment.source = Environment::None;
    request.settings.background.source = Background::Transparent;
    request.settings.tone_map.curve = Tonemap::None;
    request.settings.ground.mode = Ground::Color([1.0; 3]);
    let mut renderer = renderer();
    renderer.render(&scene, &request).unwrap();
    let radiance = renderer.read_radiance().unwrap();
    let (mut places, mut width_sum) = (Vec::new(), 0.0);
    for row in radiance.chunks_exact(4 * width as usize) {
        let red = Vec::from_iter(row.chunks_exact(4).map(|pixel| pixel[0]));
        let open = red[red.len() * 9 / 10];
        assert!(open > 0.1, "nothing is lit: {open}");
        // To the right of the middle, which is in the shadow.
        let first = red.len() / 2;
        let crosses = |share: f32| {
            let after = (first + 1..red.len()).find(|at| red[*at] > share * open).unwrap();
            let within = (share * open - red[after - 1]) / (red[after] - red[after - 1]);
            (after - 1) as f32 + within
        };
        places.push(crosses(0.5));
        width_sum += crosses(0.9) - crosses(0.1);
    }
    (places, width_sum / ROWS as f32)
}

/// The map has more texels for a wide picture: one of 256 a side is 15 pixels an edge wide at 3,840 pixels.
#[test]
fn edges_of_shadows_are_as_fine_and_straight_in_wide_pictures() {
    // 5.3 and 4.8 pixels wide, as measured, and within 0.06 of a line.
    for width in [1280, 3840] {
        let (places, edge_px) = shadow_edge(width);
        // The box turned by an angle: its shadow's edge has that to the columns.
        let slope = TURN_RAD.tan();
        let offsets = Vec::from_iter((0u8..).zip(&places).map(|(row, place)| place - slope * f32::from(row)));
        let (least, most) = offsets.iter().fold((f32::MAX, f32::MIN), |(a, b), at| (a.min(*at), b.max(*at)));
        println!("{width}: {edge_px:.2} px wide, {:.2} px from straight", most - least);
        assert!(edge_px < 8.0, "{width}: an edge of {edge_px} pixels");
        assert!(most - least < 0.5, "{width}: frayed by {} pixels: {places:?}", most - least);
        // The right corner of its top at z = 0 stands 1 m high: its shadow lies 1 m to the right.
        let expected_m = -1.0 + 0.5 / TURN_RAD.cos() + 1.0;
        let middle_m = (places[places.len() / 2] / width as f32 - 0.5) * WIDE_M;
        assert!((middle_m - expected_m).abs() < 0.03, "{width}: at {middle_m} m, not {expected_m} m");
    }
}
