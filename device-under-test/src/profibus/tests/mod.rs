//! The slave against frames written by hand, with an encoder that keeps octets.

pub(crate) mod bench;
mod finding;
mod knobs;
mod records;
mod start_up;
mod toy;
