//! Compiles the suites, so that an installed `encspec` works anywhere and starts without reading YAML.
//!
//! A mistake in a suite ends the build with the message that `encspec check suites` has for it.

mod shipped;

use shipped::Shipped;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::{env, fs, io};
use suite::compiled;
use suite_yaml::persona::load_personas;
use suite_yaml::{Sources, load};

fn main() -> ExitCode {
    match build() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn build() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=.");
    let variable = |name: &str| env::var_os(name).map(PathBuf::from).ok_or(format!("{name} is not set"));
    let here = variable("CARGO_MANIFEST_DIR")?;
    // Places are shown as they are in a checkout, whatever the folder is called where this is built.
    let sources = Sources::folder(&here)?.shown_in(Path::new("suites"));
    load_personas(&sources)?;
    let mut manuals = Vec::new();
    for manual in load(&sources, None)? {
        manuals.push((manual.device.name.clone(), compiled::write(&manual)?));
    }
    let (gsdml, gsd) = (texts(&here, "xml")?, texts(&here, "gsd")?);
    let shipped = Shipped {
        suites: sources.files().collect(),
        gsdml: gsdml.iter().map(|(path, text)| (path.as_str(), text.as_str())).collect(),
        gsd: gsd.iter().map(|(path, text)| (path.as_str(), text.as_str())).collect(),
        manuals: manuals.iter().map(|(name, octets)| (name.as_str(), octets.as_slice())).collect(),
    };
    fs::write(variable("OUT_DIR")?.join("shipped"), postcard::to_stdvec(&shipped)?)?;
    Ok(())
}

/// Path and text of each file that ends in `end`, in order.
fn texts(here: &Path, end: &str) -> io::Result<Vec<(String, String)>> {
    let mut texts = Vec::new();
    for folder in sorted(here)?.into_iter().filter(|path| path.is_dir()) {
        for file in sorted(&folder)?.into_iter().filter(|file| file.extension().is_some_and(|of| of == end)) {
            let path = file.strip_prefix(here).unwrap_or(&file).to_string_lossy().replace('\\', "/");
            texts.push((path, fs::read_to_string(file)?));
        }
    }
    Ok(texts)
}

fn sorted(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut paths = fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<_>>>()?;
    paths.sort();
    Ok(paths)
}
