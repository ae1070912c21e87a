//! What `cargo xtask fidelity` is asked for.

use std::path::PathBuf;

/// What `cargo xtask fidelity --help` prints.
pub(crate) const HELP: &str = "\
Usage: cargo xtask fidelity [OPTIONS]

published: renders the scenes of goldens-render-fidelity/scenarios.json as their published pictures were rendered (camera, size,
environment, ACES, no exposure, no shadows of the file's lights), and compares with the pictures of the glTF Sample Viewer and of
Cycles, beside the distance of Filament's pictures from the same.

  RMSE   the root of the mean square difference of sRGB values, in levels of 255, both pictures 512 pixels wide and laid over
         mid grey (127.5): over the whole picture, as renderer_spread.csv has it, and over what either covers
         (`covered`); `packed` is ours with colours of half the size, as lossy WebP has them, which the published pictures are.
         Their encoding is a power of 1/2.2, but of Filament's, which is sRGB: ours have the former here, and `as sRGB` and
         `Filament by gamma` are both in the other one
  FLIP   the mean of `manypass diff`

  ours are rendered twice as large as the published pictures and scaled by Lanczos's filter, as those were. For every scene
  there is a sheet: theirs, ours, and the map of FLIP. The command fails if the median of our distance is above Filament's, or
  above 0.9 of it with both as lossy files in the same encoding (`packed`, `Filament by gamma`).

traced: path-traces scenes of core glTF, and of four extensions, with Mitsuba 3 (xtask/mitsuba; installed by pip into
target/mitsuba), once under each light, and compares radiance (EXR): the ratio of means, the mean absolute difference, and HDR-FLIP.

Options:
  --tables TABLES    published, traced, or both with a comma [default: both]
  --only NAMES       these scenes alone, with commas between them: Duck, or khronos-Duck
  --out DIR          for pictures, sheets and fidelity.json [default: target/fidelity]
  --markdown FILE    write the tables to FILE, too
  --program PROGRAM  this build of manypass; otherwise the release build, which is made first

Takes about 3 and 13 minutes on two cores with a software adapter, and 4 more to build. Path-traced pictures are kept in DIR.
The assets lie in MANYPASS_ASSETS, else beside the repository in shared/assets.
";

/// A table that can be asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Table {
    Published,
    Traced,
}

/// What `cargo xtask fidelity` is asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Options {
    pub(super) tables: Vec<Table>,
    /// Names of scenes without what all begin with; empty for all.
    pub only: Vec<String>,
    pub out: Option<PathBuf>,
    pub markdown: Option<PathBuf>,
    /// None for the release build, which is made first.
    pub program: Option<PathBuf>,
}

/// What the names of all scenes begin with.
pub(super) const PREFIX: &str = "khronos-";

impl Default for Options {
    fn default() -> Self {
        let tables = vec![Table::Published, Table::Traced];
        Self { tables, only: Vec::new(), out: None, markdown: None, program: None }
    }
}

impl Table {
    fn parse(name: &str) -> Result<Self, String> {
        match name {
            "published" => Ok(Self::Published),
            "traced" => Ok(Self::Traced),
            _ => Err(format!("no table is called `{name}`; there are published, traced")),
        }
    }
}

impl Options {
    /// Reads the words after `fidelity`.
    ///
    /// # Errors
    /// What is wrong with them, in one sentence.
    pub fn parse(words: &[&str]) -> Result<Self, String> {
        let mut options = Self::default();
        let mut words = words.iter();
        while let Some(&word) = words.next() {
            let (name, value) = match word.split_once('=') {
                Some((name, value)) => (name, Some(value)),
                None => (word, None),
            };
            if !["--tables", "--only", "--out", "--markdown", "--program"].contains(&name) {
                return Err(format!("fidelity does not know `{word}`"));
            }
            let value = value.or_else(|| words.next().copied()).ok_or_else(|| format!("{name} needs a value"))?;
            match name {
                "--tables" => options.tables = value.split(',').map(Table::parse).collect::<Result<_, _>>()?,
                "--only" => {
                    let names = value.split(',').map(|name| name.strip_prefix(PREFIX).unwrap_or(name).to_owned());
                    options.only = names.collect();
                }
                "--out" => options.out = Some(PathBuf::from(value)),
                "--markdown" => options.markdown = Some(PathBuf::from(value)),
                _ => options.program = Some(PathBuf::from(value)),
            }
        }
        Ok(options)
    }

    /// Whether a scene is asked for.
    pub fn wants(&self, name: &str) -> bool {
        self.only.is_empty() || self.only.iter().any(|only| only == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_read_in_both_forms() {
        let options =
            Options::parse(&["--tables", "traced", "--only", "Duck,khronos-Fox", "--out=o", "--program", "p"])
                .expect("options");
        let expected = Options {
            tables: vec![Table::Traced],
            only: vec!["Duck".into(), "Fox".into()],
            out: Some("o".into()),
            markdown: None,
            program: Some("p".into()),
        };
        assert_eq!(options, expected);
        assert!(options.wants("Fox") && !options.wants("Box") && Options::default().wants("Box"));
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (words, said) in [(&["--only"][..], "needs a value"), (&["--fast"], "--fast"), (&["--tables", "x"], "`x`")]
        {
            let error = Options::parse(words).expect_err("wrong options");
            assert!(error.contains(said), "{words:?}: {error}");
        }
    }
}
