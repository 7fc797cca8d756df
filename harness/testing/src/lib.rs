//! What the tests of all crates share; nothing that is shipped depends on it.
//!
//! It must not know any crate of ours, so that each of them can be tested with it.

mod captures;
mod folder;
mod golden;
pub mod patience;
mod sample;
mod skip;
mod torture;

pub use captures::{packets, shared};
pub use folder::{Folder, unused_path, workspace};
pub use golden::{golden, hex};
pub use sample::Sample;
pub use skip::{available, skip};
pub use torture::every_prefix_and_flip;
