//! The files of a suite; the first byte says which.
#![no_main]

use encspec_fuzz::PROFINET;
use std::sync::LazyLock;
use suite_yaml::Checker;

const FILES: [&str; 8] = ["device", "requirements", "bugs", "rules", "preset", "procedures", "masks", "parking"];

static CHECKER: LazyLock<Checker> =
    LazyLock::new(|| Checker::unchecked(&suites::sources(), PROFINET).unwrap_or_else(|errors| panic!("{errors}")));

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let Some((which, text)) = data.split_first() else { return };
    let text = String::from_utf8_lossy(text);
    let file = FILES[usize::from(*which) % FILES.len()];
    if let Err(errors) = CHECKER.check(&format!("{PROFINET}/{file}.yaml"), &text) {
        assert!(!errors.to_string().is_empty());
    }
});
