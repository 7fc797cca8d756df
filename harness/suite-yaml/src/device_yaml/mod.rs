//! `device.yaml` to a [`DeviceDescription`]: what a device is, read strictly and compared with itself.
//!
//! Lengths are compared with widths, words with their tables, names with each other. Expressions over start parameters
//! (`derived`, `position_in`) stay text here; they are compiled with the name table.

mod also_keys;
mod changes;
mod cyclic;
mod pages;
mod plain;
mod profibus;
mod rest;
mod times;
mod variants;

pub(crate) use also_keys::{also, contradicted};
pub(crate) use cyclic::field;
pub use pages::{fields, path};
pub(crate) use plain::sourced_datum;
pub use plain::{FieldKeys, FieldPosition, PATH, position};
pub use plain::{duration, flag, flag_value, label, labels, named, numeral, origin, pair, plain, sourced, whole};

pub(crate) use profibus::slave;
pub(super) use rest::parameter_number;
pub use times::{OurKind, our_value, patience};

use self::changes::changed;
use self::cyclic::{Wired, WiredSlave};
use self::cyclic::{module, signal, submodule};
use self::pages::page;
use self::rest::Access;
use self::rest::{codes, parameter, parameter_access, record, stand};
use self::times::{ours, printed};
use self::variants::{IdentifyingNames, variant_identification};
use super::error::{Mistake, Mistakes, Read, Spot};
use super::keys::{Key, KeySet, Keyed, WordChoices};
use super::yaml::Node;
use expression::{Allow, NameScope, Number, Program, ResolvedName, Type, Value, WordTable};
use std::cell::RefCell;
use std::sync::Arc;
use std::time::Duration;
use suite::device::{
    DeviceDescription, DeviceRecord, LastingChanges, ProfibusFacts, ProfinetFacts, ProfinetIdentity,
    VariantIdentification,
};

/// The buses; whether it is PROFIBUS.
static BUSES: WordChoices<bool> = WordChoices(&[("profinet", false), ("profibus", true)]);

key_set! {
    pub(crate) device "device.yaml" {
        encspec may Pattern(&crate::needed_version::VERSIONS), "The versions of encspec that can read this file, for instance `>=0.2`.";
        device must Text, "The name of the folder.";
        bus must Only("profinet"), "The bus.";
        title must Text, "The title for people.";
        identity must Keys(&identity::KEYS), "Who it is.";
        variants must NonEmpty(&Label), "The variants.";
        timing may Map(&QuantityOr(&ours::KEYS)), "Times of ours, since the manual prints none: those that every manual has, with other values, and others.";
        tolerance may Map(&QuantityOr(&ours::KEYS)), "Tolerances of ours, numbers.";
        printed may Map(&Keys(&printed::KEYS)), "Times and tolerances that the manual prints.";
        rt_class may Whole(1, 2), "The class of its cyclic frames, 1 or 2 (PROFINET); 1 by default.";
        snmp may Flag, "It has an SNMP agent: its GSDML lists SNMP in SupportedProtocols, or claims conformance class B or above (PROFINET).";
        hello may Flag, "It says Hello as record 0x8090 says: its GSDML has DCP_HelloSupported (PROFINET).";
        constants may Map(&PerVariant(&Number)), "One number, or one for each variant.";
        words may Map(&WordTable), "Tables of words and their numbers.";
        derived may Map(&Condition), "Expressions over start parameters and constants.";
        signals must Map(&Keys(&signal::KEYS)), "What goes over the cyclic exchange.";
        network may Network, "The interface and the ports: by subslot of slot 0 the ident of the submodule.";
        submodules must Map(&Keys(&submodule::KEYS)), "Submodules.";
        modules must Map(&Keys(&module::KEYS)), "What one connection consists of.";
        records may Map(&Keys(&record::KEYS)), "Records.";
        parameters may Map(&Keys(&parameter::KEYS)), "Parameters of the base mode parameter access.";
        parameter_access may Keys(&parameter_access::KEYS), "How the parameters are reached, where it is not as the drive profile has it.";
        codes may Keys(&codes::KEYS), "Code tables of the manual.";
        stand may Keys(&stand::KEYS), "What a stand can do with it.";
        roles may Map(&List(&Name)), "Device-independent names.";
        changes may Keys(&changed::KEYS), "What changes the device for good.";
        variant_identification may Keys(&variant_identification::KEYS), "How a device shows which variant it is.";
        pages may Map(&Keys(&page::KEYS)), "Its web pages.";
        also may Map(&Keys(&also::KEYS)), "Suites for any device of this kind that the manual uses too, by the names of their folders.";
    }
}

key_set! {
    pub(crate) identity "identity" {
        vendor_id must Sourced(&Whole(0, 0xFFFF)), "Vendor ID of PI.";
        device_id must Sourced(&Whole(0, 0xFFFF)), "Device ID of the vendor.";
        station_type must Sourced(&Text), "Type of station as DCP shows it.";
    }
}

/// A `device.yaml` that was read, with what only the loader has to know of it.
#[derive(Debug)]
pub(super) struct Described {
    pub device: DeviceDescription,
    /// Numbers by name, one for each variant.
    pub constants: Vec<(String, Vec<Number>)>,
    /// Names and texts of `derived`.
    pub derived: Vec<(String, Node)>,
    /// The texts of `position_in`, each once; the index in this list is the number of the circle.
    pub circles: Vec<Node>,
    /// The tables of words.
    pub tables: Vec<Arc<WordTable>>,
    /// What is used by other definitions of this file, named as in `declared`.
    pub mentioned: Vec<String>,
    /// Everything that is declared here and can go unused: its name as [`super::names`] marks it, and its place.
    pub declared: Vec<(String, Spot)>,
}

/// Reads the device of the folder `folder`; with `has_any_name` its name may be another.
pub(super) fn read(node: &Node, folder: &str, has_any_name: bool, mistakes: &Mistakes) -> Option<Described> {
    let before = mistakes.count();
    let described =
        mistakes.keep(DeviceReader::new(node, mistakes).and_then(|reader| reader.device(folder, has_any_name)));
    described.filter(|_| mistakes.count() == before)
}

/// Interface and ports: subslots of slot 0 and idents.
fn network(node: &Node) -> Read<Vec<(u16, u32)>> {
    let mut network = Vec::new();
    for (key, ident) in node.entries("network")? {
        let subslot = whole::<u16>(key, "a subslot")?;
        if !(0x8000..=0x8FFF).contains(&subslot) {
            return Err(key
                .wrong(format!("{subslot:#06X} is no subslot of an interface or a port"))
                .help("an interface is at 0x8000, its ports are at 0x8001, 0x8002 ..."));
        }
        network.push((subslot, whole(ident, "an ident")?));
    }
    Ok(network)
}

/// What is known while a device is read.
struct DeviceReader<'n> {
    top: Keyed<'n>,
    mistakes: &'n Mistakes,
    variants: Vec<String>,
    tables: Vec<Arc<WordTable>>,
    constants: Vec<(String, Vec<Number>)>,
    circles: Vec<Node>,
    mentioned: RefCell<Vec<String>>,
    declared: Vec<(String, Spot)>,
}

impl<'n> DeviceReader<'n> {
    fn new(node: &'n Node, mistakes: &'n Mistakes) -> Read<DeviceReader<'n>> {
        let keys: &'static KeySet = match node.get(device::bus.name).and_then(Node::scalar) {
            Some("profibus") => &slave::KEYS,
            _ => &device::KEYS,
        };
        let (top, _) = Keyed::noting(node, keys, mistakes)?;
        let mentioned = RefCell::default();
        let (variants, tables, constants, circles, declared) = Default::default();
        Ok(DeviceReader { top, mistakes, variants, tables, constants, circles, mentioned, declared })
    }

    fn device(mut self, folder: &str, has_any_name: bool) -> Read<Described> {
        let name = self.top.must(&device::device)?;
        if name.text("device")? != folder && !has_any_name {
            let wrong = name.wrong(format!("this is the folder `{folder}`"));
            self.mistakes.note(wrong.help(format!("write `device: {folder}`")));
        }
        let is_slave = BUSES.read(self.top.must(&device::bus)?, &device::bus)?;
        self.variants = labels(self.top.must(&device::variants)?, "variants")?;
        self.words();
        self.constants();
        let before = self.mistakes.count();
        let codes = self.codes();
        let Wired { signals, submodules, modules, records, slave } = match is_slave {
            false => self.cyclic(),
            true => self.slave(&codes)?,
        };
        // What refers to a definition with a mistake would only say so again.
        let sound = self.mistakes.count() == before;
        let parameters = self.parameters();
        let access = match sound {
            true => self.kept(|of| of.parameter_access(is_slave, &submodules, &parameters)),
            false => Access::default(),
        };
        let stand = self.kept(DeviceReader::stand);
        let roles = self.kept(DeviceReader::roles);
        let pages = self.pages();
        let changes = if sound {
            self.kept(|of| of.changes(&signals, &parameters, &records, &pages))
        } else {
            LastingChanges::default()
        };
        let diagnosis = slave.as_ref().map(|slave| &slave.diagnosis);
        let names = IdentifyingNames { signals: &signals, records: &records, parameters: &parameters, diagnosis };
        let variant_identification =
            if sound { self.kept(|of| of.variant_identification(&names)) } else { VariantIdentification::default() };
        let derived = self.kept(DeviceReader::derived);
        self.names_differ(&records);
        let title = self.kept(|of| of.top.must(&device::title)?.text("title").map(str::to_owned));
        let rt_class = match self.top.get(&device::rt_class) {
            None => 1,
            Some(node) => match whole::<u8>(node, "a class")? {
                class @ (1 | 2) => class,
                other => {
                    return Err(node
                        .wrong(format!("there is no class {other} of cyclic frames here"))
                        .help("write 1 or 2"));
                }
            },
        };
        let has_snmp = flag(self.top, &device::snmp)?;
        let has_hello = flag(self.top, &device::hello)?;
        let network = self.kept(|of| of.top.get(&device::network).map_or(Ok(Vec::new()), network));
        let timing = self.timing();
        let bus = match slave {
            None => ProfinetFacts {
                identity: self.identity()?,
                rt_class,
                network,
                has_snmp,
                has_hello,
                parameter_point: access.point,
            }
            .into(),
            Some(WiredSlave { address, set_prm, diagnosis }) => {
                let (ident, ident_origin) = self.ident()?;
                let parameter_slot = access.slot;
                let min_slave_interval = Duration::ZERO;
                ProfibusFacts { ident, ident_origin, address, set_prm, diagnosis, min_slave_interval, parameter_slot }
                    .into()
            }
        };
        let device = DeviceDescription {
            name: folder.to_owned(),
            bus,
            title,
            variants: self.variants,
            variant_identification,
            timing,
            signals,
            submodules,
            modules,
            records,
            parameters,
            parameter_access: access.common,
            codes,
            stand,
            roles,
            changes,
            pages,
        };
        let mut mentioned = self.mentioned.into_inner();
        // The submodules of the device access point are part of every connection.
        let access_point = device.submodules.iter().filter(|submodule| submodule.slot == 0);
        mentioned.extend(access_point.map(|submodule| format!("submodule `{}`", submodule.name)));
        mentioned.extend(
            device
                .records
                .iter()
                .filter_map(|record| Some(format!("submodule `{}`", device.submodules.get(record.at)?.name))),
        );
        let access = access.point.and_then(|at| device.submodules.get(at));
        mentioned.extend(access.map(|submodule| format!("submodule `{}`", submodule.name)));
        Ok(Described {
            device,
            constants: self.constants,
            derived,
            circles: self.circles,
            tables: self.tables,
            mentioned,
            declared: self.declared,
        })
    }

    /// What `read` reads; a mistake in it is noted, and reading goes on.
    fn kept<T: Default>(&mut self, read: impl FnOnce(&mut Self) -> Read<T>) -> T {
        let mistakes = self.mistakes;
        mistakes.keep(read(self)).unwrap_or_default()
    }

    /// No two of the names that stand alone in an expression are the same.
    fn names_differ(&self, records: &[DeviceRecord]) {
        let starts = records.iter().filter(|record| record.start);
        let written = |record: &DeviceRecord| match self.top.get(&device::records) {
            Some(records) => records.get(&record.name),
            None => self.top.get(&slave::set_prm),
        };
        let fields = starts.filter_map(|record| written(record)?.get("fields")?.mapping());
        let others = [&device::constants, &device::derived, &device::signals, &device::records]
            .into_iter()
            .filter_map(|key| self.top.get(key)?.mapping());
        let mut known: Vec<&str> = RESERVED.to_vec();
        for (key, _) in others.chain(fields).flatten() {
            let Some(name) = key.scalar() else { continue };
            if known.contains(&name) || parameter_number(name).is_some() {
                self.mistakes.note(
                    key.wrong(format!("`{name}` is a name already"))
                        .help("names that can stand in an expression differ"),
                );
            }
            known.push(name);
        }
    }

    fn identity(&self) -> Read<ProfinetIdentity> {
        let keyed = Keyed::new(self.top.must(&device::identity)?, &identity::KEYS)?;
        let (device_id, device_id_origin) = sourced(keyed.must(&identity::device_id)?)?;
        let (vendor_id, _) = sourced(keyed.must(&identity::vendor_id)?)?;
        let (station_type, _) = sourced(keyed.must(&identity::station_type)?)?;
        Ok(ProfinetIdentity {
            vendor_id: whole(vendor_id, "the vendor ID")?,
            device_id: whole(device_id, "the device ID")?,
            station_type: station_type.text("the type of station")?.to_owned(),
            device_id_origin,
        })
    }

    fn words(&mut self) {
        for (name, node) in self.entries(&device::words) {
            let table = self.mistakes.keep(word_table(name, node));
            let Some(table) = table else { continue };
            for (word, _) in node.mapping().unwrap_or_default() {
                self.declare("word", &format!("{name}.{}", word.scalar().unwrap_or_default()), word.spot);
            }
            self.tables.push(table);
        }
    }

    fn constants(&mut self) {
        for (name, node) in self.entries(&device::constants) {
            let read = label(node, name).and_then(|()| self.per_variant(node, |node, _| numeral(node, "a constant")));
            if let Some(values) = self.mistakes.keep(read) {
                self.declare("constant", name, node.spot);
                self.constants.push((name.to_owned(), values));
            }
        }
    }

    fn derived(&mut self) -> Read<Vec<(String, Node)>> {
        let mut derived = Vec::new();
        for (name, node) in self.entries(&device::derived) {
            node.text("a derived value")?;
            self.declare("derived value", name, node.spot);
            derived.push((name.to_owned(), node.clone()));
        }
        Ok(derived)
    }

    /// A default of a field or parameter as it goes on the wire: a number, a word, `=` and an expression over constants.
    fn default(&self, node: &Node, ty: &Type) -> Read<Vec<i128>> {
        self.per_variant(node, |node, variant| {
            let scope = Constants { constants: &self.constants, mentioned: &self.mentioned, variant };
            let value = match node.expression() {
                Some(text) => {
                    let program = Program::value(text, Some(ty), &scope, Allow::DEVICE)
                        .map_err(|error| Mistake::expression(node.spot, node.lead() + 1, text, error))?;
                    program.constant().cloned()
                }
                None => {
                    let text = plain(node, "a default")?;
                    if let Type::Word(table) = ty {
                        self.mentioned.borrow_mut().push(format!("word `{}.{text}`", table.name));
                    }
                    Some(
                        expression::literal(text, ty)
                            .map_err(|error| Mistake::expression(node.spot, 0, text, error))?,
                    )
                }
            };
            value.and_then(|value| value.as_whole()).ok_or_else(|| node.wrong("this is no whole number"))
        })
    }

    /// One value for all variants, or a mapping with one for each.
    fn per_variant<T: Clone>(&self, node: &Node, read: impl Fn(&Node, usize) -> Read<T>) -> Read<Vec<T>> {
        let Some(entries) = node.mapping() else {
            return (0..self.variants.len()).map(|variant| read(node, variant)).collect();
        };
        for (key, _) in entries {
            let name = key.text("a variant")?;
            if !self.variants.iter().any(|known| known == name) {
                return Err(Mistake::unknown(key.spot, "variant", name, self.variants.iter().map(String::as_str)));
            }
        }
        let each = self.variants.iter().enumerate().map(|(index, variant)| match node.get(variant) {
            Some(value) => read(value, index),
            None => Err(node.wrong(format!("there is no value for the variant `{variant}`"))),
        });
        each.collect()
    }

    fn table(&self, node: &Node) -> Read<Arc<WordTable>> {
        let name = plain(node, "a table of words")?;
        match self.tables.iter().find(|table| table.name == name) {
            Some(table) => Ok(Arc::clone(table)),
            None => Err(Mistake::unknown(
                node.spot,
                "table of words",
                name,
                self.tables.iter().map(|table| table.name.as_str()),
            )),
        }
    }

    /// The entries of a mapping at the top, with their names; a missing key has none.
    fn entries(&self, key: &Key) -> Vec<(&'n str, &'n Node)> {
        let node = self.top.get(key);
        let read = node.map_or(Ok(Vec::new()), |node| named(node, key.name));
        self.mistakes.keep(read).unwrap_or_default()
    }

    fn declare(&mut self, kind: &str, name: &str, spot: Spot) {
        self.declared.push((format!("{kind} `{name}`"), spot));
    }
}

/// The names that a default may use.
struct Constants<'r> {
    constants: &'r [(String, Vec<Number>)],
    mentioned: &'r RefCell<Vec<String>>,
    variant: usize,
}

impl NameScope for Constants<'_> {
    fn lookup(&self, path: &str) -> Option<ResolvedName> {
        let (_, values) = self.constants.iter().find(|(name, _)| name == path)?;
        self.mentioned.borrow_mut().push(format!("constant `{path}`"));
        let value = *values.get(self.variant)?;
        Some(ResolvedName::Constant(Value::Number(value), if value.is_whole() { Type::WHOLE } else { Type::FRACTION }))
    }

    fn known(&self, visit: &mut dyn FnMut(&str)) {
        self.constants.iter().for_each(|(name, _)| visit(name));
    }
}

/// First parts of the names that every device has; nothing else can have them.
pub const RESERVED: [&str; 28] = [
    "io",
    "connection",
    "diag",
    "cfg",
    "station",
    "power",
    "link",
    "device",
    "shaft",
    "fault",
    "button",
    "switch",
    "supply",
    "led",
    "counter",
    "alarm",
    "abort",
    "lldp",
    "hello",
    "ready",
    "answer",
    "page",
    "bench",
    "cycle",
    "elapsed",
    "timing",
    "tolerance",
    "printed",
];

fn word_table(name: &str, node: &Node) -> Read<Arc<WordTable>> {
    let words = named(node, "a table of words")?;
    if words.is_empty() {
        return Err(node.wrong(format!("the table `{name}` is empty")));
    }
    let mut list: Vec<(String, i64)> = Vec::new();
    for (word, number) in words {
        let value = whole::<i64>(number, "the number of a word")?;
        if list.iter().any(|(_, known)| *known == value) {
            return Err(number.wrong(format!("{value} has a word in `{name}` already")));
        }
        list.push((word.to_owned(), value));
    }
    Ok(WordTable::new(name, list))
}
