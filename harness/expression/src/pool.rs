//! Serialises values that many parts of a whole share: each value is written once with the whole, the parts store its number.
//!
//! Serde passes no context from a whole to its parts, so the pool is a thread-local while it is read or written.

use super::WordTable;
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::sync::Arc;

/// Shared values of one type, while something that contains them is written or read.
#[derive(Debug)]
pub struct Pool<T> {
    writing: RefCell<Option<Vec<Arc<T>>>>,
    reading: RefCell<Option<Arc<[Arc<T>]>>>,
}

impl<T: PartialEq> Pool<T> {
    /// A pool that is not in use.
    pub const fn new() -> Pool<T> {
        Pool { writing: RefCell::new(None), reading: RefCell::new(None) }
    }

    /// Runs `write`; returns its result and the values that were numbered, in the order of their numbers.
    pub fn writing<R>(&self, write: impl FnOnce() -> R) -> (R, Vec<Arc<T>>) {
        let before = self.writing.replace(Some(Vec::new()));
        let written = write();
        (written, self.writing.replace(before).unwrap_or_default())
    }

    /// Runs `read`; numbers refer to `values`.
    pub fn reading<R>(&self, values: &Arc<[Arc<T>]>, read: impl FnOnce() -> R) -> R {
        let before = self.reading.replace(Some(Arc::clone(values)));
        let read = read();
        self.reading.replace(before);
        read
    }

    /// The number of `value`, the same for equal values; `None` outside of [`Pool::writing`].
    pub fn number(&self, value: &Arc<T>) -> Option<u64> {
        let mut writing = self.writing.borrow_mut();
        let values = writing.as_mut()?;
        let same = values.iter().position(|known| Arc::ptr_eq(known, value));
        let found = same.or_else(|| values.iter().position(|known| known == value));
        Some(found.unwrap_or_else(|| {
            values.push(Arc::clone(value));
            values.len() - 1
        }) as u64)
    }

    /// The value with this number; `None` outside of [`Pool::reading`] or if no value has it.
    pub fn value(&self, number: u64) -> Option<Arc<T>> {
        let reading = self.reading.borrow();
        reading.as_ref()?.get(usize::try_from(number).ok()?).cloned()
    }
}

impl<T: PartialEq> Default for Pool<T> {
    fn default() -> Pool<T> {
        Pool::new()
    }
}

thread_local! {
    /// The word tables.
    pub static TABLES: Pool<WordTable> = const { Pool::new() };
}

/// Serialises a word table as its number, for `#[serde(with)]`.
pub mod table {
    use super::*;
    use serde::{Deserializer, Serializer, de, ser};

    /// Writes the number of `table`; fails outside of [`TABLES`].
    pub fn serialize<S: Serializer>(table: &Arc<WordTable>, to: S) -> Result<S::Ok, S::Error> {
        let number = TABLES.with(|tables| tables.number(table));
        number.ok_or_else(|| ser::Error::custom("a table of words without a pool"))?.serialize(to)
    }

    /// Reads a number and returns its table; fails if no table has this number.
    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Arc<WordTable>, D::Error> {
        let number = u64::deserialize(from)?;
        TABLES.with(|tables| tables.value(number)).ok_or_else(|| de::Error::custom("no table of words has this number"))
    }
}

/// Serialises an optional word table as its number, for `#[serde(with)]`.
pub mod maybe_table {
    use super::*;
    use serde::{Deserializer, Serializer};

    #[derive(Deserialize, Serialize)]
    struct SharedTable(#[serde(with = "super::table")] Arc<WordTable>);

    /// Writes the number of `table`, if it is set; fails outside of [`TABLES`].
    pub fn serialize<S: Serializer>(table: &Option<Arc<WordTable>>, to: S) -> Result<S::Ok, S::Error> {
        table.clone().map(SharedTable).serialize(to)
    }

    /// Reads an optional number and returns its table; fails if no table has this number.
    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Arc<WordTable>>, D::Error> {
        Ok(Option::<SharedTable>::deserialize(from)?.map(|SharedTable(table)| table))
    }
}
