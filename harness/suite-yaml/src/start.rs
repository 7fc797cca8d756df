//! `start` and `connect`: the module, the settings of the bus, the start parameters and what is changed.

use super::device_yaml::{duration, plain};
use super::dialect;
use super::error::{Mistake, Read, every};
use super::frame::{StepScope, is_none, octets, text};
use super::request_keys::connect_request;
use super::yaml::{Node, NodeKind};
use controllers::profinet_io::ConnectField;
use expression::Value;
use std::time::Duration;
use suite::device::{DeviceDescription, DeviceRecord};
use suite::model::{ConnectionStart, StartDeviation, StartParameter};

/// The bytes of DP-V1 that a start-up sends.
fn dpv1(device: &DeviceDescription, instead: &[StartDeviation]) -> Option<[u8; 3]> {
    let changed = instead.iter().find_map(|instead| match instead {
        StartDeviation::Dpv1(octets) => Some(*octets),
        _ => None,
    });
    changed.or_else(|| device.profibus()?.set_prm.dpv1)
}

/// `over` laid over `under`, key by key; `none` on either side stands alone.
pub(super) fn merged(under: Option<&Node>, over: Option<&Node>) -> Read<Option<Node>> {
    let (under, over) = match (under, over) {
        (None, None) => return Ok(None),
        (Some(only), None) | (None, Some(only)) => return Ok(Some(only.clone())),
        (Some(under), Some(over)) => (under, over),
    };
    if is_none(over) || is_none(under) {
        return Ok(Some(over.clone()));
    }
    let mut entries = under.entries("start")?.to_vec();
    for (key, value) in over.entries("start")? {
        match entries.iter_mut().find(|(known, _)| known.scalar() == key.scalar()) {
            Some(entry) => *entry = (key.clone(), value.clone()),
            None => entries.push((key.clone(), value.clone())),
        }
    }
    Ok(Some(Node { spot: over.spot, kind: NodeKind::Mapping(entries) }))
}

impl StepScope<'_, '_> {
    /// A connection; the module is in use from here on.
    pub(super) fn start<'s>(&self, node: &'s Node) -> Read<ConnectionStart> {
        let device = self.names.device();
        let (mut module, mut cycle, mut watchdog, mut instead) = (None, None, None, Vec::new());
        let (mut unwatched, mut baud, mut isochronous) = (false, None, None);
        let on_profibus = device.profibus().is_some();
        let mut given: Vec<(usize, usize, i128, &'s Node)> = Vec::new();
        let mut entry = |(key, value): &'s (Node, Node)| -> Read<()> {
            match key.text("a key")? {
                "module" => module = Some(self.module(value)?),
                "cycle" => cycle = Some((duration(value, "a cycle")?, value)),
                "watchdog" if on_profibus && is_none(value) => unwatched = true,
                "baud" if on_profibus => baud = Some(self.baud(value)?),
                "isochronous" if on_profibus => isochronous = Some(self.isochronous(value)?),
                "watchdog" => watchdog = Some((duration(value, "a watchdog")?, value)),
                "instead" => instead = self.instead_start(value)?,
                name => {
                    let (record, field) = self.start_parameter(key, name)?;
                    given.push((record, field, self.start_value(value, record, field)?, key));
                }
            }
            Ok(())
        };
        let read = every(node.entries("start")?.iter().map(&mut entry));
        if read.is_err() {
            // What follows is checked with the module, whatever else is wrong.
            self.progress.module.set(module);
        }
        read?;
        let Some(module) = module else {
            return Err(node.wrong("a connection needs its `module`"));
        };
        if let Some((record, _, _, key)) = given.iter().find(|(record, ..)| !device.records[*record].starts(module)) {
            return Err(self.not_sent(key, &device.records[*record], module));
        }
        self.progress.module.set(Some(module));
        if let (Some((said, node)), Some(clock)) = (cycle, isochronous)
            && said != clock
        {
            return Err(node.wrong("in isochronous mode the clock is the cycle").help("leave out `cycle`"));
        }
        let cycle = match cycle {
            Some((cycle, node)) if !on_profibus => Some(checked_cycle(cycle, node)?),
            Some((Duration::ZERO, node)) => return Err(node.wrong("a cycle takes time")),
            cycle => cycle.map(|(cycle, _)| cycle),
        };
        let watchdog = watchdog
            .map(|(watchdog, node)| match on_profibus {
                false => checked_watchdog(watchdog, cycle.unwrap_or(device.timing.cycle), node),
                true => self.checked_slave_watchdog(watchdog, node, dpv1(device, &instead)),
            })
            .transpose()?;
        let fixes = device.modules.get(module).map_or(&[][..], |module| module.fixes());
        let mut parameters = Vec::new();
        for (record, of) in device.records.iter().enumerate().filter(|(_, record)| record.starts(module)) {
            self.names.mark("record", &of.name);
            for (field, of) in of.fields.iter().enumerate() {
                let said = given.iter().find(|(r, f, ..)| (*r, *f) == (record, field)).map(|(_, _, value, _)| *value);
                let fixed = || fixes.iter().find(|(of, _)| *of == field).map(|(_, value)| *value);
                let value = said.or_else(fixed).or_else(|| of.default.get(self.names.variant).copied());
                parameters.extend(value.map(|value| StartParameter { record, field, value }));
            }
        }
        Ok(ConnectionStart { module, cycle, watchdog, unwatched, baud, isochronous, parameters, instead })
    }

    /// The mistake that a start gives something to a record that its module does not take.
    fn not_sent(&self, key: &Node, record: &DeviceRecord, module: usize) -> Box<Mistake> {
        let modules = &self.names.device().modules;
        let with = record.with.iter().flatten().filter_map(|&index| modules.get(index));
        let with: Vec<String> = with.map(|module| format!("`{}`", module.name)).collect();
        let name = modules.get(module).map_or("", |module| module.name.as_str());
        key.wrong(format!("the record `{}` is not sent with the module `{name}`", record.name))
            .help(format!("it is sent with {}", with.join(", ")))
    }

    fn module(&self, node: &Node) -> Read<usize> {
        let modules = &self.names.device().modules;
        let name = plain(node, "a module")?;
        match modules.iter().position(|module| module.name == name) {
            Some(index) => {
                self.names.mark_module(index);
                Ok(index)
            }
            None => Err(Mistake::unknown(node.spot, "module", name, modules.iter().map(|module| module.name.as_str()))),
        }
    }

    fn start_parameter(&self, key: &Node, name: &str) -> Read<(usize, usize)> {
        let device = self.names.device();
        let starts = || device.records.iter().enumerate().filter(|(_, record)| record.start);
        for (record, of) in starts() {
            if let Some(field) = of.fields.iter().position(|field| field.name == name) {
                self.names.mark("field", &format!("{}.{name}", of.name));
                return Ok((record, field));
            }
        }
        let known = starts().flat_map(|(_, record)| &record.fields).map(|field| field.name.as_str());
        let settings = dialect::of(device.bus.kind()).settings;
        let known: Vec<&str> = known.chain(settings.names().map(|name| -> &str { name })).collect();
        Err(Mistake::unknown(key.spot, "start parameter", name, known))
    }

    fn start_value(&self, node: &Node, record: usize, field: usize) -> Read<i128> {
        let ty = self.names.record_type(record, field);
        let program = self.value(node, &ty)?;
        let value = program.constant().and_then(Value::as_whole);
        value.ok_or_else(|| node.wrong("a start parameter is known beforehand"))
    }

    fn instead_start(&self, node: &Node) -> Read<Vec<StartDeviation>> {
        let device = self.names.device();
        let mut list = Vec::new();
        for (key, value) in node.entries("instead")? {
            if device.profibus().is_some() {
                list.push(self.instead_slave(key, value)?);
                continue;
            }
            let name = key.text("a key")?;
            let record = device.records.iter().position(|record| record.start && record.name == name);
            if name == "fields" {
                list.extend(self.connect_fields(value)?);
                continue;
            }
            let only = |word: &str, help: &str| value.wrong(format!("`{name}` is `{word}` here")).help(help);
            list.push(match (name, record) {
                (_, Some(record)) if is_none(value) => StartDeviation::RecordNone(record),
                (_, Some(record)) => StartDeviation::RecordBytes(record, octets(value)?),
                ("output_length", _) => StartDeviation::OutputLength(self.number(value, "a length")?),
                ("input_length", _) => StartDeviation::InputLength(self.number(value, "a length")?),
                ("module_ident", _) => StartDeviation::ModuleIdent(self.number(value, "an ident")?),
                ("submodule_ident", _) => StartDeviation::SubmoduleIdent(self.number(value, "an ident")?),
                ("api", _) => StartDeviation::Api(self.number(value, "an API")?),
                ("rt_class", _) => match self.number(value, "an RT class")? {
                    class @ 1..=3 => StartDeviation::RtClass(class),
                    other => {
                        let mistake = value.wrong(format!("{other} is no RT class of a cyclic frame"));
                        return Err(mistake.help("it is 1, 2 or 3"));
                    }
                },
                ("slot", _) => StartDeviation::Slot(self.number(value, "a slot")?),
                ("dap_ident", _) => StartDeviation::AccessPointIdent(self.number(value, "an ident")?),
                ("byte_order", _) if value.text("a byte order")? == "little" => StartDeviation::LittleEndian,
                ("byte_order", _) => return Err(only("little", "without it the RPC headers are big-endian")),
                ("ip", _) if is_none(value) => StartDeviation::NoAddress,
                ("ip", _) => {
                    return Err(only("none", "give the device another address with `write: { station.ip: ... }`"));
                }
                ("access_point", _) if is_none(value) => StartDeviation::NoAccessPoint,
                ("access_point", _) => {
                    return Err(only("none", "without it the submodule of slot 0 is expected as well"));
                }
                ("network", _) if value.text("a word")? == "expected" => StartDeviation::NetworkExpected,
                ("network", _) => {
                    return Err(only("expected", "without it the interface and the ports are not expected"));
                }
                ("access", _) if value.text("a kind of access")? == "supervisor" => StartDeviation::SupervisorAccess,
                ("access", _) => {
                    let help = "without it the connection is that of a controller, with cyclic data";
                    return Err(only("supervisor", help));
                }
                ("parameter_pause", _) => StartDeviation::ParameterPause(duration(value, "a pause")?),
                ("station_name", _) => StartDeviation::StationName(text(value)?),
                _ => {
                    let records =
                        device.records.iter().filter(|record| record.start).map(|record| record.name.as_str());
                    let known: Vec<&str> =
                        connect_request::KEYS.names().map(|name| -> &str { name }).chain(records).collect();
                    return Err(Mistake::unknown(key.spot, "key of instead", name, known));
                }
            });
        }
        if list.is_empty() { Err(node.wrong("an empty `instead`")) } else { Ok(list) }
    }

    /// Fields of a Connect request, by their words.
    fn connect_fields(&self, node: &Node) -> Read<Vec<StartDeviation>> {
        let field = |(key, value): &(Node, Node)| {
            let word = key.text("a field")?;
            if ConnectField::by_word(word).is_none() {
                let known = ConnectField::TABLE.iter().map(|field| field.word);
                return Err(Mistake::unknown(key.spot, "field of a Connect", word, known));
            }
            Ok(StartDeviation::ConnectField(word.to_owned(), self.number(value, "a value of the field")?))
        };
        node.entries("fields of a Connect")?.iter().map(field).collect()
    }
}

/// A send clock of up to 4 ms, times a reduction that is a power of two.
pub fn checked_cycle(cycle: Duration, node: &Node) -> Read<Duration> {
    const SEND_CLOCKS: [u128; 5] = [250_000, 500_000, 1_000_000, 2_000_000, 4_000_000];
    let nanos = cycle.as_nanos();
    let reached = SEND_CLOCKS
        .iter()
        .any(|clock| nanos.is_multiple_of(*clock) && (nanos / clock).is_power_of_two() && nanos / clock <= 512);
    if reached {
        Ok(cycle)
    } else {
        Err(node
            .wrong("no send clock and reduction make this cycle")
            .help("a cycle is 250us, 500us, 1ms, 2ms, 4ms, ... 512ms"))
    }
}

/// A whole number of cycles, at most 255 and at most 1.92 s.
pub fn checked_watchdog(watchdog: Duration, cycle: Duration, node: &Node) -> Read<Duration> {
    let cycles = watchdog.as_nanos() / cycle.as_nanos().max(1);
    let good = watchdog.as_nanos() == cycle.as_nanos() * cycles
        && (1..=255).contains(&cycles)
        && watchdog <= Duration::from_millis(1920);
    if good {
        Ok(watchdog)
    } else {
        Err(node.wrong("a watchdog is a whole number of cycles, 1 to 255 of them, and at most 1920ms"))
    }
}
