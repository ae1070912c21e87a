use super::listed::{MOST_VIEWS, stem};
use super::*;
use glam::{Mat4, Vec3};
use std::fs;

/// A folder that goes when the test ends.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("manypass-views-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).expect("a folder");
        Self(path)
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
        fs::write(&path, bytes).expect("written");
        path
    }

    fn read(&self, size_px: (u32, u32)) -> Result<Views, Failure> {
        read(&self.0, size_px, &CameraSpec::default())
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// A camera at (1, 2, 3) that looks along −X with +Y up, scaled by 2.
const MATRIX: &str = "[[0, 0, 2, 1], [0, 2, 0, 2], [-2, 0, 0, 3], [0, 0, 0, 1]]";

fn nerf(text: &str, size_px: (u32, u32)) -> Result<Views, Failure> {
    // Tests run at the same time.
    let name = text.bytes().fold(5381_u64, |hash, byte| hash.wrapping_mul(33) ^ u64::from(byte));
    let folder = Folder::new(&format!("nerf-{name:x}-{}", size_px.0));
    let path = folder.write("transforms.json", text);
    read(&path, size_px, &CameraSpec::default())
}

/// A file of one frame with some keys, and with some more at the top level.
fn one_frame(top: &str, keys: &str) -> String {
    format!(r#"{{ {top} "frames": [{{ "file_path": "./train/r_0.png", {keys} "transform_matrix": {MATRIX} }}] }}"#)
}

fn world_from_view(spec: &CameraSpec) -> Mat4 {
    match spec.place {
        Place::Posed { rotation, eye } => Mat4::from_rotation_translation(rotation, eye.as_vec3()),
        ref place => panic!("{place:?} has no pose"),
    }
}

/// The field of view of the first view, in radians.
fn fov_y_rad(views: &Views) -> f64 {
    f64::from(views.cameras.first().and_then(|(spec, _)| spec.fov_y_rad).expect("a field of view"))
}

#[test]
fn a_blender_scene_has_poses_and_one_horizontal_angle() {
    let views = nerf(&one_frame(r#""camera_angle_x": 0.8,"#, ""), (200, 100)).expect("views");
    let [(spec, name)] = &views.cameras[..] else { panic!("{views:?}") };
    assert_eq!(name, "r_0");
    let looks = world_from_view(spec);
    let expected = [(Vec3::X, Vec3::NEG_Z), (Vec3::Y, Vec3::Y), (Vec3::NEG_Z, Vec3::NEG_X)];
    for (view, world) in expected {
        assert!(looks.transform_vector3(view).distance(world) < 1e-6, "{looks}");
    }
    assert_eq!(looks.w_axis.truncate(), Vec3::new(1.0, 2.0, 3.0));
    // Half as high as wide, as the picture is.
    assert!((fov_y_rad(&views) - 2.0 * (0.5 * 0.4_f64.tan()).atan()).abs() < 1e-6);
    assert_eq!((views.warnings.len(), views.files.len()), (0, 1));
}

#[test]
fn focal_lengths_in_pixels_are_of_the_file_or_of_a_frame() {
    let top = r#""fl_x": 400, "fl_y": 400, "cx": 320, "cy": 240, "w": 640, "h": 480, "camera_angle_x": 1,"#;
    let views = nerf(&one_frame(top, ""), (64, 48)).expect("views");
    assert!((fov_y_rad(&views) - 2.0 * 0.6_f64.atan()).abs() < 1e-6);
    assert_eq!(views.warnings, [""; 0]);
    // A frame's own lens comes first, whatever it is written in.
    let views = nerf(&one_frame(top, r#""camera_angle_x": 1.0, "w": 480.0,"#), (48, 48)).expect("views");
    assert!((fov_y_rad(&views) - 1.0).abs() < 1e-6 && views.warnings.len() == 1, "{views:?}");
    let views = nerf(&one_frame(r#""fl_x": 50,"#, ""), (100, 100)).expect("views");
    assert!((fov_y_rad(&views) - 2.0 * 1.0_f64.atan()).abs() < 1e-6);
    assert!(views.warnings[0].contains("no size (w, h) of the image"), "{:?}", views.warnings);
}

#[test]
fn what_pictures_do_not_show_is_said_once_a_kind() {
    let frame = format!(r#"{{ "transform_matrix": {MATRIX}, "file_path": "a/000.png" }}"#);
    let top = r#""fl_x": 410, "fl_y": 400, "cx": 332.5, "cy": 240, "w": 640, "h": 480, "k1": 0.1"#;
    let views = nerf(&format!(r#"{{ {top}, "frames": [{frame}, {frame}] }}"#), (100, 100)).expect("views");
    let names: Vec<&str> = views.cameras.iter().map(|(_, name)| name.as_str()).collect();
    assert_eq!(names, ["000", "000-1"]);
    let expected = [
        "differ by up to 2.50 % or a principal point up to 12.5 px off the middle; they are drawn with square pixels",
        "distortion",
        "use --size 640x480",
    ];
    assert_eq!(views.warnings.len(), expected.len(), "{:?}", views.warnings);
    for (warning, part) in views.warnings.iter().zip(expected) {
        assert!(warning.starts_with("2 of 2 views (000 first)") && warning.contains(part), "{warning}");
    }
    // Half a pixel and one part in a thousand are conventions and rounding.
    let top = r#""fl_x": 400.3, "fl_y": 400, "cx": 319.5, "cy": 240, "w": 640, "h": 480"#;
    let views = nerf(&format!(r#"{{ {top}, "frames": [{frame}] }}"#), (640, 480)).expect("views");
    assert_eq!(views.warnings, [""; 0]);
}

#[test]
fn faults_of_a_transforms_file_have_their_place() {
    let of_matrix = |matrix: &str| {
        let good = format!(r#"{{ "file_path": "0.png", "transform_matrix": {MATRIX} }}"#);
        let bad = format!(r#"{{ "file_path": "1.png", "transform_matrix": {matrix} }}"#);
        format!(r#"{{ "camera_angle_x": 1, "frames": [{good}, {bad}] }}"#)
    };
    let faults: Vec<(String, &str)> = vec![
        ("{".into(), "line 1 column"),
        ("{}".into(), "no `frames`"),
        (r#"{ "frames": [] }"#.into(), "lists no view"),
        (r#"{ "frames": 1 }"#.into(), "a list of frames"),
        (r#"{ "camera_angle_x": 1, "frames": [{}] }"#.into(), "frame 0: it has no `transform_matrix`"),
        (one_frame("", ""), "frame 0 (`./train/r_0.png`): it has no focal length"),
        (one_frame(r#""camera_angle_x": 50,"#, ""), "camera_angle_x 50 is not between 0 and pi"),
        (one_frame(r#""fl_x": -5, "w": 10, "h": 10,"#, ""), "a focal length of -5, -5 pixels is out of range"),
        (one_frame(r#""fl_x": 5, "w": 0, "h": 10,"#, ""), "an image of 0 x 10 pixels is out of range"),
        (one_frame(r#""fl_x": 1e-9, "w": 10, "h": 10,"#, ""), "vertical field of view"),
        (of_matrix("[[NaN, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]"), "line 1 column"),
        (of_matrix("[[1e999, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]"), "line 1 column"),
        (of_matrix("[[1, 0, 0], [0, 1, 0], [0, 0, 1]]"), "an array of length 4"),
        (
            of_matrix("[[1, 0, 0, 0], [0, 1, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]]"),
            "frame 1 (`1.png`): the rotation is singular",
        ),
        (of_matrix("[[0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 1]]"), "singular"),
        (of_matrix("[[1e300, 0, 0, 0], [0, 1e300, 0, 0], [0, 0, 1e300, 0], [0, 0, 0, 1]]"), "singular"),
        (
            of_matrix("[[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]"),
            "frame 1 (`1.png`): the rotation is mirrored",
        ),
        (of_matrix("[[1, 0, 0, 1e30], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]"), "the camera's place"),
        (
            of_matrix("[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [4, 5, 6, 1]]"),
            "[4.0, 5.0, 6.0, 1.0], not [0, 0, 0, 1]",
        ),
        (format!(r#"{{ "frames": [{}{{}}] }}"#, "{},".repeat(MOST_VIEWS)), "more than 100000 views"),
    ];
    for (text, part) in faults {
        let failure = nerf(&text, (10, 10)).expect_err(part);
        assert!(failure.code() == 1 && failure.message.contains(part), "{part}: {failure:?}");
        assert!(failure.message.contains("transforms.json") && !failure.hint.is_empty(), "{failure:?}");
    }
    let failure = read(Path::new("/nowhere/t.json"), (1, 1), &CameraSpec::default()).expect_err("no file");
    assert!(failure.message.starts_with("cannot read /nowhere/t.json"), "{failure:?}");
}

/// The camera of [`MATRIX`] as COLMAP has it: to the camera from the world, x right, y down, z forward.
fn colmap_pose() -> ([f64; 4], [f64; 3]) {
    // Right is −Z, down is −Y and forward is −X of the world: half a turn about (−1, 0, 1).
    let half = 0.5_f64.sqrt();
    ([0.0, -half, 0.0, half], [3.0, 2.0, 1.0])
}

const CAMERAS: &str = "# Camera list\n7 SIMPLE_PINHOLE 640 480 400 320 240\n\n9 PINHOLE 640 480 400 400 320 240\n";

fn colmap_text(folder: &Folder, below: &str) {
    let ([w, x, y, z], [a, b, c]) = colmap_pose();
    let images = format!(
        "# Image list\n1 {w} {x} {y} {z} {a} {b} {c} 7 in/my r_0.jpg\n1 2 -1 3 4 5\n2 1 0 0 0 0 0 0 9 b.c.png\n\n"
    );
    folder.write(&format!("{below}cameras.txt"), CAMERAS);
    folder.write(&format!("{below}images.txt"), images);
}

/// The same two views as binary files.
fn colmap_binary() -> (Vec<u8>, Vec<u8>) {
    let mut cameras = 2_u64.to_le_bytes().to_vec();
    let of_camera: [(u32, u32, &[f64]); 2] = [(7, 0, &[400.0, 320.0, 240.0]), (9, 1, &[400.0, 400.0, 320.0, 240.0])];
    for (id, model, params) in of_camera {
        cameras.extend([id.to_le_bytes(), model.to_le_bytes()].concat());
        cameras.extend([640_u64.to_le_bytes(), 480_u64.to_le_bytes()].concat());
        cameras.extend(params.iter().flat_map(|number| number.to_le_bytes()));
    }
    let (quaternion, translation) = colmap_pose();
    let mut images = 2_u64.to_le_bytes().to_vec();
    type Image<'a> = (u32, [f64; 4], [f64; 3], u32, &'a str, u64);
    let of_image: [Image<'_>; 2] =
        [(1, quaternion, translation, 7, "in/my r_0.jpg", 2), (2, [1.0, 0.0, 0.0, 0.0], [0.0; 3], 9, "b.c.png", 0)];
    for (id, quaternion, translation, camera, name, point_count) in of_image {
        images.extend(id.to_le_bytes());
        images.extend(quaternion.iter().chain(&translation).flat_map(|number| number.to_le_bytes()));
        images.extend(camera.to_le_bytes());
        images.extend(name.bytes().chain([0]));
        images.extend(point_count.to_le_bytes());
        images.extend((0..point_count * 24).map(|_| 7_u8));
    }
    (cameras, images)
}

#[test]
fn a_camera_is_the_same_in_every_format() {
    let top = r#""fl_x": 400, "fl_y": 400, "cx": 320, "cy": 240, "w": 640, "h": 480,"#;
    let of_nerf = nerf(&one_frame(top, ""), (64, 48)).expect("views");
    for below in ["", "sparse/0/", "sparse/"] {
        let folder = Folder::new(&format!("text-{}", below.len()));
        colmap_text(&folder, below);
        let of_text = folder.read((64, 48)).expect("text");
        let folder = Folder::new(&format!("binary-{}", below.len()));
        let (cameras, images) = colmap_binary();
        folder.write(&format!("{below}cameras.bin"), cameras);
        folder.write(&format!("{below}images.bin"), images);
        let of_binary = folder.read((64, 48)).expect("binary");
        assert_eq!(of_text.cameras, of_binary.cameras);
        assert_eq!((of_text.warnings.len(), of_text.files.len()), (0, 2), "{:?}", of_text.warnings);
        let names: Vec<&str> = of_text.cameras.iter().map(|(_, name)| name.as_str()).collect();
        assert_eq!(names, ["my-r_0", "b.c"]);
        let (of_nerf, of_colmap) = (&of_nerf.cameras[0].0, &of_text.cameras[0].0);
        assert!(world_from_view(of_nerf).abs_diff_eq(world_from_view(of_colmap), 1e-6), "{of_nerf:?} {of_colmap:?}");
        assert_eq!(of_nerf.fov_y_rad, of_colmap.fov_y_rad);
        // Without a turn COLMAP's camera looks along +Z with +Y down.
        let looks = world_from_view(&of_text.cameras[1].0);
        assert!(looks.transform_vector3(Vec3::NEG_Z).distance(Vec3::Z) < 1e-6, "{looks}");
        assert!(looks.transform_vector3(Vec3::Y).distance(Vec3::NEG_Y) < 1e-6, "{looks}");
    }
}

#[test]
fn distortion_of_colmap_is_left_out_with_a_warning() {
    let folder = Folder::new("distorted");
    folder.write("cameras.txt", "1 SIMPLE_RADIAL 640 480 400 320 240 0.1\n2 OPENCV 640 480 400 400 320 240 0 0 0 0\n");
    folder.write("images.txt", "1 1 0 0 0 0 0 0 1 a.png\n\n2 1 0 0 0 0 0 0 2 b.png\n");
    let views = folder.read((640, 480)).expect("views");
    assert_eq!(views.warnings, ["1 of 2 views (a first) have a lens with distortion; they are drawn without it"]);
}

#[test]
fn faults_of_a_colmap_folder_have_their_line() {
    let good = "1 1 0 0 0 0 0 0 7 a.png\n\n";
    let faults = [
        ("1 PINHOLE 640", good, "cameras.txt: line 1: this is not a camera"),
        ("1 PINHOLE 640 480 400 320 240", good, "has 4 parameters, and here are 3"),
        ("\n1 SOAP 640 480 4 3 2", good, "cameras.txt: line 2: unknown model of a camera `SOAP`"),
        ("1 PINHOLE 640 480 400 x 320 240", good, "`x` is not a number"),
        ("1 PINHOLE 640 480 nan 400 320 240", good, "a focal length of NaN, 400 pixels is out of range"),
        ("1 PINHOLE 640 480 400 400 inf 240", good, "principal point is out of range"),
        (CAMERAS, "1 1 0 0 0 0 0 0 8 a.png\n", "images.txt: line 1: camera 8 of image `a.png` is not among"),
        (CAMERAS, "1 1 0 0 0 0 0 0 7\n", "the image has no name"),
        (CAMERAS, "1 1 0 0\n", "this is not an image"),
        (CAMERAS, "1 0 0 0 0 0 0 0 7 a.png\n", "the quaternion 0 0 0 0 is not a rotation"),
        (CAMERAS, "1 nan 0 0 0 0 0 0 7 a.png\n", "is not a rotation"),
        (CAMERAS, "1 1 0 0 0 inf 0 0 7 a.png\n", "the camera's place"),
        (
            CAMERAS,
            "1 1 0 0 0 0 0 0 7 a.png\n2 1 0 0 0 0 0 0 7 b.png\n",
            "images.txt: line 2: here should be the points",
        ),
        (CAMERAS, "# none\n", "lists no view"),
    ];
    for (index, (cameras, images, part)) in faults.into_iter().enumerate() {
        let folder = Folder::new(&format!("faulty-{index}"));
        folder.write("cameras.txt", cameras);
        folder.write("images.txt", images);
        let failure = folder.read((640, 480)).expect_err(part);
        assert!(failure.code() == 1 && failure.message.contains(part), "{part}: {failure:?}");
        assert!(!failure.hint.is_empty(), "{failure:?}");
    }
    let folder = Folder::new("faulty-none");
    let failure = folder.read((640, 480)).expect_err("no files");
    assert!(failure.message.contains("has COLMAP's cameras and images"), "{failure:?}");
    folder.write("cameras.txt", CAMERAS);
    folder.write("images.txt", good.repeat(MOST_VIEWS + 1));
    let failure = folder.read((640, 480)).expect_err("many");
    assert!(failure.message.contains("lists more than 100000 views"), "{failure:?}");
}

#[test]
fn binary_files_that_end_or_lie_are_refused() {
    let folder = Folder::new("binary-faults");
    let (cameras, images) = colmap_binary();
    folder.write("cameras.bin", &cameras);
    for length in 0..images.len() - 1 {
        folder.write("images.bin", &images[..length]);
        let failure = folder.read((640, 480)).expect_err("a short file");
        assert!(
            failure.message.contains("images.bin: ") && failure.message.contains("the file ends here"),
            "{failure:?}"
        );
    }
    folder.write("images.bin", u64::MAX.to_le_bytes());
    assert!(folder.read((640, 480)).expect_err("a count").message.contains("more than 100000 views"));
    // The number of points of the last image, which is followed by none.
    let lying = [&images[..images.len() - 8], &u64::MAX.to_le_bytes()].concat();
    folder.write("images.bin", lying);
    assert!(folder.read((640, 480)).expect_err("points").message.contains("image 1 of 2: the file ends here"));
    folder.write("images.bin", &images);
    folder.write("cameras.bin", &cameras[..20]);
    assert!(folder.read((640, 480)).expect_err("cameras").message.contains("camera 0 of 2: the file ends here"));
    folder.write("cameras.bin", [&1_u64.to_le_bytes()[..], &[0xff; 48]].concat());
    assert!(folder.read((640, 480)).expect_err("a model").message.contains("unknown model of a camera 4294967295"));
}

#[test]
fn names_are_those_of_images() {
    let names = [("./train/r_0", "r_0"), ("a\\b\\000.PNG", "000"), ("r_0.5", "r_0.5"), (".png", ".png"), ("", "")];
    for (path, name) in names {
        assert_eq!(stem(path), name, "{path}");
    }
}
