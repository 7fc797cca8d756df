//! The text of a new bench file.

use super::init::{FoundDevice, KnownDevice};
use super::mapping::ParameterMapping;
use crate::cli::slaves::FoundSlave;
use ::live::discover::DiscoveredStation;
use description::variant::VariantReading;
use results::bench_file::{BenchFile, Driver, is_station_name};
use std::fmt::Write as _;

/// The text of the bench file of a device that was found.
pub(super) fn bench_file(
    bench: &BenchFile,
    found: &FoundDevice,
    known: &KnownDevice<'_>,
    mapping: Option<&ParameterMapping>,
) -> String {
    let mut out = String::new();
    // Writing into a String cannot fail.
    let _ = match found {
        FoundDevice::Station(found) => {
            let name = if found.name.is_empty() { "no name".to_owned() } else { found.printable_name() };
            let numbers = found.ids.map_or_else(
                || "no vendor and device ID".to_owned(),
                |(vendor, device)| format!("vendor 0x{vendor:04X}, device 0x{device:04X}"),
            );
            let station_type = &found.station_type;
            writeln!(out, "# Bench file of encspec. Found: {} ({name}), {numbers}, type `{station_type}`.", found.mac)
        }
        FoundDevice::Slave(found) => {
            writeln!(
                out,
                "# Bench file of encspec. Found: the slave at station {}, ident 0x{:04X}.",
                found.address, found.ident
            )
        }
    };
    device_line(&mut out, found, known);
    let _ = writeln!(out, "link: {}", bench.link);
    match found {
        FoundDevice::Station(found) => station_lines(&mut out, found),
        FoundDevice::Slave(found) => line_lines(&mut out, bench, found),
    }
    let is_slave = matches!(found, FoundDevice::Slave(_));
    let key = if is_slave { "gsd" } else { "gsdml" };
    match bench.descriptions.first() {
        Some((_, path)) => {
            let _ = writeln!(out, "{key}: {}", path.display());
        }
        None => {
            let file = if is_slave { "vendor.gsd" } else { "GSDML-....xml" };
            let _ = writeln!(out, "\n# The vendor's description of the device.\n# {key}: {file}");
        }
    }
    out.push_str(&mapping.map(ParameterMapping::lines).unwrap_or_default());
    out.push_str(LEDGER);
    if !is_slave {
        out.push_str(NETWORK);
    }
    out.push_str(STAND);
    out.push_str(if is_slave { CONSENT_ON_BUS } else { CONSENT });
    out
}

fn device_line(out: &mut String, found: &FoundDevice, known: &KnownDevice<'_>) {
    let Some(device) = known.manual.map(|manual| &manual.device) else {
        if let FoundDevice::Slave(_) = found {
            out.push_str("# There is no suite for this slave. Write one from its GSD with `encspec suite init --gsd FILE --output my-slave`, and name\n");
            out.push_str("# its folder with `--suites my-slave`.\ndevice: my-slave\n");
            return;
        }
        out.push_str("# There is no suite for this device. Describe it in a file with the keys of device.yaml.\n");
        out.push_str("device: none\ndescription: my-device.yaml\n");
        return;
    };
    if !known.is_certain {
        out.push_str("# The vendor fits this manual, which prints no device ID: is it the right one?\n");
    }
    let read = |reading: &VariantReading| format!("{} is {}", reading.what, reading.value);
    let read: Vec<String> = known.readings.iter().map(read).collect();
    // Writing into a String cannot fail.
    let _ = match &known.left[..] {
        [only] if device.variants.len() > 1 => {
            let _ = writeln!(out, "# Its variant, as read: {}.", read.join("; "));
            writeln!(out, "device: {}/{}", device.name, device.variants[*only])
        }
        [] | [_] => writeln!(out, "device: {}/{}", device.name, device.variants.first().map_or("", String::as_str)),
        left => {
            if let Some(why) = &known.unread {
                let _ = writeln!(out, "# The variant was not read: {}", why.replace('\n', " "));
            } else if read.is_empty() {
                let _ = writeln!(out, "# The variant is open: nothing that was read differs between them.");
            } else {
                let _ = writeln!(out, "# The variant is open: {}.", read.join("; "));
            }
            let _ = writeln!(out, "# {}", device.variant_question(left));
            writeln!(out, "device: {}", device.name)
        }
    };
}

fn station_lines(out: &mut String, found: &DiscoveredStation) {
    // Writing into a String cannot fail.
    let _ = match std::str::from_utf8(&found.name).ok().filter(|name| is_station_name(name)) {
        Some(name) => writeln!(out, "station_name: {name}"),
        None => writeln!(
            out,
            "# The device has no valid name; a run sets this one only with the consent `set_name`.\n# station_name: encoder-1"
        ),
    };
    let _ = writeln!(out, "mac: {}", found.mac);
    let _ = match found.ip {
        Some(ip) => writeln!(
            out,
            "ip: {}\nmask: {}\n# Has the device stored this address? DCP cannot read it, and a run puts it back.\n\
             # ip_permanence: permanent   # or temporary",
            ip.address, ip.mask
        ),
        None => writeln!(
            out,
            "# The device has no IP address; a run sets this one until power-off.\nip: {}",
            super::init::ADDRESS
        ),
    };
}

fn line_lines(out: &mut String, bench: &BenchFile, found: &FoundSlave) {
    out.push_str("line:\n");
    // Writing into a String cannot fail.
    if let Some(baud) = bench.line.baud {
        let _ = writeln!(out, "  baud: {}", baud.0);
    }
    if let Some(driver) = bench.line.driver {
        let _ = writeln!(
            out,
            "  driver: {}",
            match driver {
                Driver::Adapter => "adapter",
                Driver::Port => "port",
            }
        );
    }
    if bench.line.echo {
        out.push_str("  echo: true\n");
    }
    let _ = writeln!(out, "  address: {}", found.address);
    if let Some([first, second]) = found.masters {
        let _ = writeln!(
            out,
            "  masters: [{first}, {second}]           # addresses of encspec that no station on this bus has"
        );
    }
}

/// The keys that discovery cannot know, commented out.
const LEDGER: &str = "
# The ledger of known failures.
# ledger: known-failures.yaml
";

/// Those of a network.
const NETWORK: &str = "
# Web pages whose path and contents the manual does not print; `{}` for a page that is as in device.yaml.
# pages:
#   information: {}

# LLDP stops at a switch. Its cases run only if the cable ends at the device.
# direct_cable: true
";

const STAND: &str = "
# What controls power, shaft and faults. Without it, cases that turn the shaft, switch the power or read LEDs are not applicable.
# stand:
#   hooks: { power: 'relay 1 {value}' }
#   ask: [turn]
#   shaft: [hand]
";

const CONSENT: &str = "
# Lasting changes that are allowed. Without a consent, the cases that need it are not applicable.
# consent:
#   set_name: true
#   set_ip: true
#   factory_reset: true
#   im_records: true
#   nvm_write: 50
#   position_reference: true
#   firmware: true
#   overstress: true
#   alone: true
";

const CONSENT_ON_BUS: &str = "
# Lasting changes that are allowed. Without a consent, the cases that need it are not applicable.
# consent:
#   set_address: true
#   lock_address: true
#   factory_reset: true
#   nvm_write: 50
#   position_reference: true
#   overstress: true
#   alone: true
";
