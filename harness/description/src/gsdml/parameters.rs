//! The items of a GSDML's records as start parameters.

use super::model::{DataType, RecordItem};
use crate::start_parameters::DescribedParameter;

/// An item of a GSDML as a start parameter.
pub(super) fn parameter(item: &RecordItem) -> DescribedParameter {
    let (names, texts) = &item.translations;
    let mut words: Vec<(i128, Vec<String>)> =
        item.words.iter().map(|(number, text)| (*number, vec![text.clone()])).collect();
    for (number, text) in texts {
        if let Some((_, known)) = words.iter_mut().find(|(known, _)| known == number) {
            known.push(text.clone());
        }
    }
    let octets = match (&item.kind, item.bits) {
        (_, Some(bits)) => ((bits.low + bits.width).div_ceil(8) as usize).max(1),
        (DataType::Whole { octets, .. }, _) => usize::from(*octets),
        _ => item.octets,
    };
    let lowest = item.allowed.iter().map(|range| *range.start()).min();
    let highest = item.allowed.iter().map(|range| *range.end()).max();
    DescribedParameter {
        names: [&item.name].into_iter().chain(names).cloned().collect(),
        octet: item.octet,
        octets,
        bits: item.bits.map(|bits| (bits.low, bits.width)),
        range: lowest.zip(highest),
        words,
    }
}
