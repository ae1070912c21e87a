//! The sentences of the pages: short enough to be read once, in the field's terms. Code, tables, headings and what is
//! generated are left out.

use manypass_testkit::pages::{self, prose};
use manypass_testkit::sentences::{self, Sentence, WORDS_MAX};

/// A sentence of a page.
#[derive(Debug)]
struct PlacedSentence {
    /// The line on which it begins, from 1.
    line: usize,
    sentence: Sentence,
}

/// The text of an item of a list, if the line begins one.
fn item(line: &str) -> Option<&str> {
    let behind_number = line.trim_start_matches(|letter: char| letter.is_ascii_digit());
    match behind_number.len() < line.len() {
        true => behind_number.strip_prefix(". "),
        false => ["- ", "* ", "+ "].iter().find_map(|mark| line.strip_prefix(mark)),
    }
}

/// Paragraphs and items of lists: the number of the first line, and the lines without what begins them.
fn blocks(text: &str) -> Vec<(usize, String)> {
    let mut blocks: Vec<(usize, String)> = Vec::new();
    let (mut last, mut is_generated) = (None, false);
    for (number, whole) in prose(text) {
        let line = whole.trim();
        if line.starts_with("<!--") {
            is_generated = line.contains(": written by ");
        }
        if is_generated || line.is_empty() || ["<!--", "#", "|"].iter().any(|mark| line.starts_with(mark)) {
            continue;
        }
        let goes_on = last.is_some_and(|last| last + 1 == number);
        if !goes_on && whole.starts_with("    ") {
            continue;
        }
        last = Some(number);
        match (blocks.last_mut().filter(|_| goes_on), item(line)) {
            (Some((_, block)), None) => {
                block.push('\n');
                block.push_str(line);
            }
            (_, item) => blocks.push((number, item.unwrap_or(line).to_owned())),
        }
    }
    blocks
}

/// The sentences of a page.
fn sentences(page: &str) -> Vec<PlacedSentence> {
    let placed = |(first, text): (usize, String)| {
        let place = |sentence: Sentence| PlacedSentence {
            line: first + text[..sentence.begin].matches('\n').count(),
            sentence,
        };
        sentences::of_text(&text).into_iter().map(place).collect::<Vec<_>>()
    };
    blocks(page).into_iter().flat_map(placed).collect()
}

/// What `fault` finds in the sentences of all pages, with their places, and how many sentences there are.
fn faults(fault: impl Fn(&Sentence) -> Option<String>) -> (Vec<String>, usize) {
    let (mut found, mut count) = (Vec::new(), 0);
    for (page, text) in pages::pages() {
        for PlacedSentence { line, sentence } in sentences(&text) {
            count += 1;
            let place = |fault: String| format!("{page}:{line}: {fault}: {}", sentence.text);
            found.extend(fault(&sentence).map(place));
        }
    }
    (found, count)
}

#[test]
fn sentences_are_short() {
    let (found, count) = faults(Sentence::long);
    assert!(count > 3000, "{count} sentences");
    assert!(
        found.is_empty(),
        "{} sentences have more than {WORDS_MAX} words; make two of each:\n{}",
        found.len(),
        found.join("\n")
    );
}

#[test]
fn sentences_have_the_terms_of_the_field() {
    let (found, _) = faults(Sentence::riddle);
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn sentences_are_found() {
    let page = "# A heading\n\nOne `a. b c`, two. [Three\nfour](a b.md#c): e.g. 0.5 m!\n- Five (A. Ramires), six =\n  \
                seven.\n1. Eight et al. 9\n\n    an indented block\n\n| a | table |\n```sh\ncode\n```\nTen.\n\
                <!-- x: written by `y` -->\nMade by code.\n<!-- end of x -->\nEleven? «Twelve.»\n";
    let found = sentences(page);
    let found: Vec<(usize, &str, usize)> =
        found.iter().map(|found| (found.line, found.sentence.text.as_str(), found.sentence.words)).collect();
    let expected = [
        (3, "One `a. b c`, two.", 3),
        (3, "[Three four](a b.md#c): e.g. 0.5 m!", 5),
        (5, "Five (A. Ramires), six = seven.", 5),
        (7, "Eight et al. 9", 4),
        (15, "Ten.", 1),
        (19, "Eleven?", 1),
        (19, "«Twelve.»", 1),
    ];
    assert_eq!(found, expected);
}
