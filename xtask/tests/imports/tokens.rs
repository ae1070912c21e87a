//! One module, read from its tokens: its children, its items, what it imports and which paths it names.

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use std::collections::{BTreeMap, BTreeSet};

/// What is written in one module.
#[derive(Debug, Default)]
pub struct ModuleContent {
    /// `mod name;` without, `mod name { … }` with what it holds.
    pub children: Vec<(String, Option<ModuleContent>)>,
    /// `mod name;` under `cfg(test)`.
    pub test_children: Vec<String>,
    /// Names of what is defined in it.
    pub items: BTreeSet<String>,
    /// Names of `macro_rules`.
    pub macros: Vec<String>,
    /// Names that `use` brings into it, with their paths as they are written.
    pub bindings: BTreeMap<String, Vec<String>>,
    /// Paths before `::*`.
    pub globs: Vec<Vec<String>>,
    /// All paths in it, as they are written, those of `use` included. A word alone only if it is a type's.
    pub mentions: BTreeSet<Vec<String>>,
}

/// Words that begin an item and stand before its name.
const ITEMS: [&str; 8] = ["struct", "enum", "union", "fn", "const", "static", "type", "trait"];
/// What may stand before an item that `cfg(test)` leaves out.
const BEFORE_ITEMS: [&str; 7] = ["mod", "use", "pub", "impl", "unsafe", "async", "extern"];

/// Reads a file.
///
/// # Errors
/// The text is no Rust.
pub fn parse(text: &str) -> Result<ModuleContent, String> {
    let tokens: TokenStream = text.parse().map_err(|error| format!("{error}"))?;
    let mut parsed = ModuleContent::default();
    parsed.scan(&collected(tokens), true);
    Ok(parsed)
}

fn collected(tokens: TokenStream) -> Vec<TokenTree> {
    tokens.into_iter().collect()
}

fn word(tokens: &[TokenTree], at: usize) -> Option<String> {
    match tokens.get(at) {
        Some(TokenTree::Ident(ident)) => Some(ident.to_string().trim_start_matches("r#").to_owned()),
        _ => None,
    }
}

fn is_sign(tokens: &[TokenTree], at: usize, sign: char) -> bool {
    matches!(tokens.get(at), Some(TokenTree::Punct(punct)) if punct.as_char() == sign)
}

fn is_colons(tokens: &[TokenTree], at: usize) -> bool {
    is_sign(tokens, at, ':') && is_sign(tokens, at + 1, ':')
}

/// What is between the delimiters of a group.
fn group(tokens: &[TokenTree], at: usize, delimiter: Delimiter) -> Option<Vec<TokenTree>> {
    match tokens.get(at) {
        Some(TokenTree::Group(group)) if group.delimiter() == delimiter => Some(collected(group.stream())),
        _ => None,
    }
}

/// Whether `cfg(…)` leaves something to tests alone.
fn is_for_tests(attribute: &[TokenTree]) -> bool {
    let Some(condition) = group(attribute, 1, Delimiter::Parenthesis) else { return false };
    let names_test = |tokens: &[TokenTree]| (0..tokens.len()).any(|at| word(tokens, at).as_deref() == Some("test"));
    let of_all = group(&condition, 1, Delimiter::Parenthesis).filter(|_| word(&condition, 0).as_deref() == Some("all"));
    word(attribute, 0).as_deref() == Some("cfg")
        && (names_test(&condition) || of_all.is_some_and(|condition| names_test(&condition)))
}

/// Whether `path = …` gives a module the file that stands in for it where a feature is off. No other `path` is known.
fn is_for_stand_in(attribute: &[TokenTree]) -> bool {
    let is_path = word(attribute, 0).as_deref() == Some("path");
    let is_absent = attribute.get(2).is_some_and(|file| file.to_string().ends_with("absent.rs\""));
    assert!(!is_path || is_absent, "#[path] of another file than a stand-in, `…absent.rs`, is not understood here");
    is_path
}

impl ModuleContent {
    /// Reads tokens of the module; `is_outermost` where its items are, not within them.
    fn scan(&mut self, tokens: &[TokenTree], is_outermost: bool) {
        let mut at = 0;
        while at < tokens.len() {
            at = self.scan_at(tokens, at, is_outermost);
        }
    }

    /// Reads what stands at `at`; gives the place after it.
    fn scan_at(&mut self, tokens: &[TokenTree], at: usize, is_outermost: bool) -> usize {
        if is_sign(tokens, at, '#') {
            let bracket = if is_sign(tokens, at + 1, '!') { at + 2 } else { at + 1 };
            let attribute = group(tokens, bracket, Delimiter::Bracket).unwrap_or_default();
            if is_for_tests(&attribute) || is_for_stand_in(&attribute) {
                return self.skip_item(tokens, bracket + 1);
            }
            self.scan(&attribute, false);
            return bracket + 1;
        }
        if let Some(TokenTree::Group(group)) = tokens.get(at) {
            self.scan(&collected(group.stream()), false);
            return at + 1;
        }
        let Some(first) = word(tokens, at) else {
            // `::name` is another crate's, `.name` a field's or a method's; a path goes on after `::<…>`, too.
            let skips_word = is_colons(tokens, at) && word(tokens, at + 2).is_some();
            let is_field = is_sign(tokens, at, '.') && word(tokens, at + 1).is_some() && !is_sign(tokens, at + 1, '.');
            let is_range = at > 0 && is_sign(tokens, at - 1, '.');
            return at + if skips_word { 3 } else { 1 + usize::from(is_field && !is_range) };
        };
        match first.as_str() {
            "use" if !is_sign(tokens, at + 1, '<') => return self.use_tree(tokens, at + 1, &[]),
            "mod" if is_outermost => return self.child(tokens, at),
            "macro_rules" if is_sign(tokens, at + 1, '!') => {
                self.macros.extend(word(tokens, at + 2));
                self.items.extend(word(tokens, at + 2));
                return at + 3;
            }
            keyword if is_outermost && ITEMS.contains(&keyword) => {
                // `const fn` and `static mut` have another word between.
                let name = word(tokens, at + 1).filter(|name| !ITEMS.contains(&name.as_str()) && name != "mut");
                self.items.extend(name.or_else(|| word(tokens, at + 2).filter(|_| first == "static")));
                return at + 1;
            }
            _ => {}
        }
        let (mut path, mut next) = (vec![first], at + 1);
        while is_colons(tokens, next)
            && let Some(name) = word(tokens, next + 2)
        {
            path.push(name);
            next += 3;
        }
        if path.len() > 1 || path[0].starts_with(char::is_uppercase) {
            self.mentions.insert(path);
        }
        next
    }

    /// Reads `mod name;` or `mod name { … }`.
    fn child(&mut self, tokens: &[TokenTree], at: usize) -> usize {
        let name = word(tokens, at + 1).unwrap_or_default();
        let inline = group(tokens, at + 2, Delimiter::Brace).map(|tokens| {
            let mut parsed = Self::default();
            parsed.scan(&tokens, true);
            parsed
        });
        self.children.push((name, inline));
        at + 3
    }

    /// Passes over the item at `at`, which only tests have. Something else than an item is read as if tests had it not.
    fn skip_item(&mut self, tokens: &[TokenTree], mut at: usize) -> usize {
        while is_sign(tokens, at, '#') {
            at += 2;
        }
        let start = at;
        let is_item = |word: &String| BEFORE_ITEMS.contains(&word.as_str()) || ITEMS.contains(&word.as_str());
        if word(tokens, at).as_ref().is_none_or(|first| !is_item(first)) {
            return at;
        }
        // `use a::{b};` and `const X: T = { … };` go on after their braces.
        let mut ends_at_brace = true;
        while at < tokens.len() && !is_sign(tokens, at, ';') {
            match word(tokens, at).as_deref() {
                Some("use" | "const" | "static" | "type") => ends_at_brace = false,
                Some("fn" | "mod" | "impl" | "struct" | "enum" | "trait") => ends_at_brace = true,
                _ => {}
            }
            if ends_at_brace && group(tokens, at, Delimiter::Brace).is_some() {
                break;
            }
            at += 1;
        }
        let place = (start..at).find(|place| word(tokens, *place).as_deref() == Some("mod"));
        if is_sign(tokens, at, ';') {
            self.test_children.extend(place.and_then(|place| word(tokens, place + 1)));
        }
        at + 1
    }

    /// Reads a tree of `use` behind `prefix`; gives the place after it and after the sign that ends it.
    fn use_tree(&mut self, tokens: &[TokenTree], mut at: usize, prefix: &[String]) -> usize {
        let mut path = prefix.to_vec();
        let is_foreign = is_colons(tokens, at);
        at += if is_foreign { 2 } else { 0 };
        let mut renamed = None;
        let mut is_group = false;
        while at < tokens.len() && !is_sign(tokens, at, ',') && !is_sign(tokens, at, ';') {
            if let Some(name) = word(tokens, at) {
                if name == "as" {
                    renamed = word(tokens, at + 1);
                    at += 1;
                } else if name != "self" || path.is_empty() {
                    path.push(name);
                }
            } else if is_sign(tokens, at, '*') {
                self.globs.push(path.clone());
                self.mentions.insert(path.clone());
                is_group = true;
            } else if let Some(inner) = group(tokens, at, Delimiter::Brace) {
                let mut place = 0;
                while place < inner.len() {
                    place = self.use_tree(&inner, place, &path);
                }
                is_group = true;
            }
            at += 1;
        }
        if !is_group && !is_foreign && !path.is_empty() {
            self.mentions.insert(path.clone());
            let name = renamed.or_else(|| path.last().cloned()).filter(|name| name != "_");
            self.bindings.extend(name.map(|name| (name, path)));
        }
        at + 1
    }
}
