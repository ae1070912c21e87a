//! Particles: how many there are, where they go, what they meet, and how they look.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{plain_request, renderer};
use glam::{Vec2, Vec3};
use manypass::{Environment, FrameRequest, Path, Renderer};
use manypass_scene::framing::look_along;
use manypass_scene::particles::{Look, Particles, Preset};
use manypass_scene::primitives::{cube, plane};
use manypass_scene::{
    Camera, Light, LightKind, Material, Mesh, Node, NodeId, Primitive, Projection, Scene, ShadingModel,
};

/// Places with ages, and velocities with lengths of lives, of the scene's only particles at a time.
fn at(renderer: &mut Renderer, scene: &mut Scene, time_secs: f32) -> Vec<([f32; 4], [f32; 4])> {
    scene.time_secs = time_secs;
    renderer.simulate(scene, &mut |_| true).unwrap();
    let state = |name: &str| renderer.read_simulation(0, name).unwrap().unwrap();
    state("place").into_iter().zip(state("velocity")).collect()
}

fn alive(all: &[([f32; 4], [f32; 4])]) -> impl Iterator<Item = (Vec3, Vec3, f32)> {
    let of = |(place, velocity): &([f32; 4], [f32; 4])| (Vec3::from_slice(place), Vec3::from_slice(velocity), place[3]);
    all.iter().filter(|(place, _)| place[3] >= 0.0).map(of)
}

/// Particles that nothing moves but what a test sets.
fn plain(count: u32, parameters: &[(&str, &str)]) -> Scene {
    let mut particles = Particles::new("dust", Preset::Smoke, count);
    particles.simulation.parameters.retain(|(key, _)| key == "count");
    particles.set("gravity_m_s2", "0");
    particles.set("floor", "0,0,0,0");
    for (key, value) in parameters {
        particles.set(key, value);
    }
    Scene { particles: vec![particles], ..Scene::default() }
}

#[test]
fn as_many_live_as_are_born_in_a_life() {
    let mut renderer = renderer();
    for (count, rate, expected) in [(1000, "250", 500.0), (1000, "0", 1000.0), (300, "1e9", 300.0)] {
        let mut scene = plain(count, &[("life_s", "2,2"), ("rate_per_s", rate)]);
        for time_secs in [1.0f32, 2.0, 20.25] {
            let share = (time_secs / 2.0).min(1.0);
            let all = at(&mut renderer, &mut scene, time_secs);
            let found = alive(&all).count() as f32;
            // What is born in a step counts, or not.
            let a_step = expected / 2.0 / 60.0 + 1.0;
            assert!((found - share * expected).abs() <= a_step, "{found} of {expected} at {time_secs} s at {rate}/s");
            let young = alive(&all).filter(|(.., age)| *age < 0.5).count() as f32;
            assert!((young - 0.25 * expected).abs() <= 2.0 * a_step, "{young} are young of {found}");
        }
    }
}

#[test]
fn they_fall_and_are_carried_as_physics_says() {
    let mut renderer = renderer();
    let thrown = [("life_s", "10,10"), ("velocity_m_s", "1,4,0"), ("gravity_m_s2", "9.81"), ("center", "0,2,0")];
    let mut scene = plain(256, &thrown);
    let mut count = 0;
    for (place, velocity, age) in alive(&at(&mut renderer, &mut scene, 1.5)) {
        // Steps take the speed at their end.
        let expected = Vec3::new(age, 2.0 + 4.0 * age - 0.5 * 9.81 * age * (age + 1.0 / 60.0), 0.0);
        assert!(place.abs_diff_eq(expected, 2e-3), "{place} of {expected} after {age} s");
        assert!((velocity.y - (4.0 - 9.81 * age)).abs() < 1e-3, "{velocity}");
        count += 1;
    }
    assert!(count > 30, "{count}");
    let mut scene = plain(256, &[("life_s", "10,10"), ("wind_m_s", "3,0,-1"), ("drag_per_s", "2")]);
    for (_, velocity, age) in alive(&at(&mut renderer, &mut scene, 2.0)) {
        let expected = Vec3::new(3.0, 0.0, -1.0) * (1.0 - (-2.0 * age).exp());
        assert!(velocity.abs_diff_eq(expected, 1e-3), "{velocity} of {expected}");
    }
}

#[test]
fn air_that_swirls_neither_comes_nor_goes() {
    let mut renderer = renderer();
    let swirls =
        [("life_s", "4,4"), ("size_m", "4,4,4"), ("swirl_m_s", "0.5"), ("swirl_m", "0.8"), ("drag_per_s", "1000")];
    let mut scene = plain(30_000, &swirls);
    let all = at(&mut renderer, &mut scene, 4.0);
    let speed = (alive(&all).map(|(_, velocity, _)| velocity.length_squared()).sum::<f32>()
        / alive(&all).count() as f32)
        .sqrt();
    assert!(speed > 0.2 && speed < 2.0, "{speed}");
    // Of what was spread evenly, the middle has as much as before: the deviation is that of chance.
    let mut boxes = [0.0f32; 27];
    for (place, ..) in alive(&all) {
        let cell = ((place + 0.75) / 0.5).floor();
        if cell.min_element() >= 0.0 && cell.max_element() < 3.0 {
            boxes[(cell.x + 3.0 * cell.y + 9.0 * cell.z) as usize] += 1.0;
        }
    }
    let mean = boxes.iter().sum::<f32>() / 27.0;
    let deviation = (boxes.iter().map(|count| (count - mean).powi(2)).sum::<f32>() / 27.0).sqrt();
    assert!(mean > 40.0 && deviation < 2.2 * mean.sqrt(), "{mean} {deviation}");
}

#[test]
fn they_stay_before_planes_and_before_what_a_camera_sees() {
    let mut renderer = renderer();
    let falls = [
        ("life_s", "3,3"),
        ("gravity_m_s2", "9.81"),
        ("center", "0,3,0"),
        ("size_m", "3,0,3"),
        ("floor", "0,1,0,0"),
        ("bounce", "0.5"),
    ];
    let mut scene = plain(2000, &falls);
    let all = at(&mut renderer, &mut scene, 3.0);
    assert!(alive(&all).all(|(place, ..)| place.y > -1e-4) && alive(&all).any(|(place, ..)| place.y < 0.3));
    // A bounce of a half comes back up to a quarter of the height; it turns a step early, by up to 13 cm.
    let after = alive(&all).filter(|(.., age)| *age > 0.9).map(|(place, ..)| place.y).fold(0.0, f32::max);
    assert!((after - 0.75).abs() < 0.13, "{after} m");

    // A box that a camera above it sees, and rain that ends where it meets it.
    scene.meshes.push(Mesh { primitives: vec![cube(Vec3::ONE)], ..Mesh::default() }.into());
    scene.add_node(None, Node { mesh: Some(0), translation: 0.5 * Vec3::Y, ..Node::default() });
    let projection = Projection::Orthographic { height_m: 4.0, near_m: 0.1, far_m: 10.0 };
    scene.cameras.push(Camera { name: "above".into(), projection, aspect: None });
    let rotation = look_along(Vec3::NEG_Y, Vec3::NEG_Z).unwrap();
    let above = Node { camera: Some(0), translation: 5.0 * Vec3::Y, rotation, ..Node::default() };
    let above = scene.add_node(None, above);
    scene.update_transforms();
    scene.particles[0].meets = Some(above);
    for bounce in ["-1", "0.2"] {
        scene.particles[0].set("bounce", bounce);
        let all = at(&mut renderer, &mut scene, 3.0);
        // The map has texels of 1.6 cm.
        let is_inside = |place: Vec3| place.x.abs() < 0.48 && place.z.abs() < 0.48 && place.y < 0.96;
        assert_eq!(alive(&all).filter(|(place, ..)| is_inside(*place)).count(), 0, "at a bounce of {bounce}");
        let beside = alive(&all).filter(|(place, ..)| place.x.abs() > 0.6 && place.y < 0.9).count();
        assert!(beside > 50, "{beside} fall beside it");
    }
}

/// A still puff of a radius before a camera that looks along -Z from the origin.
fn puff(look: Look, places: &[(&str, f32)]) -> (Scene, FrameRequest) {
    let mut scene = Scene::default();
    for (index, (center, size_m)) in places.iter().enumerate() {
        let mut particles = plain(1, &[("life_s", "1000,1000"), ("center", center)]).particles.remove(0);
        particles.name = format!("puff {index}");
        particles.simulation.rate_hz = Some(1.0);
        particles.look = Look { radius_m: Vec2::splat(*size_m), ..look.clone() };
        scene.particles.push(particles);
    }
    scene.cameras.push(Camera {
        name: "Main".into(),
        projection: Projection::Perspective { fov_y_rad: 1.0, near_m: 0.1, far_m: None },
        aspect: None,
    });
    scene.add_node(None, Node { camera: Some(0), ..Node::default() });
    scene.update_transforms();
    // The first is born at once, and is whole until half of its life is over.
    scene.time_secs = 400.0;
    let mut request = plain_request(&scene, (48, 48));
    request.settings.background.source = manypass::Background::Color([0.2, 0.4, 0.6]);
    (scene, request)
}

fn middle(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec3 {
    renderer.render(scene, request).unwrap();
    let radiance = renderer.read_radiance().unwrap();
    Vec3::from_slice(&radiance[4 * (24 * 48 + 24)..][..3])
}

#[test]
fn they_add_light_hide_what_is_behind_and_are_hidden() {
    let mut renderer = renderer();
    let shines =
        Look { opacity: 0.0, emission: 2.0, color: Vec3::new(1.0, 0.5, 0.0), softness_m: 0.0, ..Look::default() };
    let (scene, request) = puff(shines, &[("0,0,-2", 0.5)]);
    let background = Vec3::new(0.2, 0.4, 0.6);
    let found = middle(&mut renderer, &scene, &request);
    let added = found - background;
    assert!(added.x > 0.5 && (added.y / added.x - 0.5).abs() < 0.01 && added.z.abs() < 1e-3, "{found}");
    // A wall before it hides it, and one behind does not.
    for (z, is_seen) in [(-1.0, false), (-3.0, true)] {
        let mut scene = scene.clone();
        scene.materials.push(Material {
            shading_model: ShadingModel::Unlit,
            base_color_factor: glam::Vec4::new(0.0, 0.0, 0.0, 1.0),
            double_sided: true,
            ..Material::default()
        });
        let wall = Primitive { material: Some(0), ..plane(8.0) };
        scene.meshes.push(Mesh { primitives: vec![wall], ..Mesh::default() }.into());
        let rotation = glam::Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
        scene.add_node(None, Node { mesh: Some(0), translation: Vec3::Z * z, rotation, ..Node::default() });
        scene.update_transforms();
        let found = middle(&mut renderer, &scene, &request);
        assert_eq!(found.x > 0.5, is_seen, "{found} with a wall at {z} m");
        for path in [Path::Forward, Path::ForwardBatched, Path::Gouraud] {
            let mut request = request.clone();
            request.settings.render.path = path;
            let other = middle(&mut renderer, &scene, &request);
            assert!(other.abs_diff_eq(found, 2e-3), "{other} on {path:?}, {found} deferred");
        }
    }
}

#[test]
fn what_hides_is_a_mean_whatever_its_order() {
    let mut renderer = renderer();
    let hides = |color: Vec3| Look { opacity: 0.5, color, emission: 1.0, softness_m: 0.0, ..Look::default() };
    let (scene, request) = puff(hides(Vec3::X), &[("0,0,-2", 0.5), ("0,0,-3", 0.75)]);
    let one = middle(&mut renderer, &scene, &request);
    // Lights are none: each emits red, and lets half of what is behind through twice.
    let background = Vec3::new(0.2, 0.4, 0.6);
    let through = one.y / background.y;
    assert!((through - 0.25).abs() < 0.02 && (one.z / background.z - through).abs() < 5e-3, "{one}");
    // Two of one system and of two colours by their places cannot be; one system of both is the same from either side.
    let mut both = Scene { particles: vec![scene.particles[0].clone()], ..scene.clone() };
    // The second of four is born after 500 of 2000 seconds.
    both.particles[0].hold(4);
    both.particles[0].set("life_s", "2000,2000");
    both.time_secs = 800.0;
    let found = middle(&mut renderer, &both, &request);
    assert!((found.y / background.y - 0.25).abs() < 0.03, "{found}");
}

#[test]
fn light_of_a_sun_and_of_the_environment_is_scattered_to_all_sides_alike() {
    let mut renderer = renderer();
    let white = Look { opacity: 1.0, softness_m: 0.0, ..Look::default() };
    let (mut scene, mut request) = puff(white, &[("0,0,-2", 0.5)]);
    request.settings.environment.source = Environment::Color([0.5; 3]);
    request.settings.background.source = manypass::Background::Color([0.0; 3]);
    // In the middle 98 % are hidden, at most.
    let ambient = middle(&mut renderer, &scene, &request) / 0.98;
    assert!(ambient.abs_diff_eq(Vec3::splat(0.5), 0.02), "{ambient}");
    request.settings.environment.source = Environment::None;
    let sun = Light { intensity: 4.0 * std::f32::consts::PI, kind: LightKind::Directional, ..Light::default() };
    scene.lights.push(sun);
    scene.add_node(None, Node { light: Some(0), ..Node::default() });
    scene.update_transforms();
    let sunny = middle(&mut renderer, &scene, &request) / 0.98;
    assert!(sunny.abs_diff_eq(Vec3::ONE, 0.03), "{sunny}");
    scene.lights[0] = Light { intensity: 4.0 * std::f32::consts::PI, kind: LightKind::Point, ..Light::default() };
    scene.node_mut(NodeId(scene.nodes.len() as u32 - 1)).translation = Vec3::new(0.0, 2.0, -2.0);
    scene.update_transforms();
    let lit = middle(&mut renderer, &scene, &request) / 0.98;
    assert!(lit.abs_diff_eq(Vec3::splat(0.25), 0.01), "{lit}");
}

/// The light of the left and of the right half of a ball of smoke of 1 m in a sun that shines in a direction.
fn halves_of_smoke(renderer: &mut Renderer, shines: Vec3, stretch_secs: f32) -> [f32; 2] {
    let look = Look { opacity: 0.3, softness_m: 0.0, stretch_secs, ..Look::default() };
    let (mut scene, mut request) = puff(look, &[("0,0,-2", 0.15)]);
    let particles = &mut scene.particles[0];
    particles.hold(1000);
    for (key, value) in [("size_m", "1,1,1"), ("shape", "1")] {
        particles.set(key, value);
    }
    request.settings.background.source = manypass::Background::Color([0.0; 3]);
    request.settings.environment.source = Environment::None;
    let sun = Light { intensity: 4.0 * std::f32::consts::PI, kind: LightKind::Directional, ..Light::default() };
    scene.lights.push(sun);
    let rotation = look_along(shines, Vec3::Y).unwrap();
    scene.add_node(None, Node { light: Some(0), rotation, ..Node::default() });
    scene.update_transforms();
    renderer.render(&scene, &request).unwrap();
    let radiance = renderer.read_radiance().unwrap();
    let red = |half: &[f32]| half.iter().step_by(4).sum::<f32>();
    let rows = radiance.chunks_exact(4 * 48).map(|row| [red(&row[..4 * 24]), red(&row[4 * 24..])]);
    rows.fold([0.0; 2], |sums, half| [sums[0] + half[0], sums[1] + half[1]])
}

#[test]
fn smoke_is_dark_on_the_side_away_from_the_light_and_streaks_are_not() {
    let mut renderer = renderer();
    // Some 350 are whole: an optical depth of 5 through the middle.
    let [left, right] = halves_of_smoke(&mut renderer, Vec3::NEG_X, 0.0);
    assert!(left > 10.0 && left < 0.8 * right, "{left} {right}");
    // They stand still, so that they are balls all the same.
    let [left, right] = halves_of_smoke(&mut renderer, Vec3::NEG_X, 0.02);
    assert!((left / right - 1.0).abs() < 0.15, "{left} {right}");
    // Those before hide those behind.
    let [lit, back_lit] = [Vec3::NEG_Z, Vec3::Z].map(|shines| halves_of_smoke(&mut renderer, shines, 0.0));
    assert!(lit[0] > 1.25 * back_lit[0] && lit[1] > 1.25 * back_lit[1], "{lit:?} {back_lit:?}");
}

#[test]
fn ragged_edges_differ_all_around_and_the_middle_stays() {
    let mut renderer = renderer();
    // Pixels of the same distance from the middle of the picture, 0.77 of the radius.
    let ring = [(8.5, 0.5), (0.5, 8.5), (6.5, 5.5), (5.5, 6.5)];
    let ring = ring
        .into_iter()
        .flat_map(|(x, y): (f32, f32)| [(24.0 + x, 24.0 + y), (24.0 - x, 24.0 - y), (24.0 + x, 24.0 - y)]);
    let ring: Vec<usize> = ring.map(|(x, y)| 4 * (y as usize * 48 + x as usize)).collect();
    let mut of = |raggedness: f32| {
        let look = Look { opacity: 0.5, emission: 1.0, softness_m: 0.0, raggedness, ..Look::default() };
        let (scene, mut request) = puff(look, &[("0,0,-2", 0.5)]);
        request.settings.background.source = manypass::Background::Color([0.0; 3]);
        let middle = middle(&mut renderer, &scene, &request).x;
        let radiance = renderer.read_radiance().unwrap();
        let all = ring.iter().map(|at| radiance[*at]);
        (middle, all.clone().fold(0.0, f32::max) - all.fold(f32::MAX, f32::min))
    };
    let ((round_middle, round_spread), (middle, spread)) = (of(0.0), of(1.0));
    assert!(round_spread < 0.02 * round_middle, "{round_spread} of {round_middle}");
    assert!(
        spread > 0.08 * middle && (middle / round_middle - 1.0).abs() < 0.02,
        "{spread} of {middle}, {round_middle}"
    );
}
