//! Tables of colours (`.cube`), as effects.
//!
//! Source: Adobe 2013, "Cube LUT Specification 1.0"; and the ranges that DaVinci Resolve writes.

use crate::diagnostic::Diagnostic;
use crate::user_shader::Source;
use half::f16;
use std::ops::Range;
use std::path::Path;

/// Colours along each side of a table: a texture of 17 MiB.
const SIDE_MAX: usize = 128;
/// Entries of a curve.
const CURVE_MAX: usize = 65536;
/// Entries of a curve in a row of its texture, as `lut_1d.wgsl` has it.
const ROW: usize = 256;

/// A table that an effect reads, beside the textures of the frame.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Table {
    /// What the shader calls it.
    pub variable: String,
    /// Texels along each side.
    pub size: [u32; 3],
    /// Red, green, blue and 1, red first.
    pub texels: Vec<[f16; 4]>,
}

/// What a file says.
#[derive(Debug)]
struct Cube {
    /// Whether there is a table, in place of curves.
    is_solid: bool,
    size: usize,
    least: [f32; 3],
    most: [f32; 3],
    values: Vec<[f32; 3]>,
}

/// Whether a file is a table of colours, by its name.
pub(super) fn is_cube(file: &str) -> bool {
    Path::new(file).extension().is_some_and(|end| end.eq_ignore_ascii_case("cube"))
}

/// The text of the effect that a table of colours is, and the table.
///
/// # Errors
/// The text is none, with its place.
pub(super) fn effect(source: Source<'_>) -> Result<(String, Table), Box<Diagnostic>> {
    let cube = parse(source)?;
    let stem = Path::new(source.file).file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let name = name(&stem.unwrap_or_default());
    let variable = format!("table_of_{}", name.replace('-', "_"));
    let look_up = if cube.is_solid { include_str!("lut_3d.wgsl") } else { include_str!("lut_1d.wgsl") };
    let template = format!("{}\n{look_up}", include_str!("lut.wgsl"));
    let vector = |[r, g, b]: [f32; 3]| format!("vec3f({r:?}, {g:?}, {b:?})");
    let text = template
        .replace("NAME", &name)
        .replace("TABLE", &variable)
        .replace("SIZE", &cube.size.to_string())
        .replace("DOMAIN_LEAST", &vector(cube.least))
        .replace("DOMAIN_MOST", &vector(cube.most));
    let limit = f32::from(f16::MAX);
    let texel = |value: &[f32; 3]| {
        let [r, g, b] = value.map(|value| f16::from_f32(value.clamp(-limit, limit)));
        [r, g, b, f16::ONE]
    };
    let mut texels: Vec<[f16; 4]> = cube.values.iter().map(texel).collect();
    let size = if cube.is_solid {
        [cube.size as u32; 3]
    } else {
        texels.resize(cube.size.next_multiple_of(ROW), [f16::ZERO; 4]);
        [ROW as u32, (texels.len() / ROW) as u32, 1]
    };
    Ok((text, Table { variable, size, texels }))
}

/// A name of an effect, as near to that of the file as may be.
fn name(stem: &str) -> String {
    let is_good = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    let name: String = stem.chars().map(|c| if is_good(c) { c } else { '_' }).take(48).collect();
    if name.starts_with(|c: char| c.is_ascii_alphabetic()) { name } else { format!("lut_{name}") }
}

fn parse(source: Source<'_>) -> Result<Cube, Box<Diagnostic>> {
    let mut declared: Option<(bool, usize, Range<usize>)> = None;
    let (mut least, mut most) = ([0.0; 3], [1.0; 3]);
    let mut domain = 0..0;
    let mut values: Vec<[f32; 3]> = Vec::new();
    let mut start = 0;
    for line in source.text.split_inclusive('\n') {
        let whole = line.trim();
        let begin = start + (line.len() - line.trim_start().len());
        let place = begin..begin + whole.len();
        start += line.len();
        if whole.is_empty() || whole.starts_with('#') || whole.starts_with("TITLE") {
            continue;
        }
        let fault = |message: &str| source.fault(place.clone(), message);
        let numbers = |text: &str| -> Option<Vec<f32>> {
            text.split_whitespace().map(|word| word.parse().ok().filter(|number: &f32| number.is_finite())).collect()
        };
        let (word, rest) = whole.split_once(char::is_whitespace).unwrap_or((whole, ""));
        match word {
            "LUT_3D_SIZE" | "LUT_1D_SIZE" => {
                let is_solid = word == "LUT_3D_SIZE";
                let limit = if is_solid { SIDE_MAX } else { CURVE_MAX };
                if declared.is_some() {
                    return Err(fault("a table has one size; tables of two kinds in one file are not read"));
                }
                let size = rest.trim().parse().ok().filter(|size| (2..=limit).contains(size));
                let size = size.ok_or_else(|| fault(&format!("its size is a number from 2 to {limit}")))?;
                declared = Some((is_solid, size, place));
            }
            "DOMAIN_MIN" | "DOMAIN_MAX" => {
                let Some(&[r, g, b]) = numbers(rest).as_deref() else {
                    return Err(fault("three numbers follow: of red, green and blue"));
                };
                *(if word == "DOMAIN_MIN" { &mut least } else { &mut most }) = [r, g, b];
                domain = place;
            }
            "LUT_3D_INPUT_RANGE" | "LUT_1D_INPUT_RANGE" => {
                let Some(&[low, high]) = numbers(rest).as_deref() else {
                    return Err(fault("two numbers follow: the least and the largest"));
                };
                (least, most) = ([low; 3], [high; 3]);
                domain = place;
            }
            _ => match (numbers(whole).as_deref(), &declared) {
                (Some(&[r, g, b]), Some((is_solid, size, _))) => {
                    let count = if *is_solid { size.pow(3) } else { *size };
                    if values.len() == count {
                        return Err(fault(&format!("there are more than the {count} colours that the size says")));
                    }
                    values.push([r, g, b]);
                }
                (Some(&[_, _, _]), None) => {
                    return Err(fault("colours follow `LUT_3D_SIZE` or `LUT_1D_SIZE` and their number"));
                }
                _ => {
                    return Err(fault(
                        "this is neither a colour, of three finite numbers, nor a word of `.cube` files",
                    ));
                }
            },
        }
    }
    let Some((is_solid, size, place)) = declared else {
        let end = source.text.len();
        return Err(
            source.fault(end..end, "it is not a look-up table: a line `LUT_3D_SIZE` or `LUT_1D_SIZE` is missing")
        );
    };
    let count = if is_solid { size.pow(3) } else { size };
    if values.len() < count {
        return Err(source.fault(place, format!("it says {count} colours, and there are {}", values.len())));
    }
    if least.iter().zip(&most).any(|(least, most)| least >= most) {
        return Err(source.fault(domain, "the domain is empty: its end is not above its beginning"));
    }
    Ok(Cube { is_solid, size, least, most, values })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str) -> String {
        effect(Source { file: "look.cube", text }).expect_err(text).to_string()
    }

    #[test]
    fn what_is_no_table_is_refused_with_its_place() {
        for (text, expected) in [
            ("", "look.cube:1:1: error: it is not a look-up table"),
            ("LUT_3D_SIZE 1", "look.cube:1:1: error: its size is a number from 2 to 128"),
            ("LUT_3D_SIZE 300", "its size is a number from 2 to 128"),
            ("LUT_1D_SIZE 70000", "its size is a number from 2 to 65536"),
            ("LUT_3D_SIZE two", "its size is a number"),
            ("LUT_3D_SIZE 2\n0 0 0\n", "look.cube:1:1: error: it says 8 colours, and there are 1"),
            ("LUT_1D_SIZE 2\n0 0 0\n1 1 1\n 1 1 1", "look.cube:4:2: error: there are more than the 2 colours"),
            ("0 0 0", "colours follow `LUT_3D_SIZE`"),
            ("LUT_1D_SIZE 2\n0 0 nan\n", "look.cube:2:1: error: this is neither a colour"),
            ("LUT_1D_SIZE 2\n0 0\n", "this is neither a colour"),
            ("LUT_1D_SIZE 2\nLUT_3D_SIZE 2", "a table has one size"),
            ("DOMAIN_MIN 0 0", "three numbers follow"),
            ("LUT_1D_SIZE 2\nDOMAIN_MAX 0 1 1\n0 0 0\n1 1 1", "look.cube:2:1: error: the domain is empty"),
        ] {
            let error = error(text);
            assert!(error.contains(expected), "{text}\n{error}\nshould say {expected}");
        }
        assert_eq!(name("2 Strip é"), "lut_2_Strip__");
    }
}
