//! Puts the suites into the binary, so that an installed `encspec` works anywhere.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs, io};

fn main() -> io::Result<()> {
    let variable = |name: &str| env::var_os(name).map(PathBuf::from).ok_or(io::ErrorKind::NotFound);
    let suites = variable("CARGO_MANIFEST_DIR")?.join("../../suites").canonicalize()?;
    let mut list =
        String::from("/// Path below `suites` and text of each file.\nstatic EMBEDDED: &[(&str, &str)] = &[\n");
    let mut gsdml =
        String::from("/// Path below `suites` and text of each GSDML.\nstatic EMBEDDED_GSDML: &[(&str, &str)] = &[\n");
    let mut gsd =
        String::from("/// Path below `suites` and text of each GSD.\nstatic EMBEDDED_GSD: &[(&str, &str)] = &[\n");
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
    for (list, name) in [(list, "embedded.rs"), (gsdml, "embedded_gsdml.rs"), (gsd, "embedded_gsd.rs")] {
        fs::write(variable("OUT_DIR")?.join(name), list + "];\n")?;
    }
    Ok(())
}

fn sorted(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut paths = fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<_>>>()?;
    paths.sort();
    Ok(paths)
}
