//! The deviations of the reference devices: the deliberate bugs and the variations that a manual permits, by topic.
//!
//! A [`Deviation`] is a name, a sentence, a kind, and the change that it attaches to the hooks of a device ([`Deviations`]). Deviations
//! with the same needs form a [`Group`]. The devices of a manual can have the deviations of all groups whose [needs](Need) they meet.

use crate::needs::Need;
use crate::seams::Deviations;
use reference_devices::DeviceManual;

/// Defines bugs, one per line: `"name" "Sentence." => |d| attach;`.
macro_rules! bugs {
    ($($name:literal $sentence:literal => |$deviations:ident| $attach:expr;)*) => {
        &[$($crate::tables::Deviation {
            name: $name,
            sentence: $sentence,
            kind: $crate::tables::DeviationKind::Bug,
            attach: |$deviations: &mut $crate::seams::Deviations| { $attach; },
        }),*]
    };
}

/// Defines permitted variations, one per line: `"name" "Sentence." "the clause that permits it" => |d| attach;`.
macro_rules! permitted {
    ($($name:literal $sentence:literal $clause:literal => |$deviations:ident| $attach:expr;)*) => {
        &[$($crate::tables::Deviation {
            name: $name,
            sentence: $sentence,
            kind: $crate::tables::DeviationKind::Permitted { clause: $clause },
            attach: |$deviations: &mut $crate::seams::Deviations| { $attach; },
        }),*]
    };
}

pub mod afx60_controls;
pub mod afx60_leds;
pub mod amt58;
pub mod codes;
mod connection_state;
mod cyclic_state;
pub mod diagnosis;
mod diagnosis_state;
pub mod dp_diagnosis;
pub mod dp_presets;
pub mod dp_station;
pub mod handshakes;
pub mod isochronous;
pub mod layouts;
pub mod limits;
pub mod measuring;
pub mod memory;
pub mod parameter_access;
mod parameter_access_state;
pub mod parameters;
pub mod persona_bugs;
pub mod presets;
pub mod profinet_io;
pub mod records;
pub mod requests;
pub mod reset;
pub mod sendix_leds;
pub mod service;
pub mod set_prm;
mod signal_image;
pub mod signals;
pub mod slave;
pub mod slave_state;
pub mod stack;
pub mod stack_data;
pub mod start;
pub mod station;
mod station_state;
mod unrequested_presets;
pub mod variations;
pub mod velocity;
pub mod vendor_axis;
pub mod vendor_parameters;
pub mod vendor_telegrams;
pub mod web;

/// A deviation of a reference device from the behaviour of the conforming device.
#[derive(Debug)]
pub struct Deviation {
    /// The name. For a bug it is the name that suites list under `catches`.
    pub name: &'static str,
    /// What the device does, in one sentence.
    pub sentence: &'static str,
    /// Whether it is a bug or permitted by the manual.
    pub kind: DeviationKind,
    /// Attaches the deviation to the hooks of a device.
    pub attach: fn(&mut Deviations),
}

/// Whether a manual forbids or permits a deviation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviationKind {
    /// Forbidden: at least one case has to fail.
    Bug,
    /// Permitted: no case may fail.
    Permitted {
        /// The clause that permits it, or a note that the manual is silent.
        clause: &'static str,
    },
}

/// Deviations that are possible if all needs are met.
#[derive(Debug)]
pub struct Group {
    /// The needs of all these deviations.
    pub needs: &'static [Need],
    /// The deviations.
    pub deviations: &'static [Deviation],
}

/// All groups, by topic.
pub static GROUPS: &[&[Group]] = &[
    amt58::GROUPS,
    codes::GROUPS,
    diagnosis::GROUPS,
    dp_diagnosis::GROUPS,
    dp_presets::GROUPS,
    dp_station::GROUPS,
    handshakes::GROUPS,
    isochronous::GROUPS,
    layouts::GROUPS,
    sendix_leds::GROUPS,
    afx60_leds::GROUPS,
    limits::GROUPS,
    measuring::GROUPS,
    memory::GROUPS,
    afx60_controls::GROUPS,
    parameter_access::GROUPS,
    parameters::GROUPS,
    profinet_io::GROUPS,
    presets::GROUPS,
    records::GROUPS,
    requests::GROUPS,
    reset::GROUPS,
    service::GROUPS,
    set_prm::GROUPS,
    signals::GROUPS,
    slave::GROUPS,
    stack::GROUPS,
    stack_data::GROUPS,
    start::GROUPS,
    station::GROUPS,
    velocity::GROUPS,
    vendor_axis::GROUPS,
    vendor_parameters::GROUPS,
    vendor_telegrams::GROUPS,
    web::GROUPS,
];

/// Returns the deviations of the groups whose needs the devices of `manual` meet.
pub fn of(manual: &'static DeviceManual) -> impl Iterator<Item = &'static Deviation> + Clone {
    let groups = GROUPS.iter().chain(variations::GROUPS).copied().flatten();
    groups.filter(|group| group.needs.iter().all(|need| need.is_met_by(manual))).flat_map(|group| group.deviations)
}
