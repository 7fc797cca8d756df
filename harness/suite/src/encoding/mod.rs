//! Helpers to encode manuals: types without serde, shared file names, and the steps of trials, which are stored separately.

mod context;
mod serde_types;

pub(crate) use context::{EncodingContext, SharedLists, file, put_steps, reading, shared, writing};
pub(crate) use serde_types::{baud, mac};
