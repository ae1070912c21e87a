//! `render.scale`: shading at another size than the picture's.

#![allow(clippy::unwrap_used, reason = "a test says what it expects by panicking")]

use crate::common::{floats, plain_request, renderer};
use glam::{DVec2, Mat4, Quat, Vec3};
use manypass::{Aov, Averaging, Pose, View};
use manypass_scene::Projection;
use manypass_testkit::scenes;
use std::sync::Arc;

/// The mean difference of channels, of 255.
fn mean_difference(a: &[u8], b: &[u8]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / a.len() as f64
}

#[test]
fn the_output_keeps_its_size_and_its_picture() {
    let test = scenes::rows_of_spheres();
    let mut renderer = renderer();
    renderer.load(&test.scene).unwrap();
    for (width, height) in [(128, 96), (97, 73), (1, 1)] {
        let mut picture_at = |scale: f32| {
            let mut request = plain_request(&test.scene, (width, height));
            request.settings.render.scale = scale;
            request.want_aovs = vec![Aov::Depth];
            request.averaging = Averaging::Both;
            request.sample_count = 4;
            for sample in 0..4 {
                request.sample_index = sample;
                renderer.render(&test.scene, &request).unwrap();
            }
            let count = (width * height) as usize;
            assert_eq!(renderer.read_radiance().unwrap().len(), 4 * count, "{width}x{height} at {scale}");
            let depth = floats(renderer.read_aov(Aov::Depth).unwrap());
            assert_eq!(depth.len(), count, "{width}x{height} at {scale}");
            (renderer.read_display().unwrap(), depth)
        };
        let (whole, depth) = picture_at(1.0);
        assert_eq!(whole.len(), (width * height * 4) as usize);
        if width == 1 {
            assert!([0.25, 2.0].map(&mut picture_at).iter().all(|(display, _)| display.len() == 4));
            continue;
        }
        let flipped: Vec<u8> = whole.chunks_exact(width as usize * 4).rev().flatten().copied().collect();
        // Half the pixels along each side blur silhouettes and highlights over two pixels; twice as many sharpen them.
        for (scale, most) in [(0.5, 5.0), (2.0, 1.5), (0.77, 3.5)] {
            let (scaled, scaled_depth) = picture_at(scale);
            let difference = mean_difference(&whole, &scaled);
            println!("{width}x{height} at {scale}: mean difference {difference:.3}/255");
            assert!(difference > 0.0 && difference < most, "{width}x{height} at {scale}: {difference}");
            assert!(mean_difference(&flipped, &scaled) > 2.0 * most, "the test cannot fail");
            // It lies where it should: moved by a pixel, to the side or down, it fits worse.
            for offset in [4, width as usize * 4] {
                for (a, b) in [
                    (&whole[offset..], &scaled[..scaled.len() - offset]),
                    (&whole[..whole.len() - offset], &scaled[offset..]),
                ] {
                    assert!(mean_difference(a, b) > difference, "{width}x{height} at {scale} is moved");
                }
            }
            let near = depth.iter().zip(&scaled_depth).filter(|(a, b)| (**a - **b).abs() < 0.05 * **a || a == b);
            assert!(near.count() * 10 > depth.len() * 8, "{width}x{height} at {scale}: depths differ");
        }
    }
}

/// Where `view` sees a point, in pixels from the top left corner.
fn pixel_of(view: &View, position_world: &[f32], size: (u32, u32)) -> DVec2 {
    let position = Vec3::from_slice(position_world).as_dvec3();
    let p = view.world_from_view.as_dmat4().inverse().transform_point3(position);
    let Projection::Perspective { fov_y_rad, .. } = view.projection else {
        panic!("the scene's camera has perspective")
    };
    let half_px = DVec2::new(f64::from(size.0), f64::from(size.1)) * 0.5;
    half_px + DVec2::new(p.x, -p.y) / (-p.z * (0.5 * f64::from(fov_y_rad)).tan()) * half_px.y
}

#[test]
fn variables_are_those_of_the_middles_of_the_pictures_pixels() {
    let test = scenes::rows_of_spheres();
    let mut renderer = renderer();
    renderer.load(&test.scene).unwrap();
    let size = (97, 73);
    let mut request = plain_request(&test.scene, size);
    request.want_aovs = Aov::ALL.iter().copied().filter(|aov| *aov != Aov::Radiance).collect();
    request.sample_count = 4;
    let earlier_view = View {
        world_from_view: request.camera.world_from_view * Mat4::from_quat(Quat::from_rotation_y(0.03)),
        ..request.camera
    };
    request.previous = Some(Arc::new(Pose::capture(&test.scene, earlier_view)));
    let camera = request.camera;
    let mut variables_at = |scale: f32| {
        request.settings.render.scale = scale;
        renderer.render(&test.scene, &request).unwrap();
        request.want_aovs.iter().map(|aov| (*aov, renderer.read_aov(*aov).unwrap())).collect::<Vec<_>>()
    };
    let whole = variables_at(1.0);
    for scale in [0.5, 0.73, 2.0] {
        let scaled = variables_at(scale);
        let positions = floats(scaled.iter().find(|(aov, _)| *aov == Aov::Position).unwrap().1.clone());
        let depths = floats(scaled.iter().find(|(aov, _)| *aov == Aov::Depth).unwrap().1.clone());
        let mut worst_px = 0.0f64;
        for at in (0..depths.len()).filter(|at| depths[*at].is_finite()) {
            let middle = DVec2::new((at % 97) as f64 + 0.5, (at / 97) as f64 + 0.5);
            worst_px = worst_px.max((pixel_of(&camera, &positions[at * 3..at * 3 + 3], size) - middle).length());
        }
        println!("scale {scale}: positions are off by at most {worst_px:.6} px");
        assert!(worst_px < 1e-3, "scale {scale}: {worst_px} px");
        for ((aov, whole), (_, scaled)) in whole.iter().zip(&scaled) {
            assert!(whole == scaled, "{aov:?} depends on render.scale {scale}");
        }
    }
}
