//! Records, parameters, code tables, the stand and the roles of a device.

use super::super::error::{Mistake, Read};
use super::super::keys::{self, Keyed, TYPES};
use super::super::yaml::Node;
use super::cyclic::words_of;
use super::{Counted, Place, Reader, flag, label, labels, named, numeral, origin, place, plain, whole, word};
use expression::{Number, Type};
use suite::device::{
    CodingSwitch, DeviceModule, DeviceParameter, DeviceRecord, DeviceSubmodule, ParameterAccess, ParameterType,
    RecordField, SignalField, StandNames,
};

/// How parameters are reached: what both buses have, and the place on either.
#[derive(Default)]
pub(super) struct Access {
    pub common: ParameterAccess,
    /// On PROFINET the submodule, where one is named.
    pub point: Option<usize>,
    /// On PROFIBUS the slot of the data set.
    pub slot: u8,
}

impl<'n> Reader<'n> {
    pub(super) fn records(&mut self, submodules: &[DeviceSubmodule], modules: &[DeviceModule]) -> Vec<DeviceRecord> {
        let mut records = Vec::new();
        for (name, node) in self.entries("records") {
            self.declare("record", name, node.spot);
            let record = self.record(name, node, submodules, modules);
            records.extend(self.mistakes.keep(record));
        }
        records
    }

    fn record(
        &mut self,
        name: &str,
        node: &Node,
        submodules: &[DeviceSubmodule],
        modules: &[DeviceModule],
    ) -> Read<DeviceRecord> {
        let keyed = Keyed::new(node, &keys::RECORD)?;
        let at = keyed.must("at")?;
        let place = plain(at, "a submodule")?;
        let Some(index) = submodules.iter().position(|submodule| submodule.name == place) else {
            return Err(Mistake::unknown(
                at.spot,
                "submodule",
                place,
                submodules.iter().map(|submodule| submodule.name.as_str()),
            ));
        };
        let octets: usize = whole(keyed.must("octets")?, "a length")?;
        let start = flag(keyed, "start")?;
        let with = keyed.get("with").map(|node| start_modules(node, start, modules)).transpose()?;
        let mut fields = Vec::new();
        for (field, node) in named(keyed.must("fields")?, "fields")? {
            self.declare("field", &format!("{name}.{field}"), node.spot);
            fields.push(self.record_field(field, node, octets)?);
        }
        Ok(DeviceRecord {
            name: name.to_owned(),
            index: whole(keyed.must("index")?, "an index")?,
            at: index,
            octets,
            start,
            with,
            fields,
            origin: origin(keyed)?,
        })
    }

    pub(super) fn record_field(&mut self, name: &str, node: &Node, octets: usize) -> Read<RecordField> {
        let keyed = Keyed::new(node, &keys::RECORD_FIELD)?;
        let Place { first, octets: count, bits } = place(keyed, &Counted::OCTETS, octets)?;
        let text = flag(keyed, "text")? || count > 8;
        let table = keyed.get("words").map(|node| self.table(node)).transpose()?;
        let width = bits.map_or(count as u32 * 8, |(_, width)| width);
        let ty = match &table {
            Some(table) => Type::Word(table.clone()),
            None => Type::whole(width, false),
        };
        let number =
            |key: &str| -> Read<Option<i128>> { keyed.get(key).map(|node| whole::<i128>(node, key)).transpose() };
        let default = match keyed.get("default") {
            None => Vec::new(),
            Some(node) if text => return Err(node.wrong("a text has no default")),
            Some(node) => self.default(node, &ty)?,
        };
        let range = (number("from")?, number("to")?);
        let origin = origin(keyed)?;
        let words = words_of(table.as_deref());
        Ok(RecordField {
            name: name.to_owned(),
            octet: first,
            octets: count,
            bits,
            words,
            table,
            default,
            range,
            text,
            origin,
        })
    }

    pub(super) fn parameters(&mut self) -> Vec<DeviceParameter> {
        let mut parameters: Vec<DeviceParameter> = Vec::new();
        for (name, node) in self.entries("parameters") {
            self.declare("parameter", name, node.spot);
            let parameter = self.parameter(name, node);
            parameters.extend(self.mistakes.keep(parameter));
        }
        parameters
    }

    pub(super) fn parameter_access(
        &self,
        is_slave: bool,
        submodules: &[DeviceSubmodule],
        parameters: &[DeviceParameter],
    ) -> Read<Access> {
        let mut access = Access::default();
        let keys = match is_slave {
            false => &keys::PARAMETER_ACCESS,
            true => {
                access.common.index = ParameterAccess::DATA_SET;
                &keys::SLAVE_PARAMETER_ACCESS
            }
        };
        let Some(node) = self.top.get("parameter_access") else { return Ok(access) };
        let keyed = Keyed::new(node, keys)?;
        if let Some(node) = keyed.get("slot") {
            access.slot = whole(node, "a slot")?;
        }
        if let Some(node) = keyed.get("index") {
            access.common.index = whole(node, "an index")?;
        }
        if let Some(node) = keyed.get("at") {
            let place = plain(node, "a submodule")?;
            let names = || submodules.iter().map(|submodule| submodule.name.as_str());
            let index = names().position(|name| name == place);
            access.point = Some(index.ok_or_else(|| Mistake::unknown(node.spot, "submodule", place, names()))?);
        }
        if let Some(node) = keyed.get("do_id") {
            access.common.do_id = match whole::<u8>(node, "a drive object")? {
                0 => return Err(node.wrong("0 is no drive object").help("write 1 to 255")),
                do_id => do_id,
            };
        }
        if let Some(node) = keyed.get("save") {
            let name = plain(node, "a parameter")?;
            let number = parameter_number(name);
            let Some(parameter) = parameters.iter().find(|of| Some(of.number) == number) else {
                let names: Vec<&str> = self.entries("parameters").iter().map(|(name, _)| *name).collect();
                return Err(Mistake::unknown(node.spot, "parameter", name, names));
            };
            if !parameter.writable {
                return Err(node.wrong(format!("`{name}` can only be read")).help("what saves is written"));
            }
            access.common.save = parameter.number;
        }
        Ok(access)
    }

    fn parameter(&mut self, name: &str, node: &Node) -> Read<DeviceParameter> {
        let keyed = Keyed::new(node, &keys::PARAMETER)?;
        let Some(number) = parameter_number(name) else {
            return Err(node
                .wrong(format!("`{name}` is no parameter"))
                .help("a parameter is `P` and its number, as P65000"));
        };
        let octets = keyed.get("octets").map(|node| whole::<usize>(node, "a length")).transpose()?;
        let kind = ParameterType::of_word(word(keyed.must("type")?, "type", TYPES)?, octets);
        let writable = word(keyed.must("access")?, "access", &["read", "read_write"])? == "read_write";
        let default =
            keyed.get("default").map(|node| self.default(node, &Type::whole(kind.width, kind.signed))).transpose()?;
        let mut elements: Vec<(String, u16)> = Vec::new();
        if let Some(node) = keyed.get("elements") {
            for (element, index) in named(node, "elements")? {
                self.declare("element", &format!("{name}.{element}"), index.spot);
                let subindex = whole(index, "a subindex")?;
                if let Some((known, _)) = elements.iter().find(|(_, known)| *known == subindex) {
                    return Err(index.wrong(format!("the subindex {subindex} is `{known}` already")));
                }
                elements.push((element.to_owned(), subindex));
            }
        }
        let mut bits: Vec<(String, Vec<SignalField>)> = Vec::new();
        if let Some(node) = keyed.get("bits") {
            if elements.is_empty() {
                bits.push((String::new(), self.fields(node, kind.width, name)?));
            } else {
                for (key, of) in node.entries("bits")? {
                    let element = plain(key, "an element")?;
                    if !elements.iter().any(|(known, _)| known == element) {
                        return Err(Mistake::unknown(
                            key.spot,
                            "element",
                            element,
                            elements.iter().map(|(name, _)| name.as_str()),
                        ));
                    }
                    bits.push((element.to_owned(), self.fields(of, kind.width, &format!("{name}.{element}"))?));
                }
            }
        }
        let permanent = flag(keyed, "permanent")?;
        Ok(DeviceParameter { number, kind, writable, default, permanent, origin: origin(keyed)?, elements, bits })
    }

    pub(super) fn codes(&mut self) -> Vec<(String, Vec<(String, u32)>)> {
        let mut codes = Vec::new();
        for (table, node) in self.entries("codes") {
            let known = ["channel_error", "diagnosis_error", "parameter_error"];
            if !known.contains(&table) {
                self.mistakes.note(Mistake::unknown(node.spot, "code table", table, known));
                continue;
            }
            let mut words = Vec::new();
            for (word, number) in self.mistakes.keep(named(node, "codes")).unwrap_or_default() {
                self.declare("code", &format!("{table}.{word}"), number.spot);
                words.extend(self.mistakes.keep(whole(number, "a code")).map(|number| (word.to_owned(), number)));
            }
            codes.push((table.to_owned(), words));
        }
        codes
    }

    pub(super) fn stand(&mut self) -> Read<StandNames> {
        let mut names = StandNames::default();
        let Some(node) = self.top.get("stand") else { return Ok(names) };
        let keyed = Keyed::new(node, &keys::STAND)?;
        let mut all = |key: &str, kind: &str| -> Read<Vec<(&str, &Node)>> {
            let list = keyed.get(key).map_or(Ok(Vec::new()), |node| named(node, key))?;
            list.iter().for_each(|(name, node)| self.declare(kind, name, node.spot));
            Ok(list)
        };
        let texts = |list: Vec<(&str, &Node)>| -> Read<Vec<(String, String)>> {
            list.into_iter().map(|(name, node)| Ok((name.to_owned(), node.text("a sentence")?.to_owned()))).collect()
        };
        names.faults = texts(all("faults", "fault")?)?;
        names.buttons = texts(all("buttons", "button")?)?;
        names.counters = texts(all("counters", "counter")?)?;
        for (name, node) in all("switches", "switch")? {
            names.switches.push(coding_switch(name, node)?);
        }
        for (name, node) in all("leds", "led")? {
            names.leds.push((name.to_owned(), labels(node, "an LED")?));
        }
        if let Some(node) = keyed.get("supply") {
            let supply = Keyed::new(node, &keys::SUPPLY)?;
            let usual = |key: &str| supply.get(key).map(|node| numeral(node, key).map(Number::to_f64)).transpose();
            (names.voltage, names.temperature) = (usual("voltage")?, usual("temperature")?);
        }
        Ok(names)
    }

    pub(super) fn roles(&mut self) -> Read<Vec<(String, Vec<String>)>> {
        let mut roles = Vec::new();
        for (name, node) in self.entries("roles") {
            label(node, name)?;
            self.declare("role", name, node.spot);
            let names: Read<Vec<String>> = node
                .items("a role")?
                .iter()
                .map(|item| {
                    let name = plain(item, "a name")?;
                    let known = self.top.get("signals").is_some_and(|signals| signals.get(name).is_some());
                    if known {
                        Ok(name.to_owned())
                    } else {
                        Err(Mistake::unknown(
                            item.spot,
                            "signal",
                            name,
                            self.entries("signals").iter().map(|(name, _)| *name).collect::<Vec<_>>(),
                        ))
                    }
                })
                .collect();
            roles.push((name.to_owned(), names?));
        }
        Ok(roles)
    }
}

/// A coding switch: its lowest and its highest position, then the one that a trial finds, which is else the lowest.
fn coding_switch(name: &str, node: &Node) -> Read<CodingSwitch> {
    let numbers: Read<Vec<u32>> = node.items("a switch")?.iter().map(|node| whole(node, "a position")).collect();
    let (lowest, highest, home) = match numbers?[..] {
        [lowest, highest] => (lowest, highest, lowest),
        [lowest, highest, home] => (lowest, highest, home),
        _ => {
            let help = "write [lowest, highest] or [lowest, highest, the one that a trial finds]";
            return Err(node.wrong("a switch has two or three positions").help(help));
        }
    };
    if lowest >= highest || !(lowest..=highest).contains(&home) {
        return Err(node.wrong("the positions of a switch go up, and the one that a trial finds is among them"));
    }
    Ok(CodingSwitch { name: name.to_owned(), lowest, highest, home })
}

/// The number of `P65000`; without leading zeros.
pub(in super::super) fn parameter_number(name: &str) -> Option<u16> {
    let digits = name.strip_prefix('P')?;
    let good = !digits.is_empty()
        && digits.bytes().all(|octet| octet.is_ascii_digit())
        && (digits == "0" || !digits.starts_with('0'));
    if good { digits.parse().ok() } else { None }
}

/// The modules with whose start-up a record is sent.
fn start_modules(node: &Node, start: bool, modules: &[DeviceModule]) -> Read<Vec<usize>> {
    if !start {
        return Err(node.wrong("only a record of the start-up goes `with` modules").help("write `start: true`"));
    }
    let names = labels(node, "with")?;
    let index = |(at, name): (usize, &String)| {
        let at = node.sequence().and_then(|items| items.get(at)).unwrap_or(node);
        let found = modules.iter().position(|module| module.name == *name);
        let known = modules.iter().map(|module| module.name.as_str());
        found.ok_or_else(|| Mistake::unknown(at.spot, "module", name, known))
    };
    names.iter().enumerate().map(index).collect()
}
