//! A capture held against a device: heard, driven again, compared.

use super::ask::Ask;
use super::compare::{Difference, Kind, compare, every, firsts};
use super::drive::{Bench, CannotDrive};
use super::follows::{Follows, UNKNOWN};
use super::heard::{Conversation, Heard, Value};
use super::infer::{self, put};
use super::listen::{Ear, Whom};
use super::masks::Masks;
use super::report::{difference, left_out};
use super::timed::Timed;
use super::turn::{Turning, follow};
use engine::DutSpec;
use judge::observe::link_type;
use replay::{AgainstReport, IpReassembler, Reassembled};
use std::io::Read;
use virtual_wire::CaptureReader;
use virtual_wire::capture::{Item, LinkType, NotACapture};

/// Within so many tolerances a difference is the same one in two runs.
const NEAR: u32 = 4;
/// Differences of a turning shaft that are looked at one by one.
const MOST_LOOKED_AT: usize = 5_000;

/// Listens to a capture, pcap or pcapng; of several devices the first one that speaks as the manual has it is followed.
///
/// An error says that `input` is no capture; damage further on is passed over, and what could be read is what was heard.
pub fn hear(input: impl Read, whom: Whom<'_>) -> Result<Heard, NotACapture> {
    let mut reader = CaptureReader::new(input)?;
    let mut ear = Ear::new(whom);
    let mut begin = None;
    let mut datagrams = IpReassembler::default();
    let link = link_type(whom.manual.device.bus.kind());
    while let Some(item) = reader.next() {
        let Item::Packet(packet) = item else { continue };
        begin.get_or_insert(packet.time);
        if packet.link_type != link {
            continue;
        }
        let number = packet.number as u64;
        let reassembled = match link {
            LinkType::ETHERNET => datagrams.take(number, packet.time, packet.captured),
            _ => Reassembled::Untouched,
        };
        match reassembled {
            Reassembled::Untouched => ear.frame(number, packet.time, packet.captured),
            Reassembled::Whole => ear.frame(number, packet.time, datagrams.whole()),
            Reassembled::Part => {}
        }
    }
    Ok(Heard { said: ear.end(), begin: begin.unwrap_or_default() })
}

/// Why a conversation cannot be driven again; none where it can.
pub fn nothing_to_drive(said: &Conversation) -> Option<String> {
    if said.asked.iter().any(|asked| matches!(asked.ask, Ask::Connect(_))) {
        return None;
    }
    Some(match said.asked.is_empty() && said.left_out.is_empty() {
        true => "the capture has no controller that speaks to a device of this manual".to_owned(),
        false => "the capture does not have the start-up of the connection, so it cannot be made again".to_owned(),
    })
}

/// Drives a device with the controller side of what was heard, and compares its answers with the recorded ones.
pub fn hold(bench: &Bench<'_>, dut: &DutSpec, heard: &Heard, masks: &Masks) -> Result<AgainstReport, CannotDrive> {
    let mut report = AgainstReport {
        against: dut.to_string(),
        left_out: heard.said.left_out.iter().map(left_out).collect(),
        inconclusive: nothing_to_drive(&heard.said),
        ..AgainstReport::default()
    };
    if report.inconclusive.is_some() {
        report.masked = masks.names.clone();
        return Ok(report);
    }
    let recorded = &heard.said;
    let mut masks = masks.clone();
    report.steps = Timed::new(recorded).script().len();
    let found = match differences(bench, dut, recorded, &mut masks, &mut report.shaft) {
        Ok(found) => found,
        Err(CannotDrive::Disturbed(why)) => {
            report.inconclusive = Some(why);
            Vec::new()
        }
        Err(error) => return Err(error),
    };
    // What only our own controller asked says nothing about a device, and nothing does behind what could not be done again.
    let depends = |of: &&Difference| recorded.left_out.iter().any(|left| left.covers(of.at));
    let is_theirs = |of: &&Difference| of.kind != Kind::Step || of.first.is_some();
    let whom = bench.whom();
    report.differences =
        found.iter().filter(|of| is_theirs(of) && !depends(of)).map(|of| difference(whom, heard, of)).collect();
    report.masked = masks.names;
    Ok(report)
}

/// In what the device differs, with the shaft as it was found out; `shaft` takes what became of it.
fn differences(
    bench: &Bench<'_>,
    dut: &DutSpec,
    recorded: &Conversation,
    masks: &mut Masks,
    shaft: &mut String,
) -> Result<Vec<Difference>, CannotDrive> {
    let mut timed = Timed::new(recorded);
    let plain = timed.script();
    if dut.live().is_some() {
        "unknown: nobody moves the shaft of a live device as it was moved; it is taken to stand where it stood"
            .clone_into(shaft);
        return without(bench, dut, recorded, masks, &plain);
    }
    let found = infer::shaft(bench, dut, recorded, &plain, None)?;
    *shaft = found.text;
    let Some((name, place)) = found.put else { return without(bench, dut, recorded, masks, &plain) };
    match Turning::of(bench, dut, recorded, (&name, place), &plain)? {
        Err(why) => {
            *shaft = format!("unknown: {why}");
            without(bench, dut, recorded, masks, &plain)
        }
        Ok(None) => {
            let mut steps = plain;
            steps.insert(0, put(place));
            Ok(compare(recorded, &bench.drive(&steps, dut)?, masks))
        }
        Ok(Some(mut turning)) => {
            let again = infer::shaft(bench, dut, recorded, &plain, Some(&turning.first()))?;
            turning.put(again.put.map_or(place, |(_, place)| place));
            follow(bench, dut, recorded, &mut turning, &mut timed)?;
            shaft.push_str(&turning.to_string());
            for (name, period) in masks.periods.iter().filter(|(name, _)| recorded.tracks.contains_key(*name)) {
                shaft.push_str(&format!(
                    "; {name} is measured anew every {} ms and compared within that",
                    period.as_millis()
                ));
            }
            turned(bench, dut, recorded, &turning, &timed, masks)
        }
    }
}

/// The differences where nobody knows the place of the shaft: what follows from it is not compared.
fn without(
    bench: &Bench<'_>,
    dut: &DutSpec,
    recorded: &Conversation,
    masks: &mut Masks,
    steps: &[Ask],
) -> Result<Vec<Difference>, CannotDrive> {
    let healthy = dut.healthy();
    let follows = Follows::of(bench, &healthy, recorded, steps)?;
    masks.names.extend(follows.names().map(|name| (name, UNKNOWN.to_owned())));
    let mut found = compare(recorded, &bench.drive(steps, dut)?, masks);
    found.retain(|of| !follows.explains(of, recorded));
    Ok(found)
}

/// The differences where the shaft turned: it is turned in time, a little early and a little late, and what one of these answers as
/// it was recorded, or the two around it, depends on when exactly the shaft was where.
fn turned(
    bench: &Bench<'_>,
    dut: &DutSpec,
    recorded: &Conversation,
    turning: &Turning,
    timed: &Timed,
    masks: &mut Masks,
) -> Result<Vec<Difference>, CannotDrive> {
    masks.turned.clone_from(&turning.turned);
    masks.circle = turning.circle();
    let tolerance = masks.tolerance(recorded.cycle.unwrap_or_default());
    let window = tolerance * NEAR;
    let tolerance = i64::try_from(tolerance.as_nanos()).unwrap_or(i64::MAX);
    let mut found = every(recorded, &bench.drive(&turning.script(timed, 0), dut)?, masks);
    found.truncate(MOST_LOOKED_AT);
    if found.is_empty() {
        return Ok(found);
    }
    let mut others = Vec::new();
    for ahead in [tolerance, -tolerance] {
        others.push(every(recorded, &bench.drive(&turning.script(timed, ahead), dut)?, masks));
    }
    found.retain(|of| {
        // With another timing it may show before or behind another step.
        let same = |other: &&Difference| (other.kind, &other.name) == (of.kind, &of.name);
        let apart = |other: &&Difference| other.at.since(of.at).max(of.at.since(other.at));
        let near = |other: &&Difference| apart(other) <= window;
        let nearest = |found: &'_ Vec<Difference>| found.iter().filter(same).filter(near).min_by_key(apart).cloned();
        let Some(others) = others.iter().map(nearest).collect::<Option<Vec<_>>>() else {
            return false;
        };
        let number = |value: &Option<Value>| value.as_ref().and_then(|value| value.number);
        let shown: Option<Vec<i128>> = others.iter().chain([of]).map(|of| number(&of.second)).collect();
        let between = number(&of.first).zip(shown).is_some_and(|(recorded, shown)| {
            let (low, high) = (shown.iter().min(), shown.iter().max());
            low.is_some_and(|low| *low <= recorded) && high.is_some_and(|high| recorded <= *high)
        });
        !between
    });
    Ok(firsts(found))
}
