//! Runs the program, and says whether this machine can render.

#![allow(dead_code, reason = "each test file uses a part")]

pub mod stand_ins;
pub mod watch;

use manypass_testkit::compare::Picture;
use manypass_testkit::needs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU32, Ordering};

/// What a run gave.
#[derive(Debug)]
pub struct Run {
    /// The exit code.
    pub code: i32,
    /// Standard output.
    pub stdout: Vec<u8>,
    /// Standard error.
    pub stderr: String,
}

impl From<Output> for Run {
    fn from(output: Output) -> Self {
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        Self { code: output.status.code().unwrap_or(-1), stdout: output.stdout, stderr }
    }
}

impl Run {
    /// Standard output as text.
    pub fn text(&self) -> String {
        String::from_utf8_lossy(&self.stdout).into_owned()
    }

    /// Fails the test unless the run ended with `code`.
    #[track_caller]
    pub fn expect(self, code: i32) -> Self {
        assert_eq!(self.code, code, "standard error: {}", self.stderr);
        self
    }
}

/// Runs the program in `folder`.
pub fn run_in(folder: &Path, args: &[&str]) -> Run {
    run_with(folder, args, &[("MANYPASS_NO_CACHE", "1")])
}

/// Runs the program in `folder` with some variables of the environment.
pub fn run_with(folder: &Path, args: &[&str], variables: &[(&str, &str)]) -> Run {
    let mut command = Command::new(env!("CARGO_BIN_EXE_manypass"));
    command.args(args).current_dir(folder).stdin(Stdio::null()).envs(variables.iter().copied());
    command.output().expect("the program starts").into()
}

/// Runs the program in `folder` with `input` on standard input.
pub fn run_with_input(folder: &Path, args: &[&str], input: &[u8]) -> Run {
    let mut child = Command::new(env!("CARGO_BIN_EXE_manypass"))
        .args(args)
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    child.stdin.take().expect("piped").write_all(input).expect("the program reads");
    child.wait_with_output().expect("the program ends").into()
}

/// An empty folder that goes when the test ends.
#[derive(Debug)]
pub struct Folder(PathBuf);

impl Folder {
    /// A folder of this call for the test called `name`; others have the same name, in the same process, too.
    pub fn new(name: &str) -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("manypass-cli-{name}-{}-{count}", std::process::id()));
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).expect("a folder");
        Self(path)
    }

    /// The path of `name` in it.
    pub fn join(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Writes a file into it.
    pub fn write(&self, name: &str, bytes: &[u8]) {
        let path = self.join(name);
        std::fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
        std::fs::write(path, bytes).expect("written");
    }

    /// The names in it, in order.
    pub fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(&self.0).expect("listed");
        let mut names: Vec<String> =
            entries.map(|entry| entry.expect("entry").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }
}

impl std::ops::Deref for Folder {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.0
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Whether there is an adapter. Without one the test fails, or is skipped where MANYPASS_ALLOW_NO_GPU=1 says that this
/// is known.
#[track_caller]
pub fn has_adapter() -> bool {
    static FOUND: OnceLock<bool> = OnceLock::new();
    let found = *FOUND.get_or_init(|| !run_in(Path::new("."), &["adapters"]).stdout.is_empty());
    if !found {
        let is_allowed = std::env::var_os("MANYPASS_ALLOW_NO_GPU").is_some_and(|value| value == "1");
        assert!(is_allowed, "no adapter, and MANYPASS_ALLOW_NO_GPU=1 is not set");
        needs::skip("no graphics adapter on this machine; on Debian and Ubuntu install mesa-vulkan-drivers");
    }
    found
}

/// A Python that has these modules: the one that MANYPASS_PYTHON names, or else that of `cargo xtask setup` or the
/// machine's.
pub fn python(modules: &[&str]) -> Option<PathBuf> {
    let of_setup = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../target/python/bin/python");
    let known = match std::env::var_os("MANYPASS_PYTHON") {
        Some(named) => vec![PathBuf::from(named)],
        None => vec![of_setup, "python3".into()],
    };
    let mut script = format!("import {}\n", [&["sys"][..], modules].concat().join(", "));
    if modules.contains(&"OpenEXR") {
        // Versions before 3.3 have other calls.
        script += "OpenEXR.File\n";
    }
    known.into_iter().find(|python| {
        let import = Command::new(python).args(["-c", script.as_str()]).stdin(Stdio::null()).output();
        import.is_ok_and(|output| output.status.success())
    })
}

/// A .glb of one triangle of the given colour, two metres wide, at the origin; with an animation `Slide` of one second
/// that moves it by two metres along x.
pub fn triangle_glb(color: [f32; 3]) -> Vec<u8> {
    let floats: [f32; 17] = [-1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0];
    let bin: Vec<u8> = floats.iter().flat_map(|value| value.to_le_bytes()).collect();
    let [r, g, b] = color;
    let mut json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0,"name":"tri"}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"material":0}}]}}],
        "materials":[{{"name":"paint","doubleSided":true,
            "pbrMetallicRoughness":{{"baseColorFactor":[{r},{g},{b},1],"metallicFactor":0}}}}],
        "animations":[{{"name":"Slide","samplers":[{{"input":1,"output":2}}],
            "channels":[{{"sampler":0,"target":{{"node":0,"path":"translation"}}}}]}}],
        "accessors":[
            {{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[-1,-1,0],"max":[1,1,0]}},
            {{"bufferView":1,"componentType":5126,"count":2,"type":"SCALAR","min":[0],"max":[1]}},
            {{"bufferView":2,"componentType":5126,"count":2,"type":"VEC3"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":8}},
            {{"buffer":0,"byteOffset":44,"byteLength":24}}],
        "buffers":[{{"byteLength":68}}]}}"#
    )
    .into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut glb = Vec::new();
    let total = 12 + 8 + json.len() + 8 + bin.len();
    for word in [0x4654_6c67, 2, total as u32, json.len() as u32, 0x4e4f_534a] {
        glb.extend_from_slice(&u32::to_le_bytes(word));
    }
    glb.extend_from_slice(&json);
    for word in [bin.len() as u32, 0x004e_4942] {
        glb.extend_from_slice(&u32::to_le_bytes(word));
    }
    glb.extend_from_slice(&bin);
    glb
}

/// A 3MF file whose model is `text`.
pub fn packed_3mf(text: &str) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    archive.start_file("3D/3dmodel.model", zip::write::SimpleFileOptions::default()).expect("a part");
    archive.write_all(text.as_bytes()).expect("written");
    archive.finish().expect("finished").into_inner()
}

/// The picture in the bytes of a file.
pub fn picture(bytes: &[u8]) -> Picture {
    let image = image::load_from_memory(bytes).expect("a picture").into_rgba8();
    Picture::from_rgba8(image.width() as usize, image.height() as usize, image.as_raw())
}
