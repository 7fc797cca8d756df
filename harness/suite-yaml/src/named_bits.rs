//! Words by their bits: `G1_ZSW: [parked, sensor_error]` is the number in which exactly these bits are 1.
//!
//! The list is replaced by its number before anything is compiled, so that both forms have one meaning.

use super::device_yaml::plain;
use super::error::{Mistake, Read};
use super::frame::StepScope;
use super::names::Name;
use super::yaml::{Node, NodeKind};
use expression::Type;
use std::borrow::Cow;
use suite::device::{NameKind, SignalField};

impl StepScope<'_, '_> {
    /// The value of a name with each list of bits replaced by its number, also inside `in` and `not`.
    ///
    /// A name without bits keeps its value as it is written.
    pub(super) fn bits_as_number<'n>(&self, node: &'n Node, key: &Node, name: &Name) -> Read<Cow<'n, Node>> {
        let holds_list = node.sequence().is_some() || node.mapping().is_some();
        let fields = self.bits_of(&name.kind);
        if !holds_list || fields.is_empty() || matches!(name.ty, Type::Set(_)) {
            return Ok(Cow::Borrowed(node));
        }
        self.replaced_bits(node, &key.to_string(), name, fields).map(Cow::Owned)
    }

    fn replaced_bits(&self, node: &Node, path: &str, name: &Name, fields: &[SignalField]) -> Read<Node> {
        let kind = match &node.kind {
            NodeKind::Scalar { .. } => return Ok(node.clone()),
            NodeKind::Sequence(items) => NodeKind::Scalar {
                text: format!("{:#X}", self.sum_of_bits(node, items, path, name, fields)?),
                quoted: false,
            },
            NodeKind::Mapping(entries) => {
                let replaced = |(key, value): &(Node, Node)| {
                    let value = match (key.scalar(), value.sequence()) {
                        (Some("in"), Some(choices)) => {
                            let choices = choices.iter().map(|choice| self.replaced_bits(choice, path, name, fields));
                            Node { spot: value.spot, kind: NodeKind::Sequence(choices.collect::<Read<_>>()?) }
                        }
                        (Some("not"), Some(_)) => self.replaced_bits(value, path, name, fields)?,
                        _ => value.clone(),
                    };
                    Ok((key.clone(), value))
                };
                NodeKind::Mapping(entries.iter().map(replaced).collect::<Read<_>>()?)
            }
        };
        Ok(Node { spot: node.spot, kind })
    }

    fn sum_of_bits(&self, list: &Node, items: &[Node], path: &str, name: &Name, fields: &[SignalField]) -> Read<u128> {
        if items.is_empty() {
            return Err(list.wrong("an empty list of bits").help("write 0 if no bit is 1"));
        }
        let mut sum = 0;
        for item in items {
            let word = plain(item, "a bit")?;
            let single = fields.iter().filter(|field| field.width == 1);
            let Some(field) = single.clone().find(|field| field.name == word) else {
                let mistake = Mistake::unknown(
                    item.spot,
                    &format!("bit of {path}"),
                    word,
                    single.map(|field| field.name.as_str()),
                );
                return Err(match fields.iter().find(|field| field.name == word) {
                    Some(field) => mistake.help(format!("`{word}` has {} bits; write the whole number", field.width)),
                    None => mistake,
                });
            };
            let bit = 1_u128 << field.low;
            if sum & bit != 0 {
                return Err(item.wrong(format!("bit {} of {path} is in the list already", field.low)));
            }
            sum |= bit;
            self.mark_bit(&name.kind, word);
        }
        Ok(sum)
    }

    /// The named bits of a whole signal, parameter or element.
    fn bits_of(&self, kind: &NameKind) -> &[SignalField] {
        let device = self.names.device();
        match *kind {
            // A number of steps has no bits: those of the wire stand elsewhere.
            NameKind::Signal { signal, field: None, shift: 0, .. } => {
                device.signals.get(signal).map_or(&[], |signal| &signal.fields)
            }
            NameKind::Parameter { parameter: Some(parameter), subindex, bits: None, .. } => {
                let Some(parameter) = device.parameters.get(parameter) else { return &[] };
                let element =
                    parameter.elements.iter().find(|(_, index)| *index == subindex).map_or("", |(name, _)| name);
                parameter.bits.iter().find(|(of, _)| of == element).map_or(&[], |(_, fields)| fields)
            }
            _ => &[],
        }
    }

    fn mark_bit(&self, kind: &NameKind, bit: &str) {
        let device = self.names.device();
        let of = match *kind {
            NameKind::Signal { signal, .. } => device.signals.get(signal).map(|signal| signal.name.clone()),
            NameKind::Parameter { parameter: Some(parameter), subindex, .. } => {
                device.parameters.get(parameter).map(|parameter| {
                    let element = parameter.elements.iter().find(|(_, index)| *index == subindex);
                    let element = element.map_or(String::new(), |(name, _)| format!(".{name}"));
                    format!("P{}{element}", parameter.number)
                })
            }
            _ => None,
        };
        self.names.mark("field", &format!("{}.{bit}", of.unwrap_or_default()));
    }
}
