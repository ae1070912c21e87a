//! EXR files of the ray caster's scenes, read back with a library of their own and compared with the ray caster.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use exr::prelude::{FlatImage, FlatSamples, ReadChannels, ReadLayers, read};
use glam::{DVec2, DVec3};
use manypass::{Aov, Background, Environment, Exposure, FrameRequest, Gpu, Renderer, View};
use manypass_offline::still::write_exr;
use manypass_offline::{PictureInfo, exr_file, render_still};
use manypass_scene::{Projection, Scene};
use manypass_testkit::compare::linear_difference;
use manypass_testkit::raycast::{Frame, Options};
use manypass_testkit::scenes;
use std::io::Cursor;

const SIZE: (usize, usize) = (128, 96);

fn view_of(scene: &Scene) -> View {
    let node = scene.nodes.iter().find(|node| node.camera.is_some()).unwrap();
    View { world_from_view: node.world_from_object, projection: scene.cameras[node.camera.unwrap()].projection }
}

/// The scene's first camera, no environment, black behind, every variable.
fn request_of(scene: &Scene) -> FrameRequest {
    let mut request = FrameRequest::new(SIZE.0 as u32, SIZE.1 as u32, view_of(scene));
    request.settings.environment.source = Environment::None;
    request.settings.background.source = Background::Color([0.0; 3]);
    request.settings.shadows.enabled = false;
    request.settings.effects.enabled = false;
    request.want_aovs = Aov::ALL.to_vec();
    // Linear outputs have the exposure divided out.
    request.settings.exposure.stops = Exposure::Stops(-1.5);
    request
}

fn decoded(bytes: Vec<u8>) -> FlatImage {
    let reader = read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
    reader.non_parallel().from_buffered(Cursor::new(bytes)).unwrap()
}

fn channel<'a>(image: &'a FlatImage, layer: &str, channel: &str) -> &'a FlatSamples {
    let named = image.layer_data.iter().find(|l| l.attributes.layer_name.as_ref().is_some_and(|name| name.eq(layer)));
    let channels = &named.unwrap_or_else(|| panic!("no layer {layer}")).channel_data.list;
    &channels.iter().find(|c| c.name.eq(channel)).unwrap_or_else(|| panic!("no channel {layer}.{channel}")).sample_data
}

fn floats<'a>(image: &'a FlatImage, layer: &str, name: &str) -> &'a [f32] {
    match channel(image, layer, name) {
        FlatSamples::F32(values) => values,
        other => panic!("{layer}.{name} holds {other:?}"),
    }
}

fn ids<'a>(image: &'a FlatImage, layer: &str) -> &'a [u32] {
    match channel(image, layer, "Id") {
        FlatSamples::U32(values) => values,
        other => panic!("{layer} holds {other:?}"),
    }
}

fn vectors(image: &FlatImage, layer: &str) -> Vec<DVec3> {
    let [x, y, z] = ["X", "Y", "Z"].map(|name| floats(image, layer, name));
    (0..x.len()).map(|i| DVec3::new(x[i].into(), y[i].into(), z[i].into())).collect()
}

/// Whether a pixel and the eight around it show the same object.
fn is_inner(ids: &[u32], at: usize) -> bool {
    let (x, y) = (at % SIZE.0, at / SIZE.0);
    let is_inside = (1..SIZE.0 - 1).contains(&x) && (1..SIZE.1 - 1).contains(&y);
    is_inside && (y - 1..=y + 1).all(|y| (x - 1..=x + 1).all(|x| ids[y * SIZE.0 + x] == ids[at]))
}

/// Where `view` sees a point, in pixels from the top left corner.
fn pixel_of(view: &View, position_world: DVec3) -> DVec2 {
    let p = view.world_from_view.as_dmat4().inverse().transform_point3(position_world);
    let half_height_m = match view.projection {
        Projection::Perspective { fov_y_rad, .. } => (0.5 * f64::from(fov_y_rad)).tan() * -p.z,
        Projection::Orthographic { height_m, .. } => 0.5 * f64::from(height_m),
    };
    let half_px = DVec2::new(SIZE.0 as f64, SIZE.1 as f64) * 0.5;
    half_px + DVec2::new(p.x, -p.y) / half_height_m * half_px.y
}

/// Every variable of a single sample; the worst reprojection error in pixels.
fn compare_variables(image: &FlatImage, truth: &Frame, scene: &Scene, name: &str) -> f64 {
    let (depth, position, normal) = (floats(image, "depth", "Z"), vectors(image, "position"), vectors(image, "normal"));
    let (objects, materials) = (ids(image, "object_id"), ids(image, "material_id"));
    let view = view_of(scene);
    let mut worst_px = 0.0f64;
    for at in 0..SIZE.0 * SIZE.1 {
        let center = DVec2::new((at % SIZE.0) as f64 + 0.5, (at / SIZE.0) as f64 + 0.5);
        if depth[at].is_finite() {
            worst_px = worst_px.max((pixel_of(&view, position[at]) - center).length());
        }
        if !is_inner(&truth.object_id, at) {
            continue;
        }
        let mesh = objects[at].checked_sub(1).and_then(|node| scene.nodes[node as usize].mesh);
        assert_eq!(mesh.map_or(0, |mesh| mesh as u32 + 1), truth.object_id[at], "{name}: object at {at}");
        assert_eq!(materials[at], truth.object_id[at], "{name}: material at {at}");
        if truth.object_id[at] == 0 {
            assert!(depth[at].is_infinite(), "{name}: the background at {at} has a depth");
            continue;
        }
        // Facets of a sphere of 0.9 m lie up to 0.3 mm inside it; grazing pixels multiply that.
        assert!((f64::from(depth[at]) - truth.depth_view_m[at]).abs() < 5e-3, "{name}: depth at {at}");
        assert!((position[at] - truth.position_world[at]).length() < 8e-3, "{name}: position at {at}");
        assert!(normal[at].dot(truth.normal_world[at]) > 0.999, "{name}: normal at {at}");
    }
    worst_px
}

#[test]
fn files_agree_with_the_ray_caster() {
    let mut renderer = Renderer::new(Gpu::headless(None).unwrap()).unwrap();
    for test in scenes::all() {
        renderer.load(&test.scene).unwrap();
        let request = request_of(&test.scene);
        let picture = render_still(&mut renderer, &test.scene, &request, 1, true, |_| true).unwrap();
        let info = PictureInfo::default();
        let radiance = Some(&*picture.radiance);
        let bytes = exr_file::encode(picture.width, picture.height, radiance, &picture.aovs, &info).unwrap();
        // Bands from the device, against the whole in memory.
        let mut banded = Cursor::new(Vec::new());
        write_exr(&mut banded, &mut renderer, &request, &info).unwrap();
        assert!(banded.into_inner() == bytes, "{}", test.name);
        let image = decoded(bytes);
        assert_eq!(image.layer_data.len(), Aov::ALL.len() + 1);
        let truth = test.world.render(SIZE.0, SIZE.1, Options::default());
        let worst_px = compare_variables(&image, &truth, &test.scene, test.name);
        println!("{}: positions lie within {worst_px:.5} px of their pixels", test.name);
        assert!(worst_px < 0.01, "{}: {worst_px} px", test.name);

        for layer in ["rgba", "radiance"] {
            let [red, green, blue, alpha] = ["R", "G", "B", "A"].map(|name| floats(&image, layer, name));
            let inner: Vec<usize> = (0..red.len()).filter(|at| is_inner(&truth.object_id, *at)).collect();
            let found: Vec<_> = inner.iter().map(|at| [red[*at], green[*at], blue[*at]]).collect();
            let expected: Vec<_> = inner.iter().map(|at| truth.radiance[*at]).collect();
            let mean = expected.iter().flatten().map(|v| f64::from(*v)).sum::<f64>() / (3 * expected.len()) as f64;
            let difference = linear_difference(&expected, &found, 0.01 * mean);
            // The G-buffer holds base colour and roughness in 8 bits: up to 0.9 % each.
            assert!(difference.mean < 0.008 && difference.share_within(0.01) > 0.95, "{} {layer}", test.name);
            assert!(alpha.iter().all(|alpha| *alpha == 1.0));
            // The test can fail: three per cent more light is too much.
            let exposed: Vec<_> = found.iter().map(|pixel| pixel.map(|v| v * 1.03)).collect();
            assert!(linear_difference(&expected, &exposed, 0.01 * mean).mean > 0.01);
        }
    }
}

#[test]
fn variables_come_from_the_first_sample_whatever_their_number() {
    let mut renderer = Renderer::new(Gpu::headless(None).unwrap()).unwrap();
    let test = scenes::rows_of_spheres();
    renderer.load(&test.scene).unwrap();
    let request = request_of(&test.scene);
    let mut layers = |samples| {
        let picture = render_still(&mut renderer, &test.scene, &request, samples, true, |_| true).unwrap();
        (picture.radiance, picture.aovs)
    };
    let (one, mut first) = layers(1);
    let (three, mut averaged) = layers(3);
    assert_ne!(one, three, "samples are jittered");
    // Radiance is the average; nothing else is.
    assert_eq!(first.pop().unwrap().aov, Aov::Radiance);
    averaged.pop();
    assert!(first == averaged);
}
