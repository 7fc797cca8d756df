//! The shipped suites, loaded once for all tests.

use encspec::engine::{DutKind, DutSpec};
use encspec::suite::model::{Manual, Variant};
use encspec::suite_yaml::load;
use std::slice;
use std::sync::LazyLock;

static MANUALS: LazyLock<Vec<Manual>> = LazyLock::new(|| {
    load(&suites::sources(), None).unwrap_or_else(|errors| panic!("{} mistakes\n{errors}", errors.0.len()))
});

/// All manuals.
pub fn manuals() -> &'static [Manual] {
    &MANUALS
}

/// One of them.
pub fn manual(name: &str) -> &'static Manual {
    MANUALS.iter().find(|manual| manual.device.name == name).unwrap_or_else(|| panic!("{name} is not shipped"))
}

/// One of them, for what takes several.
pub fn only(name: &str) -> &'static [Manual] {
    slice::from_ref(manual(name))
}

/// The built-in reference device of a variant with these deviations.
pub fn model(manual: &Manual, variant: &Variant, deviations: &[&str]) -> DutSpec {
    let deviations = deviations.iter().map(|name| (*name).to_owned()).collect();
    DutSpec { manual: manual.device.name.clone(), variant: variant.name.clone(), kind: DutKind::Model { deviations } }
}
