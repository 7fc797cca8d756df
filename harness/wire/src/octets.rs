//! A reader that tracks the offset of each field, and methods to append fields to a buffer.

use crate::error::{Result, WireError};
use alloc::vec::Vec;

/// Byte order of a field. PROFINET blocks are big-endian; RPC headers state their byte order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ByteOrder {
    /// Most significant byte first (big-endian).
    Big,
    /// Least significant byte first (little-endian).
    Little,
}

/// The bits of a number that belong to a field of `width` bits from bit `low` on, 1 to 64 bits; those beyond 64 are left out.
#[inline]
pub fn mask(low: u32, width: u32) -> u64 {
    (u64::MAX >> (64 - width.clamp(1, 64))).checked_shl(low).unwrap_or(0)
}

/// Reads fields one after the other and tracks their offset.
#[derive(Clone, Copy, Debug)]
pub struct ByteReader<'a> {
    octets: &'a [u8],
    at: usize,
    base: usize,
    layer: &'static str,
    order: ByteOrder,
}

impl<'a> ByteReader<'a> {
    /// A big-endian reader of `octets`; errors name `layer`.
    #[inline]
    pub fn new(layer: &'static str, octets: &'a [u8]) -> ByteReader<'a> {
        ByteReader { octets, at: 0, base: 0, layer, order: ByteOrder::Big }
    }

    /// Changes the layer that errors name.
    #[inline]
    pub fn layer(mut self, layer: &'static str) -> ByteReader<'a> {
        self.layer = layer;
        self
    }

    /// Changes the byte order.
    #[inline]
    pub fn order(mut self, order: ByteOrder) -> ByteReader<'a> {
        self.order = order;
        self
    }

    /// The offset of the next field, in bytes from the start of the outermost reader.
    #[inline]
    pub fn offset(&self) -> usize {
        self.base + self.at
    }

    /// The number of bytes left.
    #[inline]
    pub fn left(&self) -> usize {
        self.octets.len() - self.at
    }

    /// Whether no bytes are left.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.left() == 0
    }

    /// Reads the next `n` bytes.
    #[inline]
    pub fn take(&mut self, n: usize) -> Result<&'a [u8]> {
        match self.octets.get(self.at..).and_then(|rest| rest.get(..n)) {
            Some(field) => {
                self.at += n;
                Ok(field)
            }
            None => Err(WireError::Short { layer: self.layer, offset: self.offset(), needed: n, left: self.left() }),
        }
    }

    /// Reads all remaining bytes.
    #[inline]
    pub fn rest(&mut self) -> &'a [u8] {
        let rest = &self.octets[self.at..];
        self.at = self.octets.len();
        rest
    }

    /// A reader for only the next `n` bytes; its offsets continue those of this reader.
    #[inline]
    pub fn sub(&mut self, n: usize) -> Result<ByteReader<'a>> {
        let base = self.offset();
        Ok(ByteReader { octets: self.take(n)?, at: 0, base, layer: self.layer, order: self.order })
    }

    /// Reads the next `N` bytes as an array.
    #[inline]
    pub fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }

    /// Reads the next byte.
    #[inline]
    pub fn u8(&mut self) -> Result<u8> {
        Ok(self.array::<1>()?[0])
    }

    /// Reads a 16-bit word in the byte order of the reader.
    #[inline]
    pub fn u16(&mut self) -> Result<u16> {
        let octets = self.array()?;
        Ok(match self.order {
            ByteOrder::Big => u16::from_be_bytes(octets),
            ByteOrder::Little => u16::from_le_bytes(octets),
        })
    }

    /// Reads a 32-bit word in the byte order of the reader.
    #[inline]
    pub fn u32(&mut self) -> Result<u32> {
        let octets = self.array()?;
        Ok(match self.order {
            ByteOrder::Big => u32::from_be_bytes(octets),
            ByteOrder::Little => u32::from_le_bytes(octets),
        })
    }

    /// An error for the field of length `octets` that ends at the current offset.
    #[cold]
    pub fn wrong(&self, field: &'static str, octets: usize, wanted: &'static str, found: u64) -> WireError {
        WireError::Value {
            layer: self.layer,
            offset: self.offset().saturating_sub(octets),
            field,
            expected: wanted,
            observed: found,
        }
    }

    /// Fails if bytes are left; `needed` is the text of what is expected.
    #[inline]
    pub fn end(&self, wanted: &'static str) -> Result<()> {
        match self.left() {
            0 => Ok(()),
            left => Err(WireError::Value {
                layer: self.layer,
                offset: self.offset(),
                field: "number of remaining bytes",
                expected: wanted,
                observed: left as u64,
            }),
        }
    }

    /// Skips padding up to a multiple of `n` bytes from the start of this reader, at most to the end.
    #[inline]
    pub fn align(&mut self, n: usize) {
        self.at = self.at.next_multiple_of(n).min(self.octets.len());
    }
}

/// Appends fields to a buffer.
pub trait Append {
    /// Appends one byte.
    fn put_u8(&mut self, value: u8);
    /// Appends bytes.
    fn put(&mut self, octets: &[u8]);
    /// Appends a 16-bit word, big-endian.
    fn put_u16(&mut self, value: u16) {
        self.put(&value.to_be_bytes());
    }
    /// Appends a 32-bit word, big-endian.
    fn put_u32(&mut self, value: u32) {
        self.put(&value.to_be_bytes());
    }
    /// Appends a 16-bit word in `order`.
    fn put_u16_in(&mut self, order: ByteOrder, value: u16) {
        match order {
            ByteOrder::Big => self.put(&value.to_be_bytes()),
            ByteOrder::Little => self.put(&value.to_le_bytes()),
        }
    }
    /// Appends a 32-bit word in `order`.
    fn put_u32_in(&mut self, order: ByteOrder, value: u32) {
        match order {
            ByteOrder::Big => self.put(&value.to_be_bytes()),
            ByteOrder::Little => self.put(&value.to_le_bytes()),
        }
    }
}

impl Append for Vec<u8> {
    #[inline]
    fn put_u8(&mut self, value: u8) {
        self.push(value);
    }
    #[inline]
    fn put(&mut self, octets: &[u8]) {
        self.extend_from_slice(octets);
    }
}
