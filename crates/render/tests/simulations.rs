//! Simulations: what physics says of those that are built in, that a state follows from its time alone, and what is said
//! of those that cannot be run.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{plain_request, renderer};
use glam::{Vec2, Vec3};
use manypass::{Renderer, SimulationFile};
use manypass_scene::framing::look_along;
use manypass_scene::primitives::{cube, plane};
use manypass_scene::simulation::Simulation;
use manypass_scene::{
    Animation, Camera, Channel, Image, Interpolation, Keyframes, Material, Mesh, Node, NodeId, Primitive, Projection,
    Sampler, Scene, ShadingModel, Texture, TextureRef,
};
use std::f32::consts::PI;

const SIDE: u32 = 128;

fn with(simulation: Simulation) -> Scene {
    Scene { simulations: vec![simulation], ..Scene::default() }
}

fn ripples() -> Simulation {
    Simulation { cells: Some((SIDE, SIDE)), ..Simulation::built_in("pond", "ripples") }
}

/// The state of a scene's only simulation at a time.
fn state_at(renderer: &mut Renderer, scene: &mut Scene, (state, time_secs): (&str, f32)) -> Vec<[f32; 4]> {
    scene.time_secs = time_secs;
    renderer.simulate(scene, &mut |_| true).unwrap();
    renderer.read_simulation(0, state).unwrap().unwrap()
}

/// The energy of waves on a square of 1 m, but for the density of water.
fn energy(water: &[[f32; 4]], speed_m_s: f32) -> f64 {
    let side = SIDE as usize;
    let cell_m = 1.0 / side as f64;
    let height = |x: usize, y: usize| f64::from(water[y * side + x][0]);
    let mut sum = 0.0;
    for y in 0..side {
        for x in 0..side {
            let is_wall = |x: usize, y: usize| water[y * side + x][3] != 0.0;
            let rise = f64::from(water[y * side + x][1]);
            sum += rise * rise;
            for (other, is_within) in [((x + 1, y), x + 1 < side), ((x, y + 1), y + 1 < side)] {
                if is_within && !is_wall(x, y) && !is_wall(other.0, other.1) {
                    let slope = (height(other.0, other.1) - height(x, y)) / cell_m;
                    sum += f64::from(speed_m_s).powi(2) * slope * slope;
                }
            }
        }
    }
    0.5 * sum * cell_m * cell_m
}

#[test]
fn energy_of_waves_falls_as_the_damping_says() {
    let mut renderer = renderer();
    for damping in [0.0f32, 0.5] {
        let wave =
            ripples().with("first_m", "0.05").with("drop_m", "0.04").with("speed_m_s", "1").with("viscosity_m2_s", "0");
        let mut scene = with(Simulation {
            rate_hz: Some(1000.0),
            ..wave.with("first_place", "0.31,0.43").with("damping_per_s", &damping.to_string())
        });
        let first = energy(&state_at(&mut renderer, &mut scene, ("water", 0.0)), 1.0);
        assert!(first > 1e-4, "{first}");
        for time_secs in [0.5, 1.0, 2.0] {
            let now = energy(&state_at(&mut renderer, &mut scene, ("water", time_secs)), 1.0);
            let expected = f64::from((-damping * time_secs).exp());
            let found = now / first;
            assert!((found / expected - 1.0).abs() < 0.01, "{found} of {expected} after {time_secs} s at {damping}");
        }
    }
}

#[test]
fn waves_reach_a_wall_when_their_speed_says() {
    let mut renderer = renderer();
    // A wave along one side: a strip of water.
    let strip = Simulation { cells: Some((512, 1)), ..ripples() };
    let strip = strip
        .with("first_m", "0.01")
        .with("drop_m", "0.02")
        .with("damping_per_s", "0")
        .with("speed_m_s", "0.4")
        .with("viscosity_m2_s", "0");
    let mut scene = with(strip.with("first_place", "0.25,0.5"));
    // The middle of the hill is at 0.25 m; half of it goes to the right, and is doubled where the wall throws it back.
    let mut highest = (0.0, 0.0f32);
    for frame in 0..240 {
        let time_secs = 1.0 + frame as f32 / 120.0;
        let water = state_at(&mut renderer, &mut scene, ("water", time_secs));
        if water[511][0] > highest.1 {
            highest = (time_secs, water[511][0]);
        }
    }
    let expected = 0.75 / 0.4;
    assert!((highest.0 / expected - 1.0).abs() < 0.01, "{} s, and {expected} are expected", highest.0);
    assert!((highest.1 / 0.01 - 1.0).abs() < 0.02, "{} m", highest.1);
}

#[test]
fn bodies_of_another_animation_have_come_another_way() {
    let mut renderer = renderer();
    let (mut scene, _) = basin(1.0);
    let posed = state_at(&mut renderer, &mut scene, ("water", 1.0));
    // As it stands before anything is posed, the ball is in the middle of the water.
    scene.posed = None;
    scene.node_mut(NodeId(1)).translation = Vec3::ZERO;
    let stands = state_at(&mut renderer, &mut scene, ("water", 0.0));
    assert!(stands.iter().any(|cell| cell[2] > 0.1) && stands.iter().all(|cell| cell[0] == 0.0));
    scene.pose(0, 1.0);
    scene.update_transforms();
    assert!(state_at(&mut renderer, &mut scene, ("water", 1.0)) == posed);
}

/// A scene with a plate of 2 m, a ball that goes through its middle, and a post.
fn basin(time_secs: f32) -> (Scene, NodeId) {
    let mut scene = Scene::default();
    scene.meshes.push(Mesh { primitives: vec![plane(2.0)], ..Mesh::default() }.into());
    scene.meshes.push(Mesh { primitives: vec![cube(Vec3::ONE)], ..Mesh::default() }.into());
    let plate = scene.add_node(None, Node { mesh: Some(0), ..Node::default() });
    let ball = Node { mesh: Some(1), scale: Vec3::splat(0.4), ..Node::default() };
    let ball = scene.add_node(None, ball);
    let post =
        Node { mesh: Some(1), translation: Vec3::new(0.5, 0.0, 0.3), scale: Vec3::splat(0.3), ..Node::default() };
    let post = scene.add_node(None, post);
    scene.animations.push(Animation {
        channels: vec![Channel {
            node: ball,
            times_secs: vec![0.0, 2.0],
            interpolation: Interpolation::Linear,
            keyframes: Keyframes::Translation(vec![Vec3::new(-0.5, 0.3, 0.0), Vec3::new(-0.1, -0.05, 0.0)]),
        }],
        ..Animation::default()
    });
    scene.simulations =
        vec![Simulation { place: Some(plate), bodies: vec![ball], walls: vec![post], ..ripples().with("push", "1") }];
    scene.pose(0, time_secs);
    scene.update_transforms();
    (scene, plate)
}

#[test]
fn bodies_push_aside_as_much_water_as_they_take_and_walls_keep_it_out() {
    let mut renderer = renderer();
    let (mut scene, _) = basin(0.0);
    let before = state_at(&mut renderer, &mut scene, ("water", 0.0));
    assert!(before.iter().all(|cell| cell[2] == 0.0), "the ball is above the water at first");
    let after = state_at(&mut renderer, &mut scene, ("water", 2.0));
    let sum = |part: usize| after.iter().map(|cell| f64::from(cell[part])).sum::<f64>();
    let cell_m2 = (2.0 / f64::from(SIDE)).powi(2);
    // A sphere of 0.2 m whose middle is 0.05 m below the surface: half of it and a slice.
    let (radius, depth) = (0.2f64, 0.05f64);
    let expected =
        2.0 / 3.0 * f64::from(PI) * radius.powi(3) + f64::from(PI) * (radius * radius * depth - depth.powi(3) / 3.0);
    assert!((sum(2) * cell_m2 / expected - 1.0).abs() < 0.02, "{} of {expected} m³", sum(2) * cell_m2);
    assert!((sum(0) / sum(2) - 1.0).abs() < 1e-3, "{} and {}", sum(0), sum(2));
    let walls = after.iter().filter(|cell| cell[3] != 0.0);
    let (count, is_dry) = walls.fold((0, true), |(count, is_dry), cell| (count + 1, is_dry && cell[0] == 0.0));
    // 0.3 m a side, of cells of 2 m / 128.
    assert!(is_dry && (18 * 18..=20 * 20).contains(&count), "{count} cells of wall");
    // They are where the post is: to the right, and to where +Z goes.
    let place = scene.place_of_simulation(0);
    let post = place.world_from_place.inverse().transform_point3(Vec3::new(0.5, 0.0, 0.3));
    let at = (Vec2::new(post.x, -post.y) / 2.0 + 0.5) * SIDE as f32;
    assert!(after[at.y as usize * SIDE as usize + at.x as usize][3] != 0.0, "{at}");
}

#[test]
fn a_fluid_loses_nothing_but_what_its_pressure_states() {
    let mut renderer = renderer();
    let left_with = |renderer: &mut Renderer, iterations: &str| {
        let fluid = Simulation { cells: Some((64, 96)), ..Simulation::built_in("smoke", "fluid") };
        let mut scene = with(fluid.with("iterations", iterations));
        let flow = state_at(renderer, &mut scene, ("flow", 2.0));
        let pressure = renderer.read_simulation(0, "pressure").unwrap().unwrap();
        let at = |x: usize, y: usize, part: usize| {
            if x < 64 && y < 96 { f64::from(flow[y * 64 + x][part]) } else { 0.0 }
        };
        let (mut left, mut stated, mut speed) = (0.0, 0.0, 0.0);
        for (x, y) in (0..96).flat_map(|y| (0..64).map(move |x| (x, y))) {
            let leaving = (at(x + 1, y, 0) - at(x, y, 0)) * 64.0 + (at(x, y + 1, 1) - at(x, y, 1)) * 96.0;
            left += leaving * leaving;
            stated += f64::from(pressure[y * 64 + x][1]).powi(2);
            speed += (at(x, y, 0) * 64.0).powi(2) + (at(x, y, 1) * 96.0).powi(2);
        }
        assert!(speed > 1e3, "nothing flows: {speed}");
        // What is stated is of the pressure before the last iteration.
        assert!(left <= stated * 1.001 && left > 0.5 * stated, "{left} is left, and {stated} stated");
        (left / speed).sqrt()
    };
    let few = left_with(&mut renderer, "10");
    let many = left_with(&mut renderer, "64");
    assert!(many < 0.01 && many < 0.5 * few, "{many} with 64 iterations, {few} with 10");
}

#[test]
fn a_state_follows_from_its_time_alone() {
    let (mut one, mut other) = (renderer(), renderer());
    let rain = || with(ripples().with("drops_per_s", "40").with("drop_depth_m", "0.02"));
    let (mut scene, mut again) = (rain(), rain());
    for frame in 0..=48 {
        state_at(&mut one, &mut scene, ("water", frame as f32 / 24.0));
    }
    let at_once = state_at(&mut other, &mut again, ("water", 2.0));
    let in_frames = state_at(&mut one, &mut scene, ("water", 2.0));
    assert!(at_once == in_frames && at_once.iter().any(|cell| cell[0].abs() > 1e-4));
    // Back in time it begins anew; another seed is another course.
    let back = state_at(&mut one, &mut scene, ("water", 0.5));
    assert!(back == state_at(&mut other, &mut again, ("water", 0.5)) && back != at_once);
    again.simulations[0].seed = 1;
    assert!(state_at(&mut other, &mut again, ("water", 2.0)) != at_once);
}

/// Ground of 2 by 1.6 metres over which a cube slides from left to right in two seconds, 4 mm above it, and a camera below.
fn slide() -> Scene {
    let mut scene = Scene::default();
    for primitive in [plane(2.0), cube(Vec3::splat(0.2))] {
        scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() }.into());
    }
    let scale = Vec3::new(1.0, 1.0, 0.8);
    let ground = scene.add_node(None, Node { mesh: Some(0), scale, ..Node::default() });
    let at = |x: f32| Vec3::new(x, 0.104, 0.2);
    let sled = scene.add_node(None, Node { mesh: Some(1), translation: at(-0.5), layers: 2, ..Node::default() });
    let projection = Projection::Orthographic { height_m: 2.0, near_m: 0.01, far_m: 5.0 };
    scene.cameras.push(Camera { name: String::new(), projection, aspect: None });
    let rotation = look_along(Vec3::Y, Vec3::NEG_Z).unwrap();
    let below = Node { camera: Some(0), translation: -Vec3::Y, rotation, ..Node::default() };
    let below = scene.add_node(None, below);
    scene.animations.push(Animation {
        channels: vec![Channel {
            node: sled,
            times_secs: vec![0.0, 2.0],
            interpolation: Interpolation::Linear,
            keyframes: Keyframes::Translation(vec![at(-0.5), at(0.5)]),
        }],
        ..Animation::default()
    });
    let trails = Simulation { cells: Some((SIDE, SIDE)), ..Simulation::built_in("trails", "trails") };
    scene.simulations = vec![Simulation { place: Some(ground), sees: Some(below), layers: 2, ..trails }];
    scene.pose(0, 0.0);
    scene.update_transforms();
    scene
}

#[test]
fn trails_are_as_deep_as_what_a_camera_below_sees() {
    let mut renderer = renderer();
    let mut scene = slide();
    let cell = |x: f32, z: f32| {
        let index = |at: f32| ((at + 1.0) * 0.5 * SIDE as f32) as usize;
        index(z / 0.8) * SIDE as usize + index(x)
    };
    // Half way: where it was and is, the ground is pressed to where it sinks, 12 mm below its underside.
    let ground = state_at(&mut renderer, &mut scene, ("ground", 1.0));
    for (place, expected) in
        [((-0.5, 0.2), 0.008), ((0.0, 0.2), 0.008), ((0.3, 0.2), 0.0), ((0.0, -0.2), 0.0), ((0.0, 0.35), 0.0)]
    {
        let deep = ground[cell(place.0, place.1)][0];
        assert!((deep - expected).abs() < 1e-4, "{deep} m at {place:?}");
    }
    let pressed = ground.iter().filter(|texel| texel[0] > 0.004).count() as f32 * 0.8 * (2.0 / SIDE as f32).powi(2);
    // Its sides and half a metre of way.
    assert!((pressed - 0.2 * 0.7).abs() < 0.012, "{pressed} m² are pressed");
    // Another number of frames on the way, another renderer, and the same bytes.
    let mut again = Renderer::new(renderer.gpu().clone()).unwrap();
    state_at(&mut again, &mut scene, ("ground", 0.4));
    assert_eq!(state_at(&mut again, &mut scene, ("ground", 1.0)), ground);
    // What rises again does so as its rate says, after the sled has left.
    let mut soft = slide();
    soft.simulations[0] = soft.simulations[0].clone().with("recovery_per_s", "0.7");
    let at_half = state_at(&mut renderer, &mut soft, ("ground", 1.0))[cell(-0.4, 0.2)][0];
    let later = state_at(&mut renderer, &mut soft, ("ground", 2.0))[cell(-0.4, 0.2)][0];
    assert!((later / at_half - (-0.7f32).exp()).abs() < 0.01, "{at_half} m became {later} m");
    // A program that reads no surfaces looks at none.
    let mut blind = slide();
    blind.simulations[0] = Simulation { sees: blind.simulations[0].sees, ..ripples() };
    renderer.load(&blind).unwrap();
    assert!(renderer.warnings().iter().any(|warning| warning.contains("`pond` looks at nothing")));
    renderer.load(&scene).unwrap();
    assert!(!renderer.warnings().iter().any(|warning| warning.contains("looks at nothing")));
    // Nothing is pressed where nobody looks.
    let mut unseen = slide();
    unseen.simulations[0].sees = None;
    assert!(state_at(&mut renderer, &mut unseen, ("ground", 1.0)).iter().all(|texel| texel[0] == 0.0));
}

#[test]
fn spots_of_two_substances_divide() {
    let mut renderer = renderer();
    let coral = Simulation { cells: Some((64, 64)), ..Simulation::built_in("coral", "gray_scott") };
    let mut scene = with(coral);
    let share = |state: &[[f32; 4]]| state.iter().filter(|cell| cell[1] > 0.15).count() as f32 / state.len() as f32;
    let first = share(&state_at(&mut renderer, &mut scene, ("field", 0.0)));
    let later = state_at(&mut renderer, &mut scene, ("field", 20.0));
    assert!(first > 0.0 && share(&later) > 3.0 * first && share(&later) < 0.8, "{first} {}", share(&later));
    assert!(later.iter().all(|cell| (0.0..=1.0).contains(&cell[0]) && (0.0..=1.0).contains(&cell[1])));
}

const EXPLODES: &str = "//! start: one -> a\n//! step: twice -> a\n//! shows: color\n//! cells: 8x8\n
    fn one(cell: vec2i) -> vec4f { return vec4f(1.0, f32(cell.x), 0.0, 0.0); }
    fn twice(cell: vec2i) -> vec4f { let x = a_at(cell); return vec4f(2.0 * x.x, sqrt(-1.0 - x.y), -2.0 * x.x, 0.5); }
    fn color(cell: vec2i) -> vec4f { return a_at(cell); }\n";

#[test]
fn what_explodes_is_held_and_reported() {
    let mut renderer = renderer();
    let mut scene = with(Simulation::of_text("bomb", "bomb.wgsl", EXPLODES));
    state_at(&mut renderer, &mut scene, ("a", 0.1));
    let report = &renderer.simulation_reports().unwrap()[0];
    assert_eq!((report.steps, report.cells, report.passes), (6, (8, 8), 1));
    // The root of what is below 0 is no number.
    assert_eq!(report.held_numbers, 64);
    let state = state_at(&mut renderer, &mut scene, ("a", 100.0));
    assert!(state.iter().all(|cell| *cell == [1e6, 1e6, -1e6, 0.5]), "{:?}", state[0]);
    assert_eq!(renderer.simulation_reports().unwrap()[0].held_numbers, 3 * 64);
}

#[test]
fn materials_show_pictures_of_simulations() {
    let mut renderer = renderer();
    let text = "//! start: none -> a\n//! step: count -> a\n//! shows: color\n//! cells: 2x2\n//! rate: 4\n
        fn none(cell: vec2i) -> vec4f { return vec4f(0.0); }
        fn count(cell: vec2i) -> vec4f { return a_at(cell) + 0.125; }
        fn color(cell: vec2i) -> vec4f { return vec4f(a_at(cell).x, f32(cell.x), f32(cell.y), 1.0); }\n";
    let mut scene = with(Simulation::of_text("count", "count.wgsl", text));
    scene.images.push(Image::of_simulation("count", 0, "color"));
    let sampler = Sampler { mag_linear: false, min_linear: false, mip_linear: None, ..Sampler::default() };
    scene.textures.push(Texture { image: 0, sampler });
    let texture = Some(TextureRef { texture: 0, ..TextureRef::default() });
    scene.materials.push(Material {
        base_color_texture: texture,
        shading_model: ShadingModel::Unlit,
        ..Material::default()
    });
    let plate = Primitive { material: Some(0), ..plane(1.0) };
    scene.meshes.push(Mesh { primitives: vec![plate], ..Mesh::default() }.into());
    scene.add_node(None, Node { mesh: Some(0), ..Node::default() });
    scene.update_transforms();
    let projection = Projection::Orthographic { height_m: 1.0, near_m: 0.1, far_m: 2.0 };
    scene.cameras.push(Camera { name: "above".into(), projection, aspect: None });
    let rotation = look_along(-Vec3::Y, -Vec3::Z).unwrap();
    scene.add_node(None, Node { camera: Some(0), translation: Vec3::Y, rotation, ..Node::default() });
    scene.update_transforms();
    let request = plain_request(&scene, (32, 32));
    for (time_secs, expected) in [(0.0, 0.0), (1.0, 0.5), (0.5, 0.25)] {
        scene.time_secs = time_secs;
        renderer.render(&scene, &request).unwrap();
        let radiance = renderer.read_radiance().unwrap();
        let pixel = |x: usize, y: usize| &radiance[4 * (y * 32 + x)..][..3];
        for (x, y) in [(8, 8), (24, 8), (8, 24), (24, 24)] {
            let pixel = pixel(x, y);
            assert!((pixel[0] - expected).abs() < 2e-3, "{pixel:?} at {time_secs} s, {expected} expected");
        }
        // Rows go down the picture.
        assert!(pixel(8, 8)[1] < 0.01 && pixel(24, 8)[1] > 0.99, "{:?}", pixel(24, 8));
        assert!(pixel(8, 8)[2] < 0.01 && pixel(8, 24)[2] > 0.99, "{:?}", pixel(8, 24));
    }
}

#[test]
fn what_cannot_be_run_is_refused() {
    let mut renderer = renderer();
    let mut said = |simulation: Simulation, time_secs: f32| {
        let scene = Scene { time_secs, ..with(simulation) };
        renderer.simulate(&scene, &mut |_| true).expect_err("it cannot be run").to_string()
    };
    for (simulation, time_secs, expected) in [
        (ripples(), 1e9, "steps lead to 1000000000 s, and 108000 are made at most"),
        (Simulation { rate_hz: Some(0.0), ..ripples() }, 1.0, "0 steps a second are not possible"),
        (Simulation { rate_hz: Some(f32::NAN), ..ripples() }, 1.0, "NaN steps a second are not possible"),
        (Simulation { cells: Some((0, 4)), ..ripples() }, 1.0, "0 by 4 cells are not possible"),
        (ripples().with("depth", "3"), 1.0, "depth"),
        (ripples().with("speed_m_s", "fast"), 1.0, "speed_m_s"),
        (ripples().with("speed_m_s", "-1"), 1.0, "speed_m_s"),
        (Simulation::built_in("pond", "riples"), 1.0, "did you mean `ripples`?"),
    ] {
        let error = said(simulation, time_secs);
        assert!(error.contains(expected), "{error}\nshould say {expected}");
    }
    // Times before the beginning are the beginning, and what is no number is, too.
    for time_secs in [-5.0, f32::NAN, f32::NEG_INFINITY] {
        let scene = Scene { time_secs, ..with(ripples()) };
        renderer.simulate(&scene, &mut |_| true).unwrap();
        assert_eq!(renderer.simulation_reports().unwrap()[0].steps, 0);
    }
}

#[test]
fn simulations_take_a_bounded_amount_of_memory() {
    let names: Vec<String> = (0..8).map(|state| format!("s{state}")).collect();
    let steps: Vec<String> = names.iter().map(|name| format!("go_{name} -> {name}")).collect();
    let functions =
        names.iter().map(|name| format!("fn go_{name}(cell: vec2i) -> vec4f {{ return {name}_at(cell); }}\n"));
    let text = format!(
        "//! step: {}\n//! shows: color\n\n{}fn color(cell: vec2i) -> vec4f {{ return vec4f(0.0); }}\n",
        steps.join(", "),
        functions.collect::<String>()
    );
    let large = |name: &str| Simulation { cells: Some((2048, 2048)), ..Simulation::of_text(name, "large.wgsl", &text) };
    let scene = Scene { simulations: vec![large("one"), large("two")], ..Scene::default() };
    let error = renderer().simulate(&scene, &mut |_| true).unwrap_err().to_string();
    assert!(error.contains("`two`") && error.contains("would take 2133 MiB, and 2048 at most"), "{error}");
}

#[test]
fn faults_of_texts_have_their_place() {
    const FUNCTIONS: &str = "fn f(cell: vec2i) -> vec4f { return vec4f(0.0); }\n";
    for (header, functions, expected) in [
        ("//! step: f -> a", FUNCTIONS, "a.wgsl:1:1: error: the header of a simulation has a line `//! shows:"),
        ("//! shows: f", FUNCTIONS, "the header of a simulation has a line `//! step:"),
        ("//! step: f\n//! shows: f", FUNCTIONS, "a.wgsl:1:11: error: `f` is followed by `->`"),
        ("//! step: f -> a twice\n//! shows: f", FUNCTIONS, "`twice` is not understood"),
        ("//! step: f -> a x 0\n//! shows: f", FUNCTIONS, "a number of rounds from 1 to 64"),
        ("//! step: f -> a x many\n//! shows: f", FUNCTIONS, "`many` is not a number of rounds"),
        ("//! step: g -> a\n//! shows: f", FUNCTIONS, "there is no function `g`"),
        ("//! step: held -> a\n//! shows: f", FUNCTIONS, "there is no function `held`"),
        ("//! step: f -> simulation\n//! shows: f", FUNCTIONS, "a state cannot be called `simulation`"),
        ("//! step: f -> f\n//! shows: f", FUNCTIONS, "a state cannot be called `f`"),
        ("//! step: f -> a\n//! shows: f\n//! cells: 0x4", FUNCTIONS, "a.wgsl:3:5: error: write `//! cells: 256x256`"),
        ("//! step: f -> a\n//! shows: f\n//! cells: 4096x4", FUNCTIONS, "write `//! cells: 256x256`"),
        ("//! step: f -> a\n//! shows: f\n//! rate: 0", FUNCTIONS, "write `//! rate: 60`"),
        ("//! step: f -> a\n//! shows: f\n//! edges: none", FUNCTIONS, "write `//! edges: clamp`"),
        ("//! step: f -> a\n//! shows: f\n//! passes: f", FUNCTIONS, "begins with no word that the header"),
        ("//! step: f -> a\n//! shows: f\n//! step: f -> a", FUNCTIONS, "`step` stands twice"),
        (
            "//! step: f -> a\n//! shows: f",
            "fn f(cell: vec2f) -> vec4f { return vec4f(0.0); }",
            "is not a cell function",
        ),
        (
            "//! step: f -> a\n//! shows: f",
            "fn f(cell: vec2i) -> vec4f { loop { } return vec4f(0.0); }",
            "this loop never ends",
        ),
        ("//! step: f -> a\n//! shows: f", "fn f(cell: vec2i) -> vec4f { return b_at(cell); }", "a.wgsl:3:37: error: "),
        (
            "//! step: f -> a\n//! shows: f",
            "@group(2) @binding(0) var<uniform> x: f32;\nfn f(cell: vec2i) -> vec4f { return vec4f(x); }",
            "has neither a default nor a value",
        ),
        (
            "//! step: f -> a\n//! shows: f",
            "@group(1) @binding(0) var t: texture_2d<f32>;\nfn f(cell: vec2i) -> vec4f { return textureLoad(t, cell, 0); }",
            "a simulation's own bindings are uniforms in group 2",
        ),
        (
            "//! step: f -> a\n//! shows: f",
            "@fragment fn f() -> @location(0) vec4f { return vec4f(0.0); }",
            "is an entry point; a simulation has functions alone",
        ),
    ] {
        let text = format!("{header}\n{functions}");
        let error = SimulationFile::parse("a.wgsl", &text).map(drop).expect_err(&text).to_string();
        assert!(error.contains(expected), "{text}\n{error}\nshould say {expected}");
    }
}
