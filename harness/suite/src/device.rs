//! What a device is, as `device.yaml` says it, with every name resolved.
//!
//! This is data about devices, so a new encoder needs no change here.

mod answer_part;
mod bus;
mod observability;
mod parameter_type;
mod profibus;
mod profinet;

pub use answer_part::AnswerPart;
pub use bus::{Bus, DeviceBus, ModuleBus, PerBus};
pub use observability::{Observability, UpdatedAt, VisibleIn};
pub use parameter_type::{Formats, ParameterType};
pub use profibus::{
    Diagnosis, DiagnosisBlocks, DiagnosisField, DiagnosisName, NUMBER_OCTETS, ProfibusFacts, UserParameters,
};
pub use profinet::{Identity, ProfinetFacts};

use expression::{Program, Value, WordTable};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::Duration;
use wire::profibus::diag::Status1;

/// A name as conditions and steps use it: an index into [`super::model::Variant::names`].
pub use expression::NameId;

/// Where a datum comes from that the manual does not print.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Deserialize, Serialize)]
pub enum Origin {
    /// The manual prints it.
    #[default]
    Manual,
    /// A vendor's GSDML or GSD.
    Description,
    /// Ours, for the reference device only; never a finding about a live device.
    Invented,
}

/// A device as its manual describes it.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Device {
    /// The name of the folder.
    pub name: String,
    /// The bus that it speaks, with what only devices on this bus have.
    pub bus: DeviceBus,
    /// The title for people.
    pub title: String,
    /// The variants, by name.
    pub variants: Vec<String>,
    /// The times that the manual gives.
    pub timing: Timing,
    /// What goes over the cyclic exchange.
    pub signals: Vec<Signal>,
    /// Submodules; on PROFIBUS each module has one, of its own name.
    pub submodules: Vec<Submodule>,
    /// Modules: what one connection consists of.
    pub modules: Vec<Module>,
    /// Records; on PROFIBUS there is one, with the user octets of Set_Prm.
    pub records: Vec<Record>,
    /// Parameters of the base mode parameter access.
    pub parameters: Vec<Parameter>,
    /// How they are reached.
    pub parameter_access: ParameterAccess,
    /// Code tables of the manual: table (`channel_error`, ...), word, number.
    pub codes: Vec<(String, Vec<(String, u32)>)>,
    /// What a stand can do with it.
    pub stand: StandNames,
    /// Device-independent names and the names they stand for, in order of preference.
    pub roles: Vec<(String, Vec<String>)>,
    /// What changes the device for good, so that a live bench has to consent.
    pub changes: Changes,
    /// Its web pages.
    pub pages: Vec<Page>,
}

impl Device {
    /// The web pages whose forms let it wait for another firmware.
    pub fn pages_for_firmware(&self) -> impl Iterator<Item = &Page> {
        self.changes.firmware.iter().filter_map(|changed| match changed {
            Changed::Page(page) => self.pages.get(*page),
            _ => None,
        })
    }

    /// What only devices on PROFINET have.
    pub fn profinet(&self) -> Option<&ProfinetFacts> {
        self.bus.profinet()
    }

    /// What only devices on PROFIBUS have.
    pub fn profibus(&self) -> Option<&ProfibusFacts> {
        self.bus.profibus()
    }

    /// Vendor ID and device ID of a device on PROFINET.
    pub fn ids(&self) -> Option<(u16, u16)> {
        self.profinet().map(|facts| (facts.identity.vendor_id, facts.identity.device_id))
    }

    /// Ident number of a device on PROFIBUS.
    pub fn ident(&self) -> Option<u16> {
        self.profibus().map(|facts| facts.ident)
    }

    /// The submodules at which the base mode parameter access may stand (PROFINET), as indices into [`Device::submodules`]: the one
    /// that the manual says, else those that the records of the start-up go to.
    pub fn parameter_points(&self) -> impl Iterator<Item = usize> + '_ {
        let said = self.profinet().and_then(|facts| facts.parameter_point);
        let starts = self.records.iter().filter(|record| record.start).map(|record| record.at);
        said.into_iter().chain(starts.filter(move |_| said.is_none()))
    }

    /// How suites call a part of the diagnosis, without `diag.`.
    pub fn diagnosis_name(&self, name: DiagnosisName) -> &str {
        match name {
            DiagnosisName::Length => "length",
            DiagnosisName::Bytes => "bytes",
            DiagnosisName::Ident => "ident",
            DiagnosisName::Master => "master",
            DiagnosisName::Errors => "errors",
            DiagnosisName::MasterLock => Status1::MASTER_LOCK.words().next().unwrap_or_default(),
            DiagnosisName::Bit { octet, bit } => profibus::status_word(octet, bit).unwrap_or_default(),
            DiagnosisName::Field(index) => {
                let fields = self.profibus().map_or(&[][..], |slave| &slave.diagnosis.fields);
                fields.get(index).map_or("?", |field| &field.name)
            }
        }
    }
}

/// How the parameters of a device are reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct ParameterAccess {
    /// Index of the record that takes requests and gives responses.
    pub index: u16,
    /// The drive object that is asked.
    pub do_id: u8,
    /// Number of the parameter that saves the others.
    pub save: u16,
}

/// The base mode parameter access of the drive profile and its "transfer to non-volatile memory".
impl Default for ParameterAccess {
    fn default() -> ParameterAccess {
        ParameterAccess { index: 0xB02E, do_id: 1, save: 971 }
    }
}

impl ParameterAccess {
    /// The data set of PROFIBUS that carries the same requests.
    pub const DATA_SET: u16 = 47;
}

/// A web page.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Page {
    /// Its name.
    pub name: String,
    /// Where it is.
    pub path: String,
    /// The fields of its form: our name and the one in the page.
    pub fields: Vec<(String, String)>,
    /// The values that it shows.
    pub shows: Vec<PageValue>,
    /// Where all this comes from.
    pub origin: Origin,
}

/// A value that a web page shows.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct PageValue {
    /// Its name, which no value of another page has.
    pub name: String,
    /// The text in front of it.
    pub behind: String,
    /// How it is written.
    pub form: PageForm,
    /// Whether it is a place in steps.
    pub steps: bool,
    /// Words for its numbers.
    #[serde(with = "expression::pool::maybe_table")]
    pub table: Option<Arc<WordTable>>,
}

/// How a value is written on a web page.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum PageForm {
    /// A number in decimal.
    Decimal,
    /// A number in hexadecimal, with or without `0x`.
    Hexadecimal,
    /// A word.
    Text,
}

/// What changes a device for good, besides names, addresses and resets by DCP.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct Changes {
    /// What gives the present place another value: the reference of the machine around it is lost.
    pub position_reference: Vec<Changed>,
    /// What makes it write its memory; parameters that are `permanent` do so too.
    pub nvm_write: Vec<Changed>,
    /// What brings back what it was delivered with.
    pub factory_reset: Vec<Changed>,
    /// What lets it wait for another firmware.
    pub firmware: Vec<Changed>,
}

/// Something that is set or written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Changed {
    /// Bits of an output signal; any that is 1.
    Signal {
        /// Index into `signals`.
        signal: usize,
        /// The lowest bit.
        low: u32,
        /// How many bits.
        width: u32,
    },
    /// A parameter (index into `parameters`).
    Parameter(usize),
    /// A record (index into `records`).
    Record(usize),
    /// The form of a web page (index into `pages`).
    Page(usize),
}

/// The times that a manual gives.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct Timing {
    /// The deadline of an expectation without `within`.
    pub reaction: Duration,
    /// From Connect to the first good sample, at most.
    pub start: Duration,
    /// From power to an answer, at most.
    pub power_up: Duration,
    /// Saving, at most.
    pub save: Duration,
    /// The cycle of connections that say none; the bench's, not the manual's.
    pub cycle: Duration,
    /// The watchdog of connections that say none; ten cycles where the bench says none either.
    pub watchdog: Option<Duration>,
}

/// Who sends a signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize)]
pub enum From {
    /// The controller: an output.
    Controller,
    /// The device: an input.
    Device,
}

/// A value in the cyclic data; most significant octet first.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Signal {
    /// Its name in the manual.
    pub name: String,
    /// Who sends it.
    pub from: From,
    /// Width in bits: 8, 16, 32 or 64.
    pub width: u32,
    /// Whether it is a two's complement.
    pub signed: bool,
    /// Where it comes from.
    pub origin: Origin,
    /// The size of the circle it is a place on, as written; compiled for each variant by the loader.
    pub position_in: Option<String>,
    /// By how many bits its number stands further left than its lowest step, for each variant.
    pub shift: Vec<u32>,
    /// Its bits and bit groups.
    pub fields: Vec<Field>,
}

/// Bits of a signal, of a parameter element or of a record.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct Field {
    /// Its name.
    pub name: String,
    /// The lowest bit, 0 is the least significant of the whole.
    pub low: u32,
    /// How many bits.
    pub width: u32,
    /// Whether it is a two's complement.
    pub signed: bool,
    /// Words for its numbers.
    pub words: Vec<(String, i128)>,
    /// The same words as the type of the name.
    #[serde(with = "expression::pool::maybe_table")]
    pub table: Option<Arc<WordTable>>,
    /// For a sign of life: the first and the last number that it counts through by itself.
    pub counts: Option<(u32, u32)>,
}

/// A submodule.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Submodule {
    /// Its name.
    pub name: String,
    /// Slot number.
    pub slot: u16,
    /// Subslot number.
    pub subslot: u16,
    /// API.
    pub api: u32,
    /// Ident number.
    pub ident: u32,
    /// For each variant the ident number of the module that it is part of, where that is another one than the entry of
    /// `modules` says; always there in slot 0, which has no such entry.
    pub module_idents: Option<Vec<u32>>,
    /// Where the ident numbers come from.
    pub ident_origin: Origin,
    /// Octets of output data.
    pub output_octets: u16,
    /// Octets of input data.
    pub input_octets: u16,
    /// Signals in the output data in order (indices into `signals`).
    pub outputs: Vec<usize>,
    /// Signals in the input data in order.
    pub inputs: Vec<usize>,
}

impl Submodule {
    /// Ident number of the module that it is part of in this variant, where the entry of `modules` does not say it.
    pub fn module_ident(&self, variant: usize) -> Option<u32> {
        self.module_idents.as_ref()?.get(variant).copied()
    }
}

/// A module: what one connection consists of.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Module {
    /// Its name.
    pub name: String,
    /// How a controller asks for it.
    pub bus: ModuleBus,
    /// Where the ident number, or the configuration, comes from.
    pub ident_origin: Origin,
    /// Its submodules (indices into `submodules`), without those of the device access point.
    pub submodules: Vec<usize>,
}

/// A record.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Record {
    /// Its name.
    pub name: String,
    /// Index.
    pub index: u16,
    /// The submodule it is read from and written to (index into `submodules`).
    pub at: usize,
    /// Its length.
    pub octets: usize,
    /// Whether it is part of the start-up.
    pub start: bool,
    /// The modules (indices into `modules`) with which it is part of the start-up, where that is not every one.
    pub with: Option<Vec<usize>>,
    /// Its fields; the order is that of the file.
    pub fields: Vec<RecordField>,
    /// Where the layout comes from.
    pub origin: Origin,
}

impl Record {
    /// Whether the start-up of this module (an index into `modules`) sends it.
    pub fn starts(&self, module: usize) -> bool {
        self.start && self.with.as_ref().is_none_or(|with| with.contains(&module))
    }
}

/// A field of a record.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct RecordField {
    /// Its name.
    pub name: String,
    /// First octet.
    pub octet: usize,
    /// Number of octets that the field lies in.
    pub octets: usize,
    /// For bits in one octet: the lowest bit and how many.
    pub bits: Option<(u32, u32)>,
    /// Words for its numbers.
    pub words: Vec<(String, i128)>,
    /// The same words as the type of the name.
    #[serde(with = "expression::pool::maybe_table")]
    pub table: Option<Arc<WordTable>>,
    /// Its default for each variant; text fields have none.
    pub default: Vec<i128>,
    /// Lowest and highest number that the manual allows.
    pub range: (Option<i128>, Option<i128>),
    /// Whether the octets are text.
    pub text: bool,
    /// Where the layout comes from.
    pub origin: Origin,
}

/// A parameter of the base mode parameter access.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Parameter {
    /// Its number.
    pub number: u16,
    /// The type of its elements.
    pub kind: ParameterType,
    /// Whether it can be written.
    pub writable: bool,
    /// Its default for each variant, where the manual gives one.
    pub default: Option<Vec<i128>>,
    /// Whether a write changes the device for good.
    pub permanent: bool,
    /// Where it comes from.
    pub origin: Origin,
    /// Names of its elements and their subindices; empty where it is no array.
    pub elements: Vec<(String, u16)>,
    /// Names of bits, for an element (by name) or, with an empty name, for the whole.
    pub bits: Vec<(String, Vec<Field>)>,
}

/// What a stand can do with a device.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct StandNames {
    /// Faults and what each means.
    pub faults: Vec<(String, String)>,
    /// Buttons and where each is.
    pub buttons: Vec<(String, String)>,
    /// Coding switches.
    pub switches: Vec<CodingSwitch>,
    /// The supply voltage that a trial finds, in volts.
    pub voltage: Option<f64>,
    /// The temperature that a trial finds, in degrees Celsius.
    pub temperature: Option<f64>,
    /// LEDs and the words for what each can show.
    pub leds: Vec<(String, Vec<String>)>,
    /// Counters.
    pub counters: Vec<(String, String)>,
}

/// A coding switch.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct CodingSwitch {
    /// Its name.
    pub name: String,
    /// Its lowest position.
    pub lowest: u32,
    /// Its highest position.
    pub highest: u32,
    /// The position that a trial finds.
    pub home: u32,
}

/// What a name is and how it is reached.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub enum NameKind {
    /// A signal, its bit or field; with the program for the size of its circle, where it is a place on one.
    Signal {
        /// Index into `device.signals`.
        signal: usize,
        /// The bits (`low`, `width`, `signed`) of the signal that are meant.
        low: u32,
        /// How many bits.
        width: u32,
        /// Whether they are a two's complement.
        signed: bool,
        /// Index of the field, where one is named.
        field: Option<usize>,
        /// The size of the circle.
        circle: Option<Program>,
        /// By how many bits the number stands further left than its lowest step.
        shift: u32,
    },
    /// `io.outputs`, the output data as octets: of one submodule or of the module.
    OutputOctets(Option<usize>),
    /// `io.inputs`, the input data as octets: of one submodule or of the module.
    InputOctets(Option<usize>),
    /// `io.input_length`, octets of input data of the module.
    InputLength,
    /// `io.cyclic`: `running` or `paused`.
    Cyclic,
    /// `io.alarm_acknowledge`: `given`, `received`, `held`.
    AlarmAcknowledge,
    /// `io.output_status`: our IOPS, of one submodule or of all.
    OutputStatus(Option<usize>),
    /// `io.input_status`: the device's IOPS.
    InputStatus(Option<usize>),
    /// `io.consumer_status`: the device's IOCS.
    ConsumerStatus(Option<usize>),
    /// `io.global_control`: whether the clock of isochronous mode runs, `running` or `stopped`.
    GlobalControl,
    /// `io.clock_offset`: by how much the clock of isochronous mode comes late, a duration.
    ClockOffset,
    /// `io.diagnosis_pending`: the answer with the inputs had high priority.
    DiagnosisPending,
    /// The last Slave_Diag of the device, or a part of it.
    Diagnosis(DiagnosisName),
    /// `cfg.bytes`: the identifiers that Get_Cfg tells.
    Configuration,
    /// `connection`: `data` or `none`.
    Connection,
    /// A parameter, an element of it, or bits of an element.
    Parameter {
        /// Index into `device.parameters`, or `None` for a number that the device lacks.
        parameter: Option<usize>,
        /// Its number.
        number: u16,
        /// The subindex.
        subindex: u16,
        /// Lowest bit and number of bits, where bits are meant.
        bits: Option<(u32, u32)>,
    },
    /// A field of a record (indices into `device.records` and its fields).
    Record {
        /// The record.
        record: usize,
        /// The field; `None` for the record as octets.
        field: Option<usize>,
    },
    /// A value on a web page (indices into `device.pages` and its values).
    Page {
        /// The page.
        page: usize,
        /// The value.
        value: usize,
    },
    /// A value of the station: on PROFINET by DCP.
    Station(StationName),
    /// Something that the stand sets.
    Stand(StandName),
    /// `led.x` (index into `device.stand.leds`).
    Led(usize),
    /// `counter.x` (index into `device.stand.counters`).
    Counter(usize),
    /// An event or a part of one.
    Event(EventName),
    /// `answer` and its parts.
    Answer(AnswerPart),
    /// A start parameter in force (indices into `device.records` and its fields).
    StartParameter {
        /// The record.
        record: usize,
        /// The field.
        field: usize,
    },
    /// A value of `derived`, index into [`super::model::Variant::derived`].
    Derived(usize),
    /// A saved value, index into [`super::model::TrialSteps::saved`].
    Saved(usize),
    /// `cycle`, a duration.
    Cycle,
    /// `elapsed`, the time between this frame and the one before it of the same direction.
    Elapsed,
    /// An address of the bench.
    Bench(BenchName),
    /// A value that is known at load time.
    Constant(Value),
}

/// An address of the bench, which is another one on each bench.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize)]
pub enum BenchName {
    /// `bench.address`: that of our controller; on PROFIBUS the station address of our master.
    Address,
    /// `bench.ip`: the one that the bench gives the device.
    Ip,
    /// `bench.mask`: the subnet mask that goes with it.
    Mask,
    /// `bench.free_ip`: one of the same subnet that nobody has.
    FreeIp,
    /// `bench.station`: the station address that the device has on this bench (PROFIBUS).
    Station,
    /// `bench.free_station`: a station address that nobody has (PROFIBUS).
    FreeStation,
    /// `bench.second`: the station address of the second master (PROFIBUS).
    Second,
}

/// A value of the station.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize)]
pub enum StationName {
    /// `station.name`.
    Name,
    /// `station.ip`.
    Ip,
    /// `station.mask`.
    Mask,
    /// `station.gateway`.
    Gateway,
    /// `station.vendor_id`.
    VendorId,
    /// `station.device_id`.
    DeviceId,
    /// `station.type`.
    Type,
    /// `station.mac`.
    Mac,
    /// `station.address`: the PROFIBUS address at which a slave of the right ident number answers.
    Address,
}

/// Something that a stand sets (indices into [`StandNames`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize)]
pub enum StandName {
    /// `power`: `up`, `down`.
    Power,
    /// `link`: `up`, `down`.
    Link,
    /// `device`: `as_delivered`.
    Delivery,
    /// `shaft.speed`, in rpm.
    ShaftSpeed,
    /// `shaft.acceleration`, in rpm for each second: how speeds are reached from then on.
    ShaftAcceleration,
    /// `shaft.counts`, the raw place.
    ShaftCounts,
    /// `supply.voltage`.
    SupplyVoltage,
    /// `supply.temperature`.
    Temperature,
    /// `fault.x`: `present`, `absent`.
    Fault(usize),
    /// `button.x`: `pressed`, `released`.
    Button(usize),
    /// `switch.x`.
    Switch(usize),
}

/// An event or a part of one: true, or there, at one instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize)]
pub enum EventName {
    /// `alarm`.
    Alarm,
    /// `alarm.change`: `appears`, `disappears`, `all_disappear`.
    AlarmChange,
    /// `alarm.error`: a word of `codes.channel_error`.
    AlarmError,
    /// `alarm.severity`: `diagnosis`, `maintenance_required`, `maintenance_demanded`.
    AlarmSeverity,
    /// `alarm.slot`.
    AlarmSlot,
    /// `alarm.subslot`.
    AlarmSubslot,
    /// `alarm.channel`.
    AlarmChannel,
    /// `alarm.structure`: the UserStructureIdentifier.
    AlarmStructure,
    /// `abort`.
    Abort,
    /// `abort.code`.
    AbortCode,
    /// `lldp`.
    Lldp,
    /// `lldp.name`.
    LldpName,
    /// `lldp.chassis`.
    LldpChassis,
    /// `lldp.port`.
    LldpPort,
    /// `lldp.mac`.
    LldpMac,
    /// `lldp.source`.
    LldpSource,
}

impl EventName {
    /// Whether it is the announcement of a neighbour, which no switch passes on.
    pub fn is_lldp(self) -> bool {
        use EventName::{Lldp, LldpChassis, LldpMac, LldpName, LldpPort, LldpSource};
        matches!(self, Lldp | LldpName | LldpChassis | LldpPort | LldpMac | LldpSource)
    }
}
