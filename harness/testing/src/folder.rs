//! Places for the files of one test, and the folder that all of this project is in.

use std::fs;
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicU32, Ordering};

/// The checkout.
pub fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A path for `name` that nobody else uses, neither in this process nor in another; it is short enough for a socket, whose path has
/// at most 107 octets.
pub fn unused_path(name: &str) -> PathBuf {
    static NUMBER: AtomicU32 = AtomicU32::new(0);
    let number = NUMBER.fetch_add(1, Ordering::Relaxed);
    std::env::temp_dir().join(format!("encspec-{}-{number}-{name}", process::id()))
}

/// A new folder that nobody else uses, neither in this process nor in another; it goes with this.
pub struct Folder {
    path: PathBuf,
}

impl Folder {
    /// A folder for what `name` says.
    ///
    /// # Panics
    ///
    /// If it cannot be made.
    pub fn new(name: &str) -> Folder {
        let path = unused_path(name);
        // What is left of a process that had the same number and was ended.
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).expect("a folder for the test");
        Folder { path }
    }

    /// Writes a file, with the folders above it, and gives its path.
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

impl Deref for Folder {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.path
    }
}

impl AsRef<Path> for Folder {
    fn as_ref(&self) -> &Path {
        &self.path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // What cannot be taken away stays in the folder of the machine for such files.
        let _ = fs::remove_dir_all(&self.path);
    }
}

#[test]
fn no_two_paths_are_the_same() {
    assert_ne!(unused_path("line"), unused_path("line"));
}

#[test]
fn a_folder_is_empty_and_goes_with_its_test() {
    let folder = Folder::new("folder");
    let path = folder.to_path_buf();
    assert_eq!(fs::read_dir(&path).expect("it is there").count(), 0);
    let file = folder.write("below/it.txt", "text");
    assert_eq!(fs::read_to_string(file).expect("it was written"), "text");
    drop(folder);
    assert!(!path.exists());
}
