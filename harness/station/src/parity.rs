//! The parity bit of a serial line.

/// The parity bit of each character on a serial line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Parity {
    /// Even parity, as on PROFIBUS.
    #[default]
    Even,
    /// Odd parity.
    Odd,
    /// No parity bit.
    None,
}
