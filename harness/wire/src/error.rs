//! Why octets could not be read.

/// Why octets could not be read: in which layer, at which octet, what was wanted and what was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WireError {
    /// The octets end before the field does.
    #[error("{layer}: octet {offset}: {wanted} octets wanted, {found} left")]
    Short {
        /// The layer or block that was being read, in the words of its standard.
        layer: &'static str,
        /// Where the field begins, counted from the first octet given to the parser.
        offset: usize,
        /// Length of the field in octets.
        wanted: usize,
        /// Octets that were left.
        found: usize,
    },
    /// A field holds a value with which the rest cannot be understood.
    #[error("{layer}: octet {offset}: {field} is {found:#x}, wanted {wanted}")]
    Value {
        /// The layer or block that was being read.
        layer: &'static str,
        /// Where the field begins, counted from the first octet given to the parser.
        offset: usize,
        /// The name of the field in its standard.
        field: &'static str,
        /// What the parser can go on with, in words.
        wanted: &'static str,
        /// The value that stood there.
        found: u64,
    },
}

impl WireError {
    /// The same error when the octets given to the parser stand `octets` behind the beginning of something larger.
    pub fn behind(mut self, octets: usize) -> WireError {
        let (WireError::Short { offset, .. } | WireError::Value { offset, .. }) = &mut self;
        *offset += octets;
        self
    }
}

/// What a parser gives.
pub type Result<T, E = WireError> = core::result::Result<T, E>;
