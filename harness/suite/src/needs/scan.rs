//! Derives the needs of a trial from its steps.

use super::{Ability, BenchNeed, ClaimedFeature, Consent, LONG};
use crate::device::{Changed, NameKind, Origin, SignalForm, StandName, StationName};
use crate::model::{
    AccessChannel, AcyclicAccess, AcyclicService, Condition, ConnectionStart, DpService, HoldTime, Manual, Matcher,
    PartTest, RequestDeviation, SetValue, Setting, StartDeviation, SuiteVariant, TimeSpan, Trial, TrialStep, Turn,
    TurnAngle, Verb,
};
use crate::scan::observed_names;
use expression::{NameId, Program, Value};
use std::ops::RangeInclusive;
use std::time::Duration;
use wire::profibus::call::CALL_INDEX;
use wire::profidrive::parameter::{ParameterRequest, RequestId};

/// What a wait counts whose time follows from what the device does: it may be any.
const UNKNOWN_WAIT: Duration = Duration::from_secs(3600);

/// Index of the older parameter access of PROFIdrive.
const OLD_PARAMETER_ACCESS: u16 = 0x002F;
/// Length of the header of CALL in bytes.
const CALL_HEADER: usize = 4;
/// Record indices of I&M1 to I&M4, which are stored in the device.
const KEPT_RECORDS: RangeInclusive<u16> = 0xAFF1..=0xAFF4;
/// PDInterfaceFSUDataAdjust, which every device keeps as well.
const FAST_START_UP: u16 = 0x8090;

/// The needs of a trial.
pub(super) fn trial(manual: &Manual, variant: &SuiteVariant, trial: &Trial) -> Vec<BenchNeed> {
    let mut scan = Scan::new(manual, variant);
    if let Some(start) = trial.start() {
        scan.start(start);
    }
    for steps in trial.parts() {
        scan.steps(steps, 1);
    }
    if trial.how().bit_timing {
        scan.add(BenchNeed::BitTiming);
    }
    scan.finish()
}

/// The needs of one step.
pub(super) fn step(manual: &Manual, variant: &SuiteVariant, step: &TrialStep) -> Vec<BenchNeed> {
    let mut scan = Scan::new(manual, variant);
    scan.verb(&step.verb, 1);
    scan.finish()
}

/// The needs found so far and the state of the scan.
struct Scan<'a> {
    manual: &'a Manual,
    variant: &'a SuiteVariant,
    needs: Vec<BenchNeed>,
    /// Module and cycle of the current connection.
    module: Option<usize>,
    cycle: Duration,
    /// Total waiting time, and the part of it that no clock shortens.
    waits: Duration,
    really: Duration,
    /// Whether a connection is established.
    connected: bool,
    /// Number of writes to non-volatile memory.
    writes: u64,
    /// Angles in steps and speeds in rpm of the shaft, where known.
    ways: Vec<Option<f64>>,
    speeds: Vec<Option<f64>>,
    /// Whether a measured value is read.
    measures: bool,
    /// Whether the scan is inside a check that is judged separately; its abilities do not count for the trial.
    apart: bool,
}

impl<'a> Scan<'a> {
    fn new(manual: &'a Manual, variant: &'a SuiteVariant) -> Scan<'a> {
        Scan {
            manual,
            variant,
            needs: Vec::new(),
            module: None,
            cycle: manual.device.timing.cycle,
            waits: Duration::ZERO,
            really: Duration::ZERO,
            connected: false,
            writes: 0,
            ways: Vec::new(),
            speeds: Vec::new(),
            measures: false,
            apart: false,
        }
    }

    fn finish(mut self) -> Vec<BenchNeed> {
        if self.writes > 0 {
            let writes = u32::try_from(self.writes).unwrap_or(u32::MAX);
            self.add(BenchNeed::Consent(Consent::NvmWrite(writes)));
        }
        let moves = !self.ways.is_empty() || !self.speeds.is_empty();
        if moves && !self.measures {
            self.add(BenchNeed::Stand(Ability::Moves));
        } else {
            if !self.ways.is_empty() {
                let shortest = self.ways.iter().flatten().copied().reduce(f64::min);
                self.add(BenchNeed::Stand(Ability::Turn { shortest }));
            }
            if !self.speeds.is_empty() {
                let slowest = self.speeds.iter().flatten().copied().reduce(f64::min);
                self.add(BenchNeed::Stand(Ability::Speed { slowest }));
            }
        }
        if self.waits >= LONG {
            self.add(BenchNeed::Long { waits: self.waits, really: self.really });
        }
        self.needs
    }

    fn add(&mut self, need: BenchNeed) {
        if !self.needs.contains(&need) {
            self.needs.push(need);
        }
    }

    fn add_ability(&mut self, ability: Ability) {
        if !self.apart {
            self.add(BenchNeed::Stand(ability));
        }
    }

    fn add_claim(&mut self, name: &str) {
        self.add(BenchNeed::Claim(ClaimedFeature::Name(name.to_owned())));
    }

    fn kind(&self, name: NameId) -> Option<&'a NameKind> {
        self.variant.names.get(name.0 as usize)
    }

    /// Whether a signal is a whole number, so that its bits are those of its value.
    fn is_whole(&self, signal: usize) -> bool {
        self.manual.device.signals.get(signal).is_some_and(|signal| signal.form == SignalForm::Whole)
    }

    fn steps(&mut self, steps: &'a [TrialStep], times: u64) {
        for step in steps {
            let outer = self.apart;
            self.apart |= !step.covers.is_empty();
            self.verb(&step.verb, times);
            self.apart = outer;
        }
    }

    fn verb(&mut self, verb: &'a Verb, times: u64) {
        match verb {
            Verb::Set(settings) => settings.iter().for_each(|setting| self.setting(setting, times)),
            Verb::Turn(turn) => self.turn(turn, times),
            Verb::Exchange(entries) => {
                for entry in entries {
                    let cycles = number(&entry.times).map_or(1, |cycles| cycles as u64);
                    self.wait(self.cycle, times.saturating_mul(cycles));
                    entry.set.iter().for_each(|setting| self.setting(setting, times));
                }
            }
            Verb::Connect { start, .. } => self.start(start),
            Verb::Disconnect { second } => self.connected &= *second,
            Verb::Write(access) => self.write(access, times),
            Verb::Read { access, .. } => self.read(access, times),
            Verb::Send { service, .. } => self.service(service, times),
            Verb::Expect { condition, hold, .. } => {
                self.condition(condition);
                match hold {
                    HoldTime::For(span) => self.span(span, times),
                    HoldTime::Until(condition) => self.condition(condition),
                    HoldTime::None => {}
                }
            }
            Verb::Wait(span) => {
                let (waits, really) = (self.waits, self.really);
                self.span(span, times);
                if !self.connected && self.waits.saturating_sub(waits) >= LONG {
                    self.really = really;
                }
            }
            Verb::Save(list) => {
                list.iter().flat_map(|(_, program)| program.names()).for_each(|name| self.read_name(name));
            }
            Verb::Block { steps, times: more, observe } => {
                let mut names = Vec::new();
                observe.iter().for_each(|observation| observed_names(observation, &mut |name| names.push(name)));
                names.into_iter().for_each(|name| self.read_name(name));
                self.steps(steps, times.saturating_mul(u64::from(*more)));
            }
            Verb::Either(readings) => readings.iter().for_each(|reading| self.steps(&reading.steps, times)),
        }
    }

    fn start(&mut self, start: &ConnectionStart) {
        self.connected = true;
        self.module = Some(start.module);
        self.cycle = start.cycle(&self.manual.device);
        let device = &self.manual.device;
        if let Some(module) = device.modules.get(start.module) {
            self.add(BenchNeed::Claim(ClaimedFeature::Module(module.name.clone())));
        }
        device.records.iter().filter(|record| record.start).for_each(|record| self.add_claim(&record.name));
        if start.instead.contains(&StartDeviation::SupervisorAccess) {
            self.add(BenchNeed::Consent(Consent::Alone));
        }
        if start.isochronous.is_some() {
            self.add(BenchNeed::BitTiming);
        }
        if let Some(baud) = start.baud {
            self.add(BenchNeed::Rate(baud));
        }
    }

    fn setting(&mut self, setting: &'a Setting, times: u64) {
        match self.kind(setting.name) {
            Some(NameKind::Stand(name)) => self.stand(*name, &setting.value),
            Some(NameKind::Signal { signal, low, width, .. }) => {
                let set = match &setting.value {
                    SetValue::Value(program) if self.is_whole(*signal) => program.constant().and_then(Value::as_whole),
                    SetValue::Value(_) => None,
                    SetValue::Word(_) | SetValue::Bytes(_) => None,
                };
                let all = u128::MAX >> (128 - (*width).clamp(1, 128));
                let ones = (set.map_or(all, |value| value as u128) & all) << low;
                let hit = |changed: &Changed| match changed {
                    Changed::Signal { signal: of, low, width } => {
                        of == signal && ones & ((u128::MAX >> (128 - (*width).clamp(1, 128))) << low) != 0
                    }
                    _ => false,
                };
                self.changes(hit, times);
            }
            Some(NameKind::OutputOctets(_)) => {
                let zero = matches!(&setting.value, SetValue::Bytes(octets) if octets.iter().all(|octet| *octet == 0));
                self.all_outputs(zero, times);
            }
            _ => {}
        }
    }

    /// Output data that are set as bytes; unless they are zero, they may set any output.
    fn all_outputs(&mut self, zero: bool, times: u64) {
        let outputs: Vec<usize> = self.outputs();
        let hit = |changed: &Changed| match changed {
            Changed::Signal { signal, .. } => !zero && outputs.contains(signal),
            _ => false,
        };
        self.changes(hit, times);
    }

    /// The output signals of the current module.
    fn outputs(&self) -> Vec<usize> {
        let device = &self.manual.device;
        let module = self.module.and_then(|module| device.modules.get(module));
        let submodules = module.into_iter().flat_map(|module| &module.submodules);
        submodules.filter_map(|index| device.submodules.get(*index)).flat_map(|of| of.outputs.clone()).collect()
    }

    /// Adds the consents for changes that `device.yaml` declares.
    fn changes(&mut self, hit: impl Fn(&Changed) -> bool, times: u64) {
        let changes = &self.manual.device.changes;
        if changes.position_reference.iter().any(&hit) {
            self.add(BenchNeed::Consent(Consent::PositionReference));
        }
        if changes.factory_reset.iter().any(&hit) {
            self.add(BenchNeed::Consent(Consent::FactoryReset));
        }
        if changes.firmware.iter().any(&hit) {
            self.add(BenchNeed::Consent(Consent::Firmware));
        }
        if changes.nvm_write.iter().any(&hit) {
            self.writes = self.writes.saturating_add(times);
        }
    }

    fn stand(&mut self, name: StandName, value: &SetValue) {
        let names = &self.manual.device.stand;
        let of = |list: &[(String, String)], index: usize| list.get(index).map(|(name, _)| name.clone());
        let ability = match name {
            StandName::Power => Some(Ability::Power),
            StandName::Link => Some(Ability::Link),
            StandName::Delivery => {
                self.add(BenchNeed::Consent(Consent::FactoryReset));
                if self.manual.device.bus.switches_go_back() {
                    // The switches are set back and are read at power-up.
                    for switch in &names.switches {
                        self.add_ability(Ability::Switch(switch.name.clone()));
                    }
                    self.add_ability(Ability::Power);
                } else {
                    // The reset clears the name, which is restored at the end.
                    self.add(BenchNeed::Consent(Consent::SetName));
                }
                Some(Ability::Delivery)
            }
            StandName::ShaftAcceleration => Some(Ability::Acceleration),
            StandName::ShaftCounts => Some(Ability::Place),
            StandName::SupplyVoltage => {
                self.supply(value, names.permitted_voltage);
                Some(Ability::Voltage)
            }
            StandName::Temperature => {
                self.supply(value, names.permitted_temperature);
                Some(Ability::Temperature)
            }
            StandName::Fault(index) => of(&names.faults, index).map(Ability::Fault),
            StandName::Button(index) => of(&names.buttons, index).map(Ability::Button),
            StandName::Switch(index) => names.switches.get(index).map(|switch| Ability::Switch(switch.name.clone())),
            StandName::ShaftSpeed => {
                let speed = match value {
                    SetValue::Value(program) => number(program),
                    SetValue::Word(_) | SetValue::Bytes(_) => None,
                };
                if speed != Some(0.0) {
                    self.speeds.push(speed.map(f64::abs));
                }
                None
            }
        };
        ability.into_iter().for_each(|ability| self.add_ability(ability));
    }

    /// Adds the consent for a value beyond what the manual permits. A value that is not constant may be beyond it.
    fn supply(&mut self, value: &SetValue, [lowest, highest]: [Option<f64>; 2]) {
        let value = match value {
            SetValue::Value(program) => number(program),
            SetValue::Word(_) | SetValue::Bytes(_) => None,
        };
        let is_beyond = match value {
            Some(value) => {
                lowest.is_some_and(|lowest| value < lowest) || highest.is_some_and(|highest| value > highest)
            }
            None => lowest.or(highest).is_some(),
        };
        if is_beyond {
            self.add(BenchNeed::Consent(Consent::Overstress));
        }
    }

    fn turn(&mut self, turn: &Turn, times: u64) {
        let rpm = number(&turn.rpm);
        let revolutions = match &turn.way {
            TurnAngle::Counts(way) => {
                self.ways.push(number(way).map(f64::abs));
                None
            }
            TurnAngle::Revolutions(way) => {
                self.ways.push(None);
                number(way)
            }
            TurnAngle::Degrees(way) => {
                self.ways.push(None);
                number(way).map(|way| way / 360.0)
            }
        };
        if let (Some(way), Some(rpm)) = (revolutions, rpm)
            && rpm > 0.0
        {
            self.wait(Duration::try_from_secs_f64(way.abs() / rpm * 60.0).unwrap_or(Duration::MAX), times);
        }
    }

    fn write(&mut self, access: &AcyclicAccess, times: u64) {
        for item in &access.items {
            self.touched(item.name);
            self.written(item.name, times);
        }
        if access.instead.iter().any(|instead| matches!(instead, RequestDeviation::Destination(_))) {
            self.add(BenchNeed::Virtual("a request to another station"));
        }
        self.raw_parameters(access, times);
    }

    fn read(&mut self, access: &AcyclicAccess, times: u64) {
        let changes = access.instead.contains(&RequestDeviation::Request(RequestId::CHANGE.0));
        for item in &access.items {
            self.touched(item.name);
            self.read_name(item.name);
            if changes {
                self.written(item.name, times);
            }
        }
        self.raw_parameters(access, times);
    }

    /// A parameter request whose bytes are given by the suite.
    fn raw_parameters(&mut self, access: &AcyclicAccess, times: u64) {
        if access.via == AccessChannel::Parameters {
            for instead in &access.instead {
                if let RequestDeviation::Bytes(octets) = instead {
                    self.parameter_request(octets, times);
                }
            }
        }
    }

    fn parameter_request(&mut self, octets: &[u8], times: u64) {
        let Ok(request) = ParameterRequest::parse(octets) else { return };
        if request.header.id == RequestId::CHANGE {
            request.addresses.iter().for_each(|address| self.parameter_written(address.number, times));
        }
    }

    /// Adds the claims and pages that an access requires.
    fn touched(&mut self, name: NameId) {
        let device = &self.manual.device;
        match self.kind(name) {
            Some(NameKind::Parameter { parameter: Some(parameter), .. }) => {
                if let Some(parameter) = device.parameters.get(*parameter) {
                    self.add_claim(&format!("P{}", parameter.number));
                }
            }
            Some(NameKind::Page { page, .. }) => self.page(*page),
            Some(NameKind::Record { record, .. }) => {
                if let Some(record) = device.records.get(*record) {
                    self.add_claim(&record.name);
                }
            }
            _ => {}
        }
    }

    /// Adds a page whose layout the manual does not print.
    fn page(&mut self, page: usize) {
        if let Some(page) = self.manual.device.pages.get(page).filter(|page| page.origin == Origin::Invented) {
            self.add(BenchNeed::Page(page.name.clone()));
        }
    }

    fn written(&mut self, name: NameId, times: u64) {
        match self.kind(name) {
            Some(NameKind::Parameter { number, .. }) => self.parameter_written(*number, times),
            Some(NameKind::Record { record, .. }) => {
                let record = *record;
                let kept = self.manual.device.records.get(record).is_some_and(|of| KEPT_RECORDS.contains(&of.index));
                let said = self.manual.device.changes.nvm_write.contains(&Changed::Record(record));
                self.changes(|changed| *changed == Changed::Record(record), times);
                if kept {
                    self.im_record(said, times);
                }
            }
            Some(NameKind::Station(StationName::Name)) => self.add(BenchNeed::Consent(Consent::SetName)),
            Some(NameKind::Station(_)) => self.add(BenchNeed::Consent(Consent::SetIp)),
            _ => {}
        }
    }

    /// Adds the consents for a write to one of I&M1 to I&M4; `said`: `device.yaml` declares that it writes the memory.
    fn im_record(&mut self, said: bool, times: u64) {
        self.add(BenchNeed::Consent(Consent::ImRecords));
        if !said {
            self.writes = self.writes.saturating_add(times);
        }
    }

    fn parameter_written(&mut self, number: u16, times: u64) {
        let device = &self.manual.device;
        let Some(index) = device.parameters.iter().position(|parameter| parameter.number == number) else { return };
        self.changes(|changed| *changed == Changed::Parameter(index), times);
        if device.parameters.get(index).is_some_and(|parameter| parameter.permanent) {
            self.writes = self.writes.saturating_add(times);
        }
    }

    fn service(&mut self, service: &AcyclicService, times: u64) {
        match service {
            AcyclicService::DcpReset { .. } => self.add(BenchNeed::Consent(Consent::FactoryReset)),
            AcyclicService::Lldp { .. } => self.add(BenchNeed::DirectCable),
            AcyclicService::Load { .. } => self.add(BenchNeed::Consent(Consent::Alone)),
            AcyclicService::HttpGet { page } => self.page(*page),
            AcyclicService::HttpPost { page, .. } => {
                self.page(*page);
                self.changes(|changed| *changed == Changed::Page(*page), times);
            }
            // A device that does not detect the damage accepts the name.
            AcyclicService::Broken(word) if word.starts_with("dcp") => self.add(BenchNeed::Consent(Consent::SetName)),
            // The slave stores its new address.
            AcyclicService::Dp(DpService::SetSlaveAddress { lock, .. }) => {
                self.add(BenchNeed::Consent(Consent::SetAddress));
                if *lock != 0 {
                    self.add(BenchNeed::Consent(Consent::LockAddress));
                }
                self.writes = self.writes.saturating_add(times);
            }
            AcyclicService::Dp(DpService::DataExchange(octets)) => {
                self.all_outputs(octets.iter().flatten().all(|octet| *octet == 0), times);
            }
            AcyclicService::Dp(DpService::Write { index, bytes, .. } | DpService::Ms2Write { index, bytes, .. })
                if u16::from(*index) == self.manual.device.parameter_access.index =>
            {
                self.parameter_request(bytes, times);
            }
            // Data after the header of CALL are written to I&M1 to I&M4.
            AcyclicService::Dp(DpService::Write { index, bytes, .. } | DpService::Ms2Write { index, bytes, .. })
                if *index == CALL_INDEX && bytes.len() > CALL_HEADER =>
            {
                self.im_record(false, times);
            }
            AcyclicService::RecordWrite { at, bytes } => self.record_written(at.index, bytes, times),
            AcyclicService::RecordsWrite(records) => {
                records.iter().for_each(|(at, bytes)| self.record_written(at.index, bytes, times));
            }
            AcyclicService::DcpSet { blocks } => dcp_consents(blocks).for_each(|consent| {
                self.add(BenchNeed::Consent(consent));
            }),
            _ => {}
        }
    }

    fn record_written(&mut self, index: u16, bytes: &[u8], times: u64) {
        if [self.manual.device.parameter_access.index, OLD_PARAMETER_ACCESS].contains(&index) {
            return self.parameter_request(bytes, times);
        }
        let kept = KEPT_RECORDS.contains(&index) || index == FAST_START_UP;
        let record = self.manual.device.records.iter().position(|record| record.index == index);
        let said = record.is_some_and(|of| self.manual.device.changes.nvm_write.contains(&Changed::Record(of)));
        self.changes(|changed| record.is_some_and(|of| *changed == Changed::Record(of)), times);
        if kept {
            self.im_record(said, times);
        }
    }

    fn condition(&mut self, condition: &Condition) {
        let mut names = Vec::new();
        condition.each_name(&mut |name| names.push(name));
        for part in &condition.parts {
            // The bytes of the input data contain all measured values.
            if let PartTest::Name(name, Matcher::Bytes(pattern)) = &part.test
                && pattern.exact().is_none()
            {
                names.push(*name);
            }
        }
        names.into_iter().for_each(|name| self.read_name(name));
    }

    fn read_name(&mut self, name: NameId) {
        let device = &self.manual.device;
        match self.kind(name) {
            Some(NameKind::Led(led)) => {
                if let Some((name, _)) = device.stand.leds.get(*led) {
                    self.add_ability(Ability::Led(name.clone()));
                }
            }
            Some(NameKind::Counter(counter)) => {
                if let Some((name, _)) = device.stand.counters.get(*counter) {
                    self.add_ability(Ability::Counter(name.clone()));
                }
            }
            Some(NameKind::Signal { signal, field: None, .. }) => {
                let measured = |of: &crate::device::DeviceSignal| {
                    of.from == crate::device::SignalSender::Device
                        && (of.position_in.is_some() || of.signed || of.fields.is_empty())
                };
                self.measures |= device.signals.get(*signal).is_some_and(measured);
            }
            Some(NameKind::InputOctets(_)) => self.measures = true,
            Some(NameKind::Event(event)) if event.is_lldp() => self.add(BenchNeed::DirectCable),
            Some(NameKind::Page { page, value }) => {
                let value = device.pages.get(*page).and_then(|page| page.shows.get(*value));
                self.measures |= value.is_some_and(|value| value.steps);
            }
            _ => {}
        }
    }

    fn span(&mut self, span: &TimeSpan, times: u64) {
        match span {
            TimeSpan::Time(time) => self.wait(*time, times),
            TimeSpan::Cycles(cycles) => self.wait(self.cycle, times.saturating_mul(*cycles)),
            TimeSpan::Computed(program) => match program.constant() {
                Some(Value::Time(nanos)) => {
                    self.wait(Duration::try_from_secs_f64(nanos.to_f64() / 1e9).unwrap_or(Duration::ZERO), times);
                }
                _ => self.wait(UNKNOWN_WAIT, times),
            },
        }
    }

    fn wait(&mut self, time: Duration, times: u64) {
        let all = time.saturating_mul(u32::try_from(times).unwrap_or(u32::MAX));
        self.waits = self.waits.saturating_add(all);
        self.really = self.really.saturating_add(all);
    }
}

/// The value of a constant program.
fn number(program: &Program) -> Option<f64> {
    match program.constant()? {
        Value::Number(number) => Some(number.to_f64()),
        value => value.as_whole().map(|whole| whole as f64),
    }
}

/// What a DCP Set with these blocks may change; blocks that cannot be read may change name and address.
fn dcp_consents(blocks: &[u8]) -> impl Iterator<Item = Consent> {
    let has = |option: u8, suboption: u8| blocks.windows(2).any(|pair| pair == [option, suboption]);
    let asked = [
        (has(2, 2), Consent::SetName),
        (has(1, 2) || has(1, 3), Consent::SetIp),
        (has(5, 5) || has(5, 6), Consent::FactoryReset),
    ];
    asked.into_iter().filter_map(|(is_asked, consent)| is_asked.then_some(consent))
}
