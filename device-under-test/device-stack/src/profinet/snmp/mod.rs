//! The SNMP agent: SNMPv1 and SNMPv2c over UDP port 161, for reading only (RFC 1157, RFC 3416).
//!
//! Its encoding is its own, so that what the manager of a test reads is not what the same code wrote.

mod agent;
mod ber;
mod objects;

pub use agent::SnmpAnswer;
pub use ber::{MibName, MibValue};
pub use objects::MibObject;

pub(super) use agent::answer;
pub(super) use objects::TrafficCounters;

/// The UDP port of the agent.
pub(super) const PORT: u16 = 161;
