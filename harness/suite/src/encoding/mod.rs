//! What the parts of a manual are written and read by as octets: values that serde does not know, names of files that many parts
//! share, and the steps of trials, which stand apart.
//!
//! This must not know what a manual consists of.

mod context;
mod plain;

pub(crate) use context::{Lists, Shared, file, put_steps, reading, shared, writing};
pub(crate) use plain::{baud, mac};
