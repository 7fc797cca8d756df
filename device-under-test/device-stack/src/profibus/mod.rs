//! PROFIBUS DP, slave side, without I/O: everything that all slaves share.
//!
//! [`DpDevice`] is a [`Station`](station::Station) with an [`SlaveApplication`]: it answers FDL and DP requests, keeps the
//! states from Power_On to Data_Exch, the watchdog, the lock, Freeze and Sync, and serves DP-V1 records. It receives
//! a frame at the end of its last character. What it sends starts at once: the slave itself waits for min TSDR.
//! Deviations attach to [`SlaveHooks`].
//!
//! This module must not depend on encoders, parameters or the master side.

mod address;
mod application;
mod device;
mod diagnosis;
mod exchange;
mod hooks;
mod link;
mod records;
mod services;
mod slave;
mod start_up;
mod state_machine;

#[cfg(test)]
mod tests;

pub use application::{
    AcknowledgedAlarm, DiagnosisBits, DpState, Dpv1Access, Dpv1Channel, Dpv1RecordRefusal, ExchangeEnd,
    SlaveApplication, SlaveIdentity, SlaveStatus,
};
pub use device::DpDevice;
pub use hooks::{SlaveHooks, SlaveStackCheck};
