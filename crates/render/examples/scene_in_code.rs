//! A scene built in code: meshes, materials, lights, a camera; then a light and a material are changed by their handles,
//! and the picture is drawn. `cargo run --release -p manypass --example scene_in_code -- [OUT.png]`.

use manypass::glam::{Quat, Vec3, Vec4};
use manypass::scene::framing::look_along;
use manypass::scene::{Light, LightKind, Material, Node, Primitive, Projection, Scene, primitives};
use manypass::{Exposure, FrameRequest, Gpu, Renderer};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let out = std::env::args().nth(1).unwrap_or("scene_in_code.png".into());
    let mut scene = Scene::default();

    // Materials are metallic and roughness, as in glTF; an index is the handle.
    let paint = |color: [f32; 3], metallic_factor: f32, roughness_factor: f32| Material {
        base_color_factor: Vec3::from(color).extend(1.0),
        metallic_factor,
        roughness_factor,
        ..Material::default()
    };
    let floor = scene.add_material(paint([0.4, 0.4, 0.42], 0.0, 0.5));
    let red = scene.add_material(paint([0.8, 0.04, 0.03], 0.0, 0.4));
    let gold = scene.add_material(paint([1.0, 0.77, 0.34], 1.0, 0.2));

    // Meshes come from vertices of your own, or from the crate's primitives; a node puts one somewhere.
    let mut place = |primitive: Primitive, material: usize, translation: [f32; 3]| {
        let mesh = Some(scene.add_mesh(Primitive { material: Some(material), ..primitive }));
        scene.add_node(None, Node { mesh, translation: translation.into(), ..Node::default() })
    };
    place(primitives::plane(12.0), floor, [0.0; 3]);
    place(pyramid(2.0, 1.6), red, [0.0; 3]);
    place(primitives::uv_sphere(0.6, 64, 32), gold, [-1.9, 0.6, 0.4]);
    let torus = place(primitives::torus(0.55, 0.2, 64, 32), gold, [1.9, 0.75, 0.4]);

    // Lights and cameras look along the −Z of the nodes that hold them.
    let towards = |direction: Vec3| look_along(direction, Vec3::Y).unwrap_or(Quat::IDENTITY);
    let sun = Light { kind: LightKind::Directional, intensity: 1.5, ..Light::default() };
    scene.add_light(sun, Node { rotation: towards(Vec3::new(-0.6, -1.0, -0.5)), ..Node::default() });
    let bulb = Light { color_linear: Vec3::new(0.4, 0.6, 1.0), intensity: 4.0, radius_m: 0.1, ..Light::default() };
    let bulb = scene.add_light(bulb, Node { translation: Vec3::new(-2.5, 2.0, 1.5), ..Node::default() });
    let (eye, target) = (Vec3::new(0.0, 2.4, 6.5), Vec3::new(0.0, 0.6, 0.0));
    let projection = Projection::Perspective { fov_y_rad: 0.7, near_m: 0.1, far_m: None };
    let rotation = towards(target - eye);
    scene.add_camera(projection, Node { translation: eye, rotation, ..Node::default() });

    // Editing is a line each. `update_transforms` follows before the next frame.
    scene.node_mut(torus).rotation = Quat::from_rotation_x(1.3);
    scene.materials[red].base_color_factor = Vec4::new(0.8, 0.02, 0.02, 1.0);
    if let Some(light) = scene.light_mut(bulb) {
        light.intensity = 12.0;
    }
    scene.update_transforms();

    let mut renderer = Renderer::new(Gpu::headless(None)?)?;
    let mut request = FrameRequest { sample_count: 8, ..FrameRequest::of_scene(&scene, 640, 360) };
    renderer.expose(&scene, &mut request, Exposure::of_scene(&scene))?;
    for sample_index in 0..request.sample_count {
        request.sample_index = sample_index;
        renderer.render(&scene, &request)?;
    }
    Ok(image::save_buffer(out, &renderer.read_display()?, 640, 360, image::ColorType::Rgba8)?)
}

/// Four sides over a square, each flat, so that corners have a normal for each side.
fn pyramid(width_m: f32, height_m: f32) -> Primitive {
    let half_m = 0.5 * width_m;
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    for side in 0..4 {
        let turn = Quat::from_rotation_y(std::f32::consts::FRAC_PI_2 * side as f32);
        let corners = [Vec3::new(-half_m, 0.0, half_m), Vec3::new(half_m, 0.0, half_m), Vec3::new(0.0, height_m, 0.0)];
        let normal = turn * Vec3::new(0.0, half_m, height_m).normalize();
        positions.extend(corners.map(|corner| (turn * corner).to_array()));
        normals.extend([normal.to_array(); 3]);
    }
    Primitive::of_triangles(positions, normals, (0..12).collect())
}
