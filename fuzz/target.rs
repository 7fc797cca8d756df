//! One target of libFuzzer: the one that this program is called after; `every` is the one that `ENCSPEC_FUZZ` names.
#![no_main]

use std::sync::LazyLock;

static TARGET: LazyLock<fn(&[u8])> = LazyLock::new(|| {
    let named = std::env::var("ENCSPEC_FUZZ").ok().filter(|_| env!("CARGO_BIN_NAME") == "every");
    let name = named.as_deref().unwrap_or(env!("CARGO_BIN_NAME"));
    encspec_fuzz::target(name).unwrap_or_else(|| panic!("ENCSPEC_FUZZ names no target: {name}"))
});

libfuzzer_sys::fuzz_target!(|data: &[u8]| TARGET(data));
