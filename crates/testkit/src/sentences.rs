//! Sentences of pages and of descriptions: how they are told apart, and how long and how plain they are.

/// Words of a sentence, at most.
pub const WORDS_MAX: usize = 25;
/// Words whose full stop ends no sentence, in lower case.
const ABBREVIATIONS: [&str; 12] =
    ["e.g.", "i.e.", "etc.", "cf.", "vs.", "al.", "ca.", "approx.", "fig.", "no.", "pp.", "rec."];
/// What may stand before the first letter of a word, and behind its last sign.
const OPENING: [char; 7] = ['(', '[', '*', '_', '"', '\'', '«'];
const CLOSING: [char; 9] = [')', ']', '*', '_', '"', '\'', '»', '”', '’'];
/// What texts used to say, and the field's term.
const RIDDLES: [(&str, &str); 8] = [
    ("nobody says", "by default"),
    ("light comes through", "transmissive"),
    ("take turns in", "shadow maps are spread over samples"),
    ("chance decides", "stochastic"),
    ("is settled", "converged tiles"),
    ("gaps that maps miss", "contact shadows"),
    ("that of which", "two sentences"),
    ("by the shadow on it alone", "a shadow catcher"),
];

/// A sentence of a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sentence {
    /// The byte of the text at which it begins.
    pub begin: usize,
    /// It, in one line.
    pub text: String,
    /// The number of its words. Code counts as a word, signs alone do not.
    pub words: usize,
}

impl Sentence {
    /// What is wrong with it: its length, or a riddle in it.
    pub fn fault(&self) -> Option<String> {
        self.long().or_else(|| self.riddle())
    }

    /// Says so if it has too many words.
    pub fn long(&self) -> Option<String> {
        (self.words > WORDS_MAX).then(|| format!("{} words", self.words))
    }

    /// The riddle in it, with the field's term.
    pub fn riddle(&self) -> Option<String> {
        let (riddle, term) = RIDDLES.iter().find(|(riddle, _)| self.text.contains(riddle))?;
        Some(format!("«{riddle}» is «{term}»"))
    }
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

/// The sentences of a paragraph.
pub fn of_text(text: &str) -> Vec<Sentence> {
    let masked = masked(text);
    let mut sentences = Vec::new();
    let (mut begin, mut end, mut words) = (0, 0, 0);
    for part in masked.split_inclusive(char::is_whitespace) {
        let word = part.trim_end();
        words += usize::from(word.chars().any(char::is_alphanumeric));
        end += part.len();
        if ends_sentence(word) || end == masked.len() {
            sentences.push(Sentence { begin, text: text[begin..end].trim().replace('\n', " "), words });
            (begin, words) = (end, 0);
        }
    }
    sentences
}
