//! The contents of a GSDML as text. Texts of the file are escaped.

use super::matching::lengths;
use super::model::{
    AccessPoint, Bits, DataItem, Gsdml, GsdmlModule, GsdmlRecord, GsdmlSubmodule, ItemAccess, ModuleInfo,
    PluggableItem, RecordItem,
};
use plain_text::printable;
use std::fmt::{Result, Write as _};
use std::ops::RangeInclusive;

/// The contents of a GSDML, as text that ends in a line feed.
pub fn show(gsdml: &Gsdml) -> String {
    let mut out = String::new();
    // Writing into a String cannot fail.
    let _ = whole(&mut out, gsdml);
    printable_lines(&out)
}

fn printable_lines(text: &str) -> String {
    text.lines().map(|line| printable(line) + "\n").collect()
}

fn whole(out: &mut String, gsdml: &Gsdml) -> Result {
    let version = if gsdml.version.is_empty() { "without a version" } else { &gsdml.version };
    writeln!(out, "GSDML {version}")?;
    writeln!(out, "  vendor        0x{:04X} {}", gsdml.vendor_id, gsdml.vendor)?;
    writeln!(out, "  device        0x{:04X}", gsdml.device_id)?;
    writeln!(out, "  family        {}, {}", gsdml.family.0, gsdml.family.1)?;
    gsdml.access_points.iter().try_for_each(|point| access_point(out, gsdml, point))?;
    if !gsdml.remarks.is_empty() {
        writeln!(out, "\nerrors in this file")?;
        gsdml.remarks.iter().try_for_each(|remark| writeln!(out, "  {remark}"))?;
    }
    Ok(())
}

/// Ranges as written in the file.
fn ranges<T: PartialEq + std::fmt::Display>(ranges: &[RangeInclusive<T>]) -> String {
    let one = |range: &RangeInclusive<T>| {
        if range.start() == range.end() {
            range.start().to_string()
        } else {
            format!("{}..{}", range.start(), range.end())
        }
    };
    ranges.iter().map(one).collect::<Vec<_>>().join(" ")
}

fn info(out: &mut String, indent: &str, info: &ModuleInfo) -> Result {
    for (word, text) in
        [("order number", &info.order_number), ("hardware", &info.hardware), ("software", &info.software)]
    {
        if !text.is_empty() {
            writeln!(out, "{indent}{word:<14}{text}")?;
        }
    }
    Ok(())
}

fn access_point(out: &mut String, gsdml: &Gsdml, point: &AccessPoint) -> Result {
    writeln!(out, "\naccess point {} ({})", point.info.name, point.id)?;
    writeln!(out, "  ident         0x{:X}", point.ident)?;
    info(out, "  ", &point.info)?;
    writeln!(out, "  slots         {}", ranges(&point.slots))?;
    if point.min_device_interval > 0 {
        let micros = f64::from(point.min_device_interval) * 31.25;
        writeln!(out, "  cycle         from {micros} µs")?;
    }
    for (word, octets) in [("inputs", point.max_input), ("outputs", point.max_output)] {
        if octets > 0 {
            writeln!(out, "  {word:<14}at most {octets} bytes with status")?;
        }
    }
    for (name, value) in &point.features {
        writeln!(out, "  {name} = {value}")?;
    }
    writeln!(out, "  slot {}", point.slot)?;
    submodules(out, gsdml, &point.submodules, &point.pluggable)?;
    for offered in &point.modules {
        let Some(module) = gsdml.modules.get(offered.index) else { continue };
        writeln!(out, "  slot {}{}", ranges(&offered.places), how(offered))?;
        of_module(out, gsdml, module)?;
    }
    Ok(())
}

/// Whether a module or submodule is always there or by default.
fn how(offered: &PluggableItem) -> String {
    match (offered.fixed.is_empty(), offered.used.is_empty()) {
        (false, _) => format!(", always in {}", ranges(&offered.fixed)),
        (true, false) => format!(", by default in {}", ranges(&offered.used)),
        (true, true) => String::new(),
    }
}

fn of_module(out: &mut String, gsdml: &Gsdml, module: &GsdmlModule) -> Result {
    writeln!(out, "    module {} ({}), ident 0x{:X}", module.info.name, module.id, module.ident)?;
    info(out, "      ", &module.info)?;
    submodules(out, gsdml, &module.submodules, &module.pluggable)
}

fn submodules(out: &mut String, gsdml: &Gsdml, built_in: &[GsdmlSubmodule], pluggable: &[PluggableItem]) -> Result {
    built_in.iter().try_for_each(|of| submodule(out, &ranges(&of.subslots), "", of))?;
    for offered in pluggable {
        if let Some(of) = gsdml.submodules.get(offered.index) {
            submodule(out, &ranges(&offered.places), &how(offered), of)?;
        }
    }
    Ok(())
}

fn submodule(out: &mut String, subslots: &str, how: &str, of: &GsdmlSubmodule) -> Result {
    let octets = |octets: Option<u16>| octets.map_or("?".to_owned(), |octets| octets.to_string());
    let (input, output) = lengths(of);
    writeln!(
        out,
        "      subslot {subslots}{how}: {} ({}), ident 0x{:X}, API 0x{:X}, {} bytes in, {} out",
        of.info.name,
        of.id,
        of.ident,
        of.api,
        octets(input),
        octets(output)
    )?;
    for (word, items) in [("in", &of.inputs), ("out", &of.outputs)] {
        items.iter().try_for_each(|item| data_item(out, word, item))?;
    }
    of.records.iter().try_for_each(|of| record(out, of))
}

fn data_item(out: &mut String, word: &str, item: &DataItem) -> Result {
    writeln!(out, "        {word:<4}{} {}", item.kind, item.name)?;
    item.bits.iter().try_for_each(|(bit, name)| writeln!(out, "            bit {bit} {name}"))
}

fn record(out: &mut String, record: &GsdmlRecord) -> Result {
    writeln!(out, "        record 0x{:X} {}, {} bytes", record.index, record.name, record.octets)?;
    record.items.iter().try_for_each(|of| item(out, of))
}

fn item(out: &mut String, item: &RecordItem) -> Result {
    write!(out, "          byte {}", item.octet)?;
    match item.bits {
        Some(Bits { low, width: 1 }) => write!(out, " bit {low}")?,
        Some(Bits { low, width }) => write!(out, " bits {low}..{}", low + width - 1)?,
        None if item.octets > 1 => write!(out, "..{}", item.octet.saturating_add(item.octets - 1))?,
        None => {}
    }
    write!(out, " {}", item.name)?;
    let word = |number: i128| match item.words.iter().find(|(known, _)| *known == number) {
        Some((_, word)) => format!("{number} ({word})"),
        None => number.to_string(),
    };
    if let Some(default) = item.default {
        write!(out, ", default {}", word(default))?;
    }
    if !item.allowed.is_empty() {
        write!(out, ", allowed {}", ranges(&item.allowed))?;
    }
    match item.access {
        ItemAccess::Changeable => writeln!(out),
        ItemAccess::Visible => writeln!(out, ", fixed"),
        ItemAccess::Hidden => writeln!(out, ", hidden"),
    }
}
