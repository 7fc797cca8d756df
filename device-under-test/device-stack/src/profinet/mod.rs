//! PROFINET, device side: everything that all PROFINET devices share, sans-IO.
//!
//! [`Device`] is a [`Station`](station::Station) around an [`Application`]: it answers DCP, ARP, ICMP, RPC and HTTP, opens and
//! ends connections, exchanges cyclic frames, sends alarms, announces itself by LLDP and keeps the records of identification,
//! I&M and diagnosis. What deviates on purpose attaches to [`StackHooks`].
//!
//! This module must not know encoders, telegrams or parameters, nor anything of the controller's side.

mod ahead;
mod alarm;
mod application;
mod ar;
mod cm;
mod cyclic;
mod dcp;
mod device;
mod diagnosis;
mod hooks;
mod ip;
mod lldp;
mod maintenance;
mod phase;
mod physical;
mod plugged;
mod receive;
mod records;
mod rpc;
mod stack;
mod web;

#[cfg(test)]
mod tests;

pub use application::{
    Access, Application, ArKey, Diagnosis, DiagnosisChange, Identity, Plug, RecordRefusal, ResetScope, Seen, Severity,
    StationData,
};
pub use device::Device;
pub use hooks::{Connection, StackCheck, StackHooks, StackView, Start};
pub use physical::port_mac;
pub use plugged::{INTERFACE_IDENT, INTERFACE_SUBSLOT, PORT_IDENT, PORT_SUBSLOT};
