//! The blocks in RPC calls: type, length, version, then the fields.

pub mod connect;
pub mod control;
pub mod identification;
pub mod im;
pub mod module_diff;
pub mod physical;
pub mod record;

mod header;
pub use header::{BlockHeader, BlockType, RawBlock};
