//! Where the manuals and the captures of strangers are looked for.
//!
//! They are other people's work and stay outside the checkout; what needs them says so and does without.

use std::env;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// The folder with the manuals and the captures of strangers, or `None` where this machine has none.
///
/// `ENCSPEC_SHARED` names it; without that variable it is the folder `shared` beside the checkout. A variable that
/// names no folder counts as absent: it is never silently replaced by the folder beside the checkout.
pub fn shared() -> Option<PathBuf> {
    let folder = match env::var_os("ENCSPEC_SHARED") {
        Some(named) => PathBuf::from(named),
        None => Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared"),
    };
    folder.is_dir().then_some(folder)
}

/// The file `name` of the folder [`shared`] (for instance `captures/profinet/one-ar-life.pcapng`) for a test.
///
/// Where it is absent the reason is written to standard error, past the test runner's capture of output, so that a
/// test which then returns early is visibly skipped.
pub fn shared_file(name: &str) -> Option<PathBuf> {
    let why = match shared() {
        None => "there is no folder ../shared beside the checkout and ENCSPEC_SHARED names none".to_string(),
        Some(folder) => {
            let file = folder.join(name);
            if file.exists() {
                return Some(file);
            }
            format!("{} is not there", file.display())
        }
    };
    // In one piece, as tests run side by side. A standard error that cannot be written to leaves nobody to tell.
    let _ = io::stderr().write_all(format!("skipped: {name} is needed, {why}\n").as_bytes());
    None
}
