//! The effect that docs/commands.md shows works as it stands there.

use crate::common::{Folder, has_adapter, run_in, triangle_glb};

const PAGE: &str = include_str!("../../../docs/commands.md");

/// The text of the first fence of `language`.
fn fence(language: &str) -> &'static str {
    let (_, rest) = PAGE.split_once(&format!("```{language}\n")).expect("the fence begins");
    rest.split_once("```").expect("the fence ends").0
}

#[test]
fn the_effect_of_the_page_takes_its_setting() {
    if !has_adapter() {
        return;
    }
    let folder = Folder::new("shown-effect");
    folder.write("helmet.glb", &triangle_glb([0.5, 0.5, 0.5]));
    let text = fence("wgsl");
    assert!((6..=10).contains(&text.lines().count()), "six to ten lines:\n{text}");
    folder.write("my.wgsl", text.as_bytes());
    let (_, rest) = PAGE.split_once("`manypass render helmet.glb --effect my.wgsl").expect("the command");
    let rest = rest.split_once('`').expect("its end").0;
    assert_eq!(rest, " --set my.amount=2");
    let red_over_blue = |setting: &str| {
        let words = ["render", "helmet.glb", "--effect", "my.wgsl", "--set", setting, "--background", "000000"];
        run_in(&folder, &[&words[..], &["--size", "32x32", "--samples", "1", "-o", "out.png"]].concat()).expect(0);
        let picture = image::open(folder.join("out.png")).expect("a picture").to_rgba8();
        let sum = |channel: usize| picture.pixels().map(|pixel| f64::from(pixel.0[channel])).sum::<f64>();
        sum(0) / sum(2)
    };
    let [none, one, two] = ["my.amount=0", "my.amount=1", "my.amount=2"].map(red_over_blue);
    assert!(one > 1.1 * none && two > 1.1 * one, "{none}, {one}, {two}");
    let run = run_in(&folder, &["settings", "--effect", "my.wgsl"]).expect(0);
    assert!(run.text().contains("my.amount"), "{}", run.text());
}
