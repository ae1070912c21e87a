//! The sentences of the pages: short enough to be read once, in the field's terms. Code, tables, headings and what is
//! generated are left out.

use manypass_testkit::pages::{self, prose};

/// Words of a sentence, at most.
const WORDS_MAX: usize = 25;
/// Words whose full stop ends no sentence, in lower case.
const ABBREVIATIONS: [&str; 12] =
    ["e.g.", "i.e.", "etc.", "cf.", "vs.", "al.", "ca.", "approx.", "fig.", "no.", "pp.", "rec."];
/// What may stand before the first letter of a word, and behind its last sign.
const OPENING: [char; 7] = ['(', '[', '*', '_', '"', '\'', '«'];
const CLOSING: [char; 9] = [')', ']', '*', '_', '"', '\'', '»', '”', '’'];
/// What the pages used to say, and the field's term.
const RIDDLES: [(&str, &str); 6] = [
    ("nobody says", "by default"),
    ("light comes through", "transmissive"),
    ("take turns in", "shadow maps are spread over samples"),
    ("chance decides", "stochastic"),
    ("is settled", "converged tiles"),
    ("gaps that maps miss", "contact shadows"),
];

/// A sentence of a page.
#[derive(Debug, PartialEq, Eq)]
struct Sentence {
    /// The line on which it begins, from 1.
    line: usize,
    text: String,
    words: usize,
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

/// The same text, byte by byte, in which code and where links lead have neither spaces nor full stops.
fn masked(text: &str) -> String {
    let (mut is_code, mut is_target, mut before) = (false, false, ' ');
    let mask = |letter: char| {
        match letter {
            '`' if !is_target => is_code = !is_code,
            '(' if before == ']' && !is_code => is_target = true,
            ')' if is_target => is_target = false,
            _ => {}
        }
        before = letter;
        let is_sign = letter.is_ascii_whitespace() || ['.', '!', '?'].contains(&letter);
        if is_sign && (is_code || is_target) { '-' } else { letter }
    };
    text.chars().map(mask).collect()
}

fn ends_sentence(word: &str) -> bool {
    let word = word.trim_end_matches(CLOSING).trim_start_matches(OPENING);
    // As of a name: `A. Ramires`.
    let is_initial = word.len() == 2 && word.starts_with(|letter: char| letter.is_ascii_uppercase());
    word.ends_with(['.', '!', '?']) && !is_initial && !ABBREVIATIONS.contains(&word.to_lowercase().as_str())
}

/// The sentences of a page. Code counts as a word, signs alone do not.
fn sentences(page: &str) -> Vec<Sentence> {
    let mut sentences = Vec::new();
    for (first, text) in blocks(page) {
        let masked = masked(&text);
        let (mut begin, mut end, mut words) = (0, 0, 0);
        for part in masked.split_inclusive(char::is_whitespace) {
            let word = part.trim_end();
            words += usize::from(word.chars().any(char::is_alphanumeric));
            end += part.len();
            if ends_sentence(word) || end == masked.len() {
                let line = first + text[..begin].matches('\n').count();
                sentences.push(Sentence { line, text: text[begin..end].trim().replace('\n', " "), words });
                (begin, words) = (end, 0);
            }
        }
    }
    sentences
}

/// What `fault` finds in the sentences of all pages, with their places, and how many sentences there are.
fn faults(fault: impl Fn(&Sentence) -> Option<String>) -> (Vec<String>, usize) {
    let (mut found, mut count) = (Vec::new(), 0);
    for (page, text) in pages::pages() {
        for sentence in sentences(&text) {
            count += 1;
            let place = |fault: String| format!("{page}:{}: {fault}: {}", sentence.line, sentence.text);
            found.extend(fault(&sentence).map(place));
        }
    }
    (found, count)
}

#[test]
fn sentences_are_short() {
    let is_long = |sentence: &Sentence| sentence.words > WORDS_MAX;
    let (found, count) = faults(|sentence| is_long(sentence).then(|| format!("{} words", sentence.words)));
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
    let riddle = |sentence: &Sentence| RIDDLES.iter().find(|(riddle, _)| sentence.text.contains(riddle));
    let (found, _) = faults(|sentence| riddle(sentence).map(|(riddle, term)| format!("«{riddle}» is «{term}»")));
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn sentences_are_found() {
    let page = "# A heading\n\nOne `a. b c`, two. [Three\nfour](a b.md#c): e.g. 0.5 m!\n- Five (A. Ramires), six =\n  \
                seven.\n1. Eight et al. 9\n\n    an indented block\n\n| a | table |\n```sh\ncode\n```\nTen.\n\
                <!-- x: written by `y` -->\nMade by code.\n<!-- end of x -->\nEleven? «Twelve.»\n";
    let found = sentences(page);
    let found: Vec<(usize, &str, usize)> =
        found.iter().map(|sentence| (sentence.line, sentence.text.as_str(), sentence.words)).collect();
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
