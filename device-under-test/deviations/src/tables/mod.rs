//! The deviations of the reference devices: the deliberate bugs and the variations that a manual permits, by topic.
//!
//! A [`Deviation`] is a name, a sentence, a kind, and the change that it attaches to the hooks of a device ([`Deviations`]). Deviations
//! with the same needs form a [`Group`]. The devices of a manual can have the deviations of all groups whose [needs](Need) they meet.

use crate::needs::Need;
use crate::seams::Deviations;
use reference_devices::Manual;

/// Defines bugs, one per line: `"name" "Sentence." => |d| attach;`.
macro_rules! bugs {
    ($($name:literal $sentence:literal => |$deviations:ident| $attach:expr;)*) => {
        &[$($crate::tables::Deviation {
            name: $name,
            sentence: $sentence,
            kind: $crate::tables::Kind::Bug,
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
            kind: $crate::tables::Kind::Permitted { clause: $clause },
            attach: |$deviations: &mut $crate::seams::Deviations| { $attach; },
        }),*]
    };
}

pub mod amt58;
pub mod codes;
pub mod diagnosis;
mod diagnosis_memory;
pub mod dp_diagnosis;
pub mod dp_presets;
pub mod dp_station;
pub mod field;
pub mod handshakes;
mod image;
pub mod isochronous;
pub mod layouts;
pub mod leds;
pub mod lights;
pub mod limits;
pub mod measuring;
pub mod memory;
pub mod panel;
pub mod parameter_access;
mod parameter_memory;
pub mod parameters;
pub mod plain;
pub mod presets;
pub mod records;
pub mod requests;
pub mod reset;
mod sensor_memory;
pub mod service;
pub mod set_prm;
pub mod signals;
pub mod slave;
pub mod slave_memory;
pub mod stack;
pub mod stack_data;
mod stack_memory;
pub mod start;
pub mod station;
mod station_memory;
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
    pub kind: Kind,
    /// Attaches the deviation to the hooks of a device.
    pub attach: fn(&mut Deviations),
}

/// Whether a manual forbids or permits a deviation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
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
    leds::GROUPS,
    lights::GROUPS,
    limits::GROUPS,
    measuring::GROUPS,
    memory::GROUPS,
    panel::GROUPS,
    parameter_access::GROUPS,
    parameters::GROUPS,
    plain::GROUPS,
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
    variations::GROUPS,
    velocity::GROUPS,
    vendor_axis::GROUPS,
    vendor_parameters::GROUPS,
    vendor_telegrams::GROUPS,
    web::GROUPS,
];

/// Returns the deviations of the groups whose needs the devices of `manual` meet.
pub fn of(manual: &'static Manual) -> impl Iterator<Item = &'static Deviation> + Clone {
    let groups = GROUPS.iter().copied().flatten();
    groups.filter(|group| group.needs.iter().all(|need| need.is_met_by(manual))).flat_map(|group| group.deviations)
}
