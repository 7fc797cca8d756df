//! The HTML report as PDF, printed by a headless Chromium or Chrome.

use super::CommandError;
use std::env;
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The names of the browser, the first one that is there is used.
const BROWSERS: [&str; 5] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"];

/// The browser in the search path.
///
/// # Errors
///
/// There is none; the message says what to do.
pub(super) fn browser() -> Result<PathBuf, CommandError> {
    let folders = env::var_os("PATH").unwrap_or_default();
    let found = env::split_paths(&folders)
        .flat_map(|folder| BROWSERS.map(|name| folder.join(name)))
        .find(|program| program.is_file());
    found.ok_or_else(|| {
        CommandError::usage(
            "--report pdf needs Chromium or Chrome in the PATH, which prints the page; install it, or write --report html and print that",
        )
    })
}

/// Prints a page to a file.
pub(super) fn write(page: &str, file: &Path) -> Result<(), CommandError> {
    let failed =
        |why: String| CommandError::bench(format!("the report {} could not be written: {why}", file.display()));
    let folder = env::temp_dir().join(format!("encspec-pdf-{}", std::process::id()));
    fs::create_dir_all(&folder).map_err(|error| failed(error.to_string()))?;
    let result = print(&page.replace("<details", "<details open"), file, &folder);
    // What is left in the temporary folder does not matter to the report.
    let _ = fs::remove_dir_all(&folder);
    result.map_err(failed)
}

fn print(page: &str, file: &Path, folder: &Path) -> Result<(), String> {
    let source = folder.join("report.html");
    fs::write(&source, page).map_err(|error| error.to_string())?;
    let printed = folder.join("report.pdf");
    let program = browser().map_err(|error| error.message)?;
    let mut command = Command::new(&program);
    // The sandbox of Chromium does not work for root; the page is ours, and loads nothing.
    if fs::metadata("/proc/self").is_ok_and(|of| of.uid() == 0) {
        command.arg("--no-sandbox");
    }
    command.args([
        "--headless",
        "--disable-gpu",
        "--no-pdf-header-footer",
        "--no-first-run",
        "--disable-dev-shm-usage",
    ]);
    command.arg(format!("--user-data-dir={}", folder.join("profile").display()));
    command.arg(format!("--print-to-pdf={}", printed.display())).arg(format!("file://{}", source.display()));
    let output = command.stdin(Stdio::null()).output().map_err(|error| format!("{}: {error}", program.display()))?;
    let octets = fs::read(&printed).ok().filter(|octets| octets.starts_with(b"%PDF"));
    let said = String::from_utf8_lossy(&output.stderr);
    let octets = octets.ok_or_else(|| {
        let last = said.lines().last().unwrap_or("it said nothing");
        format!("{} printed no PDF ({}): {}", program.display(), output.status, plain_text::printable(last))
    })?;
    fs::write(file, octets).map_err(|error| error.to_string())
}
