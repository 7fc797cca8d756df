//! Thread-local context while a manual is encoded or decoded: shared values and the steps of its trials.

use expression::WordTable;
use expression::pool::{Pool, TABLES};
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::path::PathBuf;
use std::sync::Arc;

/// Values that parts of a manual share, by number.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(crate) struct SharedLists {
    files: Arc<[Arc<PathBuf>]>,
    tables: Arc<[Arc<WordTable>]>,
}

/// The context that parts of a manual are decoded with.
#[derive(Clone, Debug)]
pub(crate) struct EncodingContext {
    pub(crate) lists: SharedLists,
    /// The encoded steps of all trials, concatenated.
    pub(crate) steps: &'static [u8],
}

thread_local! {
    static FILES: Pool<PathBuf> = const { Pool::new() };
    static WRITTEN_STEPS: RefCell<Option<Vec<u8>>> = const { RefCell::new(None) };
    static READING: RefCell<Option<Arc<EncodingContext>>> = const { RefCell::new(None) };
}

/// Runs `write`; returns its result, the shared values and the encoded steps.
pub(crate) fn writing<R>(write: impl FnOnce() -> R) -> (R, SharedLists, Vec<u8>) {
    let before = WRITTEN_STEPS.replace(Some(Vec::new()));
    let ((written, tables), files) = FILES.with(|files| files.writing(|| TABLES.with(|tables| tables.writing(write))));
    let steps = WRITTEN_STEPS.replace(before).unwrap_or_default();
    (written, SharedLists { files: files.into(), tables: tables.into() }, steps)
}

/// Runs `read` in the context `shared`.
pub(crate) fn reading<R>(shared: &Arc<EncodingContext>, read: impl FnOnce() -> R) -> R {
    let SharedLists { files, tables } = &shared.lists;
    let before = READING.replace(Some(Arc::clone(shared)));
    let read = FILES.with(|of| of.reading(files, || TABLES.with(|of| of.reading(tables, read))));
    READING.set(before);
    read
}

/// The current context; `None` outside of [`reading`].
pub(crate) fn shared() -> Option<Arc<EncodingContext>> {
    READING.with_borrow(Clone::clone)
}

/// Appends the encoded steps of a trial; returns their start and end, or `None` outside of [`writing`].
pub(crate) fn put_steps(octets: &[u8]) -> Option<(usize, usize)> {
    WRITTEN_STEPS.with_borrow_mut(|steps| {
        let steps = steps.as_mut()?;
        let from = steps.len();
        steps.extend(octets);
        Some((from, steps.len()))
    })
}

/// Serialises a file name as its number, for `#[serde(with)]`.
pub(crate) mod file {
    use super::*;
    use serde::{Deserializer, Serializer, de, ser};

    pub(crate) fn serialize<S: Serializer>(file: &Arc<PathBuf>, to: S) -> Result<S::Ok, S::Error> {
        let number = FILES.with(|files| files.number(file));
        number.ok_or_else(|| ser::Error::custom("the name of a file outside of a manual"))?.serialize(to)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Arc<PathBuf>, D::Error> {
        let number = u64::deserialize(from)?;
        FILES.with(|files| files.value(number)).ok_or_else(|| de::Error::custom("no file has this number"))
    }
}
