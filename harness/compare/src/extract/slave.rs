//! The conversation on PROFIBUS: a start-up is Set_Prm and Chk_Cfg with their results; a diagnosis is requested, or fetched by the
//! master by itself.

use super::clock::{IsochronousClock, isochronous};
use super::requests::{field_value, fields};
use super::{ConversationState, fits_manual};
use crate::action::{ConnectAction, ControllerAction, span};
use crate::conversation::{AnsweredAction, SuiteValue};
use engine::{ISOCHRONOUS_GROUP, isochronous_times};
use judge::diagnosis;
use judge::image::{field_number, user_octets};
use judge::observe::{Address, CyclicStatus, Dp, Observation, ObservedAr};
use plain_text::hex;
use station::{Duration, Time};
use suite::device::{DeviceModule, DiagnosisName, UserPrmLayout};
use wire::profibus::global_control::{GlobalCommand, GlobalControl};
use wire::profibus::prm::{Dpv1, Dpv1Status1, Dpv1Status3, SetPrm, StationStatus};

/// The watchdog of a slave if nothing else is given.
const USUAL_WATCHDOG: Duration = Duration::from_secs(1);
/// The min TSDR that the harness's masters send, in bit times.
const USUAL_MIN_TSDR: u8 = 11;

/// The start-up of a slave.
#[derive(Debug, Default)]
pub(super) struct SlaveStartUp {
    open: Option<PendingStartUp>,
    /// Whether the last answer of Data_Exchange had high priority, so that the master fetches a diagnosis by itself.
    pending: bool,
    pub stands: bool,
    /// The clock that the connection follows.
    pub clock: Option<IsochronousClock>,
}

#[derive(Debug)]
struct PendingStartUp {
    at: Time,
    done: (Time, u64),
    parameters: Vec<u8>,
    configuration: Option<Vec<u8>>,
    diagnosis: Option<Vec<u8>>,
}

impl ConversationState<'_> {
    /// Takes in observations of PROFIBUS only.
    pub(super) fn slave(&mut self, ars: &[ObservedAr], observation: &Observation<'_>) {
        let is_pair = |of: &ConversationState<'_>, master: u8, station: u8| {
            of.pair == Some((Address::Fdl(master), Address::Fdl(station)))
        };
        self.clock_is_missed();
        match observation {
            Observation::Dp { event, .. } => match *event {
                Dp::Parameters { master, station, octets } => {
                    let Ok(prm) = SetPrm::parse(octets) else { return };
                    if self.pair.is_none() && Some(prm.ident) == self.device.ident() {
                        self.pair = Some((Address::Fdl(master), Address::Fdl(station)));
                    }
                    if is_pair(self, master, station) && prm.status.has(StationStatus::LOCK_REQ) {
                        self.failed();
                        let (at, parameters) = (self.now.0, octets.to_vec());
                        let open =
                            PendingStartUp { at, done: self.now, parameters, configuration: None, diagnosis: None };
                        self.start_up.open = Some(open);
                    }
                }
                Dp::Configuration { master, station, octets } if is_pair(self, master, station) => {
                    if let Some(open) = &mut self.start_up.open {
                        (open.configuration, open.done) = (Some(octets.to_vec()), self.now);
                    }
                }
                Dp::Diagnosis { master, station, octets, .. } if is_pair(self, master, station) => {
                    self.diagnosis(octets);
                }
                Dp::Control { station, control, .. } if self.start_up.stands => {
                    let addressed = [Some(Address::Fdl(station)), Some(Address::Fdl(127))];
                    if addressed.contains(&self.pair.map(|(_, device)| device)) || station == 127 {
                        self.control(control);
                    }
                }
                Dp::AddressGiven { master, station, address, ident }
                    if self.pair.is_none_or(|(_, device)| device == Address::Fdl(station)) =>
                {
                    let fields = format!("{{ new: {address}, ident: 0x{ident:04X} }}");
                    let service = "set_slave_address".to_owned();
                    self.ask(self.now.0, ControllerAction::Send { service, fields, answered: true }, Vec::new());
                    self.pair = Some((Address::Fdl(master), Address::Fdl(address)));
                }
                _ => {}
            },
            Observation::Connected { ar } => {
                let Some(ar) = ars.get(ar.0 as usize) else { return };
                let pair = (ar.controller.address, ar.device.address);
                if self.pair.is_none() && fits_manual(self.manual, ar) {
                    self.pair = Some(pair);
                }
                if self.pair == Some(pair) {
                    self.connected();
                }
            }
            Observation::Cyclic { status: CyclicStatus::Fdl { diagnosis_pending }, .. } => {
                self.start_up.pending |= *diagnosis_pending;
            }
            _ => {}
        }
    }

    fn diagnosis(&mut self, octets: &[u8]) {
        if let Some(open) = &mut self.start_up.open {
            (open.diagnosis, open.done) = (Some(octets.to_vec()), self.now);
            return;
        }
        let said = self.diagnosis_words(octets);
        let (time, frame) = self.now;
        if self.start_up.stands {
            for (name, value) in said.iter().filter(|(name, _)| name != "diag.bytes") {
                self.conversation.tracks.entry(name.clone()).or_default().take(time, frame, Some(value.clone()));
            }
        }
        if !std::mem::take(&mut self.start_up.pending) {
            self.ask(time, ControllerAction::Read(vec!["diag.bytes".to_owned()]), said);
        }
    }

    /// A diagnosis by names; its bytes come last.
    fn diagnosis_words(&self, octets: &[u8]) -> Vec<(String, SuiteValue)> {
        let device = self.device;
        let Some(slave) = device.profibus() else { return Vec::new() };
        let layout = &slave.diagnosis;
        let own = self.pair.and_then(|(master, _)| match master {
            Address::Fdl(number) => Some(number),
            Address::Mac(_) => None,
        });
        // Whether a block is an alarm depends on DP-V1, and the bytes show it anyway.
        let is_left_out = |name: &DiagnosisName| matches!(name, DiagnosisName::Bytes | DiagnosisName::Alarm(_));
        let named = DiagnosisName::words().map(|(_, name)| name).filter(|name| !is_left_out(name));
        let names = named.chain((0..layout.fields.len()).map(DiagnosisName::Field));
        let mut said = Vec::new();
        for name in names {
            let table = match name {
                DiagnosisName::Errors => layout.blocks.as_ref().map(|blocks| &blocks.table),
                DiagnosisName::Field(index) => layout.fields.get(index).and_then(|field| field.table.as_ref()),
                _ => None,
            };
            let word = |number: i64| {
                let known = table.and_then(|table| table.word(number)).map(str::to_owned);
                known.unwrap_or_else(|| number.to_string())
            };
            let value = match diagnosis::value(device, name, octets, own) {
                expression::Value::Bit(bit) => SuiteValue::number(bit.into(), 1, false),
                expression::Value::Word(number) => SuiteValue { text: word(number), number: Some(number.into()) },
                expression::Value::Set(numbers) => {
                    let words: Vec<String> = numbers.iter().map(|number| word(*number)).collect();
                    SuiteValue::word(format!("[{}]", words.join(", ")))
                }
                expression::Value::Bytes(octets) => SuiteValue::octets(&octets),
                value => match value.as_whole() {
                    Some(number) => SuiteValue::number(number, 32, number < 0),
                    None => continue,
                },
            };
            said.push((format!("diag.{}", device.diagnosis_name(name)), value));
        }
        said.push(("diag.bytes".to_owned(), SuiteValue::octets(octets)));
        said
    }

    fn control(&mut self, control: GlobalControl) {
        let bits = [
            ("clear", GlobalCommand::CLEAR_DATA),
            ("unfreeze", GlobalCommand::UNFREEZE),
            ("freeze", GlobalCommand::FREEZE),
            ("unsync", GlobalCommand::UNSYNC),
            ("sync", GlobalCommand::SYNC),
        ];
        let set = bits.iter().filter(|(_, bit)| control.command.0 & bit.0 != 0);
        let mut fields: Vec<String> = set.map(|(word, _)| format!("{word}: 1")).collect();
        // The clock of isochronous mode is a Global_Control without a command.
        if fields.is_empty() {
            return self.clock_came();
        }
        if control.groups != 0 {
            fields.push(format!("group: {}", control.groups));
        }
        let fields = format!("{{ {} }}", fields.join(", "));
        let service = "global_control".to_owned();
        self.ask(self.now.0, ControllerAction::Send { service, fields, answered: false }, Vec::new());
    }

    /// The start-up led to a connection: the first answer of Data_Exchange follows at once.
    fn connected(&mut self) {
        self.start_up.stands = true;
        self.start_up.pending = false;
        let Some(open) = self.start_up.open.take() else {
            self.left_out("a connection whose start-up is not in the capture");
            return;
        };
        let place = self.conversation.actions.len();
        let block = SetPrm::parse(&open.parameters).ok().as_ref().and_then(isochronous);
        self.start_up.clock = block.map(|(_, cycle)| IsochronousClock::new(cycle, self.now.0));
        self.push(open, None);
        self.open = Some((place, judge::observe::ArId(0)));
    }

    /// The start-up failed.
    fn failed(&mut self) {
        if let Some(open) = self.start_up.open.take() {
            self.push(open, Some("none"));
        }
    }

    fn push(&mut self, open: PendingStartUp, connection: Option<&str>) {
        let accepted = || SuiteValue::word("accepted");
        let mut answer = vec![("set_prm".to_owned(), accepted())];
        answer.extend(open.configuration.as_ref().map(|_| ("chk_cfg".to_owned(), accepted())));
        if let (Some(octets), Some(_)) = (&open.diagnosis, &open.configuration) {
            answer.extend(self.diagnosis_words(octets));
        }
        answer.extend(connection.map(|word| ("connection".to_owned(), SuiteValue::word(word))));
        let Some(ask) = self.connection(&open) else {
            self.left_out("an unreadable Set_Prm");
            return;
        };
        let (done, frame) = open.done;
        let mut asked = AnsweredAction::new(ask, (open.at, done), frame);
        answer.into_iter().for_each(|(name, value)| asked.part(name, value, frame));
        self.conversation.actions.push(asked);
    }

    fn connection(&self, open: &PendingStartUp) -> Option<ControllerAction> {
        let device = self.device;
        let prm = SetPrm::parse(&open.parameters).ok()?;
        let layout = &device.profibus()?.set_prm;
        let usual = layout.dpv1;
        let own = prm.dpv1().filter(|_| usual.is_some());
        let clock = isochronous(&prm).filter(|_| usual.is_some());
        let user = &user_octets(&prm, layout)[..];
        let record = device.records.get(UserPrmLayout::RECORD);
        let known = record.and_then(|record| fields(record, user));
        let number = |field: usize| {
            record.and_then(|record| record.fields.get(field)).and_then(|field| field_number(field, user))
        };
        let fits = |module: &&DeviceModule| {
            module.fixes().iter().filter(|(field, value)| number(*field) == Some(*value)).count()
                == module.fixes().len()
        };
        let configured = |module: &&DeviceModule| open.configuration.as_deref() == Some(module.cfg());
        let modules = || device.modules.iter();
        let module = modules().filter(configured).find(fits).or_else(|| modules().find(configured));
        let module = module.or_else(|| modules().find(fits)).or_else(|| modules().next())?;
        let mut connection = ConnectAction { module: module.name.clone(), ..ConnectAction::default() };
        let mut instead = |key: &str, value: String| connection.instead.push((key.to_owned(), value));
        if let Some(octets) = open.configuration.as_ref().filter(|octets| **octets != *module.cfg()) {
            instead("chk_cfg", format!("\"{}\"", hex(octets)));
        }
        if Some(prm.ident) != device.ident() {
            instead("ident", format!("0x{:04X}", prm.ident));
        }
        if prm.status.has(StationStatus::UNLOCK_REQ) {
            instead("lock", "both".to_owned());
        }
        for (bit, key) in [(StationStatus::FREEZE_REQ, "freeze_req"), (StationStatus::SYNC_REQ, "sync_req")] {
            if prm.status.has(bit) {
                instead(key, "1".to_owned());
            }
        }
        if prm.min_tsdr != USUAL_MIN_TSDR {
            instead("min_tsdr", prm.min_tsdr.to_string());
        }
        if prm.groups != clock.map_or(0, |_| ISOCHRONOUS_GROUP) {
            instead("groups", prm.groups.to_string());
        }
        match (known, record) {
            (Some(known), Some(record)) => {
                // The base of the watchdog follows from its time.
                let fine = Dpv1Status1::WD_BASE_1MS.0;
                let blocks = if clock.is_some() { Dpv1Status3::PRM_STRUCTURE | Dpv1Status3::ISOCHRONOUS } else { 0 };
                let plain = |[first, second, third]: [u8; 3]| [first & !fine, second, third & !blocks];
                if let Some(sent) = own.map(Dpv1::octets).filter(|sent| usual.map(plain) != Some(plain(*sent))) {
                    instead("dpv1", format!("\"{}\"", hex(&sent)));
                }
                for (index, field) in record.fields.iter().enumerate() {
                    let fixed = module.fixes().iter().find(|(of, _)| *of == index).map(|(_, value)| *value);
                    let usual = fixed.or_else(|| field.default.get(self.variant).copied());
                    if known.len() == record.fields.len() && number(index) != usual {
                        connection.settings.push((field.name.clone(), field_value(field, user)?.text));
                    }
                }
            }
            _ => instead("user_octets", format!("\"{}\"", hex(&prm.user))),
        }
        if let Some((times, cycle)) = clock {
            connection.settings.push(("isochronous".to_owned(), span(cycle)));
            if times != isochronous_times(cycle) {
                connection.instead.push(("user_octets".to_owned(), format!("\"{}\"", hex(&prm.user))));
            }
        }
        let base = own.filter(|dpv1| dpv1.status_1.reserved() == 0).map_or(10, Dpv1::watchdog_base_ms);
        let watchdog = prm.status.has(StationStatus::WD_ON).then(|| prm.watchdog_ms(base)).flatten();
        let usual = device.timing.watchdog.unwrap_or(USUAL_WATCHDOG);
        match watchdog.map(|millis| Duration::from_millis(millis.into())) {
            None => connection.settings.push(("watchdog".to_owned(), "none".to_owned())),
            Some(watchdog) if watchdog != usual => {
                connection.settings.push(("watchdog".to_owned(), span(watchdog)));
            }
            Some(_) => {}
        }
        Some(ControllerAction::Connect(connection))
    }

    pub(super) fn slave_end(&mut self) {
        self.failed();
    }
}
