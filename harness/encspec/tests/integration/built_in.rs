//! The built-in suites, loaded once for all tests.

use encspec::engine::{DutKind, DutSpec};
use encspec::suite::model::{Manual, SuiteVariant};
use encspec::suite_yaml::load;
use std::slice;
use std::sync::LazyLock;

static MANUALS: LazyLock<Vec<Manual>> = LazyLock::new(|| {
    load(&suites::sources(), None).unwrap_or_else(|errors| panic!("{} errors\n{errors}", errors.0.len()))
});

/// All built-in manuals.
pub fn manuals() -> &'static [Manual] {
    &MANUALS
}

/// The manual with this name.
pub fn manual(name: &str) -> &'static Manual {
    MANUALS
        .iter()
        .find(|manual| manual.device.name == name)
        .unwrap_or_else(|| panic!("there is no built-in suite {name}"))
}

/// The manual with this name, as a slice.
pub fn only(name: &str) -> &'static [Manual] {
    slice::from_ref(manual(name))
}

/// The reference device of a variant with these deviations.
pub fn model(manual: &Manual, variant: &SuiteVariant, deviations: &[&str]) -> DutSpec {
    let deviations = deviations.iter().map(|name| (*name).to_owned()).collect();
    DutSpec { manual: manual.device.name.clone(), variant: variant.name.clone(), kind: DutKind::Model { deviations } }
}
