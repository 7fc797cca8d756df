//! Helpers to encode manuals: types without serde, shared file names, and the steps of trials, which are stored separately.

mod context;
mod plain;

pub(crate) use context::{Lists, Shared, file, put_steps, reading, shared, writing};
pub(crate) use plain::{baud, mac};
