//! Compares a capture with a device: extracts the conversation, drives it again, and compares the answers.

use super::action::ControllerAction;
use super::compare::{Difference, DifferenceKind, compare, every, firsts};
use super::conversation::{Conversation, RecordedConversation, SuiteValue};
use super::drive::{CannotDrive, ScriptBench};
use super::extract::{ConversationReader, ManualVariant};
use super::masks::Masks;
use super::report::{difference, left_out};
use super::shaft_dependence::{ShaftDependence, UNKNOWN};
use super::shaft_motion::{ShaftMotion, adapt};
use super::shaft_position::{self, set_shaft};
use super::timed_script::TimedScript;
use engine::DutSpec;
use judge::observe::link_type;
use replay::{AgainstReport, IpReassembler, Reassembled};
use std::io::Read;
use virtual_wire::CaptureReader;
use virtual_wire::capture::{CaptureItem, LinkType, NotACapture};

/// Two runs have the same difference if its times are within this many tolerances.
const NEAR: u32 = 4;
/// Upper limit of the differences of a turning shaft that are checked one by one.
const MOST_LOOKED_AT: usize = 5_000;

/// Extracts the conversation from a capture, pcap or pcapng; of several devices that fit the manual it follows the first.
///
/// # Errors
///
/// `input` is not a capture. Damage after its begin is skipped.
pub fn extract_capture(input: impl Read, whom: ManualVariant<'_>) -> Result<RecordedConversation, NotACapture> {
    let mut reader = CaptureReader::new(input)?;
    let mut ear = ConversationReader::new(whom);
    let mut begin = None;
    let mut datagrams = IpReassembler::default();
    let link = link_type(whom.manual.device.bus.kind());
    while let Some(item) = reader.next() {
        let CaptureItem::Packet(packet) = item else { continue };
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
    Ok(RecordedConversation { conversation: ear.end(), begin: begin.unwrap_or_default() })
}

/// Why a conversation cannot be driven again; `None` if it can.
pub fn not_drivable(said: &Conversation) -> Option<String> {
    if said.actions.iter().any(|asked| matches!(asked.ask, ControllerAction::Connect(_))) {
        return None;
    }
    let is_empty = said.actions.is_empty() && said.left_out.is_empty();
    let why = if is_empty {
        "the capture has no controller that connects to a device of this manual"
    } else {
        "the capture does not have the start-up of the connection, so it cannot be repeated"
    };
    Some(why.to_owned())
}

/// Drives a device with the controller side of a capture, and compares its answers with the recorded ones.
pub fn compare_capture(
    bench: &ScriptBench<'_>,
    dut: &DutSpec,
    conversation: &RecordedConversation,
    masks: &Masks,
) -> Result<AgainstReport, CannotDrive> {
    let mut report = AgainstReport {
        against: dut.to_string(),
        left_out: conversation.conversation.left_out.iter().map(left_out).collect(),
        inconclusive: not_drivable(&conversation.conversation),
        ..AgainstReport::default()
    };
    if report.inconclusive.is_some() {
        report.masked = masks.names.clone();
        return Ok(report);
    }
    let recorded = &conversation.conversation;
    let mut masks = masks.clone();
    report.steps = TimedScript::new(recorded).script().len();
    let found = match differences(bench, dut, recorded, &mut masks, &mut report.shaft) {
        Ok(found) => found,
        Err(CannotDrive::Disturbed(why)) => {
            report.inconclusive = Some(why);
            Vec::new()
        }
        Err(error) => return Err(error),
    };
    // Actions of the harness's own controller say nothing about a device, and nothing counts after actions that cannot be repeated.
    let depends = |of: &&Difference| recorded.left_out.iter().any(|left| left.covers(of.at));
    let is_theirs = |of: &&Difference| of.kind != DifferenceKind::Step || of.first.is_some();
    let whom = bench.manual_variant();
    report.differences =
        found.iter().filter(|of| is_theirs(of) && !depends(of)).map(|of| difference(whom, conversation, of)).collect();
    report.masked = masks.names;
    Ok(report)
}

/// The differences of the device, with the shaft position as inferred; `shaft` receives a sentence about it.
fn differences(
    bench: &ScriptBench<'_>,
    dut: &DutSpec,
    recorded: &Conversation,
    masks: &mut Masks,
    shaft: &mut String,
) -> Result<Vec<Difference>, CannotDrive> {
    let mut timed = TimedScript::new(recorded);
    let plain = timed.script();
    if dut.live().is_some() {
        "unknown: encspec cannot move the shaft of a live device as it was recorded".clone_into(shaft);
        return without_shaft(bench, dut, recorded, masks, &plain);
    }
    let found = shaft_position::shaft(bench, dut, recorded, &plain, None)?;
    *shaft = found.text;
    let Some((name, place)) = found.put else { return without_shaft(bench, dut, recorded, masks, &plain) };
    match ShaftMotion::of(bench, dut, recorded, (&name, place), &plain)? {
        Err(why) => {
            *shaft = format!("unknown: {why}");
            without_shaft(bench, dut, recorded, masks, &plain)
        }
        Ok(None) => {
            let mut steps = plain;
            steps.insert(0, set_shaft(place));
            Ok(compare(recorded, &bench.drive(&steps, dut)?, masks))
        }
        Ok(Some(mut turning)) => {
            let again = shaft_position::shaft(bench, dut, recorded, &plain, Some(&turning.first()))?;
            turning.put(again.put.map_or(place, |(_, place)| place));
            adapt(bench, dut, recorded, &mut turning, &mut timed)?;
            shaft.push_str(&turning.to_string());
            for (name, period) in masks.periods.iter().filter(|(name, _)| recorded.tracks.contains_key(*name)) {
                shaft.push_str(&format!(
                    "; {name} is updated every {} ms and compared within that time",
                    period.as_millis()
                ));
            }
            with_turning_shaft(bench, dut, recorded, &turning, &timed, masks)
        }
    }
}

/// The differences if the shaft position is unknown: values that depend on it are not compared.
fn without_shaft(
    bench: &ScriptBench<'_>,
    dut: &DutSpec,
    recorded: &Conversation,
    masks: &mut Masks,
    steps: &[ControllerAction],
) -> Result<Vec<Difference>, CannotDrive> {
    let reference = dut.without_deviations();
    let follows = ShaftDependence::of(bench, &reference, recorded, steps)?;
    masks.names.extend(follows.names().map(|name| (name, UNKNOWN.to_owned())));
    let mut found = compare(recorded, &bench.drive(steps, dut)?, masks);
    found.retain(|of| !follows.explains(of, recorded));
    Ok(found)
}

/// The differences if the shaft turned. It is turned in time, a little early and a little late; a value that one of these runs has
/// as recorded, or that lies between two of them, depends on the exact position of the shaft.
fn with_turning_shaft(
    bench: &ScriptBench<'_>,
    dut: &DutSpec,
    recorded: &Conversation,
    turning: &ShaftMotion,
    timed: &TimedScript,
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
        // With another timing it may occur before or after another step.
        let same = |other: &&Difference| (other.kind, &other.name) == (of.kind, &of.name);
        let apart = |other: &&Difference| other.at.since(of.at).max(of.at.since(other.at));
        let near = |other: &&Difference| apart(other) <= window;
        let nearest = |found: &'_ Vec<Difference>| found.iter().filter(same).filter(near).min_by_key(apart).cloned();
        let Some(others) = others.iter().map(nearest).collect::<Option<Vec<_>>>() else {
            return false;
        };
        let number = |value: &Option<SuiteValue>| value.as_ref().and_then(|value| value.number);
        let values: Option<Vec<i128>> = others.iter().chain([of]).map(|of| number(&of.second)).collect();
        let between = number(&of.first).zip(values).is_some_and(|(recorded, values)| {
            let (low, high) = (values.iter().min(), values.iter().max());
            low.is_some_and(|low| *low <= recorded) && high.is_some_and(|high| recorded <= *high)
        });
        !between
    });
    Ok(firsts(found))
}
