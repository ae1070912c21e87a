//! The help and documentation of AOVs, from the table that encoders use, too.

use manypass::Aov;
use std::fmt::Write as _;

/// The table of `docs/aovs.md`, in Markdown.
pub fn markdown_table() -> String {
    let mut text = String::from(
        "| name | what it is | EXR channels | unit | space | where there is no surface | PNG |\n|---|---|---|---|---|---|---|\n",
    );
    for aov in Aov::ALL {
        let info = aov.info();
        let channels = info.channels.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(" ");
        let _ = writeln!(
            text,
            "| `{}` | {} | {channels} | {} | {} | {} | {} |",
            info.name,
            info.doc,
            info.unit,
            info.space,
            info.background,
            info.png.doc(),
        );
    }
    text
}

/// The long help of `--aov`.
pub fn help() -> String {
    let mut text = String::from(
        "`all`, or names with commas: layers of .exr, or .png files of their own\n\n\
         They show opaque and masked surfaces, not blended ones, at the middle of each pixel. Only radiance is the average \
         of all samples, with everything. In .exr all values are 32-bit floats, ids 32-bit whole numbers. In .png a number v \
         stands for a value as said below. The report (aov_ranges) and the file's text `manypass` have low and high. \
         Cameras are in the headers of .exr and in the report. docs/aovs.md has all of this with code.\n",
    );
    for aov in Aov::ALL {
        let info = aov.info();
        let _ = write!(
            text,
            "\n{}: {}. Unit: {}. Space: {}. No surface: {}. PNG: {}.",
            info.name,
            info.doc,
            info.unit,
            info.space,
            info.background,
            info.png.doc(),
        );
    }
    text
}
