//! Decals: where they lie against the ray caster, what each part does, and that every path shows the same.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{floats, plain_request, renderer};
use glam::{Mat4, Vec2, Vec3};
use manypass::gpu::Floor;
use manypass::{Aov, FrameRequest, Gpu, Path, Renderer, View};
use manypass_scene::decal::{DECALS_MAX, Decal, DecalLook, DecalOpacity};
use manypass_scene::primitives::{cube, plane, uv_sphere};
use manypass_scene::{
    AlphaMode, Image, ImageSource, Light, LightKind, Material, Node, PixelFormat, Pixels, Projection, Scene,
    ShadingModel, demo,
};
use manypass_testkit::build::{SceneBuilder, at, grey};
use manypass_testkit::raycast::{Camera, Options, World};
use std::f32::consts::PI;
use std::sync::Arc;

const SIZE: (u32, u32) = (160, 120);
const PERSPECTIVE: Projection = Projection::Perspective { fov_y_rad: 0.9, near_m: 0.05, far_m: None };

/// A floor, a wall and a ball in the corner between them.
fn corner(projection: Projection) -> Scene {
    let mut builder = SceneBuilder::new(Vec3::new(1.6, 1.4, 3.0), Vec3::new(0.0, 0.4, 0.0), projection);
    builder.put(plane(8.0), grey(0.5), at(Vec3::ZERO));
    builder.put(cube(Vec3::new(8.0, 3.0, 0.2)), grey(0.4), at(Vec3::new(0.0, 1.5, -1.1)));
    builder.put(uv_sphere(0.4, 128, 64), grey(0.3), at(Vec3::new(-0.2, 0.4, -0.3)));
    builder.finish()
}

/// Adds an image of `side` texels, of which a function gives the bytes by the place in texels.
fn add_image(scene: &mut Scene, side: u32, texel: impl Fn(u32, u32) -> [u8; 4]) -> usize {
    let data = (0..side * side).flat_map(|at| texel(at % side, at / side)).collect();
    let pixels = Pixels { width: side, height: side, format: PixelFormat::Rgba8, data };
    scene.images.push(Image { name: "of a test".into(), source: ImageSource::Pixels(pixels.into()) });
    scene.images.len() - 1
}

/// Decals of a look in boxes, whichever way surfaces are turned.
fn decal(look: &DecalLook, parent_from_box: Mat4) -> Decal {
    Decal { parent_from_box, angle_rad: Vec2::splat(PI), ..Decal::new("of a test", look.clone()) }
}

fn placed(look: &DecalLook, center: Vec3, direction: Vec3, size_m: Vec3) -> Decal {
    let mut decal = decal(look, Mat4::IDENTITY);
    decal.place(center, direction, Vec3::Y, size_m);
    decal
}

fn variable(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest, aov: Aov) -> Vec<f32> {
    let request = FrameRequest { want_aovs: vec![aov], ..request.clone() };
    renderer.render(scene, &request).unwrap();
    floats(renderer.read_aov(aov).unwrap())
}

fn radiance(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<[f32; 3]> {
    renderer.render(scene, request).unwrap();
    renderer.read_radiance().unwrap().chunks_exact(4).map(|p| [p[0], p[1], p[2]]).collect()
}

/// Colours that rise evenly: linear light of a place from the upper left corner.
fn gradient(u: f64, v: f64) -> [f64; 3] {
    [0.1 + 0.8 * u, 0.1 + 0.8 * v, 0.25]
}

fn srgb(linear: f64) -> u8 {
    let encoded = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0).round() as u8
}

#[test]
fn a_decal_over_a_corner_lies_where_rays_have_it() {
    let orthographic = Projection::Orthographic { height_m: 3.2, near_m: 0.1, far_m: 20.0 };
    let cut = Projection::Perspective { fov_y_rad: 0.9, near_m: 0.05, far_m: Some(4.2) };
    let boxes = [
        // Along the bisector of the corner, over floor, wall and ball.
        (Vec3::new(0.1, 0.5, -0.5), Vec3::new(0.1, -1.0, -1.0), Vec3::new(1.7, 1.4, 1.6)),
        // The eye is inside.
        (Vec3::new(1.0, 0.8, 1.4), Vec3::new(-0.4, -0.3, -1.0), Vec3::new(3.0, 2.6, 7.0)),
    ];
    let mut renderer = renderer();
    for (projection, (center, direction, size_m)) in
        [PERSPECTIVE, orthographic, cut].into_iter().flat_map(|projection| boxes.map(|of| (projection, of)))
    {
        let mut scene = corner(projection);
        let image = add_image(&mut scene, 64, |x, y| {
            let [r, g, b] = gradient((f64::from(x) + 0.5) / 64.0, (f64::from(y) + 0.5) / 64.0).map(srgb);
            [r, g, b, 255]
        });
        let look = DecalLook { color_image: Some(image), ..DecalLook::default() };
        scene.decals = vec![placed(&look, center, direction, size_m)];
        let plain = scene.decals[0].parent_from_box;
        // A box that is mirrored along its depth is the same.
        for matrix in [plain, plain * Mat4::from_scale(Vec3::new(1.0, 1.0, -1.0))] {
            scene.decals[0].parent_from_box = matrix;
            let found = variable(&mut renderer, &scene, &plain_request(&scene, SIZE), Aov::BaseColor);
            let world = World::of_scene(&scene, Camera::of_scene(&scene).unwrap());
            let truth = world.render(SIZE.0 as usize, SIZE.1 as usize, Options::default());
            let box_from_world = matrix.as_dmat4().inverse();
            let (mut inside, mut outside, mut off) = (0, 0, 0);
            for (at, color) in found.chunks_exact(3).enumerate() {
                let object = truth.object_id[at] as usize;
                // A row of the floor lies before the near plane of parallel rays.
                if object == 0 || color == [0.0; 3] {
                    continue;
                }
                let local = box_from_world.transform_point3(truth.position_world[at]);
                let far = local.abs().max_element();
                let below = [0.5, 0.4, 0.3][object - 2];
                // Silhouettes of triangles and edges of boxes differ by a pixel, and coarse texels end at the edge.
                if (0.45..0.52).contains(&far) {
                    continue;
                }
                let expected = if far < 0.5 { gradient(local.x + 0.5, 0.5 - local.y) } else { [below; 3] };
                let is_right =
                    color.iter().zip(expected).all(|(found, truth)| (f64::from(*found) - truth).abs() < 0.02);
                off += usize::from(!is_right);
                if far < 0.5 {
                    inside += 1;
                } else {
                    outside += 1;
                }
            }
            assert!(inside > 1000 && (outside > 1000 || center.x > 0.5), "{inside} inside, {outside} outside");
            // At the silhouette of the ball.
            assert!(off < 60, "{off} of {inside} and {outside} with {projection:?}, {center}");
        }
    }
}

/// A floor seen from above, of which a metre is `SIZE.1 / 4` pixels.
fn floor(material: Material) -> Scene {
    let projection = Projection::Orthographic { height_m: 4.0, near_m: 0.1, far_m: 10.0 };
    let mut builder = SceneBuilder::new(4.0 * Vec3::Y, Vec3::ZERO, projection);
    builder.put(plane(8.0), material, at(Vec3::ZERO));
    builder.finish()
}

/// What a variable has at a place of the floor.
fn on_floor<const N: usize>(values: &[f32], place: Vec2) -> [f32; N] {
    let px_a_metre = SIZE.1 as f32 / 4.0;
    let pixel = Vec2::new(SIZE.0 as f32, SIZE.1 as f32) * 0.5 + place * px_a_metre;
    let at = (pixel.y as usize * SIZE.0 as usize + pixel.x as usize) * N;
    values[at..at + N].try_into().unwrap()
}

fn down(look: &DecalLook, center: Vec3) -> Decal {
    let mut decal = decal(look, Mat4::IDENTITY);
    decal.place(center, Vec3::NEG_Y, Vec3::NEG_Z, Vec3::ONE);
    decal
}

fn assert_near<const N: usize>(found: [f32; N], expected: [f32; N], what: &str) {
    let is_near = found.iter().zip(&expected).all(|(found, expected)| (found - expected).abs() < 0.008);
    assert!(is_near, "{what}: {found:?} in place of {expected:?}");
}

#[test]
fn each_part_has_an_opacity_of_its_own() {
    let mut scene = floor(Material { roughness_factor: 0.8, metallic_factor: 1.0, ..grey(0.5) });
    let opacity = DecalOpacity { color: 0.25, normal: 1.0, roughness: 0.75, emission: 0.5 };
    let look = DecalLook {
        color: Vec3::new(1.0, 0.1, 0.1),
        roughness: 0.2,
        emission: Vec3::new(0.0, 4.0, 0.0),
        opacity,
        ..DecalLook::default()
    };
    scene.decals.push(down(&look, Vec3::ZERO));
    let mut renderer = renderer();
    let request = plain_request(&scene, SIZE);
    let color = variable(&mut renderer, &scene, &request, Aov::BaseColor);
    assert_near(on_floor(&color, Vec2::ZERO), [0.625, 0.4, 0.4], "base colour");
    assert_near(on_floor(&color, Vec2::new(0.6, 0.0)), [0.5; 3], "base colour beside it");
    let roughness = variable(&mut renderer, &scene, &request, Aov::Roughness);
    assert_near(on_floor(&roughness, Vec2::ZERO), [0.35], "roughness");
    let metallic = variable(&mut renderer, &scene, &request, Aov::Metallic);
    assert_near(on_floor(&metallic, Vec2::ZERO), [0.75], "metallic");
    // Half of what is below stays.
    scene.materials[0].emissive_factor = Vec3::new(1.0, 0.0, 0.0);
    let emission = variable(&mut renderer, &scene, &request, Aov::Emission);
    assert_near(on_floor(&emission, Vec2::ZERO), [0.5, 2.0, 0.0], "emission");
    assert_near(on_floor(&emission, Vec2::new(0.6, 0.0)), [1.0, 0.0, 0.0], "emission beside it");
    // What is unlit shows its base colour.
    scene.materials[0].shading_model = ShadingModel::Unlit;
    let unlit = variable(&mut renderer, &scene, &request, Aov::Emission);
    assert_near(on_floor(&unlit, Vec2::ZERO), [0.625, 2.4, 0.4], "unlit");
}

#[test]
fn images_say_how_much_there_is_and_how_it_is() {
    let mut scene = floor(grey(0.5));
    let halves = add_image(&mut scene, 2, |x, _| [255, 255, 255, if x == 0 { 255 } else { 0 }]);
    let finish = add_image(&mut scene, 2, |_, _| [0, 128, 255, 255]);
    let leaning = add_image(&mut scene, 1, |_, _| [128 + 90, 128, 128 + 90, 255]);
    let look = DecalLook {
        color: Vec3::new(0.9, 0.2, 0.2),
        color_image: Some(halves),
        metallic: 0.5,
        rough_metal_image: Some(finish),
        normal_image: Some(leaning),
        opacity: DecalOpacity { color: 1.0, normal: 1.0, roughness: 1.0, emission: 0.0 },
        ..DecalLook::default()
    };
    scene.decals.push(down(&look, Vec3::ZERO));
    let mut renderer = renderer();
    let request = plain_request(&scene, SIZE);
    let places = [Vec2::new(-0.4, 0.0), Vec2::new(0.4, 0.0)];
    let mut parts = |aov| variable(&mut renderer, &scene, &request, aov);
    let (color, roughness) = (parts(Aov::BaseColor), parts(Aov::Roughness));
    let (metallic, normal) = (parts(Aov::Metallic), parts(Aov::Normal));
    assert_near(on_floor(&color, places[0]), [0.9, 0.2, 0.2], "base colour");
    assert_near(on_floor(&color, places[1]), [0.5; 3], "base colour without alpha");
    assert_near(on_floor(&roughness, places[0]), [0.502], "roughness");
    assert_near(on_floor(&roughness, places[1]), [1.0], "roughness without alpha");
    assert_near(on_floor(&metallic, places[0]), [0.5], "metallic");
    // Leaning to the right of the picture, which is +X, by 45°.
    assert_near(on_floor(&normal, places[0]), [0.708, 0.706, 0.004], "normal");
    assert_near(on_floor(&normal, places[1]), [0.0, 1.0, 0.0], "normal without alpha");
    // A picture that is turned leans elsewhere.
    scene.decals[0].place(Vec3::ZERO, Vec3::NEG_Y, Vec3::NEG_X, Vec3::ONE);
    let normal = variable(&mut renderer, &scene, &request, Aov::Normal);
    assert_near(on_floor(&normal, Vec2::new(0.0, 0.4)), [-0.004, 0.706, -0.708], "normal of a turned picture");
}

#[test]
fn angles_and_layers_choose_surfaces_and_orders_lie_over_each_other() {
    let mut scene = floor(grey(0.5));
    let red = DecalLook { color: Vec3::new(1.0, 0.0, 0.0), ..DecalLook::default() };
    let blue = DecalLook { color: Vec3::new(0.0, 0.0, 1.0), ..DecalLook::default() };
    let mut renderer = renderer();
    let request = plain_request(&scene, SIZE);
    let mut shown = |scene: &Scene| {
        let color = variable(&mut renderer, scene, &request, Aov::BaseColor);
        on_floor::<3>(&color, Vec2::ZERO)
    };
    // Later ones lie over earlier ones, unless their order is lower.
    scene.decals = vec![down(&red, Vec3::ZERO), down(&blue, Vec3::ZERO)];
    assert_near(shown(&scene), [0.0, 0.0, 1.0], "later");
    scene.decals[0].order = 1;
    assert_near(shown(&scene), [1.0, 0.0, 0.0], "higher");
    // The floor is on the first layer.
    scene.decals[0].layers = 0b110;
    assert_near(shown(&scene), [0.0, 0.0, 1.0], "another layer");
    scene.nodes[1].layers = 1 << 17 | 0b100;
    scene.decals[1].layers = 0b1001;
    assert_near(shown(&scene), [1.0, 0.0, 0.0], "its layers");
    scene.decals[0].layers = 1 << 17;
    assert_near(shown(&scene), [1.0, 0.0, 0.0], "a high layer");
    // Half way between 40° and 80° by the cosine.
    let cosine = 0.5 * (40.0f32.to_radians().cos() + 80.0f32.to_radians().cos());
    let direction = Vec3::new((1.0 - cosine * cosine).sqrt(), -cosine, 0.0);
    let mut slanted = placed(&red, Vec3::ZERO, direction, Vec3::new(2.0, 2.0, 4.0));
    slanted.angle_rad = Vec2::new(40.0f32.to_radians(), 80.0f32.to_radians());
    scene.decals = vec![slanted];
    assert_near(shown(&scene), [0.75, 0.25, 0.25], "between angles");
    // From below there is nothing.
    let mut below = down(&red, Vec3::ZERO);
    below.place(Vec3::ZERO, Vec3::Y, Vec3::NEG_Z, Vec3::ONE);
    below.angle_rad = Vec2::new(1.0, 1.4);
    scene.decals = vec![below];
    assert_near(shown(&scene), [0.5; 3], "from behind");
}

#[test]
fn many_over_each_other_are_all_there() {
    let mut scene = floor(grey(0.0));
    // More than are looked at at once.
    let count = 75;
    let mut expected = [0.0f32; 3];
    for at in 0..count {
        let share = at as f32 / count as f32;
        let color = Vec3::new(share, 1.0 - share, if at % 2 == 0 { 1.0 } else { 0.0 });
        let look = DecalLook {
            color,
            opacity: DecalOpacity { color: 0.1, ..DecalLook::default().opacity },
            ..DecalLook::default()
        };
        expected = std::array::from_fn(|channel| expected[channel] * 0.9 + color.to_array()[channel] * 0.1);
        // Not all hold every pixel.
        scene.decals.push(down(&look, Vec3::ZERO));
        scene.decals.push(down(&look, Vec3::new(0.9, 0.0, 0.0)));
    }
    let color = variable(&mut renderer(), &scene, &plain_request(&scene, SIZE), Aov::BaseColor);
    assert_near(on_floor(&color, Vec2::ZERO), expected, "all");
    assert_near(on_floor(&color, Vec2::new(0.9, 0.0)), expected, "all beside");
}

#[test]
fn every_path_shows_the_same() {
    let scene = demo::named("decals").unwrap();
    let mut renderer = renderer();
    let base = plain_request(&scene, (240, 135));
    let show = |renderer: &mut Renderer, scene: &Scene, path| {
        radiance(renderer, scene, &base.with(|settings| settings.render.path = path))
    };
    let deferred = show(&mut renderer, &scene, Path::Deferred);
    let bare = show(&mut renderer, &Scene { decals: Vec::new(), ..scene.clone() }, Path::Deferred);
    let mean: f32 = deferred.iter().flatten().sum::<f32>() / deferred.len() as f32 / 3.0;
    let differs =
        |a: &[f32; 3], b: &[f32; 3], by: f32| (0..3).any(|at| (a[at] - b[at]).abs() > by * (a[at].abs() + mean));
    let changed = deferred.iter().zip(&bare).filter(|(a, b)| differs(a, b, 0.02)).count();
    assert!(changed > deferred.len() / 25, "{changed} pixels show decals");
    for path in [Path::Forward, Path::ForwardBatched] {
        let forward = show(&mut renderer, &scene, path);
        let off = deferred.iter().zip(&forward).filter(|(a, b)| differs(a, b, 0.02)).count();
        assert!(off < deferred.len() / 400, "{off} of {} differ on {path:?}", deferred.len());
    }
    // Per vertex light has the colour of decals alone.
    let gouraud = show(&mut renderer, &scene, Path::Gouraud);
    let bare = show(&mut renderer, &Scene { decals: Vec::new(), ..scene.clone() }, Path::Gouraud);
    let changed_too = gouraud.iter().zip(&bare).filter(|(a, b)| differs(a, b, 0.02)).count();
    assert!(changed_too > changed / 2, "{changed_too} pixels show decals");
}

#[test]
fn variables_of_the_first_surface_have_them() {
    let mut scene = floor(Material { alpha_mode: AlphaMode::Blend, ..grey(0.5) });
    let red = DecalLook { color: Vec3::new(1.0, 0.0, 0.0), ..DecalLook::default() };
    scene.decals = vec![down(&red, Vec3::ZERO)];
    let request = plain_request(&scene, SIZE).with(|settings| settings.aov.first_surface = true);
    let color = variable(&mut renderer(), &scene, &request, Aov::BaseColor);
    assert_near(on_floor(&color, Vec2::ZERO), [1.0, 0.0, 0.0], "a blended surface");
    assert_near(on_floor(&color, Vec2::new(0.8, 0.0)), [0.5; 3], "beside it");
}

#[test]
fn what_nobody_sees_is_not_drawn() {
    let mut scene = floor(grey(0.5));
    let look = DecalLook::default();
    let mut renderer = renderer();
    let request = plain_request(&scene, SIZE);
    let mut passes = |scene: &Scene| {
        let plan = renderer.plan(scene, &request).unwrap();
        plan.passes.iter().filter(|pass| pass.name.starts_with("geometry.decals")).count()
    };
    // Without light nobody reads colours.
    let sun = Light { kind: LightKind::Directional, ..Light::default() };
    scene.lights.push(sun);
    scene.add_node(None, Node { light: Some(0), ..Node::default() });
    scene.update_transforms();
    scene.decals = vec![down(&look, Vec3::ZERO)];
    assert_eq!(passes(&scene), 2);
    scene.decals = vec![down(&look, Vec3::new(9.0, 0.0, 0.0))];
    assert_eq!(passes(&scene), 0, "beside the picture");
    scene.decals = vec![down(&look, Vec3::new(0.0, 1.5, 0.0))];
    assert_eq!(passes(&scene), 0, "it holds no surface");
}

#[test]
fn what_is_no_decal_is_left_out() {
    let mut scene = floor(grey(0.5));
    let red = DecalLook { color: Vec3::new(1.0, 0.0, 0.0), ..DecalLook::default() };
    let odd = DecalLook {
        color: Vec3::new(f32::NAN, 7.0, -1.0),
        roughness: f32::INFINITY,
        emission: Vec3::splat(f32::NAN),
        opacity: DecalOpacity { color: f32::NAN, normal: -1.0, roughness: 9.0, emission: 2.0 },
        ..DecalLook::default()
    };
    scene.decals = vec![
        Decal { parent_from_box: Mat4::from_scale(Vec3::new(1.0, 1.0, 0.0)), ..down(&red, Vec3::ZERO) },
        Decal { parent_from_box: Mat4::from_scale(Vec3::splat(f32::NAN)), ..down(&red, Vec3::ZERO) },
        Decal { angle_rad: Vec2::NAN, ..down(&odd, Vec3::new(1.2, 0.0, 0.0)) },
        // Without its shape.
        down(&DecalLook { color_image: Some(99), ..red.clone() }, Vec3::ZERO),
    ];
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    let warnings = renderer.warnings();
    assert_eq!(warnings.iter().filter(|warning| warning.contains("has no volume")).count(), 2, "{warnings:?}");
    let request = plain_request(&scene, SIZE);
    let color = variable(&mut renderer, &scene, &request, Aov::BaseColor);
    assert_near(on_floor(&color, Vec2::ZERO), [0.5; 3], "flat ones");
    assert!(color.iter().all(|value| value.is_finite() || *value == 0.0));
    // More than there may be: the first ones are shown.
    let look = Arc::new(red);
    let many = |at: usize| Decal {
        look: look.clone(),
        ..down(&look, Vec3::new((at % 60) as f32 * 0.1 - 3.0, 0.0, (at / 60) as f32 * 0.05 - 2.0))
    };
    scene.decals = (0..DECALS_MAX + 100).map(many).collect();
    renderer.load(&scene).unwrap();
    assert!(renderer.warnings().iter().any(|warning| warning.contains("4196 decals")));
    let color = variable(&mut renderer, &scene, &request, Aov::BaseColor);
    assert_near(on_floor(&color, Vec2::ZERO), [1.0, 0.0, 0.0], "many");
}

#[test]
fn a_sheared_box_is_thrown_along_its_own_direction() {
    let mut scene = floor(grey(0.5));
    let red = DecalLook { color: Vec3::new(1.0, 0.0, 0.0), ..DecalLook::default() };
    // Its depth leans: the plane of the picture faces another way than it is thrown.
    let lean = |x: f32, y: f32| Mat4 { z_axis: Vec3::new(x, y, 0.0).extend(0.0), ..Mat4::from_rotation_x(-0.5 * PI) };
    let angle_rad = Vec2::new(0.6, 0.9);
    let mut renderer = renderer();
    let request = plain_request(&scene, SIZE);
    for (matrix, expected) in [(lean(0.0, 1.0), [1.0, 0.0, 0.0]), (lean(2.0, 0.5), [0.5; 3])] {
        scene.decals = vec![Decal { angle_rad, ..decal(&red, matrix) }];
        let color = variable(&mut renderer, &scene, &request, Aov::BaseColor);
        assert_near(on_floor(&color, Vec2::ZERO), expected, "thrown along its depth");
    }
}

#[test]
fn mirrors_and_moving_nodes_show_them() {
    let mut scene = floor(grey(0.5));
    let red = DecalLook { color: Vec3::new(1.0, 0.0, 0.0), ..DecalLook::default() };
    let carrier = scene.add_node(None, Node::default());
    scene.decals = vec![Decal { node: Some(carrier), ..down(&red, Vec3::ZERO) }];
    let mut renderer = renderer();
    let mut request = plain_request(&scene, SIZE);
    for x in [-1.0, 0.5] {
        scene.node_mut(carrier).translation = Vec3::new(x, 0.0, 0.0);
        scene.update_transforms();
        let color = variable(&mut renderer, &scene, &request, Aov::BaseColor);
        assert_near(on_floor(&color, Vec2::new(x, 0.0)), [1.0, 0.0, 0.0], "where the node is");
        assert_near(on_floor(&color, Vec2::new(x - 0.7, 0.0)), [0.5; 3], "where it is not");
    }
    // A camera that sees the world mirrored.
    let world_from_view = request.camera.world_from_view * Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    request.camera = View { world_from_view, ..request.camera };
    let color = variable(&mut renderer, &scene, &request, Aov::BaseColor);
    assert_near(on_floor(&color, Vec2::new(-0.5, 0.0)), [1.0, 0.0, 0.0], "mirrored");
}

#[test]
fn the_floor_plans_decals() {
    let scene = demo::named("decals").unwrap();
    let mut renderer = Renderer::new(Gpu::without_adapter(Floor::WebGl2).unwrap()).unwrap();
    let plan = renderer.plan(&scene, &FrameRequest::of_scene(&scene, 320, 180)).unwrap();
    assert!(plan.passes.iter().any(|pass| pass.name == "geometry.decals"));
}
