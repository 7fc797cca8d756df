//! Values that many parts of a whole share: each is written once with the whole, and the parts have its number.
//!
//! Serde hands nothing along from a whole to its parts, so a pool stands beside the thread while it reads or writes.

use super::WordTable;
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::sync::Arc;

/// Shared values of one kind, while something that has them is written or read.
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

    /// Does what `write` does; gives besides its result the values that got numbers, by number.
    pub fn writing<R>(&self, write: impl FnOnce() -> R) -> (R, Vec<Arc<T>>) {
        let before = self.writing.replace(Some(Vec::new()));
        let written = write();
        (written, self.writing.replace(before).unwrap_or_default())
    }

    /// Does what `read` does, where a number stands for its value in `values`.
    pub fn reading<R>(&self, values: &Arc<[Arc<T>]>, read: impl FnOnce() -> R) -> R {
        let before = self.reading.replace(Some(Arc::clone(values)));
        let read = read();
        self.reading.replace(before);
        read
    }

    /// The number of `value`, the same for equal values; none if nothing is being written.
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

    /// The value of a number; none if nothing is being read, or no value has this number.
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
    /// The tables of words.
    pub static TABLES: Pool<WordTable> = const { Pool::new() };
}

/// A table of words by its number, for `#[serde(with)]`.
pub mod table {
    use super::*;
    use serde::{Deserializer, Serializer, de, ser};

    /// Writes the number of `table`; fails outside of [`TABLES`].
    pub fn serialize<S: Serializer>(table: &Arc<WordTable>, to: S) -> Result<S::Ok, S::Error> {
        let number = TABLES.with(|tables| tables.number(table));
        number.ok_or_else(|| ser::Error::custom("a table of words without a pool"))?.serialize(to)
    }

    /// The table of the number that comes next; fails if there is none.
    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Arc<WordTable>, D::Error> {
        let number = u64::deserialize(from)?;
        TABLES.with(|tables| tables.value(number)).ok_or_else(|| de::Error::custom("no table of words has this number"))
    }
}

/// A table of words that may be missing, for `#[serde(with)]`.
pub mod maybe_table {
    use super::*;
    use serde::{Deserializer, Serializer};

    #[derive(Deserialize, Serialize)]
    struct Table(#[serde(with = "super::table")] Arc<WordTable>);

    /// Writes the number of `table` if there is one; fails outside of [`TABLES`].
    pub fn serialize<S: Serializer>(table: &Option<Arc<WordTable>>, to: S) -> Result<S::Ok, S::Error> {
        table.clone().map(Table).serialize(to)
    }

    /// The table of the number that comes next, if one comes; fails if there is no such table.
    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Arc<WordTable>>, D::Error> {
        Ok(Option::<Table>::deserialize(from)?.map(|Table(table)| table))
    }
}
