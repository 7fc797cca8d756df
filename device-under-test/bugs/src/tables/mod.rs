//! The deliberate bugs of the reference devices, by topic.
//!
//! A [`Deviation`] is a name, a sentence, a kind, and the change that it attaches to the hooks of a device. Bugs with the same needs
//! form a [`Group`]. The devices of a manual can have the bugs of all groups whose needs they meet.

pub use deviation_hooks::{Deviation, DeviationKind, Group};

pub mod afx60_controls;
pub mod afx60_leds;
pub mod amt58;
pub mod codes;
pub mod connect_fields;
pub mod connection_records;
mod connection_state;
pub mod cyclic_state;
pub mod dcp_options;
mod dcp_options_state;
pub mod diagnosis;
mod diagnosis_state;
pub mod dp_diagnosis;
pub mod dp_encoder;
pub mod dp_presets;
pub mod dp_station;
pub mod frame_status;
mod frame_status_state;
pub mod handshakes;
pub mod hello;
pub mod ip_packets;
mod ip_packets_state;
pub mod isochronous;
pub mod layouts;
pub mod limits;
pub mod measuring;
pub mod memory;
pub mod net_load;
pub mod parameter_access;
mod parameter_access_state;
pub mod parameters;
pub mod persona_bugs;
pub mod presets;
pub mod profinet_io;
pub mod record_access;
mod record_access_state;
pub mod records;
pub mod requests;
pub mod reset;
pub mod rpc_calls;
mod rpc_calls_state;
pub mod sendix_leds;
pub mod service;
pub mod set_prm;
pub mod shared_slots;
mod shared_slots_state;
pub mod signal_image;
pub mod signals;
pub mod snmp;
mod snmp_state;
pub mod stack;
pub mod stack_data;
pub mod start;
pub mod station;
mod station_state;
pub mod supervisors;
mod supervisors_state;
mod unrequested_presets;
pub mod velocity;
pub mod vendor_axis;
pub mod vendor_parameters;
pub mod vendor_telegrams;
pub mod web;

/// All groups, by topic.
pub static GROUPS: &[&[Group]] = &[
    amt58::GROUPS,
    codes::GROUPS,
    connect_fields::GROUPS,
    connection_records::GROUPS,
    hello::GROUPS,
    dcp_options::GROUPS,
    diagnosis::GROUPS,
    slave_bugs::dp_alarms::GROUPS,
    dp_diagnosis::GROUPS,
    dp_encoder::GROUPS,
    dp_presets::GROUPS,
    slave_bugs::dp_slave::GROUPS,
    dp_station::GROUPS,
    frame_status::GROUPS,
    handshakes::GROUPS,
    ip_packets::GROUPS,
    isochronous::GROUPS,
    layouts::GROUPS,
    sendix_leds::GROUPS,
    afx60_leds::GROUPS,
    limits::GROUPS,
    measuring::GROUPS,
    memory::GROUPS,
    afx60_controls::GROUPS,
    net_load::GROUPS,
    parameter_access::GROUPS,
    parameters::GROUPS,
    profinet_io::GROUPS,
    presets::GROUPS,
    record_access::GROUPS,
    records::GROUPS,
    requests::GROUPS,
    reset::GROUPS,
    rpc_calls::GROUPS,
    service::GROUPS,
    set_prm::GROUPS,
    shared_slots::GROUPS,
    signals::GROUPS,
    slave_bugs::slave::GROUPS,
    snmp::GROUPS,
    stack::GROUPS,
    stack_data::GROUPS,
    start::GROUPS,
    station::GROUPS,
    supervisors::GROUPS,
    velocity::GROUPS,
    vendor_axis::GROUPS,
    vendor_parameters::GROUPS,
    vendor_telegrams::GROUPS,
    web::GROUPS,
];
