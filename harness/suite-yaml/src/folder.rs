//! Reads the files of a folder of suites, or of the folder of one manual.
//!
//! This module knows names of files and folders, not what is in them.

use super::error::{LoadError, LoadErrors};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use suite::Location;

/// The folder of what manuals share.
pub(super) const COMMON: &str = "common";
/// The folder of the personas.
pub(super) const PERSONAS: &str = "personas";

/// A file of a folder of suites.
pub(super) struct SuiteFile {
    /// Its path below the folder of suites.
    pub path: String,
    /// Its path as messages show it.
    pub shown: PathBuf,
    pub text: String,
}

fn failed(path: &Path, error: &io::Error) -> LoadErrors {
    stray(path, &error.to_string())
}

fn stray(path: &Path, message: &str) -> LoadErrors {
    let at = Location { file: Arc::new(path.to_owned()), line: 0, column: 0 };
    LoadErrors(vec![LoadError { at, width: 0, line: String::new(), message: message.to_owned(), help: None }])
}

fn list(folder: &Path) -> Result<Vec<PathBuf>, LoadErrors> {
    let entries = fs::read_dir(folder).map_err(|error| failed(folder, &error))?;
    let paths: Result<Vec<PathBuf>, io::Error> = entries.map(|entry| Ok(entry?.path())).collect();
    paths.map_err(|error| failed(folder, &error))
}

fn name(path: &Path) -> Option<String> {
    path.file_name().map(|name| name.to_string_lossy().into_owned())
}

/// The files of each manual in a folder of suites, of its common suites and of its personas.
pub(super) fn of_suites(path: &Path) -> Result<Vec<SuiteFile>, LoadErrors> {
    let mut files = Vec::new();
    for folder in list(path)?.into_iter().filter(|path| path.is_dir()) {
        let Some(called) = name(&folder) else { continue };
        if ![COMMON, PERSONAS].contains(&called.as_str()) && !folder.join("device.yaml").is_file() {
            return Err(stray(
                &folder,
                "a folder of suites needs a `device.yaml`; without it nothing in the folder is read",
            ));
        }
        files.extend(of_folder(&folder, &called)?);
    }
    Ok(files)
}

/// The same, or the files of one manual if the folder itself is that of a manual, with the common suites beside it; a folder
/// without either is refused.
pub(super) fn of_suites_or_manual(path: &Path) -> Result<Vec<SuiteFile>, LoadErrors> {
    if path.join("device.yaml").is_file() {
        let real = path.canonicalize().map_err(|error| failed(path, &error))?;
        let mut files = of_folder(path, &name(&real).unwrap_or_default())?;
        let beside = real.parent().map(|above| above.join(COMMON)).filter(|folder| has_common_suites(folder));
        if let Some(folder) = beside {
            let written = path.with_file_name(COMMON);
            let is_same =
                written.canonicalize().is_ok_and(|written| folder.canonicalize().is_ok_and(|real| real == written));
            let shown = if is_same { written } else { folder };
            files.extend(of_folder(&shown, COMMON)?);
        }
        return Ok(files);
    }
    let files = of_suites(path)?;
    match files.is_empty() {
        true => Err(stray(
            path,
            "there is no suite here: no folder has a `device.yaml`, and there are no common suites or personas",
        )),
        false => Ok(files),
    }
}

/// Whether the folder has a common suite; any folder may be called `common`.
fn has_common_suites(folder: &Path) -> bool {
    let is_one = |file: &PathBuf| {
        let text = file.extension().filter(|end| *end == "yaml").and_then(|_| fs::read_to_string(file).ok());
        text.is_some_and(|text| text.lines().any(|line| line.starts_with("common:")))
    };
    folder.is_dir() && list(folder).is_ok_and(|files| files.iter().any(is_one))
}

/// The files in the folder of a manual or of what manuals share, which is called `called` below the folder of suites.
fn of_folder(folder: &Path, called: &str) -> Result<Vec<SuiteFile>, LoadErrors> {
    let mut files = Vec::new();
    for file in list(folder)? {
        match file.extension().and_then(|end| end.to_str()) {
            _ if file.is_dir() => return Err(stray(&file, "folders inside the folder of a manual are not read")),
            Some("yaml") => {}
            Some("xml" | "gsd" | "md") => continue,
            _ => return Err(stray(&file, "only files that end in `.yaml` are read here; rename it or take it away")),
        }
        let text = fs::read_to_string(&file).map_err(|error| failed(&file, &error))?;
        if let Some(name) = name(&file) {
            files.push(SuiteFile { path: format!("{called}/{name}"), shown: file, text });
        }
    }
    Ok(files)
}
