//! The slave against frames written by hand, with an encoder that keeps octets.

mod bench;
mod finding;
mod records;
mod start_up;
mod toy;
