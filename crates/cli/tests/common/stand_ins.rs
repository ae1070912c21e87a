//! Small files in place of a user's own that pages name.

use super::{Folder, triangle_glb};
use manypass_testkit::ktx2::cube_map;

/// A stage of the user's.
const STAGE: &[u8] = b"model = \"room.glb\"\n[[lights]]\nkind = \"point\"\nposition = [0, 1, 2]\n";
/// A camera three metres before the origin, as NeRF's tools write it.
const TRANSFORMS: &[u8] = br#"{"camera_angle_x":0.8,"frames":[{"file_path":"./train/a.png",
    "transform_matrix":[[1,0,0,0],[0,1,0,0],[0,0,1,3],[0,0,0,1]]}]}"#;

/// What stands in for a file by its name: for a model, a stage, or a picture of the environment. Models are known by
/// their first bytes, whatever they end in.
pub fn of(name: &str) -> Option<Vec<u8>> {
    // R8G8B8A8_SRGB.
    const FORMAT: u32 = 43;
    // Several files, or one that a bake writes.
    if name.contains('*') || name == "baked.glb" {
        return None;
    }
    match name.rsplit_once('.')? {
        ("room" | "part" | "shoe", "glb" | "gltf") => Some(room_glb()),
        (_, "glb") => Some(triangle_glb([1.0, 0.0, 0.0])),
        (_, "hdr") => Some(radiance(4, 2)),
        (_, "ktx2") => Some(cube_map(FORMAT, 32, 1, |_| vec![200, 200, 200, 255])),
        (stem, "toml") if stem.ends_with(".stage") => Some(STAGE.to_vec()),
        _ => None,
    }
}

/// Writes what folders and lists of the user's hold, and the model of stages: the faces of a cube, and cameras as
/// NeRF's tools and COLMAP write them.
pub fn write_all(folder: &Folder) {
    folder.write("room.glb", &room_glb());
    for face in ["px", "nx", "py", "ny", "pz", "nz"] {
        folder.write(&format!("cube/{face}.hdr"), &radiance(2, 2));
    }
    // A stage of the examples names it.
    folder.write("dusk.hdr", &radiance(4, 2));
    folder.write("transforms.json", TRANSFORMS);
    folder.write("colmap/cameras.txt", b"1 PINHOLE 32 18 30 30 16 9\n");
    folder.write("colmap/images.txt", b"1 1 0 0 0 0 0 3 1 a.jpg\n\n");
}

/// A Radiance file of one colour.
fn radiance(width: usize, height: usize) -> Vec<u8> {
    let head = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n");
    let texels = [128_u8, 16, 16, 131].repeat(width * height);
    [head.as_bytes(), &texels[..]].concat()
}

/// A .glb with what stages name: quads as nodes `Lake` (it lies), `Glass`, `Door.1`, `Door.2`, `Goer.1` and `Wall`, a
/// node with a camera, materials, and variants `midnight` and `beach`.
pub fn room_glb() -> Vec<u8> {
    let corners: [f32; 20] = [
        -1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 1.0, 1.0, 0.0, -1.0, 1.0, 0.0, // Positions, then UVs.
        0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0,
    ];
    let mut bin: Vec<u8> = corners.iter().flat_map(|value| value.to_le_bytes()).collect();
    bin.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|index| index.to_le_bytes()));
    let mut nodes = vec![r#"{"name":"Lake","mesh":0,"rotation":[-0.70710678,0,0,0.70710678]}"#.to_owned()];
    for (at, name) in ["Glass", "Door.1", "Door.2", "Goer.1", "Wall"].iter().enumerate() {
        nodes.push(format!(r#"{{"name":"{name}","mesh":{},"translation":[{},0,0]}}"#, (at + 1) % 3, at + 1));
    }
    nodes.push(r#"{"name":"Ceiling camera","camera":0,"translation":[0,2,6]}"#.to_owned());
    let quad = r#""attributes":{"POSITION":0,"TEXCOORD_0":1,"TEXCOORD_1":1},"indices":2"#;
    let meshes = [0, 1, 2].map(|at| format!(r#"{{"primitives":[{{{quad},"material":{at}}}]}}"#)).join(",");
    let mut json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0,1,2,3,4,5,6]}}],"nodes":[{}],
        "extensionsUsed":["KHR_materials_variants"],
        "extensions":{{"KHR_materials_variants":{{"variants":[{{"name":"midnight"}},{{"name":"beach"}}]}}}},
        "cameras":[{{"type":"perspective","perspective":{{"yfov":0.8,"znear":0.1}}}}],"meshes":[{meshes}],
        "materials":[{{"name":"Screen"}},{{"name":"wall"}},{{"name":"roof"}}],
        "accessors":[
            {{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[-1,-1,0],"max":[1,1,0]}},
            {{"bufferView":1,"componentType":5126,"count":4,"type":"VEC2"}},
            {{"bufferView":2,"componentType":5123,"count":6,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":32}},
            {{"buffer":0,"byteOffset":80,"byteLength":12}}],
        "buffers":[{{"byteLength":92}}]}}"#,
        nodes.join(",")
    )
    .into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let (json_bytes, bin_bytes) = (json.len() as u32, bin.len() as u32);
    let head = [0x4654_6c67, 2, 28 + json_bytes + bin_bytes, json_bytes, 0x4e4f_534a].map(u32::to_le_bytes).concat();
    [head, json, [bin_bytes, 0x004e_4942].map(u32::to_le_bytes).concat(), bin].concat()
}
