//! `encspec discover`: lists the stations on a PROFINET segment or a PROFIBUS.

use super::port::{DiscoverySegment, LineArgs, PortArgs, SegmentArgs};
use super::{CommandError, CommandResult, ListingFormat, Suites, list, print_message, show, slaves};
use clap::Args;
use live::discover::DiscoveredStation;
use plain_text::printable;
use report::ExitStatus;
use serde::Serialize;
use std::fmt::Write as _;
use std::time::Duration;
use suite::device::Origin;
use suite::model::Manual;

/// Arguments of `encspec discover`.
#[derive(Debug, Args)]
pub(super) struct DiscoverArgs {
    #[command(flatten)]
    segment: SegmentArgs,
    #[command(flatten)]
    line: LineArgs,
    /// Seconds to wait for answers on PROFINET
    #[arg(long, value_name = "SECONDS", default_value_t = 2, value_parser = clap::value_parser!(u64).range(1..=120))]
    wait: u64,
    /// Output format
    #[arg(long, value_enum, default_value_t)]
    format: ListingFormat,
    #[command(flatten)]
    suites: Suites,
}

/// A station in the output.
#[derive(Serialize)]
struct ListedStation {
    mac: String,
    name: String,
    ip: Option<String>,
    mask: Option<String>,
    gateway: Option<String>,
    vendor_id: Option<u16>,
    device_id: Option<u16>,
    #[serde(rename = "type")]
    station_type: String,
    roles: Vec<&'static str>,
    /// The manual with the same vendor and device ID.
    suite: Option<String>,
    /// Manuals of the same vendor that print no device ID.
    similar: Vec<String>,
}

impl ListedStation {
    fn of(found: &DiscoveredStation, manuals: &[Manual]) -> ListedStation {
        let (suite, similar) = found.ids.map_or_else(Default::default, |ids| suites_for(ids, manuals));
        ListedStation {
            mac: found.mac.to_string(),
            name: if found.name.is_empty() { String::new() } else { found.printable_name() },
            ip: found.ip.map(|ip| ip.address.to_string()),
            mask: found.ip.map(|ip| ip.mask.to_string()),
            gateway: found.ip.map(|ip| ip.gateway.to_string()),
            vendor_id: found.ids.map(|(vendor, _)| vendor),
            device_id: found.ids.map(|(_, device)| device),
            station_type: found.station_type.clone(),
            roles: found.roles.clone(),
            suite,
            similar,
        }
    }
}

/// The manual with these vendor and device IDs, and the manuals of the same vendor that print no device ID.
fn suites_for(ids: (u16, u16), manuals: &[Manual]) -> (Option<String>, Vec<String>) {
    let same = |manual: &&Manual| manual.device.ids() == Some(ids);
    let suite = manuals.iter().find(same).map(|manual| manual.device.name.clone());
    let similar = |manual: &&Manual| {
        let of_vendor = manual.device.ids().is_some_and(|(vendor, _)| vendor == ids.0);
        of_vendor && manual.device.bus.number_origin() == Origin::Invented && !same(manual)
    };
    (suite, manuals.iter().filter(similar).map(|manual| manual.device.name.clone()).collect())
}

pub(super) fn run(args: &DiscoverArgs) -> CommandResult {
    let manuals = args.suites.load()?;
    match args.segment.segment() {
        DiscoverySegment::Line(path) => slaves::discover(&path, &args.line, args.format, &manuals),
        DiscoverySegment::Port(port) => stations(args, &port, &manuals),
    }
}

fn stations(args: &DiscoverArgs, port: &PortArgs, manuals: &[Manual]) -> CommandResult {
    let (survey, opened) = port.survey(Duration::from_secs(args.wait))?;
    let stations: Vec<ListedStation> = survey.stations.iter().map(|found| ListedStation::of(found, manuals)).collect();
    let place = opened.describe();
    match args.format {
        ListingFormat::Json => {
            #[derive(Serialize)]
            struct SurveyReport {
                stations: Vec<ListedStation>,
                remarks: Vec<String>,
            }
            show(&list::pretty(&SurveyReport { stations, remarks: survey.remarks }));
        }
        ListingFormat::Text => {
            show(&text(&stations));
            survey.remarks.iter().for_each(|remark| print_message(remark));
        }
    }
    if survey.stations.is_empty() {
        return Err(CommandError::bench(format!("no station answered at {} within {} s", place, args.wait)));
    }
    Ok(ExitStatus::Green)
}

fn text(stations: &[ListedStation]) -> String {
    let or = |text: &str, without: &str| if text.is_empty() { without.to_owned() } else { printable(text) };
    let mut out = String::new();
    for station in stations {
        let ip = station.ip.as_deref().unwrap_or("no address");
        // Writing into a String cannot fail.
        let _ = writeln!(out, "{}  {ip}  {}", station.mac, or(&station.name, "(no name)"));
        if let (Some(vendor), Some(device)) = (station.vendor_id, station.device_id) {
            let _ =
                write!(out, "    vendor {vendor:#06x}, device {device:#06x}, {}", or(&station.station_type, "no type"));
        } else {
            let _ = write!(out, "    no vendor and device ID, {}", or(&station.station_type, "no type"));
        }
        let _ = writeln!(out, ", {}", or(&station.roles.join(" and "), "no role"));
        let _ = match (&station.suite, station.similar.as_slice()) {
            (Some(suite), _) => writeln!(out, "    suite {suite}"),
            (None, []) => writeln!(out, "    no suite"),
            (None, similar) => {
                writeln!(out, "    no suite for this device ID; suites of this vendor: {}", similar.join(", "))
            }
        };
    }
    out
}
