//! Parsing a shader of the user's, with errors at places of its own text.

use crate::diagnostic::Diagnostic;
use naga::front::wgsl;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use std::error::Error;
use std::ops::Range;

/// A fault as the compiler tells it: the places in bytes of the composed text, with a word about each.
struct Fault {
    message: String,
    labels: Vec<(Range<usize>, String)>,
    notes: Vec<String>,
}

/// A shader's own text with what it finds declared after it, so that its lines keep their numbers.
pub(crate) fn composed(own: &str, declared: &str) -> String {
    format!("{own}\n{declared}")
}

/// Parses and validates `own` with what it finds `declared`.
///
/// # Errors
/// It is not valid; the place is one of `own`.
pub(crate) fn parse(file: &str, own: &str, declared: &str) -> Result<(naga::Module, ModuleInfo), Box<Diagnostic>> {
    let source = composed(own, declared);
    let module = match wgsl::parse_str(&source) {
        Ok(module) => module,
        Err(error) => return Err(Box::new(located(file, own, parse_fault(&error)))),
    };
    let validated = Validator::new(ValidationFlags::all(), Capabilities::default()).validate(&module);
    let info = validated.map_err(|error| Box::new(located(file, own, validation_fault(&error))))?;
    Ok((module, info))
}

fn parse_fault(error: &wgsl::ParseError) -> Fault {
    let labels = error.labels().filter_map(|(span, label)| Some((span.to_range()?, label.to_owned())));
    Fault {
        message: error.message().into(),
        labels: labels.collect(),
        notes: error.notes().map(str::to_owned).collect(),
    }
}

/// The whole chain of causes: the first says only which function is wrong.
fn validation_fault(error: &naga::WithSpan<naga::valid::ValidationError>) -> Fault {
    let mut message = error.as_inner().to_string();
    let mut source = error.as_inner().source();
    while let Some(cause) = source {
        message = format!("{message}: {cause}");
        source = cause.source();
    }
    let label = |label: &String| if label.starts_with("naga::") { String::new() } else { without_handles(label) };
    let labels = error.spans().filter_map(|(span, text)| Some((span.to_range()?, label(text)))).collect();
    Fault { message: without_handles(&message), labels, notes: Vec::new() }
}

/// Without the compiler's own numbers of things, such as `[3]` and `Some([3])`, which say nothing outside of it.
fn without_handles(text: &str) -> String {
    let is_handle = |word: &str| {
        let inner = word.strip_prefix("Some(").and_then(|rest| rest.strip_suffix(')')).unwrap_or(word);
        let number = inner.strip_prefix('[').and_then(|rest| rest.strip_suffix(']'));
        number.is_some_and(|number| !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()))
    };
    let mut words: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        let (name, end) = word.split_at(word.trim_end_matches([':', ',', '.']).len());
        match words.last_mut() {
            Some(last) if is_handle(name) => last.push_str(end),
            _ => words.push(word.into()),
        }
    }
    words.join(" ")
}

fn located(file: &str, own: &str, fault: Fault) -> Diagnostic {
    let (inside, outside): (Vec<_>, Vec<_>) = fault.labels.iter().partition(|(range, _)| range.start < own.len());
    let Some((range, label)) = inside.first() else {
        return located_at_end(file, own, &fault);
    };
    let mut diagnostic = Diagnostic::new(file, own, range.clone(), &fault.message).label(label);
    for (range, label) in &inside[1..] {
        let place = Diagnostic::new(file, own, range.clone(), "");
        diagnostic = diagnostic.note(format!("{label} ({}:{}:{})", place.file, place.line, place.column));
    }
    for (_, label) in outside.iter().filter(|(_, label)| !label.is_empty()) {
        diagnostic = diagnostic.note(format!("{label} (in what is declared for it)"));
    }
    fault.notes.iter().fold(diagnostic, |diagnostic, note| diagnostic.note(note))
}

/// The compiler found nothing wrong before the end of `own`. If that is cut off it says so by itself; else the fault shows
/// in what is declared for it.
fn located_at_end(file: &str, own: &str, fault: &Fault) -> Diagnostic {
    let end = own.trim_end().len();
    if let Err(error) = wgsl::parse_str(own) {
        let alone = parse_fault(&error);
        if alone.labels.first().is_some_and(|(range, _)| range.start >= end) {
            let message = alone.message.replace("found \"\"", "found the end of the file");
            return Diagnostic::new(file, own, end..end, message).label("the file ends here");
        }
    }
    let diagnostic = Diagnostic::new(file, own, end..end, &fault.message);
    if fault.labels.is_empty() {
        return diagnostic;
    }
    diagnostic
        .note("it shows in what every such file finds declared: a name of this file's may hide one that is used there")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(own: &str) -> String {
        parse("a.wgsl", own, crate::shader::compose::EFFECT_PRELUDE).map(drop).expect_err(own).to_string()
    }

    const MAIN: &str = "@fragment fn fs(@builtin(position) p: vec4f) -> @location(0) vec4f {";

    #[test]
    fn errors_have_places_of_the_own_text() {
        for (own, place) in [
            (format!("{MAIN}\n\n    return radianc_at(vec2i(p.xy)); }}"), "a.wgsl:3:12: error: "),
            (format!("// é\n/* ü */ {MAIN} return radianc_at(vec2i(p.xy)); }}"), "a.wgsl:2:85: error: "),
            (
                format!("{MAIN}\n    return vec3f(1.0);\n}}\n"),
                "a.wgsl:2:12: error: Entry point fs at Fragment is invalid: The `return` expression does not match the declared",
            ),
            (format!("{MAIN} return vec4f(1.0); }}\n\nfn unfinished() -> f32 {{ retur"), "a.wgsl:3:"),
            ("this is not WGSL".into(), "a.wgsl:1:1: error: "),
            ("\n\nvar<private> radiance: f32;\n".into(), "a.wgsl:3:14: error: "),
        ] {
            let error = error(&own);
            assert!(error.starts_with(place), "{own}\n{error}\nshould be at {place}");
        }
    }

    #[test]
    fn a_cut_off_text_is_reported_at_its_last_line() {
        let whole = format!("{MAIN}\n    let x = 1.0;\n    return vec4f(x, 1.0, 1.0, 1.0);\n}}\n");
        parse("a.wgsl", &whole, "").map(drop).expect("the whole is valid");
        let mut cut_count = 0;
        for cut in 1..whole.len() - 1 {
            let own = &whole[..cut];
            let Err(error) = parse("a.wgsl", own, "") else { continue };
            cut_count += 1;
            let lines = own.trim_end().lines().count();
            assert!(error.line >= 1 && error.line <= lines, "{own}\n{error}");
            assert!(error.line + 1 >= lines, "{own}\n{error}");
        }
        assert!(cut_count > 60);
        let cut = parse("a.wgsl", &whole[..whole.len() - 3], "").map(drop).expect_err("cut off").to_string();
        assert!(cut.starts_with("a.wgsl:3:36: error: ") && cut.contains("the file ends here"), "{cut}");
    }

    #[test]
    fn a_name_that_hides_one_of_the_prelude_is_at_the_end() {
        let error = error(&format!("fn clamp(x: f32) -> f32 {{ return x; }}\n{MAIN} return vec4f(clamp(1.0)); }}\n"));
        assert!(error.starts_with("a.wgsl:2:") && error.contains("may hide one"), "{error}");
    }
}
