//! An effect's text with other names, so that several can stand in one module.

use crate::user_shader::scan::{Scan, words};
use std::collections::HashSet;

/// `text`, whose scan is `scan`, with `prefix` before every name that it declares itself outside of functions, and its
/// bindings from `first_binding` on. None where a binding is no plain number.
///
/// A name within a function that is the same as one outside is renamed with it, which changes nothing. Members of
/// structs keep theirs.
pub(super) fn renamed(text: &str, scan: &Scan, prefix: &str, first_binding: usize) -> Option<String> {
    let words = words(text);
    let at = |index: usize| words.get(index).map(|range| &text[range.clone()]);
    let declared: HashSet<&str> = declared(&at, words.len());
    debug_assert!(scan.functions.keys().all(|name| declared.contains(name.as_str())), "{declared:?}");
    let mut result = String::with_capacity(text.len() * 2);
    let mut copied = 0;
    let mut binding = first_binding;
    let mut in_struct = false;
    for (index, range) in words.iter().enumerate() {
        let word = &text[range.clone()];
        let before = index.checked_sub(1).and_then(&at);
        match word {
            "struct" => in_struct = true,
            "}" => in_struct = false,
            _ => {}
        }
        let replacement = if word == "binding" && before == Some("@") && at(index + 1) == Some("(") {
            at(index + 2)?.parse::<u32>().ok().filter(|_| at(index + 3) == Some(")"))?;
            // The number is replaced below.
            continue;
        } else if before == Some("(") && index >= 3 && at(index - 2) == Some("binding") && at(index - 3) == Some("@") {
            binding += 1;
            (binding - 1).to_string()
        } else {
            // `a.name`, `@name`, `@builtin(name)`, and `name:` in a struct are no uses of what is declared outside.
            let is_builtin = before == Some("(") && index >= 2 && at(index - 2) == Some("builtin");
            let is_member = in_struct && at(index + 1) == Some(":");
            let is_other = matches!(before, Some("." | "@")) || is_builtin || is_member;
            if is_other || !declared.contains(word) {
                continue;
            }
            format!("{prefix}{word}")
        };
        result.push_str(&text[copied..range.start]);
        result.push_str(&replacement);
        copied = range.end;
    }
    result.push_str(&text[copied..]);
    Some(result)
}

/// The names that are declared outside of functions.
fn declared<'t>(at: &impl Fn(usize) -> Option<&'t str>, count: usize) -> HashSet<&'t str> {
    let mut names = HashSet::new();
    let mut depth = 0usize;
    for index in 0..count {
        match at(index).unwrap_or_default() {
            "{" | "(" => depth += 1,
            "}" | ")" => depth = depth.saturating_sub(1),
            "fn" | "struct" | "const" | "override" | "alias" if depth == 0 => names.extend(at(index + 1)),
            "var" if depth == 0 => {
                // `var<private> name`; nothing else stands between the angles.
                let close = (index + 1..count).find(|other| at(*other) == Some(">"));
                let name = if at(index + 1) == Some("<") { close.map(|close| close + 1) } else { Some(index + 1) };
                names.extend(name.and_then(at));
            }
            _ => {}
        }
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::user_shader::scan::scan;

    #[test]
    fn what_a_text_declares_gets_other_names_and_nothing_else_does() {
        let text = "//! effect a\nstruct Tint { tint: vec3f, tone: Tone, }\nstruct Tone { x: f32 }\n\
                    @group(2) @binding(0) var<uniform> tint: Tint;\n@group(2) @binding(3) var<uniform> y: f32;\n\
                    const tone = 2.0; // tone\n\
                    fn position(x: vec4f, at: vec2f) -> vec4f { let tone = x; return tone * tint.tone.x * y + x.y; }\n\
                    fn fs(@builtin(position) p: vec4f) -> vec4f { return position(p, p.xy); }";
        let renamed = renamed(text, &scan(text), "e1_", 4).expect("plain numbers");
        let expected = "//! effect a\nstruct e1_Tint { tint: vec3f, tone: e1_Tone, }\nstruct e1_Tone { x: f32 }\n\
                    @group(2) @binding(4) var<uniform> e1_tint: e1_Tint;\n@group(2) @binding(5) var<uniform> e1_y: f32;\n\
                    const e1_tone = 2.0; // tone\n\
                    fn e1_position(x: vec4f, at: vec2f) -> vec4f { let e1_tone = x; return e1_tone * e1_tint.tone.x * e1_y + x.y; }\n\
                    fn e1_fs(@builtin(position) p: vec4f) -> vec4f { return e1_position(p, p.xy); }";
        assert_eq!(renamed, expected);
        let odd = "const N = 1;\n@group(2) @binding(N) var<uniform> y: f32;";
        assert_eq!(super::renamed(odd, &scan(odd), "e_", 0), None);
    }
}
