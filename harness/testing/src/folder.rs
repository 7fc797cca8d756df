//! Temporary folders for tests, and the path of the checkout.

use std::fs;
use std::path::{Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicU32, Ordering};

/// The path of the checkout.
pub fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A path for `name` that no other test uses, in this process or another.
///
/// It is short enough for a Unix socket, whose path has at most 107 bytes.
pub fn unused_path(name: &str) -> PathBuf {
    static NUMBER: AtomicU32 = AtomicU32::new(0);
    let number = NUMBER.fetch_add(1, Ordering::Relaxed);
    std::env::temp_dir().join(format!("encspec-{}-{number}-{name}", process::id()))
}

/// A new folder that no other test uses, in this process or another. It is removed on drop.
pub struct Folder {
    path: PathBuf,
}

impl Folder {
    /// Creates a folder whose name ends in `name`.
    ///
    /// # Panics
    ///
    /// If it cannot be created.
    pub fn new(name: &str) -> Folder {
        let path = unused_path(name);
        // A process with the same number that was killed may have left one.
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).expect("a folder for the test");
        Folder { path }
    }

    /// The path of the folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The path of `name` in the folder.
    pub fn join(&self, name: impl AsRef<Path>) -> PathBuf {
        self.path.join(name)
    }

    /// Writes a file and creates the folders above it. Returns its path.
    ///
    /// # Panics
    ///
    /// If it cannot be written.
    pub fn write(&self, file: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path.join(file);
        fs::create_dir_all(path.parent().unwrap_or(&self.path)).expect("a folder for the test");
        fs::write(&path, content).expect("a file for the test");
        path
    }
}

impl AsRef<Path> for Folder {
    fn as_ref(&self) -> &Path {
        &self.path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // What cannot be removed stays in the system's folder for temporary files.
        let _ = fs::remove_dir_all(&self.path);
    }
}

#[test]
fn paths_are_unique() {
    assert_ne!(unused_path("line"), unused_path("line"));
}

#[test]
fn a_folder_starts_empty_and_is_removed_on_drop() {
    let folder = Folder::new("folder");
    let path = folder.path().to_owned();
    assert_eq!(fs::read_dir(&path).expect("the folder exists").count(), 0);
    let file = folder.write("below/it.txt", "text");
    assert_eq!(fs::read_to_string(file).expect("it was written"), "text");
    drop(folder);
    assert!(!path.exists());
}
