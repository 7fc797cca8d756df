//! Names, settings and services that only PROFIBUS has, or that mean something else there.

use super::{Sentences, ServiceEntry};

/// Names that every device on PROFIBUS has besides; those of `diag` come from the tables of the wire.
pub(super) const NAMES: Sentences = &[
    ("io.outputs", "the output data as octets"),
    ("io.inputs", "the input data as octets"),
    ("io.global_control", "whether the clock of isochronous mode comes: running, stopped"),
    ("io.clock_offset", "by how much it comes late"),
    ("io.diagnosis_pending", "the answer with the inputs had high priority: a new diagnosis is to be fetched"),
    ("diag.length", "octets of the last diagnosis"),
    ("diag.bytes", "the diagnosis as octets"),
    ("diag.ident", "the ident number in it"),
    ("diag.master", "the address of the master in it; 255 for none"),
    ("diag.errors", "a set of words of the codes that its blocks tell"),
    (
        "device",
        "as_delivered: one as it was delivered takes its place, with nothing stored, at the address that it comes with",
    ),
    ("cfg.bytes", "the identifiers that Get_Cfg tells"),
    ("station.address", "the station address at which a device of the right ident number answers"),
    ("answer.set_prm", "the last answer to Set_Prm"),
    ("answer.chk_cfg", "the last answer to Chk_Cfg"),
    ("bench.station", "the station address that the device has on the bench"),
    ("bench.free_station", "a station address that nobody has"),
    ("bench.second", "the station address of the second master"),
];

/// The keys of `start` and `connect` besides start parameters.
pub(super) const SETTINGS: Sentences = &[
    ("module", "the module"),
    ("cycle", "the time from one Data_Exchange to the next; by default that of the bench, else 4ms"),
    (
        "watchdog",
        "the time without a master after which the slave gives up, or `none`; by default that of the bench, else 1s",
    ),
    ("baud", "the transmission rate of the bus in bits per second; by default that of the bench"),
    ("isochronous", "the time from one clock of isochronous mode to the next, which is the cycle then"),
    ("instead", "what is changed against the right start-up"),
];

/// The keys of `instead` in a parameter request that say where its data set stands.
pub(super) const PLACE: Sentences = &[("slot", "slot of the data set"), ("index", "its index")];

/// The services of `send`.
pub(super) const SERVICES: &[ServiceEntry] = &[
    (
        "set_slave_address",
        &["new", "ident", "lock", "length"],
        "Gives a station address; `lock` is 0 by default, `length` cuts or lengthens the data with zeros.",
    ),
    (
        "global_control",
        &["clear", "unfreeze", "freeze", "unsync", "sync", "group"],
        "One Global_Control with these bits; `group` is a mask of groups, 0 and so all of them by default; nobody answers.",
    ),
    ("fdl_status", &[], "Asks whether there is a station."),
    ("slave_diag", &[], "Asks for the diagnosis."),
    ("get_cfg", &[], "Asks for the configuration."),
    ("set_prm", &["bytes"], "Set_Prm with these octets, all of them."),
    ("chk_cfg", &["bytes"], "Chk_Cfg with these octets."),
    ("data_exchange", &["bytes"], "One Data_Exchange with these outputs."),
    ("read_inputs", &[], "RD_Inp."),
    ("read_outputs", &[], "RD_Outp."),
    ("ds_read", &["slot", "index", "length"], "DS_Read over MS1."),
    ("ds_write", &["slot", "index", "bytes"], "DS_Write over MS1."),
    ("broken", &["frame"], "A damaged frame, by its word."),
];
