//! Puts the suites into the binary, so that an installed `encspec` works anywhere.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn main() -> io::Result<()> {
    let variable = |name: &str| env::var_os(name).map(PathBuf::from).ok_or(io::ErrorKind::NotFound);
    let suites = variable("CARGO_MANIFEST_DIR")?.canonicalize()?;
    let mut list = String::from(
        "/// Path and text of each file of a suite.
static SUITES: &[(&str, &str)] = &[
",
    );
    let mut gsdml = String::from(
        "/// Path and text of each GSDML.
static GSDML: &[(&str, &str)] = &[
",
    );
    let mut gsd = String::from(
        "/// Path and text of each GSD.
static GSD: &[(&str, &str)] = &[
",
    );
    println!("cargo::rerun-if-changed={}", suites.display());
    for folder in sorted(&suites)?.into_iter().filter(|path| path.is_dir()) {
        println!("cargo::rerun-if-changed={}", folder.display());
        for file in sorted(&folder)? {
            let list = match file.extension().and_then(|end| end.to_str()) {
                Some("yaml") => &mut list,
                Some("xml") => &mut gsdml,
                Some("gsd") => &mut gsd,
                _ => continue,
            };
            let below = file.strip_prefix(&suites).unwrap_or(&file).to_string_lossy().replace('\\', "/");
            // Writing into a String cannot fail.
            let _ = writeln!(list, "    ({below:?}, include_str!({:?})),", file.display().to_string());
        }
    }
    fs::write(
        variable("OUT_DIR")?.join("embedded.rs"),
        [list, gsdml, gsd]
            .map(|list| {
                list + "];
"
            })
            .concat(),
    )?;
    Ok(())
}

fn sorted(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut paths = fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<_>>>()?;
    paths.sort();
    Ok(paths)
}
