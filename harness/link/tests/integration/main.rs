//! Sockets, interfaces, serial lines and lines of text, each with both its sides in one process.

mod common;
mod lines;
mod nic;
mod serial;
mod socket;
mod wire;
