//! Names, settings and services that only PROFINET has, or that mean something else there.

use super::super::keys::{Shape, TableWords, WordChoices};
use super::super::request_keys::SOUGHT;
use super::{Sentences, ServiceEntry};
use controllers::profinet_io::LoadKind;
use wire::profinet::rpc::Uuid;
use wire::snmp::{SnmpPduKind, SnmpVersion};

/// Further names that every device on PROFINET has.
pub(super) const NAMES: Sentences = &[
    ("io.outputs", "the output data as bytes; also of one submodule, then only for `expect`"),
    ("io.inputs", "the input data as bytes; also of one submodule"),
    (
        "io.alarm_acknowledge",
        "how we acknowledge alarms: given (in full), received (by the transport only), held (not at all)",
    ),
    ("io.output_status", "our provider status: good, bad; also of one submodule"),
    ("io.input_status", "the device's provider status: good, bad"),
    ("io.consumer_status", "the device's consumer status: good, bad"),
    ("io.output_data_status", "our DataStatus, 0x35 by default: bit 0 primary, 2 valid, 4 run, 5 no problem"),
    ("io.input_data_status", "the device's DataStatus"),
    ("io.input_counter", "the cycle counter of the device's last frame"),
    ("station.name", "the name of the station"),
    ("station.ip", "its address"),
    ("station.mask", "its subnet mask"),
    ("station.gateway", "its gateway"),
    ("station.vendor_id", "its vendor ID"),
    ("station.device_id", "its device ID"),
    ("station.type", "its type"),
    ("station.mac", "the MAC address with which it answers an Identify now, 6 bytes"),
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
    ("alarm.type", "its type as a word, for instance diagnosis, process, pull"),
    ("alarm.priority", "low, high"),
    ("alarm.payload", "the bytes of its first item after the UserStructureIdentifier"),
    ("alarm.structure", "its UserStructureIdentifier"),
    ("alarm.sequence", "the SequenceNumber of its AlarmSpecifier"),
    ("abort", "the device aborted the connection"),
    ("abort.code", "why, as a word"),
    ("lldp", "the device announced itself to its neighbour"),
    ("lldp.name", "the station name that it announces, as chassis id or after the port id; empty if none"),
    ("lldp.chassis", "the bytes of the chassis id"),
    ("lldp.port", "the port id up to its first dot, `port-001`"),
    ("lldp.mac", "the MAC address in the TLV of PROFINET, 6 bytes; no value without that TLV"),
    ("lldp.source", "the MAC address that the announcement comes from, that of the port, 6 bytes"),
    ("lldp.ttl", "the time to live in seconds"),
    ("lldp.bytes", "all TLVs"),
    ("hello", "the device said Hello by DCP"),
    ("hello.name", "the name of the station in it"),
    ("hello.ip", "the address in it"),
    ("ready", "the device said by ApplicationReady that a plugged or released submodule is ready"),
    ("ready.sequence", "the SequenceNumber of the alarm of that submodule"),
    ("answer.status", "the status of the last web answer"),
    ("answer.contains", "texts that stand in the last web answer"),
    ("answer.lacks", "texts that do not"),
    ("answer.number", "the number that the last object of the last SNMP answer has; no value if it is none"),
    ("answer.text", "the last web answer as displayed text"),
    ("bench.ip", "the address that the bench gives the device"),
    ("bench.mask", "the subnet mask that goes with it"),
    ("bench.free_ip", "an address of the same subnet that no station has"),
];

key_set! {
    pub(crate) connection "a connection on PROFINET" {
        module may Name, "The module.";
        cycle may Time, "The time between two cyclic frames; by default that of the bench, else 4ms.";
        watchdog may Time, "The time without frames after which the connection ends; by default that of the bench, else ten cycles.";
        instead may StartInstead, "What is changed against the right start-up.";
    }
}

/// The services of `send`.
pub(super) static SERVICES: &[ServiceEntry] = &[
    (&dcp_reset::KEYS, "DCP Set that resets the device; `mode` says what is lost."),
    (&dcp_signal::KEYS, "DCP Set that lets the device blink."),
    (
        &dcp_identify::KEYS,
        "DCP Identify by a station name, by `who` (all, own_name), by the alias of its neighbour's port (`port-001.chassis`), or by \
         `filters`; then `answer: { bytes }` are the blocks of the response.",
    ),
    (
        &dcp_get::KEYS,
        "DCP Get; `answer: { bytes }` are the blocks of the response, and the first refused element is the refusal.",
    ),
    (&dcp_set::KEYS, "DCP Set; `answer: { bytes }` are the blocks of the response."),
    (
        &rpc::KEYS,
        "One RPC PDU; `answer: { bytes }` is the kind of the first PDU that answers, as a byte, and its body.",
    ),
    (
        &snmp::KEYS,
        "One SNMP request; `answer: { bytes }` is the kind of the response (`A2`), its error-status and its error-index, a byte each, \
         then name and value of each object, each as type, length and content with the shortest length. Not applicable without `snmp` \
         in `device.yaml`.",
    ),
    (
        &ping::KEYS,
        "One ICMP echo request after an ARP request; `answer: { bytes }` is `01` for a reply with the same data and `00` for another one.",
    ),
    (&record_read::KEYS, "Reads a record by its numbers."),
    (&record_write::KEYS, "Writes a record by its numbers."),
    (
        &records_write::KEYS,
        "Writes several records in one call; `answer: { bytes }` are their PNIO statuses of four bytes each, and the first that is \
         not zero is the refusal.",
    ),
    (
        &load::KEYS,
        "Net load: frames for others and for all, one after the other, beside the cyclic frames; there is no answer. Live only where the \
         bench says `alone`.",
    ),
    (&lldp::KEYS, "Announces a neighbour, once; there is no answer."),
    (
        &arp::KEYS,
        "Asks who has an address, by default the one that the device was last given; accepted if the device says that it has it.",
    ),
    (&arp_probe::KEYS, "The same without a sender address, as a station does before it takes an address."),
    (&abort::KEYS, "Ends the own connection by an ERR-RTA."),
    (&broken::KEYS, "A damaged frame, by its word."),
    (&http_get::KEYS, "Requests a web page of device.yaml."),
    (&http_post::KEYS, "Sends the form of a web page with these texts entered."),
];

key_set! {
    pub(crate) dcp_reset "dcp_reset" {
        mode must Name, "What is reset.";
    }
}

key_set! {
    pub(crate) dcp_signal "dcp_signal" {
    }
}

key_set! {
    pub(crate) dcp_identify "dcp_identify" {
        name may Scalar, "A station name.";
        who may Word(&SOUGHT), "All stations, or the one with the name of the device.";
        alias may Scalar, "The alias of a neighbour's port.";
        filters may Octets, "The filters: option, suboption, length and value of each.";
        delay may Whole(0, 0xFFFF), "ResponseDelayFactor beside `filters`, 1 by default.";
        within may Time, "How long the answer may take beside `filters`, 1s by default.";
    } [OneOf(&[&name, &who, &alias, &filters]), With(&[&delay, &within], &filters)]
}

key_set! {
    pub(crate) dcp_get "dcp_get" {
        elements must Octets, "Option and suboption of each element.";
    }
}

key_set! {
    pub(crate) dcp_set "dcp_set" {
        blocks must Octets, "Option, suboption, length, qualifier and value of each block.";
    }
}

/// The kinds of PDU that a client sends.
pub(in super::super) static PACKETS: WordChoices<u8> =
    WordChoices(&[("request", 0), ("ping", 1), ("ack", 7), ("cancel", 8)]);

/// The interfaces that can be called; `unknown` is none that exists.
pub(in super::super) static INTERFACES: WordChoices<Uuid> = WordChoices(&[
    ("device", Uuid::DEVICE_INTERFACE),
    ("controller", Uuid::CONTROLLER_INTERFACE),
    ("supervisor", Uuid::SUPERVISOR_INTERFACE),
    ("parameter_server", Uuid::PARAMETER_SERVER_INTERFACE),
    ("endpoint_mapper", Uuid::ENDPOINT_MAPPER),
    ("unknown", Uuid([0x7F; 16])),
]);

/// The objects that can be called.
pub(in super::super) static OBJECTS: WordChoices<Option<Uuid>> =
    WordChoices(&[("device", None), ("nil", Some(Uuid::NIL)), ("unknown", Some(Uuid([0x7F; 16])))]);

key_set! {
    pub(crate) rpc "rpc" {
        packet may Word(&PACKETS), "The kind of the PDU, `request` by default.";
        interface may Word(&INTERFACES), "The interface, `device` by default.";
        interface_version may Whole(0, 0xFFFF_FFFF), "Its version, 1 by default, and 3 for the endpoint mapper.";
        object may Word(&OBJECTS), "The object, `device` by default, and `nil` for the endpoint mapper.";
        opnum must Whole(0, 0xFFFF), "The operation.";
        activity may Only("last"), "`last`: the activity of the last `rpc` of the case; by default a new one.";
        sequence may Whole(0, 0xFFFF_FFFF), "The sequence number within the activity, 0 by default.";
        server_boot may Whole(0, 0xFFFF_FFFF), "The boot time of the device that the client claims to know, 0 (none) by default.";
        byte_order may Only("little"), "`little`: header and NDR are little-endian.";
        blocks may Octets, "The blocks after an NDR header that fits.";
        body may Octets, "The whole body; empty without `blocks` and `body`.";
        fragment may Whole(8, 1392), "The bytes of the body in each fragment; by default it is sent in one piece where it fits.";
        sent may NonEmpty(&Shape::Whole(0, 0xFFFF)), "The numbers of the fragments that are sent, in this order; all by default.";
        ip_fragment may Whole(8, 1480), "The bytes of each datagram in an IP fragment, a multiple of 8; by default it is sent in one piece.";
        ip_sent may NonEmpty(&Shape::Whole(0, 0xFFFF)), "The numbers of the IP fragments that are sent, in this order; all by default.";
    } [NotBoth(&blocks, &body), With(&[&ip_sent], &ip_fragment)]
}

/// The frames of a net load.
pub(in super::super) static LOADS: TableWords =
    TableWords(|| LoadKind::TABLE.iter().map(|(_, word, _)| *word).collect());

key_set! {
    pub(crate) load "load" {
        frames must Word(&LOADS), "ARP requests for another address, DCP Identify for another name, frames to another multicast address, datagrams to all, or DCP frames that end before their blocks.";
        count must Whole(1, 100_000), "How many frames are sent.";
        gap may Time, "The time from one frame to the next, 1ms by default.";
    }
}

key_set! {
    pub(crate) ping "ping" {
        length may Whole(0, 8000), "The number of bytes of data, 32 by default; they count from 0 on.";
        ip may Scalar, "The address that is asked, by default that of the device; the frame goes to the device all the same.";
        wrong_checksum may Flag, "The checksum of the request is wrong.";
        ip_fragment may Whole(8, 1480), "The bytes of the request in an IP fragment, a multiple of 8; by default as many as fit in a frame.";
        ip_sent may NonEmpty(&Shape::Whole(0, 0xFFFF)), "The numbers of the IP fragments that are sent, in this order; all by default.";
    }
}

/// The requests of an SNMP manager.
pub(in super::super) static SNMP_REQUESTS: WordChoices<SnmpPduKind> = WordChoices(&[
    ("get", SnmpPduKind::GET),
    ("get_next", SnmpPduKind::GET_NEXT),
    ("get_bulk", SnmpPduKind::GET_BULK),
    ("set", SnmpPduKind::SET),
    ("response", SnmpPduKind::RESPONSE),
]);

/// The versions of SNMP that have communities.
pub(in super::super) static SNMP_VERSIONS: WordChoices<SnmpVersion> =
    WordChoices(&[("v1", SnmpVersion::V1), ("v2c", SnmpVersion::V2C)]);

key_set! {
    pub(crate) snmp "snmp" {
        request may Word(&SNMP_REQUESTS), "The kind of the request, `get` by default; `response` is none, and no agent answers it.";
        names may Scalar, "The names of the objects, such as '1.3.6.1.2.1.1.1.0', with blanks between.";
        value may Octets, "The value beside each name as type, length and content; NULL (`05 00`) by default.";
        version may Word(&SNMP_VERSIONS), "The version, `v2c` by default.";
        community may Scalar, "The community, `public` by default.";
        non_repeaters may Whole(0, 0xFFFF), "In a `get_bulk` the number of names that are not repeated, 0 by default.";
        repetitions may Whole(0, 0xFFFF), "In a `get_bulk` how often the others are repeated, 0 by default.";
        bytes may Octets, "The whole message instead.";
    } [OneOf(&[&names, &bytes]), With(&[&request, &value, &version, &community, &non_repeaters, &repetitions], &names)]
}

key_set! {
    pub(crate) records_write "records_write" {
        records must NonEmpty(&Shape::Keys(&record_write::KEYS)), "The records in their order.";
    }
}

key_set! {
    pub(crate) record_read "record_read" {
        slot must Whole(0, 0xFFFF), "The slot.";
        subslot must Whole(0, 0xFFFF), "The subslot.";
        index must Whole(0, 0xFFFF), "The index.";
        api may Whole(0, 0xFFFF_FFFF), "The API; by default that of the submodule.";
        implicit may Flag, "Without a connection (ReadImplicit).";
        length must Whole(0, 0xFFFF_FFFF), "How many bytes are read at most.";
    }
}

key_set! {
    pub(crate) record_write "record_write" {
        slot must Whole(0, 0xFFFF), "The slot.";
        subslot must Whole(0, 0xFFFF), "The subslot.";
        index must Whole(0, 0xFFFF), "The index.";
        api may Whole(0, 0xFFFF_FFFF), "The API; by default that of the submodule.";
        bytes must Octets, "The data.";
    }
}

key_set! {
    pub(crate) lldp "lldp" {
        chassis must Scalar, "The chassis id.";
        port must Scalar, "The port id.";
    }
}

key_set! {
    pub(crate) arp "arp" {
        ip may Scalar, "The address.";
    }
}

key_set! {
    pub(crate) arp_probe "arp_probe" {
        ip may Scalar, "The address.";
    }
}

key_set! {
    pub(crate) abort "abort" {
    }
}

key_set! {
    pub(crate) broken "broken" {
        frame must Name, "The word of the damaged frame.";
    }
}

key_set! {
    pub(crate) http_get "http_get" {
        page must Name, "The page.";
    }
}

key_set! {
    pub(crate) http_post "http_post" {
        page must Name, "The page.";
        fields must Map(&Scalar), "What is entered in its fields.";
    }
}
