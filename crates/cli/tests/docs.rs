//! Commands of the pages that take no time are run as they stand there.

mod common;

use common::{Folder, run_in, triangle_glb};
use manypass_testkit::pages::{self, root};

/// Where files are that pages name without a folder.
const FOLDERS: [&str; 3] = ["", "crates/render/examples", "docs/examples/effects"];

#[test]
fn commands_of_the_pages_that_draw_nothing_run() {
    let folder = Folder::new("docs");
    let mut count = 0;
    for (page, text) in pages::pages() {
        for command in pages::commands(&page, &text).iter().filter(|command| !command.is_mentioned) {
            let words: Vec<&str> = command.words.iter().skip(1).map(String::as_str).collect();
            let draws_nothing = match words.first() {
                Some(&("settings" | "info")) => true,
                Some(&"graph") => words.contains(&"--limits"),
                _ => false,
            };
            if !draws_nothing {
                continue;
            }
            for word in &words {
                if word.ends_with(".glb") {
                    folder.write(word, &triangle_glb([1.0, 0.0, 0.0]));
                } else if let Some(path) =
                    FOLDERS.iter().map(|folder| root().join(folder).join(word)).find(|path| path.is_file())
                {
                    folder.write(word, &std::fs::read(path).expect("a file of the repository"));
                }
            }
            let run = run_in(&folder, &words);
            assert_eq!(run.code, 0, "{}: {}: {}", command.place, words.join(" "), run.stderr);
            assert!(!run.stdout.is_empty(), "{}: it prints nothing", command.place);
            count += 1;
        }
    }
    assert!(count >= 5, "{count} commands");
}
