//! Reading and appending octets with the place of each field known.

use crate::error::{Result, WireError};
use alloc::vec::Vec;

/// Byte order of a field; PROFINET blocks are big-endian, RPC headers say their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Order {
    /// Most significant octet first.
    Big,
    /// Least significant octet first.
    Little,
}

/// Reads fields one after the other and knows where each one stands.
#[derive(Clone, Copy, Debug)]
pub struct Reader<'a> {
    octets: &'a [u8],
    at: usize,
    base: usize,
    layer: &'static str,
    order: Order,
}

impl<'a> Reader<'a> {
    /// Reads `octets` as `layer`, big-endian.
    #[inline]
    pub fn new(layer: &'static str, octets: &'a [u8]) -> Reader<'a> {
        Reader { octets, at: 0, base: 0, layer, order: Order::Big }
    }

    /// The same reader under the name of an inner layer.
    #[inline]
    pub fn layer(mut self, layer: &'static str) -> Reader<'a> {
        self.layer = layer;
        self
    }

    /// The same reader in another byte order.
    #[inline]
    pub fn order(mut self, order: Order) -> Reader<'a> {
        self.order = order;
        self
    }

    /// Where the next field stands, counted from the first octet of the outermost reader.
    #[inline]
    pub fn offset(&self) -> usize {
        self.base + self.at
    }

    /// Octets that are left.
    #[inline]
    pub fn left(&self) -> usize {
        self.octets.len() - self.at
    }

    /// Whether nothing is left.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.left() == 0
    }

    /// The next `n` octets.
    #[inline]
    pub fn take(&mut self, n: usize) -> Result<&'a [u8]> {
        match self.octets.get(self.at..).and_then(|rest| rest.get(..n)) {
            Some(field) => {
                self.at += n;
                Ok(field)
            }
            None => Err(WireError::Short { layer: self.layer, offset: self.offset(), wanted: n, found: self.left() }),
        }
    }

    /// All octets that are left.
    #[inline]
    pub fn rest(&mut self) -> &'a [u8] {
        let rest = &self.octets[self.at..];
        self.at = self.octets.len();
        rest
    }

    /// A reader of the next `n` octets alone; offsets go on counting.
    #[inline]
    pub fn sub(&mut self, n: usize) -> Result<Reader<'a>> {
        let base = self.offset();
        Ok(Reader { octets: self.take(n)?, at: 0, base, layer: self.layer, order: self.order })
    }

    /// The next `N` octets as an array.
    #[inline]
    pub fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }

    /// The next octet.
    #[inline]
    pub fn u8(&mut self) -> Result<u8> {
        Ok(self.array::<1>()?[0])
    }

    /// The next 16-bit word in the order of the reader.
    #[inline]
    pub fn u16(&mut self) -> Result<u16> {
        let octets = self.array()?;
        Ok(match self.order {
            Order::Big => u16::from_be_bytes(octets),
            Order::Little => u16::from_le_bytes(octets),
        })
    }

    /// The next 32-bit word in the order of the reader.
    #[inline]
    pub fn u32(&mut self) -> Result<u32> {
        let octets = self.array()?;
        Ok(match self.order {
            Order::Big => u32::from_be_bytes(octets),
            Order::Little => u32::from_le_bytes(octets),
        })
    }

    /// An error about the field that ends where the reader stands.
    #[cold]
    pub fn wrong(&self, field: &'static str, octets: usize, wanted: &'static str, found: u64) -> WireError {
        WireError::Value { layer: self.layer, offset: self.offset().saturating_sub(octets), field, wanted, found }
    }

    /// Fails where octets are left; `wanted` says in words what is to be there.
    #[inline]
    pub fn end(&self, wanted: &'static str) -> Result<()> {
        match self.left() {
            0 => Ok(()),
            left => Err(WireError::Value {
                layer: self.layer,
                offset: self.offset(),
                field: "number of octets left",
                wanted,
                found: left as u64,
            }),
        }
    }

    /// Passes over padding up to a multiple of `n` octets from the start of this reader, as far as there is any.
    #[inline]
    pub fn align(&mut self, n: usize) {
        self.at = self.at.next_multiple_of(n).min(self.octets.len());
    }
}

/// Appends fields to a buffer.
pub trait Append {
    /// Appends one octet.
    fn put_u8(&mut self, value: u8);
    /// Appends octets.
    fn put(&mut self, octets: &[u8]);
    /// Appends a 16-bit word, most significant octet first.
    fn put_u16(&mut self, value: u16) {
        self.put(&value.to_be_bytes());
    }
    /// Appends a 32-bit word, most significant octet first.
    fn put_u32(&mut self, value: u32) {
        self.put(&value.to_be_bytes());
    }
    /// Appends a 16-bit word in `order`.
    fn put_u16_in(&mut self, order: Order, value: u16) {
        match order {
            Order::Big => self.put(&value.to_be_bytes()),
            Order::Little => self.put(&value.to_le_bytes()),
        }
    }
    /// Appends a 32-bit word in `order`.
    fn put_u32_in(&mut self, order: Order, value: u32) {
        match order {
            Order::Big => self.put(&value.to_be_bytes()),
            Order::Little => self.put(&value.to_le_bytes()),
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
