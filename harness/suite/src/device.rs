//! The contents of `device.yaml` with all names resolved.
//!
//! This is the schema of device data; a new encoder needs no change here.

mod answer_part;
mod bus;
mod observability;
mod parameter_type;
mod profibus;
mod profinet;
mod signal_form;
mod timing;
mod variant_identification;

pub use answer_part::AnswerPart;
pub use bus::{Bus, DeviceBus, ModuleBus, PerBus};
pub use observability::{Observability, UpdatedAt, VisibleIn};
pub use parameter_type::{Formats, ParameterType};
pub use profibus::{
    DiagnosedAlarmPart, DiagnosisBlocks, DiagnosisField, DiagnosisLayout, DiagnosisName, NUMBER_OCTETS, ProfibusFacts,
    UserPrmLayout,
};
pub use profinet::{ProfinetFacts, ProfinetIdentity};
pub use signal_form::{SignalForm, text_of};
pub use timing::{DeviceTiming, OurSpan, PATIENCE, PrintedSpan, STANDARD_TIMES};
pub use variant_identification::{ExpectedNumber, VariantIdentification, VariantValue, VariantValueSource};

use expression::{Program, Value, WordTable};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use wire::octets::mask;

/// A name as conditions and steps use it: an index into [`super::model::SuiteVariant::names`].
pub use expression::NameId;

/// The source of a value in `device.yaml`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Deserialize, Serialize)]
pub enum Origin {
    /// The manual prints it.
    #[default]
    Manual,
    /// A vendor's GSDML or GSD.
    Description,
    /// Invented for the reference device; never a finding about a live device.
    Invented,
}

/// A device as its manual describes it.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct DeviceDescription {
    /// Name of the manual, which is its folder.
    pub name: String,
    /// The bus with its bus-specific facts.
    pub bus: DeviceBus,
    /// Title for reports.
    pub title: String,
    /// Names of the variants.
    pub variants: Vec<String>,
    /// How a device shows which variant it is.
    pub variant_identification: VariantIdentification,
    /// Times and tolerances.
    pub timing: DeviceTiming,
    /// Signals in the cyclic data.
    pub signals: Vec<DeviceSignal>,
    /// Submodules; on PROFIBUS each module has one with the same name.
    pub submodules: Vec<DeviceSubmodule>,
    /// Modules; a connection uses one of them.
    pub modules: Vec<DeviceModule>,
    /// Records; on PROFIBUS one, with the user parameter data of Set_Prm.
    pub records: Vec<DeviceRecord>,
    /// Parameters of the base mode parameter access.
    pub parameters: Vec<DeviceParameter>,
    /// Access to the parameters.
    pub parameter_access: ParameterAccess,
    /// Code tables of the manual: name (`channel_error`, ...), words with numbers.
    pub codes: Vec<(String, Vec<(String, u32)>)>,
    /// Names that a stand can serve.
    pub stand: StandNames,
    /// Roles (device-independent names) and their names, in order of preference.
    pub roles: Vec<(String, Vec<String>)>,
    /// Actions with lasting effects, which need consents on a live bench.
    pub changes: LastingChanges,
    pub pages: Vec<WebPage>,
}

impl DeviceDescription {
    /// The web pages whose forms start the wait for a firmware update.
    pub fn pages_for_firmware(&self) -> impl Iterator<Item = &WebPage> {
        self.changes.firmware.iter().filter_map(|changed| match changed {
            Changed::Page(page) => self.pages.get(*page),
            _ => None,
        })
    }

    /// The question that decides between these variants (indices into `variants`), and how a bench file answers it.
    pub fn variant_question(&self, left: &[usize]) -> String {
        let names = left.iter().filter_map(|index| self.variants.get(*index));
        let names: Vec<String> = names.map(|variant| format!("`{}/{variant}`", self.name)).collect();
        let question = self.variant_identification.question.trim();
        let question = if question.is_empty() { "Which variant is it?" } else { question };
        format!("{question} Write {}.", names.join(" or "))
    }

    /// The facts of a device on PROFINET.
    pub fn profinet(&self) -> Option<&ProfinetFacts> {
        self.bus.profinet()
    }

    /// The facts of a device on PROFIBUS.
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

    /// The submodules that can have the parameter access point (PROFINET), as indices into [`DeviceDescription::submodules`]: the one in the
    /// manual, else those that the start-up records are written to.
    pub fn parameter_points(&self) -> impl Iterator<Item = usize> + '_ {
        let said = self.profinet().and_then(|facts| facts.parameter_point);
        let starts = self.records.iter().filter(|record| record.start).map(|record| record.at);
        said.into_iter().chain(starts.filter(move |_| said.is_none()))
    }

    /// The name of a part of the diagnosis in suites, without `diag.`.
    pub fn diagnosis_name(&self, name: DiagnosisName) -> &str {
        match name {
            DiagnosisName::Field(index) => {
                let fields = self.profibus().map_or(&[][..], |slave| &slave.diagnosis.fields);
                fields.get(index).map_or("?", |field| &field.name)
            }
            name => DiagnosisName::words().find(|(_, of)| *of == name).map(|(word, _)| word).unwrap_or_default(),
        }
    }
}

/// Access to the parameters of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct ParameterAccess {
    /// Index of the record for requests and responses.
    pub index: u16,
    /// DO-ID of requests.
    pub do_id: u8,
    /// Number of the parameter that saves the others.
    pub save: u16,
}

/// Base mode parameter access of PROFIdrive and its parameter "transfer to non-volatile memory".
impl Default for ParameterAccess {
    fn default() -> ParameterAccess {
        ParameterAccess { index: 0xB02E, do_id: 1, save: 971 }
    }
}

impl ParameterAccess {
    /// Index of the data set for the same requests on PROFIBUS.
    pub const DATA_SET: u16 = 47;
}

#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct WebPage {
    pub name: String,
    pub path: String,
    /// Fields of its form: name in the suite, name in the page.
    pub fields: Vec<(String, String)>,
    /// Values on the page.
    pub shows: Vec<PageValue>,
    /// Source of path, fields and values.
    pub origin: Origin,
}

/// A value on a web page.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct PageValue {
    /// Its name, unique among all pages.
    pub name: String,
    /// The text before the value.
    pub label: String,
    /// Its format.
    pub form: PageForm,
    /// Whether it is a position in steps.
    pub steps: bool,
    /// Words for its numbers.
    #[serde(with = "expression::pool::maybe_table")]
    pub table: Option<Arc<WordTable>>,
}

/// The format of a value on a web page.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum PageForm {
    /// A number in decimal.
    Decimal,
    /// A number in hexadecimal, with or without `0x`.
    Hexadecimal,
    /// A word.
    Text,
}

/// Actions with lasting effects, in addition to setting names and addresses and resets by DCP.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct LastingChanges {
    /// Changes the value of the current position; the reference of the machine is lost.
    pub position_reference: Vec<Changed>,
    /// Writes non-volatile memory; writes of `permanent` parameters do so too.
    pub nvm_write: Vec<Changed>,
    /// Restores the factory settings.
    pub factory_reset: Vec<Changed>,
    /// Starts the wait for a firmware update.
    pub firmware: Vec<Changed>,
}

/// An action: something that is set or written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Changed {
    /// Setting any of these bits of an output signal to 1.
    Signal {
        /// Index into `signals`.
        signal: usize,
        low: u32,
        width: u32,
    },
    /// A parameter (index into `parameters`).
    Parameter(usize),
    /// A record (index into `records`).
    Record(usize),
    /// The form of a web page (index into `pages`).
    Page(usize),
}

/// The sender of a signal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize)]
pub enum SignalSender {
    /// The controller: an output.
    Controller,
    /// The device: an input.
    Device,
}

/// A value in the cyclic data.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct DeviceSignal {
    /// Its name in the manual.
    pub name: String,
    pub from: SignalSender,
    /// Width in bits: 8, 16, 32 or 64; of a text any number of whole bytes.
    pub width: u32,
    /// Whether it is a two's complement.
    pub signed: bool,
    pub form: SignalForm,
    /// Whether the least significant byte comes first.
    pub little_endian: bool,
    /// Source of the value.
    pub origin: Origin,
    /// Expression for the size of the circle, if the signal is a position; compiled for each variant by the loader.
    pub position_in: Option<String>,
    /// The bit that is set while the device shows a code in place of the position, as `SIGNAL.FIELD`.
    pub code_when: Option<String>,
    /// Left shift of the value in bits, for each variant.
    pub shift: Vec<u32>,
    /// Bits and bit groups.
    pub fields: Vec<SignalField>,
}

/// Bits of a signal, of a parameter element or of a record.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct SignalField {
    pub name: String,
    /// Lowest bit, 0 is the least significant bit of the whole.
    pub low: u32,
    pub width: u32,
    /// Whether it is a two's complement.
    pub signed: bool,
    /// Words for its numbers.
    pub words: Vec<(String, i128)>,
    /// The same words as the type of the name.
    #[serde(with = "expression::pool::maybe_table")]
    pub table: Option<Arc<WordTable>>,
    /// For a sign of life: first and last number of the count.
    pub counts: Option<(u32, u32)>,
}

impl SignalField {
    /// The bits of the whole that belong to it.
    pub fn mask(&self) -> u64 {
        mask(self.low, self.width)
    }
}

/// Whether a name, or its last part, says that the manual reserves what it names.
pub fn is_reserved(name: &str) -> bool {
    let last = name.rsplit('.').next().unwrap_or(name);
    ["reserved", "not_used", "unused"].iter().any(|begin| last.starts_with(begin))
}

#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct DeviceSubmodule {
    pub name: String,
    pub slot: u16,
    pub subslot: u16,
    pub api: u32,
    pub ident: u32,
    /// For each variant the ident number of its module, if it differs from the entry of `modules`; always set in slot 0, which has
    /// no such entry.
    pub module_idents: Option<Vec<u32>>,
    /// Source of the ident numbers.
    pub ident_origin: Origin,
    /// Length of the output data in bytes.
    pub output_octets: u16,
    /// Length of the input data in bytes.
    pub input_octets: u16,
    /// Output signals in order (indices into `signals`).
    pub outputs: Vec<usize>,
    /// Input signals in order (indices into `signals`).
    pub inputs: Vec<usize>,
}

impl DeviceSubmodule {
    /// Ident number of its module in this variant, if the entry of `modules` does not have it.
    pub fn module_ident(&self, variant: usize) -> Option<u32> {
        self.module_idents.as_ref()?.get(variant).copied()
    }
}

/// A module; a connection uses one module.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct DeviceModule {
    pub name: String,
    /// How a controller requests it.
    pub bus: ModuleBus,
    /// Source of the ident number or configuration.
    pub ident_origin: Origin,
    /// Its submodules (indices into `submodules`), without those of the device access point.
    pub submodules: Vec<usize>,
    /// Why the device does not have it, from its GSDML.
    pub absent: Option<String>,
}

#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct DeviceRecord {
    pub name: String,
    pub index: u16,
    /// Its submodule (index into `submodules`).
    pub at: usize,
    /// Length in bytes.
    pub octets: usize,
    /// Whether it is part of the start-up.
    pub start: bool,
    /// The modules (indices into `modules`) with which it is part of the start-up; `None`: all modules.
    pub with: Option<Vec<usize>>,
    /// Its fields in the order of the file.
    pub fields: Vec<RecordField>,
    /// The bytes before fields are written into them, from a description; empty: all 0.
    pub template: Vec<u8>,
    /// Source of the layout.
    pub origin: Origin,
}

impl DeviceRecord {
    /// The bytes before any field is written into them.
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = self.template.clone();
        bytes.resize(self.octets, 0);
        bytes
    }

    /// Whether the start-up of this module (index into `modules`) sends it.
    pub fn starts(&self, module: usize) -> bool {
        self.start && self.with.as_ref().is_none_or(|with| with.contains(&module))
    }
}

/// A field of a record.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct RecordField {
    pub name: String,
    /// Offset of the first byte.
    pub octet: usize,
    /// Length in bytes.
    pub octets: usize,
    /// For bits in one byte: lowest bit and number of bits.
    pub bits: Option<(u32, u32)>,
    /// Words for its numbers.
    pub words: Vec<(String, i128)>,
    /// The same words as the type of the name.
    #[serde(with = "expression::pool::maybe_table")]
    pub table: Option<Arc<WordTable>>,
    /// Default value for each variant; text fields have none.
    pub default: Vec<i128>,
    /// Lowest and highest value that the manual allows.
    pub range: (Option<i128>, Option<i128>),
    /// Whether it is a text.
    pub text: bool,
    /// Other names that manual and descriptions have for it.
    pub called: Vec<String>,
    /// Source of the layout.
    pub origin: Origin,
    /// Why the record does not have it, from a GSDML; then it is not written.
    pub absent: Option<String>,
    /// Lowest and highest value that an engineering tool lets users set, from a GSDML.
    pub settable: Option<(i128, i128)>,
}

/// A parameter of the base mode parameter access.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct DeviceParameter {
    pub number: u16,
    /// The type of its elements.
    pub kind: ParameterType,
    /// Whether it can be written.
    pub writable: bool,
    /// Default value for each variant, if the manual has one.
    pub default: Option<Vec<i128>>,
    /// Whether a write is stored in non-volatile memory.
    pub permanent: bool,
    /// Whether a device may lack it: then it refuses it as unknown, and does not list it in P980.
    pub optional: bool,
    /// Source of the value.
    pub origin: Origin,
    /// Names and subindices of its elements; empty if it is not an array.
    pub elements: Vec<(String, u16)>,
    /// Names of bits of an element (by name) or, with an empty name, of the whole parameter.
    pub bits: Vec<(String, Vec<SignalField>)>,
}

/// Names that a stand can serve for a device.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct StandNames {
    /// Faults and their descriptions.
    pub faults: Vec<(String, String)>,
    /// Buttons and their locations.
    pub buttons: Vec<(String, String)>,
    pub switches: Vec<CodingSwitch>,
    /// Supply voltage at the start of a trial, in volts.
    pub voltage: Option<f64>,
    /// Temperature at the start of a trial, in degrees Celsius.
    pub temperature: Option<f64>,
    /// The lowest and the highest voltage that the manual permits.
    pub permitted_voltage: [Option<f64>; 2],
    /// The lowest and the highest temperature that the manual permits.
    pub permitted_temperature: [Option<f64>; 2],
    /// LEDs and the words for their states.
    pub leds: Vec<(String, Vec<String>)>,
    pub counters: Vec<(String, String)>,
}

#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct CodingSwitch {
    pub name: String,
    /// Its lowest position.
    pub lowest: u32,
    /// Its highest position.
    pub highest: u32,
    /// Position at the start of a trial.
    pub home: u32,
}

/// What a name refers to.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub enum NameKind {
    /// A signal, or a bit or field of it.
    Signal {
        /// Index into `device.signals`.
        signal: usize,
        /// Lowest bit.
        low: u32,
        width: u32,
        /// Whether the bits are in two's complement.
        signed: bool,
        /// Index of the field, if it is one.
        field: Option<usize>,
        /// Program for the size of the circle, if it is a position.
        circle: Option<Program>,
        /// The bit that is set while it is a code and no position.
        code_when: Option<NameId>,
        /// Left shift of the value in bits.
        shift: u32,
    },
    /// `io.outputs`: the output data as bytes, of one submodule or of the module.
    OutputOctets(Option<usize>),
    /// `io.inputs`: the input data as bytes, of one submodule or of the module.
    InputOctets(Option<usize>),
    /// `io.input_length`: length of the input data of the module in bytes.
    InputLength,
    /// `io.input_data_status`: DataStatus of the last frame of the device.
    InputDataStatus,
    /// `io.input_counter`: the cycle counter of the last frame of the device.
    InputCounter,
    /// `io.output_data_status`: DataStatus of the frames of the controller.
    OutputDataStatus,
    /// `io.cyclic`: `running` or `paused`.
    Cyclic,
    /// `io.alarm_acknowledge`: `given`, `received`, `held`.
    AlarmAcknowledge,
    /// `io.output_status`: IOPS of the controller, of one submodule or of all.
    OutputStatus(Option<usize>),
    /// `io.input_status`: IOPS of the device.
    InputStatus(Option<usize>),
    /// `io.consumer_status`: IOCS of the device.
    ConsumerStatus(Option<usize>),
    /// `io.global_control`: the clock of isochronous mode, `running` or `stopped`.
    GlobalControl,
    /// `io.clock_offset`: delay of the clock of isochronous mode, a duration.
    ClockOffset,
    /// `io.diagnosis_pending`: whether the answer with the inputs had high priority.
    DiagnosisPending,
    /// The last Slave_Diag of the device, or a part of it.
    Diagnosis(DiagnosisName),
    /// `cfg.bytes`: the identifiers returned by Get_Cfg.
    Configuration,
    /// `connection`: `data` or `none`.
    Connection,
    /// A parameter, an element of it, or bits of an element.
    Parameter {
        /// Index into `device.parameters`; `None` for a number that the device does not have.
        parameter: Option<usize>,
        number: u16,
        subindex: u16,
        /// Lowest bit and number of bits, if it refers to bits.
        bits: Option<(u32, u32)>,
    },
    /// A field of a record (indices into `device.records` and its fields).
    Record {
        record: usize,
        /// The field; `None` for the record as bytes.
        field: Option<usize>,
    },
    /// A value on a web page (indices into `device.pages` and its values).
    Page { page: usize, value: usize },
    /// A value of the station, read by DCP on PROFINET.
    Station(StationName),
    /// A value that the stand sets.
    Stand(StandName),
    /// `led.x` (index into `device.stand.leds`).
    Led(usize),
    /// `counter.x` (index into `device.stand.counters`).
    Counter(usize),
    /// An event or a part of one.
    Event(EventName),
    /// `answer` and its parts.
    Answer(AnswerPart),
    /// An active start parameter (indices into `device.records` and its fields).
    StartParameter { record: usize, field: usize },
    /// A value of `derived`, index into [`super::model::SuiteVariant::derived`].
    Derived(usize),
    /// A saved value, index into [`super::model::TrialSteps::saved`].
    Saved(usize),
    /// `cycle`, a duration.
    Cycle,
    /// `elapsed`: the time between this frame and the previous one of the same direction.
    Elapsed,
    /// An address of the bench.
    Bench(BenchName),
    /// A value known at load time.
    Constant(Value),
}

/// An address that depends on the bench.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize)]
pub enum BenchName {
    /// `bench.address`: IP address of the controller; on PROFIBUS station address of the master.
    Address,
    /// `bench.ip`: IP address of the device on this bench.
    Ip,
    /// `bench.mask`: subnet mask.
    Mask,
    /// `bench.free_ip`: unused IP address of the same subnet.
    FreeIp,
    /// `bench.station`: station address of the device on this bench (PROFIBUS).
    Station,
    /// `bench.free_station`: unused station address (PROFIBUS).
    FreeStation,
    /// `bench.second`: station address of the second master (PROFIBUS).
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
    /// `station.address`: PROFIBUS address at which a slave with the expected ident number answers.
    Address,
}

/// A value that a stand sets (indices into [`StandNames`]).
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
    /// `shaft.acceleration`, in rpm per second, for later changes of the speed.
    ShaftAcceleration,
    /// `shaft.counts`: the raw position.
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

/// An event or a part of one; it has a value at the instant of the event only.
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
    /// `alarm.type`: the AlarmType.
    AlarmType,
    /// `alarm.priority`: `low`, `high`.
    AlarmPriority,
    /// `alarm.payload`: the bytes of its first item after the UserStructureIdentifier.
    AlarmPayload,
    /// `alarm.slot`.
    AlarmSlot,
    /// `alarm.subslot`.
    AlarmSubslot,
    /// `alarm.channel`.
    AlarmChannel,
    /// `alarm.structure`: the UserStructureIdentifier.
    AlarmStructure,
    /// `alarm.sequence`: the SequenceNumber of its AlarmSpecifier.
    AlarmSequence,
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
    /// `lldp.ttl`.
    LldpTtl,
    /// `lldp.bytes`.
    LldpBytes,
    /// `hello`.
    Hello,
    /// `hello.name`.
    HelloName,
    /// `hello.ip`.
    HelloIp,
    /// `ready`.
    Ready,
    /// `ready.sequence`: the SequenceNumber of the alarm.
    ReadySequence,
}

impl EventName {
    /// Whether it is an LLDP event, which no switch forwards.
    pub fn is_lldp(self) -> bool {
        use EventName::{Lldp, LldpBytes, LldpChassis, LldpMac, LldpName, LldpPort, LldpSource, LldpTtl};
        matches!(self, Lldp | LldpName | LldpChassis | LldpPort | LldpMac | LldpSource | LldpTtl | LldpBytes)
    }

    /// Whether it is an alarm or a part of one.
    pub fn is_alarm(self) -> bool {
        let is_other =
            matches!(self, EventName::Abort | EventName::AbortCode | EventName::Ready | EventName::ReadySequence);
        !is_other && !self.is_lldp() && !self.is_hello()
    }

    /// Whether it is a Hello of DCP.
    pub fn is_hello(self) -> bool {
        matches!(self, EventName::Hello | EventName::HelloName | EventName::HelloIp)
    }
}
