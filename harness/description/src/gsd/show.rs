//! The contents of a GSD as text.

use super::model::{FieldType, Gsd, GsdField, GsdModule};
use plain_text::hex;
use std::fmt::Write as _;
use wire::profibus::cfg::{Identifier, io_lengths};

/// The contents of a GSD, in lines.
pub fn show(gsd: &Gsd) -> String {
    let mut out = String::new();
    // Writing into a String cannot fail.
    let _ = show_into(gsd, &mut out);
    out
}

fn show_into(gsd: &Gsd, out: &mut String) -> std::fmt::Result {
    let text = |text: &str| text.chars().take(80).collect::<String>().escape_debug().to_string();
    writeln!(out, "{} {}, revision {}", text(&gsd.vendor), text(&gsd.model), text(&gsd.revision))?;
    writeln!(out, "  ident number     0x{:04X}", gsd.ident)?;
    writeln!(out, "  GSD revision     {}", gsd.gsd_revision)?;
    let abilities = [
        (gsd.freeze, "freeze"),
        (gsd.sync, "sync"),
        (gsd.auto_baud, "automatic baud rate"),
        (gsd.set_slave_address, "Set_Slave_Address"),
        (gsd.fail_safe, "fail safe"),
        (gsd.dpv1, "DP-V1"),
        (gsd.isochronous, "isochronous mode"),
    ];
    let able: Vec<&str> = abilities.into_iter().filter_map(|(is, word)| is.then_some(word)).collect();
    writeln!(
        out,
        "  supports         {}",
        if able.is_empty() { "none of the listed features".into() } else { able.join(", ") }
    )?;
    writeln!(out, "  kbit/s           {}", gsd.bauds.join(", "))?;
    if !gsd.max_tsdr.is_empty() {
        let times: Vec<String> = gsd
            .max_tsdr
            .iter()
            .map(|(baud, bits)| format!("{} at {} kbit/s", bits.0, f64::from(baud.0) / 1_000.0))
            .collect();
        writeln!(out, "  max TSDR         {} (bit times)", times.join(", "))?;
    }
    if let Some(longest) = gsd.max_diagnosis {
        writeln!(out, "  diagnosis        up to {longest} bytes")?;
    }
    for module in &gsd.modules {
        writeln!(out, "  module           {}: Chk_Cfg {}{}", text(&module.name), hex(&module.cfg), lengths(module))?;
        writeln!(out, "    user bytes    {}", hex(&gsd.default_octets(module)))?;
        for (at, field) in gsd.fields(module) {
            writeln!(out, "      {:<12} {}", place(at, field), line(field, &text(&field.name)))?;
        }
    }
    Ok(())
}

/// The lengths of the cyclic data of a module; empty if its identifiers cannot be read.
fn lengths(module: &GsdModule) -> String {
    let sums = Identifier::parse_all(&module.cfg).map(|identifiers| io_lengths(&identifiers));
    sums.map_or_else(|_| String::new(), |sums| format!(", {} bytes in, {} out", sums.inputs, sums.outputs))
}

fn place(at: usize, field: &GsdField) -> String {
    match field.kind {
        FieldType::Octets { octets: 1, .. } => format!("{at}"),
        FieldType::Octets { octets, .. } => format!("{at} to {}", at + octets - 1),
        FieldType::Bits { low, high } if low == high => format!("{at} bit {low}"),
        FieldType::Bits { low, high } => format!("{at} bits {low}-{high}"),
    }
}

fn line(field: &GsdField, name: &str) -> String {
    match field.range {
        Some((low, high)) => format!("{name}: default {}, {low} to {high}", field.default),
        None => format!("{name}: default {}", field.default),
    }
}
