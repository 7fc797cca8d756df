//! The parity bit of a serial line.

/// The parity bit of each octet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Parity {
    /// The number of ones is even, as PROFIBUS has it.
    #[default]
    Even,
    /// The number of ones is odd.
    Odd,
    /// There is none.
    None,
}
