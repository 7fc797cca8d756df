//! The GSDML files of the reference devices, which the binary carries.

use super::{Gsdml, places, read};

include!(concat!(env!("OUT_DIR"), "/embedded_gsdml.rs"));

/// The GSDML files of the reference devices: `<manual>/<file>` and the text.
pub fn embedded() -> &'static [(&'static str, &'static str)] {
    EMBEDDED_GSDML
}

/// The GSDML of the reference device of a manual and variant: the name of the file and what it says; none: there is none.
pub fn embedded_for(manual: &str, variant: &str) -> Option<(&'static str, Gsdml)> {
    let of_manual: Vec<(&'static str, Gsdml)> = embedded()
        .iter()
        .filter_map(|(path, text)| {
            let (folder, name) = path.split_once('/')?;
            (folder == manual).then(|| Some((name, read(text).ok()?)))?
        })
        .collect();
    let only = of_manual.len() == 1;
    let like = |gsdml: &Gsdml| places::called_like(gsdml, variant).or(only.then_some(0));
    let likest = of_manual.iter().filter_map(|(_, gsdml)| like(gsdml)).max()?;
    of_manual.into_iter().find(|(_, gsdml)| like(gsdml) == Some(likest))
}
