//! The comments of a shader and what they stand above, which a parser of WGSL throws away.

use super::size::{CASES_MAX, switch_fault};
use super::source::Source;
use crate::diagnostic::Diagnostic;
use std::collections::HashMap;
use std::ops::Range;

/// A line comment.
#[derive(Clone, Debug)]
pub(crate) struct Comment {
    /// Its bytes, from the first slash to the end of the line.
    pub range: Range<usize>,
    /// Whether nothing but space stands before it on its line.
    pub is_alone: bool,
}

/// A word, or a single other character.
#[derive(Clone, Debug)]
struct Token {
    range: Range<usize>,
}

/// A declaration with a name: a member of a struct, or a variable.
#[derive(Clone, Debug)]
pub(crate) struct Declaration {
    /// The bytes of its name.
    pub name: Range<usize>,
    /// The bytes of its type.
    pub ty: Range<usize>,
    /// The comments above it, each on a line of its own.
    pub comments: Vec<Range<usize>>,
}

/// The comments of a shader, and its declarations by their names.
#[derive(Debug, Default)]
pub(crate) struct Scan {
    /// All line comments.
    pub comments: Vec<Comment>,
    /// Where the first declaration begins; the text's end if there is none.
    pub first_token: usize,
    /// Members, by the names of the struct and of the member.
    pub members: HashMap<(String, String), Declaration>,
    /// Variables of the module.
    pub variables: HashMap<String, Declaration>,
    /// The bytes of the names of functions.
    pub functions: HashMap<String, Range<usize>>,
    /// Where an expression becomes longer than the compiler's recursion can bear, or the whole too long for it.
    overlong: Option<Range<usize>>,
    /// The word that begins a `switch` of too many cases.
    large_switch: Option<Range<usize>>,
}

impl Scan {
    /// Whether the text is short enough to be compiled.
    ///
    /// # Errors
    /// Where it is not.
    pub(crate) fn check_length(&self, source: Source<'_>) -> Result<(), Box<Diagnostic>> {
        if let Some(place) = &self.large_switch {
            return Err(switch_fault(source, place.clone()));
        }
        match &self.overlong {
            Some(place) => Err(source.fault(place.clone(), "the shader is too long or nested too deeply from here on")),
            None => Ok(()),
        }
    }
}

/// So many operators in one statement are compiled on a thread's usual stack of 2 MiB; the compiler recurses for each.
const OPERATORS_MAX: usize = 4000;
/// And so many declarations, each of which may need the next one, and branches in one chain of `else if`.
const BLOCKS_MAX: usize = 1000;
/// And so many words and signs: the time of the compiler grows as the square of the expressions of a function, to 1.5 s
/// for as many.
const TOKENS_MAX: usize = 60_000;

/// Scans a text, which need not be valid.
pub(crate) fn scan(text: &str) -> Scan {
    let mut scan = Scan::default();
    let tokens = tokens(text, &mut scan.comments);
    scan.overlong = overlong(text, &tokens).or_else(|| tokens.get(TOKENS_MAX).map(|token| token.range.clone()));
    scan.large_switch = large_switch(text, &tokens);
    scan.first_token = tokens.first().map_or(text.len(), |token| token.range.start);
    Walk { text, tokens: &tokens, at: 0, scan }.run()
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// The bytes of all words and single other characters outside of comments.
pub(crate) fn words(text: &str) -> Vec<Range<usize>> {
    tokens(text, &mut Vec::new()).into_iter().map(|token| token.range).collect()
}

/// Splits a text into tokens; line comments go into `comments`, and block comments, which nest, are left out.
fn tokens(text: &str, comments: &mut Vec<Comment>) -> Vec<Token> {
    let mut tokens = Vec::new();
    let mut at = 0;
    while let Some(c) = text[at..].chars().next() {
        let rest = &text[at..];
        let length = if c.is_whitespace() {
            c.len_utf8()
        } else if rest.starts_with("//") {
            let length = rest.find('\n').unwrap_or(rest.len());
            let line_start = text[..at].rfind('\n').map_or(0, |newline| newline + 1);
            comments.push(Comment { range: at..at + length, is_alone: text[line_start..at].trim().is_empty() });
            length
        } else if rest.starts_with("/*") {
            block_comment_length(rest)
        } else {
            let length = if is_word(c) { rest.find(|c| !is_word(c)).unwrap_or(rest.len()) } else { c.len_utf8() };
            tokens.push(Token { range: at..at + length });
            length
        };
        at += length;
    }
    tokens
}

/// Where there are more than [`OPERATORS_MAX`] operators without an end of a statement, or more than [`BLOCKS_MAX`] branches
/// or declarations in all.
fn overlong(text: &str, tokens: &[Token]) -> Option<Range<usize>> {
    let (mut operators, mut branches, mut declarations) = (0, 0, 0);
    for (token, next) in tokens.iter().zip(tokens.iter().skip(1).chain([&Token { range: 0..0 }])) {
        let word = &text[token.range.clone()];
        match word {
            ";" | "{" | "}" => operators = 0,
            "else" => branches += 1,
            "fn" | "struct" | "const" | "alias" | "override" => declarations += 1,
            // The point of a number is none.
            "." => operators += usize::from(!text[next.range.clone()].starts_with(|c: char| c.is_ascii_digit())),
            "+" | "-" | "*" | "/" | "%" | "&" | "|" | "^" | "<" | ">" | "=" | "!" | "~" | "[" | "(" => operators += 1,
            _ => {}
        }
        if operators > OPERATORS_MAX || branches > BLOCKS_MAX || declarations > BLOCKS_MAX {
            return Some(token.range.clone());
        }
    }
    None
}

/// The word that begins the first `switch` in which more than [`CASES_MAX`] cases stand.
fn large_switch(text: &str, tokens: &[Token]) -> Option<Range<usize>> {
    // Of those that are open: the word, the depth of braces around it, and its cases so far.
    let mut open: Vec<(&Token, usize, usize)> = Vec::new();
    let mut depth = 0usize;
    for token in tokens {
        match &text[token.range.clone()] {
            "{" => depth += 1,
            "}" => {
                depth = depth.saturating_sub(1);
                while open.last().is_some_and(|(_, around, _)| *around >= depth) {
                    open.pop();
                }
            }
            "switch" => open.push((token, depth, 0)),
            "case" => {
                if let Some((word, _, cases)) = open.last_mut() {
                    *cases += 1;
                    if *cases > CASES_MAX {
                        return Some(word.range.clone());
                    }
                }
            }
            _ => {}
        }
    }
    None
}

fn block_comment_length(text: &str) -> usize {
    let mut depth = 0usize;
    let mut at = 0;
    while let Some(c) = text[at..].chars().next() {
        if text[at..].starts_with("/*") {
            depth += 1;
            at += 2;
        } else if text[at..].starts_with("*/") {
            depth = depth.saturating_sub(1);
            at += 2;
            if depth == 0 {
                break;
            }
        } else {
            at += c.len_utf8();
        }
    }
    at
}

/// Goes through the declarations of a module.
struct Walk<'t> {
    text: &'t str,
    tokens: &'t [Token],
    at: usize,
    scan: Scan,
}

impl<'t> Walk<'t> {
    fn run(mut self) -> Scan {
        // The token after which the present declaration begins.
        let mut before = None;
        let mut depth = 0usize;
        while let Some(word) = self.peek() {
            let here = self.at;
            self.at += 1;
            match word {
                "{" | "(" => depth += 1,
                "}" | ")" => depth = depth.saturating_sub(1),
                "struct" if depth == 0 => {
                    self.members();
                    before = self.at.checked_sub(1);
                }
                "fn" if depth == 0 => {
                    if let Some(name) = self.tokens.get(self.at) {
                        self.scan.functions.entry(self.text[name.range.clone()].into()).or_insert(name.range.clone());
                    }
                }
                "var" if depth == 0 => self.variable(before),
                _ => {}
            }
            if depth == 0 && matches!(word, ";" | "}") {
                before = Some(here);
            }
        }
        self.scan
    }

    fn peek(&self) -> Option<&'t str> {
        self.tokens.get(self.at).map(|token| &self.text[token.range.clone()])
    }

    /// The comments between a token and the later one at `to` that have lines of their own.
    fn comments_between(&self, from: Option<usize>, to: usize) -> Vec<Range<usize>> {
        let start = from.and_then(|from| self.tokens.get(from)).map_or(0, |token| token.range.end);
        let end = self.tokens[to].range.start;
        let between =
            self.scan.comments.iter().filter(|comment| comment.range.start >= start && comment.range.end <= end);
        between.filter(|comment| comment.is_alone).map(|comment| comment.range.clone()).collect()
    }

    /// `NAME { members }`, with the word `struct` behind.
    fn members(&mut self) {
        let Some(name) = self.peek().map(str::to_owned) else { return };
        self.at += 1;
        if self.peek() != Some("{") {
            return;
        }
        let mut before = self.at;
        self.at += 1;
        while self.peek().is_some_and(|word| word != "}") {
            self.attributes();
            let member = self.at;
            self.at += 1;
            if self.peek() == Some(":") {
                self.at += 1;
                let ty = self.until(&[",", "}"]);
                let comments = self.comments_between(Some(before), member);
                let declared = Declaration { name: self.tokens[member].range.clone(), ty, comments };
                let key = (name.clone(), self.text[declared.name.clone()].to_owned());
                self.scan.members.insert(key, declared);
            }
            if self.peek() == Some(",") {
                before = self.at;
                self.at += 1;
            }
        }
        // The loop of declarations has not seen the opening brace.
        self.at += 1;
    }

    /// `<uniform> NAME: TYPE`, with the word `var` behind.
    fn variable(&mut self, before: Option<usize>) {
        if self.peek() == Some("<") {
            self.until(&[]);
        }
        let name = self.at;
        self.at += 1;
        if self.peek() != Some(":") {
            return;
        }
        self.at += 1;
        let comments = self.comments_between(before, name);
        let ty = self.until(&[";", "="]);
        let declared = Declaration { name: self.tokens[name].range.clone(), ty, comments };
        self.scan.variables.insert(self.text[declared.name.clone()].into(), declared);
    }

    /// Passes over `@name` and `@name(…)`.
    fn attributes(&mut self) {
        while self.peek() == Some("@") {
            self.at += 2;
            if self.peek() == Some("(") {
                self.until(&[]);
            }
        }
    }

    /// Goes to the first of `ends` outside brackets, or behind a closed bracket if there are no `ends`; gives the bytes
    /// that were passed over.
    fn until(&mut self, ends: &[&str]) -> Range<usize> {
        let start = self.tokens.get(self.at).map_or(self.text.len(), |token| token.range.start);
        let mut end = start;
        let mut depth = 0usize;
        while let Some(word) = self.peek() {
            if depth == 0 && ends.contains(&word) {
                break;
            }
            match word {
                "(" | "<" | "[" => depth += 1,
                ")" | ">" | "]" => depth = depth.saturating_sub(1),
                _ => {}
            }
            end = self.tokens[self.at].range.end;
            self.at += 1;
            if depth == 0 && ends.is_empty() {
                break;
            }
        }
        start..end
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_belong_to_what_they_stand_above() {
        let text = "//! effect x\n/* struct No { // a\n /* nested */ } */\nstruct Style { // of the struct\n    /// one\n    \
                    // = 1\n    a: f32, // beside a\n    // two\n    @align(16) @size(32) b: array<vec2<f32>, 4>,\n}\n\
                    fn f(x: f32) { var y: f32 = 1.0; }\n/// three\n@group(2) @binding(0)\n// four\n\
                    var<uniform> style: Style;\nvar<private> z: f32 = 2.0;";
        let scan = scan(text);
        let words = |declared: &Declaration| -> Vec<String> {
            declared.comments.iter().map(|range| text[range.clone()].to_owned()).collect()
        };
        let member = |name: &str| &scan.members[&("Style".to_owned(), name.to_owned())];
        assert_eq!(words(member("a")), ["/// one", "// = 1"]);
        assert_eq!(words(member("b")), ["// two"]);
        assert_eq!(&text[member("b").ty.clone()], "array<vec2<f32>, 4>");
        assert_eq!(words(&scan.variables["style"]), ["/// three", "// four"]);
        assert_eq!(&text[scan.variables["z"].ty.clone()], "f32");
        let after_struct = "struct S {\n// in it\na: f32 }\n// above\nvar<uniform> s: S;";
        assert_eq!(super::scan(after_struct).variables["s"].comments.len(), 1);
        assert_eq!(scan.members.len(), 2);
        assert!(!scan.variables.contains_key("y") && scan.functions.contains_key("f"));
        assert!(text[scan.first_token..].starts_with("struct Style"));
    }

    #[test]
    fn cases_are_counted_in_their_switch_and_long_texts_are_known() {
        let cases = |count: usize| "case 1: {}".repeat(count);
        let nested =
            format!("switch a {{ {} case 2: {{ switch b {{ {} }} }} {} }}", cases(300), cases(800), cases(600));
        assert_eq!(scan(&nested).large_switch, None);
        let large = format!("{nested} switch c {{ {} }}", cases(CASES_MAX + 1));
        assert_eq!(scan(&large).large_switch.map(|place| large[place.start..].starts_with("switch c")), Some(true));
        assert!(scan(&"a;".repeat(TOKENS_MAX / 2)).overlong.is_none());
        assert!(scan(&"a;".repeat(TOKENS_MAX / 2 + 1)).overlong.is_some());
    }

    #[test]
    fn any_text_can_be_scanned() {
        for text in [
            "",
            "struct",
            "struct S",
            "struct S {",
            "struct S { a",
            "struct S { a:",
            "struct S { @",
            "var",
            "var<",
            "/*",
            "/* /* */",
            "fn",
            "var<uniform> x:",
            "@group(",
            "struct S { a: f32 b: }",
            "é // ü",
            "struct S { } }",
        ] {
            scan(text);
        }
    }
}
