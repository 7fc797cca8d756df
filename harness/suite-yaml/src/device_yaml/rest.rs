//! Records, parameters, code tables, the stand and the roles of a device.

use super::super::error::{Mistake, Read};
use super::super::keys::{Key, Keyed, WordChoices};
use super::super::yaml::Node;
use super::cyclic::words_of;
use super::plain::{FieldKeys, FieldPosition, ORIGINS, position};
use super::{DeviceReader, device, flag, label, labels, named, numeral, origin, plain, whole};
use expression::{Number, Type};
use suite::device::{
    CodingSwitch, DeviceModule, DeviceParameter, DeviceRecord, DeviceSubmodule, ParameterAccess, ParameterType,
    RecordField, SignalField, StandNames,
};

/// The types of parameters.
static TYPES: WordChoices<&str> = WordChoices(&[
    ("u8", "u8"),
    ("u16", "u16"),
    ("u32", "u32"),
    ("u64", "u64"),
    ("i8", "i8"),
    ("i16", "i16"),
    ("i32", "i32"),
    ("i64", "i64"),
    ("bytes", "bytes"),
    ("text", "text"),
]);
/// Whether a parameter can be written.
static ACCESSES: WordChoices<bool> = WordChoices(&[("read", false), ("read_write", true)]);

key_set! {
    pub(crate) codes "codes" {
        channel_error may Map(&Whole(0, 0xFFFF_FFFF)), "Errors of channels in alarms.";
        diagnosis_error may Map(&Whole(0, 0xFFFF_FFFF)), "Errors in the blocks of a diagnosis.";
        parameter_error may Map(&Whole(0, 0xFFFF_FFFF)), "Error numbers of parameter access in addition to those of the drive profile.";
    }
}

key_set! {
    pub(crate) record "a record" {
        index must Whole(0, 0xFFFF), "Index.";
        at must Name, "The submodule it is read from and written to.";
        octets must Whole(0, 0xFFFF_FFFF), "Its length.";
        start may Flag, "It is part of the start-up.";
        with may NonEmpty(&Label), "The modules with whose start-up it is sent; all by default.";
        fields must Map(&Keys(&record_field::KEYS)), "Its fields.";
        template may Octets, "Its bytes where no field is, by a GSDML; all 0 by default.";
        from_source may Word(&ORIGINS), "Where its layout comes from if the manual does not print it.";
    } [With(&[&r#with], &start)]
}

key_set! {
    pub(crate) record_field "a field of a record" {
        octet may Whole(0, 0xFFFF_FFFF), "The byte it lies in.";
        octets may Pair(0, 0xFFFF_FFFF), "Its first and its last byte.";
        bit may Whole(0, 7), "Its bit in the byte.";
        bits may Pair(0, 7), "Its lowest and its highest bit in the byte.";
        words may Name, "The table of its words.";
        text may Flag, "Its bytes are text.";
        default may PerVariant(&Scalar), "Its documented default.";
        from may Whole(-0x8000_0000_0000_0000, 0xFFFF_FFFF_FFFF_FFFF), "The lowest number that the manual allows.";
        to may Whole(-0x8000_0000_0000_0000, 0xFFFF_FFFF_FFFF_FFFF), "The highest number that the manual allows.";
        called may NonEmpty(&Text), "Other names for it in the manual and in descriptions; a GSDML or GSD is searched for them.";
        from_source may Word(&ORIGINS), "Where its place comes from if the manual does not print it.";
        absent may Text, "Why the record does not have it, by a GSDML; it is not written, and a start with another value than the default is not applicable.";
        settable may Pair(0, 0xFFFF_FFFF_FFFF_FFFF), "The lowest and the highest number that a GSDML lets users set; a start with another one is not applicable.";
    } [OneOf(&[&octet, &octets]), NotBoth(&bit, &bits)]
}

key_set! {
    pub(crate) parameter "a parameter" {
        r#type must Word(&TYPES), "The type of its elements.";
        octets may Whole(0, 0xFFFF_FFFF), "For bytes and text: how many.";
        access must Word(&ACCESSES), "Whether it can be written.";
        default may PerVariant(&Scalar), "Its default.";
        permanent may Flag, "A write changes the device for good.";
        optional may Flag, "A device may lack it: where it refuses it as unknown and does not list it in P980, a trial that needs it is not applicable.";
        elements may Map(&Whole(0, 0xFFFF)), "Names and subindices of its elements.";
        bits may ParameterBits, "Names of bits, of the parameter or of an element.";
        from_source may Word(&ORIGINS), "Where it comes from if the manual does not print it.";
    }
}

key_set! {
    pub(crate) parameter_access "parameter_access" {
        index may Whole(0, 0xFFFF), "Index of its record; 0xB02E by default.";
        at may Name, "The submodule that its record stands at; by default the one of the module in use that the records of the start-up go to.";
        do_id may Whole(1, 255), "The addressed drive object, 1 to 255; 1 by default.";
        save may Name, "The parameter that saves the others; P971 by default.";
    }
}

key_set! {
    pub(crate) slave_parameter_access "parameter_access on PROFIBUS" {
        index may Whole(0, 0xFFFF), "Index of the data set; 47 by default.";
        slot may Whole(0, 0xFF), "Its slot; 0 by default.";
        do_id may Whole(1, 255), "The addressed drive object, 1 to 255; 1 by default.";
        save may Name, "The parameter that saves the others; P971 by default.";
    }
}

key_set! {
    pub(crate) stand "stand" {
        faults may Map(&Text), "Conditions of the encoder that the manual describes.";
        buttons may Map(&Text), "Buttons and where each is.";
        switches may Map(&Between(2, 3, &Whole(0, 0xFFFF_FFFF))), "Coding switches with their lowest and highest position, then the one that a trial finds and that they are put back to, by default the lowest.";
        supply may Keys(&supply::KEYS), "The supply and the temperature that a trial finds and that they are put back to.";
        leds may Map(&NonEmpty(&Label)), "LEDs and what each can show.";
        counters may Map(&Text), "Counters.";
    }
}

key_set! {
    pub(crate) supply "supply" {
        voltage may Number, "In volts.";
        temperature may Number, "In degrees Celsius.";
        highest_voltage may Number, "The highest voltage that the manual permits; a higher one needs the consent `overstress`.";
        lowest_temperature may Number, "The lowest temperature that the manual permits; a lower one needs the consent `overstress`.";
        highest_temperature may Number, "The highest temperature that the manual permits; a higher one needs the consent `overstress`.";
    }
}

/// How parameters are reached: what both buses have, and the slot or submodule of each.
#[derive(Default)]
pub(super) struct Access {
    pub common: ParameterAccess,
    /// On PROFINET the submodule, where one is named.
    pub point: Option<usize>,
    /// On PROFIBUS the slot of the data set.
    pub slot: u8,
}

impl<'n> DeviceReader<'n> {
    pub(super) fn records(&mut self, submodules: &[DeviceSubmodule], modules: &[DeviceModule]) -> Vec<DeviceRecord> {
        let mut records = Vec::new();
        for (name, node) in self.entries(&device::records) {
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
        let keyed = Keyed::new(node, &record::KEYS)?;
        let at = keyed.must(&record::at)?;
        let place = plain(at, "a submodule")?;
        let index = match submodules.iter().position(|submodule| submodule.name == place) {
            Some(index) => index,
            None if self.is_declared(&device::submodules, place) => 0,
            None => {
                let known = submodules.iter().map(|submodule| submodule.name.as_str());
                return Err(Mistake::unknown(at.spot, "submodule", place, known));
            }
        };
        let octets: usize = whole(keyed.must(&record::octets)?, "a length")?;
        let start = flag(keyed, &record::start)?;
        // A module that has a mistake of its own is not called unknown.
        let is_known = modules.len() == self.entries(&device::modules).len();
        let with = keyed.get(&record::with).filter(|_| is_known);
        let with = with.map(|node| start_modules(node, start, modules)).transpose()?;
        let mut fields = Vec::new();
        for (field, node) in named(keyed.must(&record::fields)?, "fields")? {
            self.declare("field", &format!("{name}.{field}"), node.spot);
            fields.push(self.record_field(field, node, octets)?);
        }
        Ok(DeviceRecord {
            name: name.to_owned(),
            index: whole(keyed.must(&record::index)?, "an index")?,
            at: index,
            octets,
            start,
            with,
            fields,
            template: keyed.get(&record::template).map(template).transpose()?.unwrap_or_default(),
            origin: origin(keyed, &record::from_source)?,
        })
    }

    pub(super) fn record_field(&mut self, name: &str, node: &Node, octets: usize) -> Read<RecordField> {
        let keyed = Keyed::new(node, &record_field::KEYS)?;
        let FieldPosition { first, octets: count, bits } = position(keyed, &OCTETS, octets)?;
        let text = flag(keyed, &record_field::text)? || count > 8;
        let table = keyed.get(&record_field::words).map(|node| self.table(node)).transpose()?;
        let width = bits.map_or(count as u32 * 8, |(_, width)| width);
        let ty = match &table {
            Some(table) => Type::Word(table.clone()),
            None => Type::whole(width, false),
        };
        let number = |key: &Key| keyed.get(key).map(|node| whole::<i128>(node, key.name)).transpose();
        let default = match keyed.get(&record_field::default) {
            None => Vec::new(),
            Some(node) if text => return Err(node.wrong("a text has no default")),
            Some(node) => self.default(node, &ty)?,
        };
        let range = (number(&record_field::from)?, number(&record_field::to)?);
        let origin = origin(keyed, &record_field::from_source)?;
        let words = words_of(table.as_deref());
        let called = keyed.get(&record_field::called).map(names_elsewhere).transpose()?.unwrap_or_default();
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
            called,
            origin,
            absent: keyed
                .get(&record_field::absent)
                .map(|node| node.text("a reason").map(str::to_owned))
                .transpose()?,
            settable: keyed.get(&record_field::settable).map(settable).transpose()?,
        })
    }

    pub(super) fn parameters(&mut self) -> Vec<DeviceParameter> {
        let mut parameters: Vec<DeviceParameter> = Vec::new();
        for (name, node) in self.entries(&device::parameters) {
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
            false => &parameter_access::KEYS,
            true => {
                access.common.index = ParameterAccess::DATA_SET;
                &slave_parameter_access::KEYS
            }
        };
        let Some(node) = self.top.get(&device::parameter_access) else { return Ok(access) };
        let keyed = Keyed::new(node, keys)?;
        if let Some(node) = keyed.get(&slave_parameter_access::slot) {
            access.slot = whole(node, "a slot")?;
        }
        if let Some(node) = keyed.get(&parameter_access::index) {
            access.common.index = whole(node, "an index")?;
        }
        if let Some(node) = keyed.get(&parameter_access::at) {
            let place = plain(node, "a submodule")?;
            let names = || submodules.iter().map(|submodule| submodule.name.as_str());
            let index = names().position(|name| name == place);
            access.point = Some(index.ok_or_else(|| Mistake::unknown(node.spot, "submodule", place, names()))?);
        }
        if let Some(node) = keyed.get(&parameter_access::do_id) {
            access.common.do_id = match whole::<u8>(node, "a drive object")? {
                0 => return Err(node.wrong("0 is no drive object").help("write 1 to 255")),
                do_id => do_id,
            };
        }
        if let Some(node) = keyed.get(&parameter_access::save) {
            let name = plain(node, "a parameter")?;
            let number = parameter_number(name);
            let Some(parameter) = parameters.iter().find(|of| Some(of.number) == number) else {
                let names: Vec<&str> = self.entries(&device::parameters).iter().map(|(name, _)| *name).collect();
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
        let keyed = Keyed::new(node, &parameter::KEYS)?;
        let Some(number) = parameter_number(name) else {
            return Err(node
                .wrong(format!("`{name}` is no parameter"))
                .help("a parameter is `P` and its number, as P65000"));
        };
        let octets = keyed.get(&parameter::octets).map(|node| whole::<usize>(node, "a length")).transpose()?;
        let kind = ParameterType::of_word(TYPES.read(keyed.must(&parameter::r#type)?, &parameter::r#type)?, octets);
        let writable = ACCESSES.read(keyed.must(&parameter::access)?, &parameter::access)?;
        let default = keyed
            .get(&parameter::default)
            .map(|node| self.default(node, &Type::whole(kind.width, kind.signed)))
            .transpose()?;
        let mut elements: Vec<(String, u16)> = Vec::new();
        if let Some(node) = keyed.get(&parameter::elements) {
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
        if let Some(node) = keyed.get(&parameter::bits) {
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
        let permanent = flag(keyed, &parameter::permanent)?;
        Ok(DeviceParameter {
            number,
            kind,
            writable,
            default,
            permanent,
            optional: flag(keyed, &parameter::optional)?,
            origin: origin(keyed, &parameter::from_source)?,
            elements,
            bits,
        })
    }

    pub(super) fn codes(&mut self) -> Vec<(String, Vec<(String, u32)>)> {
        let mut codes = Vec::new();
        if let Some(node) = self.top.get(&device::codes)
            && self.mistakes.keep(Keyed::new(node, &codes::KEYS)).is_none()
        {
            return Vec::new();
        }
        for (table, node) in self.entries(&device::codes) {
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
        let Some(node) = self.top.get(&device::stand) else { return Ok(names) };
        let keyed = Keyed::new(node, &stand::KEYS)?;
        let mut all = |key: &Key, kind: &str| -> Read<Vec<(&str, &Node)>> {
            let list = keyed.get(key).map_or(Ok(Vec::new()), |node| named(node, key.name))?;
            list.iter().for_each(|(name, node)| self.declare(kind, name, node.spot));
            Ok(list)
        };
        let texts = |list: Vec<(&str, &Node)>| -> Read<Vec<(String, String)>> {
            list.into_iter().map(|(name, node)| Ok((name.to_owned(), node.text("a sentence")?.to_owned()))).collect()
        };
        names.faults = texts(all(&stand::faults, "fault")?)?;
        names.buttons = texts(all(&stand::buttons, "button")?)?;
        names.counters = texts(all(&stand::counters, "counter")?)?;
        for (name, node) in all(&stand::switches, "switch")? {
            names.switches.push(coding_switch(name, node)?);
        }
        for (name, node) in all(&stand::leds, "led")? {
            names.leds.push((name.to_owned(), labels(node, "an LED")?));
        }
        if let Some(node) = keyed.get(&stand::supply) {
            let supply = Keyed::new(node, &supply::KEYS)?;
            let usual = |key: &Key| supply.get(key).map(|node| numeral(node, key.name).map(Number::to_f64)).transpose();
            (names.voltage, names.temperature) = (usual(&supply::voltage)?, usual(&supply::temperature)?);
            names.permitted_voltage = [None, usual(&supply::highest_voltage)?];
            names.permitted_temperature = [usual(&supply::lowest_temperature)?, usual(&supply::highest_temperature)?];
        }
        Ok(names)
    }

    pub(super) fn roles(&mut self) -> Read<Vec<(String, Vec<String>)>> {
        let mut roles = Vec::new();
        for (name, node) in self.entries(&device::roles) {
            label(node, name)?;
            self.declare("role", name, node.spot);
            let names: Read<Vec<String>> = node
                .items("a role")?
                .iter()
                .map(|item| {
                    let name = plain(item, "a name")?;
                    let known = self.top.get(&device::signals).is_some_and(|signals| signals.get(name).is_some());
                    if known {
                        Ok(name.to_owned())
                    } else {
                        Err(Mistake::unknown(
                            item.spot,
                            "signal",
                            name,
                            self.entries(&device::signals).iter().map(|(name, _)| *name).collect::<Vec<_>>(),
                        ))
                    }
                })
                .collect();
            roles.push((name.to_owned(), names?));
        }
        Ok(roles)
    }
}

/// The keys of a position in a record.
const OCTETS: FieldKeys = FieldKeys {
    one: &record_field::octet,
    many: &record_field::octets,
    bit: &record_field::bit,
    bits: &record_field::bits,
    whole: "record",
};

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

/// The bytes of a record, in hexadecimal.
fn template(node: &Node) -> Read<Vec<u8>> {
    let octet = |text: &str| u8::from_str_radix(text, 16).ok().filter(|_| text.len() == 2);
    let octets: Option<Vec<u8>> = node.text("bytes")?.split_whitespace().map(octet).collect();
    octets.ok_or_else(|| node.wrong("bytes have two hexadecimal digits each").help("for instance \"80 00 12\""))
}

/// The lowest and the highest number that users can set.
fn settable(node: &Node) -> Read<(i128, i128)> {
    match node.items("settable")? {
        [lowest, highest] => Ok((whole(lowest, "a number")?, whole(highest, "a number")?)),
        _ => Err(node.wrong("`settable` is the lowest and the highest number")),
    }
}

/// Names of a field in the manual and in descriptions.
fn names_elsewhere(node: &Node) -> Read<Vec<String>> {
    node.items("called")?.iter().map(|item| plain(item, "a name").map(str::to_owned)).collect()
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
