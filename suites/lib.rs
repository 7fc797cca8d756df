//! The shipped suites, and the descriptions of the reference devices, as the binary carries them.
//!
//! The build script has compiled the suites ([`suite::compiled`]), and a manual is read when it is asked for. The texts are here
//! too, for whoever changes one of them. This crate must not know what stands in them: [`suite`] reads the suites, [`description`]
//! the descriptions.

mod shipped;
#[cfg(test)]
mod tests;

use description::gsdml::{Gsdml, best_described};
use shipped::Shipped;
use std::sync::LazyLock;
use suite_yaml::Sources;

static SHIPPED: LazyLock<Shipped<'static>> = LazyLock::new(|| {
    let octets = include_bytes!(concat!(env!("OUT_DIR"), "/shipped"));
    postcard::from_bytes(octets).expect("what the build script of this crate has written")
});

/// The shipped suites, compiled; what is made of them has the places of its parts in `suites/`.
pub fn sources() -> Sources {
    Sources::of(&SHIPPED.suites).compiled(SHIPPED.manuals.iter().copied())
}

/// The GSDML files of the reference devices: `<manual>/<file>` and the text.
pub fn gsdml() -> &'static [(&'static str, &'static str)] {
    &SHIPPED.gsdml
}

/// The GSD files of the reference devices: `<manual>/<file>` and the text.
pub fn gsd() -> &'static [(&'static str, &'static str)] {
    &SHIPPED.gsd
}

/// The GSDML of the reference device of a manual and variant: the name of the file and what it says; none: there is none.
pub fn gsdml_for(manual: &str, variant: &str) -> Option<(&'static str, Gsdml)> {
    let of_manual = gsdml().iter().filter_map(|&(path, text)| {
        let (folder, name) = path.split_once('/')?;
        (folder == manual).then_some((name, text))
    });
    best_described(of_manual, variant)
}
