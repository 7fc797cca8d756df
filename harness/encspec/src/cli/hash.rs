//! SHA-256 of files and suites, as reports have them.

use sha2::{Digest, Sha256};
use std::fs::File;
use std::io;
use std::path::Path;
use suite_yaml::Sources;

/// The hash of a file.
pub(super) fn sha256_of_file(path: &Path) -> io::Result<String> {
    let mut hash = Sha256::new();
    io::copy(&mut File::open(path)?, &mut hash)?;
    Ok(text(hash))
}

/// The hash of the files in a folder of suites: path, length and text of each, in the order of the paths.
pub(super) fn sha256_of_suite(sources: &Sources, folder: &str) -> String {
    let mut hash = Sha256::new();
    for (path, file) in sources.files() {
        if path.split_once('/').is_some_and(|(of, _)| of == folder) {
            hash.update(format!("{path}\0{}\0", file.len()));
            hash.update(file);
        }
    }
    text(hash)
}

fn text(hash: Sha256) -> String {
    hash.finalize().iter().map(|octet| format!("{octet:02x}")).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_hash_of_the_standard() {
        // FIPS 180-4, the example "abc" of one block.
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        let folder = testing::Folder::new("hash");
        assert_eq!(super::sha256_of_file(&folder.write("abc", "abc")).ok().as_deref(), Some(expected));
    }
}
