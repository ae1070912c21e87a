//! Reflections of the picture at the default settings, in five scenes, against rays on the CPU.
//!
//! Each pixel of a reflecting surface that is checked has as many rays as the picture has samples, through the same
//! places of the pixel; a rough surface has four times as many, by the distribution of GGX. The rays meet the triangles
//! of the scene. All that is reflected has a radiance that does not depend on the direction from which it is seen, so
//! that it is known where the picture hides it, too. Surfaces that reflect show the environment in each other, because
//! light that is reflected twice is none of what the picture shows.
//!
//! These need an adapter; the software one will do. `MANYPASS_LOOK` names a folder for pictures: the frame, what it
//! reflects, what the rays bring, and the wrong pixels.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::reflected::{Lobe, bulb, glowing, load, metal, pixel_of, places, without};
use crate::common::shadows::{perspective, radiance, shared, world_of};
use crate::common::{look, plain_request};
use glam::{DVec2, Quat, Vec3};
use manypass::{Environment, View};
use manypass_scene::{Material, Node, Primitive, primitives};
use manypass_testkit::build::{SceneBuilder, at, grey};
use manypass_testkit::raycast::{Hit, PixelPattern, World};
use std::collections::BTreeMap;
use std::f32::consts::FRAC_PI_2;

/// Of the picture. Its filters are as wide in pixels in a larger one, and so narrower in what it shows.
const SIZE: (u32, u32) = (320, 240);

/// The default of the command line.
const SAMPLES: u32 = 16;

/// Of rough surfaces, per sample.
const RAYS: u32 = 4;

/// A pixel is wrong if a channel of what it reflects is off by more, as a share of what is right, but at least of 1.
const WRONG: f32 = 0.1;

/// So large a share of what a pixel reflects may be of another group.
const GROUP_SHARE: f32 = 0.05;

/// Over the brightest thing: rounding of half floats, and of the table of albedos.
const BRIGHTER_MAX: f32 = 1.03;

/// The shares of pixels that may be wrong: where the picture shows what they reflect, and where they reflect the
/// environment. Measured were 0.029, 0.019, 0.087, 0.069 and 0.118 of the first, and at most 0.011 of the second. What is
/// wrong are edges, over which filters reach: in four times as many pixels it is 0.024, 0.056, 0.047, 0.045 and 0.038.
const LIMITS: [(&str, [f32; 2]); 5] = [
    ("mirror floor", [0.04, 0.03]),
    ("room", [0.03, 0.03]),
    ("hall", [0.11, 0.03]),
    ("pots", [0.09, 0.03]),
    ("product", [0.15, 0.03]),
];

/// What a node is made of.
#[derive(Clone, Copy, Debug)]
enum Finish {
    /// The radiance of sides that are turned to a light that is painted on; of others it is less.
    Painted([f32; 3]),
    /// The radiance of all sides.
    Lamp(f32),
    /// White, of a perceptual roughness.
    Metal(f32),
    /// Black, of a perceptual roughness.
    Lacquer(f32),
}

/// The radiance of what is painted, by its normal; linear in it, so that triangles interpolate it.
fn painted(color: [f32; 3], normal: Vec3) -> Vec3 {
    let to_light = Vec3::new(0.4, 0.8, 0.45).normalize();
    Vec3::from(color) * (0.7 + 0.3 * normal.dot(to_light))
}

impl Finish {
    /// What it looks like without reflections. Lacquer is flat and alone in its scenes: none of it is reflected.
    fn radiance(self, normal: Vec3, environment: f32) -> Vec3 {
        match self {
            Self::Painted(color) => painted(color, normal),
            Self::Lamp(radiance) => Vec3::splat(radiance),
            Self::Metal(_) | Self::Lacquer(_) => Vec3::splat(environment),
        }
    }

    /// How it reflects, if it does.
    fn lobe(self, normal: Vec3) -> Option<Lobe> {
        match self {
            Self::Painted(_) | Self::Lamp(_) => None,
            Self::Metal(roughness) => Some(Lobe { normal, roughness, f0: 1.0 }),
            Self::Lacquer(roughness) => Some(Lobe { normal, roughness, f0: 0.04 }),
        }
    }

    fn material(self) -> Material {
        match self {
            Self::Painted(_) => glowing([1.0; 3]),
            Self::Lamp(radiance) => bulb(radiance),
            Self::Metal(roughness) => metal(roughness),
            Self::Lacquer(roughness_factor) => Material { roughness_factor, ..grey(0.0) },
        }
    }
}

/// A scene in the same light from everywhere.
struct Setup {
    name: &'static str,
    builder: SceneBuilder,
    /// By node.
    finishes: BTreeMap<usize, Finish>,
    environment: f32,
}

impl Setup {
    fn new(name: &'static str, (eye, target): (Vec3, Vec3), environment: f32) -> Self {
        let builder = SceneBuilder::new(eye, target, perspective());
        Self { name, builder, finishes: BTreeMap::new(), environment }
    }

    fn put(&mut self, mut primitive: Primitive, finish: Finish, node: Node) {
        if let Finish::Painted(color) = finish {
            let normals = primitive.normals.iter().map(|normal| node.rotation * Vec3::from(*normal));
            primitive.colors = normals.map(|normal| painted(color, normal).extend(1.0).to_array()).collect();
        }
        let id = self.builder.put(primitive, finish.material(), node);
        self.finishes.insert(id.0 as usize, finish);
    }

    /// A box of a size around a place.
    fn cuboid(&mut self, size_m: [f32; 3], finish: Finish, place: [f32; 3]) {
        self.put(primitives::cube(size_m.into()), finish, at(place.into()));
    }
}

/// Where the picture shows what a pixel reflects.
#[derive(Clone, Copy, Debug)]
enum Group {
    Seen,
    /// Behind something, or on a side that is turned away.
    Hidden,
    /// Beside the picture, or so near to its edges that hits fade out.
    Outside,
    /// It is the environment.
    Open,
}

/// What a pixel reflects.
#[derive(Clone, Copy, Debug)]
struct Truth {
    radiance: Vec3,
    group: Group,
}

/// The sum over the rays of a pixel.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    radiance: Vec3,
    /// By [`Group`].
    weights: [f32; 4],
}

impl Tally {
    fn truth(&self) -> Option<Truth> {
        let total: f32 = self.weights.iter().sum();
        let is_large = |group: &Group| self.weights[*group as usize] > GROUP_SHARE * total;
        let group = [Group::Outside, Group::Hidden, Group::Seen].into_iter().find(is_large).unwrap_or(Group::Open);
        (total > 0.0).then(|| Truth { radiance: self.radiance / total, group })
    }
}

/// Evenly spread places of rays in a lobe, turned by other amounts in each pixel (Cranley & Patterson 1976).
fn place_in_lobe(pixel: usize, ray: u32) -> [f32; 2] {
    let turned = |place: f64, step: f64| ((place + step * pixel as f64).fract() as f32).min(0.9999);
    let place = (f64::from(ray) + 0.5) / f64::from(SAMPLES * RAYS);
    [turned(place, 0.754_877_67), turned(0.618_033_99 * f64::from(ray), 0.569_840_29)]
}

/// What finds out what pixels reflect.
struct Rays<'s> {
    world: World,
    finishes: &'s BTreeMap<usize, Finish>,
    environment: f32,
    view: View,
    /// The places and normals that pixels show.
    shown: Vec<(Vec3, Vec3)>,
}

impl Rays<'_> {
    /// Whether one of the four pixels around a place shows it.
    fn group_of(&self, position: Vec3, normal: Vec3) -> Group {
        let world_from_view = self.view.world_from_view;
        let [backward, eye] = [world_from_view.z_axis, world_from_view.w_axis].map(|axis| axis.truncate());
        let distance_m = (eye - position).dot(backward);
        let (x, y) = pixel_of(&self.view, SIZE, position);
        let [across, down] = [x / SIZE.0 as f32, y / SIZE.1 as f32].map(|share| share.min(1.0 - share));
        if distance_m <= 0.0 || across.min(down) < 0.09 {
            return Group::Outside;
        }
        let width = SIZE.0 as usize;
        let first = (y - 0.5) as usize * width + (x - 0.5) as usize;
        let is_shown = [first, first + 1, first + width, first + width + 1].into_iter().any(|pixel| {
            let (shown_position, shown_normal) = self.shown[pixel];
            let away = position - shown_position;
            // It is on the same side of the same body, and not far from there.
            shown_normal.dot(normal) > 0.8
                && shown_normal.dot(away).abs() < 0.005 * distance_m
                && away.length() < 0.1 * distance_m
        });
        if is_shown { Group::Seen } else { Group::Hidden }
    }

    /// Adds the rays that leave a surface for one sample of a pixel.
    fn follow(&self, hit: &Hit, (to_eye, lobe): (Vec3, &Lobe), (pixel, sample): (usize, u32), tally: &mut Tally) {
        let count = if lobe.roughness > 0.0 { RAYS } else { 1 };
        let origin = hit.position_world + 1e-5 * hit.normal_world;
        for ray in 0..count {
            let place = place_in_lobe(pixel, ray * SAMPLES + sample);
            let Some((towards, weight)) = lobe.reflected(to_eye, place) else { continue };
            let met = self.world.first_solid((origin, towards.as_dvec3().normalize()));
            let (radiance, group) = match met {
                None => (Vec3::splat(self.environment), Group::Open),
                Some(met) => {
                    let (position, normal) = (met.position_world.as_vec3(), met.normal_world.as_vec3());
                    let finish = self.finishes[&met.object];
                    let group = match self.group_of(position, normal) {
                        Group::Seen if finish.lobe(normal).is_some() => Group::Open,
                        group => group,
                    };
                    (finish.radiance(normal, self.environment), group)
                }
            };
            tally.radiance += weight * radiance;
            tally.weights[group as usize] += weight;
        }
    }

    /// What a pixel reflects, if all of it is one surface that reflects.
    fn truth(&self, pixel: usize) -> Option<Truth> {
        let size = DVec2::new(f64::from(SIZE.0), f64::from(SIZE.1));
        let corner = DVec2::new((pixel % SIZE.0 as usize) as f64, (pixel / SIZE.0 as usize) as f64);
        let mut first = None;
        let mut tally = Tally::default();
        for sample in 0..SAMPLES {
            let uv = (corner + PixelPattern::Sequence.place(sample, 1)) / size;
            let ray = self.world.camera.ray(DVec2::new(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y), size.x / size.y);
            let hit = self.world.first_solid(ray)?;
            if *first.get_or_insert(hit.object) != hit.object {
                return None;
            }
            let lobe = self.finishes[&hit.object].lobe(hit.normal_world.as_vec3())?;
            self.follow(&hit, (-ray.1.as_vec3(), &lobe), (pixel, sample), &mut tally);
        }
        tally.truth()
    }

    /// What every fourth pixel reflects, if it does.
    fn truths(&self) -> BTreeMap<usize, Truth> {
        let (width, count) = (SIZE.0 as usize, (SIZE.0 * SIZE.1) as usize);
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let part = |first: usize| {
            let own = (first..count).step_by(threads).filter(|pixel| pixel % width % 2 == 0 && pixel / width % 2 == 0);
            own.filter_map(|pixel| Some((pixel, self.truth(pixel)?))).collect::<Vec<_>>()
        };
        let part = &part;
        std::thread::scope(|scope| {
            let workers: Vec<_> = (0..threads).map(|first| scope.spawn(move || part(first))).collect();
            workers.into_iter().flat_map(|worker| worker.join().unwrap()).collect()
        })
    }
}

/// Writes what there is to look at.
fn look_at(name: &str, found: &[[f32; 3]], reflected: &[[f32; 3]], truths: &BTreeMap<usize, Truth>) {
    let picture = |of: &dyn Fn(usize, Vec3) -> Vec3| {
        let pixel = |pixel: usize| truths.get(&pixel).map_or([0.0; 3], |truth| of(pixel, truth.radiance).to_array());
        (0..found.len()).map(pixel).collect::<Vec<[f32; 3]>>()
    };
    let own = picture(&|pixel, _| Vec3::from(reflected[pixel]));
    let expected = picture(&|_, radiance| radiance);
    let wrong = picture(&|pixel, radiance| {
        let is_wrong = is_wrong(Vec3::from(reflected[pixel]), radiance);
        if is_wrong { Vec3::X } else { Vec3::splat(0.1) }
    });
    look(&format!("reflections_{}", name.replace(' ', "_")), &[found, &own, &expected, &wrong], SIZE);
}

fn is_wrong(reflected: Vec3, expected: Vec3) -> bool {
    (reflected - expected).abs().max_element() > WRONG * expected.max_element().max(1.0)
}

/// Asserts that a scene is reflected as its rays say.
fn check(setup: Setup) {
    let Setup { name, builder, finishes, environment } = setup;
    let scene = builder.finish();
    let request = plain_request(&scene, SIZE).with(|settings| {
        settings.environment.source = Environment::Color([environment; 3]);
        settings.reflections.enabled = true.into();
    });
    let mut renderer = shared();
    load(&mut renderer, &scene);
    let found = radiance(&mut renderer, &scene, &request, SAMPLES);
    let bare = radiance(&mut renderer, &scene, &without(&request), SAMPLES);
    let shown = places(&mut renderer, &scene, &request);
    drop(renderer);
    // Surfaces that reflect have no light but that: of the same light from everywhere they show their albedo.
    let shares =
        found.iter().zip(&bare).map(|(found, bare)| Vec3::from(*found) / Vec3::from(*bare).max(Vec3::splat(1e-6)));
    let reflected: Vec<[f32; 3]> = shares.map(|share| (environment * share).to_array()).collect();
    let view = request.camera;
    let truths = Rays { world: world_of(&scene), finishes: &finishes, environment, view, shown }.truths();
    look_at(name, &found, &reflected, &truths);

    // How many there are, are wrong, and would be without reflections.
    let mut counts = [[0usize; 3]; 4];
    for (pixel, truth) in &truths {
        let [own, plain] =
            [Vec3::from(reflected[*pixel]), Vec3::splat(environment)].map(|of| is_wrong(of, truth.radiance));
        let of_group = &mut counts[truth.group as usize];
        of_group[0] += 1;
        of_group[1] += usize::from(own);
        of_group[2] += usize::from(plain);
    }
    let share = |group: Group, which: usize| {
        let of_group = counts[group as usize];
        of_group[which] as f32 / of_group[0].max(1) as f32
    };
    for group in [Group::Seen, Group::Hidden, Group::Outside, Group::Open] {
        let count = counts[group as usize][0];
        let [wrong, plain] = [1, 2].map(|which| 100.0 * share(group, which));
        println!("{name}, {group:?}: {count} pixels, {wrong:.1} % are wrong ({plain:.1} % without reflections)");
    }
    let brightest = truths.keys().flat_map(|pixel| reflected[*pixel]).fold(0.0, f32::max);
    let things = finishes.values().map(|finish| match finish {
        Finish::Painted(color) => Vec3::from(*color).max_element(),
        Finish::Lamp(radiance) => *radiance,
        Finish::Metal(_) | Finish::Lacquer(_) => environment,
    });
    let brightest_thing = things.fold(environment, f32::max);
    println!("{name}: {brightest:.3} is the brightest that is reflected, of {brightest_thing:.3}");

    let (_, [seen_max, open_max]) = *LIMITS.iter().find(|(of, _)| *of == name).unwrap();
    assert!(counts[Group::Seen as usize][0] >= 300, "{name}: {counts:?}");
    assert!(share(Group::Seen, 2) > 5.0 * seen_max, "{name} looks the same without reflections: {counts:?}");
    assert!(share(Group::Seen, 1) <= seen_max, "{name}, of what is seen: {}", share(Group::Seen, 1));
    assert!(share(Group::Open, 1) <= open_max, "{name}, of the environment: {}", share(Group::Open, 1));
    assert!(brightest <= BRIGHTER_MAX * brightest_thing, "{name}: {brightest} of {brightest_thing}");
}

#[test]
fn a_mirror_floor_under_boxes_and_balls() {
    let mut setup = Setup::new("mirror floor", (Vec3::new(1.6, 1.5, 4.4), Vec3::new(0.0, 0.2, 0.0)), 0.1);
    setup.cuboid([12.0, 0.1, 12.0], Finish::Metal(0.0), [0.0, -0.05, 0.0]);
    for i in 0..9u8 {
        let [x, z] = [i % 3, i / 3].map(f32::from);
        let finish = Finish::Painted([0.35 + 0.3 * x, 0.95 - 0.3 * z, f32::from(i % 4) / 4.0]);
        let [x_m, z_m] = [1.3 * x - 1.3, 1.1 * z - 1.6];
        if i % 2 == 0 {
            setup.put(primitives::uv_sphere(0.45, 64, 32), finish, at(Vec3::new(x_m, 0.45, z_m)));
        } else {
            setup.cuboid([0.7, 0.9, 0.7], finish, [x_m, 0.45, z_m]);
        }
    }
    check(setup);
}

#[test]
fn a_mirror_on_the_wall_of_a_room() {
    let mut setup = Setup::new("room", (Vec3::new(1.0, 1.5, 2.0), Vec3::new(-1.2, 1.1, -1.6)), 0.2);
    let walls: [([f32; 3], [f32; 3], [f32; 3]); 6] = [
        ([5.0, 0.1, 5.0], [0.45, 0.35, 0.3], [0.0, -0.05, 0.0]),
        ([5.0, 0.1, 5.0], [0.9, 0.9, 0.9], [0.0, 2.85, 0.0]),
        ([5.0, 2.8, 0.1], [0.8, 0.7, 0.5], [0.0, 1.4, -2.55]),
        ([5.0, 2.8, 0.1], [0.8, 0.7, 0.5], [0.0, 1.4, 2.55]),
        ([0.1, 2.8, 5.0], [0.5, 0.6, 0.8], [-2.55, 1.4, 0.0]),
        ([0.1, 2.8, 5.0], [0.5, 0.6, 0.8], [2.55, 1.4, 0.0]),
    ];
    for (size_m, color, place) in walls {
        setup.cuboid(size_m, Finish::Painted(color), place);
    }
    setup.cuboid([0.04, 2.2, 2.6], Finish::Metal(0.0), [-2.48, 1.3, -0.9]);
    // Pictures and a shelf on the wall behind, a lamp, a table with a ball.
    for i in 0..4u8 {
        let x = f32::from(i);
        let color = [0.9 - 0.25 * x, 0.15 + 0.2 * x, 0.3 + 0.1 * x];
        setup.cuboid([0.35, 0.5, 0.04], Finish::Painted(color), [-1.9 + 0.6 * x, 1.7, -2.48]);
    }
    setup.cuboid([1.6, 0.08, 0.25], Finish::Painted([0.3, 0.15, 0.1]), [-1.0, 1.1, -2.38]);
    setup.put(primitives::uv_sphere(0.14, 32, 16), Finish::Lamp(1.5), at(Vec3::new(-0.4, 1.28, -2.3)));
    setup.cuboid([0.7, 0.7, 0.7], Finish::Painted([0.9, 0.4, 0.2]), [-1.2, 0.35, -1.7]);
    setup.put(primitives::uv_sphere(0.25, 48, 24), Finish::Painted([0.2, 0.8, 0.3]), at(Vec3::new(-1.2, 0.95, -1.7)));
    check(setup);
}

/// Nothing lies so high or so far aside that rays from the floor meet what is outside of the picture.
#[test]
fn a_lacquered_floor_of_a_hall() {
    let mut setup = Setup::new("hall", (Vec3::new(0.0, 1.7, 7.5), Vec3::new(0.0, 0.6, -1.0)), 0.15);
    setup.cuboid([6.2, 0.1, 9.0], Finish::Lacquer(0.15), [0.0, -0.05, 0.5]);
    setup.cuboid([6.2, 2.6, 0.1], Finish::Painted([0.6, 0.5, 0.4]), [0.0, 1.3, -4.05]);
    for side in [-1.0, 1.0] {
        setup.cuboid([0.1, 2.6, 4.0], Finish::Painted([0.7, 0.45, 0.35]), [3.05 * side, 1.3, -2.0]);
        for i in 0..3u8 {
            let z_m = -0.4 - 1.5 * f32::from(i);
            let color = Finish::Painted([0.9, 0.85, 0.75]);
            setup.put(primitives::cylinder(0.18, 2.6, 48), color, at(Vec3::new(2.2 * side, 1.3, z_m)));
        }
        setup.cuboid([0.7, 1.3, 0.06], Finish::Lamp(2.0), [1.1 * side, 1.5, -3.97]);
    }
    setup.cuboid([0.9, 2.0, 0.1], Finish::Painted([0.15, 0.25, 0.5]), [0.0, 1.0, -3.95]);
    setup.cuboid([0.6, 0.5, 0.6], Finish::Painted([0.8, 0.2, 0.15]), [0.6, 0.25, -0.8]);
    check(setup);
}

#[test]
fn metal_balls_and_pots_on_a_rough_metal_table() {
    let mut setup = Setup::new("pots", (Vec3::new(0.0, 1.1, 3.4), Vec3::new(0.0, 0.25, -0.2)), 0.8);
    setup.cuboid([4.4, 0.1, 2.0], Finish::Metal(0.3), [0.0, -0.05, 0.0]);
    setup.cuboid([3.6, 1.0, 0.1], Finish::Painted([0.5, 0.3, 0.2]), [0.0, 0.5, -1.1]);
    for i in 0..5u8 {
        let x_m = 0.6 * f32::from(i) - 1.2;
        if i % 2 == 0 {
            setup.put(primitives::uv_sphere(0.22, 64, 32), Finish::Metal(0.05), at(Vec3::new(x_m, 0.22, 0.0)));
        } else {
            let pot = primitives::cylinder(0.2, 0.36, 48);
            setup.put(pot, Finish::Painted([0.1, 0.2, 0.45]), at(Vec3::new(x_m, 0.18, 0.0)));
        }
    }
    for i in 0..4u8 {
        let color = [0.1 + 0.1 * f32::from(i), 0.4 - 0.1 * f32::from(i), 0.1];
        setup.cuboid([0.16; 3], Finish::Painted(color), [0.6 * f32::from(i) - 0.9, 0.08, 0.45]);
    }
    check(setup);
}

/// The foot of a mixer.
#[test]
fn a_product_on_a_glossy_ground() {
    let mut setup = Setup::new("product", (Vec3::new(0.6, 0.55, 1.9), Vec3::new(0.0, 0.22, 0.1)), 0.9);
    setup.cuboid([6.0, 0.1, 6.0], Finish::Lacquer(0.1), [0.0, -0.05, 0.0]);
    let body = Finish::Painted([0.45, 0.08, 0.08]);
    setup.put(primitives::cylinder(0.42, 0.06, 64), body, at(Vec3::new(0.0, 0.03, 0.0)));
    setup.put(primitives::cylinder(0.09, 0.8, 64), body, at(Vec3::new(-0.18, 0.45, 0.0)));
    let disc = primitives::cylinder(0.3, 0.05, 64);
    setup.put(disc, Finish::Painted([0.25, 0.25, 0.28]), at(Vec3::new(0.06, 0.085, 0.0)));
    let bowl = primitives::cylinder(0.2, 0.24, 64);
    setup.put(bowl, Finish::Painted([0.6, 0.6, 0.5]), at(Vec3::new(0.12, 0.23, 0.0)));
    let head = Node { rotation: Quat::from_rotation_z(FRAC_PI_2), ..at(Vec3::new(0.05, 0.88, 0.0)) };
    setup.put(primitives::capsule(0.12, 0.4, 48, 12), body, head);
    check(setup);
}
