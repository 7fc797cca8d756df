//! The shipped suites, and the descriptions of the reference devices, as the binary carries them.
//!
//! This crate must not know what stands in them: [`suite`] reads the suites, [`description`] the descriptions.

use description::gsdml::{Gsdml, likest};
use suite::Sources;

include!(concat!(env!("OUT_DIR"), "/embedded.rs"));

/// The shipped suites.
pub fn sources() -> Sources {
    Sources::of(SUITES)
}

/// The GSDML files of the reference devices: `<manual>/<file>` and the text.
pub fn gsdml() -> &'static [(&'static str, &'static str)] {
    GSDML
}

/// The GSD files of the reference devices: `<manual>/<file>` and the text.
pub fn gsd() -> &'static [(&'static str, &'static str)] {
    GSD
}

/// The GSDML of the reference device of a manual and variant: the name of the file and what it says; none: there is none.
pub fn gsdml_for(manual: &str, variant: &str) -> Option<(&'static str, Gsdml)> {
    let of_manual = GSDML.iter().filter_map(|&(path, text)| {
        let (folder, name) = path.split_once('/')?;
        (folder == manual).then_some((name, text))
    });
    likest(of_manual, variant)
}
