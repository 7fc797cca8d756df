//! The deviations of the reference devices: the deliberate bugs and the variations that a manual permits, by topic.
//!
//! A [`Deviation`] is a name, a sentence, a kind, and what it attaches to the hooks of a device ([`Deviations`]). Those that need the
//! same of a device form a [`Group`]; a manual whose devices have what a group [needs](Need) has its deviations.

use crate::needs::Need;
use crate::seams::Deviations;
use reference_devices::Manual;

/// Lines of `"name" "Sentence." => |d| what it attaches;`.
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

/// Lines of `"name" "Sentence." "the clause that leaves it free" => |d| what it attaches;`.
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

/// A deviation of a reference device from what its conforming device does.
#[derive(Debug)]
pub struct Deviation {
    /// Its name: of a bug the one that the suites name under `catches`.
    pub name: &'static str,
    /// What the device does with it, in one sentence.
    pub sentence: &'static str,
    /// Whether its manual forbids it.
    pub kind: Kind,
    /// Attaches it to the hooks of a device.
    pub attach: fn(&mut Deviations),
}

/// What the manual says of a deviation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// It is forbidden: some case has to fail with it.
    Bug,
    /// It is left free: no case may fail with it.
    Permitted {
        /// The clause that leaves it free, or that the manual is silent.
        clause: &'static str,
    },
}

/// The deviations that are possible wherever all of the needs are met.
#[derive(Debug)]
pub struct Group {
    /// What they need of a device.
    pub needs: &'static [Need],
    /// The deviations.
    pub deviations: &'static [Deviation],
}

/// Every group, by topic.
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

/// The deviations of the groups whose needs the devices of `manual` meet.
pub fn of(manual: &'static Manual) -> impl Iterator<Item = &'static Deviation> + Clone {
    let groups = GROUPS.iter().copied().flatten();
    groups.filter(|group| group.needs.iter().all(|need| need.is_met_by(manual))).flat_map(|group| group.deviations)
}
