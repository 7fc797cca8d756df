//! Requests beside the handshakes: records, parameters, station, services and start-ups, right ones and ones broken on purpose.

use crate::draw::Draw;
use crate::names::SequenceNames;
use crate::step::SequenceStep;
use compare::action::{ConnectAction, ControllerAction, mapping};

/// Indices of records that the standards give: I&M, parameter access, diagnosis, log book, connections, ports.
const INDICES: [u32; 24] = [
    0xAFF0, 0xAFF1, 0xAFF2, 0xAFF3, 0xAFF4, 0xAFF5, 0xB02E, 0xBF00, 0x8000, 0x8001, 0x8028, 0x8029, 0x802A, 0x802B,
    0x802F, 0x800A, 0x800C, 0xC00A, 0xE00A, 0xE00C, 0xF000, 0xF840, 0xF841, 0x7FFE,
];
/// Fields of a Connect request that are drawn.
const CONNECT_FIELDS: [&str; 20] = [
    "ar_version",
    "ar_type",
    "ar_properties",
    "activity_timeout",
    "iocr_version",
    "iocr_type",
    "iocr_lt",
    "iocr_properties",
    "data_length",
    "frame_id",
    "send_clock",
    "reduction",
    "phase",
    "watchdog_factor",
    "data_hold_factor",
    "expected_module",
    "module_properties",
    "data_description",
    "alarm_cr_type",
    "rta_timeout",
];
const STATION_NAMES: [&str; 8] =
    ["'enc-1'", "'enc-2'", "'encoder'", "''", "'enc.line-1'", "'-enc'", "'enc_1'", "'port-001'"];
/// Blocks of DCP Set and elements of DCP Get.
const DCP_ELEMENTS: [&str; 10] =
    ["02 01", "02 02", "02 03", "02 05", "02 07", "01 02", "01 01", "02 06", "05 03", "01 02 02 02 02 03"];
const DCP_BLOCKS: [&str; 6] = [
    "02 02 00 07 00 01 65 6E 63 2D 31 00",
    "02 02 00 07 00 00 65 6E 63 2D 31 00",
    "01 02 00 0E 00 00 C0 A8 00 0B FF FF FF 00 00 00 00 00",
    "02 03 00 06 00 00 00 01 00 02",
    "05 03 00 04 00 00 01 00",
    "09 01 00 02 00 00",
];

/// Services with a frame count bit, which can be repeated.
const REPEATED: [&str; 4] = ["ds_read", "slave_diag", "get_cfg", "data_exchange"];

/// A request to a device of the manual; `None` if the manual has none of the kind that was drawn.
pub(crate) fn draw(names: &SequenceNames, module: &str, draw: &mut Draw) -> Option<SequenceStep> {
    match draw.between(0, 99) {
        0..=17 => whole_record(names, draw),
        18..=29 => several_parameters(names, draw),
        30..=44 => wrong_parameter_request(names, draw),
        45..=52 => written_record(names, draw),
        53..=58 => second(names, module, draw),
        _ if names.on_profinet => Some(profinet(names, draw)),
        _ => Some(profibus(names, draw)),
    }
}

/// Reads everything that the manual names: what is found at one time decides what has to be found later.
pub(crate) fn everything(names: &SequenceNames, draw: &mut Draw) -> Vec<SequenceStep> {
    let mut steps: Vec<SequenceStep> = Vec::new();
    let read = |names: &[String]| SequenceStep::from(ControllerAction::Read(names.to_vec()));
    steps.extend(names.readable.chunks(1 + draw.between(3, 12) as usize).map(read));
    steps.extend(names.records.iter().filter(|_| draw.chance(40)).map(|(_, fields)| read(fields)));
    if names.on_profinet {
        steps.push(read(&["station.name", "station.ip", "station.mask"].map(str::to_owned)));
    } else {
        steps.push(SequenceStep::send("slave_diag", "{}"));
    }
    steps
}

fn whole_record(names: &SequenceNames, draw: &mut Draw) -> Option<SequenceStep> {
    let (_, fields) = draw.one(&names.records)?;
    Some(ControllerAction::Read(fields.clone()).into())
}

fn several_parameters(names: &SequenceNames, draw: &mut Draw) -> Option<SequenceStep> {
    let first = draw.between(0, names.readable.len().saturating_sub(1) as u64) as usize;
    let count = draw.between(1, 12) as usize;
    let read: Vec<String> = names.readable.iter().skip(first).take(count).cloned().collect();
    (!read.is_empty()).then(|| ControllerAction::Read(read).into())
}

fn wrong_parameter_request(names: &SequenceNames, draw: &mut Draw) -> Option<SequenceStep> {
    let wrong = match draw.between(0, 11) {
        0 => format!("reference: {}", draw.between(0, 255)),
        1 => format!("request: {}", draw.one(&[0, 3, 4, 0x40, 0x81, 0xFF])?),
        2 => format!("do_id: {}", draw.one(&[0, 1, 2, 255])?),
        3 => format!("count: {}", draw.one(&[0, 2, 3, 39, 40, 255])?),
        4 => format!("attribute: {}", draw.one(&[0, 0x10, 0x20, 0x30, 0x80, 0xF0])?),
        5 => format!("elements: {}", draw.one(&[0, 1, 2, 3, 8, 234, 255])?),
        6 | 7 => format!("subindex: {}", draw.one(&[0, 1, 2, 3, 7, 16, 255, 65535])?),
        8 => format!("length: {}", draw.one(&[0, 1, 3, 4, 9, 10, 11, 12, 200, 241])?),
        9 => format!("format: {}", draw.one(&[1, 2, 3, 4, 5, 6, 7, 8, 0x41, 0x42, 0x43, 0x44, 0xFF])?),
        10 => format!("values: {}", draw.one(&[0, 2, 3, 255])?),
        _ => format!("bytes: \"{}\"", octets(draw, 12)),
    };
    let is_of_write = wrong.starts_with("format") || wrong.starts_with("values");
    let step: SequenceStep = if is_of_write || draw.chance(30) {
        let (name, width) = draw.one(&names.writable)?;
        ControllerAction::Write(vec![(name.clone(), draw.number(*width).to_string())]).into()
    } else {
        ControllerAction::Read(vec![draw.one(&names.readable)?.clone()]).into()
    };
    Some(step.with("instead", format!("{{ {wrong} }}")))
}

/// A record as bytes: one of the start-up while the connection is established, I&M, or any other.
fn written_record(names: &SequenceNames, draw: &mut Draw) -> Option<SequenceStep> {
    if !names.on_profinet {
        let (slot, index) = (draw.between(0, 3), *draw.one(&[0, 1, 2, 47, 255])?);
        return Some(SequenceStep::send(
            "ds_write",
            format!("{{ slot: {slot}, index: {index}, bytes: \"{}\" }}", octets(draw, 16)),
        ));
    }
    let (slot, subslot) = *draw.one(&names.places)?;
    let (index, bytes) = match draw.between(0, 3) {
        0 => (0xAFF1, format!("00 21 00 38 01 00 {}", vec!["41"; 54].join(" "))),
        1 => (0xAFF2, format!("00 22 00 12 01 00 {}", vec!["32"; 16].join(" "))),
        2 => (0xAFF3, format!("00 23 00 38 01 00 {}", vec!["42"; 54].join(" "))),
        _ => (*draw.one(&INDICES)?, octets(draw, 24)),
    };
    Some(SequenceStep::send(
        "record_write",
        format!("{{ slot: {slot}, subslot: 0x{subslot:X}, index: 0x{index:X}, bytes: \"{bytes}\" }}"),
    ))
}

/// A request of the second controller or master.
fn second(names: &SequenceNames, module: &str, draw: &mut Draw) -> Option<SequenceStep> {
    let step: SequenceStep = match draw.between(0, 2) {
        0 => {
            // The loader takes names of the module that was connected last.
            let module = module.to_owned();
            ControllerAction::Connect(ConnectAction { module, ..ConnectAction::default() }).into()
        }
        1 => ControllerAction::Disconnect.into(),
        _ => whole_record(names, draw)?,
    };
    Some(step.with("as", "second"))
}

fn profinet(names: &SequenceNames, draw: &mut Draw) -> SequenceStep {
    let place = *draw.one(&names.places).unwrap_or(&(0, 1));
    let any = |list: &[&'static str], draw: &mut Draw| *draw.one(list).unwrap_or(&"");
    match draw.between(0, 13) {
        0..=3 => {
            let (slot, subslot) =
                if draw.chance(90) { place } else { (draw.between(0, 5) as u16, draw.between(0, 3) as u16) };
            let index = *draw.one(&INDICES).unwrap_or(&0xAFF0);
            let length = *draw.one(&[4096, 4096, 4096, 0, 8, 240]).unwrap_or(&4096);
            let implicit = if draw.chance(20) { ", implicit: true" } else { "" };
            SequenceStep::send(
                "record_read",
                format!("{{ slot: {slot}, subslot: 0x{subslot:X}, index: 0x{index:X}, length: {length}{implicit} }}"),
            )
        }
        4 => {
            let name = any(&STATION_NAMES, draw);
            ControllerAction::Write(vec![("station.name".to_owned(), name.to_owned())]).into()
        }
        5 => {
            let ip = any(&["=bench.ip", "=bench.free_ip", "0.0.0.0", "=bench.address"], draw);
            let mask = any(&["=bench.mask", "=bench.mask", "255.255.255.128", "0.0.0.0", "255.0.255.0"], draw);
            let gateway = any(&["=bench.address", "0.0.0.0", "=bench.ip"], draw);
            let entries = [("station.ip", ip), ("station.mask", mask), ("station.gateway", gateway)];
            ControllerAction::Write(entries.map(|(name, value)| (name.to_owned(), value.to_owned())).to_vec()).into()
        }
        6 => {
            let names =
                ["name", "ip", "mask", "gateway", "vendor_id", "device_id", "type"].map(|of| format!("station.{of}"));
            ControllerAction::Read(names.to_vec()).into()
        }
        7 => SequenceStep::send("dcp_get", format!("{{ elements: \"{}\" }}", any(&DCP_ELEMENTS, draw))),
        8 => SequenceStep::send("dcp_set", format!("{{ blocks: \"{}\" }}", any(&DCP_BLOCKS, draw))),
        9 => {
            let who = ["all", "own_name", "own_id", "other_vendor", "other_device", "own_type", "other_type"];
            let fields = if draw.chance(70) {
                format!("{{ who: {} }}", any(&who, draw))
            } else if draw.chance(50) {
                format!("{{ name: {} }}", any(&["'enc-1'", "'encoder'", "'enc-2'", "'no-such-station'"], draw))
            } else {
                "{ alias: 'port-002.neighbour' }".to_owned()
            };
            SequenceStep::send("dcp_identify", fields)
        }
        10 => {
            let mode = any(&["factory", "communication", "application", "all", "engineering", "device"], draw);
            SequenceStep::send("dcp_reset", format!("{{ mode: {mode} }}"))
        }
        11 => SequenceStep::send("lldp", format!("{{ chassis: 'neighbour', port: 'port-00{}' }}", draw.between(1, 3))),
        12 => SequenceStep::send(any(&["arp", "arp_probe", "dcp_signal"], draw), "{}"),
        _ => {
            let opnum = draw.between(0, 7);
            let packet = any(&["request", "ping", "cancel"], draw);
            let interface = any(&["device", "controller", "endpoint_mapper", "unknown"], draw);
            SequenceStep::send("rpc", format!("{{ packet: {packet}, interface: {interface}, opnum: {opnum} }}"))
        }
    }
}

fn profibus(names: &SequenceNames, draw: &mut Draw) -> SequenceStep {
    let slot = draw.between(0, 3);
    let step = match draw.between(0, 14) {
        0 => {
            let index = *draw.one(&[0, 1, 2, 47, 255]).unwrap_or(&47);
            let length = *draw.one(&[0, 1, 10, 240]).unwrap_or(&240);
            SequenceStep::send("ds_read", format!("{{ slot: {slot}, index: {index}, length: {length} }}"))
        }
        1 => SequenceStep::send("im_read", format!("{{ slot: {slot}, record: {} }}", draw.between(0, 3))),
        2 => {
            let ident = if draw.chance(80) { names.ident } else { 0x1234 };
            let (new, lock) =
                (draw.one(&[20, 3, 126, 127]).copied().unwrap_or(20), if draw.chance(80) { 0 } else { 255 });
            SequenceStep::send("set_slave_address", format!("{{ new: {new}, ident: 0x{ident:X}, lock: {lock} }}"))
        }
        3 => SequenceStep::send("data_exchange", format!("{{ bytes: \"{}\" }}", octets(draw, 8))),
        4 => SequenceStep::send("set_prm", format!("{{ bytes: \"{}\" }}", octets(draw, 32))),
        5 => SequenceStep::send("chk_cfg", format!("{{ bytes: \"{}\" }}", octets(draw, 3))),
        6 => {
            let bit = draw
                .one(&["clear: 1", "freeze: 1", "sync: 1", "unfreeze: 1", "unsync: 1", "clear: 0"])
                .unwrap_or(&"clear: 1");
            SequenceStep::send("global_control", format!("{{ {bit}, group: {} }}", draw.between(0, 3)))
        }
        7 => {
            SequenceStep::send("access_point", format!("{{ sap: {} }}", draw.one(&[48, 49, 52, 53, 54]).unwrap_or(&48)))
        }
        8 => SequenceStep::send("ms2_initiate", "{}"),
        9 => SequenceStep::send(
            "ms2_read",
            format!("{{ slot: {slot}, index: {}, length: 240 }}", draw.one(&[47, 255, 1]).unwrap_or(&47)),
        ),
        10 => SequenceStep::send("ms2_abort", "{}"),
        11 => SequenceStep::send("ms2_im_read", format!("{{ slot: {slot}, record: 0 }}")),
        12 => SequenceStep::send("get_cfg", "{}"),
        13 => SequenceStep::send("fdl_status", "{}"),
        _ => SequenceStep::send("slave_diag", "{}"),
    };
    match &step.action {
        ControllerAction::Send { service, .. } if REPEATED.contains(&service.as_str()) && draw.chance(15) => {
            step.with("repeats", draw.between(1, 3).to_string())
        }
        _ => step,
    }
}

/// What is wrong on purpose in a start-up.
pub(crate) fn wrong_start(
    names: &SequenceNames,
    start_records: &[String],
    draw: &mut Draw,
) -> Option<(String, String)> {
    let entry = |name: &str, value: String| Some((name.to_owned(), value));
    if !names.on_profinet {
        return match draw.between(0, 12) {
            0 => entry("ident", "0x1234".to_owned()),
            1 => entry("lock", (*draw.one(&["unlock", "both", "neither"])?).to_owned()),
            2 => entry("freeze_req", "1".to_owned()),
            3 => entry("sync_req", "1".to_owned()),
            4 => entry("watchdog_factors", format!("[{}, {}]", draw.between(0, 3), draw.between(0, 20))),
            5 => entry("min_tsdr", draw.one(&[0, 11, 60, 255])?.to_string()),
            6 => entry("groups", draw.between(0, 255).to_string()),
            7 => entry("output_length", draw.between(0, 20).to_string()),
            8 => entry("chk_cfg", format!("\"{}\"", octets(draw, 4))),
            9 => entry("chk_cfg", "none".to_owned()),
            10 => entry("set_prm", "none".to_owned()),
            11 => entry("user_octets", format!("\"{}\"", octets(draw, 30))),
            _ => entry(
                "dpv1",
                format!("\"{:02X} {:02X} {:02X}\"", draw.between(0, 255), draw.between(0, 255), draw.between(0, 255)),
            ),
        };
    }
    match draw.between(0, 12) {
        0 => entry("output_length", draw.between(0, 40).to_string()),
        1 => entry("input_length", draw.between(0, 40).to_string()),
        2 => entry("module_ident", format!("0x{:X}", draw.number(32))),
        3 => entry("submodule_ident", format!("0x{:X}", draw.number(32))),
        4 => entry("api", draw.one(&[0, 0x3D00, 0x3A00])?.to_string()),
        5 => entry("station_name", "'other-name'".to_owned()),
        6 => entry("rt_class", draw.between(1, 3).to_string()),
        7 => entry("slot", draw.between(0, 3).to_string()),
        8 => entry("dap_ident", format!("0x{:X}", draw.number(32))),
        9 => entry("byte_order", "little".to_owned()),
        10 | 11 => {
            let field = (*draw.one(&CONNECT_FIELDS)?).to_owned();
            let value = draw.number(16).to_string();
            entry("fields", mapping(&[(field, value)]))
        }
        _ => {
            let record = draw.one(start_records)?.clone();
            Some((record, if draw.chance(50) { "none".to_owned() } else { format!("\"{}\"", octets(draw, 40)) }))
        }
    }
}

/// Up to `most` random bytes, at least one.
fn octets(draw: &mut Draw, most: u64) -> String {
    let count = draw.between(1, most);
    let octets: Vec<String> = (0..count).map(|_| format!("{:02X}", draw.number(8))).collect();
    octets.join(" ")
}
