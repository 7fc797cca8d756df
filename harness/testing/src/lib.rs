//! Helpers shared by the tests of all crates. Nothing that is shipped depends on this crate.
//!
//! It depends on no other crate of this workspace, so that every one of them can use it in its tests.

mod captures;
mod folder;
mod golden;
mod robustness;
mod sample;
mod skip;
pub mod stall;

pub use captures::{packets, shared};
pub use folder::{Folder, unused_path, workspace};
pub use golden::{golden, hex};
pub use robustness::every_prefix_and_flip;
pub use sample::DailySample;
pub use skip::{available, skip};
