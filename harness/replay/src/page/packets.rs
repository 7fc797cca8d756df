//! The packets of the findings, divided into their parts: the protocol fields of every frame, then the signals of the manual.

use super::unsigned;
use crate::clock::{CaptureClock, wall_clock};
use crate::fits_manual;
use judge::image::ConnectionImage;
use judge::observe::{ArId, FrameDirection, FramePart, ObservedAr, anatomy};
use judge::view::bits;
use report::page::PagePacket;
use station::Time;
use std::collections::BTreeMap;
use std::ops::Range;
use suite::device::{Bus, DeviceDescription, PerBus};
use suite::model::Manual;
use virtual_wire::capture::LinkType;

/// The cyclic data in a packet: their connection and direction, and the offset of the data area.
#[derive(Clone, Copy, Debug)]
pub(super) struct PacketData {
    pub bus: Bus,
    pub ar: ArId,
    pub direction: FrameDirection,
    pub at: usize,
}

#[derive(Debug)]
struct StoredPacket {
    seconds: f64,
    wall_clock: Option<String>,
    link: LinkType,
    octets: Vec<u8>,
    carries: Option<PacketData>,
}

/// The packets of the findings.
#[derive(Debug, Default)]
pub(super) struct Packets {
    clock: CaptureClock,
    wanted: BTreeMap<u64, Option<StoredPacket>>,
    ars: PerBus<Vec<ObservedAr>>,
}

impl Packets {
    /// Keeps these packets.
    pub fn new(numbers: impl Iterator<Item = u64>) -> Packets {
        Packets { wanted: numbers.map(|number| (number, None)).collect(), ..Packets::default() }
    }

    /// Takes in a packet; returns whether it is kept.
    pub fn keep(&mut self, number: u64, time: Time, link: LinkType, octets: &[u8]) -> bool {
        self.clock.take(time);
        let Some(kept) = self.wanted.get_mut(&number) else { return false };
        let (seconds, wall_clock) = (self.clock.seconds(time), wall_clock(time));
        *kept = Some(StoredPacket { seconds, wall_clock, link, octets: octets.to_vec(), carries: None });
        true
    }

    /// Notes that a kept packet carries cyclic data.
    pub fn carries(&mut self, number: u64, seen: PacketData) {
        if let Some(Some(kept)) = self.wanted.get_mut(&number) {
            kept.carries = Some(seen);
        }
    }

    /// Sets the connections of the capture.
    pub fn connections(&mut self, profinet: &[ObservedAr], profibus: &[ObservedAr]) {
        self.ars = PerBus { profinet: profinet.to_vec(), profibus: profibus.to_vec() };
    }

    /// The time of a packet, in seconds since the first one.
    pub fn seconds(&self, number: u64) -> Option<f64> {
        Some(self.wanted.get(&number)?.as_ref()?.seconds)
    }

    /// A packet in its parts, with the byte and the bit to mark.
    pub fn packet(&self, number: u64, mark: Option<(usize, Option<u8>)>, manuals: &[Manual]) -> Option<PagePacket> {
        let kept = self.wanted.get(&number)?.as_ref()?;
        let mut parts = anatomy(kept.link, &kept.octets, &self.ars.profinet);
        if let Some(seen) = kept.carries {
            let ars = self.ars.of(seen.bus);
            let ar = ars.get(seen.ar.0 as usize);
            let manual = ar.and_then(|ar| manuals.iter().find(|manual| fits_manual(manual, ar)));
            if let (Some(ar), Some(manual)) = (ar, manual) {
                let mut image = ConnectionImage::new(&manual.device);
                image.open(&manual.device, ar);
                parts = with_signals(parts, &manual.device, &image, seen, &kept.octets);
            }
        }
        let wall_clock = kept.wall_clock.as_ref().map_or_else(String::new, |time| format!(" ({time})"));
        let head = format!("Packet {number}, {:.6} s{wall_clock}, {} bytes", kept.seconds, kept.octets.len());
        Some(PagePacket { head, octets: kept.octets.clone(), parts, mark })
    }
}

/// Divides the data area at the bounds of the signals of the manual.
fn with_signals(
    parts: Vec<FramePart>,
    device: &DeviceDescription,
    image: &ConnectionImage,
    seen: PacketData,
    octets: &[u8],
) -> Vec<FramePart> {
    let mut signals: Vec<(Range<usize>, usize)> = Vec::new();
    for signal in 0..device.signals.len() {
        if let Some((direction, place)) = image.octets_of_signal(signal)
            && direction == seen.direction
        {
            signals.push((place.start + seen.at..place.end + seen.at, signal));
        }
    }
    signals.sort_by_key(|(place, _)| place.start);
    let mut cut = Vec::with_capacity(parts.len() + signals.len());
    for part in parts {
        let mut at = part.octets.start;
        for (place, signal) in &signals {
            if place.start >= at && place.end <= part.octets.end {
                if place.start > at {
                    cut.push(FramePart { octets: at..place.start, ..part.clone() });
                }
                let value = value(device, *signal, octets.get(place.clone()).unwrap_or_default());
                cut.push(FramePart { octets: place.clone(), name: device.signals[*signal].name.clone(), value });
                at = place.end;
            }
        }
        if at < part.octets.end {
            cut.push(FramePart { octets: at..part.octets.end, ..part });
        }
    }
    cut
}

/// A signal as hexadecimal number, with its bit groups and the bits that are set.
fn value(device: &DeviceDescription, signal: usize, octets: &[u8]) -> String {
    let signal = &device.signals[signal];
    let all = unsigned(octets);
    let mut text = format!("0x{all:0width$X}", width = octets.len() * 2);
    if signal.fields.is_empty() {
        text += &format!(" ({all})");
    }
    for field in &signal.fields {
        let number = bits(all, field.low, field.width, false);
        let word = field.words.iter().find(|(_, value)| *value == number).map(|(word, _)| word.as_str());
        match (field.width, number, word) {
            (_, 0, None) => {}
            (1, _, _) => text += &format!(", {}", field.name),
            (_, _, Some(word)) => text += &format!(", {} = {word}", field.name),
            (_, number, None) => text += &format!(", {} = {number}", field.name),
        }
    }
    text
}
