//! The fields of PROFIBUS frames: names, formats and words. `encspec dissect --fields` and the dissector for Wireshark share them.

use std::sync::LazyLock;
use wire::profibus::diag::{ChannelType, DpAlarmType, ErrorType, Status1, Status2, Status3, StatusType};
use wire::profibus::dpv1::{Dpv1AbortReason, Dpv1ErrorDecode, Dpv1Function, RecordError, Subnet};
use wire::profibus::fdl::{AnswerFunction, RequestFunction, StartDelimiter, StationType};
use wire::profibus::global_control::GlobalCommand;
use wire::profibus::prm::{Dpv1Status1, Dpv1Status2, Dpv1Status3, PrmBlockType, StationStatus};

/// What a field holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DpFieldKind {
    /// A number, shown in decimal.
    Decimal,
    /// A number, shown in hexadecimal.
    Hexadecimal,
    /// A byte of bits; each word is the name of a further field for one bit.
    Flags,
    /// Bytes.
    Octets,
    /// A text.
    Text,
}

/// A field of a PROFIBUS frame.
#[derive(Clone, Debug)]
pub struct DpField {
    /// The name, after `profibus.`.
    pub name: &'static str,
    /// The name in the tree of Wireshark.
    pub title: &'static str,
    /// What it holds.
    pub kind: DpFieldKind,
    /// Number, word and sentence of the values or bits with a name.
    pub words: Vec<(u32, &'static str, &'static str)>,
}

/// The words of a code or of bits.
macro_rules! words {
    ($of:ty) => {
        <$of>::TABLE.iter().map(|(code, word, sentence)| (u32::from(code.0), *word, *sentence)).collect()
    };
}

/// The words of the frame count, by its bits FCV and FCB.
const COUNTS: [(u32, &str, &str); 4] = [
    (0, "unused", "No frame count."),
    (1, "first", "The first request to a station."),
    (2, "zero", "Frame count 0."),
    (3, "one", "Frame count 1."),
];

/// The bits of the third byte of DP-V1 in Set_Prm.
const STATUS_3: [(u32, &str, &str); 3] = [
    (Dpv1Status3::PRM_STRUCTURE as u32, "prm_structure", "Structured blocks follow."),
    (Dpv1Status3::ISOCHRONOUS as u32, "isochronous", "The slave works isochronously."),
    (Dpv1Status3::PRM_COMMAND as u32, "prm_command", "A redundancy command is among the blocks."),
];

/// All fields.
pub fn fields() -> &'static [DpField] {
    static FIELDS: LazyLock<Vec<DpField>> = LazyLock::new(table);
    &FIELDS
}

fn table() -> Vec<DpField> {
    use DpFieldKind::{Decimal, Flags, Hexadecimal, Octets, Text};
    let plain = |name, title, kind| DpField { name, title, kind, words: Vec::new() };
    let coded = |name, title, kind, words| DpField { name, title, kind, words };
    vec![
        coded("start", "Start delimiter", Hexadecimal, words!(StartDelimiter)),
        plain("length", "Length", Decimal),
        plain("da", "Destination", Decimal),
        plain("sa", "Source", Decimal),
        plain("fc", "Function code", Hexadecimal),
        coded("request", "Request function", Hexadecimal, words!(RequestFunction)),
        coded("count", "Frame count", Decimal, COUNTS.to_vec()),
        coded("answer", "Answer function", Hexadecimal, words!(AnswerFunction)),
        coded("station", "Station type", Decimal, words!(StationType)),
        plain("da.segment", "Destination segment", Decimal),
        plain("da.sap", "Destination SAP", Decimal),
        plain("sa.segment", "Source segment", Decimal),
        plain("sa.sap", "Source SAP", Decimal),
        plain("fcs", "Checksum", Hexadecimal),
        plain("service", "Service", Text),
        plain("damaged", "Damaged", Decimal),
        plain("data", "Data", Octets),
        coded("prm.status", "Station status", Flags, words!(StationStatus)),
        plain("prm.watchdog_factor_1", "Watchdog factor 1", Decimal),
        plain("prm.watchdog_factor_2", "Watchdog factor 2", Decimal),
        plain("prm.watchdog", "Watchdog (ms)", Decimal),
        plain("prm.min_tsdr", "min TSDR", Decimal),
        plain("prm.ident", "Ident number", Hexadecimal),
        plain("prm.groups", "Groups", Hexadecimal),
        coded("prm.dpv1_status_1", "DP-V1 status 1", Flags, words!(Dpv1Status1)),
        coded("prm.dpv1_status_2", "DP-V1 status 2", Flags, words!(Dpv1Status2)),
        coded("prm.dpv1_status_3", "DP-V1 status 3", Flags, STATUS_3.to_vec()),
        plain("prm.alarm_mode", "Alarm mode", Decimal),
        plain("prm.user", "User parameters", Octets),
        coded("block.type", "Block type", Decimal, words!(PrmBlockType)),
        plain("block.slot", "Block slot", Decimal),
        plain("block.data", "Block data", Octets),
        plain("iso.t_base_dp", "T_BASE_DP", Decimal),
        plain("iso.t_dp", "T_DP", Decimal),
        plain("iso.t_mapc", "T_MAPC", Decimal),
        plain("iso.t_base_io", "T_BASE_IO", Decimal),
        plain("iso.t_i", "T_I", Decimal),
        plain("iso.t_o", "T_O", Decimal),
        plain("iso.t_dx", "T_DX", Decimal),
        plain("iso.t_pll_w", "T_PLL_W", Decimal),
        plain("iso.t_pll_d", "T_PLL_D", Decimal),
        plain("cfg.outputs", "Bytes of outputs", Decimal),
        plain("cfg.inputs", "Bytes of inputs", Decimal),
        plain("cfg.manufacturer", "Manufacturer data", Octets),
        plain("cfg.all_outputs", "Bytes of outputs in all", Decimal),
        plain("cfg.all_inputs", "Bytes of inputs in all", Decimal),
        coded("diag.status_1", "Station status 1", Flags, words!(Status1)),
        coded("diag.status_2", "Station status 2", Flags, words!(Status2)),
        coded("diag.status_3", "Station status 3", Flags, words!(Status3)),
        plain("diag.master", "Master", Decimal),
        plain("diag.ident", "Ident number", Hexadecimal),
        plain("diag.device", "Device-related diagnosis", Octets),
        coded("diag.alarm", "Alarm type", Decimal, words!(DpAlarmType)),
        coded("diag.status_type", "Status type", Hexadecimal, words!(StatusType)),
        plain("diag.slot", "Slot", Decimal),
        plain("diag.specifier", "Specifier", Hexadecimal),
        plain("diag.identifier", "Identifier with a diagnosis", Decimal),
        plain("diag.channel.identifier", "Identifier of the channel", Decimal),
        plain("diag.channel.direction", "Direction of the channel", Decimal),
        plain("diag.channel.number", "Channel", Decimal),
        coded("diag.channel.type", "Channel type", Decimal, words!(ChannelType)),
        coded("diag.channel.error", "Channel error", Decimal, words!(ErrorType)),
        plain("diag.revision", "Revision", Decimal),
        coded("control.command", "Command", Flags, words!(GlobalCommand)),
        plain("control.groups", "Groups", Hexadecimal),
        plain("address.new", "New address", Decimal),
        plain("address.ident", "Ident number", Hexadecimal),
        plain("address.no_change", "No further change", Decimal),
        plain("address.data", "Stored by the slave", Octets),
        coded("dpv1.function", "Function", Hexadecimal, words!(Dpv1Function)),
        plain("dpv1.slot", "Slot", Decimal),
        plain("dpv1.index", "Index", Decimal),
        plain("dpv1.length", "Length of the record", Decimal),
        plain("dpv1.record", "Record", Octets),
        plain("dpv1.sap", "SAP of the connection", Decimal),
        plain("dpv1.send_timeout", "Send timeout (10 ms)", Decimal),
        plain("dpv1.most_data", "Maximum length of data", Decimal),
        plain("dpv1.features", "Features", Octets),
        plain("dpv1.profile_features", "Profile features", Octets),
        plain("dpv1.profile", "Profile", Hexadecimal),
        plain("dpv1.source", "Source address", Octets),
        plain("dpv1.destination", "Destination address", Octets),
        coded("dpv1.subnet", "Subnet", Decimal, words!(Subnet)),
        coded("dpv1.reason", "Reason", Hexadecimal, words!(Dpv1AbortReason)),
        plain("dpv1.alarm_type", "Alarm type", Decimal),
        plain("dpv1.specifier", "Specifier", Hexadecimal),
        coded("dpv1.error_decode", "Error decode", Hexadecimal, words!(Dpv1ErrorDecode)),
        coded("dpv1.error_code_1", "Error code 1", Hexadecimal, words!(RecordError)),
        plain("dpv1.error_code_2", "Error code 2", Hexadecimal),
        plain("dpv1.more", "More data", Octets),
    ]
}
