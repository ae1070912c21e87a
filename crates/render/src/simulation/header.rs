//! The header of a simulation's file: its first lines, which begin with `//!`.

use crate::diagnostic::Diagnostic;
use crate::user_shader::Source;
use crate::user_shader::rounds::{Rounds, STEPS_MAX, number};
use crate::user_shader::scan::Scan;
use crate::user_shader::source::{entries, is_identifier};
use manypass_scene::simulation::{CELLS_SIDE_MAX, RATE_HZ_MAX};
use std::ops::Range;

/// The words that a header may hold.
const WORDS: [&str; 8] = ["simulation", "start", "step", "shows", "cells", "rate", "edges", "reads"];
/// What a simulation may read beside its states.
const SURFACES: &str = "surfaces";
/// Width and height in cells where nobody says.
const CELLS: (u32, u32) = (256, 256);
/// Steps in a second where nobody says.
const RATE_HZ: f32 = 60.0;

/// What lies beyond the cells at the edge.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Edges {
    /// The cell at the edge, again and again.
    #[default]
    Clamp,
    /// The cells of the other side.
    Wrap,
}

/// A pass: a function that is drawn into a state or a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Pass {
    pub function: String,
    /// What it writes.
    pub target: String,
    pub rounds: Rounds,
    /// The bytes of its entry.
    pub place: Range<usize>,
}

/// What a header says.
#[derive(Debug)]
pub(super) struct Header {
    pub name: Option<String>,
    pub start: Vec<Pass>,
    pub step: Vec<Pass>,
    pub shows: Vec<Pass>,
    pub cells: (u32, u32),
    pub rate_hz: f32,
    pub edges: Edges,
    /// Whether it reads the surfaces that a camera sees.
    pub reads_surfaces: bool,
}

impl Header {
    /// Reads the header of `source`.
    ///
    /// # Errors
    /// A line that is not of the form, or not at the top; no steps, or nothing that is shown.
    pub fn parse(source: Source<'_>, scan: &Scan) -> Result<Self, Box<Diagnostic>> {
        let (start, step, shows) = (Vec::new(), Vec::new(), Vec::new());
        let mut header = Self {
            name: None,
            start,
            step,
            shows,
            cells: CELLS,
            rate_hz: RATE_HZ,
            edges: Edges::default(),
            reads_surfaces: false,
        };
        let mut said: Vec<String> = Vec::new();
        for (place, line) in source.header_lines(scan)? {
            header.line(source, (place, line), &mut said)?;
        }
        let missing =
            [("step", header.step.is_empty(), "FUNCTION -> STATE"), ("shows", header.shows.is_empty(), "NAME")];
        if let Some((word, _, form)) = missing.into_iter().find(|(_, is_missing, _)| *is_missing) {
            let fault = source.fault(0..0, format!("the header of a simulation has a line `//! {word}: {form}, …`"));
            return Err(Box::new(fault.note("docs/simulations.md has the form of the file")));
        }
        Ok(header)
    }

    /// One line, which begins at the byte `start`.
    fn line(
        &mut self,
        source: Source<'_>,
        (start, line): (usize, &str),
        said: &mut Vec<String>,
    ) -> Result<(), Box<Diagnostic>> {
        let length = line.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(line.len());
        let (word, rest) = line.split_at(length);
        let here = start..start + word.len().max(1);
        if !WORDS.contains(&word) {
            let message =
                format!("`{line}` begins with no word that the header of a simulation has: {}", WORDS.join(", "));
            return Err(Box::new(source.fault(here, message).note("a remark begins with `//` alone")));
        }
        if said.iter().any(|known| known == word) {
            return Err(source.fault(here, format!("`{word}` stands twice in the header")));
        }
        said.push(word.into());
        let rest = rest.strip_prefix(if word == "simulation" { " " } else { ":" }).unwrap_or_default();
        let text = rest.trim();
        let place = start + line.len() - rest.trim_start().len();
        let range = place..place + text.len().max(1);
        let wrong = |form: &str| Err(source.fault(here.clone(), format!("write `//! {form}`")));
        match word {
            "simulation" => {
                if !crate::user_shader::source::is_name(text) {
                    return wrong("simulation NAME");
                }
                self.name = Some(text.into());
            }
            "cells" => {
                let sides = text.split_once('x').and_then(|(width, height)| Some((number(width)?, number(height)?)));
                let sides = sides.filter(|(width, height)| (*width).max(*height) <= CELLS_SIDE_MAX);
                let Some(sides) = sides else { return wrong("cells: 256x256") };
                self.cells = sides;
            }
            "rate" => {
                let rate = text.parse().ok().filter(|rate: &f32| *rate > 0.0 && *rate <= RATE_HZ_MAX);
                let Some(rate_hz) = rate else {
                    return wrong(&format!("rate: 60`, at most `{RATE_HZ_MAX}"));
                };
                self.rate_hz = rate_hz;
            }
            "edges" => match text {
                "clamp" => self.edges = Edges::Clamp,
                "wrap" => self.edges = Edges::Wrap,
                _ => return wrong("edges: clamp`, or `//! edges: wrap"),
            },
            "reads" if text == SURFACES => self.reads_surfaces = true,
            "reads" => return wrong("reads: surfaces"),
            _ if text.is_empty() => return wrong(&format!("{word}: FUNCTION -> STATE, …")),
            "shows" => {
                for (entry, place) in entries(text, range.start) {
                    if !is_identifier(entry) {
                        return Err(
                            source.fault(place, format!("`{entry}` is not the name of a picture and its function"))
                        );
                    }
                    let (function, rounds) = (entry.to_owned(), Rounds::Count(1));
                    self.shows.push(Pass { target: function.clone(), function, rounds, place });
                }
            }
            _ => {
                let passes: Vec<Pass> = entries(text, range.start)
                    .map(|(entry, place)| pass(source, entry, place))
                    .collect::<Result<_, _>>()?;
                if passes.len() > STEPS_MAX {
                    return Err(source.fault(range, format!("there are at most {STEPS_MAX} passes")));
                }
                *(if word == "start" { &mut self.start } else { &mut self.step }) = passes;
            }
        }
        Ok(())
    }
}

fn pass(source: Source<'_>, entry: &str, place: Range<usize>) -> Result<Pass, Box<Diagnostic>> {
    let malformed = |message: String| {
        let note = "a pass is `FUNCTION -> STATE x 3`, with spaces between: its state, and the number of rounds, which may be left \
                    out";
        Box::new(source.fault(place.clone(), message).note(note))
    };
    let mut words = entry.split_whitespace();
    let function = words.next().filter(|word| is_identifier(word));
    let function = function.ok_or_else(|| malformed(format!("`{entry}` begins with no name of a function")))?;
    let is_arrow = words.next() == Some("->");
    let target = words.next().filter(|word| is_arrow && is_identifier(word));
    let target =
        target.ok_or_else(|| malformed(format!("`{function}` is followed by `->` and the name of a state")))?;
    let rounds = match words.next() {
        None => Rounds::Count(1),
        Some("x") => words.next().and_then(Rounds::parse).ok_or_else(|| malformed(Rounds::expected()))?,
        Some(word) => return Err(malformed(format!("`{word}` is not understood"))),
    };
    match words.next() {
        Some(word) => Err(malformed(format!("`{word}` is not understood"))),
        None => Ok(Pass { function: function.into(), target: target.into(), rounds, place }),
    }
}
