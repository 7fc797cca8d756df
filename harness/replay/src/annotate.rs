//! The capture again, for Wireshark: each finding is a comment of its packet, and stations have their names.

use super::finding::CaptureFinding;
use super::report::{CaptureReport, ConnectionReport};
use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use thiserror::Error;
use virtual_wire::capture::{CaptureItem, LinkType, NotACapture};
use virtual_wire::{CaptureReader, PcapngWriter};
use wire::ethernet::Mac;

/// Why a capture could not be written again.
#[derive(Debug, Error)]
pub enum CannotAnnotate {
    /// It cannot be read a second time.
    #[error("it cannot be read again: {0}")]
    Unreadable(#[from] NotACapture),
    /// The output takes no more.
    #[error("it cannot be written: {0}")]
    Unwritable(#[from] io::Error),
}

/// Writes the packets of `input`, the capture of `report`, to `output` as pcapng, with the findings as comments beside those they have.
/// Damaged places of the file are left out. PROFIBUS frames get the user link type `user` (0 to 15), if there is one.
///
/// # Errors
///
/// `input` is no capture any more, or `output` cannot be written.
pub fn annotate(
    report: &CaptureReport,
    input: impl Read,
    output: impl Write,
    user: Option<u8>,
) -> Result<(), CannotAnnotate> {
    let mut comments: BTreeMap<u64, Vec<String>> = BTreeMap::new();
    for finding in &report.findings {
        // What is about the capture as a whole stands at its first packet.
        comments.entry(finding.frame.max(1)).or_default().push(comment(finding));
        for of in &finding.consequences {
            let text = format!(
                "encspec {}: {}. This follows from {} in packet {}.",
                of.id, of.text, finding.id, finding.frame
            );
            comments.entry(of.frame.max(1)).or_default().push(text);
        }
    }
    let mut reader = CaptureReader::new(input)?;
    let mut writer = PcapngWriter::new(output, "encspec")?;
    writer.names(&names(report))?;
    let mut interfaces: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    while let Some(item) = reader.next() {
        let CaptureItem::Packet(packet) = item else { continue };
        let key = (packet.section, packet.interface);
        let interface = match interfaces.get(&key) {
            Some(known) => *known,
            None => {
                let name = format!("interface {} of section {}", packet.interface, packet.section);
                let link = match (packet.link_type, user) {
                    (LinkType::PROFIBUS, Some(user)) => LinkType::user(user),
                    (link, _) => link,
                };
                let new = writer.interface(&name, link)?;
                interfaces.insert(key, new);
                new
            }
        };
        let own = packet.comment.as_deref().map(str::to_owned);
        let found = comments.remove(&(packet.number as u64)).unwrap_or_default();
        let text: Vec<String> = own.into_iter().chain(found).collect();
        let text = (!text.is_empty()).then(|| text.join("\n"));
        writer.cut_packet(interface, packet.time, packet.captured, packet.original_length, text.as_deref())?;
    }
    writer.finish()?;
    Ok(())
}

fn comment(finding: &CaptureFinding) -> String {
    let CaptureFinding { id, severity, blame, text, .. } = finding;
    let text = [&[text.clone()][..], &finding.details].concat().join("; ");
    let next = finding.next.as_ref().map_or_else(String::new, |next| format!(" {next}"));
    format!("encspec {id} ({}, blame: {}): {text}.{next}", severity.word(), blame.word())
}

/// The MAC addresses of the stations whose names the capture shows.
fn names(report: &CaptureReport) -> Vec<(Mac, String)> {
    let of = |ar: &ConnectionReport| {
        [(ar.controller.mac.clone(), ar.controller.station.clone()), (ar.device.mac.clone(), ar.device.station.clone())]
    };
    let known = report.ars.iter().flat_map(of).filter_map(|(mac, station)| Some((mac?.parse().ok()?, station?)));
    let known: BTreeMap<Mac, String> = known.filter(|(_, station): &(Mac, String)| !station.is_empty()).collect();
    known.into_iter().collect()
}
