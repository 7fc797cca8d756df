//! PROFINET and PROFIBUS DP device stacks, sans-IO, for whatever stands behind them.
//!
//! [`profinet::Device`] and [`profibus::Device`] are [`Station`](station::Station)s: they take frames and the time, and give
//! frames. What a device *does* is an application behind a trait, [`profinet::Application`] or [`profibus::Application`]: what
//! it says of itself, its cyclic data, its records and diagnoses, what it stores. No encoder is known here.
//!
//! A slave that gives its outputs back as inputs; a master asks it for its status:
//!
//! ```
//! use device_stack::Attached;
//! use device_stack::profibus::{Application, Device, DiagnosisBits, End, Identity, Seen};
//! use station::{Duration, Outbox, StandAction, Station, Time};
//! use wire::profibus::cfg::Sums;
//! use wire::profibus::fdl::BaudRate;
//! use wire::profibus::prm::SetPrm;
//!
//! struct Mirror {
//!     identity: Identity,
//!     seen: Vec<u8>,
//! }
//!
//! impl Application for Mirror {
//!     fn identity(&self) -> &Identity {
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
//!     fn check_configuration(&mut self, _: Time, identifiers: &[u8]) -> Option<Sums> {
//!         // One module of two octets each way.
//!         (identifiers == [0x31]).then_some(Sums { inputs: 2, outputs: 2 })
//!     }
//!     fn configuration(&self, out: &mut Vec<u8>) {
//!         out.push(0x31);
//!     }
//!     fn exchange_begins(&mut self, _: Time) {}
//!     fn exchange_ends(&mut self, _: Time, _: End) {}
//!     fn outputs(&mut self, _: Time, data: Option<&[u8]>) {
//!         self.seen = data.unwrap_or(&[0; 2]).to_vec();
//!     }
//!     fn inputs(&mut self, _: Time, data: &mut [u8]) {
//!         data.copy_from_slice(&self.seen);
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
//!     fn led(&mut self, _: Time, _: &str, _: &Seen) -> Option<&'static str> {
//!         None
//!     }
//!     fn counter(&mut self, _: Time, _: &str) -> Option<u64> {
//!         None
//!     }
//!     fn deadline(&self) -> Option<Time> {
//!         None
//!     }
//!     fn advance(&mut self, _: Time) {}
//! }
//!
//! let identity = Identity {
//!     ident: 0xABCD,
//!     boot_time: Duration::from_millis(100),
//!     freeze: false,
//!     sync: false,
//!     fail_safe: false,
//!     dpv1: false,
//!     ms1: false,
//!     ms2: 0,
//!     abilities: None,
//!     set_ext_prm: false,
//! };
//! let mirror = Mirror { identity, seen: vec![0; 2] };
//! let mut device = Device::new(mirror, BaudRate(1_500_000), Attached::NONE);
//!
//! // The master 2 asks 5 for its status, and is answered min TSDR later: a slave that is not ready for the ring.
//! let mut out = Outbox::new();
//! device.receive(Time::ZERO, &[0x10, 5, 2, 0x49, 0x50, 0x16], &mut out);
//! device.wake(device.deadline().expect("an answer is due"), &mut out);
//! assert_eq!(out.frames().next(), Some(&[0x10, 2, 5, 0x00, 0x07, 0x16][..]));
//! ```
//!
//! For PROFINET the plain device of `reference-devices` (`models/plain.rs`) is the shortest application there is.
//!
//! This crate must not know encoders, nor anything of the controller's side.
#![no_std]

extern crate alloc;
#[cfg(test)]
extern crate self as device_stack;
#[cfg(test)]
extern crate std;

mod attached;
pub mod profibus;
pub mod profinet;

pub use attached::Attached;

use station::Time;

/// The earlier one of two times, of which there may be none.
#[inline]
fn earlier(one: Option<Time>, other: Option<Time>) -> Option<Time> {
    match (one, other) {
        (Some(one), Some(other)) => Some(one.min(other)),
        (None, one) | (one, None) => one,
    }
}
