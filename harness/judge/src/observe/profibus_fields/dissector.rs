//! Writes the dissector for Wireshark: the fields and words of the table, and a program in Lua that finds them in a frame.

use super::table::{DpField, DpFieldKind, fields};
use std::fmt::Write as _;
use wire::profibus::sap::SlaveSap;

/// The program, with a mark where the fields are inserted.
const PROGRAM: &str = include_str!("dissector.lua");
const FIELDS: &str = "-- FIELDS\n";
const USER: &str = "USER_LINK_TYPE";

/// A dissector in Lua for PROFIBUS frames of the user link type `user`, 0 to 15 (pcap link type 147 to 162).
pub fn dissector(user: u8) -> String {
    let lines: String = fields().iter().map(line).collect();
    let points: String =
        SlaveSap::TABLE.iter().map(|(SlaveSap(sap), word, _)| format!("[{sap}] = \"{word}\", ")).collect();
    let lines = format!("{lines}local SLAVE_SAPS = {{ {points}}}\n");
    PROGRAM.replacen(FIELDS, &lines, 1).replacen(USER, &user.to_string(), 1)
}

fn line(field: &DpField) -> String {
    let DpField { name, title, kind, words } = field;
    let make = match kind {
        DpFieldKind::Decimal => "decimal",
        DpFieldKind::Hexadecimal => "hexadecimal",
        DpFieldKind::Flags => "flags",
        DpFieldKind::Octets => "octets",
        DpFieldKind::Text => "text",
    };
    let mut line = format!("{make}(\"{name}\", \"{title}\"");
    if !words.is_empty() {
        line.push_str(", {\n");
        for (number, word, sentence) in words {
            let _ = writeln!(line, "    {{ {number:#04x}, \"{word}\", \"{sentence}\" }},");
        }
        line.push('}');
    }
    line.push_str(")\n");
    line
}
