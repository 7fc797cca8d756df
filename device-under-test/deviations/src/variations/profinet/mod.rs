//! What a PROFINET device may do, whatever the manual of the encoder says: the standard leaves it free.

pub mod cyclic;
pub mod description;
pub mod discovery;
pub mod identity;
pub mod ip_packets;
mod loss;
pub mod path;
pub mod ports;
pub mod rpc;
pub mod snmp;
pub mod startup;
mod state;
pub mod times;
pub mod vendor_records;
