//! Texts for parties, durations and statuses in findings.

use judge::observe::{Address, ArId, FrameDirection, ObservedAr, Party};
use wire::profinet::status::PnioStatus;

/// The connection of an id.
pub(super) fn of(ars: &[ObservedAr], ArId(index): ArId) -> Option<&ObservedAr> {
    ars.get(index as usize)
}

/// The sender of a direction, with its role in the connection; a letter where the capture does not show the roles.
pub(super) fn sender(ar: &ObservedAr, direction: FrameDirection) -> String {
    if !ar.roles_known {
        return match direction {
            FrameDirection::ToController => format!("station A ({})", party(&ar.device)),
            FrameDirection::ToDevice => format!("station B ({})", party(&ar.controller)),
        };
    }
    match (direction, ar.controller.address) {
        (FrameDirection::ToController, Address::Mac(_)) => format!("device {}", party(&ar.device)),
        (FrameDirection::ToController, Address::Fdl(_)) => format!("slave {}", party(&ar.device)),
        (FrameDirection::ToDevice, Address::Mac(_)) => format!("controller {}", party(&ar.controller)),
        (FrameDirection::ToDevice, Address::Fdl(_)) => format!("master {}", party(&ar.controller)),
    }
}

/// The device of a connection, or `a device`.
pub(super) fn device(ars: &[ObservedAr], ar: Option<ArId>) -> String {
    ar.and_then(|ar| of(ars, ar)).map_or_else(|| "a device".to_owned(), |ar| sender(ar, FrameDirection::ToController))
}

/// Station name and address of a party.
pub(super) fn party(party: &Party) -> String {
    match &party.station {
        Some(station) => format!("'{station}' ({})", party.address),
        None => party.address.to_string(),
    }
}

/// A PNIO status as a sentence with its numbers, and the faulty field that it names.
pub(super) fn status(status: &PnioStatus) -> String {
    let field = status.faulty_field().map(|field| format!(", field {field}")).unwrap_or_default();
    match status.sentence() {
        Some(sentence) => format!("{}{field} [{status}]", sentence.trim_end_matches('.')),
        None => format!("{status}{field}"),
    }
}

pub(super) use plain_text::span;

/// ` (3 times, last in frame 7)`, or nothing for once.
pub(super) fn times(count: u64, last: u64) -> String {
    if count > 1 { format!(" ({count} times, last in frame {last})") } else { String::new() }
}
