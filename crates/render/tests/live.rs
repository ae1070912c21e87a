//! A scene that is edited between frames: every picture is that of the edited scene loaded anew, and only what changed
//! is uploaded.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{floats, plain_request, renderer};
use glam::{Mat4, Quat, Vec3, Vec4};
use manypass::graph::{PlannedAttachment, Target};
use manypass::{Aov, Averaging, Environment, FrameRequest, Ground, Path, Renderer};
use manypass_scene::image::ImageSource;
use manypass_scene::material::{Clearcoat, HeightMap, HeightMethod};
use manypass_scene::{
    AlphaMode, Camera, Image, Light, LightKind, Material, Mesh, MorphTarget, Node, NodeId, PixelFormat, Pixels,
    Primitive, Projection, Scene, ShadingModel, Skin, Texture, TextureRef, TextureTransform, TexturedFactor,
    primitives,
};
use manypass_testkit::scenes;
use std::sync::Arc;

/// Bytes of one instance and of the factors of one material.
const INSTANCE_BYTES: u64 = 72;
const MATERIAL_BYTES: u64 = 240;
/// Bytes of the factors of a material's layers.
const LAYER_BYTES: u64 = 720;
/// All instances, where others come first in the table.
const REORDERED: u64 = 40 * INSTANCE_BYTES;

fn chequer(colors: [[u8; 4]; 2]) -> ImageSource {
    let texel = |i: usize| colors[(i / 8 + i % 8) % 2];
    let data = (0..64).flat_map(texel).collect();
    ImageSource::Pixels(Arc::new(Pixels { width: 8, height: 8, format: PixelFormat::Rgba8, data }))
}

fn reference(texture: usize) -> Option<TextureRef> {
    Some(TextureRef { texture, uv_set: 0, transform: TextureTransform::default() })
}

fn add_mesh(scene: &mut Scene, primitive: Primitive, node: Node) -> NodeId {
    let mesh = Some(scene.meshes.len());
    scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() }.into());
    scene.add_node(None, Node { mesh, ..node })
}

/// Spheres under lights; a wall with textures, a glass plate, a cube with a morph target, a bent one, and points.
struct Studio {
    scene: Scene,
    sphere: NodeId,
    wall: NodeId,
    morphed: NodeId,
    joint: NodeId,
}

fn studio() -> Studio {
    let mut scene = scenes::rows_of_spheres().scene;
    let with_mesh = |(index, node): (usize, &Node)| node.mesh.map(|_| NodeId(index as u32));
    let sphere = scene.nodes.iter().enumerate().filter_map(with_mesh).nth(3).unwrap();
    for (name, colors) in
        [("paint", [[200, 60, 40, 255], [240, 240, 230, 255]]), ("bumps", [[128, 160, 240, 255], [128, 96, 240, 255]])]
    {
        scene.textures.push(Texture { image: scene.images.len(), sampler: Default::default() });
        scene.images.push(Image { name: name.into(), source: chequer(colors) });
    }
    let mut of_material = |material: Material| {
        scene.materials.push(material);
        Some(scene.materials.len() - 1)
    };
    let paint = of_material(Material { base_color_texture: reference(0), metallic_factor: 0.0, ..Default::default() });
    let bumpy = of_material(Material { normal_texture: reference(1), metallic_factor: 0.2, ..Default::default() });
    let base_color_factor = Vec4::new(0.3, 0.6, 0.9, 0.4);
    let glass = of_material(Material { base_color_factor, alpha_mode: AlphaMode::Blend, ..Default::default() });
    let cube = |size_m: f32, material| Primitive { material, ..primitives::cube(Vec3::splat(size_m)) };
    let at = |x: f32, y: f32, z: f32| Node { translation: Vec3::new(x, y, z), ..Node::default() };
    let wall = add_mesh(&mut scene, cube(1.0, paint), at(-1.0, 0.5, -0.5));
    add_mesh(&mut scene, cube(0.5, glass), at(0.6, 0.8, 0.9));
    let mut morphing = cube(0.6, bumpy);
    let positions = morphing.positions.iter().map(|position| [0.0, 0.6 * position[1].max(0.0), 0.0]).collect();
    morphing.morph_targets = vec![MorphTarget { positions, ..Default::default() }];
    let morphed = add_mesh(&mut scene, morphing, Node { morph_weights: vec![0.3], ..at(1.0, 0.4, 0.4) });
    let mut bent = cube(0.5, paint);
    bent.joints = bent.positions.iter().map(|position| [u16::from(position[1] > 0.0), 0, 0, 0]).collect();
    bent.weights = vec![[1.0, 0.0, 0.0, 0.0]; bent.positions.len()];
    let skinned = add_mesh(&mut scene, bent, at(-0.4, 0.3, 1.0));
    let joint = scene.add_node(None, at(-0.4, 0.4, 1.0));
    let inverse_bind_matrices = vec![Mat4::IDENTITY; 2];
    scene.skins.push(Skin { joints: vec![skinned, joint], inverse_bind_matrices });
    scene.node_mut(skinned).skin = Some(0);
    let mut dots = cube(0.4, bumpy);
    (dots.topology, dots.indices) = (manypass_scene::Topology::Points, vec![3, 1, 7, 11]);
    add_mesh(&mut scene, dots, at(0.0, 1.2, 0.5));
    scene.update_transforms();
    Studio { scene, sphere, wall, morphed, joint }
}

/// How it is drawn: the path, and whether it stands on a ground and casts shadows, which takes bytes of its own.
type Way = (Path, Ground);

fn request(scene: &Scene, (path, ground): Way) -> FrameRequest {
    let mut request = FrameRequest { averaging: Averaging::Both, ..plain_request(scene, (96, 64)) };
    request.settings.environment.source = Environment::Studio;
    request.settings.render.path = path;
    request.settings.ground.mode = ground;
    request.settings.shadows.enabled = ground != Ground::None;
    request
}

fn picture(renderer: &mut Renderer, scene: &Scene, way: Way) -> (Vec<u8>, Vec<f32>) {
    renderer.render(scene, &request(scene, way)).unwrap();
    (renderer.read_display().unwrap(), renderer.read_radiance().unwrap())
}

/// What was done, and how many bytes it may have uploaded.
type Edit = (&'static str, fn(&mut Studio), u64);

const EVERYTHING: u64 = u64::MAX;

fn edits() -> Vec<Edit> {
    vec![
        (
            "moves",
            |studio| studio.scene.node_mut(studio.sphere).translation += Vec3::new(0.02, 0.05, 0.0),
            INSTANCE_BYTES,
        ),
        ("changes a material", |studio| studio.scene.materials[0].base_color_factor.x *= 0.5, MATERIAL_BYTES),
        (
            "gives a material a texture",
            |studio| studio.scene.materials[0].base_color_texture = reference(0),
            MATERIAL_BYTES + REORDERED,
        ),
        (
            "replaces a texture",
            |studio| studio.scene.images[0].source = chequer([[10, 220, 30, 255], [0, 0, 90, 255]]),
            // Eight mips of four bytes a texel; no factor changes.
            4 * (64 + 16 + 4 + 1),
        ),
        (
            "paints into a texture",
            |studio| match &mut studio.scene.images[0].source {
                ImageSource::Pixels(pixels) => Arc::make_mut(pixels).data[..64].fill(200),
                _ => unreachable!(),
            },
            4 * (64 + 16 + 4 + 1),
        ),
        ("hides", |studio| studio.scene.node_mut(studio.wall).is_visible = false, REORDERED),
        ("shows again", |studio| studio.scene.node_mut(studio.wall).is_visible = true, REORDERED),
        (
            "adds",
            |studio| {
                let ball = Primitive { material: Some(1), ..primitives::uv_sphere(0.2, 12, 6) };
                let node = Node { translation: Vec3::new(0.3, 0.9, 1.2), ..Node::default() };
                add_mesh(&mut studio.scene, ball, node);
            },
            // 13 × 7 vertices, triangles of two a cell, and instances that moved on in the table.
            91 * 64 + 12 * 6 * 6 * 4 + REORDERED,
        ),
        ("removes", |studio| studio.scene.remove_node(studio.sphere), REORDERED),
        (
            "changes a mesh",
            |studio| {
                let mesh = studio.scene.node(studio.wall).mesh.unwrap();
                let primitive = &mut Arc::make_mut(&mut studio.scene.meshes[mesh]).primitives[0];
                primitive.positions.iter_mut().for_each(|position| position[1] *= 1.5);
                primitive.bounds.max.y *= 1.5;
                primitive.bounds.min.y *= 1.5;
            },
            24 * 64 + 36 * 4 + INSTANCE_BYTES,
        ),
        ("morphs", |studio| studio.scene.node_mut(studio.morphed).morph_weights = vec![0.9], 16),
        (
            "bends",
            |studio| studio.scene.node_mut(studio.joint).rotation = Quat::from_rotation_z(0.6),
            64 + INSTANCE_BYTES,
        ),
        (
            "changes a morph target",
            |studio| {
                let mesh = studio.scene.node(studio.morphed).mesh.unwrap();
                let target = &mut Arc::make_mut(&mut studio.scene.meshes[mesh]).primitives[0].morph_targets[0];
                target.positions.iter_mut().for_each(|position| position[0] += 0.2);
            },
            EVERYTHING,
        ),
        (
            "adds a light",
            |studio| {
                let light = Some(studio.scene.lights.len());
                let kind = LightKind::Point;
                studio.scene.lights.push(Light {
                    color_linear: Vec3::X,
                    intensity: 9.0,
                    range_m: Some(3.0),
                    kind,
                    ..Light::default()
                });
                studio.scene.add_node(None, Node { light, translation: Vec3::new(0.5, 1.5, 0.5), ..Node::default() });
            },
            EVERYTHING,
        ),
        (
            "drops meshes that nobody shows",
            |studio| {
                studio.scene.remove_node(studio.morphed);
                studio.scene.meshes.truncate(studio.scene.node(studio.morphed).mesh.unwrap());
                let known = studio.scene.meshes.len();
                studio.scene.nodes.iter_mut().for_each(|node| node.mesh = node.mesh.filter(|mesh| *mesh < known));
            },
            REORDERED,
        ),
        (
            "gives a material a clear coat with a map",
            |studio| {
                let map = TexturedFactor { factor: 1.0, texture: reference(0) };
                let roughness = TexturedFactor::new(0.1);
                studio.scene.materials[1].clearcoat =
                    Some(Clearcoat { weight: map, roughness, normal_texture: None, normal_scale: 1.0 });
            },
            MATERIAL_BYTES + LAYER_BYTES + 4 * (64 + 16 + 4 + 1) + REORDERED,
        ),
        (
            "makes a material of glass",
            |studio| studio.scene.materials[0].transmission = Some(TexturedFactor::new(0.9)),
            MATERIAL_BYTES + LAYER_BYTES + REORDERED,
        ),
        (
            "makes the coat rough",
            |studio| {
                let coat = studio.scene.materials[1].clearcoat.as_mut().unwrap();
                coat.roughness.factor = 0.6;
            },
            // The G-buffer tells rays how rough it is.
            MATERIAL_BYTES + LAYER_BYTES,
        ),
        ("takes the coat away", |studio| studio.scene.materials[1].clearcoat = None, MATERIAL_BYTES + REORDERED),
        (
            "shows a variant",
            |studio| {
                studio.scene.variants.push("glass".into());
                let mesh = studio.scene.node(studio.wall).mesh.unwrap();
                Arc::make_mut(&mut studio.scene.meshes[mesh]).primitives[0].variant_materials = vec![(0, 0)];
                studio.scene.variant = Some(0);
            },
            24 * 64 + 36 * 4 + REORDERED,
        ),
        ("shows no variant", |studio| studio.scene.variant = None, REORDERED),
        ("swaps materials", |studio| studio.scene.materials.swap(0, 1), 2 * (MATERIAL_BYTES + LAYER_BYTES) + REORDERED),
        ("drops a material", |studio| studio.scene.materials.truncate(4), EVERYTHING),
    ]
}

#[test]
fn an_edited_scene_is_the_edited_scene_loaded() {
    for way in [(Path::Deferred, Ground::None), (Path::Forward, Ground::None), (Path::Deferred, Ground::Shadow)] {
        let mut studio = studio();
        let mut live = renderer();
        let mut anew = Renderer::new(live.gpu().clone()).unwrap();
        let mut last = picture(&mut live, &studio.scene, way);
        for (what, edit, most_bytes) in edits() {
            // The bytes of a frame that changes nothing are none.
            assert!(picture(&mut live, &studio.scene, way) == last);
            assert_eq!(live.stats().uploaded_bytes, 0, "a frame before one that {what}");
            edit(&mut studio);
            studio.scene.update_transforms();
            let edited = picture(&mut live, &studio.scene, way);
            let uploaded = live.stats().uploaded_bytes;
            anew.unload();
            let loaded = picture(&mut anew, &studio.scene, way);
            assert!(edited == loaded, "{way:?}: a scene that {what} is another picture when it is loaded");
            assert!(edited != last || what.starts_with("drops"), "{way:?}: one sees nothing of a scene that {what}");
            assert!(
                uploaded <= most_bytes || way.1 != Ground::None,
                "{way:?}: a scene that {what} uploads {uploaded} bytes"
            );
            if way.1 == Ground::None && ["moves", "changes a material", "morphs"].contains(&what) {
                assert_eq!(live.stats().bind_groups_made, 0, "{way:?}: a scene that {what}");
            }
            last = edited;
        }
    }
}

/// What happens to the studio, and whether an opaque surface glows from then on.
type Glow = (&'static str, fn(&mut Scene), bool);

/// The last material of [`studio`] is that of the plate of glass; a lamp with a material of its own comes behind it.
const GLASS: usize = 13;
const LAMP: usize = 14;

fn glows() -> Vec<Glow> {
    fn lamp(scene: &mut Scene) -> &mut Node {
        scene.nodes.last_mut().unwrap()
    }
    vec![
        ("is dark", |_| (), false),
        ("has glass that emits, which is blended", |scene| scene.materials[GLASS].emissive_factor = Vec3::ONE, false),
        ("has a lamp that is shown", |scene| lamp(scene).is_visible = true, true),
        ("has a lamp that goes out", |scene| scene.materials[LAMP].emissive_factor = Vec3::ZERO, false),
        ("has an unlit lamp", |scene| scene.materials[LAMP].shading_model = ShadingModel::Unlit, true),
        ("has a lamp that is hidden", |scene| lamp(scene).is_visible = false, false),
    ]
}

#[test]
fn surfaces_are_drawn_into_radiance_only_while_one_glows() {
    let mut scene = studio().scene;
    assert_eq!((scene.materials.len(), scene.materials[GLASS].alpha_mode), (LAMP, AlphaMode::Blend));
    let emissive_factor = Vec3::new(0.25, 0.5, 0.125);
    scene.materials.push(Material { emissive_factor, base_color_factor: Vec4::splat(0.5), ..Default::default() });
    let cube = Primitive { material: Some(LAMP), ..primitives::cube(Vec3::splat(0.4)) };
    add_mesh(&mut scene, cube, Node { translation: Vec3::Y, is_visible: false, ..Node::default() });
    let mut live = renderer();
    let mut anew = Renderer::new(live.gpu().clone()).unwrap();
    for (what, edit, glows) in glows() {
        edit(&mut scene);
        scene.update_transforms();
        let edited = picture(&mut live, &scene, (Path::Deferred, Ground::None));
        anew.unload();
        assert!(
            edited == picture(&mut anew, &scene, (Path::Deferred, Ground::None)),
            "a studio that {what} is another one anew"
        );
        let request =
            FrameRequest { want_aovs: vec![Aov::Emission], ..request(&scene, (Path::Deferred, Ground::None)) };
        let plan = live.plan(&scene, &request).unwrap();
        let geometry = plan.passes.iter().find(|pass| pass.name == "geometry").unwrap();
        let is_color = |attachment: &&PlannedAttachment| matches!(attachment.target, Target::Color(_));
        let targets = geometry.attachments.iter().filter(is_color).count();
        assert_eq!(targets, if glows { 4 } else { 3 }, "targets of a studio that {what}");
        assert_eq!(plan.passes.iter().any(|pass| pass.name == "coverage"), !glows, "a studio that {what}");
        live.render(&scene, &request).unwrap();
        let emission = floats(live.read_aov(Aov::Emission).unwrap());
        let most = emission.iter().copied().fold(0.0, f32::max);
        // Half floats have 11 bits.
        let expected = if glows { 0.5 } else { 0.0 };
        assert!((most - expected).abs() <= 5e-4 * expected, "a studio that {what} emits {most}");
    }
}

#[test]
fn memory_is_given_back() {
    let mut studio = studio();
    let mut renderer = renderer();
    renderer.load(&studio.scene).unwrap();
    let bytes = renderer.scene_bytes();
    for round in 0..50u8 {
        studio.scene.images[0].source = chequer([[round, 9, 9, 255], [0, round, 90, 255]]);
        let mesh = Arc::make_mut(&mut studio.scene.meshes[2]);
        mesh.primitives[0].positions[0][0] += 0.001;
        renderer.load(&studio.scene).unwrap();
        assert_eq!(renderer.scene_bytes(), bytes, "round {round}");
    }
    // A large mesh takes a page of its own, and gives it back.
    add_mesh(&mut studio.scene, primitives::uv_sphere(0.2, 400, 300), Node::default());
    renderer.load(&studio.scene).unwrap();
    assert!(renderer.scene_bytes() > bytes + 64 * 120_000);
    studio.scene.meshes.pop();
    renderer.load(&studio.scene).unwrap();
    assert_eq!(renderer.scene_bytes(), bytes);
    // Nothing is left of a scene but the table that morph targets have in any case.
    renderer.load(&Scene::default()).unwrap();
    assert!(renderer.scene_bytes() <= 64 << 10, "{} bytes are left", renderer.scene_bytes());
    assert!(bytes > 64 << 10);
}

#[test]
fn what_is_drawn_from_bundles_is_what_is_drawn_at_once() {
    let Studio { mut scene, .. } = studio();
    for index in 0..300 {
        let material = Some(index % 5);
        let cube = Primitive { material, ..primitives::cube(Vec3::splat(0.05)) };
        let place = Vec3::new((index % 20) as f32 * 0.1 - 1.0, 0.4 + (index / 20) as f32 * 0.08, 1.1);
        add_mesh(&mut scene, cube, Node { translation: place, ..Node::default() });
    }
    scene.update_transforms();
    let (mut live, mut anew) = (renderer(), renderer());
    for frame in 0..10 {
        let mut request = request(&scene, (Path::Deferred, Ground::None));
        match frame {
            // Some leave the picture, and come back.
            4..=6 => request.camera.world_from_view *= Mat4::from_rotation_y(0.35),
            7 => scene.node_mut(NodeId(40)).is_visible = false,
            _ => (),
        }
        live.render(&scene, &request).unwrap();
        anew.unload();
        anew.render(&scene, &request).unwrap();
        let read = |renderer: &mut Renderer| (renderer.read_display().unwrap(), renderer.read_radiance().unwrap());
        assert!(read(&mut live) == read(&mut anew), "frame {frame}");
        // A stretch is encoded when it comes for the second time: never in a frame that is the first of its kind.
        let bundles = [live.stats().bundles_executed, anew.stats().bundles_executed];
        match frame {
            0 => assert_eq!(bundles, [0, 0]),
            1..=3 | 8..=9 => assert!(bundles[0] > 0 && bundles[1] == 0, "frame {frame}: {bundles:?}"),
            _ => assert_eq!(bundles[1], 0, "frame {frame}"),
        }
    }
}

#[test]
fn what_a_mesh_lacks_is_not_taken_from_another() {
    let mut scene = scenes::rows_of_spheres().scene;
    let mut renderer = renderer();
    let before = picture(&mut renderer, &scene, (Path::Deferred, Ground::None));
    assert_eq!(renderer.warnings(), Vec::<String>::new());
    let mut torn = primitives::cube(Vec3::ONE);
    torn.indices[4] = 24;
    let torn = add_mesh(&mut scene, torn, Node::default());
    // More points than vertices, which is fine: they lie in the middle of a sphere.
    let mut dots = primitives::cube(Vec3::splat(0.001));
    (dots.topology, dots.indices) = (manypass_scene::Topology::Points, vec![0; 100]);
    dots.morph_targets = vec![MorphTarget { positions: vec![[0.0; 3]; 24], ..Default::default() }];
    let node = scene.nodes.iter().find(|node| node.mesh == Some(3)).unwrap().clone();
    let translation = scene.meshes[3].primitives[0].bounds.center();
    add_mesh(&mut scene, dots, Node { translation, ..Node { mesh: None, ..node } });
    // Nor are nodes read that name what is not there.
    scene.add_node(None, Node { mesh: Some(99), skin: Some(99), light: Some(99), ..Node::default() });
    scene.update_transforms();
    assert!(picture(&mut renderer, &scene, (Path::Deferred, Ground::None)) == before);
    let warnings = renderer.warnings();
    assert!(matches!(&warnings[..], [warning] if warning.contains("does not have")), "{warnings:?}");
    scene.remove_node(torn);
    scene.meshes.remove(scene.node(torn).mesh.unwrap());
    renderer.load(&scene).unwrap();
    assert_eq!(renderer.warnings(), Vec::<String>::new());
}

/// Until an image is there its material is that without the texture, whose flat texel changes nothing.
#[test]
fn an_image_that_comes_later_is_shown_from_then_on() {
    let scene = studio().scene;
    let mut renderer = renderer();
    for way in [(Path::Deferred, Ground::None), (Path::Forward, Ground::None)] {
        let whole = picture(&mut renderer, &scene, way);
        for (image, forget) in [
            (0, (|material| material.base_color_texture = None) as fn(&mut Material)),
            (1, |m| m.normal_texture = None),
        ] {
            let (mut waiting, mut without) = (scene.clone(), scene.clone());
            waiting.images[image].source = ImageSource::Loading("later.png".into());
            without.materials.iter_mut().for_each(forget);
            let found = picture(&mut renderer, &waiting, way);
            assert!(found == picture(&mut renderer, &without, way) && found != whole, "{way:?} without image {image}");
            renderer.render(&waiting, &request(&waiting, way)).unwrap();
            assert!(renderer.warnings().is_empty(), "{:?}", renderer.warnings());
            waiting.images[image].source = scene.images[image].source.clone();
            assert!(picture(&mut renderer, &waiting, way) == whole, "{way:?} with image {image}");
        }
    }
}

/// Relief is in shadow maps. Two materials that swap their height maps upload nothing, and their shadows swap all the
/// same.
#[test]
fn shadows_follow_height_maps_that_are_swapped() {
    let mut scene = Scene::default();
    let kind = LightKind::Directional;
    scene.lights.push(Light { intensity: 3.0, kind, casts_shadows: true, ..Light::default() });
    // At a slant, so that what is high casts far.
    let rotation = Quat::from_rotation_x(-0.5) * Quat::from_rotation_y(0.6);
    scene.add_node(None, Node { rotation, light: Some(0), ..Node::default() });
    let projection = Projection::Perspective { fov_y_rad: 0.6, near_m: 0.1, far_m: None };
    scene.cameras.push(Camera { name: String::new(), projection, aspect: None });
    scene.add_node(None, Node { translation: Vec3::Z * 4.0, camera: Some(0), ..Node::default() });
    let (low, high) = ([0, 0, 0, 255], [255; 4]);
    for (index, colors) in [[low, high], [high, high]].into_iter().enumerate() {
        scene.textures.push(Texture { image: index, sampler: Default::default() });
        scene.images.push(Image { name: String::new(), source: chequer(colors) });
        let texture = reference(index).unwrap();
        let height = HeightMap { texture, depth_m: 0.1, method: HeightMethod::Occlusion, self_shadow: false };
        scene.materials.push(Material { height: Some(height), metallic_factor: 0.0, ..Material::default() });
        let tile = Primitive { material: Some(index), ..primitives::cube(Vec3::new(1.0, 1.0, 0.2)) };
        add_mesh(&mut scene, tile, Node { translation: Vec3::X * (1.2 * index as f32 - 0.6), ..Node::default() });
    }
    scene.update_transforms();
    let way = (Path::Deferred, Ground::Shadow);
    let mut live = renderer();
    let mut anew = Renderer::new(live.gpu().clone()).unwrap();
    let before = picture(&mut live, &scene, way);
    let textures = [1, 0].map(|index| reference(index).unwrap());
    for (material, texture) in scene.materials.iter_mut().zip(textures) {
        material.height.as_mut().unwrap().texture = texture;
    }
    let swapped = picture(&mut live, &scene, way);
    assert!(swapped != before);
    assert!(swapped == picture(&mut anew, &scene, way), "the shadows are those of before");
}
