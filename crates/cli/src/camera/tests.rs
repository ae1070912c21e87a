use super::*;
use manypass_scene::primitives::cube;
use manypass_scene::{Aabb, Camera, Mesh, Node, Primitive, Topology};

fn unit_scene() -> Scene {
    let mesh = Mesh { primitives: vec![cube(Vec3::splat(2.0))], ..Mesh::default() };
    let mut scene = Scene { meshes: vec![mesh.into()], ..Scene::default() };
    scene.add_node(None, Node { mesh: Some(0), ..Node::default() });
    scene.update_transforms();
    scene
}

fn unit_framing() -> Framing {
    Framing::of_scene(&unit_scene())
}

fn orbit(yaw_deg: f32, pitch_deg: f32) -> (Vec3, Vec3) {
    let place = Place::Orbit { yaw_deg, pitch_deg, radius_m: Some(5.0) };
    let spec = CameraSpec { place, ..CameraSpec::default() };
    let (view, _) = resolve(&spec, &unit_scene(), &unit_framing(), 1.5, 0.0).expect("camera");
    (view.w_axis.truncate(), -view.z_axis.truncate())
}

#[test]
fn orbits_turn_as_the_contract_says() {
    for (yaw, pitch, eye) in [(0.0, 0.0, Vec3::Z), (90.0, 0.0, Vec3::X), (-90.0, 0.0, -Vec3::X), (0.0, 90.0, Vec3::Y)] {
        let (position, forward) = orbit(yaw, pitch);
        assert!(position.abs_diff_eq(5.0 * eye, 1e-4), "{yaw} {pitch}: {position}");
        assert!(forward.abs_diff_eq(-eye, 1e-5), "{yaw} {pitch}: {forward}");
    }
}

#[test]
fn the_whole_model_fits_into_narrow_and_wide_pictures() {
    for aspect in [0.25, 1.0, 4.0] {
        let (view, projection) =
            resolve(&CameraSpec::default(), &unit_scene(), &unit_framing(), aspect, 0.0).expect("camera");
        let Projection::Perspective { fov_y_rad, near_m, .. } = projection else { panic!("perspective") };
        let tan_y = (0.5 * fov_y_rad).tan();
        for corner in unit_framing().bounds_world().corners() {
            let p = view.inverse().transform_point3(corner);
            assert!(-p.z > near_m && p.y.abs() <= -p.z * tan_y && p.x.abs() <= -p.z * tan_y * aspect, "{aspect}: {p}");
        }
    }
}

#[test]
fn eye_looks_at_the_target_even_straight_down() {
    for eye in [Vec3::new(3.0, 2.0, 1.0), Vec3::new(0.0, 4.0, 0.0)] {
        let spec = CameraSpec { place: Place::Eye(eye.as_dvec3()), ..CameraSpec::default() };
        let (view, _) = resolve(&spec, &unit_scene(), &unit_framing(), 1.0, 0.0).expect("camera");
        assert!((-view.z_axis.truncate()).abs_diff_eq(-eye.normalize(), 1e-5));
        assert!((view.determinant() - 1.0).abs() < 1e-4);
    }
    let spec = CameraSpec { place: Place::Eye(DVec3::ZERO), ..CameraSpec::default() };
    assert_eq!(resolve(&spec, &unit_scene(), &unit_framing(), 1.0, 0.0).expect_err("degenerate").code(), 2);
}

#[test]
fn the_files_camera_wins_without_flags() {
    let mut scene = unit_scene();
    let projection = Projection::Perspective { fov_y_rad: 1.0, near_m: 0.1, far_m: None };
    scene.cameras.push(Camera { name: "Main".into(), projection, aspect: None });
    scene.add_node(
        None,
        Node { camera: Some(0), translation: Vec3::new(0.0, 0.0, 7.0), scale: Vec3::splat(3.0), ..Node::default() },
    );
    scene.update_transforms();
    for place in [Place::Default, Place::Named("Main".into()), Place::Named("0".into())] {
        let (view, found) =
            resolve(&CameraSpec { place, ..CameraSpec::default() }, &scene, &Framing::of_scene(&scene), 1.0, 0.0)
                .expect("camera");
        assert_eq!((view, found), (Mat4::from_translation(Vec3::new(0.0, 0.0, 7.0)), projection));
    }
    let unknown = CameraSpec { place: Place::Named("Side".into()), ..CameraSpec::default() };
    assert_eq!(
        resolve(&unknown, &scene, &Framing::of_scene(&scene), 1.0, 0.0).expect_err("unknown").hint,
        "cameras by index or name: 0 `Main`"
    );
}

/// A camera at z = 7 that looks along −Z.
fn scene_with_camera(projection: Projection) -> Scene {
    let mut scene = unit_scene();
    scene.cameras.push(Camera { name: "Main".into(), projection, aspect: None });
    scene.add_node(None, Node { camera: Some(0), translation: Vec3::new(0.0, 0.0, 7.0), ..Node::default() });
    scene.update_transforms();
    scene
}

#[test]
fn flags_change_the_files_camera_and_leave_the_rest() {
    let own = Projection::Perspective { fov_y_rad: 1.0, near_m: 0.1, far_m: Some(50.0) };
    let scene = scene_with_camera(own);
    let framing = Framing::of_scene(&scene);
    let place = Mat4::from_translation(Vec3::new(0.0, 0.0, 7.0));
    let resolved = |spec: &CameraSpec| resolve(spec, &scene, &framing, 1.0, 0.0);
    let spec = CameraSpec::default;
    let cases = [
        (CameraSpec { near_m: Some(2.0), ..spec() }, (1.0, 2.0, Some(50.0))),
        (CameraSpec { far_m: Some(9.0), ..spec() }, (1.0, 0.1, Some(9.0))),
        (CameraSpec { fov_y_rad: Some(0.5), ..spec() }, (0.5, 0.1, Some(50.0))),
    ];
    for (spec, (fov_y_rad, near_m, far_m)) in cases {
        let expected = (place, Projection::Perspective { fov_y_rad, near_m, far_m });
        assert_eq!(resolved(&spec).expect("camera"), expected, "{spec:?}");
    }
    let (view, projection) = resolved(&CameraSpec { ortho_height_m: Some(3.0), ..spec() }).expect("camera");
    assert_eq!((view, projection), (place, Projection::Orthographic { height_m: 3.0, near_m: 0.1, far_m: 50.0 }));
    let (view, projection) =
        resolved(&CameraSpec { target: Some(DVec3::new(7.0, 0.0, 0.0)), ..spec() }).expect("camera");
    let diagonal = Vec3::new(1.0, 0.0, -1.0).normalize();
    assert_eq!((view.w_axis, projection), (place.w_axis, own));
    assert!((-view.z_axis.truncate()).abs_diff_eq(diagonal, 1e-6) && view.y_axis.truncate().abs_diff_eq(Vec3::Y, 1e-6));
    let (view, _) = resolved(&CameraSpec { up: Some(Vec3::X), ..spec() }).expect("camera");
    assert!(view.z_axis.truncate().abs_diff_eq(Vec3::Z, 1e-6) && view.y_axis.truncate().abs_diff_eq(Vec3::X, 1e-6));
    assert_eq!(resolved(&CameraSpec { near_m: Some(60.0), ..spec() }).expect_err("planes").code(), 2);
    assert_eq!(resolved(&CameraSpec { far_m: Some(0.05), ..spec() }).expect_err("planes").code(), 2);
}

#[test]
fn a_turntable_keeps_its_distance_and_its_middle() {
    let mut scene = unit_scene();
    scene.add_node(None, Node { mesh: Some(0), translation: Vec3::new(5.0, 0.0, 0.0), ..Node::default() });
    scene.update_transforms();
    let framing = Framing::of_scene(&scene);
    for (ortho_height_m, target) in
        [(None, None), (Some(4.0), None), (None, Some(DVec3::X)), (Some(4.0), Some(DVec3::X))]
    {
        let spec = CameraSpec { place: DEFAULT_ORBIT, turns: true, ortho_height_m, target, ..CameraSpec::default() };
        let middle = spec.target_world().unwrap_or_else(|| framing.center_world());
        let arm = |turn_deg: f32| {
            let (view, _) = resolve(&spec, &scene, &framing, 1.5, turn_deg).expect("camera");
            view.inverse().transform_point3(middle)
        };
        for turn_deg in [10.0, 90.0, 200.0, -10.0] {
            assert!(arm(turn_deg).abs_diff_eq(arm(0.0), 1e-4), "{} {}", arm(turn_deg), arm(0.0));
        }
        assert!(arm(0.0).x.abs() < 1e-4, "the axis is in the middle: {}", arm(0.0));
    }
}

#[test]
fn places_far_away_keep_their_digits_until_they_are_told_from_the_origin() {
    let mut scene = unit_scene();
    scene.origin_m = Vec3::new(500_000.0, 4_649_776.0, 100.0);
    // Floats are a whole multiple of half a metre there.
    let origin_m = scene.origin_m.as_dvec3();
    let eye = origin_m + DVec3::new(2.1, 0.2, 3.3);
    let target = origin_m + DVec3::new(0.1, 0.2, -0.3);
    let placed = |place| CameraSpec { place, target: Some(target), ..CameraSpec::default() };
    let posed = Place::Posed { rotation: Quat::IDENTITY, eye };
    for spec in [placed(Place::Eye(eye)), placed(posed)] {
        let (view, _) = resolve(&spec, &scene, &unit_framing(), 1.0, 0.0).expect("camera");
        assert!(view.w_axis.truncate().abs_diff_eq(Vec3::new(2.1, 0.2, 3.3), 1e-6), "{view}");
        if matches!(spec.place, Place::Eye(_)) {
            let forward = Vec3::new(-2.0, 0.0, -3.6).normalize();
            assert!((-view.z_axis.truncate()).abs_diff_eq(forward, 1e-6), "{view}");
        }
    }
}

#[test]
fn outliers_are_told_of_where_the_camera_is_fitted() {
    let grid = |i: u16| [f32::from(i % 13), f32::from(i % 11), f32::from(i % 7)];
    let positions: Vec<[f32; 3]> = (0..2000).map(grid).chain([[900.0, 0.0, 0.0]]).collect();
    let bounds = Aabb::from_points(positions.iter().copied().map(Vec3::from));
    let primitive = Primitive { topology: Topology::Points, positions, bounds, ..Primitive::default() };
    let mut scene =
        Scene { meshes: vec![Mesh { primitives: vec![primitive], ..Mesh::default() }.into()], ..Scene::default() };
    scene.add_node(None, Node { mesh: Some(0), ..Node::default() });
    scene.update_transforms();
    let framing = Framing::of_scene(&scene);
    let hint = |place: Place| outlier_hint(&CameraSpec { place, ..CameraSpec::default() }, &scene, &framing);
    let said = hint(Place::Default).expect("a hint");
    assert!(said.starts_with("1 of its points lie") && said.contains("; --orbit 30,28,2700 shows"), "{said}");
    assert!(hint(Place::Automatic).is_some() && hint(DEFAULT_ORBIT).is_some());
    assert!(hint(Place::Eye(DVec3::ONE)).is_none());
    assert!(outlier_hint(&CameraSpec::default(), &unit_scene(), &unit_framing()).is_none());
}
