//! What the files of a crate import from one another, read from their tokens: `use` in every form, paths that are
//! written out, and those within macros. A name that a module exports again counts for where it is defined.

use super::tokens::{self, ModuleContent};
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// The modules of a crate.
#[derive(Debug, Default)]
pub struct Tree {
    modules: Vec<Module>,
    /// From the path from the crate's root to the index.
    by_path: BTreeMap<Vec<String>, usize>,
    /// `macro_rules` with their module; `#[macro_export]` puts them into the root.
    macros: BTreeMap<String, usize>,
    /// Files that only tests have.
    test_files: BTreeSet<String>,
    imports: BTreeMap<(String, String), String>,
    named: BTreeSet<ItemUse>,
}

#[derive(Debug)]
struct Module {
    path: Vec<String>,
    file: String,
    parsed: ModuleContent,
}

/// An item that a file names.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ItemUse {
    /// The file that names it.
    pub by: String,
    /// The file that defines it.
    pub of: String,
    /// Its name there.
    pub item: String,
}

/// Where a path ends: a module, and what is named in it.
type Target = (usize, Option<String>);

/// Paths that lead to themselves end here.
const DEPTH_MAX: usize = 24;

/// The file of the module `name` below `above`.
fn file_below(files: &BTreeMap<String, String>, above: &[String], name: &str) -> Option<String> {
    let stem = [above, &[name.to_owned()]].concat().join("/");
    [format!("{stem}.rs"), format!("{stem}/mod.rs")].into_iter().find(|file| files.contains_key(file))
}

impl Tree {
    /// The crate of these files, whose names begin at the folder of `lib.rs`. Modules under `cfg(test)` are left out.
    ///
    /// # Panics
    /// If a file is missing or is no Rust.
    pub fn new(files: &BTreeMap<String, String>) -> Self {
        let mut tree = Self::default();
        tree.add(files, Vec::new(), "lib.rs".to_owned(), None);
        for module in 0..tree.modules.len() {
            for written in &tree.modules[module].parsed.mentions {
                let Some((target, item)) = tree.resolve(module, written, 0) else { continue };
                let (by, of) = (&tree.modules[module].file, &tree.modules[target].file);
                if by != of {
                    tree.imports.entry((by.clone(), of.clone())).or_insert_with(|| written.join("::"));
                }
                let named = item.map(|item| ItemUse { by: by.clone(), of: of.clone(), item });
                tree.named.extend(named);
            }
        }
        tree
    }

    fn add(
        &mut self,
        files: &BTreeMap<String, String>,
        path: Vec<String>,
        file: String,
        inline: Option<ModuleContent>,
    ) {
        let parsed = inline.unwrap_or_else(|| {
            let text = files.get(&file).unwrap_or_else(|| panic!("there is no {file}"));
            tokens::parse(text).unwrap_or_else(|error| panic!("{file}: {error}"))
        });
        let index = self.modules.len();
        self.by_path.insert(path.clone(), index);
        self.macros.extend(parsed.macros.iter().map(|name| (name.clone(), index)));
        self.modules.push(Module { path: path.clone(), file: file.clone(), parsed });
        let file_of = |name: &str| file_below(files, &path, name);
        for (name, inline) in std::mem::take(&mut self.modules[index].parsed.children) {
            let child = [&path[..], std::slice::from_ref(&name)].concat();
            match inline {
                Some(inline) => self.add(files, child, file.clone(), Some(inline)),
                None => {
                    let below = file_of(&name).unwrap_or_else(|| panic!("{file}: no file for `mod {name}`"));
                    self.add(files, child, below, None);
                }
            }
        }
        let tests = self.modules[index].parsed.test_children.clone();
        tests.iter().for_each(|name| self.add_tests(files, &path, name));
    }

    /// The file of a module that only tests have, and those of the modules below it.
    fn add_tests(&mut self, files: &BTreeMap<String, String>, above: &[String], name: &str) {
        let Some(file) = file_below(files, above, name) else { return };
        let path = [above, &[name.to_owned()]].concat();
        let parsed = tokens::parse(&files[&file]).unwrap_or_else(|error| panic!("{file}: {error}"));
        let children = parsed.children.into_iter().filter(|(_, inline)| inline.is_none()).map(|(name, _)| name);
        children.chain(parsed.test_children).for_each(|name| self.add_tests(files, &path, &name));
        self.test_files.insert(file);
    }

    fn child(&self, module: usize, name: &str) -> Option<usize> {
        let path = [&self.modules[module].path[..], &[name.to_owned()]].concat();
        self.by_path.get(&path).copied()
    }

    /// What `path` means in `module`; none for other crates, generics and variables.
    fn resolve(&self, module: usize, path: &[String], depth: usize) -> Option<Target> {
        let (first, rest) = path.split_first()?;
        match first.as_str() {
            "crate" => self.walk(0, rest, depth),
            "self" => self.walk(module, rest, depth),
            "super" => {
                let (_, above) = self.modules[module].path.split_last()?;
                let parent = *self.by_path.get(above)?;
                if rest.first().is_some_and(|next| next == "super") {
                    self.resolve(parent, rest, depth)
                } else {
                    self.walk(parent, rest, depth)
                }
            }
            _ => self.find(module, first, rest, depth),
        }
    }

    /// `rest` below `module`. What is not known there is taken for one of its items.
    fn walk(&self, module: usize, rest: &[String], depth: usize) -> Option<Target> {
        let Some((name, after)) = rest.split_first() else { return Some((module, None)) };
        self.find(module, name, after, depth).or_else(|| {
            let exported = if module == 0 { self.macros.get(name) } else { None };
            Some((*exported.unwrap_or(&module), Some(name.clone())))
        })
    }

    /// `name::rest` where `name` is a child of `module`, an item, or imported into it.
    fn find(&self, module: usize, name: &str, rest: &[String], depth: usize) -> Option<Target> {
        if depth > DEPTH_MAX {
            return None;
        }
        let parsed = &self.modules[module].parsed;
        if let Some(child) = self.child(module, name) {
            // A function may have the name of a module beside it; what follows tells them apart.
            return self.walk(child, rest, depth + 1);
        }
        if parsed.items.contains(name) {
            return Some((module, Some(name.to_owned())));
        }
        if let Some(path) = parsed.bindings.get(name) {
            // `use glam;` binds a name to itself.
            let is_foreign = path.len() == 1 && path[0] == name;
            let whole = [&path[..], rest].concat();
            return if is_foreign { None } else { self.resolve(module, &whole, depth + 1) };
        }
        parsed.globs.iter().find_map(|glob| {
            let (from, None) = self.resolve(module, glob, depth + 1)? else { return None };
            self.find(from, name, rest, depth + 1)
        })
    }

    /// All files but those that only tests have.
    pub fn files(&self) -> BTreeSet<&str> {
        self.modules.iter().map(|module| module.file.as_str()).collect()
    }

    /// Files of modules that only tests have.
    pub fn test_files(&self) -> &BTreeSet<String> {
        &self.test_files
    }

    /// Pairs of a file and another that it imports, with what is written there.
    pub fn imports(&self) -> impl Iterator<Item = (&str, &str, &str)> {
        self.imports.iter().map(|((by, of), written)| (by.as_str(), of.as_str(), written.as_str()))
    }

    /// All items that files name, their own included.
    pub fn named(&self) -> &BTreeSet<ItemUse> {
        &self.named
    }

    /// The files that `from` imports, and those that they import, with the file before each on the shortest way.
    pub fn reach<'a>(&'a self, from: &'a str) -> BTreeMap<&'a str, &'a str> {
        let (mut before, mut open) = (BTreeMap::new(), VecDeque::from([from]));
        while let Some(file) = open.pop_front() {
            for (_, next, _) in self.imports().filter(|(by, ..)| *by == file) {
                if !before.contains_key(next) {
                    before.insert(next, file);
                    open.push_back(next);
                }
            }
        }
        before
    }

    /// How `from` comes to import `to`: `a.rs → b.rs (crate::b) → …`; none if it does not.
    pub fn chain(&self, from: &str, to: &str) -> Option<String> {
        let before = self.reach(from);
        let mut steps = vec![to];
        while steps.len() < 2 || steps.last() != Some(&from) {
            steps.push(before.get(steps.last()?)?);
        }
        let mut text = from.to_owned();
        for pair in steps.windows(2).rev() {
            let written = &self.imports[&(pair[1].to_owned(), pair[0].to_owned())];
            text += &format!(" → {} ({written})", pair[0]);
        }
        Some(text)
    }
}
