//! Layers of materials: what they make of even light from everywhere, by environments and by lights.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{plain_request, radiance, renderer};
use glam::{Vec3, Vec4};
use manypass::gpu::Floor;
use manypass::{Background, Environment, FrameRequest, Gpu, Path, Renderer};
use manypass_scene::material::{
    Anisotropy, Clearcoat, DiffuseTransmission, Iridescence, Material, Sheen, Specular, TexturedFactor, Volume,
};
use manypass_scene::{
    AlphaMode, Image, ImageSource, MorphTarget, PixelFormat, Pixels, Projection, Sampler, Scene, ShadingModel, Skin,
    Texture, TextureRef, TextureTransform, primitives,
};
use manypass_testkit::build::{SceneBuilder, at};
use manypass_testkit::raycast::Options;
use manypass_testkit::scenes::{self, FURNACE_ROUGHNESS};

const SIZE: (u32, u32) = (128, 52);

fn white() -> Material {
    Material { base_color_factor: Vec4::ONE, metallic_factor: 0.0, ..Material::default() }
}

fn coat(roughness: f32) -> Clearcoat {
    Clearcoat {
        weight: TexturedFactor::new(1.0),
        roughness: TexturedFactor::new(roughness),
        normal_texture: None,
        normal_scale: 1.0,
    }
}

fn sheen(color: f32, roughness: f32) -> Sheen {
    Sheen { color: TexturedFactor::new(Vec3::splat(color)), roughness: TexturedFactor::new(roughness) }
}

fn scattering(weight: f32) -> DiffuseTransmission {
    DiffuseTransmission { weight: TexturedFactor::new(weight), color: TexturedFactor::new(Vec3::ONE) }
}

/// Every layer on white, alone and together; and the least of the light that it may keep, of dielectrics and of metals.
/// Each of them lets all of it out again but a film and coloured specular light: glTF takes the greatest of the three
/// colours from what enters the surface below.
fn models() -> Vec<(&'static str, Material, [f32; 2])> {
    let specular = Specular {
        weight: TexturedFactor::new(0.4),
        color: TexturedFactor::new(Vec3::new(1.0, 0.5, 2.0)),
        glossiness: None,
    };
    let film = Iridescence { weight: TexturedFactor::new(1.0), ..Iridescence::default() };
    let glass = Material { transmission: Some(TexturedFactor::new(1.0)), ..white() };
    let volume = Volume { thickness: TexturedFactor::new(0.3), ..Volume::default() };
    vec![
        ("plain", white(), [1.0; 2]),
        ("clear coat", Material { clearcoat: Some(coat(0.1)), ..white() }, [1.0; 2]),
        ("rough clear coat", Material { clearcoat: Some(coat(0.7)), ..white() }, [1.0; 2]),
        ("white sheen", Material { sheen: Some(sheen(1.0, 0.5)), ..white() }, [1.0; 2]),
        (
            "sheen below a clear coat",
            Material { sheen: Some(sheen(0.5, 0.9)), clearcoat: Some(coat(0.3)), ..white() },
            [1.0; 2],
        ),
        (
            "grey specular",
            Material { specular: Some(Specular { color: TexturedFactor::new(Vec3::ONE), ..specular }), ..white() },
            [1.0; 2],
        ),
        ("coloured specular", Material { specular: Some(specular), ..white() }, [0.93, 1.0]),
        ("total reflection", Material { ior: 0.0, ..white() }, [1.0; 2]),
        ("diamond", Material { ior: 2.42, ..white() }, [1.0; 2]),
        (
            "anisotropy",
            Material { anisotropy: Some(Anisotropy { strength: 0.8, ..Anisotropy::default() }), ..white() },
            [1.0; 2],
        ),
        ("film", Material { iridescence: Some(film), ..white() }, [0.8, 0.9]),
        ("thin glass", glass.clone(), [1.0; 2]),
        ("glass", Material { volume: Some(volume), ..glass.clone() }, [1.0; 2]),
        ("glass that disperses", Material { volume: Some(volume), dispersion: 1.0, ..glass.clone() }, [1.0; 2]),
        ("glass below a clear coat", Material { clearcoat: Some(coat(0.0)), ..glass }, [1.0; 2]),
        ("unlit", Material { shading_model: ShadingModel::Unlit, ..white() }, [1.0; 2]),
        (
            "specular and glossiness",
            Material {
                specular: Some(Specular {
                    color: TexturedFactor::new(Vec3::splat(25.0)),
                    glossiness: Some(0.6),
                    ..Specular::default()
                }),
                ..white()
            },
            [1.0; 2],
        ),
        ("leaf", Material { diffuse_transmission: Some(scattering(0.7)), ..white() }, [1.0; 2]),
    ]
}

/// `scene` with all its surfaces of `material`, each as rough and as metallic as before where it is so.
fn dressed(mut scene: Scene, material: &Material) -> Scene {
    scene.lights.clear();
    scene.nodes.iter_mut().for_each(|node| node.light = None);
    for surface in &mut scene.materials {
        *surface = Material { roughness_factor: surface.roughness_factor, ..material.clone() };
    }
    scene
}

/// From a mirror to the roughest.
const ROUGHNESS: [f32; 5] = [0.0, 0.15, 0.4, 0.7, 1.0];

/// Of every roughness a dielectric and a metal of each model.
#[test]
fn white_layers_vanish_in_an_even_environment() {
    let mut renderer = renderer();
    for (name, material, least) in models() {
        let mut scene = dressed(scenes::furnace(0, [1.0; 2]).scene, &material);
        for (at, surface) in scene.materials.iter_mut().enumerate() {
            surface.roughness_factor = ROUGHNESS[at / 2];
            surface.metallic_factor = (at % 2) as f32;
        }
        renderer.load(&scene).unwrap();
        for path in [Path::Deferred, Path::Forward, Path::ForwardBatched, Path::Gouraud] {
            let request = plain_request(&scene, SIZE).with(|settings| {
                settings.render.path = path;
                settings.environment.source = Environment::Color([1.0; 3]);
                settings.background.source = Background::Environment;
            });
            renderer.render(&scene, &request).unwrap();
            let pixels = renderer.read_radiance().unwrap();
            // Dielectrics are in the upper half.
            for (half, least) in pixels.chunks(pixels.len() / 2).zip(least) {
                let colours = half.chunks_exact(4).flat_map(|pixel| &pixel[..3]);
                let range = colours.fold((f32::MAX, 0.0f32), |(low, high), v| (low.min(*v), high.max(*v)));
                assert!(range.0 > least - 0.01 && range.1 < 1.01, "{name}, {path:?}: from {} to {}", range.0, range.1);
            }
        }
    }
}

/// Means over spheres in the parts that are seen at angles of so much cosine.
fn means(scene: &Scene, request: &FrameRequest, inside: &[Vec<usize>]) -> Vec<f64> {
    let pixels = radiance(scene, request);
    let mean = |at: &Vec<usize>| at.iter().map(|at| f64::from(pixels[*at][1])).sum::<f64>() / at.len() as f64;
    inside.iter().map(mean).collect()
}

#[test]
fn lights_from_everywhere_are_an_even_environment_for_layers() {
    const SUNS: u16 = 3072;
    let test = scenes::furnace(SUNS, [1.0; 2]);
    let truth = test.world.render(SIZE.0 as usize, SIZE.1 as usize, Options::default());
    // The upper spheres, in three bands of N·V.
    let bands = [(0.3, 0.5), (0.5, 0.75), (0.75, 1.01)];
    let inside: Vec<Vec<usize>> = (0..FURNACE_ROUGHNESS.len())
        .flat_map(|column| bands.map(|band| (column, band)))
        .map(|(column, (low, high))| {
            let is_inside = |at: &usize| {
                let n_dot_v = truth.normal_world[*at].z;
                truth.object_id[*at] == 2 * column as u32 + 1 && (low..high).contains(&n_dot_v)
            };
            (0..truth.object_id.len()).filter(is_inside).collect()
        })
        .collect();
    let black = Material { base_color_factor: Vec3::ZERO.extend(1.0), ..white() };
    let film = Iridescence { weight: TexturedFactor::new(1.0), ..Iridescence::default() };
    let stretched = Anisotropy { strength: 0.5, ..Anisotropy::default() };
    let metal = Material { metallic_factor: 1.0, ..white() };
    let cases = [
        ("coat on black", Material { clearcoat: Some(coat(0.4)), ..black.clone() }, 0.03),
        // White dielectrics reflect a few per cent too much of lights at grazing angles, as glTF's appendix B has it.
        ("coat on white", Material { clearcoat: Some(coat(0.4)), ..white() }, 0.07),
        ("sheen on black", Material { sheen: Some(sheen(0.8, 0.5)), ..black.clone() }, 0.03),
        ("a leaf", Material { diffuse_transmission: Some(scattering(0.5)), ..white() }, 0.07),
        (
            "specular",
            Material { specular: Some(Specular { weight: TexturedFactor::new(0.5), ..Specular::default() }), ..black },
            0.03,
        ),
        // Compensation is that of lobes that are round.
        ("anisotropy", Material { anisotropy: Some(stretched), ..metal.clone() }, 0.06),
        ("a film on metal", Material { iridescence: Some(film), ..metal }, 0.04),
    ];
    for (name, material, tolerance) in cases {
        let mut by_lights = test.scene.clone();
        let mut by_environment = dressed(test.scene.clone(), &material);
        for (lit, surface) in by_lights.materials.iter_mut().zip(&mut by_environment.materials) {
            lit.clone_from(surface);
        }
        by_environment.update_transforms();
        let lights = plain_request(&by_lights, SIZE);
        let environment = plain_request(&by_environment, SIZE)
            .with(|settings| settings.environment.source = Environment::Color([1.0; 3]));
        let found = means(&by_lights, &lights, &inside);
        let expected = means(&by_environment, &environment, &inside);
        for (at, (found, expected)) in found.iter().zip(&expected).enumerate() {
            let off = found / expected - 1.0;
            let (roughness, band) = (FURNACE_ROUGHNESS[at / 3], bands[at % 3]);
            assert!(
                off.abs() < tolerance,
                "{name} at roughness {roughness}, N·V {band:?}: {found:.4} by lights, {expected:.4} by the environment"
            );
        }
    }
}

#[test]
fn glass_shows_what_lies_behind_in_its_colour() {
    // Glass that reflects nothing and is nothing but colour.
    let test = scenes::rows_of_spheres();
    let material = Material {
        base_color_factor: Vec4::new(0.25, 0.5, 1.0, 1.0),
        transmission: Some(TexturedFactor::new(1.0)),
        specular: Some(Specular { weight: TexturedFactor::new(0.0), ..Specular::default() }),
        ..white()
    };
    let scene = dressed(test.scene, &material);
    let request = plain_request(&scene, SIZE).with(|settings| {
        settings.environment.source = Environment::Color([1.0; 3]);
        settings.background.source = Background::Environment;
        // All of the scene is glass: through more of it the colour would be multiplied more than once.
        settings.transparency.refractive_layers = 1;
    });
    let pixels = radiance(&scene, &request);
    let through = pixels.iter().filter(|pixel| (pixel[0] - 0.25).abs() < 0.01).count();
    assert!(through > 500, "{through} pixels");
    for pixel in &pixels {
        // Edges have no second sample: a pixel is glass or background.
        let is_glass = (Vec3::from(*pixel) - Vec3::new(0.25, 0.5, 1.0)).abs().max_element() < 0.01;
        let is_background = (Vec3::from(*pixel) - Vec3::ONE).abs().max_element() < 0.01;
        assert!(is_glass || is_background, "{pixel:?}");
    }
    // Before nothing the picture is as transparent as the glass.
    let request = request.with(|settings| settings.background.source = Background::Transparent);
    let mut renderer = renderer();
    renderer.load(&scene).unwrap();
    renderer.render(&scene, &request).unwrap();
    let alphas: Vec<f32> = renderer.read_radiance().unwrap().chunks_exact(4).map(|p| p[3]).collect();
    let expected = 1.0 - (0.25 + 0.5 + 1.0) / 3.0;
    let of_glass = alphas.iter().filter(|alpha| (**alpha - expected).abs() < 0.01).count();
    assert!(of_glass.abs_diff(through) < 20, "{of_glass} of {through} pixels");
}

#[test]
fn what_is_masked_and_layered_has_holes() {
    let test = scenes::rows_of_spheres();
    let material = Material {
        base_color_factor: Vec4::new(1.0, 1.0, 1.0, 0.4),
        alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
        clearcoat: Some(coat(0.1)),
        ..white()
    };
    let scene = dressed(test.scene, &material);
    for path in [Path::Deferred, Path::Forward] {
        let request = plain_request(&scene, SIZE).with(|settings| {
            settings.render.path = path;
            settings.environment.source = Environment::Color([1.0; 3]);
            settings.background.source = Background::Transparent;
        });
        assert!(radiance(&scene, &request).iter().flatten().all(|value| *value == 0.0), "{path:?}");
    }
}

/// A white card under a green pane and, above that and beside it, a red one, seen from above.
fn panes() -> Scene {
    let projection = Projection::Perspective { fov_y_rad: 0.4, near_m: 0.1, far_m: None };
    let mut builder = SceneBuilder::new(Vec3::Y * 5.0, Vec3::ZERO, projection);
    let card = Material { shading_model: ShadingModel::Unlit, ..white() };
    builder.put(primitives::plane(8.0), card, at(Vec3::NEG_Y));
    let pane = |color: Vec3| Material {
        base_color_factor: color.extend(1.0),
        roughness_factor: 0.0,
        transmission: Some(TexturedFactor::new(1.0)),
        ..white()
    };
    builder.put(primitives::plane(1.0), pane(Vec3::new(0.2, 0.9, 0.3)), at(Vec3::new(0.25, 0.0, 0.0)));
    builder.put(primitives::plane(1.0), pane(Vec3::new(0.8, 0.3, 0.2)), at(Vec3::new(-0.25, 0.5, 0.0)));
    builder.finish()
}

#[test]
fn glass_is_seen_through_glass() {
    let scene = panes();
    let (red, green) = (Vec3::new(0.8, 0.3, 0.2), Vec3::new(0.2, 0.9, 0.3));
    for path in [Path::Deferred, Path::Forward] {
        for layers in [None, Some(1), Some(2)] {
            let request = plain_request(&scene, SIZE).with(|settings| {
                settings.render.path = path;
                settings.transparency.refractive_layers = layers.unwrap_or(settings.transparency.refractive_layers);
            });
            let found = radiance(&scene, &request);
            // Where rays of the middle row meet the panes' heights.
            let pixel = |x_m: f32, height_m: f32| {
                let half_m = 0.2f32.tan() * (5.0 - height_m);
                let column = (0.5 * SIZE.0 as f32 + x_m / half_m * 0.5 * SIZE.1 as f32) as usize;
                Vec3::from(found[SIZE.1 as usize / 2 * SIZE.0 as usize + column])
            };
            let behind = if layers == Some(1) { red } else { red * green };
            for (name, found, expected) in [
                ("red", pixel(-0.6, 0.5), red),
                ("green", pixel(0.6, 0.0), green),
                ("both", pixel(0.0, 0.25), behind),
                ("none", pixel(-1.4, 0.0), Vec3::ONE),
            ] {
                // What is reflected of either side is missing: at most 4 % of each pane.
                let ratio = found / expected;
                assert!(
                    ratio.min_element() > 0.9 && ratio.max_element() < 1.001,
                    "{path:?} {layers:?} {name}: {found}"
                );
            }
        }
    }
}

#[test]
fn occlusion_in_the_texture_of_metallic_roughness_keeps_light_from_layers() {
    // Red is occlusion: a quarter of the light arrives. Green and blue are neither rough nor metal to speak of.
    let data = vec![64, 255, 0, 255];
    let pixels = Pixels { width: 1, height: 1, format: PixelFormat::Rgba8, data };
    let mut scene = scenes::furnace(0, [1.0; 2]).scene;
    scene.images = vec![Image { name: String::new(), source: ImageSource::Pixels(pixels.into()) }];
    scene.textures = vec![Texture { image: 0, sampler: Sampler::default() }];
    let texture = Some(TextureRef { texture: 0, uv_set: 0, transform: TextureTransform::default() });
    for path in [Path::Deferred, Path::Forward] {
        let lit = |occlusion_texture, clearcoat: Option<Clearcoat>| {
            let material = Material { metallic_roughness_texture: texture, occlusion_texture, clearcoat, ..white() };
            let scene = dressed(scene.clone(), &material);
            let request = plain_request(&scene, SIZE).with(|settings| {
                settings.render.path = path;
                settings.environment.source = Environment::Color([1.0; 3]);
            });
            radiance(&scene, &request).iter().map(|pixel| f64::from(pixel[1])).sum::<f64>()
        };
        for clearcoat in [None, Some(coat(0.3))] {
            let share = lit(texture, clearcoat) / lit(None, clearcoat);
            assert!(share < 0.5, "{path:?}, {}: {share}", if clearcoat.is_some() { "coated" } else { "plain" });
        }
    }
}

/// A ball with a clear coat, as `deform` makes it of one that is not deformed.
fn coated_ball(deform: impl Fn(&mut Scene, &mut manypass_scene::Primitive) -> Option<usize>) -> Scene {
    let projection = Projection::Perspective { fov_y_rad: 0.7, near_m: 0.1, far_m: None };
    let mut builder = SceneBuilder::new(Vec3::Z * 4.0, Vec3::ZERO, projection);
    let mut ball = primitives::uv_sphere(1.0, 16, 8);
    let skin = deform(&mut builder.scene, &mut ball);
    builder.put(ball, Material { clearcoat: Some(coat(0.1)), ..white() }, at(Vec3::ZERO));
    let mut scene = builder.finish();
    let node = scene.nodes.iter().position(|node| node.mesh.is_some()).unwrap();
    scene.nodes[node].skin = skin;
    scene.update_transforms();
    scene
}

#[test]
fn layers_of_what_is_deformed_are_missed_on_webgl_2_alone_and_a_warning_says_so() {
    let plain = coated_ball(|_, _| None);
    let morphed = coated_ball(|_, ball| {
        let positions = vec![[0.1, 0.0, 0.0]; ball.positions.len()];
        ball.morph_targets = vec![MorphTarget { positions, ..MorphTarget::default() }];
        None
    });
    let skinned = coated_ball(|scene, ball| {
        ball.joints = vec![[0; 4]; ball.positions.len()];
        ball.weights = vec![[1.0, 0.0, 0.0, 0.0]; ball.positions.len()];
        let joint = scene.add_node(None, Default::default());
        scene.skins.push(Skin { joints: vec![joint], inverse_bind_matrices: Vec::new() });
        Some(0)
    });
    for (floor, layers_deform) in [(Floor::WebGpu, true), (Floor::WebGl2, false)] {
        let mut renderer = Renderer::new(Gpu::without_adapter(floor).unwrap()).unwrap();
        for (name, scene, is_deformed) in
            [("plain", &plain, false), ("morphed", &morphed, true), ("skinned", &skinned, true)]
        {
            renderer.load(scene).unwrap();
            let is_lost = is_deformed && !layers_deform;
            let plan = renderer.plan(scene, &plain_request(scene, SIZE)).unwrap();
            let is_layered = plan.passes.iter().any(|pass| pass.name == "layered");
            assert_eq!(is_layered, !is_lost, "{floor:?}, {name}");
            let warnings = renderer.warnings();
            let says_so = warnings.iter().any(|warning| warning.contains("too few textures for materials with layers"));
            assert_eq!(says_so, is_lost, "{floor:?}, {name}: {warnings:?}");
        }
    }
}
