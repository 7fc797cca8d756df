//! Bench files.
#![no_main]

use results::bench_file;
use std::path::PathBuf;
use std::sync::LazyLock;

static FILE: LazyLock<PathBuf> =
    LazyLock::new(|| std::env::temp_dir().join(format!("encspec-fuzz-{}.yaml", std::process::id())));

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    std::fs::write(&*FILE, data).expect("a folder for temporary files");
    match bench_file::read(&FILE, &encspec_fuzz::MANUALS) {
        Ok(bench) => drop(std::hint::black_box(bench)),
        Err(errors) => assert!(!errors.to_string().is_empty()),
    }
});
