use super::*;
use crate::primitives::{cube, torus, uv_sphere};
use crate::{Animation, Channel, Interpolation, Keyframes, Material, Mesh, Node, Primitive, Topology};
use glam::Vec2;

const LENSES: [Vec2; 3] = [Vec2::new(0.7, 0.4), Vec2::new(0.2, 0.4), Vec2::splat(0.5)];

/// Points that look random, in an oblong far from the origin.
fn points(count: u32) -> Vec<Vec3> {
    let unit = |i: u32, step: f32| (i as f32 * step).fract() - 0.5;
    let point = |i| Vec3::new(9.0 * unit(i, 0.754_877), 2.0 * unit(i, 0.569_84), 4.0 * unit(i, 0.430_16));
    (0..count).map(|i| point(i) + Vec3::new(50.0, -3.0, 7.0)).collect()
}

/// The smallest and the largest place of points in the picture, whose sides are at −1 and 1.
fn extent(points: &[Vec3], eye: Vec3, rotation: Quat, half_extent: Vec2) -> (Vec2, Vec2) {
    points.iter().fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(low, high), point| {
        let place = rotation.inverse() * (*point - eye);
        assert!(place.z < 0.0, "{point} is behind the camera");
        let ndc = Vec2::new(place.x, place.y) / -place.z / half_extent;
        (low.min(ndc), high.max(ndc))
    })
}

fn scene_of(primitives: Vec<Primitive>) -> Scene {
    let mut scene = Scene { meshes: vec![Mesh { primitives, ..Mesh::default() }.into()], ..Scene::default() };
    scene.add_node(None, Node { mesh: Some(0), ..Node::default() });
    scene.update_transforms();
    scene
}

#[test]
fn margins_are_equal_and_of_the_stated_width() {
    let points = points(500);
    let framing = Framing::of_points(points.clone());
    for (yaw_deg, pitch_deg) in [(0.0, 0.0), (30.0, 20.0), (170.0, -70.0), (90.0, 90.0)] {
        for half_extent in LENSES {
            let rotation = orbit_rotation(yaw_deg, pitch_deg, Vec3::Y);
            let eye = framing.fit().eye(rotation, half_extent);
            let (low, high) = extent(&points, eye, rotation, half_extent);
            assert!((low + high).abs().max_element() < 1e-4, "off-centre: {low} {high}");
            assert!((high.max_element() - (1.0 - 2.0 * MARGIN)).abs() < 1e-4, "{high}");
            let target = framing.center_world();
            let eye = target + rotation * Vec3::Z * framing.fit().distance_m(target, rotation, half_extent);
            let (low, high) = extent(&points, eye, rotation, half_extent);
            assert!((high.max(-low).max_element() - (1.0 - 2.0 * MARGIN)).abs() < 1e-4, "{low} {high}");
            let eye = framing.fit().eye_of_parallel_rays(rotation);
            let places = points.iter().map(|point| rotation.inverse() * (*point - eye));
            let bounds = Aabb::from_points(places);
            assert!(bounds.center().truncate().abs().max_element() < 1e-4 && bounds.max.z < 0.0, "{bounds:?}");
        }
    }
}

#[test]
fn one_place_does_for_every_yaw_of_a_turntable() {
    let points = points(60);
    let framing = Framing::of_points(points.clone());
    for (pitch_deg, up) in [(0.0, Vec3::Y), (20.0, Vec3::Y), (-50.0, Vec3::new(1.0, 2.0, -1.0).normalize())] {
        for half_extent in LENSES {
            let on_axis = framing.center_world();
            let fit = framing.turning(on_axis, up);
            let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
            let first = fit.eye(orbit_rotation(0.0, pitch_deg, up), half_extent);
            let arm = first - on_axis;
            for yaw_deg in (0..720).map(|i| 0.5 * i as f32) {
                let rotation = orbit_rotation(yaw_deg, pitch_deg, up);
                let eye = fit.eye(rotation, half_extent);
                let turned = on_axis + Quat::from_axis_angle(up, yaw_deg.to_radians()) * arm;
                assert!(eye.distance(turned) < 1e-3, "{yaw_deg}: {eye} is not {turned}");
                let seen = extent(&points, turned, rotation, half_extent);
                (low, high) = (low.min(seen.0), high.max(seen.1));
            }
            let reach = high.max(-low).max_element();
            assert!((reach - (1.0 - 2.0 * MARGIN)).abs() < 1e-3, "{low} {high}");
            assert!((low + high).abs().max_element() < 2e-3, "off-centre: {low} {high}");
        }
    }
}

#[test]
fn nothing_thin_tiny_huge_or_broken_is_lost() {
    let rotation = orbit_rotation(30.0, 20.0, Vec3::Y);
    let back = rotation * Vec3::Z;
    let right = rotation * Vec3::X;
    let bad = [Vec3::NAN, Vec3::INFINITY, Vec3::splat(3e38)];
    let shapes: [(&str, Vec<Vec3>); 6] = [
        ("a point", vec![Vec3::new(4.0, 5.0, 6.0)]),
        ("a needle that points at the camera", vec![Vec3::ZERO, back]),
        ("a plane seen edge-on", vec![Vec3::ZERO, back, right, right + back]),
        ("a line across", vec![Vec3::ZERO, right]),
        ("broken vertices", [&bad[..], &[Vec3::ZERO, Vec3::ONE]].concat()),
        ("a cone with the camera's own angle", vec![back, right * 0.3, -right * 0.3]),
    ];
    for (name, points) in shapes {
        for scale in [1e-6, 1.0, 1e6] {
            let points: Vec<Vec3> = points.iter().map(|point| *point * scale).collect();
            let framing = Framing::of_points(points.clone());
            let eye = framing.fit().eye(rotation, LENSES[0]);
            let sound: Vec<Vec3> = points.into_iter().filter(|point| point.abs().max_element() < 1e18).collect();
            let (low, high) = extent(&sound, eye, rotation, LENSES[0]);
            assert!(low.min_element() > -0.9 && high.max_element() < 0.9, "{name}: {low} {high}");
            let near_m = framing.fit().near_m(eye, rotation);
            let nearest_m = sound.iter().map(|point| back.dot(eye - *point)).fold(f32::INFINITY, f32::min);
            assert!(near_m > 0.0 && near_m < nearest_m, "{name}: {near_m} {nearest_m}");
        }
    }
    let nothing = Framing::of_scene(&Scene::default());
    let (world_from_view, _) = nothing.automatic(1.5);
    let distance_m = world_from_view.w_axis.truncate().length();
    assert!(distance_m > 1.0 && distance_m < 10.0 && nothing.bounds_world().is_empty(), "{distance_m}");
}

#[test]
fn vertices_that_no_index_names_are_not_framed() {
    let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [100.0; 3]];
    let bounds = Aabb::from_points(positions.iter().map(|position| Vec3::from(*position)));
    let scene = scene_of(vec![Primitive { positions, bounds, indices: vec![0, 1, 2], ..Primitive::default() }]);
    assert_eq!(Framing::of_scene(&scene).bounds_world().max, Vec3::new(1.0, 1.0, 0.0));
}

#[test]
fn an_animation_is_framed_over_all_of_its_time() {
    let mut scene = scene_of(vec![cube(Vec3::ONE)]);
    scene.add_node(None, Node { mesh: Some(0), translation: Vec3::NEG_Y, ..Node::default() });
    let keyframes = Keyframes::Translation(vec![Vec3::ZERO, Vec3::X * 20.0, Vec3::ZERO]);
    let times_secs = vec![1.0, 2.0, 3.0];
    let channel = Channel { node: crate::NodeId(0), times_secs, interpolation: Interpolation::Linear, keyframes };
    scene.animations.push(Animation { name: "there and back".into(), channels: vec![channel], ..Animation::default() });
    scene.node_mut(crate::NodeId(0)).translation = Vec3::new(0.0, 5.0, 0.0);
    scene.update_transforms();
    let before = scene.nodes.clone();
    let framing = Framing::of_animation(&mut scene, 0);
    assert_eq!(scene.nodes, before);
    // The box in its rest pose, at a height of 5 m, is never drawn.
    let Aabb { min, max } = *framing.bounds_world();
    assert_eq!((min, max.y), (Vec3::new(-0.5, -1.5, -0.5), 0.5));
    assert!(max.x > 19.0 && max.x <= 20.5, "{max}");
    assert_eq!(Framing::of_animation(&mut scene, 1).bounds_world().max.y, 5.5);
    assert_eq!(Framing::of_scene(&scene).bounds_world().max.y, 5.5);
}

/// The primitive with its inside turned out.
fn turned_in(mut primitive: Primitive) -> Primitive {
    primitive.indices.chunks_exact_mut(3).for_each(|triangle| triangle.swap(1, 2));
    primitive.normals.iter_mut().flatten().for_each(|value| *value = -*value);
    primitive
}

/// What is closed but for its top.
fn without_roof(mut primitive: Primitive) -> Primitive {
    let is_roof = |triangle: &[u32]| {
        let height = |index: &u32| primitive.positions[*index as usize][1];
        let top = primitive.bounds.max.y;
        triangle.iter().all(|index| height(index) >= top)
    };
    primitive.indices = primitive.indices.chunks_exact(3).filter(|t| !is_roof(t)).flatten().copied().collect();
    primitive
}

fn moved(mut primitive: Primitive, by: Vec3) -> Primitive {
    primitive.positions.iter_mut().for_each(|position| *position = (Vec3::from(*position) + by).to_array());
    primitive.bounds = Aabb { min: primitive.bounds.min + by, max: primitive.bounds.max + by };
    primitive
}

/// A box with walls of two sides.
fn with_outside(size_m: Vec3) -> Vec<Primitive> {
    vec![turned_in(cube(0.98 * size_m)), cube(size_m)]
}

/// Boxes on the floor of [`with_outside`].
fn furniture(count: usize, size_m: Vec3) -> Vec<Primitive> {
    let side_m = 0.2 * size_m.x;
    let height_m = 0.5 * side_m - 0.485 * size_m.y;
    let places = [(0.35, 0.28), (-0.35, 0.28), (0.35, -0.28), (-0.35, -0.28), (0.0, -0.28)];
    let at = |(x, z): (f32, f32)| moved(cube(Vec3::splat(side_m)), Vec3::new(x * size_m.x, height_m, z * size_m.z));
    places.into_iter().take(count).map(at).collect()
}

#[test]
fn rooms_are_seen_from_inside_and_solids_and_vessels_from_outside() {
    let (size_m, high_m) = (Vec3::new(4.0, 3.0, 9.0), Vec3::new(4.0, 6.0, 5.0));
    let double_sided = |inside: Primitive| {
        let mut scene = scene_of(vec![Primitive { material: Some(0), ..inside }]);
        scene.materials.push(Material { double_sided: true, ..Material::default() });
        scene
    };
    let court = |size_m: Vec3| with_outside(size_m).into_iter().map(without_roof).collect::<Vec<_>>();
    let furnished = |walls: Vec<Primitive>, count, size_m| scene_of([walls, furniture(count, size_m)].concat());
    // Boards that line the walls, of which each is a piece that nothing outside shows.
    let lining = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z].map(|side| {
        let board_m = 0.9 * size_m * (Vec3::ONE - 0.99 * side.abs());
        moved(cube(board_m), 0.46 * size_m * side)
    });
    let mut mirrored = scene_of(vec![cube(size_m)]);
    mirrored.node_mut(crate::NodeId(0)).scale = Vec3::new(-1.0, 1.0, 1.0);
    mirrored.node_mut(crate::NodeId(0)).matrix = None;
    mirrored.update_transforms();
    let scenes = [
        ("a room", scene_of(vec![turned_in(cube(size_m))]), true),
        ("a small room without an outside", scene_of(vec![turned_in(cube(0.1 * size_m))]), true),
        ("a house", furnished(with_outside(size_m), 5, size_m), true),
        ("a dolls' house", furnished(with_outside(0.1 * size_m), 5, 0.1 * size_m), true),
        ("a court", furnished(court(high_m), 5, high_m), true),
        ("a box with little in it", furnished(with_outside(size_m), 4, size_m), false),
        ("a hollow box", scene_of(with_outside(size_m)), false),
        ("a lined box", scene_of([with_outside(size_m), lining.to_vec()].concat()), false),
        ("a room with walls of both sides", double_sided(turned_in(cube(size_m))), true),
        ("a box", scene_of(vec![cube(size_m)]), false),
        ("a box with walls of both sides", double_sided(cube(size_m)), false),
        ("a mirrored box", mirrored, false),
        ("a sphere", scene_of(vec![uv_sphere(3.0, 32, 16)]), false),
        ("a ring", scene_of(vec![torus(3.0, 1.0, 32, 16)]), false),
        ("a vessel", scene_of(court(0.1 * high_m)), false),
        ("a floor", scene_of(vec![crate::primitives::plane(50.0)]), false),
    ];
    for (name, scene, is_room) in scenes {
        let framing = Framing::of_scene(&scene);
        assert_eq!(framing.interior().is_some(), is_room, "{name}");
        let Some(interior) = framing.interior() else { continue };
        assert_eq!(framing.automatic(1.5), (interior.world_from_view, interior.projection));
        let (eye, back) = (interior.world_from_view.w_axis.truncate(), interior.world_from_view.z_axis.truncate());
        let size_m = framing.bounds_world().max - framing.bounds_world().min;
        assert!(eye.abs().cmplt(0.5 * size_m).all(), "{name}: {eye} is outside");
        assert!(back.z.abs() > 0.8 && eye.z * back.z > 0.25 * size_m.z, "{name}: {eye}, looking along {}", -back);
    }
}

/// What a closed line of radii and heights encloses, turned around the Y axis; the line goes up outside.
fn turned(line: &[[f32; 2]]) -> Primitive {
    const AROUND: usize = 24;
    let place = |i: usize| {
        let [radius_m, height_m] = line[i / AROUND];
        let (sin, cos) = (std::f32::consts::TAU * (i % AROUND) as f32 / AROUND as f32).sin_cos();
        [radius_m * cos, height_m, radius_m * sin]
    };
    let positions: Vec<[f32; 3]> = (0..line.len() * AROUND).map(place).collect();
    let quad = |i: usize| {
        let after = i - i % AROUND + (i + 1) % AROUND;
        [i, i + AROUND, after + AROUND, i, after + AROUND, after].map(|index| index as u32)
    };
    let indices = (0..(line.len() - 1) * AROUND).flat_map(quad).collect();
    let bounds = Aabb::from_points(positions.iter().map(|position| Vec3::from(*position)));
    Primitive { positions, bounds, indices, ..Primitive::default() }
}

/// The corners of all triangles.
fn corners(primitives: &[Primitive]) -> Vec<[f32; 3]> {
    let of = |primitive: &Primitive| -> Vec<[f32; 3]> {
        primitive.indices.iter().map(|index| primitive.positions[*index as usize]).collect()
    };
    primitives.iter().flat_map(of).collect()
}

fn obj(primitives: &[Primitive]) -> String {
    let corners = corners(primitives);
    let vertices: String = corners.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    let face = |i: usize| format!("f {} {} {}\n", 3 * i + 1, 3 * i + 2, 3 * i + 3);
    vertices + &(0..corners.len() / 3).map(face).collect::<String>()
}

/// Z points up there.
fn stl(primitives: &[Primitive]) -> String {
    let vertex = |[x, y, z]: &[f32; 3]| format!("vertex {x} {} {y}\n", -z);
    let facet = |corners: &[[f32; 3]]| {
        let loop_of: String = corners.iter().map(vertex).collect();
        format!("facet normal 0 0 0\nouter loop\n{loop_of}endloop\nendfacet\n")
    };
    format!("solid a\n{}endsolid a\n", corners(primitives).chunks(3).map(facet).collect::<String>())
}

#[test]
fn vessels_of_every_size_and_format_are_seen_from_outside() {
    let mug = turned(&[[0.0, 0.0], [0.4, 0.0], [0.4, 1.0], [0.36, 1.0], [0.36, 0.05], [0.0, 0.05]]);
    let spoon = moved(cube(Vec3::new(0.05, 0.6, 0.02)), Vec3::new(0.2, 0.4, 0.1));
    let vase = [[0.0, 0.0], [0.2, 0.0], [0.45, 0.5], [0.25, 1.0], [0.22, 1.0], [0.42, 0.5], [0.18, 0.05], [0.0, 0.05]];
    let bottle = [
        [[0.0, 0.0], [0.3, 0.0], [0.3, 0.6], [0.1, 0.75], [0.1, 1.0]],
        [[0.08, 1.0], [0.08, 0.75], [0.27, 0.58], [0.27, 0.03], [0.0, 0.03]],
    ];
    let crate_m = Vec3::new(1.0, 1.0, 1.2);
    let crate_walls = with_outside(crate_m).into_iter().map(without_roof);
    let lid = moved(cube(Vec3::new(0.5, 0.01, 1.2)), Vec3::new(0.25, 0.51, 0.0));
    let vessels = [
        ("a mug", vec![mug.clone()]),
        ("a mug with a spoon", vec![mug, spoon]),
        ("a vase", vec![turned(&vase)]),
        ("a bottle", vec![turned(&bottle.concat())]),
        ("a crate with half a lid", crate_walls.chain([lid]).collect()),
        ("a hollow ball", vec![uv_sphere(0.5, 24, 12), turned_in(uv_sphere(0.47, 24, 12))]),
    ];
    let read = |text: &str, name: &str| crate::load_bytes(text.as_bytes(), &mut |_| Err("none".into()), name).unwrap();
    for (name, primitives) in vessels {
        // A millimetre, a hand's breadth in metres, centimetres and millimetres, and a kilometre.
        for scale in [0.001, 0.1, 10.0, 100.0, 1000.0] {
            let scaled = |primitive: &Primitive| {
                let positions = primitive.positions.iter().map(|position| position.map(|value| scale * value));
                let bounds = Aabb { min: scale * primitive.bounds.min, max: scale * primitive.bounds.max };
                Primitive { positions: positions.collect(), bounds, ..primitive.clone() }
            };
            let primitives: Vec<Primitive> = primitives.iter().map(scaled).collect();
            let (obj, stl) = (read(&obj(&primitives), "a.obj").scene, read(&stl(&primitives), "a.stl").scene);
            for (format, scene) in [("meshes", scene_of(primitives)), ("OBJ", obj), ("STL", stl)] {
                let framing = Framing::of_scene(&scene);
                assert!(framing.interior().is_none(), "{name} at {scale} as {format}");
                let height_m = framing.bounds_world().max.y - framing.bounds_world().min.y;
                assert!((0.9..1.1).contains(&(height_m / scale)), "{name} at {scale} as {format}: {height_m}");
            }
        }
    }
}

#[test]
fn a_scene_with_a_camera_has_no_other() {
    let mut scene = scene_of(vec![turned_in(cube(Vec3::splat(4.0)))]);
    let projection = Projection::Perspective { fov_y_rad: 1.0, near_m: 0.1, far_m: None };
    scene.cameras.push(crate::Camera { name: String::new(), projection, aspect: None });
    scene.add_node(None, Node { camera: Some(0), ..Node::default() });
    scene.update_transforms();
    assert!(Framing::of_scene(&scene).interior().is_none());
}

/// Points that a scene draws as such.
fn cloud(points: &[Vec3]) -> Primitive {
    let positions = points.iter().map(|point| point.to_array()).collect();
    let bounds = Aabb::from_points(points.iter().copied());
    Primitive { topology: Topology::Points, positions, bounds, ..Primitive::default() }
}

#[test]
fn outliers_of_a_cloud_are_not_framed() {
    let model = points(5000);
    let bounds = Aabb::from_points(model.iter().copied());
    let heap = |count: u16| (0..count).map(|i| Vec3::new(1000.0 + f32::from(i), 0.0, 0.0)).collect::<Vec<_>>();
    let with = |outliers: &[Vec3]| [&model[..], outliers].concat();
    let framing = Framing::of_scene(&scene_of(vec![cloud(&with(&heap(5)))]));
    assert_eq!(
        (*framing.bounds_world(), framing.automatic(1.5)),
        (bounds, Framing::of_points(model.clone()).automatic(1.5))
    );
    let outliers = *framing.outliers().expect("outliers");
    assert_eq!((outliers.count, outliers.bounds_world.max.x), (5, 1004.0));
    assert!(framing.far_m(Vec3::new(-100.0, 0.0, 0.0)) > 1104.0);
    // More than a thousandth of the points, and points in a scene with surfaces, are no outliers.
    for primitives in [vec![cloud(&with(&heap(6)))], vec![cloud(&with(&heap(5))), cube(Vec3::ONE)]] {
        let framing = Framing::of_scene(&scene_of(primitives));
        assert!(framing.outliers().is_none() && framing.bounds_world().max.x > 1003.0, "{:?}", framing.bounds_world());
    }
    let scenes = [scene_of(vec![cloud(&with(&heap(1)))]), scene_of(vec![cube(Vec3::ONE)])];
    assert!(Framing::of_scenes(&[&scenes[0], &scenes[0]]).outliers().is_some_and(|outliers| outliers.count == 2));
    assert!(Framing::of_scenes(&[&scenes[0], &scenes[1]]).outliers().is_none());
}

#[test]
fn masts_of_a_clean_cloud_are_framed() {
    let model = points(40_000);
    let bounds = Aabb::from_points(model.iter().copied());
    assert!(Framing::of_scene(&scene_of(vec![cloud(&model)])).outliers().is_none());
    let mast: Vec<Vec3> =
        (1..=40u16).map(|i| bounds.center() + Vec3::new(0.0, 1.0 + 0.6 * f32::from(i), 0.0)).collect();
    let whole = Aabb::from_points([&model[..], &mast[..]].concat());
    assert!(whole.radius_m() > 2.0 * bounds.radius_m());
    let framed = |points: &[Vec3]| *Framing::of_scene(&scene_of(vec![cloud(points)])).bounds_world();
    assert_eq!(framed(&[&model[..], &mast[..]].concat()), whole);
    // Its top alone is an outlier.
    assert_eq!(framed(&[&model[..], &mast[39..]].concat()), bounds);
}
