//! The errors of parsers.

/// A parse error: the layer, the offset in bytes, the expected and the observed value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WireError {
    /// The input ends before the field does.
    #[error("{layer}: byte {offset}: expected {needed} bytes, {left} left")]
    Short {
        /// The layer or block that is parsed, as its standard names it.
        layer: &'static str,
        /// The start of the field, in bytes from the start of the input.
        offset: usize,
        /// The length of the field in bytes.
        needed: usize,
        /// The number of bytes left.
        left: usize,
    },
    /// A field has an invalid value, with which the rest cannot be parsed.
    #[error("{layer}: byte {offset}: {field} is {observed:#x}, expected {expected}")]
    Value {
        /// The layer or block that is parsed.
        layer: &'static str,
        /// The start of the field, in bytes from the start of the input.
        offset: usize,
        /// The name of the field in its standard.
        field: &'static str,
        /// The valid values, as text.
        expected: &'static str,
        /// The observed value.
        observed: u64,
    },
}

impl WireError {
    /// The same error with its offset increased by `octets`, for a parser whose input starts there in a larger buffer.
    pub fn at_offset(mut self, octets: usize) -> WireError {
        let (WireError::Short { offset, .. } | WireError::Value { offset, .. }) = &mut self;
        *offset += octets;
        self
    }
}

/// The result of a parser.
pub type Result<T, E = WireError> = core::result::Result<T, E>;
