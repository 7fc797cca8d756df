//! `encspec discover` on PROFIBUS: the stations of a bus; and the slave for which `encspec bench init` writes a bench file.

use super::port::LineArgs;
use super::{CommandError, CommandResult, ListingFormat, list, show};
use live::profibus::survey::{BusSurvey, FoundStation, ReceivedTraffic, survey};
use plain_text::hex;
use report::ExitStatus;
use serde::Serialize;
use std::fmt::Write as _;
use std::time::Duration;
use suite::model::Manual;
use wire::profibus::diag::{NO_MASTER, SlaveDiag, Status2};
use wire::profibus::fdl::StationType;

/// Addresses that a master of the harness may have.
const MASTERS: std::ops::RangeInclusive<u8> = 1..=125;

/// A station that answered.
#[derive(Serialize)]
struct ListedSlave {
    address: u8,
    kind: &'static str,
    ident: Option<u16>,
    /// The master that has parameterised it.
    master: Option<u8>,
    /// The words of the status bits.
    status: Vec<&'static str>,
    /// The bytes of Slave_Diag.
    diagnosis: Option<String>,
    /// The manual with the same ident number.
    suite: Option<String>,
}

/// What was received before anything was sent.
#[derive(Serialize)]
struct ListedTraffic {
    seconds: f64,
    frames: u64,
    masters: Vec<ListedMaster>,
    /// The shortest and the longest time between two tokens of a master.
    token_rotation_ms: Option<[f64; 2]>,
    answering: Vec<ListedAnswer>,
    damaged: u64,
}

#[derive(Serialize)]
struct ListedMaster {
    address: u8,
    tokens: u64,
}

#[derive(Serialize)]
struct ListedAnswer {
    address: u8,
    ident: Option<u16>,
    suite: Option<String>,
}

/// The whole output.
#[derive(Serialize)]
struct SurveyListing {
    line: String,
    baud: u32,
    received: ListedTraffic,
    /// `null` if another station sends, so that nothing was sent.
    stations: Option<Vec<ListedSlave>>,
}

/// The manual with this ident number.
fn manual_of(ident: u16, manuals: &[Manual]) -> Option<&Manual> {
    manuals.iter().find(|manual| manual.device.ident() == Some(ident))
}

fn suite_of(ident: Option<u16>, manuals: &[Manual]) -> Option<String> {
    ident.and_then(|ident| manual_of(ident, manuals)).map(|manual| manual.device.name.clone())
}

impl ListedSlave {
    fn of(found: &FoundStation, manuals: &[Manual]) -> ListedSlave {
        let ident = found.diagnosis.as_ref().map(|diagnosis| diagnosis.ident);
        ListedSlave {
            address: found.address,
            kind: kind(found.kind),
            ident,
            master: found.diagnosis.as_ref().map(|diagnosis| diagnosis.master).filter(|master| *master != NO_MASTER),
            status: found.diagnosis.as_ref().map(status).unwrap_or_default(),
            diagnosis: found.diagnosis.as_ref().map(|diagnosis| hex(&octets(diagnosis))),
            suite: suite_of(ident, manuals),
        }
    }
}

impl ListedTraffic {
    fn of(received: &ReceivedTraffic, manuals: &[Manual]) -> ListedTraffic {
        let millis = |time: Duration| time.as_secs_f64() * 1_000.0;
        let answer = |(address, ident): (&u8, &Option<u16>)| ListedAnswer {
            address: *address,
            ident: *ident,
            suite: suite_of(*ident, manuals),
        };
        ListedTraffic {
            seconds: received.time.as_secs_f64(),
            frames: received.frames,
            masters: received.masters.iter().map(|(&address, &tokens)| ListedMaster { address, tokens }).collect(),
            token_rotation_ms: received.rotation.map(|(shortest, longest)| [millis(shortest), millis(longest)]),
            answering: received.answering.iter().map(answer).collect(),
            damaged: received.damaged.0,
        }
    }
}

fn kind(of: StationType) -> &'static str {
    match of {
        StationType::SLAVE => "slave",
        StationType::MASTER_NOT_READY => "master, not ready for the ring",
        StationType::MASTER_READY => "master, ready for the ring",
        _ => "master in the ring",
    }
}

/// The words of the bits that are set, without the one that every slave sets.
fn status(diagnosis: &SlaveDiag) -> Vec<&'static str> {
    let all = diagnosis.status_1.words().chain(diagnosis.status_2.words()).chain(diagnosis.status_3.words());
    let fixed = Status2::FIXED_ONE.words().next();
    all.filter(|word| Some(*word) != fixed).collect()
}

fn octets(diagnosis: &SlaveDiag) -> Vec<u8> {
    let mut octets = Vec::new();
    diagnosis.write(&mut octets);
    octets
}

fn surveyed(path: &str, line: &LineArgs) -> Result<BusSurvey, CommandError> {
    link::interrupt::watch();
    survey(path, &line.spec(), line.alone).map_err(|error| CommandError::bench(error.to_string()))
}

/// Lists the stations of the bus at the serial line `path`, or what was received from them where another station sends.
pub(super) fn discover(path: &str, line: &LineArgs, format: ListingFormat, manuals: &[Manual]) -> CommandResult {
    let survey = surveyed(path, line)?;
    let listed = |found: &Vec<FoundStation>| found.iter().map(|of| ListedSlave::of(of, manuals)).collect();
    let stations: Option<Vec<ListedSlave>> = survey.stations.as_ref().map(listed);
    let received = ListedTraffic::of(&survey.received, manuals);
    let is_empty =
        stations.as_ref().is_none_or(Vec::is_empty) && received.masters.is_empty() && received.answering.is_empty();
    match format {
        ListingFormat::Json => {
            show(&list::pretty(&SurveyListing { line: survey.line.clone(), baud: survey.baud.0, received, stations }))
        }
        ListingFormat::Text => {
            if !survey.received.is_silent() {
                show(&traffic_text(&survey, &received));
            }
            show(&stations_text(stations.as_deref().unwrap_or_default()));
        }
    }
    match &survey.stations {
        _ if !is_empty => Ok(ExitStatus::Green),
        Some(_) => Err(CommandError::bench(format!("no station answered at {}", survey.line))),
        None => Err(CommandError::bench(format!(
            "nothing that was received at {} is a frame of PROFIBUS; is {} bit/s the rate of the bus?",
            survey.line, survey.baud.0
        ))),
    }
}

fn stations_text(stations: &[ListedSlave]) -> String {
    let mut out = String::new();
    for station in stations {
        // Writing into a String cannot fail.
        let _ = write!(out, "{}  {}", station.address, station.kind);
        let _ = match (station.ident, station.master) {
            (Some(ident), Some(master)) => writeln!(out, ", ident 0x{ident:04X}, parameterised by master {master}"),
            (Some(ident), None) => writeln!(out, ", ident 0x{ident:04X}, not parameterised"),
            (None, _) if station.kind == "slave" => writeln!(out, ", no diagnosis"),
            (None, _) => writeln!(out),
        };
        if let Some(diagnosis) = &station.diagnosis {
            let _ = writeln!(out, "    diagnosis {diagnosis}: {}", station.status.join(", "));
        }
        if station.ident.is_some() {
            let suite =
                station.suite.as_deref().map_or_else(|| "no suite".to_owned(), |suite| format!("suite {suite}"));
            let _ = writeln!(out, "    {suite}");
        }
    }
    out
}

/// What was received, and why nothing was sent.
fn traffic_text(survey: &BusSurvey, received: &ListedTraffic) -> String {
    let mut out = String::new();
    // Writing into a String cannot fail.
    let _ = writeln!(out, "{} is in use; received in {:.1} s:", survey.line, received.seconds);
    for master in &received.masters {
        let _ = writeln!(out, "    master {}, {} tokens", master.address, master.tokens);
    }
    if let Some([shortest, longest]) = received.token_rotation_ms {
        let _ = writeln!(out, "    token rotation {shortest:.1} ms to {longest:.1} ms");
    }
    for answer in &received.answering {
        let ident = answer.ident.map_or_else(String::new, |ident| format!(", ident 0x{ident:04X}"));
        let suite = answer.suite.as_ref().map_or_else(String::new, |suite| format!(", suite {suite}"));
        let _ = writeln!(out, "    station {} answers{ident}{suite}", answer.address);
    }
    if let Some(first) = &survey.received.damaged.1 {
        let _ = writeln!(out, "    {} times {first}", received.damaged);
    }
    if survey.stations.is_none() {
        out.push_str("Nothing was sent. Take the other master off the bus, or say `--alone` if no station on it can be disturbed.\n");
    }
    out
}

/// A slave for a bench file.
pub(super) struct FoundSlave {
    /// Its station address.
    pub address: u8,
    /// Its ident number.
    pub ident: u16,
    /// Addresses for the masters of the harness, which no station on this bus has.
    pub masters: Option<[u8; 2]>,
}

/// The slave at the address `station`, or the only one, of the bus at the serial line `path`.
pub(super) fn find(path: &str, line: &LineArgs, station: Option<&str>) -> Result<FoundSlave, CommandError> {
    let survey = surveyed(path, line)?;
    let Some(stations) = &survey.stations else {
        let received = ListedTraffic::of(&survey.received, &[]);
        return Err(CommandError::bench(traffic_text(&survey, &received).trim_end().to_owned()));
    };
    let found = choose_slave(stations, station)?;
    let address = found.address;
    let ident = found.diagnosis.as_ref().map(|diagnosis| diagnosis.ident);
    let ident =
        ident.ok_or_else(|| CommandError::bench(format!("the slave at station {address} sends no diagnosis")))?;
    let is_free = |address: &u8| stations.iter().all(|of| of.address != *address);
    let mut free = MASTERS.filter(is_free);
    let masters = free.next().zip(free.next()).map(<[u8; 2]>::from);
    Ok(FoundSlave { address, ident, masters })
}

/// The slave at the address `station`, or the only slave.
fn choose_slave<'f>(stations: &'f [FoundStation], station: Option<&str>) -> Result<&'f FoundStation, CommandError> {
    let slaves = || stations.iter().filter(|found| found.kind == StationType::SLAVE);
    let all = || slaves().map(|found| found.address.to_string()).collect::<Vec<_>>().join(", ");
    let mut matching = slaves().filter(|found| station.is_none_or(|station| found.address.to_string() == station));
    match (matching.next(), matching.next(), station) {
        (Some(found), None, _) => Ok(found),
        (Some(_), Some(_), _) => {
            Err(CommandError::usage(format!("several slaves answer; choose one with --station: {}", all())))
        }
        (None, _, Some(station)) if slaves().next().is_some() => Err(CommandError::usage(format!(
            "there is no slave at station {}; found: {}",
            station.escape_default(),
            all()
        ))),
        (None, ..) => Err(CommandError::bench("no slave answered; is it powered, and is this the rate of the bus?")),
    }
}
