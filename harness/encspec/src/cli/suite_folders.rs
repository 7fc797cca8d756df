//! `--suites`: folders with suites that are added to the built-in ones.

use super::{CommandError, print_message};
use clap::Args;
use std::path::PathBuf;
use std::sync::{Arc, Once};
use suite::model::Manual;
use suite::persona::Persona;
use suite_yaml::persona::{load_personas, named_persona};
use suite_yaml::{LoadErrors, Sources, load, load_some};

/// A folder is read several times in one run, and what it replaces is printed the first time.
static PRINTED: Once = Once::new();

/// Where the suites come from.
#[derive(Clone, Debug, Default, Args)]
pub struct Suites {
    /// Add the suites in this folder, or the one manual whose folder it is, to the built-in ones; a manual of the same name
    /// replaces the built-in one; may be repeated
    #[arg(long = "suites", value_name = "DIR")]
    pub folders: Vec<PathBuf>,
}

impl Suites {
    /// The text of the built-in suites and of those in the folders. Prints to standard error what a folder replaces.
    pub(super) fn sources(&self) -> Result<Sources, LoadErrors> {
        let mut sources = suites::sources();
        let mut replaced = Vec::new();
        for folder in &self.folders {
            let (more, added) = sources.and_folder(folder)?;
            sources = more;
            if !added.replaced.is_empty() {
                replaced.push(format!("{} replaces {}", folder.display(), added.replaced.join(", ")));
            }
        }
        PRINTED.call_once(|| replaced.iter().for_each(|line| print_message(line)));
        Ok(sources.with_sentences(deviations::sentence))
    }

    /// The names of the manuals in the folders.
    pub(super) fn own(&self) -> Result<Vec<String>, LoadErrors> {
        let added = self.folders.iter().map(|folder| Ok(Sources::none().and_folder(folder)?.1.manuals));
        Ok(added.collect::<Result<Vec<_>, LoadErrors>>()?.concat())
    }

    /// Loads every manual.
    pub fn load(&self) -> Result<Vec<Manual>, LoadErrors> {
        load(&self.sources()?, None)
    }

    /// Loads the manuals that `duts` name. Loads every manual unless each of `duts` is a reference device of a built-in suite.
    pub(super) fn load_for(&self, duts: &[String]) -> Result<Vec<Manual>, LoadErrors> {
        let sources = self.sources()?;
        let known = sources.manuals();
        let named = |dut: &String| {
            let name = dut.strip_prefix("model:")?;
            let name = name.split_once('/').map_or(name, |(name, _)| name);
            known.iter().find(|known| *known == name).map(String::as_str)
        };
        match duts.iter().map(named).collect::<Option<Vec<&str>>>() {
            // With `--suites` everything is loaded, so that errors in any file of the folder are reported.
            Some(names) if !names.is_empty() && self.folders.is_empty() => load_some(&sources, &names),
            _ => load(&sources, None),
        }
    }

    /// Loads every persona.
    pub fn personas(&self) -> Result<Vec<Persona>, LoadErrors> {
        load_personas(&self.sources()?)
    }

    /// The persona with this name; an unknown name is a usage error.
    pub fn persona(&self, name: &str) -> Result<Arc<Persona>, CommandError> {
        Ok(Arc::new(named_persona(self.personas()?, name).map_err(CommandError::usage)?))
    }

    pub(super) fn load_one(&self, manual: Option<&str>) -> Result<Vec<Manual>, CommandError> {
        Ok(load(&self.sources()?, manual)?)
    }
}
