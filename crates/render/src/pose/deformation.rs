//! Joints and weights of morph targets, the same for all views of a frame.

use manypass_scene::Scene;
use std::collections::BTreeMap;

/// Transforms of skins and weights of morph targets of all nodes.
#[derive(Debug, Default)]
pub(crate) struct Deformation {
    /// Rows of `world_from_mesh`, three a joint.
    pub joint_rows: Vec<[f32; 4]>,
    /// Weights.
    pub morph_weights: Vec<f32>,
    /// By skin: its nodes share them.
    joints: BTreeMap<usize, Joints>,
}

/// The joints of a skin in the table.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Joints {
    pub first: u32,
    /// Whether most of them turn triangles around; a mesh has one winding, so the others have to do with it.
    pub mirrored: bool,
}

impl Deformation {
    /// Forgets what it holds, and keeps the memory.
    pub fn clear(&mut self) {
        self.joint_rows.clear();
        self.morph_weights.clear();
        self.joints.clear();
    }

    /// Whether nothing is deformed, nor would be if its skin had joints.
    pub fn is_empty(&self) -> bool {
        self.joints.is_empty() && self.joint_rows.is_empty() && self.morph_weights.is_empty()
    }

    /// The joints of a skin, which are appended for the first of its nodes.
    pub fn joints_of(&mut self, scene: &Scene, skin: usize) -> Joints {
        if let Some(known) = self.joints.get(&skin) {
            return *known;
        }
        let first = (self.joint_rows.len() / 3) as u32;
        let mut balance = 0;
        for matrix in scene.joint_matrices(skin) {
            self.joint_rows.extend([0, 1, 2].map(|row| matrix.row(row).to_array()));
            let determinant = matrix.determinant();
            balance += i32::from(determinant > 0.0) - i32::from(determinant < 0.0);
        }
        let joints = Joints { first, mirrored: balance < 0 };
        self.joints.insert(skin, joints);
        joints
    }

    /// Where the joints of a skin begin in the table.
    pub fn first_joint(&mut self, scene: &Scene, skin: usize) -> u32 {
        self.joints_of(scene, skin).first
    }

    /// Weights for `count` targets, and where the first of them is; what is missing is 0.
    pub fn append_weights(&mut self, weights: &[f32], count: u32) -> u32 {
        let first = self.morph_weights.len() as u32;
        self.morph_weights.extend((0..count as usize).map(|i| weights.get(i).copied().unwrap_or(0.0)));
        first
    }
}
