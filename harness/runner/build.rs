//! Puts the suites into the binary, so that an installed `encspec` works anywhere.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn main() -> io::Result<()> {
    let variable = |name: &str| env::var_os(name).map(PathBuf::from).ok_or(io::ErrorKind::NotFound);
    let suites = variable("CARGO_MANIFEST_DIR")?.join("../../suites").canonicalize()?;
    let mut list =
        String::from("/// Path below `suites` and text of each file.\nstatic EMBEDDED: &[(&str, &str)] = &[\n");
    println!("cargo::rerun-if-changed={}", suites.display());
    for folder in sorted(&suites)?.into_iter().filter(|path| path.is_dir()) {
        println!("cargo::rerun-if-changed={}", folder.display());
        for file in sorted(&folder)?.into_iter().filter(|path| path.extension().is_some_and(|end| end == "yaml")) {
            let below = file.strip_prefix(&suites).unwrap_or(&file).to_string_lossy().replace('\\', "/");
            // Writing into a String cannot fail.
            let _ = writeln!(list, "    ({below:?}, include_str!({:?})),", file.display().to_string());
        }
    }
    list.push_str("];\n");
    fs::write(variable("OUT_DIR")?.join("embedded.rs"), list)
}

fn sorted(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut paths = fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<_>>>()?;
    paths.sort();
    Ok(paths)
}
