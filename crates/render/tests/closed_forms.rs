//! Radiance of simple surfaces against formulas that are written again here, in f64 and from the papers: brushed metal,
//! films on metal, two-sided planes from both sides, colours of vertices, and lit panes that are blended.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{plain_request, renderer};
use glam::{DVec3, Quat, Vec3};
use manypass::{Environment, Path, Renderer};
use manypass_scene::material::{Anisotropy, Iridescence, TexturedFactor};
use manypass_scene::{
    AlphaMode, Light, LightKind, Material, Node, Primitive, Projection, Scene, ShadingModel, primitives,
};
use manypass_testkit::build::{SceneBuilder, at, grey};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

const SIDE: u32 = 64;
const PATHS: [Path; 4] = [Path::Forward, Path::Deferred, Path::ForwardBatched, Path::Gouraud];

/// A picture of 2 m, seen from 5 m above with parallel rays: the eye looks along the normal everywhere.
fn seen_from_above() -> SceneBuilder {
    SceneBuilder::new(Vec3::Y * 5.0, Vec3::ZERO, Projection::Orthographic { height_m: 2.0, near_m: 0.1, far_m: 20.0 })
}

fn radiance(renderer: &mut Renderer, scene: &Scene, path: Path, environment: Environment) -> Vec<DVec3> {
    let request = plain_request(scene, (SIDE, SIDE)).with(|settings| {
        settings.render.path = path;
        settings.environment.source = environment;
    });
    renderer.load(scene).unwrap();
    renderer.render(scene, &request).unwrap();
    let pixels = renderer.read_radiance().unwrap();
    pixels.chunks_exact(4).map(|pixel| DVec3::new(pixel[0].into(), pixel[1].into(), pixel[2].into())).collect()
}

/// Where the middle of a pixel lies on the plane, in metres along X and Z.
fn place(pixel: usize) -> [f64; 2] {
    let side = SIDE as usize;
    [pixel % side, pixel / side].map(|k| 2.0 * (k as f64 + 0.5) / f64::from(SIDE) - 1.0)
}

/// The direction from a pixel's place to a lamp of one candela, 1 m above the middle, and its light across it in lux.
fn from_lamp(pixel: usize) -> (DVec3, f64) {
    let [x_m, z_m] = place(pixel);
    let to_lamp = DVec3::new(-x_m, 1.0, -z_m);
    (to_lamp.normalize(), to_lamp.length_squared().recip())
}

/// GGX times visibility times N·L, as wide as `alphas` along X and Z, of an eye that looks along the normal, +Y
/// (Burley 2012; Heitz 2014, height-correlated).
fn lobe([along_x, along_z]: [f64; 2], to_light: DVec3) -> f64 {
    let halfway = (to_light + DVec3::Y).normalize();
    let stretched = (halfway.x / along_x).powi(2) + (halfway.z / along_z).powi(2) + halfway.y.powi(2);
    let distribution = 1.0 / (PI * along_x * along_z * stretched * stretched);
    let slope_squared = ((along_x * to_light.x).powi(2) + (along_z * to_light.z).powi(2)) / to_light.y.powi(2);
    let hidden = 0.5 * ((1.0 + slope_squared).sqrt() - 1.0);
    distribution / (4.0 * (1.0 + hidden))
}

/// The share of even light that the lobe reflects, by an integral over all directions above.
fn albedo(alphas: [f64; 2]) -> f64 {
    const STEPS: u32 = 300;
    let [polar_step, azimuth_step] = [FRAC_PI_2, TAU].map(|range| range / f64::from(STEPS));
    let of = |i: u32| {
        let polar = (f64::from(i / STEPS) + 0.5) * polar_step;
        let (sin, cos) = ((f64::from(i % STEPS) + 0.5) * azimuth_step).sin_cos();
        lobe(alphas, DVec3::new(polar.sin() * cos, polar.cos(), polar.sin() * sin)) * polar.sin()
    };
    (0..STEPS * STEPS).map(of).sum::<f64>() * polar_step * azimuth_step
}

/// A grey surface, after glTF's appendix B with energy compensation (Lagarde & Golubev 2018).
#[derive(Clone, Copy, Debug)]
struct Surface {
    base: f64,
    metallic: f64,
    alphas: [f64; 2],
    albedo: f64,
}

impl Surface {
    fn new(base: f64, metallic: f64, alphas: [f64; 2]) -> Self {
        Self { base, metallic, alphas, albedo: albedo(alphas) }
    }

    /// What 1 lx across this direction is reflected as, along the normal.
    fn reflected(&self, to_light: DVec3) -> f64 {
        let f0 = 0.04 + (self.base - 0.04) * self.metallic;
        let view_dot_half = (0.5 * (1.0 + to_light.y)).sqrt();
        let fresnel = f0 + (1.0 - f0) * (1.0 - view_dot_half).powi(5);
        let compensation = 1.0 + f0 * (1.0 / self.albedo - 1.0);
        let diffuse = self.base * (1.0 - self.metallic) * (1.0 - fresnel) / PI * to_light.y;
        diffuse + fresnel * compensation * lobe(self.alphas, to_light)
    }
}

/// The least and the greatest ratio of what was found to what is expected at each pixel.
fn ratios(found: &[DVec3], expected: impl Fn(usize) -> f64) -> [f64; 2] {
    let ratios = found.iter().enumerate().map(|(pixel, found)| found.x / expected(pixel));
    ratios.fold([f64::MAX, f64::MIN], |[least, most], ratio| [least.min(ratio), most.max(ratio)])
}

#[test]
fn brushed_metal_is_a_stretched_lobe() {
    let mut renderer = renderer();
    // Compensation is read from the table of round lobes: that of the widest is 2 % too little.
    let metals = [(0.2f32, 0.8f32, 0.005), (0.3, 0.5, 0.01), (0.3, 0.8, 0.005), (0.5, 0.9, 0.025)];
    for (roughness, strength, tolerance) in metals {
        let across = f64::from(roughness).powi(2);
        let along = across + (1.0 - across) * f64::from(strength).powi(2);
        for is_turned in [false, true] {
            let rotation_rad = if is_turned { std::f32::consts::FRAC_PI_2 } else { 0.0 };
            let material = Material {
                metallic_factor: 1.0,
                roughness_factor: roughness,
                anisotropy: Some(Anisotropy { strength, rotation_rad, ..Anisotropy::default() }),
                ..grey(0.5)
            };
            let mut builder = seen_from_above();
            builder.put(primitives::plane(3.0), material, Node::default());
            builder.light(Light::default(), Vec3::Y, Vec3::NEG_Y);
            let scene = builder.finish();
            let alphas = if is_turned { [across, along] } else { [along, across] };
            let metal = Surface::new(0.5, 1.0, alphas);
            for path in [Path::Forward, Path::Deferred] {
                let found = radiance(&mut renderer, &scene, path, Environment::None);
                let by_lamp = |metal: &Surface, pixel| {
                    let (to_lamp, lux) = from_lamp(pixel);
                    metal.reflected(to_lamp) * lux
                };
                let [least, most] = ratios(&found, |pixel| by_lamp(&metal, pixel));
                println!("{roughness}, {strength}, {path:?}: {least:.4} to {most:.4}");
                assert!(
                    least > 1.0 - tolerance && most < 1.0 + tolerance,
                    "roughness {roughness}, strength {strength}, {path:?}: {least} to {most} of the formula"
                );
                let round = Surface { alphas: [across; 2], ..metal };
                let [least, most] = ratios(&found, |pixel| by_lamp(&round, pixel));
                assert!(most > 2.0 * least, "a round lobe would do: {least} to {most}");
            }
        }
    }
}

/// The colour matching functions of the CIE's observer of 1931 at a wavelength in nanometres (Wyman, Sloan & Shirley
/// 2013, the fit of several lobes).
fn observer(wavelength_nm: f64) -> DVec3 {
    let bump = |middle: f64, below: f64, above: f64| {
        let width = if wavelength_nm < middle { below } else { above };
        (-0.5 * ((wavelength_nm - middle) * width).powi(2)).exp()
    };
    DVec3::new(
        1.056 * bump(599.8, 0.0264, 0.0323) + 0.362 * bump(442.0, 0.0624, 0.0374) - 0.065 * bump(501.1, 0.0490, 0.0382),
        0.821 * bump(568.8, 0.0213, 0.0247) + 0.286 * bump(530.9, 0.0613, 0.0322),
        1.217 * bump(437.0, 0.0845, 0.0278) + 0.681 * bump(459.0, 0.0385, 0.0725),
    )
}

/// What a film of a refractive index reflects at normal incidence on grey metal of reflectance `f0` (Airy's formula:
/// all orders at once), as linear Rec. 709. As in Belcour & Barla 2017 the mean over all phases is white, and what
/// differs from it is seen by light of even power.
fn airy(f0: f64, film_ior: f64, thickness_nm: f64) -> DVec3 {
    let metal_ior = (1.0 + f0.sqrt()) / (1.0 - f0.sqrt());
    let outer = (1.0 - film_ior) / (1.0 + film_ior);
    let inner = (film_ior - metal_ior) / (film_ior + metal_ior);
    let (squares, product) = (outer * outer + inner * inner, outer * inner);
    let mean = (squares - 2.0 * product * product) / (1.0 - product * product);
    let (mut sum, mut luminance) = (DVec3::ZERO, 0.0);
    for wavelength_nm in (380..=780).map(f64::from) {
        let cosine = (4.0 * PI * film_ior * thickness_nm / wavelength_nm).cos();
        let reflectance = (squares + 2.0 * product * cosine) / (1.0 + product * product + 2.0 * product * cosine);
        let seen = observer(wavelength_nm);
        sum += seen * (reflectance - mean);
        luminance += seen.y;
    }
    let xyz = sum / luminance;
    let rgb = DVec3::new(
        DVec3::new(3.2404542, -1.5371385, -0.4985314).dot(xyz),
        DVec3::new(-0.969266, 1.8760108, 0.041556).dot(xyz),
        DVec3::new(0.0556434, -0.2040259, 1.0572252).dot(xyz),
    );
    (rgb + mean).clamp(DVec3::ZERO, DVec3::ONE)
}

#[test]
fn a_film_on_metal_reflects_as_airys_formula_says() {
    let mut renderer = renderer();
    // The fits of the paper have fewer and other lobes, and two orders of interference: of films of a high index more
    // are seen.
    let films = [(1.3, 300.0), (1.3, 550.0), (1.6, 200.0), (1.6, 300.0), (1.6, 400.0), (2.0, 300.0), (2.0, 550.0)];
    for f0 in [0.5f32, 0.9] {
        let mut all = Vec::new();
        for (ior, thickness_max_nm) in films {
            let film =
                Iridescence { weight: TexturedFactor::new(1.0), ior, thickness_max_nm, ..Iridescence::default() };
            let material =
                Material { metallic_factor: 1.0, roughness_factor: 0.0, iridescence: Some(film), ..grey(f0) };
            let mut builder = seen_from_above();
            builder.put(primitives::plane(3.0), material, Node::default());
            let scene = builder.finish();
            let even = Environment::Color([1.0; 3]);
            let found = radiance(&mut renderer, &scene, Path::Forward, even)[(SIDE * SIDE / 2 + SIDE / 2) as usize];
            let expected = airy(f0.into(), ior.into(), thickness_max_nm.into());
            let worst = (found - expected).abs().max_element();
            let tolerance = if ior < 1.8 { 0.02 } else { 0.035 };
            println!("{f0}, index {ior}, {thickness_max_nm} nm: {found:.3}, expected {expected:.3}");
            assert!(worst < tolerance, "{f0}, index {ior}, {thickness_max_nm} nm: {found}, expected {expected}");
            all.push(found);
        }
        let colours = all.iter().map(|found| found.max_element() - found.min_element());
        assert!(colours.fold(0.0, f64::max) > 0.1, "the films of {f0} have no colour");
    }
}

/// A plane in the light of a sun of 3 lx, which stands at an angle from the vertical, above or below.
fn sunlit(plane: Primitive, material: Material, node: Node, to_light: DVec3) -> Scene {
    let mut builder = seen_from_above();
    builder.put(plane, material, node);
    let sun = Light { kind: LightKind::Directional, intensity: 3.0, ..Light::default() };
    builder.light(sun, Vec3::ZERO, -to_light.as_vec3());
    builder.finish()
}

#[test]
fn both_sides_of_a_plane_take_light_from_their_own_side() {
    let mut renderer = renderer();
    let rough = Surface::new(0.8, 0.0, [1.0; 2]);
    let over = Node { rotation: Quat::from_rotation_x(std::f32::consts::PI), ..Node::default() };
    for (angle_rad, is_above) in [(0.0f64, true), (0.6, true), (1.2, true), (0.6, false), (1.2, false)] {
        let height = if is_above { angle_rad.cos() } else { -angle_rad.cos() };
        let to_light = DVec3::new(0.0, height, angle_rad.sin());
        let expected = if is_above { 3.0 * rough.reflected(to_light) } else { 0.0 };
        for (node, side) in [(Node::default(), "front"), (over.clone(), "back")] {
            let material = Material { double_sided: true, roughness_factor: 1.0, ..grey(0.8) };
            let scene = sunlit(primitives::plane(3.0), material, node.clone(), to_light);
            for path in PATHS {
                let found = radiance(&mut renderer, &scene, path, Environment::None);
                // The G-buffer has base colours in 8 bits.
                let is_near = |found: &DVec3| (found.x - expected).abs() <= 0.005 * expected;
                assert!(
                    found.iter().all(is_near),
                    "{side}, {path:?}, {angle_rad}: {}, expected {expected}",
                    found[found.len() / 2]
                );
            }
        }
    }
    // What has one side is not there from behind.
    let scene = sunlit(primitives::plane(3.0), grey(0.8), over, DVec3::Y);
    let found = radiance(&mut renderer, &scene, Path::Forward, Environment::None);
    assert!(found.iter().all(|found| *found == DVec3::ZERO));
}

#[test]
fn colours_of_vertices_are_linear_and_multiply_the_base_colour() {
    let mut renderer = renderer();
    let mut plane = primitives::plane(2.0);
    plane.colors = plane.positions.iter().map(|[x, _, z]| [0.5 + 0.4 * x, 0.5 - 0.4 * z, 0.3, 1.0]).collect();
    let factor = Vec3::new(0.5, 0.8, 1.0);
    let base = |pixel: usize| {
        let [x, z] = place(pixel);
        DVec3::new(0.5 + 0.4 * x, 0.5 - 0.4 * z, 0.3) * factor.as_dvec3()
    };
    let to_light = DVec3::new(0.0, 0.6f64.cos(), 0.6f64.sin());
    // Reflectance is linear in a dielectric's base colour.
    let [black, white] = [0.0, 1.0].map(|base| 3.0 * Surface::new(base, 0.0, [1.0; 2]).reflected(to_light));
    for shading_model in [ShadingModel::Unlit, ShadingModel::Standard] {
        let material = Material {
            shading_model,
            base_color_factor: factor.extend(1.0),
            metallic_factor: 0.0,
            roughness_factor: 1.0,
            ..Material::default()
        };
        let scene = sunlit(plane.clone(), material, Node::default(), to_light);
        let is_unlit = shading_model == ShadingModel::Unlit;
        for path in PATHS {
            let found = radiance(&mut renderer, &scene, path, Environment::None);
            let off = |(pixel, found): (usize, &DVec3)| {
                let expected = if is_unlit { base(pixel) } else { black + (white - black) * base(pixel) };
                (*found - expected).abs().max_element()
            };
            let worst = found.iter().enumerate().map(off).fold(0.0, f64::max);
            // The G-buffer has base colours in 8 bits.
            let tolerance = if path == Path::Deferred && !is_unlit { 0.006 } else { 0.0015 };
            assert!(worst < tolerance, "{shading_model:?}, {path:?}: off by {worst}");
        }
    }
}

/// Alpha says what share of a pixel the surface covers, so that its highlight is multiplied by it as its colour is.
#[test]
fn alpha_multiplies_all_that_a_pane_reflects() {
    const BEHIND: f32 = 0.3;
    let mut renderer = renderer();
    let glossy = Surface::new(0.2, 0.0, [0.09; 2]);
    for alpha in [0.25f32, 0.43, 0.8] {
        let pane = Material {
            base_color_factor: Vec3::splat(0.2).extend(alpha),
            roughness_factor: 0.3,
            alpha_mode: AlphaMode::Blend,
            ..grey(0.2)
        };
        let wall = Material { shading_model: ShadingModel::Unlit, ..grey(BEHIND) };
        let mut builder = seen_from_above();
        builder.put(primitives::plane(3.0), pane, Node::default());
        builder.put(primitives::plane(3.0), wall, at(Vec3::NEG_Y * 0.5));
        builder.light(Light::default(), Vec3::Y, Vec3::NEG_Y);
        let scene = builder.finish();
        let share = f64::from(alpha);
        for path in [Path::Forward, Path::Deferred] {
            let found = radiance(&mut renderer, &scene, path, Environment::None);
            let [least, most] = ratios(&found, |pixel| {
                let (to_lamp, lux) = from_lamp(pixel);
                share * glossy.reflected(to_lamp) * lux + (1.0 - share) * f64::from(BEHIND)
            });
            assert!(least > 0.996 && most < 1.004, "alpha {alpha}, {path:?}: {least} to {most} of the formula");
        }
    }
}
