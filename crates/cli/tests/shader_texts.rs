//! The composed texts of shaders go to the folder that the environment names.

use crate::common::{Folder, has_adapter, run_with, triangle_glb};

#[test]
fn composed_texts_are_written_to_the_folder_that_is_named() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("shader-texts");
    folder.write("tri.glb", &triangle_glb([0.9, 0.1, 0.1]));
    folder.write("file", b"in the way");
    let render = |place: &str| {
        let words = ["render", "tri.glb", "--effect", "film", "--size", "16x16", "--samples", "1", "-o", "a.png"];
        run_with(&folder, &words, &[("MANYPASS_NO_CACHE", "1"), ("MANYPASS_SHADER_DUMP", place)])
    };
    render("").expect(0);
    assert!(!folder.join("texts").exists());
    render("texts/new").expect(0);
    for name in ["tone_map.wgsl", "effect.film.wgsl"] {
        let text = std::fs::read_to_string(folder.join("texts/new").join(name)).expect(name);
        assert!(text.contains("@fragment"), "{name}: {text}");
    }
    let run = render("file/below").expect(1);
    let is_told = |word: &&str| run.stderr.contains(*word);
    assert!(["file/below", "MANYPASS_SHADER_DUMP", "hint: "].iter().all(is_told), "{}", run.stderr);
}
