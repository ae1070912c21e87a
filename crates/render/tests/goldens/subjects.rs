//! What the goldens show, all of it built by code.

use glam::{Quat, Vec2, Vec3};
use manypass::scene::overlay::{Overlay, OverlayItem, OverlayPlace, OverlayShape, OverlayText};
use manypass::scene::primitives::{capsule, cube, plane, torus, uv_sphere};
use manypass::scene::{
    Aabb, AlphaMode, Animation, Channel, Image, ImageSource, Interpolation, Keyframes, Light, LightKind, Material,
    Mesh, MorphTarget, Node, NodeId, PixelFormat, Pixels, Primitive, Projection, Sampler, Scene, ShadingModel, Skin,
    Texture, TextureRef, TextureTransform, demo,
};
use manypass::{
    Background, EffectFile, Environment, Exposure, Fisheye, FisheyeFrame, FrameRequest, MeteringPattern,
    OcclusionMethod, Pose, Resolution, Settings, Switch, Tonemap, UpscaleMethod, View,
};
use std::sync::Arc;

/// One golden.
pub struct Subject {
    /// The file's name.
    pub name: &'static str,
    /// What is drawn.
    pub scene: Scene,
    /// Requests of one width, drawn below one another.
    pub strips: Vec<FrameRequest>,
    /// The effect of each strip, built in or of docs/samples.md, and its settings, where there are any. An effect that
    /// needs another one has that before it, with `+` between.
    pub effects: Vec<(&'static str, &'static [&'static str])>,
    /// The table of colours of each strip, its file and that one's text, where there are any.
    pub tables: Vec<(&'static str, String)>,
    /// Why the picture is known to be wrong, if it is.
    pub known_failure: Option<&'static str>,
}

/// All of them.
pub fn all() -> Vec<Subject> {
    vec![
        roughness_and_metallic(),
        lights(),
        blended_panes(),
        mask(),
        tone_curves(),
        normal_map(),
        mirrored_nodes(),
        skin_and_morph(),
        transparent_background(),
        hall(),
        built_in_effects(),
        effects_of_surfaces(),
        occlusion(),
        reflections(),
        overlay(),
        outlines_of_objects(),
        contact_shadows(),
        light_between_surfaces(),
        antialiasing(),
        occlusion_by_points_and_bent_normals(),
        tables_of_colours(),
        fisheye(),
        lens(),
        exposure_that_adapts(),
        samples_of_pictures(),
        samples_of_frames(),
        of_room("monitors", -5.2),
        of_room("mirror", -5.2),
        water(),
        of_room("portals", -2.6),
        of_room("reflection_probes", -5.6),
        at_time(of_room("simulations", -1.0), 1.5),
        at_time(of_room("particles", -1.0), 1.5),
        of_room("decals", -4.5),
        at_time(of_room("trails", -1.5), 3.0),
    ]
}

fn subject(name: &'static str, mut scene: Scene, size: (u32, u32), eye: Vec3, target: Vec3) -> Subject {
    scene.update_transforms();
    let mut request = FrameRequest::of_scene(&scene, size.0, size.1);
    request.camera = looking(eye, target);
    request.settings.background.source = Background::Color([0.02, 0.02, 0.03]);
    request.settings.tone_map.dither = 0.0;
    request.settings.occlusion.enabled = Switch::Off;
    request.settings.reflections.enabled = Switch::Off;
    Subject { name, scene, strips: vec![request], effects: Vec::new(), tables: Vec::new(), known_failure: None }
}

fn looking(eye: Vec3, target: Vec3) -> View {
    let world_from_view = glam::camera::rh::view::look_at_mat4(eye, target, Vec3::Y).inverse();
    View { world_from_view, projection: Projection::Perspective { fov_y_rad: 0.6, near_m: 0.1, far_m: Some(100.0) } }
}

fn matte(color: [f32; 3]) -> Material {
    let base_color_factor = Vec3::from(color).extend(1.0);
    Material { base_color_factor, metallic_factor: 0.0, roughness_factor: 0.6, ..Material::default() }
}

fn put(scene: &mut Scene, mut primitive: Primitive, material: Material, translation: Vec3) -> NodeId {
    primitive.material = Some(scene.materials.len());
    scene.materials.push(material);
    let mesh = Some(scene.meshes.len());
    scene.meshes.push(Mesh { primitives: vec![primitive], ..Mesh::default() }.into());
    scene.add_node(None, Node { mesh, translation, ..Node::default() })
}

fn shine(scene: &mut Scene, kind: LightKind, color: [f32; 3], intensity: f32, at: Vec3, towards: Vec3) {
    let light = Some(scene.lights.len());
    let color_linear = Vec3::from(color);
    scene.lights.push(Light { color_linear, intensity, range_m: None, kind, ..Light::default() });
    let rotation = Quat::from_rotation_arc(Vec3::NEG_Z, (towards - at).normalize());
    scene.add_node(None, Node { translation: at, rotation, light, ..Node::default() });
}

/// A texture of `side` × `side` texels by a function of u and v, as the material slots refer to it.
fn texture(scene: &mut Scene, side: u32, texel: impl Fn(f32, f32) -> [u8; 4]) -> TextureRef {
    let middle = |i: u32| (i as f32 + 0.5) / side as f32;
    let data = (0..side * side).flat_map(|i| texel(middle(i % side), middle(i / side))).collect();
    let pixels = Pixels { width: side, height: side, format: PixelFormat::Rgba8, data };
    scene.images.push(Image { name: String::new(), source: ImageSource::Pixels(Arc::new(pixels)) });
    scene.textures.push(Texture { image: scene.images.len() - 1, sampler: Sampler::default() });
    TextureRef { texture: scene.textures.len() - 1, uv_set: 0, transform: TextureTransform::default() }
}

/// Blue dielectric above, gold below; from smooth on the left to rough on the right, under the studio.
fn roughness_and_metallic() -> Subject {
    let mut scene = Scene::default();
    for i in 0..5u8 {
        for (y, color, metallic_factor) in [(0.55, [0.1, 0.3, 0.8], 0.0), (-0.55, [1.0, 0.77, 0.34], 1.0)] {
            let roughness_factor = 0.1 + 0.225 * f32::from(i);
            let material = Material { metallic_factor, roughness_factor, ..matte(color) };
            put(&mut scene, uv_sphere(0.48, 48, 24), material, Vec3::new(1.05 * (f32::from(i) - 2.0), y, 0.0));
        }
    }
    subject("roughness_and_metallic", scene, (128, 60), Vec3::new(0.0, 0.0, 4.4), Vec3::ZERO)
}

/// A red point light on the left, a green spot light in the middle, a weak sun from the right.
fn lights() -> Subject {
    let mut scene = Scene::default();
    put(&mut scene, plane(8.0), matte([0.6; 3]), Vec3::ZERO);
    for x in [-1.4, 0.0, 1.4] {
        put(&mut scene, uv_sphere(0.4, 48, 24), matte([0.8; 3]), Vec3::new(x, 0.4, 0.0));
    }
    shine(&mut scene, LightKind::Point, [1.0, 0.1, 0.1], 6.0, Vec3::new(-1.9, 0.9, 0.6), Vec3::ZERO);
    let spot = LightKind::Spot { inner_cone_rad: 0.2, outer_cone_rad: 0.3 };
    shine(&mut scene, spot, [0.1, 1.0, 0.2], 40.0, Vec3::new(0.0, 3.0, 1.5), Vec3::new(0.0, 0.2, 0.0));
    shine(&mut scene, LightKind::Directional, [0.4, 0.5, 1.0], 0.6, Vec3::new(4.0, 2.0, 2.0), Vec3::ZERO);
    subject("lights", scene, (128, 72), Vec3::new(0.0, 2.0, 5.0), Vec3::new(0.0, 0.3, 0.0))
}

/// Red, green and blue panes of half alpha, one behind the other, before an opaque box with a fourth behind it.
fn blended_panes() -> Subject {
    let mut scene = Scene::default();
    put(&mut scene, cube(Vec3::splat(0.9)), matte([0.9, 0.8, 0.2]), Vec3::new(0.1, 0.0, 0.0));
    let panes =
        [([0.9, 0.05, 0.05], -0.6, 0.2, 0.9), ([0.05, 0.8, 0.05], 0.1, -0.2, 1.2), ([0.05, 0.1, 0.9], 0.7, 0.15, 1.5)];
    for (color, x, y, z) in panes.into_iter().chain([([0.9, 0.9, 0.9], -0.9, 0.5, -0.9)]) {
        let base_color_factor = Vec3::from(color).extend(0.5);
        let material = Material { base_color_factor, alpha_mode: AlphaMode::Blend, double_sided: true, ..matte(color) };
        put(&mut scene, cube(Vec3::new(0.9, 0.9, 0.01)), material, Vec3::new(x, y, z));
    }
    subject("blended_panes", scene, (96, 80), Vec3::new(0.8, 1.0, 5.0), Vec3::new(0.0, 0.1, 0.3))
}

/// Discs cut out of a plate by alpha, the upper ones larger; what lies behind is seen through the plate.
fn mask() -> Subject {
    let mut scene = Scene::default();
    let holes = texture(&mut scene, 64, |u, v| {
        let from_middle = ((4.0 * u).fract() - 0.5).hypot((4.0 * v).fract() - 0.5);
        [230, 120, 40, (255.0 * (from_middle + 0.25 * (1.0 - v)).clamp(0.0, 1.0)) as u8]
    });
    let alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
    let material =
        Material { base_color_texture: Some(holes), alpha_mode, double_sided: true, ..matte([1.0, 1.0, 1.0]) };
    let plate = put(&mut scene, plane(1.6), material, Vec3::ZERO);
    scene.node_mut(plate).rotation = Quat::from_rotation_x(1.2);
    put(&mut scene, uv_sphere(0.5, 48, 24), matte([0.1, 0.6, 0.7]), Vec3::new(0.3, -0.1, -0.8));
    subject("mask", scene, (80, 80), Vec3::new(0.5, 0.4, 3.2), Vec3::ZERO)
}

/// Unlit boxes, dark to white, then glowing ones, of 1 to 64: one strip for every tone curve, in their order.
fn tone_curves() -> Subject {
    let mut scene = Scene::default();
    let colors = [[0.05; 3], [0.18; 3], [0.8; 3], [0.8, 0.05, 0.05], [0.05, 0.6, 0.1], [0.05, 0.1, 0.8]];
    for (i, color) in (0u8..).zip(colors) {
        let material = Material { shading_model: ShadingModel::Unlit, ..matte(color) };
        put(&mut scene, cube(Vec3::splat(0.9)), material, Vec3::new(f32::from(i) - 5.5, 0.0, 0.0));
    }
    let glows = [[1.0, 0.3, 0.1], [0.1, 0.3, 1.0]];
    for (i, strength) in (0u8..).zip([1.0, 4.0, 16.0, 1.0, 8.0, 64.0]) {
        let emissive_factor = strength * Vec3::from(glows[usize::from(i / 3)]);
        let material = Material { emissive_factor, ..matte([0.0; 3]) };
        put(&mut scene, cube(Vec3::splat(0.9)), material, Vec3::new(f32::from(i) + 0.5, 0.0, 0.0));
    }
    let mut subject = subject("tone_curves", scene, (120, 12), Vec3::Z * 5.0, Vec3::ZERO);
    let request = &mut subject.strips[0];
    request.camera.projection = Projection::Orthographic { height_m: 1.2, near_m: 0.1, far_m: 10.0 };
    request.settings.environment.source = Environment::None;
    let curves =
        [Tonemap::None, Tonemap::Neutral, Tonemap::Aces, Tonemap::Agx, Tonemap::Reinhard, Tonemap::Exponential];
    subject.strips = curves.map(|tonemap| request.with(|settings| settings.tone_map.curve = tonemap)).to_vec();
    subject
}

/// Half spheres that stand out of the left half of the surface and go into its right half; +Y of the texture is up.
fn bumps(scene: &mut Scene) -> TextureRef {
    texture(scene, 128, |u, v| {
        let (x, y) = ((4.0 * u).fract() * 2.5 - 1.25, 1.25 - (4.0 * v).fract() * 2.5);
        let sign = if u < 0.5 { 1.0 } else { -1.0 };
        let normal =
            if x * x + y * y < 1.0 { Vec3::new(sign * x, sign * y, (1.0 - x * x - y * y).sqrt()) } else { Vec3::Z };
        let [x, y, z] = (normal.with_z(normal.z.max(0.2)).normalize() * 127.5 + 127.5).round().to_array();
        [x as u8, y as u8, z as u8, 255]
    })
}

/// A plate with bumps on the left and dents on the right, lit by a sun from above on the left: bumps are bright above.
fn normal_map() -> Subject {
    let mut scene = Scene::default();
    let normal_texture = Some(bumps(&mut scene));
    let plate = put(&mut scene, plane(2.0), Material { normal_texture, ..matte([0.7, 0.65, 0.6]) }, Vec3::ZERO);
    scene.node_mut(plate).rotation = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    let at = Vec3::new(-2.0, 3.0, 3.0);
    shine(&mut scene, LightKind::Directional, [1.0; 3], 3.0, at, Vec3::ZERO);
    subject("normal_map", scene, (96, 96), Vec3::new(0.0, 0.0, 3.6), Vec3::ZERO)
}

/// A box and an arm, and their mirror image by a node of negative scale, with bumps: both are lit from above on the
/// left.
fn mirrored_nodes() -> Subject {
    let mut scene = Scene::default();
    let normal_texture = Some(bumps(&mut scene));
    let material = Material { normal_texture, ..matte([0.3, 0.6, 0.35]) };
    let mirror = scene.add_node(None, Node { scale: Vec3::new(-1.0, 1.0, 1.0), ..Node::default() });
    for parent in [None, Some(mirror)] {
        for (size, at) in [(Vec3::ONE, Vec3::new(0.8, 0.0, 0.0)), (Vec3::new(0.4, 0.4, 0.8), Vec3::new(1.2, 0.7, 0.3))]
        {
            let node = put(&mut scene, cube(size), material.clone(), at);
            if let Some(parent) = parent {
                scene.roots.retain(|root| *root != node);
                scene.node_mut(node).parent = Some(parent);
                scene.node_mut(parent).children.push(node);
            }
        }
    }
    shine(&mut scene, LightKind::Directional, [1.0; 3], 3.0, Vec3::new(-2.0, 3.0, 3.0), Vec3::ZERO);
    subject("mirrored_nodes", scene, (112, 72), Vec3::new(0.0, 1.2, 5.0), Vec3::new(0.0, 0.25, 0.0))
}

/// A capsule bent by two joints to the right at its middle, and a ball stretched upwards by a morph target, in the
/// middle of their animation.
fn skin_and_morph() -> Subject {
    let mut scene = Scene::default();
    let mut rod = capsule(0.25, 1.4, 32, 8);
    for [_, y, _] in &rod.positions {
        let upper = (0.5 + y / 0.6).clamp(0.0, 1.0);
        rod.joints.push([0, 1, 0, 0]);
        rod.weights.push([1.0 - upper, upper, 0.0, 0.0]);
    }
    // A capsule has no rings along its straight part: its ends alone would bend.
    let rod = subdivided(&rod);
    let rod = put(&mut scene, rod, matte([0.8, 0.35, 0.15]), Vec3::ZERO);
    let lower = scene.add_node(None, Node { translation: Vec3::new(-0.7, 0.0, 0.0), ..Node::default() });
    let upper = scene.add_node(Some(lower), Node::default());
    scene.skins.push(Skin { joints: vec![lower, upper], inverse_bind_matrices: vec![glam::Mat4::IDENTITY; 2] });
    scene.node_mut(rod).skin = Some(0);
    let mut ball = uv_sphere(0.5, 32, 16);
    let stretch = |[_, y, _]: &[f32; 3]| [0.0, 1.5 * y.max(0.0), 0.0];
    ball.morph_targets =
        vec![MorphTarget { positions: ball.positions.iter().map(stretch).collect(), ..Default::default() }];
    let ball = put(&mut scene, ball, matte([0.2, 0.4, 0.8]), Vec3::new(0.8, -0.4, 0.0));
    let channel =
        |node, keyframes| Channel { node, times_secs: vec![0.0, 2.0], interpolation: Interpolation::Linear, keyframes };
    let turns = vec![Quat::IDENTITY, Quat::from_rotation_z(-2.4)];
    let channels = vec![
        channel(upper, Keyframes::Rotation(turns)),
        channel(ball, Keyframes::MorphWeights { count: 1, values: vec![0.0, 2.0] }),
    ];
    scene.animations.push(Animation { channels, ..Animation::default() });
    scene.pose(0, 1.0);
    subject("skin_and_morph", scene, (96, 80), Vec3::new(0.3, 0.6, 4.6), Vec3::new(0.1, 0.1, 0.0))
}

/// Every triangle split into four, three times, so that long triangles can bend.
fn subdivided(primitive: &Primitive) -> Primitive {
    let mut result = primitive.clone();
    for _ in 0..3 {
        let coarse = std::mem::take(&mut result.indices);
        for triangle in coarse.chunks_exact(3) {
            let [a, b, c] = [triangle[0], triangle[1], triangle[2]];
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(from, to)| add_middle(&mut result, from, to));
            result.indices.extend([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca]);
        }
    }
    result.bounds = Aabb::from_points(result.positions.iter().copied().map(Vec3::from));
    result
}

/// A vertex between two others; the weights of its joints are those of its own height.
fn add_middle(primitive: &mut Primitive, a: u32, b: u32) -> u32 {
    let (a, b) = (a as usize, b as usize);
    let middle = |values: &[[f32; 3]]| (Vec3::from(values[a]) + Vec3::from(values[b])) * 0.5;
    let position = middle(&primitive.positions);
    let normal = middle(&primitive.normals).normalize_or(Vec3::Y);
    let upper = (0.5 + position.y / 0.6).clamp(0.0, 1.0);
    primitive.positions.push(position.to_array());
    primitive.normals.push(normal.to_array());
    primitive.tangents.push(primitive.tangents[a]);
    primitive.uv0.push(primitive.uv0[a]);
    primitive.joints.push([0, 1, 0, 0]);
    primitive.weights.push([1.0 - upper, upper, 0.0, 0.0]);
    primitive.positions.len() as u32 - 1
}

/// A metal ring with a pane of half alpha before it and nothing behind; alpha is 0, about a half, and 1.
fn transparent_background() -> Subject {
    let mut scene = Scene::default();
    let material = Material { metallic_factor: 1.0, roughness_factor: 0.3, ..matte([0.95, 0.64, 0.54]) };
    let ring = put(&mut scene, torus(0.7, 0.25, 48, 24), material, Vec3::ZERO);
    scene.node_mut(ring).rotation = Quat::from_rotation_x(1.0);
    let base_color_factor = Vec3::new(0.1, 0.5, 0.9).extend(0.5);
    let pane = Material { base_color_factor, alpha_mode: AlphaMode::Blend, double_sided: true, ..matte([1.0; 3]) };
    put(&mut scene, cube(Vec3::new(0.8, 1.4, 0.01)), pane, Vec3::new(0.6, 0.1, 0.9));
    let mut subject = subject("transparent_background", scene, (80, 64), Vec3::new(0.2, 0.3, 4.6), Vec3::ZERO);
    subject.strips[0].settings.background.source = Background::Transparent;
    subject
}

/// The built-in demo, small.
fn hall() -> Subject {
    let scene = demo::hall();
    let mut request = FrameRequest::of_scene(&scene, 128, 72);
    request.settings.tone_map.dither = 0.0;
    // As in a still, all of its lights have their maps.
    request.settings.shadows.maps = 65536;
    Subject { name: "hall", scene, strips: vec![request], effects: Vec::new(), tables: Vec::new(), known_failure: None }
}

/// A built-in scene with pictures within the picture.
fn of_room(name: &'static str, stops: f32) -> Subject {
    let scene = demo::named(name).unwrap();
    let mut request = FrameRequest::of_scene(&scene, 128, 72);
    request.settings.tone_map.dither = 0.0;
    request.settings.exposure.stops = Exposure::Stops(stops);
    request.settings.occlusion.enabled = Switch::Off;
    request.settings.reflections.enabled = Switch::Off;
    Subject { name, scene, strips: vec![request], effects: Vec::new(), tables: Vec::new(), known_failure: None }
}

/// The same at a time of its first animation.
fn at_time(mut subject: Subject, time_secs: f32) -> Subject {
    subject.scene.pose(0, time_secs);
    subject.scene.update_transforms();
    subject
}

/// The lake and the pool of the demo, under its sky.
fn water() -> Subject {
    let mut scene = demo::named("water").unwrap();
    scene.time_secs = 1.5;
    let mut request = FrameRequest::of_scene(&scene, 128, 72);
    let environment = &mut request.settings.environment;
    environment.source = Environment::Sky;
    (environment.sun_elevation_deg, environment.sun_azimuth_deg) = (24.0, -60.0);
    request.settings.tone_map.dither = 0.0;
    request.settings.exposure.stops = Exposure::Stops(0.7);
    request.settings.occlusion.enabled = Switch::Off;
    request.settings.reflections.enabled = Switch::Off;
    Subject {
        name: "water",
        scene,
        strips: vec![request],
        effects: Vec::new(),
        tables: Vec::new(),
        known_failure: None,
    }
}

/// Built-in effects, each in a strip, over boxes of colours and boxes that glow.
fn built_in_effects() -> Subject {
    let mut subject = tone_curves();
    let mut request = subject.strips[1].clone();
    request.height = 21;
    request.camera.projection = Projection::Orthographic { height_m: 2.1, near_m: 0.1, far_m: 10.0 };
    subject.name = "built_in_effects";
    subject.effects = ["bloom", "blur", "film", "fxaa", "glow", "sharpen"].map(|name| (name, [].as_slice())).to_vec();
    subject.strips = vec![request; subject.effects.len()];
    subject
}

/// The other built-in effects, each in a strip, over boxes and balls.
fn effects_of_surfaces() -> Subject {
    let mut subject = occlusion();
    let mut request = subject.strips[1].clone();
    request.height = 18;
    request.camera = looking(Vec3::new(0.4, 1.2, 4.4), Vec3::new(0.0, 0.45, -0.3));
    request.camera.projection = Projection::Perspective { fov_y_rad: 0.25, near_m: 0.1, far_m: None };
    subject.name = "effects_of_surfaces";
    subject.effects = vec![
        ("grade", &["temperature_k=4000", "contrast=1.5", "saturation=1.3"]),
        ("outline", &[]),
        ("toon", &[]),
        ("smaa", &[]),
        ("lens", &["k1=0.3", "chromatic=0.05", "vignette=8"]),
        ("dof", &["f_stop=0.05"]),
        ("motion_blur", &["shutter=1"]),
    ];
    subject.scene.update_transforms();
    let mut before = request.camera;
    before.world_from_view.w_axis += 0.6 * before.world_from_view.x_axis;
    request.previous = Some(Pose::capture(&subject.scene, before).into());
    subject.strips = vec![request; subject.effects.len()];
    subject
}

/// Effects of docs/samples.md over boxes of colours and boxes that glow, each in a strip.
fn samples_of_pictures() -> Subject {
    let mut subject = built_in_effects();
    subject.name = "samples_of_pictures";
    subject.effects = vec![
        ("scanlines", &["pitch_px=4,3"]),
        ("halftone", &["pitch_px=4"]),
        ("pixelate", &["side_px=5"]),
        ("ascii", &[]),
        ("glitch", &["band_px=4", "seed=3"]),
        ("glow+flare", &["strength=2"]),
    ];
    subject
}

/// The others, over boxes and balls, each in a strip; trails are those of frames that follow each other.
fn samples_of_frames() -> Subject {
    let mut subject = effects_of_surfaces();
    subject.name = "samples_of_frames";
    subject.effects = vec![
        ("trails", &[]),
        ("thermal", &[]),
        ("mist", &["half_m=2", "top_m=0", "thins_m=1", "color=0.4,0.5,0.6"]),
        ("chosen", &["nodes=2,3", "rounds=3"]),
        ("tilt_shift", &["blur=0.2"]),
        ("growth", &[]),
    ];
    subject.strips.truncate(subject.effects.len());
    for request in &mut subject.strips {
        (request.height, request.previous) = (21, None);
    }
    subject.strips[0].goes_on = true;
    subject
}

/// The names of effects that goldens show.
fn drawn() -> Vec<&'static str> {
    let drawn = all().into_iter().flat_map(|subject| subject.effects).flat_map(|(name, _)| name.split('+'));
    let mut drawn: Vec<_> = drawn.collect();
    drawn.sort_unstable();
    drawn.dedup();
    drawn
}

#[test]
fn every_built_in_effect_has_its_golden() {
    assert!(EffectFile::built_in_names().eq(drawn().into_iter().filter(|name| EffectFile::is_built_in(name))));
}

#[test]
fn every_sample_effect_has_its_golden() {
    let drawn: Vec<_> = drawn().into_iter().filter(|name| !EffectFile::is_built_in(name)).collect();
    assert_eq!(drawn, crate::common::sample_names());
}

/// Text, lines and an image over boxes and balls, some of them at places of the world; below over nothing.
fn overlay() -> Subject {
    let mut subject = occlusion();
    subject.name = "overlay";
    let mut request = subject.strips[1].clone();
    let item = |text: &str, place: OverlayPlace, size_px: f32| {
        let text = OverlayText {
            size_px,
            background: Some((Vec3::new(0.0, 0.0, 0.1), 0.7)),
            padding_px: 2.0,
            ..OverlayText::new(text)
        };
        OverlayItem { shape: OverlayShape::Text(text), ..OverlayItem::text("", place) }
    };
    let behind =
        OverlayItem { depth_test: true, ..item("behind", OverlayPlace::at_world(Vec3::new(-1.1, 0.8, -0.6)), 9.0) };
    let ring = [(0.0, 0.0), (0.6, 0.0), (0.6, 0.6), (0.0, 0.6)].map(|(x, z)| Vec3::new(x - 0.3, 0.02, z + 0.1));
    let on_floor = OverlayItem {
        depth_test: true,
        color_linear: Vec3::new(1.0, 0.3, 0.0),
        ..OverlayItem::line_world(ring.to_vec())
    };
    let data = [[255, 60, 40, 255], [40, 200, 60, 255], [60, 90, 255, 160], [255, 255, 255, 255]].concat();
    let pixels = Arc::new(Pixels { width: 2, height: 2, format: PixelFormat::Rgba8, data });
    let mut sprite = OverlayItem::sprite(pixels, OverlayPlace::at_px(Vec2::new(-4.0, -4.0)));
    if let OverlayShape::Sprite(shape) = &mut sprite.shape {
        (shape.size_px, shape.rotation_deg) = ([Some(12.0), None], 20.0);
    }
    let zigzag = [(4.0, 40.0), (14.0, 28.0), (24.0, 40.0), (34.0, 28.0)].map(|(x, y)| Vec2::new(x, y));
    let items = vec![
        item("Ωver\nÄ 3 µm", OverlayPlace::at_px(Vec2::new(3.0, 3.0)), 9.0),
        behind,
        on_floor,
        OverlayItem { opacity: 0.6, ..OverlayItem::line(zigzag.to_vec()) },
        sprite,
    ];
    request.overlay = Overlay { items }.into();
    let mut over_nothing = request.clone();
    over_nothing.settings.background.source = Background::Transparent;
    over_nothing.camera = looking(Vec3::new(0.4, 1.2, 14.4), Vec3::new(0.0, 0.45, -0.3));
    subject.strips = vec![request, over_nothing];
    subject
}

/// Boxes of two materials side by side, whose faces lie in one plane: no line, one between objects, between materials.
fn outlines_of_objects() -> Subject {
    let mut scene = Scene::default();
    for (x, material) in [(-1.5, 0), (-0.5, 0), (0.5, 1), (1.5, 1)] {
        let node = put(&mut scene, cube(Vec3::splat(1.0)), matte([0.7, 0.7, 0.6]), Vec3::new(x, 0.0, 0.0));
        let mesh = scene.node(node).mesh.unwrap();
        Arc::make_mut(&mut scene.meshes[mesh]).primitives[0].material = Some(material);
    }
    let mut subject = subject("outlines_of_objects", scene, (128, 36), Vec3::new(0.0, 0.0, 8.0), Vec3::ZERO);
    let mut request = subject.strips[0].clone();
    request.camera.projection = Projection::Orthographic { height_m: 1.3, near_m: 0.1, far_m: 20.0 };
    subject.effects = vec![("outline", &[]), ("outline", &["object=1"]), ("outline", &["material=1", "color=1,0,0"])];
    subject.strips = vec![request; subject.effects.len()];
    subject
}

/// Boxes and balls in a corner under even light, with horizons (above) and without occlusion.
fn occlusion() -> Subject {
    let mut scene = Scene::default();
    put(&mut scene, plane(8.0), matte([0.8; 3]), Vec3::ZERO);
    let wall = put(&mut scene, plane(8.0), matte([0.8, 0.75, 0.7]), Vec3::new(0.0, 0.0, -1.0));
    scene.node_mut(wall).rotation = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    put(&mut scene, cube(Vec3::splat(0.8)), matte([0.8, 0.3, 0.2]), Vec3::new(-1.1, 0.4, -0.4));
    put(&mut scene, cube(Vec3::new(0.2, 1.4, 0.2)), matte([0.3, 0.5, 0.8]), Vec3::new(-0.2, 0.7, -0.6));
    put(&mut scene, uv_sphere(0.45, 48, 24), matte([0.8; 3]), Vec3::new(0.6, 0.45, -0.4));
    put(&mut scene, uv_sphere(0.25, 48, 24), matte([0.2, 0.6, 0.3]), Vec3::new(1.25, 0.25, -0.2));
    let mut subject = subject("occlusion", scene, (128, 60), Vec3::new(0.4, 1.6, 4.4), Vec3::new(0.0, 0.45, -0.3));
    let request = &mut subject.strips[0];
    request.settings.environment.source = Environment::Color([0.8; 3]);
    let enabled = [true, false];
    subject.strips =
        enabled.map(|enabled| request.with(|settings| settings.occlusion.enabled = enabled.into())).to_vec();
    subject
}

/// Boxes and balls on a floor that is a mirror, then glossy, with reflections of the picture; and without them.
fn reflections() -> Subject {
    let mut scene = Scene::default();
    let steel = |roughness_factor| Material { metallic_factor: 1.0, roughness_factor, ..matte([0.8; 3]) };
    put(&mut scene, cube(Vec3::new(2.2, 0.1, 6.0)), steel(0.0), Vec3::new(-1.1, -0.05, 0.0));
    put(&mut scene, cube(Vec3::new(2.2, 0.1, 6.0)), steel(0.3), Vec3::new(1.1, -0.05, 0.0));
    for x in [-1.1f32, 1.1] {
        put(&mut scene, cube(Vec3::splat(0.6)), matte([0.8, 0.3, 0.2]), Vec3::new(x - 0.5, 0.3, -0.8));
        put(&mut scene, cube(Vec3::new(0.2, 1.4, 0.2)), matte([0.3, 0.5, 0.8]), Vec3::new(x, 0.7, -1.2));
        put(&mut scene, uv_sphere(0.3, 48, 24), matte([0.2, 0.6, 0.3]), Vec3::new(x + 0.5, 0.5, -0.6));
    }
    let mut subject = subject("reflections", scene, (128, 60), Vec3::new(0.0, 1.1, 4.6), Vec3::new(0.0, 0.3, -0.3));
    let request = &mut subject.strips[0];
    request.settings.environment.source = Environment::Color([0.6, 0.7, 0.8]);
    let enabled = [true, false];
    subject.strips =
        enabled.map(|enabled| request.with(|settings| settings.reflections.enabled = enabled.into())).to_vec();
    subject
}

/// Low boxes and a ring on a floor under a sun whose maps are coarse, with shadows that the picture shows where those
/// miss them; and without.
fn contact_shadows() -> Subject {
    let mut scene = Scene::default();
    put(&mut scene, plane(8.0), matte([0.8, 0.75, 0.7]), Vec3::ZERO);
    for x in [-0.9f32, -0.3, 0.3] {
        put(&mut scene, cube(Vec3::new(0.35, 0.1, 0.2)), matte([0.8, 0.3, 0.2]), Vec3::new(x, 0.08, 0.3 * x));
        put(&mut scene, cube(Vec3::new(0.05, 0.3, 0.05)), matte([0.3, 0.5, 0.8]), Vec3::new(x, 0.15, 0.3 * x + 0.5));
    }
    put(&mut scene, torus(0.25, 0.05, 48, 24), matte([0.2, 0.6, 0.3]), Vec3::new(0.9, 0.1, 0.2));
    shine(&mut scene, LightKind::Directional, [1.0; 3], 3.0, Vec3::new(-2.0, 2.2, -1.0), Vec3::ZERO);
    let mut subject = subject("contact_shadows", scene, (128, 60), Vec3::new(0.0, 1.2, 3.0), Vec3::new(0.0, 0.0, 0.1));
    let request = &mut subject.strips[0];
    request.settings.shadows.atlas_px = 256;
    request.settings.shadows.bias_texels = 16.0;
    subject.strips = [0.3, 0.0].map(|m| request.with(|settings| settings.shadows.contact_m = m)).to_vec();
    subject
}

/// A white room with a red and a green wall and two boxes under a lamp, with light that surfaces send each other, and
/// without.
fn light_between_surfaces() -> Subject {
    let mut scene = Scene::default();
    let white = [0.8, 0.8, 0.78];
    put(&mut scene, cube(Vec3::new(2.4, 0.2, 2.4)), matte(white), Vec3::new(0.0, -0.1, 0.0));
    put(&mut scene, cube(Vec3::new(2.4, 0.2, 2.4)), matte(white), Vec3::new(0.0, 2.1, 0.0));
    put(&mut scene, cube(Vec3::new(2.4, 2.0, 0.2)), matte(white), Vec3::new(0.0, 1.0, -1.1));
    put(&mut scene, cube(Vec3::new(0.2, 2.0, 2.2)), matte([0.8, 0.1, 0.05]), Vec3::new(-1.1, 1.0, 0.0));
    put(&mut scene, cube(Vec3::new(0.2, 2.0, 2.2)), matte([0.1, 0.7, 0.1]), Vec3::new(1.1, 1.0, 0.0));
    let tall = put(&mut scene, cube(Vec3::new(0.6, 1.2, 0.6)), matte(white), Vec3::new(-0.35, 0.6, -0.3));
    scene.node_mut(tall).rotation = Quat::from_rotation_y(0.3);
    let low = put(&mut scene, cube(Vec3::splat(0.6)), matte(white), Vec3::new(0.4, 0.3, 0.3));
    scene.node_mut(low).rotation = Quat::from_rotation_y(-0.3);
    shine(&mut scene, LightKind::Point, [1.0, 0.9, 0.8], 3.0, Vec3::new(0.0, 1.7, 0.2), Vec3::ZERO);
    let mut subject =
        subject("light_between_surfaces", scene, (64, 64), Vec3::new(0.0, 1.0, 4.6), Vec3::new(0.0, 1.0, 0.0));
    let request = &mut subject.strips[0];
    request.settings.environment.source = Environment::None;
    let enabled = [true, false];
    subject.strips = enabled.map(|enabled| request.with(|settings| settings.gi.enabled = enabled)).to_vec();
    subject
}

/// Bars and a ring: frames that follow each other, half as large ones enlarged by those before, along their edges, and
/// evenly.
fn antialiasing() -> Subject {
    let mut scene = Scene::default();
    for i in 0..7u8 {
        let lean = 0.12 * (f32::from(i) - 3.0);
        let bar = put(&mut scene, cube(Vec3::new(0.06, 1.3, 0.06)), matte([0.9, 0.85, 0.8]), Vec3::X * 4.0 * lean);
        scene.node_mut(bar).rotation = Quat::from_rotation_z(lean);
    }
    let ring = put(&mut scene, torus(0.42, 0.1, 48, 16), matte([0.8, 0.2, 0.1]), Vec3::new(0.3, 0.0, 0.3));
    scene.node_mut(ring).rotation = Quat::from_rotation_x(1.2);
    let size = (128, 31);
    let mut subject = subject("antialiasing", scene, size, Vec3::new(0.0, 0.2, 2.4), Vec3::ZERO);
    let request = subject.strips[0].clone();
    let over_time = |scale: f32, method: UpscaleMethod| {
        request.with(|settings| {
            settings.taa.enabled = method == UpscaleMethod::Temporal;
            settings.render.scale = scale;
            settings.upscale.method = method;
        })
    };
    subject.strips = vec![
        over_time(1.0, UpscaleMethod::Temporal),
        over_time(0.5, UpscaleMethod::Temporal),
        over_time(0.5, UpscaleMethod::Edges),
        over_time(0.5, UpscaleMethod::Bilinear),
    ];
    subject
}

/// Nothing that is found in the picture.
fn bare(settings: &mut Settings) {
    settings.set("occlusion.enabled", "false").unwrap();
    settings.set("reflections.enabled", "false").unwrap();
}

/// What `occlusion` shows: by points in a hemisphere; and at full size under the studio, whose light comes from where
/// nothing is in its way.
fn occlusion_by_points_and_bent_normals() -> Subject {
    let mut subject = occlusion();
    let with = subject.strips[0].with(|settings| {
        bare(settings);
        settings.set("occlusion.enabled", "true").unwrap();
    });
    subject.name = "occlusion_by_points_and_bent_normals";
    subject.strips = vec![
        with.with(|settings| settings.occlusion.method = OcclusionMethod::Ssao),
        with.with(|settings| {
            settings.environment.source = Environment::Studio;
            (settings.occlusion.resolution, settings.occlusion.bent_normals) = (Resolution::Full, true);
        }),
    ];
    subject
}

/// Boxes of colours through a table that makes light warm and shadows blue, and through a curve that turns all over.
fn tables_of_colours() -> Subject {
    let mut subject = tone_curves();
    let mut request = subject.strips[1].with(bare);
    request.height = 21;
    request.camera.projection = Projection::Orthographic { height_m: 2.1, near_m: 0.1, far_m: 10.0 };
    subject.name = "tables_of_colours";
    subject.strips = vec![request; 2];
    let table = |head: &str, count: usize, color: &dyn Fn(usize) -> [f32; 3]| {
        let lines = (0..count).map(color).map(|[r, g, b]| format!("{r:.4} {g:.4} {b:.4}\n"));
        format!("{head} {}\n{}", if head.contains("3D") { 9 } else { count }, lines.collect::<String>())
    };
    let toned = |index: usize| {
        let [r, g, b] = [index % 9, index / 9 % 9, index / 81].map(|at| at as f32 / 8.0);
        let light = 0.3 * r + 0.6 * g + 0.1 * b;
        [0.25 * light + 0.75 * r * r, 0.9 * g, 0.7 * b + 0.3 * (1.0 - light)]
    };
    subject.tables = vec![
        ("toned.cube", table("LUT_3D_SIZE", 729, &toned)),
        ("negative.cube", table("LUT_1D_SIZE", 17, &|index| [1.0 - index as f32 / 16.0; 3])),
    ];
    subject
}

/// The room of `light_between_surfaces` from within: a circle of more than a half space, and a frame that is full.
fn fisheye() -> Subject {
    let mut subject = light_between_surfaces();
    let mut request = subject.strips[1].with(bare);
    request.camera = looking(Vec3::new(0.1, 1.1, 0.8), Vec3::new(0.0, 0.9, -1.0));
    let maps =
        [(Fisheye::Equidistant, FisheyeFrame::Circular, 220.0), (Fisheye::Stereographic, FisheyeFrame::Full, 200.0)];
    subject.name = "fisheye";
    subject.strips = maps
        .map(|(map, frame, fov_deg)| {
            request.with(|settings| {
                let camera = &mut settings.camera;
                (camera.fisheye, camera.fisheye_frame, camera.fisheye_fov_deg) = (map, frame, fov_deg);
            })
        })
        .to_vec();
    subject
}

/// Balls at several distances, and a bar, through a lens.
fn lens() -> Subject {
    let mut scene = Scene::default();
    for (i, color) in (0u8..).zip([[0.8, 0.2, 0.1], [0.9, 0.7, 0.2], [0.2, 0.6, 0.3], [0.2, 0.4, 0.8], [0.8; 3]]) {
        let along = f32::from(i) - 2.0;
        put(&mut scene, uv_sphere(0.3, 32, 16), matte(color), Vec3::new(0.75 * along, 0.0, -1.1 * along));
    }
    put(&mut scene, cube(Vec3::new(0.5, 0.12, 0.12)), matte([0.9; 3]), Vec3::new(-1.3, 0.0, 0.0));
    let mut subject = subject("lens", scene, (128, 48), Vec3::new(0.0, 0.3, 4.6), Vec3::ZERO);
    let request = FrameRequest { sample_count: 32, ..subject.strips[0].with(bare) };
    let through = request.with(|settings| (settings.camera.f_stop, settings.camera.focus_m) = (0.12, 4.6));
    subject.strips = vec![through];
    subject
}

/// The frame half a second after the middle of the picture became brighter by more than four stops: where exposure is
/// quick, and where it is on its way.
fn exposure_that_adapts() -> Subject {
    let mut subject = tone_curves();
    let mut request = subject.strips[1].with(|settings| {
        bare(settings);
        settings.exposure.stops = Exposure::AUTO;
        (settings.exposure.adapt, settings.exposure.metering) = (true, MeteringPattern::Spot);
    });
    request.height = 24;
    // From a box of radiance 1 to the one of 16 beside it.
    request.camera = looking(Vec3::new(2.92, 0.0, 5.0), Vec3::new(2.92, 0.0, 0.0));
    request.camera.projection = Projection::Orthographic { height_m: 0.6, near_m: 0.1, far_m: 10.0 };
    subject.name = "exposure_that_adapts";
    subject.strips =
        [0.02, 0.4].map(|secs| request.with(|settings| settings.exposure.adapt_to_light_s = secs)).to_vec();
    subject
}
