//! What the words of a header let an effect's shader find declared beside the prelude. Only they do, so that files without
//! them may give their own things these names.

use std::fmt::Write;

/// The texture of the ids of nodes and materials, whose texels are whole numbers.
pub(super) const IDS: &str = "ids";
/// The first binding of textures that a header declares; those before are the prelude's.
pub(super) const FIRST_TEXTURE: u32 = 10;
/// The first binding of tables.
const FIRST_TABLE: u32 = 500;

/// A texture that a header lets the shader read, and that only the header declares.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct BorrowedTexture {
    /// As the header has it: of the frame `NAME`, of another effect `EFFECT.TEXTURE`.
    pub key: String,
    /// What the shader calls it.
    pub variable: String,
    /// The settings of which one has to be other than 0 for the shader to look at it; none where it always may.
    pub settings: Vec<String>,
}

impl BorrowedTexture {
    /// What `key` stands for.
    pub fn new(key: &str) -> Self {
        Self { key: key.into(), variable: key.replace(['.', '-'], "_"), settings: Vec::new() }
    }

    /// The effect and its texture, if it is one of an effect's.
    pub fn of_effect(&self) -> Option<(&str, &str)> {
        self.key.split_once('.')
    }
}

/// The declarations that a shader finds which reads `display`, finds `drawn`, and reads its own `textures` and those that
/// it borrows.
pub(super) fn declarations(
    reads_display: bool,
    finds_drawn: bool,
    textures: &[&str],
    borrowed: &[BorrowedTexture],
) -> String {
    let mut declarations = format!("{}\n", crate::shader::compose::EFFECT_PRELUDE);
    if reads_display {
        declarations.push_str(include_str!("display.wgsl"));
    }
    if finds_drawn {
        declarations.push_str(include_str!("steps.wgsl"));
    }
    for (binding, texture) in (FIRST_TEXTURE..).zip(textures) {
        declarations.push_str(&texture_declaration(binding, texture));
    }
    for (binding, borrowed) in (FIRST_TEXTURE + textures.len() as u32..).zip(borrowed) {
        let declaration = texture_declaration(binding, &borrowed.variable);
        let is_whole = borrowed.key == IDS;
        declarations.push_str(&if is_whole { declaration.replace("<f32>", "<u32>") } else { declaration });
    }
    declarations
}

/// The declarations of tables, which are textures of three dimensions.
pub(super) fn table_declarations<'t>(tables: impl Iterator<Item = &'t str>) -> String {
    let declaration =
        |(binding, table): (u32, &str)| format!("@group(1) @binding({binding}) var {table}: texture_3d<f32>;\n");
    (FIRST_TABLE..).zip(tables).map(declaration).collect()
}

/// The declaration of a texture.
pub(super) fn texture_declaration(binding: u32, texture: &str) -> String {
    let mut declaration = String::new();
    let _ = writeln!(declaration, "@group(1) @binding({binding}) var {texture}: texture_2d<f32>;");
    declaration
}
