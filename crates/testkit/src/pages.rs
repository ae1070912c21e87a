//! What the pages of the repository show of commands and code.

use std::path::{Path, PathBuf};

/// What stands between two fences of a page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Snippet {
    /// The page, from the repository's root.
    pub page: String,
    /// The line of the page on which its text begins, from 1.
    pub line: usize,
    /// The word behind the fence; empty if there is none.
    pub language: String,
    /// What stands between the fences.
    pub text: String,
}

impl Snippet {
    /// `page:line` of a line of its text, which are counted from 0.
    pub fn place(&self, line: usize) -> String {
        format!("{}:{}", self.page, self.line + line)
    }
}

/// A command of the program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Command {
    /// `page:line`.
    pub place: String,
    /// The page, from the repository's root.
    pub page: String,
    /// Its words, without quotes; the first is the program.
    pub words: Vec<String>,
    /// Whether it stands in a sentence, where inputs may be left out.
    pub is_mentioned: bool,
}

/// The repository's root.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The pages with their texts: those at the root, and those of `docs` and the folders below it.
///
/// # Panics
/// They cannot be read.
pub fn pages() -> Vec<(String, String)> {
    let mut pages: Vec<String> = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md"].map(str::to_owned).to_vec();
    pages.extend(below("docs"));
    pages.sort();
    let read = |page: String| {
        let text = std::fs::read_to_string(root().join(&page)).expect("a page");
        (page, text)
    };
    pages.into_iter().map(read).collect()
}

/// The lines of a page that are not code, with their numbers from 1.
pub fn prose(text: &str) -> Vec<(usize, &str)> {
    let mut is_code = false;
    let mut lines = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        if line.trim_start().starts_with("```") {
            is_code = !is_code;
        } else if !is_code {
            lines.push((number, line));
        }
    }
    lines
}

/// The pages in a folder and in those below it, from the repository's root.
fn below(folder: &str) -> Vec<String> {
    let entries = std::fs::read_dir(root().join(folder)).expect("a folder of pages");
    let names = entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned());
    let pages_of = |name: String| {
        let path = format!("{folder}/{name}");
        match root().join(&path).is_dir() {
            true => below(&path),
            false if path.ends_with(".md") => vec![path],
            false => Vec::new(),
        }
    };
    names.flat_map(pages_of).collect()
}

/// The snippets of a page.
pub fn snippets(page: &str, text: &str) -> Vec<Snippet> {
    let mut snippets: Vec<Snippet> = Vec::new();
    let mut is_inside = false;
    for (line, content) in (1..).zip(text.lines()) {
        if let Some(language) = content.trim_start().strip_prefix("```") {
            if !is_inside {
                let (page, language) = (page.to_owned(), language.trim().to_owned());
                snippets.push(Snippet { page, line: line + 1, language, text: String::new() });
            }
            is_inside = !is_inside;
        } else if let Some(snippet) = snippets.last_mut().filter(|_| is_inside) {
            snippet.text += content;
            snippet.text.push('\n');
        }
    }
    snippets
}

/// The commands of a page: the lines of its `sh` snippets, and what stands in sentences between backticks and begins with
/// the program's name.
pub fn commands(page: &str, text: &str) -> Vec<Command> {
    let command = |place: String, words: Vec<String>, is_mentioned: bool| Command {
        place,
        page: page.to_owned(),
        words,
        is_mentioned,
    };
    let mut commands = Vec::new();
    for snippet in snippets(page, text).iter().filter(|snippet| snippet.language == "sh") {
        for (line, content) in snippet.text.lines().enumerate() {
            commands.push(command(snippet.place(line), words(content), false));
        }
    }
    let mut is_inside = false;
    for (line, content) in (1..).zip(text.lines()) {
        is_inside ^= content.trim_start().starts_with("```");
        let between = content.split('`').skip(1).step_by(2).filter(|_| !is_inside);
        let of_program = between.filter(|code| code.starts_with("manypass "));
        commands.extend(of_program.map(|code| command(format!("{page}:{line}"), words(code), true)));
    }
    commands.retain(|command| !command.words.is_empty());
    commands
}

/// The words of a line as a shell has them, up to a comment or what the output goes to.
pub fn words(line: &str) -> Vec<String> {
    let mut words = Vec::new();
    let mut word: Option<String> = None;
    let mut quote = None;
    for letter in line.chars() {
        match (quote, letter) {
            (Some(open), _) if open == letter => quote = None,
            (Some(_), _) => word.get_or_insert_default().push(letter),
            (None, '\'' | '"') => {
                quote = Some(letter);
                word.get_or_insert_default();
            }
            (None, '#') if word.is_none() => break,
            (None, '|' | '>') => break,
            (None, letter) if letter.is_whitespace() => words.extend(word.take()),
            (None, letter) => word.get_or_insert_default().push(letter),
        }
    }
    words.extend(word);
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = "Say `manypass info a.glb` or `info`.\n\n```sh\nmanypass render a.glb   # a comment\nls | sort\n```\n\
                        1. A list\n   ```toml\n   a = 1\n   ```\n";

    #[test]
    fn snippets_have_their_places() {
        let found = snippets("a.md", PAGE);
        let languages: Vec<(&str, usize)> =
            found.iter().map(|snippet| (snippet.language.as_str(), snippet.line)).collect();
        assert_eq!(languages, [("sh", 4), ("toml", 9)]);
        assert_eq!((found[1].text.as_str(), found[0].place(1)), ("   a = 1\n", "a.md:5".into()));
    }

    #[test]
    fn commands_stand_in_snippets_and_in_sentences() {
        let found = commands("a.md", PAGE);
        let told: Vec<(&str, String, bool)> = found
            .iter()
            .map(|command| (command.place.as_str(), command.words.join(" "), command.is_mentioned))
            .collect();
        let expected = [
            ("a.md:4", "manypass render a.glb".to_owned(), false),
            ("a.md:5", "ls".to_owned(), false),
            ("a.md:1", "manypass info a.glb".to_owned(), true),
        ];
        assert_eq!(told, expected);
    }

    #[test]
    fn words_are_those_of_a_shell() {
        assert_eq!(words("a 'b c'  \"d'\" e#f #g"), ["a", "b c", "d'", "e#f"]);
        assert_eq!(words("a -o - | b"), ["a", "-o", "-"]);
        assert_eq!(words("a '' > b"), ["a", ""]);
        assert!(words("# nothing").is_empty());
    }
}
