//! Which names there are, for suggestions and for the schema.

use super::super::device::DiagnosisName;
use super::super::dialect::{self, Dialect};
use super::Names;

/// Names, each with what it is.
pub(in super::super) type Sentences = &'static [(&'static str, &'static str)];

impl Names<'_> {
    /// Every constant, start parameter and derived value.
    pub(super) fn values(&self, visit: &mut dyn FnMut(&str)) {
        self.described.constants.iter().for_each(|(name, _)| visit(name));
        self.described.derived.iter().for_each(|(name, _)| visit(name));
        let starts = self.device().records.iter().filter(|record| record.start);
        starts.flat_map(|record| &record.fields).for_each(|field| visit(&field.name));
    }

    /// Every name there is, for suggestions.
    pub(in super::super) fn known(&self, visit: &mut dyn FnMut(&str)) {
        let device = self.device();
        for signal in &device.signals {
            visit(&signal.name);
            signal.fields.iter().for_each(|field| visit(&format!("{}.{}", signal.name, field.name)));
        }
        for record in device.records.iter().filter(|_| device.profibus().is_none()) {
            record.fields.iter().for_each(|field| visit(&format!("{}.{}", record.name, field.name)));
        }
        for parameter in &device.parameters {
            visit(&format!("P{}", parameter.number));
            parameter.elements.iter().for_each(|(name, _)| visit(&format!("P{}.{name}", parameter.number)));
            for (of, fields) in &parameter.bits {
                let dot = if of.is_empty() { "" } else { "." };
                fields.iter().for_each(|field| visit(&format!("P{}{dot}{of}.{}", parameter.number, field.name)));
            }
        }
        let stand = &device.stand;
        stand.faults.iter().for_each(|(name, _)| visit(&format!("fault.{name}")));
        stand.buttons.iter().for_each(|(name, _)| visit(&format!("button.{name}")));
        stand.switches.iter().for_each(|switch| visit(&format!("switch.{}", switch.name)));
        stand.leds.iter().for_each(|(name, _)| visit(&format!("led.{name}")));
        stand.counters.iter().for_each(|(name, _)| visit(&format!("counter.{name}")));
        let shown = device.pages.iter().flat_map(|page| &page.shows);
        shown.for_each(|value| visit(&format!("page.{}", value.name)));
        device.roles.iter().for_each(|(name, _)| visit(&format!("role.{name}")));
        if let Some(slave) = device.profibus() {
            DiagnosisName::words().for_each(|(word, _)| visit(&format!("diag.{word}")));
            slave.diagnosis.fields.iter().for_each(|field| visit(&format!("diag.{}", field.name)));
        }
        built_in_names(dialect::of(device.bus.kind())).for_each(|(name, _)| visit(name));
        self.values(visit);
    }
}

/// Names that every device has, with what each is.
const ON_BOTH: Sentences = &[
    ("io.input_length", "octets of input data"),
    ("io.cyclic", "whether we send cyclic frames: running, paused"),
    ("connection", "data or none, as our controller sees it"),
    ("shaft.speed", "revolutions per minute, clockwise positive"),
    (
        "shaft.acceleration",
        "by how many revolutions per minute each second speeds are reached from now on; 0, as each trial begins: at once",
    ),
    ("shaft.counts", "the raw place in hardware steps"),
    ("power", "up, down"),
    ("link", "up, down"),
    ("supply.voltage", "in volts"),
    ("supply.temperature", "in degrees Celsius"),
    ("answer", "the last answer"),
    ("answer.bytes", "the octets of the last response"),
    ("bench.address", "the controller's address"),
    ("cycle", "the time between two cyclic frames"),
    ("elapsed", "the time between this cyclic frame and the one before it of the same direction, as it was seen"),
    ("timing.reaction", "the default deadline"),
    ("timing.start", "from Connect to the first good sample"),
    ("timing.power_up", "from power to an answer"),
    ("timing.save", "saving"),
];

/// Names that every device on PROFINET has besides.
pub(in super::super) const ON_PROFINET: Sentences = &[
    ("io.outputs", "the output data as octets; also of one submodule, then only for `expect`"),
    ("io.inputs", "the input data as octets; also of one submodule"),
    (
        "io.alarm_acknowledge",
        "how we acknowledge alarms: given (in full), received (by the transport only), held (not at all)",
    ),
    ("io.output_status", "our provider status: good, bad; also of one submodule"),
    ("io.input_status", "the device's provider status: good, bad"),
    ("io.consumer_status", "the device's consumer status: good, bad"),
    ("station.name", "the name of the station"),
    ("station.ip", "its address"),
    ("station.mask", "its subnet mask"),
    ("station.gateway", "its gateway"),
    ("station.vendor_id", "its vendor ID"),
    ("station.device_id", "its device ID"),
    ("station.type", "its type"),
    ("station.mac", "the MAC address with which it answers an Identify now, 6 octets"),
    (
        "device",
        "as_delivered: one as it was delivered takes its place, without an address or anything stored, with the name that it comes with",
    ),
    ("alarm", "an alarm came"),
    ("alarm.change", "appears, disappears, all_disappear, disappears_others_remain"),
    ("alarm.error", "a word of codes.channel_error"),
    ("alarm.severity", "diagnosis, maintenance_required, maintenance_demanded"),
    ("alarm.slot", "its slot"),
    ("alarm.subslot", "its subslot"),
    ("alarm.channel", "its channel"),
    ("alarm.structure", "its UserStructureIdentifier"),
    ("abort", "the device aborted the connection"),
    ("abort.code", "why, as a word"),
    ("lldp", "the device announced itself to its neighbour"),
    ("lldp.name", "the station name that it tells there, as chassis id or behind the port id; empty if none"),
    ("lldp.chassis", "the octets of the chassis id"),
    ("lldp.port", "the port id up to its first dot, `port-001`"),
    ("lldp.mac", "the MAC address in the TLV of PROFINET, 6 octets; no value without that TLV"),
    ("lldp.source", "the MAC address that the announcement comes from, that of the port, 6 octets"),
    ("answer.status", "the status of the last web answer"),
    ("answer.contains", "texts that stand in the last web answer"),
    ("answer.lacks", "texts that do not"),
    ("answer.text", "the last web answer as a reader sees it"),
    ("bench.ip", "the address that the bench gives the device"),
    ("bench.mask", "the subnet mask that goes with it"),
    ("bench.free_ip", "an address of the same subnet that nobody has"),
];

/// Names that every device on PROFIBUS has besides; those of `diag` come from the tables of the wire.
pub(in super::super) const ON_PROFIBUS: Sentences = &[
    ("io.outputs", "the output data as octets"),
    ("io.inputs", "the input data as octets"),
    ("io.global_control", "whether the clock of isochronous mode comes: running, stopped"),
    ("io.clock_offset", "by how much it comes late"),
    ("io.diagnosis_pending", "the answer with the inputs had high priority: a new diagnosis is to be fetched"),
    ("diag.length", "octets of the last diagnosis"),
    ("diag.bytes", "the diagnosis as octets"),
    ("diag.ident", "the ident number in it"),
    ("diag.master", "the address of the master in it; 255 for none"),
    ("diag.errors", "a set of words of the codes that its blocks tell"),
    (
        "device",
        "as_delivered: one as it was delivered takes its place, with nothing stored, at the address that it comes with",
    ),
    ("cfg.bytes", "the identifiers that Get_Cfg tells"),
    ("station.address", "the station address at which a device of the right ident number answers"),
    ("answer.set_prm", "the last answer to Set_Prm"),
    ("answer.chk_cfg", "the last answer to Chk_Cfg"),
    ("bench.station", "the station address that the device has on the bench"),
    ("bench.free_station", "a station address that nobody has"),
    ("bench.second", "the station address of the second master"),
];

/// Names that every device on the bus of a dialect has, with what each is.
pub(in super::super) fn built_in_names(
    dialect: &Dialect,
) -> impl Iterator<Item = &'static (&'static str, &'static str)> + use<> {
    ON_BOTH.iter().chain(dialect.names)
}
