//! What `cargo xtask bench` is asked for.

use std::path::PathBuf;

/// What `cargo xtask bench --help` prints.
pub(crate) const HELP: &str = "\
Usage: cargo xtask bench [OPTIONS]

Measures what frames cost, as ratios within one run: what is compared takes turns, and the least median of the turns counts.
What takes long has one turn. Times of different machines, or of different runs, are not to be compared.

Tables:
  graph     the frame graph, and frames of 10,000 nodes and of a million instances, outside the adapter
  ways      ways of lighting by numbers of lights, each as a ratio to the cheapest, with draws, pairs and bytes
  shadows   the same with every tenth light shadowed, with shadowed lights and shadow maps drawn
  fields    the demo and the fields of lights: the pass `direct` against the limit, which is a bare loop over lights
            measured in the same run (`cargo bench -p manypass --bench limit`), and the frame against forward and brute force
  textures  memory of the textures of a frame of 1920x1080
  levels    10,000 small things with and without levels of detail of meshes and materials
  effects   effects at 1920x1080 beside a plain copy, with the bytes that they read, write and hold; the blur and occlusion
            beside their textbook versions
  quality   tiers of quality: milliseconds of a live frame, beside the next tier's, and FLIP to the best with many samples
  captures  mirrors, water, portals, reflection probes and monitors: milliseconds of a live frame beside the same frame without them
  decals    leaves on the floor of the hall, beside the pass that draws the G-buffer without them
  simulations  a step of waves, patterns, fluids and 100,000 particles, beside a copy of their states
  environment  prefiltering a picture of 2048x1024, having it from a cache, and the studio
  antialiasing  ways of anti-aliasing and of upscaling at 480x270 against stills of 64 samples, over a move of 60 frames through
            the demo hall and around a skinned figure; every sixth frame is compared, or all with --all-frames
  baking    light by rays and by pictures at equal error: a probe and a texel of the Cornell box; and frames of the hall with
            baked probes and light maps, beside frames without
  growth    files with 10,000, 100,000 and 1,000,000 nodes, lights, materials, primitives, corners of a polygon, points
            and others, and up to 60,000 items of an overlay: `info` and a still, each beside a tenth of them; two
            minutes at the most
  baseline  ours and the program of --baseline in turns, on 16 and 1,024 lights

A cell counts only if its picture is that of brute force, which visits every light for every pixel. Otherwise it says
DIFFERS, and the command fails at its end. Light by vertices (gouraud) is another picture, which is not compared.

Options:
  --only TABLES       run these tables alone, with commas between them
  --lights NUMBERS    only fields of so many lights, with commas between them [default: 16,64,256,1024,4096,10000]
  --markdown FILE     write the tables to FILE, too, with machine, adapter and date
  --baseline PROGRAM  run the table baseline against another build of manypass; alone, unless --only names other tables, too
  --all-frames        compare all frames of the moves of the table antialiasing, which takes six times as long
  --quick             measure the table effects once and small: whether it can be measured, not what it says
  --program PROGRAM   measure this build of manypass; otherwise the release build, which is made first

All tables take about 22 minutes on two cores with a software adapter, and 4 more to build.
The fields of lights lie in MANYPASS_ASSETS, else beside the repository in shared/assets.
";

/// The numbers of lights of the fields.
pub(super) const LIGHTS: [usize; 6] = [16, 64, 256, 1024, 4096, 10_000];

/// A table that can be asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TableName {
    Graph,
    Ways,
    Shadows,
    Fields,
    Textures,
    Levels,
    Effects,
    Quality,
    Captures,
    Decals,
    Simulations,
    Environment,
    Antialiasing,
    Baking,
    Growth,
    Baseline,
}

impl TableName {
    const ALL: [(&str, Self); 16] = [
        ("graph", Self::Graph),
        ("ways", Self::Ways),
        ("shadows", Self::Shadows),
        ("fields", Self::Fields),
        ("textures", Self::Textures),
        ("levels", Self::Levels),
        ("effects", Self::Effects),
        ("quality", Self::Quality),
        ("captures", Self::Captures),
        ("decals", Self::Decals),
        ("simulations", Self::Simulations),
        ("environment", Self::Environment),
        ("antialiasing", Self::Antialiasing),
        ("baking", Self::Baking),
        ("growth", Self::Growth),
        ("baseline", Self::Baseline),
    ];

    fn parse(name: &str) -> Result<Self, String> {
        let found = Self::ALL.iter().find(|(known, _)| *known == name).map(|(_, table)| *table);
        found.ok_or_else(|| {
            format!("no table is called `{name}`; there are {}", Self::ALL.map(|(name, _)| name).join(", "))
        })
    }
}

/// What `cargo xtask bench` is asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Options {
    pub tables: Vec<TableName>,
    pub lights: Vec<usize>,
    pub markdown: Option<PathBuf>,
    pub baseline: Option<PathBuf>,
    /// None for the release build, which is made first.
    pub program: Option<PathBuf>,
    /// Whether all frames of moves are compared, not every sixth.
    pub all_frames: bool,
    /// Whether the table of effects is measured small and once.
    pub is_quick: bool,
}

impl Options {
    /// Reads the words after `bench`.
    ///
    /// # Errors
    /// What is wrong with them, in one sentence.
    pub fn parse(words: &[&str]) -> Result<Self, String> {
        let (mut only, mut lights) = (None, LIGHTS.to_vec());
        let (mut markdown, mut baseline, mut program) = (None, None, None);
        let (mut all_frames, mut is_quick) = (false, false);
        let mut words = words.iter();
        while let Some(&word) = words.next() {
            match word {
                "--all-frames" => all_frames = true,
                "--quick" => is_quick = true,
                _ => (),
            }
            if ["--all-frames", "--quick"].contains(&word) {
                continue;
            }
            let (name, value) = match word.split_once('=') {
                Some((name, value)) => (name, Some(value)),
                None => (word, None),
            };
            let known = ["--only", "--lights", "--markdown", "--baseline", "--program"];
            if !known.contains(&name) {
                return Err(format!("bench does not know `{word}`"));
            }
            let value = value.or_else(|| words.next().copied()).ok_or_else(|| format!("{name} needs a value"))?;
            match name {
                "--only" => only = Some(value.split(',').map(TableName::parse).collect::<Result<Vec<_>, _>>()?),
                "--lights" => lights = value.split(',').map(number_of_lights).collect::<Result<Vec<_>, _>>()?,
                "--markdown" => markdown = Some(PathBuf::from(value)),
                "--baseline" => baseline = Some(PathBuf::from(value)),
                _ => program = Some(PathBuf::from(value)),
            }
        }
        use TableName::{
            Antialiasing, Baseline, Effects, Environment, Fields, Graph, Levels, Quality, Shadows, Textures, Ways,
        };
        let tables = match (only, &baseline) {
            (Some(only), _) => only,
            (None, Some(_)) => vec![Baseline],
            (None, None) => {
                vec![Graph, Ways, Shadows, Fields, Textures, Levels, Effects, Quality, Environment, Antialiasing]
            }
        };
        if tables.contains(&Baseline) != baseline.is_some() {
            return Err("the table baseline and --baseline PROGRAM need each other".into());
        }
        Ok(Self { tables, lights, markdown, baseline, program, all_frames, is_quick })
    }
}

fn number_of_lights(text: &str) -> Result<usize, String> {
    let number = text.parse().ok().filter(|number| LIGHTS.contains(number));
    number.ok_or_else(|| format!("there is no field of `{text}` lights; there are {LIGHTS:?}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_read_in_both_forms() {
        let words = [
            "--only",
            "ways,fields",
            "--lights=16,1024",
            "--markdown",
            "a.md",
            "--all-frames",
            "--quick",
            "--program=x/manypass",
        ];
        let expected = Options {
            tables: vec![TableName::Ways, TableName::Fields],
            lights: vec![16, 1024],
            markdown: Some("a.md".into()),
            baseline: None,
            program: Some("x/manypass".into()),
            all_frames: true,
            is_quick: true,
        };
        assert_eq!(Options::parse(&words), Ok(expected));
    }

    #[test]
    fn a_baseline_is_measured_alone_unless_other_tables_are_named() {
        let tables = |words: &[&str]| Options::parse(words).map(|options| options.tables);
        assert_eq!(tables(&["--baseline", "old"]), Ok(vec![TableName::Baseline]));
        let both = tables(&["--baseline", "old", "--only", "baseline,ways"]);
        assert_eq!(both, Ok(vec![TableName::Baseline, TableName::Ways]));
        assert_eq!(tables(&[]).map(|tables| tables.len()), Ok(10));
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (words, said) in [
            (&["--only", "wais"][..], "wais"),
            (&["--only"], "needs a value"),
            (&["--lights", "17"], "17"),
            (&["--fast"], "--fast"),
            (&["--only", "baseline"], "--baseline PROGRAM"),
            (&["--baseline", "old", "--only", "ways"], "--baseline PROGRAM"),
        ] {
            let error = Options::parse(words).expect_err("wrong options");
            assert!(error.contains(said), "{words:?}: {error}");
        }
    }
}
