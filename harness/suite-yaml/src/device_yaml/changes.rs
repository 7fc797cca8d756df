//! What changes a device for good: the names after `changes`.

use super::super::error::{Mistake, Read};
use super::super::keys::{Key, Keyed};
use super::super::yaml::Node;
use super::{DeviceReader, device, plain};
use suite::device::{Changed, DeviceParameter, DeviceRecord, DeviceSignal, LastingChanges, SignalSender, WebPage};

key_set! {
    pub(crate) changed "changes" {
        position_reference may NonEmpty(&Name), "Outputs, parameters and records that give the present place another value.";
        nvm_write may NonEmpty(&Name), "Outputs, parameters and records that make it write its memory, in addition to `permanent` parameters.";
        factory_reset may NonEmpty(&Name), "Outputs, parameters and records that restore the factory settings, in addition to DCP.";
        firmware may NonEmpty(&Name), "Forms of web pages that let it wait for another firmware.";
    }
}

impl<'n> DeviceReader<'n> {
    pub(super) fn changes(
        &self,
        signals: &[DeviceSignal],
        parameters: &[DeviceParameter],
        records: &[DeviceRecord],
        pages: &[WebPage],
    ) -> Read<LastingChanges> {
        let Some(node) = self.top.get(&device::changes) else { return Ok(LastingChanges::default()) };
        let keyed = Keyed::new(node, &changed::KEYS)?;
        let list = |key: &Key| -> Read<Vec<Changed>> {
            let Some(node) = keyed.get(key) else { return Ok(Vec::new()) };
            let mut list = Vec::new();
            for item in node.items(key.name)? {
                let changed = match page(item, pages) {
                    Some(index) => Changed::Page(index),
                    None => self.changed(item, signals, parameters, records)?,
                };
                let saved = matches!(changed, Changed::Parameter(index) if parameters.get(index).is_some_and(|of| of.permanent));
                if key.name == changed::nvm_write.name && saved {
                    return Err(item
                        .wrong("a parameter that is `permanent` writes the memory anyway")
                        .help("leave it out here"));
                }
                if list.contains(&changed) {
                    return Err(item.wrong(format!("`{item}` stands twice in {}", key.name)));
                }
                list.push(changed);
            }
            if list.is_empty() { Err(node.wrong(format!("{} is empty", key.name))) } else { Ok(list) }
        };
        Ok(LastingChanges {
            position_reference: list(&changed::position_reference)?,
            nvm_write: list(&changed::nvm_write)?,
            factory_reset: list(&changed::factory_reset)?,
            firmware: list(&changed::firmware)?,
        })
    }

    fn changed(
        &self,
        node: &Node,
        signals: &[DeviceSignal],
        parameters: &[DeviceParameter],
        records: &[DeviceRecord],
    ) -> Read<Changed> {
        let path = plain(node, "a name")?;
        let (name, field) = path.split_once('.').map_or((path, None), |(name, field)| (name, Some(field)));
        let outputs = || signals.iter().enumerate().filter(|(_, signal)| signal.from == SignalSender::Controller);
        if let Some((index, signal)) = outputs().find(|(_, signal)| signal.name == name) {
            let whole = (0, signal.width);
            let bits = field.map_or(Some(whole), |field| {
                signal.fields.iter().find(|known| known.name == field).map(|known| (known.low, known.width))
            });
            if let Some((low, width)) = bits {
                if let Some(field) = field {
                    self.mentioned.borrow_mut().push(format!("field `{name}.{field}`"));
                }
                return Ok(Changed::Signal { signal: index, low, width });
            }
        }
        if let Some(index) = parameters.iter().position(|parameter| path == format!("P{}", parameter.number)) {
            return if parameters.get(index).is_some_and(|parameter| parameter.writable) {
                Ok(Changed::Parameter(index))
            } else {
                Err(node.wrong(format!("`{path}` can only be read")).help("what changes a device is set or written"))
            };
        }
        if let Some(index) = records.iter().position(|record| record.name == path) {
            return Ok(Changed::Record(index));
        }
        let fields = outputs().flat_map(|(_, of)| of.fields.iter().map(|field| format!("{}.{}", of.name, field.name)));
        let wholes = outputs().map(|(_, of)| of.name.clone());
        let writable = parameters.iter().filter(|of| of.writable).map(|of| format!("P{}", of.number));
        let known: Vec<String> =
            fields.chain(wholes).chain(writable).chain(records.iter().map(|of| of.name.clone())).collect();
        Err(Mistake::unknown(node.spot, "output, parameter or record", path, known.iter().map(String::as_str)))
    }
}

/// The page with a form that `page.x` stands for.
fn page(node: &Node, pages: &[WebPage]) -> Option<usize> {
    let name = node.scalar()?.strip_prefix("page.")?;
    pages.iter().position(|page| page.name == name && !page.fields.is_empty())
}
