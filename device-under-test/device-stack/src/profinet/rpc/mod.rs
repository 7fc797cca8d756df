//! Calls: the server that controllers call, the endpoint mapper, and the one call that the device makes.
//!
//! This module must not know what an operation does.

mod caller;
mod endpoint_mapper;
mod server;

pub(super) use caller::{Call, Progress};
pub(super) use endpoint_mapper::Registered;
pub(super) use server::{Reply, Request, Server, Taken};

use alloc::vec::Vec;
use wire::datagram::LONGEST_PAYLOAD;
use wire::profinet::rpc::{Header, fragments};

/// The PDUs in which a body travels, each in one frame.
fn pdus(header: &Header, body: &[u8]) -> Vec<Vec<u8>> {
    fragments(header, body, LONGEST_PAYLOAD - Header::LENGTH)
}
