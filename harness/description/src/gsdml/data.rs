//! The data of a submodule in a GSDML: the cyclic data, and the records that are written at start-up.

use super::model::{Bits, DataItem, DataType, GsdmlRecord, ItemAccess, RecordItem};
use super::xml::{GsdmlDocument, below, child, children, data_type, numeral};
use roxmltree::Node;

/// The longest record that the services can transfer, in bytes.
const LONGEST: usize = 65_535;

/// Input and output data of a submodule.
pub(super) fn cyclic<'d>(page: &GsdmlDocument<'d>, node: Node<'d, 'd>) -> (Vec<DataItem>, Vec<DataItem>) {
    let items =
        |direction| below(node, &["IOData", direction, "DataItem"]).into_iter().map(|node| item(page, node)).collect();
    (items("Input"), items("Output"))
}

fn item<'d>(page: &GsdmlDocument<'d>, node: Node<'d, 'd>) -> DataItem {
    let kind = node.attribute("DataType").unwrap_or_default();
    let (_, octets) = data_type(kind, page.number(node, "Length"));
    if octets.is_none() {
        page.remark(node, &format!("the length of the type `{kind}` is unknown"));
    }
    let bit = |node| Some((page.number(node, "BitOffset")?, page.text(node)));
    DataItem {
        name: page.text(node),
        kind: kind.to_owned(),
        octets,
        bits: children(node, "BitDataItem").filter_map(bit).collect(),
    }
}

/// The records of a submodule that are written at start-up.
pub(super) fn records<'d>(page: &GsdmlDocument<'d>, node: Node<'d, 'd>) -> Vec<GsdmlRecord> {
    let lists = below(node, &["RecordDataList"]);
    let of = |list: Node<'d, 'd>| children(list, "ParameterRecordDataItem").collect::<Vec<_>>();
    lists.into_iter().flat_map(of).filter_map(|node| record(page, node)).collect()
}

fn record<'d>(page: &GsdmlDocument<'d>, node: Node<'d, 'd>) -> Option<GsdmlRecord> {
    let index = page.number(node, "Index")?;
    let octets = page.number::<u16>(node, "Length").map_or(0, usize::from);
    let mut default = vec![0; octets];
    for constant in children(node, "Const") {
        let data = page.octets(constant, "Data");
        let offset: usize = page.number(constant, "ByteOffset").unwrap_or_default();
        put(page, constant, &mut default, offset, &data);
    }
    let mut items = Vec::new();
    for node in children(node, "Ref") {
        let item = reference(page, node);
        default_into(page, node, &item, &mut default);
        items.push(item);
    }
    Some(GsdmlRecord {
        name: child(node, "Name").map(|name| page.text(name)).unwrap_or_default(),
        index,
        octets,
        transfer_sequence: page.number(node, "TransferSequence").unwrap_or_default(),
        default,
        items,
    })
}

fn put(page: &GsdmlDocument<'_>, node: Node<'_, '_>, record: &mut [u8], offset: usize, data: &[u8]) {
    let end = offset.checked_add(data.len()).filter(|end| *end <= LONGEST);
    match end.and_then(|end| record.get_mut(offset..end)) {
        Some(place) => place.copy_from_slice(data),
        None => page.remark(node, "it does not fit into its record and is ignored"),
    }
}

fn reference<'d>(page: &GsdmlDocument<'d>, node: Node<'d, 'd>) -> RecordItem {
    let length = page.number::<u16>(node, "Length");
    let (kind, octets) = data_type(node.attribute("DataType").unwrap_or_default(), length);
    let low = || match page.number::<u32>(node, "BitOffset").unwrap_or_default() {
        low @ ..64 => low,
        _ => {
            page.remark(node, "`BitOffset` is out of range; 0 is used");
            0
        }
    };
    let bits = match kind {
        DataType::Bit => Some(Bits { low: low(), width: 1 }),
        DataType::BitArea => {
            Some(Bits { low: low(), width: page.number::<u32>(node, "BitLength").unwrap_or(1).clamp(1, 64) })
        }
        _ => None,
    };
    let whole = matches!(kind, DataType::Bit | DataType::BitArea | DataType::Whole { .. });
    let flag = |name| page.flag(node, name).unwrap_or(true);
    let access = match (flag("Visible"), flag("Changeable")) {
        (false, _) => ItemAccess::Hidden,
        (true, false) => ItemAccess::Visible,
        (true, true) => ItemAccess::Changeable,
    };
    RecordItem {
        name: page.text(node),
        octets: octets.map_or(0, usize::from),
        octet: page.number(node, "ByteOffset").unwrap_or_default(),
        bits,
        default: if whole { page.number(node, "DefaultValue") } else { None },
        allowed: if whole { page.ranges(node, "AllowedValues") } else { Vec::new() },
        words: page.words(node),
        translations: (page.translations(node), page.translated_words(node)),
        access,
        kind,
    }
}

/// Writes the default of an item into the bytes of its record.
fn default_into(page: &GsdmlDocument<'_>, node: Node<'_, '_>, item: &RecordItem, record: &mut [u8]) {
    let Some(text) = node.attribute("DefaultValue") else { return };
    match (&item.kind, item.bits, item.default) {
        (DataType::Whole { octets, .. }, _, Some(number)) => {
            let all = number.to_be_bytes();
            put(page, node, record, item.octet, &all[all.len() - usize::from(*octets)..]);
        }
        (_, Some(bits), Some(number)) => {
            let octets = ((bits.low + bits.width).div_ceil(8) as usize).max(1);
            let place = item.octet.checked_add(octets).and_then(|end| record.get_mut(item.octet..end));
            let Some(place) = place else {
                page.remark(node, "it does not fit into its record and is ignored");
                return;
            };
            let mask = ((1u128 << bits.width) - 1) << bits.low;
            let old = place.iter().fold(0u128, |old, octet| (old << 8) | u128::from(*octet));
            let mut new = (old & !mask) | (((number as u128) << bits.low) & mask);
            for octet in place.iter_mut().rev() {
                *octet = new as u8;
                new >>= 8;
            }
        }
        (DataType::Float(4), ..) => {
            if let Ok(number) = text.trim().parse::<f32>() {
                put(page, node, record, item.octet, &number.to_be_bytes());
            }
        }
        (DataType::Float(_), ..) => {
            if let Ok(number) = text.trim().parse::<f64>() {
                put(page, node, record, item.octet, &number.to_be_bytes());
            }
        }
        (DataType::Octets, ..) => {
            let is_list = !text.is_empty()
                && text.split(',').all(|part| part.trim().starts_with("0x") && numeral::<u8>(part).is_some());
            let data = if is_list { page.octets(node, "DefaultValue") } else { text.as_bytes().to_vec() };
            put(page, node, record, item.octet, &data);
        }
        _ => {}
    }
}
