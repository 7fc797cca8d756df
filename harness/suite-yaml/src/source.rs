//! Where the text of the suites comes from: a program that carries it, or a folder.
//!
//! This module knows files, not their contents.

use super::error::{LoadError, LoadErrors, Mistake, Mistakes, Spot};
use super::folder;
pub(super) use super::folder::{COMMON, PERSONAS};
use expression::Value;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;
use suite::Location;
use suite::device::DeviceTiming;

/// The folder of the suite for any PROFINET IO device, whose `device.yaml` a description of a live device replaces.
pub const ANY_DEVICE: &str = "profinet-io";

/// The folder of the suite for any DP slave, whose `device.yaml` a description of a live slave replaces.
pub const ANY_SLAVE: &str = "dp-slave";

/// The folder of the suite for any DP encoder, which joins that for any slave where a GSD describes an encoder.
pub const ANY_DP_ENCODER: &str = "dp-encoder";

/// The folder of the suite for any encoder of the PROFIdrive encoder profile, of whose `device.yaml` a GSDML replaces sections.
pub const ANY_ENCODER: &str = "profidrive-encoder";

/// The list of a manual's requirements: this file, or several whose names begin so.
pub(super) const REQUIREMENTS: &str = "requirements";
/// The list of the deliberate bugs: this file, or several whose names begin so.
pub(super) const BUGS: &str = "bugs";

/// Whether the file `name` holds the list `list` or a part of it: `bugs`, `bugs-memory`.
pub(super) fn is_part(name: &str, list: &str) -> bool {
    name.strip_prefix(list).is_some_and(|rest| rest.is_empty() || rest.starts_with('-'))
}

/// Whether the file `path` (below `suites`) holds bugs of a manual.
pub(super) fn is_list_of_bugs(path: &str) -> bool {
    path.split_once('/').is_some_and(|(_, file)| is_part(file.trim_end_matches(".yaml"), BUGS))
}

/// The text of all suite files, by their path below the folder `suites`.
#[derive(Clone, Debug)]
pub struct Sources {
    /// What is put in front of a path when it is shown.
    shown: PathBuf,
    files: BTreeMap<String, Cow<'static, str>>,
    pub(super) times: BenchTimes,
    /// Files that stand elsewhere than their path below `suites` says, by that path.
    elsewhere: BTreeMap<String, PathBuf>,
    /// Whether the cases will not be run, so that their steps can be dropped.
    pub(super) is_for_rules: bool,
    /// Manuals that were compiled from these very files, by name.
    compiled: BTreeMap<&'static str, &'static [u8]>,
    /// The sentence of a bug by manual and name, where there is one.
    sentences: fn(&str, &str) -> Option<&'static str>,
    /// Whether the device of the suite for any PROFINET IO device is that of a description.
    pub(super) is_described: bool,
    /// The lists of bugs of manuals that a folder replaced.
    replaced_bugs: Vec<Cow<'static, str>>,
}

/// What a folder added to the suites.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct AddedSuites {
    /// Its manuals.
    pub manuals: Vec<String>,
    /// What it replaced: manuals by name, common suites and personas as `common/NAME` and `personas/NAME`.
    pub replaced: Vec<String>,
}

/// Times of a bench that replace those of the suites.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BenchTimes {
    /// The cycle of connections that say none.
    pub cycle: Option<Duration>,
    /// The watchdog of connections that say none.
    pub watchdog: Option<Duration>,
    /// Times of ours, by name.
    pub ours: Vec<(String, Value)>,
    /// The factor of the times of ours.
    pub patience: Option<u32>,
    /// Tolerances of ours, by name.
    pub tolerances: Vec<(String, Value)>,
}

impl BenchTimes {
    /// Replaces the times of the manual and of the language by those of the bench.
    pub(super) fn apply(&self, timing: &mut DeviceTiming) {
        timing.cycle = self.cycle.unwrap_or(timing.cycle);
        timing.watchdog = self.watchdog.or(timing.watchdog);
        timing.patience = self.patience.unwrap_or(timing.patience);
        for (known, own) in [(&mut timing.ours, &self.ours), (&mut timing.tolerances, &self.tolerances)] {
            for (name, value) in own {
                known.iter_mut().filter(|known| known.name == *name).for_each(|known| known.value = value.clone());
            }
        }
        timing.hold_beyond_reactions();
    }
}

impl Sources {
    /// Suites that are part of a program: the path of each file below `suites`, and its text.
    pub fn of(files: &[(&'static str, &'static str)]) -> Sources {
        let files = files.iter().map(|&(path, text)| (path.to_owned(), Cow::Borrowed(text))).collect();
        Sources { files, ..Sources::none() }
    }

    /// No suites at all; [`Sources::with`] adds files.
    pub fn none() -> Sources {
        Sources {
            shown: PathBuf::from("suites"),
            files: BTreeMap::new(),
            times: BenchTimes::default(),
            elsewhere: BTreeMap::new(),
            is_for_rules: false,
            compiled: BTreeMap::new(),
            sentences: |_, _| None,
            is_described: false,
            replaced_bugs: Vec::new(),
        }
    }

    /// The same suites with what [`compiled::write`](suite::compiled::write) gave for some of their manuals, each with its name.
    ///
    /// These are read instead of the files. A later change to the text of a manual has it compiled again.
    #[must_use]
    pub fn compiled(mut self, manuals: impl IntoIterator<Item = (&'static str, &'static [u8])>) -> Sources {
        self.compiled = manuals.into_iter().collect();
        self
    }

    /// The same suites with the sentences of the bugs, by manual and name: the suites list bugs, the reference devices know what
    /// they are.
    #[must_use]
    pub fn with_sentences(self, sentences: fn(&str, &str) -> Option<&'static str>) -> Sources {
        Sources { sentences, ..self }
    }

    /// The sentence of a bug of a manual; empty if there is none.
    pub(super) fn sentence(&self, manual: &str, bug: &str) -> String {
        (self.sentences)(manual, bug).unwrap_or_default().to_owned()
    }

    /// The bytes of a manual that was compiled from these very files.
    pub(super) fn octets(&self, manual: &str) -> Option<&'static [u8]> {
        self.compiled.get(manual).copied()
    }

    /// The suites in a folder that is laid out as `suites/` of this project is; only files ending in `.yaml` are read.
    ///
    /// Fails if the folder or a file in it cannot be read, or is no UTF-8.
    pub fn folder(path: &Path) -> Result<Sources, LoadErrors> {
        let files = folder::of_suites(path)?;
        let files = files.into_iter().map(|file| (file.path, Cow::Owned(file.text))).collect();
        Ok(Sources { shown: path.to_owned(), files, ..Sources::none() })
    }

    /// The same suites with those of a folder: a folder of suites, or the folder of one manual.
    ///
    /// A manual of a name that there is already is replaced with all of its files; a common suite and a persona are replaced by
    /// name. Fails as [`Sources::folder`] does, and if nothing in the folder is a suite.
    pub fn and_folder(mut self, path: &Path) -> Result<(Sources, AddedSuites), LoadErrors> {
        let files = folder::of_suites_or_manual(path)?;
        let mut added = AddedSuites::default();
        for folder in files.iter().filter_map(|file| file.path.strip_suffix("/device.yaml")) {
            if self.files.contains_key(&format!("{folder}/device.yaml")) {
                added.replaced.push(folder.to_owned());
            }
            // Common suites may name bugs that only the replaced manual lists.
            let (gone, kept) =
                self.files.into_iter().partition(|(path, _)| path.split_once('/').is_some_and(|of| of.0 == folder));
            self.files = kept;
            self.replaced_bugs.extend(gone.into_iter().filter(|(path, _)| is_list_of_bugs(path)).map(|(_, text)| text));
            self.compiled.remove(folder);
            self.forget_users(folder);
            added.manuals.push(folder.to_owned());
        }
        for file in files {
            let folder = file.path.split_once('/').map_or("", |(folder, _)| folder);
            let before = if folder == COMMON || folder == PERSONAS { self.files.get(&file.path) } else { None };
            if before.is_some_and(|before| **before != file.text) {
                added.replaced.push(file.path.trim_end_matches(".yaml").to_owned());
                if folder == COMMON {
                    self.compiled.clear();
                }
            }
            self.elsewhere.insert(file.path.clone(), file.shown);
            self.files.insert(file.path, Cow::Owned(file.text));
        }
        Ok((self, added))
    }

    /// The same suites for a program that judges by their rules and runs no case: the steps of the cases are checked and then dropped,
    /// which takes half the memory.
    #[must_use]
    pub fn for_rules(mut self) -> Sources {
        self.is_for_rules = true;
        self
    }

    /// The same suites with the text of one file replaced or added; `path` is below `suites`, with `/`.
    #[must_use]
    pub fn with(mut self, path: &str, text: impl Into<String>) -> Sources {
        self.files.insert(path.to_owned(), Cow::Owned(text.into()));
        match path.split_once('/') {
            Some((PERSONAS, _)) => {}
            // The bugs of one manual may be named by a common suite that others use.
            Some((folder, file)) if folder != COMMON && !is_part(file.trim_end_matches(".yaml"), BUGS) => {
                self.compiled.remove(folder);
                if file != "device.yaml" {
                    self.forget_users(folder);
                }
            }
            _ => self.compiled.clear(),
        }
        self
    }

    /// Has the manuals compiled again that use the topics of the suite `folder` too.
    fn forget_users(&mut self, folder: &str) {
        let names = |text: &str| text.lines().any(|line| line == "also:") && text.contains(&format!("\n  {folder}:"));
        let users = self.files.iter().filter(|(_, text)| names(text));
        let users: Vec<String> = users.filter_map(|(path, _)| Some(path.split_once('/')?.0.to_owned())).collect();
        users.iter().for_each(|user| {
            self.compiled.remove(user.as_str());
        });
    }

    /// The same suites, shown as if they stood in the folder `shown`.
    #[must_use]
    pub fn shown_in(mut self, shown: &Path) -> Sources {
        self.shown = shown.to_owned();
        self.compiled.clear();
        self
    }

    /// The same suites with one file shown under the path that the user gave.
    pub(super) fn called(mut self, path: &str, shown: &str) -> Sources {
        self.elsewhere.insert(path.to_owned(), PathBuf::from(shown));
        self
    }

    /// The same suites for the device that `text` describes, the text of `file`: it replaces the `device.yaml`
    /// of the suite for any PROFINET IO device, [`ANY_DEVICE`].
    ///
    /// A description is written as every `device.yaml` of PROFINET is; its name may be any. The suite asks it for the modules `data` and `mirror`, the signals
    /// `given` and `mirrored`, the submodule `mirror`, the records `im0` and `im1`, the constant `vendor`, and the faults
    /// `passing` and `standing`; what the device does not have is left out by the bench file. For exchangeable modules and shared
    /// devices it asks for the module and submodule `counter`, the constant `counter_slot`, and the faults `pulled`, `wrong` and
    /// `event`; a module that a device does not have is `absent`.
    #[must_use]
    pub fn with_description(self, file: &Path, text: impl Into<String>) -> Sources {
        self.described(ANY_DEVICE, file, text)
    }

    /// The same suites for the device that `text` describes, the text of `file`: it replaces the `device.yaml` of the folder
    /// `any`, which is [`ANY_DEVICE`], [`ANY_SLAVE`] or [`ANY_ENCODER`].
    #[must_use]
    pub fn described(mut self, any: &str, file: &Path, text: impl Into<String>) -> Sources {
        let path = format!("{any}/device.yaml");
        self.elsewhere.insert(path.clone(), file.to_owned());
        self.is_described = true;
        self.with(&path, text)
    }

    /// The same suites, in which the manual `into` also has the requirements, bugs, cases, rules and procedures of the manual `from`; its
    /// `device.yaml` has to have the names of both. A bug that both list keeps the requirements of `into`.
    #[must_use]
    pub fn joined(mut self, into: &str, from: &str) -> Sources {
        let listed = |line: &str| Some(line.strip_prefix("  ")?.split_once(':')?.0.to_owned());
        let of_folder = |folder: &str| {
            let files =
                self.files.iter().filter(move |(path, _)| path.split_once('/').is_some_and(|of| of.0 == folder));
            files.map(|(path, text)| (path.clone(), text.to_string())).collect::<Vec<_>>()
        };
        let lists = of_folder(into).into_iter().filter(|(path, _)| is_list_of_bugs(path));
        let known: Vec<String> =
            lists.flat_map(|(_, text)| text.lines().filter_map(listed).collect::<Vec<_>>()).collect();
        for (path, text) in of_folder(from) {
            let Some((_, file)) = path.split_once('/').filter(|(_, file)| *file != "device.yaml") else { continue };
            let is_new = |line: &&str| listed(line).is_none_or(|name| !known.contains(&name));
            let text = match is_list_of_bugs(&path) {
                true => text.lines().filter(is_new).fold(String::new(), |text, line| text + line + "\n"),
                false => text,
            };
            let joined = format!("{into}/{file}");
            self.elsewhere.insert(joined.clone(), self.shown.join(&path));
            self = self.with(&joined, text);
        }
        self
    }

    /// The same suites with the times of a bench.
    #[must_use]
    pub fn on_bench(mut self, times: BenchTimes) -> Sources {
        if times != self.times {
            self.compiled.clear();
        }
        self.times = times;
        self
    }

    /// Every file: its path below `suites`, and its text.
    pub fn files(&self) -> impl Iterator<Item = (&str, &str)> {
        self.files.iter().map(|(path, text)| (path.as_str(), text.as_ref()))
    }

    /// The text of each list of bugs, also of manuals that a folder replaced.
    pub(super) fn lists_of_bugs(&self) -> impl Iterator<Item = &str> {
        let listed = self.files().filter(|(path, _)| is_list_of_bugs(path)).map(|(_, text)| text);
        listed.chain(self.replaced_bugs.iter().map(AsRef::as_ref))
    }

    /// The folders that hold a manual: those with a `device.yaml`, in the order of their names.
    pub fn manuals(&self) -> Vec<String> {
        self.files.keys().filter_map(|path| path.strip_suffix("/device.yaml")).map(str::to_owned).collect()
    }

    /// The names (without `.yaml`) of the files in a folder, in order.
    pub(super) fn names_in(&self, folder: &str) -> Vec<String> {
        let name = |path: &String| {
            let (of, name) = path.split_once('/')?;
            (of == folder).then(|| name.strip_suffix(".yaml").map(str::to_owned))?
        };
        self.files.keys().filter_map(name).collect()
    }
}

/// The files that were opened while a manual is loaded; a [`Spot`] names them by number.
#[derive(Clone, Debug, Default)]
pub(super) struct Files(Vec<(Arc<PathBuf>, Cow<'static, str>)>);

impl Files {
    /// Opens `<folder>/<name>.yaml` of `sources`; none if there is no such file.
    pub(super) fn open(&mut self, sources: &Sources, folder: &str, name: &str) -> Option<(u16, Cow<'static, str>)> {
        let path = format!("{folder}/{name}.yaml");
        let text = sources.files.get(&path)?.clone();
        let number = self.0.len();
        let shown = sources.elsewhere.get(&path).cloned().unwrap_or_else(|| sources.shown.join(path));
        self.0.push((Arc::new(shown), text.clone()));
        Some((u16::try_from(number).ok()?, text))
    }

    /// The location of `spot` as the suites store it.
    pub(super) fn location(&self, spot: Spot) -> Location {
        let file = self.0.get(usize::from(spot.file)).map(|(path, _)| Arc::clone(path)).unwrap_or_default();
        Location { file, line: spot.line, column: spot.column }
    }

    /// The mistake with its line.
    fn error(&self, mistake: Mistake) -> LoadError {
        let spot = mistake.spot;
        let text = self.0.get(usize::from(spot.file)).map_or("", |(_, text)| text);
        let line = (spot.line as usize).checked_sub(1).and_then(|line| text.lines().nth(line)).unwrap_or_default();
        LoadError {
            at: self.location(spot),
            width: spot.width.max(1) as usize,
            line: line.to_owned(),
            message: mistake.message,
            help: mistake.help,
        }
    }

    /// All mistakes with their lines.
    pub(super) fn errors(&self, mistakes: &Mistakes) -> LoadErrors {
        LoadErrors(mistakes.take().into_iter().map(|mistake| self.error(mistake)).collect())
    }
}

impl Sources {
    /// The error that there is no such manual, or none at all.
    pub(super) fn no_manual(&self, only: Option<&str>) -> LoadError {
        let known = self.manuals();
        let message = match only {
            Some(name) => format!("there is no manual `{name}`"),
            None => "there is no manual here: no folder has a device.yaml".to_owned(),
        };
        let help = match only.and_then(|name| plain_text::nearest(name, known.iter().map(String::as_str))) {
            Some(meant) => Some(format!("did you mean `{meant}`?")),
            None if known.is_empty() => None,
            None => Some(format!("there are {}", known.join(", "))),
        };
        let at = Location { file: Arc::new(self.shown.clone()), line: 0, column: 0 };
        LoadError { at, width: 0, line: String::new(), message, help }
    }
}
