//! The state of one connection: last cyclic data, start parameters from the wire, the current event.
//!
//! A value is unknown before it is first received, after the connection ended, and while its sender marks its data as bad. While
//! a Global_Control (PROFIBUS) holds or clears data, the outputs are unknown: what is sent is not what is in force, or not what the
//! inputs answer.

use crate::observe::{CyclicStatus, DiagnosisFrame, FrameDirection, ObservedAr, SlaveStartData};
use station::{Duration, Time};
use std::cmp::Reverse;
use std::ops::Range;
use suite::device::{DeviceDescription, DeviceModule, DeviceRecord, Origin, RecordField, UserPrmLayout};
use wire::ethernet::Mac;
use wire::profibus::global_control::GlobalCommand;
use wire::profibus::prm::{Dpv1Status3, PrmBlock, PrmBlockType, SetPrm};
use wire::profinet::rt::{ApduStatus, IoxS};

/// The data area of one direction.
#[derive(Clone, Debug, Default)]
pub struct Area {
    octets: Vec<u8>,
    seen: bool,
    good: bool,
    /// Whether every IOPS in it is good.
    providers: bool,
    place: Placement,
    gap: Option<Duration>,
}

/// Time and position of a data area on the wire.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Placement {
    /// Time of the frame.
    pub time: Time,
    /// Number of the frame.
    pub frame: u64,
    /// Offset of the data area in the frame, in bytes.
    pub at: usize,
}

/// Offsets of the parts of a submodule in the data areas.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct SubmoduleOffsets {
    input: Option<Range<usize>>,
    output: Option<Range<usize>>,
    input_status: Option<usize>,
    output_status: Option<usize>,
    output_consumer: Option<usize>,
}

/// The values of `alarm.*`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ObservedAlarm {
    /// `alarm.change`: the specifier, if the alarm carries a channel diagnosis.
    pub change: Option<u8>,
    /// `alarm.error`: the channel error type.
    pub error: Option<u16>,
    /// `alarm.severity`: 0 diagnosis, 1 maintenance required, 2 maintenance demanded.
    pub severity: Option<u8>,
    /// `alarm.type`.
    pub alarm_type: u16,
    /// `alarm.priority`: whether it is high.
    pub is_high: bool,
    /// `alarm.payload`.
    pub payload: Option<Vec<u8>>,
    /// `alarm.slot`.
    pub slot: u16,
    /// `alarm.subslot`.
    pub subslot: u16,
    /// `alarm.channel`.
    pub channel: Option<u16>,
    /// `alarm.structure`: the UserStructureIdentifier.
    pub structure: Option<u16>,
    /// `alarm.sequence`.
    pub sequence: u16,
}

/// The values of `lldp.*`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ObservedLldp {
    /// `lldp.name`.
    pub name: Option<String>,
    /// `lldp.chassis`.
    pub chassis: Option<Vec<u8>>,
    /// `lldp.port`.
    pub port: Option<String>,
    /// `lldp.mac`.
    pub mac: Option<Mac>,
    /// `lldp.source`.
    pub source: Option<Mac>,
    /// `lldp.ttl`, in seconds.
    pub ttl: Option<u16>,
    /// `lldp.bytes`: all TLVs.
    pub octets: Vec<u8>,
}

/// The values of `hello.*`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ObservedHello {
    /// `hello.name`.
    pub name: Option<String>,
    /// `hello.ip`.
    pub ip: Option<[u8; 4]>,
}

/// The event at this instant.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum CurrentEvent {
    /// No event.
    #[default]
    Nothing,
    /// An alarm was received.
    Alarm(ObservedAlarm),
    /// The connection was aborted by an ERR-RTA; its PNIO status as one number, ErrorCode first.
    Abort(u32),
    /// The device sent an LLDP frame.
    Lldp(ObservedLldp),
    /// The device said Hello by DCP.
    Hello(ObservedHello),
    /// The device said that a plugged or released submodule is ready; the SequenceNumber of that alarm.
    Ready(u16),
    /// The device sent its diagnosis, which is stored in the image.
    Diagnosis,
}

/// The last diagnosis of a slave and its position on the wire; unlike cyclic data it outlives the connection.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ObservedDiagnosis {
    /// The data of Slave_Diag.
    pub octets: Vec<u8>,
    pub place: Placement,
}

/// The state of one connection.
#[derive(Clone, Debug)]
pub struct ConnectionImage {
    signals: Vec<Option<(FrameDirection, Range<usize>)>>,
    /// Whether the least significant byte of each signal comes first.
    little_endian: Vec<bool>,
    submodules: Vec<SubmoduleOffsets>,
    inputs: Area,
    outputs: Area,
    records: Vec<Option<Vec<u8>>>,
    stands: bool,
    module: Option<usize>,
    cycle: Option<Duration>,
    /// Increases with every update.
    version: u64,
    /// The version at which the layout of the connection was set.
    layout: u64,
    /// The version of the last change of start parameters.
    parameters: u64,
    /// Direction and change of `elapsed` of the last update, if it only changed bits of the cyclic data.
    changed: Option<(FrameDirection, bool)>,
    changed_bits: Vec<u64>,
    diagnosis: Option<ObservedDiagnosis>,
    pending: Option<bool>,
    /// The status of the last frame with inputs, on PROFINET.
    input_apdu: Option<ApduStatus>,
    /// What the last Global_Control commands hold: clear, freeze and sync.
    held: [bool; 3],
    /// What happened at this instant.
    pub happening: CurrentEvent,
}

/// The change by a cyclic frame that only changed bits of the cyclic data.
#[derive(Clone, Copy, Debug)]
pub struct ImageChange<'a> {
    pub direction: FrameDirection,
    /// The changed bits of the data area, eight bytes per word, the first byte lowest.
    pub bits: &'a [u64],
    /// Whether the time since the previous frame changed.
    pub elapsed: bool,
}

/// A status byte of a submodule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StatusByte {
    /// IOPS of the outputs, sent by the controller.
    Output,
    /// IOPS of the inputs, sent by the device.
    Input,
    /// IOCS of the outputs, sent by the device.
    Consumer,
}

impl StatusByte {
    fn of(self) -> fn(&SubmoduleOffsets) -> Option<usize> {
        match self {
            StatusByte::Output => |spots| spots.output_status,
            StatusByte::Input => |spots| spots.input_status,
            StatusByte::Consumer => |spots| spots.output_consumer,
        }
    }
}

impl ConnectionImage {
    /// An image without a connection: every value is unknown.
    pub fn new(device: &DeviceDescription) -> ConnectionImage {
        ConnectionImage {
            signals: vec![None; device.signals.len()],
            little_endian: device.signals.iter().map(|signal| signal.little_endian).collect(),
            submodules: vec![SubmoduleOffsets::default(); device.submodules.len()],
            inputs: Area::default(),
            outputs: Area::default(),
            records: vec![None; device.records.len()],
            stands: false,
            module: None,
            cycle: None,
            version: 0,
            layout: 0,
            parameters: 0,
            changed: None,
            changed_bits: Vec::new(),
            diagnosis: None,
            pending: None,
            input_apdu: None,
            held: [false; 3],
            happening: CurrentEvent::Nothing,
        }
    }

    /// Sets the layout of a connection that the device has just accepted.
    pub fn open(&mut self, device: &DeviceDescription, ar: &ObservedAr) {
        let version = self.version + 1;
        let diagnosis = ar.slave.as_deref().and_then(last_diagnosis);
        *self = ConnectionImage {
            version,
            layout: version,
            parameters: version,
            diagnosis,
            ..ConnectionImage::new(device)
        };
        self.stands = true;
        self.cycle = Some(ar.outputs.cycle).filter(|cycle| !cycle.is_zero());
        if let Some(start_data) = &ar.slave {
            return self.open_slave(device, ar, start_data);
        }
        for (index, submodule) in device.submodules.iter().enumerate() {
            let found = ar.submodules.iter().find(|placed| {
                placed.slot == submodule.slot
                    && placed.subslot == submodule.subslot
                    && placed.submodule_ident == submodule.ident
            });
            let Some(placed) = found else { continue };
            self.submodules[index] = SubmoduleOffsets {
                input: placed.input.clone(),
                output: placed.output.clone(),
                input_status: placed.input_status,
                output_status: placed.output_status,
                output_consumer: placed.output_consumer,
            };
            self.place(device, &submodule.inputs, FrameDirection::ToController, placed.input.as_ref());
            self.place(device, &submodule.outputs, FrameDirection::ToDevice, placed.output.as_ref());
        }
        self.module = self.module_of(device, ar);
    }

    /// Sets the layout for a slave: that of the module with this configuration; of several, the one whose required parameters
    /// were sent.
    fn open_slave(&mut self, device: &DeviceDescription, ar: &ObservedAr, start_data: &SlaveStartData) {
        let sent = start_data.parameters.as_ref().and_then(|octets| SetPrm::parse(octets).ok());
        let layout = device.profibus().map(|slave| &slave.set_prm);
        let user = sent.as_ref().zip(layout).map(|(prm, layout)| user_octets(prm, layout));
        let record = device.records.get(UserPrmLayout::RECORD);
        if let (Some(known), Some(record)) = (self.records.get_mut(UserPrmLayout::RECORD), record) {
            *known = user.filter(|user| has_known_layout(record, user));
        }
        let configuration = start_data.configuration.as_deref();
        let fits = |module: &DeviceModule| {
            let fields = device.records.get(UserPrmLayout::RECORD).map_or(&[][..], |record| &record.fields);
            let fixed = module.fixes().iter().filter(|(field, value)| {
                let seen = fields.get(*field).and_then(|field| self.start_parameter(UserPrmLayout::RECORD, field));
                seen == Some(*value)
            });
            (fixed.count() == module.fixes().len(), Some(module.cfg()) == configuration)
        };
        let same = device.modules.iter().enumerate().filter(|(_, module)| fits(module).1);
        let module = same.max_by_key(|(index, module)| (fits(module).0, Reverse(*index))).map(|(index, _)| index);
        self.module = module;
        let placed = ar.submodules.first();
        let (Some(module), Some(placed)) = (module.and_then(|module| device.modules.get(module)), placed) else {
            return;
        };
        for &index in &module.submodules {
            let Some(submodule) = device.submodules.get(index) else { continue };
            self.submodules[index] = SubmoduleOffsets {
                input: placed.input.clone(),
                output: placed.output.clone(),
                ..SubmoduleOffsets::default()
            };
            self.place(device, &submodule.inputs, FrameDirection::ToController, placed.input.as_ref());
            self.place(device, &submodule.outputs, FrameDirection::ToDevice, placed.output.as_ref());
        }
    }

    /// The module whose submodules are all present. Modules may share submodules: of several, the one with most submodules, then
    /// one with the ident number that the controller expects, then the first.
    fn module_of(&self, device: &DeviceDescription, ar: &ObservedAr) -> Option<usize> {
        let is_there =
            |index: &usize| self.submodules.get(*index).is_some_and(|spots| *spots != SubmoduleOffsets::default());
        let expected = |ident: u32| ar.submodules.iter().any(|placed| placed.slot != 0 && placed.module_ident == ident);
        let fits = |module: &DeviceModule| {
            let all = !module.submodules.is_empty() && module.submodules.iter().all(is_there);
            all.then(|| (module.submodules.len(), module.ident().is_some_and(expected)))
        };
        let fitting = device.modules.iter().enumerate().filter_map(|(index, module)| Some((fits(module)?, index)));
        fitting.max_by_key(|&(fits, index)| (fits, Reverse(index))).map(|(_, index)| index)
    }

    fn place(
        &mut self,
        device: &DeviceDescription,
        signals: &[usize],
        direction: FrameDirection,
        area: Option<&Range<usize>>,
    ) {
        let Some(area) = area else { return };
        let mut at = area.start;
        for &signal in signals {
            let octets = device.signals[signal].width as usize / 8;
            if at + octets <= area.end {
                self.signals[signal] = Some((direction, at..at + octets));
            }
            at += octets;
        }
    }

    /// Ends the connection: all its values become unknown.
    pub fn close(&mut self) {
        self.took_over(None);
        self.parameters = self.version;
        self.stands = false;
        self.module = None;
        self.pending = None;
        self.inputs = Area::default();
        self.outputs = Area::default();
        self.records.iter_mut().for_each(|record| *record = None);
    }

    /// Stores a start record; if the device refused it, the active values are unknown.
    pub fn record(
        &mut self,
        device: &DeviceDescription,
        slot: u16,
        subslot: u16,
        index: u16,
        data: &[u8],
        accepted: bool,
    ) {
        if let Some(found) = start_record(device, slot, subslot, index) {
            let is_known = device.records.get(found).is_some_and(|of| has_known_layout(of, data));
            self.set_record(found, (accepted && is_known).then(|| data.to_vec()));
        }
    }

    /// Notes that a start record is being written: until the answer, the active values are unknown.
    pub fn record_requested(&mut self, device: &DeviceDescription, slot: u16, subslot: u16, index: u16) {
        if let Some(found) = start_record(device, slot, subslot, index) {
            self.set_record(found, None);
        }
    }

    fn set_record(&mut self, found: usize, data: Option<Vec<u8>>) {
        if let Some(known) = self.records.get_mut(found) {
            *known = data;
            self.took_over(None);
            self.parameters = self.version;
        }
    }

    fn took_over(&mut self, changed: Option<(FrameDirection, bool)>) {
        self.version += 1;
        self.changed = changed;
    }

    /// A number that increases by 1 with every update.
    pub fn version(&self) -> u64 {
        self.version
    }

    /// A number that identifies the layout; it differs for each connection.
    pub fn layout(&self) -> u64 {
        self.layout
    }

    /// A number that changes with every change of start parameters.
    pub fn parameters(&self) -> u64 {
        self.parameters
    }

    /// The change by the last update, if it only changed bits of the cyclic data.
    pub fn change(&self) -> Option<ImageChange<'_>> {
        let (direction, elapsed) = self.changed?;
        Some(ImageChange { direction, bits: &self.changed_bits, elapsed })
    }

    /// Stores a cyclic frame; returns whether its data are good: valid, running, every IOPS good.
    pub fn cyclic(&mut self, direction: FrameDirection, data: &[u8], status: CyclicStatus, place: Placement) -> bool {
        let (area, of): (_, fn(&SubmoduleOffsets) -> Option<usize>) = match direction {
            FrameDirection::ToController => (&mut self.inputs, |spots| spots.input_status),
            FrameDirection::ToDevice => (&mut self.outputs, |spots| spots.output_status),
        };
        let is_same = area.seen && area.octets == data;
        let good_status = |at: usize| data.get(at).is_some_and(|&octet| IoxS(octet).is_good());
        if !is_same {
            area.providers = self.submodules.iter().filter_map(of).all(good_status);
        }
        let is_held = direction == FrameDirection::ToDevice && self.held.contains(&true);
        let good = is_good(status) && area.providers && !is_held;
        let is_alike = area.seen && area.good == good && area.octets.len() == data.len();
        if is_same {
            self.changed_bits.clear();
        } else {
            differing_bits(&area.octets, data, &mut self.changed_bits);
            area.octets.clear();
            area.octets.extend_from_slice(data);
        }
        let gap = area.seen.then(|| place.time.since(area.place.time));
        let elapsed = area.gap != gap;
        area.gap = gap;
        area.seen = true;
        area.good = good;
        area.place = place;
        let mut changed = is_alike.then_some((direction, elapsed));
        if let (CyclicStatus::Fdl { diagnosis_pending }, FrameDirection::ToController) = (status, direction)
            && self.pending.replace(diagnosis_pending) != Some(diagnosis_pending)
        {
            changed = None;
        }
        if let (CyclicStatus::Apdu(status), FrameDirection::ToController) = (status, direction) {
            self.input_apdu = Some(status);
        }
        self.took_over(changed);
        good
    }

    /// Stores what a Global_Control holds from now on, whatever groups it is for, since the slave may belong to them.
    pub fn controlled(&mut self, command: GlobalCommand) {
        let [_, freeze, sync] = self.held;
        let held = [
            command.has(GlobalCommand::CLEAR_DATA),
            (freeze || command.has(GlobalCommand::FREEZE)) && !command.has(GlobalCommand::UNFREEZE),
            (sync || command.has(GlobalCommand::SYNC)) && !command.has(GlobalCommand::UNSYNC),
        ];
        if held != self.held {
            self.held = held;
            self.took_over(None);
        }
    }

    /// Stores a diagnosis.
    pub fn diagnosed(&mut self, octets: &[u8], place: Placement) {
        self.took_over(None);
        let seen = self.diagnosis.get_or_insert_with(|| ObservedDiagnosis { octets: Vec::new(), place });
        seen.octets.clear();
        seen.octets.extend_from_slice(octets);
        seen.place = place;
    }

    /// Frames are missing: the cyclic data become unknown.
    pub fn interrupt(&mut self) {
        self.took_over(None);
        for area in [&mut self.inputs, &mut self.outputs] {
            area.seen = false;
            area.gap = None;
        }
    }

    /// Numbers of the last frame to the controller and of the last frame to the device.
    pub fn last_frames(&self) -> [Option<u64>; 2] {
        [&self.inputs, &self.outputs].map(|area| area.seen.then_some(area.place.frame))
    }

    /// The last diagnosis of the device.
    pub fn diagnosis(&self) -> Option<&ObservedDiagnosis> {
        self.diagnosis.as_ref()
    }

    /// Whether the last answer of Data_Exchange had high priority.
    pub fn diagnosis_pending(&self) -> Option<bool> {
        self.pending.filter(|_| self.stands)
    }

    fn area(&self, direction: FrameDirection) -> &Area {
        match direction {
            FrameDirection::ToController => &self.inputs,
            FrameDirection::ToDevice => &self.outputs,
        }
    }

    /// Whether the connection is established.
    pub fn stands(&self) -> bool {
        self.stands
    }

    /// Whether the last sample was good.
    pub fn has_good_inputs(&self) -> bool {
        self.inputs.seen && self.inputs.good
    }

    /// The current module (index into `device.modules`), if the device description has it.
    pub fn module(&self) -> Option<usize> {
        self.module
    }

    /// Sets the cycle time if the frames do not contain it.
    pub fn set_cycle(&mut self, cycle: Duration) {
        self.took_over(None);
        self.cycle = Some(cycle);
    }

    /// The cycle time: the agreed one, else the measured time between two frames to the device.
    pub fn cycle(&self) -> Option<Duration> {
        self.cycle.or(self.outputs.gap)
    }

    /// The raw value of a signal, if it is known.
    pub fn signal(&self, signal: usize) -> Option<u64> {
        let (direction, octets) = self.signals.get(signal)?.as_ref()?;
        let area = self.area(*direction);
        if !(self.stands && area.seen && area.good) {
            return None;
        }
        let octets = area.octets.get(octets.clone())?;
        Some(if self.is_little_endian(signal) { little_endian(octets) } else { big_endian(octets) })
    }

    /// Whether the least significant byte of a signal comes first.
    pub fn is_little_endian(&self, signal: usize) -> bool {
        self.little_endian.get(signal).is_some_and(|is_so| *is_so)
    }

    /// The bytes of a signal, if they are known.
    pub fn signal_octets(&self, signal: usize) -> Option<&[u8]> {
        let (direction, octets) = self.signals.get(signal)?.as_ref()?;
        let area = self.area(*direction);
        area.octets.get(octets.clone()).filter(|_| self.stands && area.seen && area.good)
    }

    /// The direction of a signal and its range in the data area.
    pub fn octets_of_signal(&self, signal: usize) -> Option<(FrameDirection, Range<usize>)> {
        self.signals.get(signal)?.clone()
    }

    /// Offsets of the data bytes of one submodule, or of all, in the data area of a direction.
    pub fn octets_of(&self, direction: FrameDirection, submodule: Option<usize>) -> impl Iterator<Item = usize> {
        let range = move |spots: &SubmoduleOffsets| match direction {
            FrameDirection::ToController => spots.input.clone(),
            FrameDirection::ToDevice => spots.output.clone(),
        };
        self.meant(submodule).filter_map(range).flatten()
    }

    /// Offsets of the status bytes of one submodule, or of all, in the data area of their direction.
    pub fn status_of(&self, status: StatusByte, submodule: Option<usize>) -> impl Iterator<Item = usize> {
        self.meant(submodule).filter_map(status.of())
    }

    fn meant(&self, submodule: Option<usize>) -> impl Iterator<Item = &SubmoduleOffsets> {
        let all = self.submodules.iter().enumerate();
        all.filter(move |(index, _)| submodule.is_none_or(|meant| meant == *index)).map(|(_, spots)| spots)
    }

    /// The direction of a signal on this connection.
    pub fn direction(&self, signal: usize) -> Option<FrameDirection> {
        self.signals.get(signal)?.as_ref().map(|(direction, _)| *direction)
    }

    /// The position of a signal in the last frame: frame number and offset of its first byte in the frame.
    pub fn place_of(&self, signal: usize) -> Option<(u64, usize)> {
        let (direction, octets) = self.signals.get(signal)?.as_ref()?;
        let area = self.area(*direction);
        area.seen.then_some((area.place.frame, area.place.at + octets.start))
    }

    /// The time between the last two frames of a direction.
    pub fn elapsed(&self, direction: FrameDirection) -> Option<Duration> {
        self.area(direction).gap.filter(|_| self.stands)
    }

    /// The data bytes of one direction, of one submodule or of all in order.
    pub fn octets(&self, direction: FrameDirection, submodule: Option<usize>) -> Option<Vec<u8>> {
        let area = self.area(direction);
        if !(self.stands && area.seen && area.good) {
            return None;
        }
        if submodule
            .is_some_and(|submodule| self.submodules.get(submodule).is_none_or(|of| *of == SubmoduleOffsets::default()))
        {
            return None;
        }
        let mut octets = Vec::new();
        let meant = |index: usize| submodule.is_none_or(|submodule| submodule == index);
        for (_, spots) in self.submodules.iter().enumerate().filter(|(index, _)| meant(*index)) {
            let range = match direction {
                FrameDirection::ToController => &spots.input,
                FrameDirection::ToDevice => &spots.output,
            };
            if let Some(range) = range {
                octets.extend_from_slice(area.octets.get(range.clone())?);
            }
        }
        Some(octets)
    }

    /// Length of the input data as agreed by the Connect, in bytes.
    pub fn input_length(&self) -> Option<usize> {
        let length = |spots: &SubmoduleOffsets| spots.input.as_ref().map_or(0, Range::len);
        self.stands.then(|| self.submodules.iter().map(length).sum())
    }

    /// The status of the last frame with inputs, on PROFINET.
    pub fn input_apdu(&self) -> Option<ApduStatus> {
        self.input_apdu.filter(|_| self.stands && self.inputs.seen)
    }

    /// IOPS of the outputs: of one submodule, or whether all are good.
    pub fn output_status(&self, submodule: Option<usize>) -> Option<bool> {
        self.status(&self.outputs, submodule, StatusByte::Output)
    }

    /// IOPS of the inputs: of one submodule, or whether all are good.
    pub fn input_status(&self, submodule: Option<usize>) -> Option<bool> {
        self.status(&self.inputs, submodule, StatusByte::Input)
    }

    /// IOCS of the outputs: of one submodule, or whether all are good.
    pub fn consumer_status(&self, submodule: Option<usize>) -> Option<bool> {
        self.status(&self.inputs, submodule, StatusByte::Consumer)
    }

    fn status(&self, area: &Area, submodule: Option<usize>, status: StatusByte) -> Option<bool> {
        let of = status.of();
        if !(self.stands && area.seen) {
            return None;
        }
        let good = |at: usize| area.octets.get(at).map(|&octet| IoxS(octet).is_good());
        match submodule {
            Some(submodule) => self.submodules.get(submodule).and_then(of).and_then(good),
            None => self.submodules.iter().filter_map(of).map(good).try_fold(true, |all, one| Some(all && one?)),
        }
    }

    /// The number in a field of a start record, as last accepted by the device.
    pub fn start_parameter(&self, record: usize, field: &RecordField) -> Option<i128> {
        let octets = self.records.get(record)?.as_ref()?;
        field_number(field, octets)
    }
}

/// The start record at this place, as an index into `records`.
fn start_record(device: &DeviceDescription, slot: u16, subslot: u16, index: u16) -> Option<usize> {
    device.records.iter().position(|record| {
        let at = &device.submodules[record.at];
        record.start && record.index == index && (at.slot, at.subslot) == (slot, subslot)
    })
}

/// Whether the places of start parameters are known: where encspec chose them and the device was sent another number of bytes, they are
/// elsewhere.
fn has_known_layout(record: &DeviceRecord, data: &[u8]) -> bool {
    record.origin != Origin::Invented || data.is_empty() || data.len() == record.octets
}

/// The bits that differ between two areas of the same length, eight bytes per word, the first byte lowest.
fn differing_bits(before: &[u8], now: &[u8], bits: &mut Vec<u64>) {
    let word = |octets: &[u8]| octets.iter().rev().fold(0, |word, &octet| (word << 8) | u64::from(octet));
    let whole = |octets: &[u8]| <[u8; 8]>::try_from(octets).map_or_else(|_| word(octets), u64::from_le_bytes);
    bits.clear();
    bits.extend(before.chunks(8).zip(now.chunks(8)).map(|(before, now)| whole(before) ^ whole(now)));
}

/// The user parameter data of Set_Prm: after the DP-V1 bytes, extracted from their block if there is one.
pub fn user_octets(prm: &SetPrm, layout: &UserPrmLayout) -> Vec<u8> {
    let behind = if layout.dpv1.is_some() { prm.user_after_dpv1() } else { &prm.user };
    let blocks = prm.dpv1().filter(|_| layout.dpv1.is_some());
    if !blocks.is_some_and(|dpv1| dpv1.status_3.has(Dpv1Status3::PRM_STRUCTURE)) {
        return behind.to_vec();
    }
    let blocks = PrmBlock::parse_all(behind).unwrap_or_default();
    blocks
        .into_iter()
        .find(|block| block.kind == PrmBlockType::USER_PRM_DATA)
        .map(|block| block.data)
        .unwrap_or_default()
}

/// The last diagnosis before a connection was established.
fn last_diagnosis(slave: &SlaveStartData) -> Option<ObservedDiagnosis> {
    let DiagnosisFrame { octets, frame, time, at } = slave.diagnosis.clone()?;
    Some(ObservedDiagnosis { octets, place: Placement { time, frame, at } })
}

/// Whether the status marks the data as good; always true on PROFIBUS.
fn is_good(status: CyclicStatus) -> bool {
    match status {
        CyclicStatus::Apdu(status) => status.data_status.is_valid() && status.data_status.is_run(),
        CyclicStatus::Fdl { .. } => true,
    }
}

/// The big-endian number in up to 8 bytes.
pub fn big_endian(octets: &[u8]) -> u64 {
    octets.iter().fold(0, |number, &octet| (number << 8) | u64::from(octet))
}

/// The little-endian number in up to 8 bytes.
pub fn little_endian(octets: &[u8]) -> u64 {
    octets.iter().rev().fold(0, |number, &octet| (number << 8) | u64::from(octet))
}

/// The number of a field in the bytes of a record.
pub fn field_number(field: &RecordField, octets: &[u8]) -> Option<i128> {
    let octets = octets.get(field.octet..field.octet + field.octets)?;
    let number = octets.iter().fold(0u128, |number, &octet| (number << 8) | u128::from(octet));
    let number = match field.bits {
        Some((low, width)) => (number >> low) & ((1 << width) - 1),
        None => number,
    };
    i128::try_from(number).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differing_bits_have_the_positions_of_their_bytes() {
        let (before, mut now) = ([0u8; 10], [0u8; 10]);
        (now[0], now[7], now[9]) = (0x01, 0x80, 0x10);
        let mut bits = vec![1, 2, 3];
        differing_bits(&before, &now, &mut bits);
        assert_eq!(bits, [1 | 0x80 << 56, 0x10 << 8]);
        differing_bits(&now, &now, &mut bits);
        assert_eq!(bits, [0, 0]);
    }
}
