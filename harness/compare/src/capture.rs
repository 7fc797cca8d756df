//! Compares a capture with a device: extracts the conversation, drives it again, and compares the answers.

use super::action::ControllerAction;
use super::compare::Difference;
use super::conversation::{Conversation, RecordedConversation};
use super::drive::{CannotDrive, ScriptBench};
use super::extract::{ConversationReader, ManualVariant};
use super::masks::Masks;
use super::report::{difference, left_out};
use super::shaft_fit::{ShaftFit, counts, differences};
use super::timed_script::TimedScript;
use super::unseen::UnseenCauses;
use engine::DutSpec;
use judge::observe::link_type;
use replay::{AgainstReport, DifferenceReport, IpReassembler, Reassembled};
use std::io::Read;
use virtual_wire::CaptureReader;
use virtual_wire::capture::{CaptureItem, LinkType, NotACapture};

/// Extracts the conversation from a capture, pcap or pcapng; of several devices that fit the manual it follows the first.
///
/// # Errors
///
/// `input` is not a capture. Damage after its begin is skipped.
pub fn extract_capture(input: impl Read, whom: ManualVariant<'_>) -> Result<RecordedConversation, NotACapture> {
    let mut reader = CaptureReader::new(input)?;
    let mut ear = ConversationReader::new(whom);
    // A device with other idents than those of the manual, which only its description has, is followed if none fits better.
    let mut relaxed = ConversationReader::of_any_identity(whom);
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
        let octets = match reassembled {
            Reassembled::Untouched => packet.captured,
            Reassembled::Whole => datagrams.whole(),
            Reassembled::Part => continue,
        };
        ear.frame(number, packet.time, octets);
        relaxed.frame(number, packet.time, octets);
    }
    let conversation = Some(ear.end()).filter(|fits| not_drivable(fits).is_none()).unwrap_or_else(|| relaxed.end());
    Ok(RecordedConversation { conversation, begin: begin.unwrap_or_default() })
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
    let mut fit = ShaftFit::default();
    let found = match differences(bench, dut, recorded, (&mut masks, &[]), &mut fit) {
        Ok(found) => found,
        Err(CannotDrive::Disturbed(why)) => {
            report.inconclusive = Some(why);
            Vec::new()
        }
        Err(error) => return Err(error),
    };
    let found: Vec<Difference> = found.into_iter().filter(|of| counts(recorded, of)).collect();
    let whom = bench.manual_variant();
    let explained = if found.is_empty() || dut.live().is_some() {
        vec![None; found.len()]
    } else {
        UnseenCauses { bench, recorded, masks: &masks, fit: &fit }.explain(dut, &found)?
    };
    report.differences = found
        .iter()
        .zip(explained)
        .map(|(of, explained)| DifferenceReport { explained, ..difference(whom, conversation, of) })
        .collect();
    report.shaft = fit.text;
    report.masked = masks.names;
    Ok(report)
}
