//! PROFIBUS DP, slave side: everything that all slaves share, sans-IO.
//!
//! [`Device`] is a [`Station`](station::Station) around an [`Application`]: it answers FDL and DP requests, keeps the states
//! from Power_On to Data_Exch, the watchdog, the lock, freeze and sync, and polls records of DP-V1 through. A frame comes to it
//! at the end of its last character, and what it sends begins at once: it waits for min TSDR by itself.
//! Deviations attach to it at [`SlaveHooks`].
//!
//! This module must not know encoders or parameters, nor anything of the master's side.

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

pub use application::{Access, Application, Channel, DiagnosisBits, End, Identity, Refusal, Seen, State};
pub use device::Device;
pub use hooks::{Check, SlaveHooks};
