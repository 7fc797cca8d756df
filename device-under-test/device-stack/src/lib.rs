//! PROFINET and PROFIBUS DP device stacks without I/O.
//!
//! [`profinet::IoDevice`] and [`profibus::DpDevice`] are [`Station`](station::Station)s: they receive frames and the
//! current time, and return frames to send. What a device *does* is defined by an application, an implementation of
//! [`profinet::IoApplication`] or [`profibus::SlaveApplication`]: identification, cyclic data, records, diagnoses, stored
//! data. The stacks know nothing about encoders.
//!
//! A slave that returns its outputs as inputs; a master requests its FDL status:
//!
//! ```
//! use device_stack::Attached;
//! use device_stack::profibus::{SlaveApplication, DpDevice, DiagnosisBits, ExchangeEnd, SlaveIdentity};
//! use station::{Duration, Outbox, StandAction, Station, Time};
//! use wire::profibus::cfg::IoLengths;
//! use wire::profibus::fdl::BaudRate;
//! use wire::profibus::prm::SetPrm;
//!
//! struct Mirror {
//!     identity: SlaveIdentity,
//!     outputs: Vec<u8>,
//! }
//!
//! impl SlaveApplication for Mirror {
//!     fn identity(&self) -> &SlaveIdentity {
//!         &self.identity
//!     }
//!     fn power_up(&mut self, _: Time) {}
//!     fn power_down(&mut self, _: Time) {}
//!     fn address(&self) -> u8 {
//!         5
//!     }
//!     fn takes_address(&self) -> bool {
//!         false
//!     }
//!     fn set_address(&mut self, _: Time, _: u8, _: bool) {}
//!     fn parameters(&mut self, _: Time, _: &SetPrm) -> bool {
//!         true
//!     }
//!     fn check_configuration(&mut self, _: Time, identifiers: &[u8]) -> Option<IoLengths> {
//!         // One module with two input bytes and two output bytes.
//!         (identifiers == [0x31]).then_some(IoLengths { inputs: 2, outputs: 2 })
//!     }
//!     fn configuration(&self, out: &mut Vec<u8>) {
//!         out.push(0x31);
//!     }
//!     fn exchange_begins(&mut self, _: Time) {}
//!     fn exchange_ends(&mut self, _: Time, _: ExchangeEnd) {}
//!     fn outputs(&mut self, _: Time, data: Option<&[u8]>) {
//!         self.outputs = data.unwrap_or(&[0; 2]).to_vec();
//!     }
//!     fn inputs(&mut self, _: Time, data: &mut [u8]) {
//!         data.copy_from_slice(&self.outputs);
//!     }
//!     fn diagnosis(&mut self, _: Time, _: &mut Vec<u8>) -> DiagnosisBits {
//!         DiagnosisBits::default()
//!     }
//!     fn diagnosis_changed(&mut self) -> bool {
//!         false
//!     }
//!     fn act(&mut self, _: Time, _: &StandAction<'_>) -> Option<Time> {
//!         None
//!     }
//! }
//!
//! let identity = SlaveIdentity {
//!     ident: 0xABCD,
//!     boot_time: Duration::from_millis(100),
//!     freeze: false,
//!     sync: false,
//!     fail_safe: false,
//!     dpv1: false,
//!     ms1: false,
//!     extra_alarm_sap: false,
//!     ms2: 0,
//!     abilities: None,
//!     isochronous: false,
//!     set_ext_prm: false,
//! };
//! let mirror = Mirror { identity, outputs: vec![0; 2] };
//! let mut device = DpDevice::new(mirror, BaudRate(1_500_000), Attached::NONE);
//!
//! // Master 2 requests the FDL status of station 5. The answer is due min TSDR later: a slave, not in the ring.
//! let mut out = Outbox::new();
//! device.receive(Time::ZERO, &[0x10, 5, 2, 0x49, 0x50, 0x16], &mut out);
//! device.wake(device.deadline().expect("an answer is due"), &mut out);
//! assert_eq!(out.frames().next(), Some(&[0x10, 2, 5, 0x00, 0x07, 0x16][..]));
//! ```
//!
//! For PROFINET, the plain IO device of `reference-devices` (`models/plain.rs`) is the shortest application.
//!
//! This crate must not depend on encoder crates or on the controller side.
#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate self as device_stack;
#[cfg(test)]
extern crate std;

mod attached;
pub mod profibus;
pub mod profinet;
mod supply;

pub use attached::Attached;

use station::Time;

/// The earlier of two optional times.
#[inline]
fn earlier(one: Option<Time>, other: Option<Time>) -> Option<Time> {
    match (one, other) {
        (Some(one), Some(other)) => Some(one.min(other)),
        (None, one) | (one, None) => one,
    }
}
