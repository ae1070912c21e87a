//! What a call reads and writes: no output may replace an input or another output.

use crate::args::{FrameArgs, RenderArgs};
use crate::failure::Failure;
use crate::gather::Item;
use crate::identity::{KnownFiles, Lookup, Place, is_file};
use crate::input::Input;
use crate::job::Job;
use crate::looks::Subject;
use crate::output::{self, is_pass_picture};
use crate::pattern::is_stdout;
use manypass::EffectFile;
use manypass_offline::atomic;
use manypass_scene::environment::prefiltered_files;
use manypass_scene::formats;
use manypass_scene::stage::{is_stage, named_effects, named_environments, named_images, named_model};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The most pictures whose files are checked before the first is drawn; those of the rest are checked as their turn
/// comes.
const CHECKED_AT_START: u64 = 20_000;

/// What a call reads and writes.
#[derive(Debug, Default)]
pub struct Places {
    reads: KnownFiles,
    writes: KnownFiles,
    /// Folders that `--dump-passes` fills.
    dumps: BTreeSet<PathBuf>,
    /// Folders in which another output has a name as `--dump-passes` gives them.
    numbered: BTreeSet<PathBuf>,
    lookup: Lookup,
    checked_pictures: u64,
}

impl Places {
    /// Everything that `args` reads and writes, as far as that can be known before anything is drawn; `lights` are
    /// the files of the environment that settings name, `effects` are those of the chain that they name.
    ///
    /// # Errors
    /// Wrong usage, if an output would replace something that is read, or another output.
    pub fn new(
        args: &RenderArgs,
        job: &Job,
        items: &[Item],
        (lights, effects): (&[PathBuf], &[EffectFile]),
    ) -> Result<Self, Failure> {
        let mut places = Self::default();
        items.iter().for_each(|item| places.read_input(&item.input));
        places.read_named(&args.frame);
        places.read_effects(effects);
        lights.iter().for_each(|path| places.read_environment(path));
        job.views.files.iter().for_each(|path| places.read(path, format!("the cameras {}", path.display())));
        let reports_to_stdout = args.report.as_deref().is_some_and(is_stdout);
        if job.output.is_stdout() || reports_to_stdout {
            places.write_open_stdout()?;
        }
        if let Some(path) = job.output.stream().and_then(|place| place.path.as_deref()) {
            places.write_as(path, "all pictures")?;
        }
        if let Some(report) = args.report.as_deref().filter(|_| !reports_to_stdout) {
            places.write_as(report, "the report")?;
        }
        let (first, last) = job.frames.unwrap_or((0, 0));
        // What looks are called is known when their file is read.
        let known = if job.several.has_looks() { &[] } else { items };
        'pictures: for item in known {
            for frame in first..=last {
                if places.checked_pictures == CHECKED_AT_START {
                    break 'pictures;
                }
                places.write_picture(job, Subject { names: &item.names, look: &job.look, frame })?;
                places.checked_pictures += 1;
            }
        }
        Ok(places)
    }

    /// What one input reads.
    pub fn of_input(input: &Input) -> Self {
        let mut places = Self::default();
        places.read_input(input);
        places
    }

    /// What one input and `effects` read.
    pub fn of_input_and_effects(input: &Input, effects: &[EffectFile]) -> Self {
        let mut places = Self::of_input(input);
        places.read_effects(effects);
        places
    }

    /// What a comparison of pictures reads.
    pub fn of_pictures(paths: &[&Path]) -> Self {
        let mut places = Self::default();
        paths.iter().for_each(|path| places.read(path, format!("the picture {}", path.display())));
        places
    }

    /// What a comparison of models reads.
    pub fn of_models(inputs: &[Input], frame: &FrameArgs, effects: &[EffectFile]) -> Self {
        let mut places = Self::default();
        inputs.iter().for_each(|input| places.read_input(input));
        places.read_named(frame);
        places.read_effects(effects);
        let environment = frame.around.environment.as_deref().map(Path::new);
        environment.iter().for_each(|path| places.read(path, format!("the environment {}", path.display())));
        places
    }

    /// The files of effects; built-in ones have none.
    fn read_effects(&mut self, effects: &[EffectFile]) {
        let files = effects.iter().map(EffectFile::file).filter(|file| !EffectFile::is_built_in(file));
        files.for_each(|file| self.read(Path::new(file), format!("the effect {file}")));
    }

    /// The file of settings that a flag names.
    fn read_named(&mut self, frame: &FrameArgs) {
        frame.settings.iter().for_each(|path| self.read(path, format!("the settings {}", path.display())));
    }

    /// Checks the files of a picture, unless that was done at the start. `item_index` is that of its input among all.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn check(&mut self, item_index: u64, job: &Job, subject: Subject<'_>) -> Result<(), Failure> {
        let (first, last) = job.frames.unwrap_or((0, 0));
        let frame_count = u64::from(last.saturating_sub(first)) + 1;
        let index =
            item_index.saturating_mul(frame_count).saturating_add(u64::from(subject.frame.saturating_sub(first)));
        if index < self.checked_pictures { Ok(()) } else { self.write_picture(job, subject) }
    }

    fn read_input(&mut self, input: &Input) {
        match input {
            Input::File(path) if is_stage(path) => {
                self.read(path, format!("the stage {}", path.display()));
                // A stage that names a stage is an error as soon as it is read.
                named_model(path).iter().filter(|model| !is_stage(model)).for_each(|model| self.read_model(model));
                named_environments(path).into_iter().for_each(|path| self.read_environment(&path));
                for image in named_images(path) {
                    self.read(&image, format!("an image that {} names", path.display()));
                }
                for effect in named_effects(path) {
                    self.read(&effect, format!("an effect that {} names", path.display()));
                }
            }
            Input::File(path) => self.read_model(path),
            Input::Stdin if cfg!(unix) => self.read(Path::new("/dev/stdin"), "the model on standard input".into()),
            Input::Stdin | Input::Demo(_) => {}
        }
    }

    fn read_model(&mut self, path: &Path) {
        self.read(path, format!("the model {}", path.display()));
        // What is wrong with the model is said when it is read. What it names belongs to it, even if it is not read.
        for file in formats::mentions(path).unwrap_or_default() {
            self.read(&file, format!("a file that {} names", path.display()));
        }
    }

    fn read_environment(&mut self, path: &Path) {
        // Those of levels that are named by a pattern, or of the faces of a cube.
        for file in prefiltered_files(path) {
            self.read(&file, format!("the environment {}", file.display()));
        }
    }

    fn read(&mut self, path: &Path, what: String) {
        if is_file(path) {
            let place = self.lookup.place(path);
            self.reads.insert(place, what);
        }
    }

    /// Standard output, where it goes to a file.
    ///
    /// # Errors
    /// Wrong usage, if that file is read.
    fn write_open_stdout(&mut self) -> Result<(), Failure> {
        let open = Path::new("/dev/stdout");
        if cfg!(unix) && is_file(open) { self.write_as(open, "standard output") } else { Ok(()) }
    }

    fn write_picture(&mut self, job: &Job, subject: Subject<'_>) -> Result<(), Failure> {
        let dump = job.dump_passes.as_ref().map(|pattern| pattern.expand(subject, "rgba"));
        let sheet = job.contact_sheet.as_ref().map(|pattern| pattern.expand(subject, "rgba"));
        if let Some((target, aovs)) = output::files(job, subject) {
            self.write(&target)?;
            aovs.iter().try_for_each(|path| self.write(path))?;
        }
        sheet.map_or(Ok(()), |path| self.write_as(&path, "a contact sheet"))?;
        dump.map_or(Ok(()), |folder| self.write_dump(&folder))
    }

    /// Adds an output.
    ///
    /// # Errors
    /// Wrong usage, if it would replace something that is read, or another output.
    pub fn write(&mut self, path: &Path) -> Result<(), Failure> {
        self.write_as(path, "a picture")
    }

    /// Adds an output that is `what`.
    ///
    /// # Errors
    /// As [`Self::write`].
    pub fn write_as(&mut self, path: &Path, what: &str) -> Result<(), Failure> {
        let is_open = atomic::is_in_place(path);
        let place = match fs::symlink_metadata(path) {
            // Devices and pipes take what comes and keep nothing that could be lost.
            Ok(_) if is_open && !is_file(path) => return Ok(()),
            Ok(_) => self.lookup.place(path),
            // Most outputs are not there yet, and long sequences have many.
            Err(_) => self.lookup.absent(path),
        };
        let shown = path.display();
        self.refuse_read(&place, path)?;
        // A file that is open already takes all pictures, one after the other.
        let written = if is_open { format!("{what} to the open file {shown}") } else { what.to_owned() };
        if let Some(other) = self.writes.get(&place) {
            if is_open && other == written {
                return Ok(());
            }
            let message = format!("two outputs would be written to {shown}");
            return Err(Failure::usage(
                message,
                "use {parent}, {stem}, {variant}, {camera} and {frame:04} in the names, and other folders",
            ));
        }
        if path.file_name().is_some_and(is_pass_picture) {
            let folder = place.path.parent().unwrap_or(Path::new("")).to_owned();
            self.refuse_dump_beside(self.dumps.contains(&folder), path)?;
            self.numbered.insert(folder);
        }
        self.writes.insert(place, written);
        Ok(())
    }

    /// Adds a folder of pictures of passes; their names are known only when they are drawn.
    fn write_dump(&mut self, folder: &Path) -> Result<(), Failure> {
        let place = self.lookup.place(folder).path;
        self.refuse_dump_beside(self.numbered.contains(&place), folder)?;
        if !self.dumps.insert(place) {
            let message = format!("the passes of two pictures would be written to {}", folder.display());
            return Err(Failure::usage(
                message,
                "use {parent}, {stem}, {variant}, {camera} and {frame:04} in the name",
            ));
        }
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        for path in entries.filter(|entry| is_pass_picture(&entry.file_name())).map(|entry| entry.path()) {
            let place = self.lookup.place(&path);
            self.refuse_read(&place, &path)?;
        }
        Ok(())
    }

    fn refuse_read(&self, place: &Place, path: &Path) -> Result<(), Failure> {
        self.reads.get(place).map_or(Ok(()), |what| {
            let message = format!("{} would replace {what}", path.display());
            Err(Failure::usage(message, "write to another file or folder, for example -o renders/"))
        })
    }

    fn refuse_dump_beside(&self, is_beside: bool, path: &Path) -> Result<(), Failure> {
        if !is_beside {
            return Ok(());
        }
        let message = format!("--dump-passes could replace another output at {}", path.display());
        Err(Failure::usage(message, "give --dump-passes a folder of its own"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn a_file_is_known_by_every_name() {
        let root = std::env::temp_dir().join(format!("manypass-places-{}", std::process::id()));
        let _ = fs::remove_dir_all(&root);
        fs::create_dir_all(root.join("in")).expect("a folder");
        let model = root.join("in/m.glb");
        fs::write(&model, b"x").expect("written");
        fs::hard_link(&model, root.join("hard.png")).expect("linked");
        std::os::unix::fs::symlink("in/m.glb", root.join("soft.png")).expect("linked");
        std::os::unix::fs::symlink("in", root.join("door")).expect("linked");
        let names = ["in/m.glb", "./in/../in/./m.glb", "new/../in/m.glb", "hard.png", "soft.png", "door/m.glb"];
        for name in names {
            let mut places = Places::of_input(&Input::File(model.clone()));
            assert_eq!(places.write(&root.join(name)).expect_err(name).code(), 2);
            let mut places = Places::default();
            places.write(&model).expect("the first output");
            assert_eq!(places.write(&root.join(name)).expect_err(name).code(), 2);
        }
        let mut places = Places::of_input(&Input::File(model));
        for name in ["in/n.glb", "m.glb", "door/n.png", "/dev/null", "/dev/null"] {
            places.write(&root.join(name)).expect(name);
        }
        places.write(&root.join("in/n.png")).expect_err("the same as door/n.png");
        places.write_dump(&root.join("in")).expect("a dump");
        assert!(places.write(&root.join("door/01-a.png")).is_err() && places.write_dump(&root.join("door")).is_err());
        let _ = fs::remove_dir_all(root);
    }

    #[test]
    fn pictures_after_one_that_failed_are_checked_in_their_turn() {
        use crate::args::{Cli, Command};
        use clap::Parser as _;
        let words = ["manypass", "render", "a.glb", "b.glb", "--frames", "5..7", "-o", "out/gone_{frame}.png"];
        let Command::Render(args) = Cli::try_parse_from(words).expect("arguments").command else { return };
        let job = Job::new(&args, true, &[]).expect("a job");
        let names = crate::gather::Names::default();
        let mut places = Places { checked_pictures: 4, ..Places::default() };
        // The first input failed at its first frame; the second has the indices 3 to 5 all the same.
        for (frame, is_checked_now) in [(5, false), (6, true), (7, true)] {
            places.check(1, &job, Subject { names: &names, look: &job.look, frame }).expect("free");
            let written = places.write(&PathBuf::from(format!("out/gone_{frame}.png")));
            assert_eq!(written.is_err(), is_checked_now, "{frame}");
        }
    }
}
