//! Positions of names on the wire, and the choice of the position that shows a failure best.

use super::view::NameView;
use crate::observe::FrameDirection;
use expression::NameId;
use results::outcome::JudgedPart;
use suite::device::{DiagnosisName, NameKind};

/// A position on the wire: frame number, byte in the frame, and for a single bit the bit in that byte.
pub type WirePosition = (u64, usize, Option<u8>);

/// The position of the last value of a name on the wire.
pub fn place_of(name: NameId, view: &NameView<'_>) -> Option<WirePosition> {
    match view.variant.names.get(name.0 as usize)? {
        NameKind::Signal { signal, low, width, .. } => {
            let (frame, octet) = view.image.place_of(*signal)?;
            let of = view.device.signals.get(*signal)?;
            // The byte that comes first of those with bits of the name.
            let first =
                if of.little_endian { low / 8 } else { (of.width / 8 - 1).saturating_sub((low + width - 1) / 8) };
            Some((frame, octet + first as usize, (*width == 1).then_some((low % 8) as u8)))
        }
        NameKind::Diagnosis(name) => {
            let place = view.image.diagnosis()?.place;
            let (octet, bit) = in_diagnosis(*name, view)?;
            Some((place.frame, place.at + octet, bit))
        }
        _ => None,
    }
}

/// Whether a name is in the cyclic data to the controller.
pub fn is_input(name: NameId, view: &NameView<'_>) -> bool {
    match view.variant.names.get(name.0 as usize) {
        Some(NameKind::Signal { signal, .. }) => view.image.direction(*signal) == Some(FrameDirection::ToController),
        _ => false,
    }
}

/// The offset in Slave_Diag, 0 is the first of the six standard bytes, and the bit.
fn in_diagnosis(name: DiagnosisName, view: &NameView<'_>) -> Option<(usize, Option<u8>)> {
    Some(match name {
        DiagnosisName::Bit { octet, bit } => (usize::from(octet), Some(bit)),
        DiagnosisName::Master => (3, None),
        DiagnosisName::Ident => (4, None),
        DiagnosisName::Field(index) => {
            let field = view.device.profibus()?.diagnosis.fields.get(index)?;
            let bit = field.bits.and_then(|(low, width)| (width == 1).then_some(u8::try_from(low).ok()).flatten());
            (field.octet, bit)
        }
        DiagnosisName::Length
        | DiagnosisName::Bytes
        | DiagnosisName::Errors
        | DiagnosisName::Alarm(_)
        | DiagnosisName::MasterLock => return None,
    })
}

/// The position that shows a failure best: that of a name in a part that does not hold, else the first one.
pub fn decisive(
    places: &[(NameId, Option<WirePosition>)],
    parts: &[JudgedPart],
    view: &NameView<'_>,
) -> Option<WirePosition> {
    let of_part = |name: &str| parts.iter().any(|part| !part.held && part.text.contains(name));
    let spot = places.iter().filter(|(_, place)| place.is_some()).find(|(name, _)| {
        match view.variant.names.get(name.0 as usize) {
            Some(NameKind::Signal { signal, .. }) => {
                view.device.signals.get(*signal).is_some_and(|signal| of_part(&signal.name))
            }
            Some(NameKind::Diagnosis(_)) => of_part(&view.name(*name)),
            _ => false,
        }
    });
    spot.or_else(|| places.iter().find(|(_, place)| place.is_some())).and_then(|(_, place)| *place)
}
