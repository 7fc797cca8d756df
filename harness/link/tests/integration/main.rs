//! Sockets, interfaces, serial lines and text lines, with both ends in one process.

mod common;
mod lines;
mod nic;
mod serial;
mod socket;
mod tap;
mod wire;
