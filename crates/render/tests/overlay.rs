//! Text, lines and sprites over the finished picture, at named pixels.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common;
use glam::{Mat4, Vec2, Vec3};
use manypass::scene::overlay::{
    Anchor, LinePoints, Overlay, OverlayItem, OverlayLine, OverlayPlace, OverlayShape, OverlaySprite, OverlayText,
    TextAlign,
};
use manypass::scene::primitives::cube;
use manypass::scene::{PixelFormat, Pixels, Projection, Scene};
use manypass::{
    Background, Environment, Fisheye, FrameRequest, OverlayError, Path, PixelSamples, RenderError, Renderer,
};
use manypass_testkit::build::{SceneBuilder, at, grey};
use std::sync::Arc;

const WIDTH: u32 = 64;
const HEIGHT: u32 = 48;

/// A wall of 2 m, 5 m before a camera at the origin; in a picture of 64 × 48 pixels it covers 19.2 each way.
fn wall() -> Scene {
    let projection = Projection::Perspective { fov_y_rad: 2.0 * 0.5f32.atan(), near_m: 0.1, far_m: None };
    let mut builder = SceneBuilder::new(Vec3::ZERO, Vec3::NEG_Z, projection);
    builder.put(cube(Vec3::new(2.0, 2.0, 0.1)), grey(0.5), at(Vec3::new(0.0, 0.0, -5.05)));
    builder.finish()
}

fn request(scene: &Scene, items: Vec<OverlayItem>) -> FrameRequest {
    let mut request = common::plain_request(scene, (WIDTH, HEIGHT));
    request.overlay = Overlay { items }.into();
    request
}

fn picture(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<[u8; 4]> {
    renderer.load(scene).unwrap();
    renderer.render(scene, request).unwrap();
    renderer.read_display().unwrap().chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect()
}

/// What the items make of a black picture.
fn drawn(items: Vec<OverlayItem>) -> Vec<[u8; 4]> {
    let scene =
        SceneBuilder::new(Vec3::ZERO, Vec3::NEG_Z, Projection::Orthographic { height_m: 1.0, near_m: 0.1, far_m: 9.0 });
    let scene = scene.finish();
    picture(&mut common::renderer(), &scene, &request(&scene, items))
}

fn pixel(picture: &[[u8; 4]], x: u32, y: u32) -> [u8; 4] {
    picture[(y * WIDTH + x) as usize]
}

fn lit(picture: &[[u8; 4]]) -> Vec<(u32, u32)> {
    let at = |index: usize| (index as u32 % WIDTH, index as u32 / WIDTH);
    picture.iter().enumerate().filter(|(_, pixel)| pixel[..3] != [0; 3]).map(|(index, _)| at(index)).collect()
}

fn shape(item: OverlayItem, change: impl FnOnce(&mut OverlayShape)) -> OverlayItem {
    let mut item = item;
    change(&mut item.shape);
    item
}

fn text(item: OverlayItem, change: impl FnOnce(&mut OverlayText)) -> OverlayItem {
    shape(item, |shape| {
        if let OverlayShape::Text(text) = shape {
            change(text)
        }
    })
}

fn px(x: f32, y: f32) -> OverlayPlace {
    OverlayPlace::at_px(Vec2::new(x, y))
}

/// Left and right column, upper and lower row of what is lit.
fn bounds(picture: &[[u8; 4]]) -> [u32; 4] {
    let lit = lit(picture);
    assert!(!lit.is_empty(), "nothing is drawn");
    let (xs, ys) = (|| lit.iter().map(|(x, _)| *x), || lit.iter().map(|(_, y)| *y));
    [xs().min().unwrap(), xs().max().unwrap(), ys().min().unwrap(), ys().max().unwrap()]
}

#[test]
fn a_letter_lies_at_named_pixels() {
    // DejaVu Sans: an H is 1493 of 2048 units high, its stems are from 201 to 403 and from 1137 to 1339, its bar from
    // 711 to 881; the ascent is 1901 units. At 32 pixels a unit is 1/64 pixel: the baseline is at row 30.
    let item = text(OverlayItem::text("H", px(4.0, 0.0)), |text| text.size_px = 32.0);
    let picture = drawn(vec![item]);
    let white = [255, 255, 255, 255];
    for (x, y) in [(8, 8), (9, 20), (22, 8), (23, 29), (15, 17)] {
        assert_eq!(pixel(&picture, x, y), white, "{x} {y}");
    }
    for (x, y) in [(6, 20), (25, 20), (15, 10), (15, 26), (8, 5), (8, 30)] {
        assert_eq!(pixel(&picture, x, y), [0, 0, 0, 255], "{x} {y}");
    }
    assert_eq!(bounds(&picture), [7, 24, 6, 29]);
    // The bar is from 18.89 up to 16.23.
    assert!(pixel(&picture, 15, 18)[0].abs_diff(227) <= 3 && pixel(&picture, 15, 16)[0].abs_diff(196) <= 3);
    // 23.33 rows: of the upper one a third is covered.
    assert!(pixel(&picture, 8, 6)[0].abs_diff(84) <= 3, "{:?}", pixel(&picture, 8, 6));
}

#[test]
fn text_stands_where_its_anchor_says() {
    let item = |place| text(OverlayItem::text("HH\nH", place), |text| text.size_px = 16.0);
    // An H is 12.03 pixels wide in advance, 11.66 high, a line 19 high; its stems begin 1.57 right of the pen.
    let [left, right, top, bottom] = bounds(&drawn(vec![item(px(0.0, 0.0))]));
    assert_eq!((left, right, top, bottom), (1, 22, 3, 33));
    for (place, by) in [
        (px(-1.0, -1.0), (WIDTH - 25 - 1, HEIGHT - 38 - 1)),
        (OverlayPlace::anchored(Anchor::BottomRight, Vec2::ZERO), (WIDTH - 25, HEIGHT - 38)),
        (OverlayPlace::anchored(Anchor::Center, Vec2::new(2.0, -1.0)), (22, 4)),
        (OverlayPlace::anchored(Anchor::Top, Vec2::ZERO), (20, 0)),
    ] {
        let found = bounds(&drawn(vec![item(place.clone())]));
        assert_eq!(found, [left + by.0, right + by.0, top + by.1, bottom + by.1], "{place:?}");
    }
    // The shorter line at the right: its stems are those of the second letter above.
    let right = text(item(px(0.0, 0.0)), |text| text.align = TextAlign::Right);
    let picture = drawn(vec![right]);
    assert!(pixel(&picture, 4, 28)[0] == 0 && lit(&picture).iter().any(|(x, y)| *x > 18 && *y > 25));
}

#[test]
fn a_box_lies_behind_its_text_and_a_letter_without_shape_is_a_box() {
    let item = text(OverlayItem::text("漢", px(2.0, 3.0)), |text| {
        (text.size_px, text.padding_px) = (20.0, 2.0);
        text.background = Some((Vec3::new(1.0, 0.0, 0.0), 1.0));
    });
    let picture = drawn(vec![item]);
    // A letter of 0.62 em, a line of 23 pixels, and 2 pixels on each side.
    assert_eq!(bounds(&picture), [2, 18, 3, 29]);
    assert_eq!((pixel(&picture, 2, 3), pixel(&picture, 18, 29)), ([255, 0, 0, 255], [255, 0, 0, 255]));
    // 10 × 14 pixels on the baseline at row 24, hollow.
    let white = [255; 4];
    for (x, y) in [(5, 10), (14, 10), (5, 23), (14, 23), (9, 10), (5, 15)] {
        assert_eq!(pixel(&picture, x, y), white, "{x} {y}");
    }
    for (x, y) in [(6, 11), (13, 22), (4, 10), (15, 23), (9, 9), (9, 24)] {
        assert_eq!(pixel(&picture, x, y), [255, 0, 0, 255], "{x} {y}");
    }
}

#[test]
fn lines_cover_exactly_what_they_should() {
    let line = |points: [[f32; 2]; 2]| OverlayItem::line(points.map(Vec2::from_array).to_vec());
    // Through the middles of pixels: whole ones.
    let picture = drawn(vec![line([[10.0, 20.5], [30.0, 20.5]])]);
    let expected: Vec<(u32, u32)> = (10..30).map(|x| (x, 20)).collect();
    assert_eq!(lit(&picture), expected);
    assert!(expected.iter().all(|(x, y)| pixel(&picture, *x, *y) == [255; 4]));
    // Down, from edges: the last is that of the picture.
    let picture = drawn(vec![line([[-3.5, 2.0], [-3.5, -1.0]])]);
    assert_eq!(lit(&picture), (2..HEIGHT - 1).map(|y| (WIDTH - 4, y)).collect::<Vec<_>>());
    // Between rows: half of both.
    let picture = drawn(vec![line([[10.0, 20.0], [30.0, 20.0]])]);
    assert_eq!(lit(&picture).len(), 40);
    assert!(pixel(&picture, 15, 19)[0].abs_diff(128) <= 1 && pixel(&picture, 15, 20)[0].abs_diff(128) <= 1);
    // A quarter of a pixel wide, and an end in the middle of a pixel.
    let thin = shape(line([[10.5, 20.5], [30.0, 20.5]]), |shape| {
        if let OverlayShape::Line(line) = shape {
            line.width_px = 0.25
        }
    });
    let picture = drawn(vec![thin]);
    assert!(pixel(&picture, 15, 20)[0].abs_diff(64) <= 1 && pixel(&picture, 10, 20)[0].abs_diff(32) <= 1);
    // Oblique: what is covered adds up to length times width.
    let oblique = shape(line([[10.0, 10.0], [40.0, 30.0]]), |shape| {
        if let OverlayShape::Line(line) = shape {
            line.width_px = 3.0
        }
    });
    let sum: f64 = drawn(vec![oblique]).iter().map(|pixel| f64::from(pixel[0]) / 255.0).sum();
    let expected = 3.0 * 30f64.hypot(20.0);
    assert!((sum / expected - 1.0).abs() < 0.02, "{sum} {expected}");
}

#[test]
fn corners_of_lines_are_mitred_and_no_pixel_is_covered_twice() {
    let points = [[10.0, 30.0], [10.0, 10.0], [40.0, 10.0], [40.0, 30.0]].map(Vec2::from_array).to_vec();
    let line = OverlayLine { points: LinePoints::Pixels(points), width_px: 4.0 };
    let item = shape(OverlayItem::line(Vec::new()), |shape| *shape = OverlayShape::Line(line));
    let picture = drawn(vec![OverlayItem { opacity: 0.5, ..item }]);
    let lit = lit(&picture);
    // Three strips of 4 pixels: 34 wide, and 18 more down on each side below the first four rows.
    assert_eq!(lit.len(), 34 * 4 + 2 * 18 * 4);
    assert!(lit.iter().all(|(x, y)| pixel(&picture, *x, *y)[0].abs_diff(128) <= 1), "evenly clear");
    assert_eq!(bounds(&picture), [8, 41, 8, 29]);
}

/// Four texels, the last clear.
fn four() -> Arc<Pixels> {
    let data = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 255, 0]].concat();
    Arc::new(Pixels { width: 2, height: 2, format: PixelFormat::Rgba8, data })
}

#[test]
fn sprites_lie_at_named_pixels() {
    let item = OverlayItem::sprite(four(), px(5.0, 7.0));
    let picture = drawn(vec![item.clone()]);
    let [red, green, blue] = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255]];
    let corners = [(5, 7), (6, 7), (5, 8)].map(|(x, y)| pixel(&picture, x, y));
    assert_eq!((corners, lit(&picture).len()), ([red, green, blue], 3));
    // Turned clockwise by a right angle, in the lower right corner, and tinted.
    let turned = OverlayItem { place: px(-3.0, -3.0), color_linear: Vec3::new(1.0, 1.0, 0.0), ..item.clone() };
    let turned = shape(turned, |shape| {
        if let OverlayShape::Sprite(sprite) = shape {
            sprite.rotation_deg = 90.0
        }
    });
    let picture = drawn(vec![turned]);
    let (x, y) = (WIDTH - 5, HEIGHT - 5);
    assert_eq!((pixel(&picture, x + 1, y), pixel(&picture, x + 1, y + 1)), (red, green));
    // Blue is nothing of yellow.
    assert_eq!(lit(&picture).len(), 2);
    // Eight times as large, it reaches from edge to edge.
    let large = shape(item, |shape| {
        if let OverlayShape::Sprite(OverlaySprite { size_px, .. }) = shape {
            *size_px = [Some(16.0), None]
        }
    });
    let picture = drawn(vec![large]);
    assert_eq!((pixel(&picture, 5, 7), pixel(&picture, 20, 7), pixel(&picture, 5, 22)), (red, green, blue));
    assert_eq!(bounds(&picture), [5, 20, 7, 22]);
}

#[test]
fn later_items_come_over_earlier_ones_and_opacity_mixes_display_colours() {
    let filled = |color: Vec3, x: f32| {
        let line = shape(OverlayItem::line(vec![Vec2::new(x, 20.0), Vec2::new(x + 10.0, 20.0)]), |shape| {
            if let OverlayShape::Line(line) = shape {
                line.width_px = 10.0
            }
        });
        OverlayItem { color_linear: color, ..line }
    };
    let (red, green) = (filled(Vec3::X, 10.0), OverlayItem { opacity: 0.25, ..filled(Vec3::Y, 15.0) });
    let picture = drawn(vec![red.clone(), green.clone()]);
    let mixed = pixel(&picture, 17, 20);
    assert!(mixed[0].abs_diff(191) <= 1 && mixed[1].abs_diff(64) <= 1 && mixed[3] == 255, "{mixed:?}");
    assert_eq!(pixel(&drawn(vec![green, red]), 17, 20), [255, 0, 0, 255]);
}

#[test]
fn what_lies_behind_a_wall_is_hidden_and_what_lies_before_it_is_not() {
    let mut renderer = common::renderer();
    let scene = wall();
    let label = |z: f32, tests: bool| {
        let item =
            text(OverlayItem::text("■", OverlayPlace::at_world(Vec3::new(0.0, 0.0, z))), |text| text.size_px = 12.0);
        OverlayItem { depth_test: tests, color_linear: Vec3::X, ..item }
    };
    let count = |picture: &[[u8; 4]]| picture.iter().filter(|pixel| pixel[0] > 200 && pixel[1] < 50).count();
    for path in [Path::Deferred, Path::Forward] {
        for (samples, scale, msaa) in [(1, 1.0, 1), (16, 1.0, 1), (1, 0.5, 1), (1, 1.0, 4)] {
            let is_forward = path == Path::Forward;
            if msaa > 1 && !is_forward {
                continue;
            }
            let mut shown = |item| {
                let mut request = request(&scene, vec![item]);
                request.averaging = manypass::Averaging::Display;
                request.settings.render.path = path;
                request.settings.render.scale = scale;
                request.settings.adaptive.threshold = 1.0;
                request.settings.msaa.samples = if msaa > 1 { PixelSamples::Four } else { PixelSamples::One };
                request.sample_count = samples;
                renderer.load(&scene).unwrap();
                for sample_index in 0..samples {
                    let request = FrameRequest { sample_index, ..request.clone() };
                    if sample_index + 1 < samples {
                        renderer.accumulate(&scene, &request).unwrap();
                    } else {
                        renderer.render(&scene, &request).unwrap();
                    }
                }
                let bytes = renderer.read_display().unwrap();
                count(&bytes.chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect::<Vec<_>>())
            };
            let what = format!("{path:?} {samples} {scale} {msaa}");
            let before = shown(label(-4.0, true));
            assert!(before > 20, "{what}: {before}");
            assert_eq!(shown(label(-6.0, true)), 0, "{what}");
            assert!(shown(label(-6.0, false)) > 20, "{what}");
            let brought = shown(OverlayItem { depth_offset_m: 2.0, ..label(-6.0, true) });
            assert!(brought > 20, "{what}: {brought}");
            // On the wall itself.
            assert!(shown(label(-5.0, true)) > 20, "{what}");
        }
    }
}

#[test]
fn a_line_leads_into_a_wall_and_behind_the_eye() {
    let (mut renderer, scene) = (common::renderer(), wall());
    // From behind the eye, a metre right of it and below, to a point behind the wall.
    let points = vec![Vec3::new(0.5, -0.5, 3.0), Vec3::new(0.5, -0.5, -20.0)];
    let item = OverlayItem { depth_test: true, color_linear: Vec3::X, ..OverlayItem::line_world(points.clone()) };
    let red = |picture: &[[u8; 4]]| -> Vec<(u32, u32)> {
        let is_red = |(x, y): &(u32, u32)| pixel(picture, *x, *y)[0] > 150 && pixel(picture, *x, *y)[1] < 100;
        lit(picture).into_iter().filter(is_red).collect()
    };
    let found = red(&picture(&mut renderer, &scene, &request(&scene, vec![item.clone()])));
    // It meets the wall at a distance of 5 m: half of 48 pixels is 2.5 m there.
    let (end, border) = (found.iter().map(|(_, y)| *y).min().unwrap(), found.iter().map(|(_, y)| *y).max().unwrap());
    assert!((28..=29).contains(&end) && border == HEIGHT - 1, "{found:?}");
    let whole = red(&picture(&mut renderer, &scene, &request(&scene, vec![OverlayItem { depth_test: false, ..item }])));
    assert!(whole.iter().any(|(_, y)| *y <= 26) && whole.len() > found.len(), "{whole:?}");
}

#[test]
fn places_follow_nodes_and_the_camera() {
    let (mut renderer, mut scene) = (common::renderer(), wall());
    scene.nodes[1].name = "Wall".into();
    let item = text(OverlayItem::text("■", OverlayPlace::at_node("Wall")), |text| text.size_px = 8.0);
    let mut request = request(&scene, vec![OverlayItem { color_linear: Vec3::X, ..item }]);
    let middle = |renderer: &mut Renderer, scene: &Scene, request: &FrameRequest| {
        let picture = picture(renderer, scene, request);
        let red: Vec<(u32, u32)> = lit(&picture).into_iter().filter(|(x, y)| pixel(&picture, *x, *y)[1] < 50).collect();
        let mean = |of: &dyn Fn(&(u32, u32)) -> u32| {
            red.iter().map(|at| f64::from(of(at)) + 0.5).sum::<f64>() / red.len() as f64
        };
        (mean(&|at| at.0), mean(&|at| at.1))
    };
    let first = middle(&mut renderer, &scene, &request);
    assert!((first.0 - 32.0).abs() < 1.0 && (first.1 - 24.0).abs() < 2.5, "{first:?}");
    // A metre at 5.05 m is 48 / 5.05 pixels.
    scene.nodes[1].translation.x = 1.0;
    scene.update_transforms();
    let second = middle(&mut renderer, &scene, &request);
    assert!((second.0 - first.0 - 9.5).abs() < 0.6 && (second.1 - first.1).abs() < 0.1, "{second:?}");
    request.camera.world_from_view = Mat4::from_translation(Vec3::X);
    let third = middle(&mut renderer, &scene, &request);
    assert!((third.0 - first.0).abs() < 0.1, "{third:?}");
    request.overlay = Overlay { items: vec![OverlayItem::text("a", OverlayPlace::at_node("Door"))] }.into();
    let error = renderer.render(&scene, &request).unwrap_err();
    assert_eq!(error.to_string(), "item 0 of the overlay: the scene has no node called `Door`");
}

#[test]
fn a_fisheye_shows_places_where_it_shows_surfaces() {
    let scene = wall();
    let place = OverlayPlace::at_world(Vec3::new(1.0, 1.0, -5.0));
    let item = text(OverlayItem::text("■", place), |text| text.size_px = 6.0);
    let mut request = request(&scene, vec![OverlayItem { color_linear: Vec3::X, ..item }]);
    request.averaging = manypass::Averaging::Display;
    for map in [Fisheye::Equidistant, Fisheye::Equisolid, Fisheye::Stereographic] {
        (request.settings.camera.fisheye, request.settings.camera.fisheye_fov_deg) = (map, 60.0);
        let picture = picture(&mut common::renderer(), &scene, &request);
        let is_red = |(x, y): &(u32, u32)| pixel(&picture, *x, *y)[0] > 200 && pixel(&picture, *x, *y)[1] < 50;
        let red: Vec<(u32, u32)> = lit(&picture).into_iter().filter(is_red).collect();
        let (x, y) = red.iter().fold((0.0, 0.0), |(x, y), at| (x + f64::from(at.0) + 0.5, y + f64::from(at.1) + 0.5));
        let (x, y) = (x / red.len() as f64 - 32.0, y / red.len() as f64 - 24.0);
        // 15.8° from the axis, of 30° that are 24 pixels away.
        let expected = match map {
            Fisheye::Equisolid => 24.0 * 7.9f64.to_radians().sin() / 15f64.to_radians().sin(),
            Fisheye::Stereographic => 24.0 * 7.9f64.to_radians().tan() / 15f64.to_radians().tan(),
            _ => 24.0 * 15.8 / 30.0,
        };
        assert!((x.hypot(y) - expected).abs() < 1.5 && x > 0.0 && y < 0.0, "{map:?}: {x} {y}, {expected}");
    }
    let item = OverlayItem { depth_test: true, ..OverlayItem::text("a", OverlayPlace::at_world(Vec3::NEG_Z)) };
    request.overlay = Overlay { items: vec![item] }.into();
    let error = common::renderer().render(&scene, &request).unwrap_err();
    assert!(matches!(error, RenderError::Overlay(_)) && error.to_string().contains("fisheye"), "{error}");
}

#[test]
fn over_a_transparent_picture_colours_are_not_darkened() {
    let (mut renderer, scene) = (common::renderer(), wall());
    let line = OverlayItem {
        opacity: 0.5,
        color_linear: Vec3::X,
        ..OverlayItem::line(vec![Vec2::new(0.0, 24.5), Vec2::new(64.0, 24.5)])
    };
    let mut of = request(&scene, vec![line]);
    of.settings.background.source = Background::Transparent;
    of.settings.environment.source = Environment::Studio;
    let with = picture(&mut renderer, &scene, &of);
    let edge = pixel(&with, 2, 24);
    assert!(edge[0] == 255 && edge[1] == 0 && edge[3].abs_diff(128) <= 1, "{edge:?}");
    of.overlay = Arc::default();
    let without = picture(&mut renderer, &scene, &of);
    let (over, under) = (pixel(&with, 32, 24), pixel(&without, 32, 24));
    let mixed = (f64::from(under[1]) * 0.5).round() as u8;
    assert!(under[3] == 255 && over[3] == 255 && over[1].abs_diff(mixed) <= 1, "{over:?} {under:?}");
    // Where nothing is drawn nothing changes, not by a bit.
    for (index, (a, b)) in with.iter().zip(&without).enumerate() {
        assert!(index as u32 / WIDTH == 24 || a == b, "{index}: {a:?} {b:?}");
    }
}

#[test]
fn an_overlay_changes_the_picture_alone() {
    let (mut renderer, scene) = (common::renderer(), wall());
    let mut of = request(&scene, Vec::new());
    of.sample_count = 4;
    let mut draw = |of: &FrameRequest| {
        renderer.load(&scene).unwrap();
        for sample_index in 0..4 {
            renderer.render(&scene, &FrameRequest { sample_index, ..of.clone() }).unwrap();
        }
        (renderer.read_display().unwrap(), renderer.read_radiance().unwrap())
    };
    let (before, radiance) = draw(&of);
    let item = text(OverlayItem::text("over", px(10.0, 10.0)), |text| text.background = Some((Vec3::ONE, 1.0)));
    of.overlay = Overlay { items: vec![item] }.into();
    let (with, radiance_with) = draw(&of);
    assert!(before != with && radiance == radiance_with, "means are without it, and so are linear files");
    // What is there of it after each of four samples is there once.
    of.overlay = Arc::default();
    assert!(draw(&of).0 == before, "without one the picture is that of before, to the byte");
    // What is nowhere in the picture costs no pass.
    let outside = Overlay { items: vec![OverlayItem::text("a", px(500.0, 500.0))] };
    of.overlay = outside.into();
    let plan = renderer.plan(&scene, &of).unwrap().to_text();
    assert!(!plan.contains("overlay"), "{plan}");
}

#[test]
fn what_cannot_be_drawn_is_refused_and_tiny_and_huge_pictures_are_drawn() {
    let (mut renderer, scene) = (common::renderer(), wall());
    let wrong = [
        (OverlayItem::text("", px(0.0, 0.0)), "`text`: the text is empty"),
        (OverlayItem::text("a\u{1b}", px(0.0, 0.0)), "U+001B"),
        (OverlayItem::text("a", px(f32::NAN, 0.0)), "`position`"),
        (OverlayItem::text("a", OverlayPlace::at_world(Vec3::splat(f32::INFINITY))), "`at_world`"),
        (text(OverlayItem::text("a", px(0.0, 0.0)), |text| text.size_px = f32::NAN), "`size_px`"),
        (text(OverlayItem::text("a", px(0.0, 0.0)), |text| text.size_px = 1e9), "`size_px`"),
        (OverlayItem { opacity: -1.0, ..OverlayItem::text("a", px(0.0, 0.0)) }, "`opacity`"),
        (OverlayItem::line(vec![Vec2::ZERO]), "two points or more"),
        (OverlayItem::text("x".repeat(100_001), px(0.0, 0.0)), "100000 are possible"),
    ];
    for (item, part) in wrong {
        let error = renderer.render(&scene, &request(&scene, vec![item])).unwrap_err().to_string();
        assert!(error.starts_with("item 0 of the overlay: ") && error.contains(part), "{error}");
    }
    let many = vec![OverlayItem::text("aaaaaaaaaa", px(0.0, 0.0)); 20_001];
    let error = renderer.render(&scene, &request(&scene, many)).unwrap_err().to_string();
    assert!(error.contains("more than 200000"), "{error}");
    let sizes = (0..200u8)
        .map(|size| text(OverlayItem::text("W", px(0.0, 0.0)), |text| text.size_px = 800.0 + f32::from(size)));
    let error = renderer.render(&scene, &request(&scene, sizes.collect())).unwrap_err().to_string();
    assert!(error.contains("do not fit into a texture of 4096"), "{error}");
    let item = || {
        text(OverlayItem::text("Ag", OverlayPlace::anchored(Anchor::Center, Vec2::ZERO)), |text| text.size_px = 900.0)
    };
    for (width, height) in [(1, 1), (1, 4096), (4096, 1)] {
        let mut of = request(&scene, vec![item(), OverlayItem::line(vec![Vec2::ZERO, Vec2::new(-0.5, -0.5)])]);
        (of.width, of.height) = (width, height);
        renderer.render(&scene, &of).unwrap();
        assert_eq!(renderer.read_display().unwrap().len(), (width * height * 4) as usize);
    }
}

#[test]
fn ten_thousand_labels_are_drawn() {
    let labels = (0..10_000u16).map(|i| {
        let (x, y) = (f32::from(i % 100) / 100.0 * 60.0, f32::from(i / 100) / 100.0 * 40.0);
        text(OverlayItem::text("label", px(x, y)), |text| text.size_px = 8.0)
    });
    let picture = drawn(labels.collect());
    // The quads of the last one, in the two hundredth row of their table, are in their place.
    assert!(lit(&picture).len() > 1500);
    assert!(lit(&picture).iter().any(|(x, y)| *x > 60 && *y > 40));
}

#[test]
fn a_view_shows_what_its_request_says() {
    let (mut renderer, scene) = (common::renderer(), wall());
    renderer.load(&scene).unwrap();
    let (plain, labelled) = (request(&scene, Vec::new()), request(&scene, vec![OverlayItem::text("b", px(0.0, 0.0))]));
    renderer.render_views(&scene, &[("a", &plain), ("b", &labelled)]).unwrap();
    let read = |name: &str| pollster::block_on(renderer.rendered(name).unwrap().read_display_async()).unwrap();
    assert!(read("a") != read("b"));
}

#[test]
fn letters_and_images_count_for_the_memory_budget_while_they_are_not_there() {
    let scene = wall();
    let mut renderer = common::renderer();
    renderer.load(&scene).unwrap();
    // So large that it has a texture of 2,048 texels a side, 16 MiB.
    let sprite = |side: u32| {
        let data = vec![255; (4 * side * side) as usize];
        let pixels = Pixels { width: side, height: side, format: PixelFormat::Rgba8, data };
        request(&scene, vec![OverlayItem::sprite(Arc::new(pixels), px(0.0, 0.0))])
    };
    let (large, small) = (sprite(1500), sprite(20));
    // Whatever else the frame has is there already.
    renderer.render(&scene, &small).unwrap();
    renderer.set_memory_budget(Some((16 << 20) - 1));
    let error = renderer.render(&scene, &large).unwrap_err();
    let Some(RenderError::Overlay(OverlayError::Memory { side, needed_bytes, budget_bytes })) = Some(&error) else {
        panic!("{error}")
    };
    assert_eq!((*side, *needed_bytes, *budget_bytes), (2048, 16 << 20, (16 << 20) - 1));
    assert!(error.to_string().contains("a texture of 2048 × 2048 texels"), "{error}");
    // Nothing is left of it, and what is smaller is drawn.
    renderer.render(&scene, &sprite(21)).unwrap();
    renderer.set_memory_budget(Some(16 << 20));
    renderer.render(&scene, &large).unwrap();
    // It is there, and takes nothing more.
    renderer.set_memory_budget(Some(0));
    renderer.render(&scene, &large).unwrap();
    assert!(matches!(renderer.render(&scene, &small), Err(RenderError::Overlay(OverlayError::Memory { .. }))));
}
