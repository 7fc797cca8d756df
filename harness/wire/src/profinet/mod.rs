//! PROFINET IO: cyclic frames, DCP, RPC with its blocks, alarms, status codes.

pub mod alarm;
pub mod blocks;
pub mod dcp;
pub mod diagnosis;
pub mod rpc;
pub mod rt;
pub mod status;
