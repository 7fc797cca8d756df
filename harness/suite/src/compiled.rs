//! Encodes manuals as bytes at build time and decodes the built-in suites at run time.
//!
//! A manual is decoded as a whole, except for the steps of its trials: these are nine tenths of it and are decoded on first use,
//! since listings do not need them. The bytes are read by the same build that wrote them; the format is not stable.

use super::encoding::{EncodingContext, SharedLists, reading, writing};
use super::model::Manual;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The header of an encoded manual.
#[derive(Deserialize, Serialize)]
struct ManualHeader {
    lists: SharedLists,
    /// Length of the manual in bytes; the steps of its trials follow it.
    length: usize,
}

/// Encodes a manual; the result is deterministic.
///
/// Fails only if the manual contains a value that cannot be encoded.
pub fn write(manual: &Manual) -> Result<Vec<u8>, postcard::Error> {
    let (octets, lists, steps) = writing(|| postcard::to_stdvec(manual));
    let octets = octets?;
    let mut out = postcard::to_stdvec(&ManualHeader { lists, length: octets.len() })?;
    out.extend(octets);
    out.extend(steps);
    Ok(out)
}

/// Decodes a manual.
///
/// Fails if the bytes were not written by [`write()`] of the same build.
pub fn read(octets: &'static [u8]) -> Result<Manual, postcard::Error> {
    let (head, rest) = postcard::take_from_bytes::<ManualHeader>(octets)?;
    let (manual, steps) = rest.split_at_checked(head.length).ok_or(postcard::Error::DeserializeUnexpectedEnd)?;
    let shared = Arc::new(EncodingContext { lists: head.lists, steps });
    reading(&shared, || postcard::from_bytes(manual))
}
