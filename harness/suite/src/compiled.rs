//! Manuals as octets: what the loader hands on, written where the suites are built in and read where they are used.
//!
//! A manual without the steps of its trials is small and is read as a whole. The steps of a trial are read when somebody asks for
//! them: they are nine tenths of a manual, and no listing needs them. The octets are of the very build that reads them, so
//! nothing here is a format that others could rely on.

use super::encoding::{Lists, Shared, reading, writing};
use super::model::Manual;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// What stands in front of a manual.
#[derive(Deserialize, Serialize)]
struct Head {
    lists: Lists,
    /// How long the manual is, in octets; behind it stand the steps of its trials.
    length: usize,
}

/// The octets of a manual; the same manual gives the same octets.
///
/// Fails only if something in the manual cannot be written as octets.
pub fn write(manual: &Manual) -> Result<Vec<u8>, postcard::Error> {
    let (octets, lists, steps) = writing(|| postcard::to_stdvec(manual));
    let octets = octets?;
    let mut out = postcard::to_stdvec(&Head { lists, length: octets.len() })?;
    out.extend(octets);
    out.extend(steps);
    Ok(out)
}

/// The manual of these octets.
///
/// Fails if they are not what [`write()`] of the same build gave.
pub fn read(octets: &'static [u8]) -> Result<Manual, postcard::Error> {
    let (head, rest) = postcard::take_from_bytes::<Head>(octets)?;
    let (manual, steps) = rest.split_at_checked(head.length).ok_or(postcard::Error::DeserializeUnexpectedEnd)?;
    let shared = Arc::new(Shared { lists: head.lists, steps });
    reading(&shared, || postcard::from_bytes(manual))
}
