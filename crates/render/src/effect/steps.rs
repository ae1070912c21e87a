//! The passes of an effect, as the line `//! passes:` of its header has them.

use crate::diagnostic::Diagnostic;
use crate::user_shader::Source;
use crate::user_shader::rounds::{Rounds, STEPS_MAX, number};
use crate::user_shader::source::is_identifier;
use std::collections::BTreeSet;
use std::ops::Range;

/// A pass of an effect.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Step {
    /// Its `@fragment` function.
    pub function: String,
    /// What it is called within the effect: the function, without `fs_` where no other is called so.
    pub name: String,
    /// The texture that it writes; none for the effect's result.
    pub texture: Option<String>,
    /// The sides of the texture are those of the picture divided by this, rounded up.
    pub divisor: u32,
    /// How often it is drawn.
    pub rounds: Rounds,
    /// The bytes of its entry.
    pub place: Range<usize>,
}

impl Step {
    /// The only pass of an effect that has but one function.
    pub fn only(function: String) -> Self {
        Self {
            name: short(&function).into(),
            function,
            texture: None,
            divisor: 1,
            rounds: Rounds::Count(1),
            place: 0..0,
        }
    }
}

fn short(function: &str) -> &str {
    function.strip_prefix("fs_").filter(|rest| !rest.is_empty()).unwrap_or(function)
}

/// Reads the entries of the list, each with its bytes.
///
/// # Errors
/// One that is not of the form, or a list whose last pass is not its only one that writes the result.
pub(super) fn parse<'t>(
    source: Source<'t>,
    entries: impl Iterator<Item = (&'t str, Range<usize>)>,
) -> Result<Vec<Step>, Box<Diagnostic>> {
    let mut steps = entries.map(|(entry, place)| step(source, entry, place)).collect::<Result<Vec<_>, _>>()?;
    let functions: Vec<String> = steps.iter().map(|step| step.function.clone()).collect();
    for step in &mut steps {
        if functions.iter().any(|other| *other != step.function && short(other) == step.name) {
            step.name.clone_from(&step.function);
        }
    }
    if let Some(beyond) = steps.get(STEPS_MAX) {
        return Err(source.fault(beyond.place.clone(), format!("an effect has at most {STEPS_MAX} passes")));
    }
    let Some((last, others)) = steps.split_last() else { return Ok(steps) };
    if let Some(step) = others.iter().find(|step| step.texture.is_none()) {
        let message = format!("only the last pass makes the result; `{}` writes a texture", step.function);
        let note = format!("name it: `{} -> TEXTURE`; later passes read it by that name", step.function);
        return Err(Box::new(source.fault(step.place.clone(), message).note(note)));
    }
    let is_result = last.texture.is_none() && last.divisor == 1 && last.rounds == Rounds::Count(1);
    if !is_result {
        let message = format!("the last pass makes the result: it is `{}` alone", last.function);
        let note = "it writes no texture of its own, and is drawn once at the full size";
        return Err(Box::new(source.fault(last.place.clone(), message).note(note)));
    }
    Ok(steps)
}

fn step(source: Source<'_>, entry: &str, place: Range<usize>) -> Result<Step, Box<Diagnostic>> {
    let malformed = |message: String| {
        let note = "a pass is `FUNCTION -> TEXTURE 1/2 x 3`, with spaces between: its texture, the size, \
                    and the number of rounds; all but the function may be left out";
        Box::new(source.fault(place.clone(), message).note(note))
    };
    let mut words = entry.split_whitespace().peekable();
    let function = words.next().filter(|word| is_identifier(word));
    let function = function.ok_or_else(|| malformed(format!("`{entry}` begins with no name of a function")))?;
    let mut step = Step { place: place.clone(), ..Step::only(function.into()) };
    if words.next_if_eq(&"->").is_some() {
        let texture = words.next().filter(|word| is_identifier(word));
        let texture = texture.ok_or_else(|| malformed("`->` is followed by the name of a texture".into()))?;
        step.texture = Some(texture.into());
    }
    if let Some(size) = words.next_if(|word| word.starts_with("1/")) {
        let divisor = size.strip_prefix("1/").and_then(number);
        let divisor = divisor.filter(|divisor| (1..=64).contains(divisor));
        step.divisor = divisor.ok_or_else(|| malformed(format!("`{size}` is not a size: 1/1 to 1/64 of each side")))?;
    }
    if words.next_if_eq(&"x").is_some() {
        step.rounds = words.next().and_then(Rounds::parse).ok_or_else(|| malformed(Rounds::expected()))?;
    }
    match words.next() {
        Some(word) => Err(malformed(format!("`{word}` is not understood"))),
        None => Ok(step),
    }
}

/// Checks that each pass reads what is there, and that all that is written is read; with each pass the names of the
/// textures that it reads.
///
/// # Errors
/// A texture that is read before it is written, or never; a pass whose rounds know nothing of each other.
pub(super) fn check(source: Source<'_>, steps: &[(&Step, Vec<&str>)]) -> Result<(), Box<Diagnostic>> {
    let fault = |step: &Step, message: String| Err(source.fault(step.place.clone(), message));
    let is_own = |name: &str| steps.iter().any(|(step, _)| step.texture.as_deref() == Some(name));
    let mut written: BTreeSet<&str> = BTreeSet::new();
    for (at, (step, read)) in steps.iter().enumerate() {
        if let Some(early) = read.iter().find(|texture| is_own(texture) && !written.contains(*texture)) {
            return fault(step, format!("`{}` reads `{early}`, which no pass before it writes", step.function));
        }
        let Some(texture) = step.texture.as_deref() else { continue };
        written.insert(texture);
        if step.rounds != Rounds::Count(1) && !read.contains(&texture) {
            let message =
                format!("`{}` does not read `{texture}`: of its rounds only the last would count", step.function);
            return fault(step, message);
        }
        // Until another takes its place, which may itself look at it.
        let next = steps.iter().skip(at + 1).position(|(later, _)| later.texture.as_deref() == Some(texture));
        let mut until = steps.iter().skip(at + 1).take(next.map_or(usize::MAX, |next| next + 1));
        if !until.any(|(_, read)| read.contains(&texture)) {
            return fault(step, format!("no later pass reads `{texture}`, which `{}` writes", step.function));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(list: &str) -> Result<Vec<Step>, String> {
        let source = Source { file: "a.wgsl", text: list };
        let entries = list.split(',').map(|entry| (entry.trim(), 0..1));
        parse(source, entries).map_err(|error| error.to_string())
    }

    #[test]
    fn a_pass_is_read_to_its_last_word() {
        let steps = parsed("fs_a -> wide 1/4 x 3, b -> wide x rounds, fs_c").expect("a good list");
        let step = |function: &str, texture: Option<&str>, divisor, rounds| Step {
            texture: texture.map(str::to_owned),
            divisor,
            rounds,
            place: 0..1,
            ..Step::only(function.into())
        };
        assert_eq!(steps[0], step("fs_a", Some("wide"), 4, Rounds::Count(3)));
        assert_eq!(steps[1], step("b", Some("wide"), 1, Rounds::Setting("rounds".into())));
        assert_eq!(steps[2], step("fs_c", None, 1, Rounds::Count(1)));
        assert_eq!([&steps[0].name, &steps[1].name], ["a", "b"]);
        let names: Vec<String> =
            parsed("fs_a -> x, a -> x, fs_").expect("three").into_iter().map(|step| step.name).collect();
        assert_eq!(names, ["fs_a", "a", "fs_"]);
    }

    #[test]
    fn what_is_no_list_of_passes_is_refused() {
        for (list, expected) in [
            ("fs_a, fs_b", "only the last pass makes the result"),
            ("fs_a -> wide", "the last pass makes the result"),
            ("fs_a x 2", "the last pass makes the result"),
            ("fs_a 1/2", "the last pass makes the result"),
            ("2d -> wide, fs_b", "begins with no name"),
            ("fs_a ->, fs_b", "followed by the name of a texture"),
            ("fs_a -> wide 1/0, fs_b", "`1/0` is not a size"),
            ("fs_a -> wide 1/+2, fs_b", "`1/+2` is not a size"),
            ("fs_a -> wide 1/02, fs_b", "`1/02` is not a size"),
            ("fs_a -> wide x +3, fs_b", "followed by a number of rounds"),
            ("fs_a -> wide 1/65, fs_b", "`1/65` is not a size"),
            ("fs_a -> wide x, fs_b", "followed by a number of rounds"),
            ("fs_a -> wide x 0, fs_b", "followed by a number of rounds"),
            ("fs_a -> wide x 65, fs_b", "followed by a number of rounds"),
            ("fs_a -> wide twice, fs_b", "`twice` is not understood"),
            ("fs_a -> wide x 2 1/2, fs_b", "`1/2` is not understood"),
        ] {
            let error = parsed(list).expect_err(list);
            assert!(error.contains(expected), "{list}\n{error}\nshould say {expected}");
        }
        let many = vec!["fs_a -> wide"; STEPS_MAX].join(", ") + ", fs_b";
        assert!(parsed(&many).expect_err("many").contains("at most 64 passes"));
    }

    #[test]
    fn textures_are_written_before_they_are_read_and_read_after() {
        let checked = |list: &str, read: &[&[&str]]| {
            let steps = parsed(list).expect(list);
            let steps: Vec<_> = steps.iter().zip(read).map(|(step, read)| (step, read.to_vec())).collect();
            check(Source { file: "a.wgsl", text: list }, &steps).map_err(|error| error.to_string())
        };
        checked("a -> x, b -> x, c", &[&[], &["x"], &["x"]]).expect("ping-pong");
        checked("a -> x, b -> x x 4, c", &[&["radiance"], &["x"], &["x"]]).expect("rounds");
        let deaf = checked("a -> x x 2, b", &[&["radiance"], &["x"]]).expect_err("rounds that do not go on");
        assert!(deaf.contains("of its rounds only the last would count"), "{deaf}");
        let early = checked("a -> x, b", &[&["x"], &["x"]]).expect_err("early");
        assert!(early.contains("`a` reads `x`, which no pass before it writes"), "{early}");
        for (list, read) in [
            ("a -> x, b", &[&[][..], &[]][..]),
            ("a -> x, b -> x, c", &[&[], &[], &["x"]]),
            ("a -> x, b -> y, c", &[&[], &["x"], &["x"]]),
        ] {
            assert!(checked(list, read).expect_err(list).contains("no later pass reads"), "{list}");
        }
    }
}
