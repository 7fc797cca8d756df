//! PROFINET, device side, without I/O: everything that all PROFINET devices share.
//!
//! [`IoDevice`] is a [`Station`](station::Station) with an [`IoApplication`]: it answers DCP, ARP, ICMP, RPC, SNMP and HTTP,
//! opens and ends connections, exchanges cyclic frames, sends alarms, announces itself by LLDP and serves the records
//! of identification, I&M and diagnosis. Deviations attach to [`StackHooks`].
//!
//! This module must not depend on encoders, telegrams, parameters or the controller side.

mod alarm;
mod application;
mod ar;
mod clock_offset;
mod cm;
mod connection_record;
mod cyclic;
mod dcp;
mod device;
mod diagnosis;
mod fast_start_up;
mod hooks;
mod ip;
mod lldp;
mod log_book;
mod maintenance;
mod ownership;
mod phase;
mod physical;
mod plugged;
mod port_parameters;
mod reassembly;
mod receive;
mod records;
mod rpc;
mod snmp;
mod stack;
mod web;

#[cfg(test)]
mod tests;

pub use application::{
    ArKey, DiagnosisChange, DiagnosisSeverity, IoApplication, IoIdentity, PlugChange, PluggableSubmodule, RecordAccess,
    RecordRefusal, ResetScope, StackStatus, StationData, SubmoduleDiagnosis,
};
pub use device::IoDevice;
pub use hooks::{ArEvent, StackCheck, StackHooks, StackView, StationLoad};
pub use physical::port_mac;
pub use plugged::{INTERFACE_IDENT, INTERFACE_SUBSLOT, PORT_IDENT, PORT_SUBSLOT};
pub use snmp::{MibName, MibObject, MibValue, SnmpAnswer};
