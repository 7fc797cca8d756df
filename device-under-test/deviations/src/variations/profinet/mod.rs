//! What a PROFINET device may do, whatever the manual of the encoder says: the standard leaves it free.

pub mod cyclic;
pub mod discovery;
pub mod identity;
pub mod path;
pub mod rpc;
pub mod startup;
mod state;
pub mod times;
