//! Names, settings and services that only PROFINET has, or that mean something else there.

use super::{Sentences, ServiceEntry};

/// Names that every device on PROFINET has besides.
pub(super) const NAMES: Sentences = &[
    ("io.outputs", "the output data as octets; also of one submodule, then only for `expect`"),
    ("io.inputs", "the input data as octets; also of one submodule"),
    (
        "io.alarm_acknowledge",
        "how we acknowledge alarms: given (in full), received (by the transport only), held (not at all)",
    ),
    ("io.output_status", "our provider status: good, bad; also of one submodule"),
    ("io.input_status", "the device's provider status: good, bad"),
    ("io.consumer_status", "the device's consumer status: good, bad"),
    ("station.name", "the name of the station"),
    ("station.ip", "its address"),
    ("station.mask", "its subnet mask"),
    ("station.gateway", "its gateway"),
    ("station.vendor_id", "its vendor ID"),
    ("station.device_id", "its device ID"),
    ("station.type", "its type"),
    ("station.mac", "the MAC address with which it answers an Identify now, 6 octets"),
    (
        "device",
        "as_delivered: one as it was delivered takes its place, without an address or anything stored, with the name that it comes with",
    ),
    ("alarm", "an alarm came"),
    ("alarm.change", "appears, disappears, all_disappear, disappears_others_remain"),
    ("alarm.error", "a word of codes.channel_error"),
    ("alarm.severity", "diagnosis, maintenance_required, maintenance_demanded"),
    ("alarm.slot", "its slot"),
    ("alarm.subslot", "its subslot"),
    ("alarm.channel", "its channel"),
    ("alarm.structure", "its UserStructureIdentifier"),
    ("abort", "the device aborted the connection"),
    ("abort.code", "why, as a word"),
    ("lldp", "the device announced itself to its neighbour"),
    ("lldp.name", "the station name that it tells there, as chassis id or behind the port id; empty if none"),
    ("lldp.chassis", "the octets of the chassis id"),
    ("lldp.port", "the port id up to its first dot, `port-001`"),
    ("lldp.mac", "the MAC address in the TLV of PROFINET, 6 octets; no value without that TLV"),
    ("lldp.source", "the MAC address that the announcement comes from, that of the port, 6 octets"),
    ("answer.status", "the status of the last web answer"),
    ("answer.contains", "texts that stand in the last web answer"),
    ("answer.lacks", "texts that do not"),
    ("answer.text", "the last web answer as a reader sees it"),
    ("bench.ip", "the address that the bench gives the device"),
    ("bench.mask", "the subnet mask that goes with it"),
    ("bench.free_ip", "an address of the same subnet that nobody has"),
];

/// The keys of `start` and `connect` besides start parameters, each with its sentence.
pub(super) const SETTINGS: Sentences = &[
    ("module", "the module"),
    ("cycle", "the time between two cyclic frames; by default that of the bench, else 4ms"),
    (
        "watchdog",
        "the time without frames after which the connection ends; by default that of the bench, else ten cycles",
    ),
    ("instead", "what is changed against the right start-up"),
];

/// The keys of `instead` in a parameter request that say where its record stands.
pub(super) const PLACE: &[&str] = &["slot", "subslot", "api"];

/// The services of `send`.
pub(super) const SERVICES: &[ServiceEntry] = &[
    ("dcp_reset", &["mode"], "DCP Set that resets the device; `mode` says what is lost."),
    ("dcp_signal", &[], "DCP Set that lets the device blink."),
    (
        "dcp_identify",
        &["name", "who", "alias"],
        "DCP Identify by a station name, by `who` (all, own_name), or by the alias of its neighbour's port: \
         `port-001.chassis`.",
    ),
    ("record_read", &["slot", "subslot", "index", "length"], "Reads a record by its numbers."),
    ("record_write", &["slot", "subslot", "index", "bytes"], "Writes a record by its numbers."),
    ("lldp", &["chassis", "port"], "Announces a neighbour, once; nobody answers."),
    (
        "arp",
        &["ip"],
        "Asks who has an address, by default the one that the device was last given; accepted if the device says that it has it.",
    ),
    ("arp_probe", &["ip"], "The same with no address of our own, as by somebody who wants to take the address."),
    ("abort", &[], "Ends the own connection by an ERR-RTA."),
    ("broken", &["frame"], "A damaged frame, by its word."),
    ("http_get", &["page"], "Asks for a web page of device.yaml."),
    ("http_post", &["page", "fields"], "Sends the form of a web page with these texts entered."),
];
