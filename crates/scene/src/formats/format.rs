//! The formats of models.

/// What a model is written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// glTF 2.0, as `.gltf` or `.glb`.
    Gltf,
    /// Stereolithography: triangles, as text or bytes.
    Stl,
    /// Wavefront OBJ with its MTL.
    Obj,
    /// The polygon format of Stanford: meshes and point clouds.
    Ply,
    /// 3D Manufacturing Format.
    ThreeMf,
}
