//! The XAC77 as a PROFINET device stack sees it.

use super::live::{Faults, Live, Phase, Ram, Store};
use super::parameters::VENDOR_ID;
use super::{ACCESS_POINT_SUBSLOT, ENCODER_API, ENCODER_SLOT, TELEGRAM_SUBSLOT, Variant, names};
use crate::application::{
    Access, Application, ArKey, DiagnosisChange, Identity, Plug, RecordRefusal, ResetScope, Seen, StationData,
};
use crate::behaviour::{Behaviour, PowerUp};
use crate::encoder::{Cell, PresetMode, Shaft};
use crate::profidrive::life_sign::Watch;
use crate::profidrive::parameters::{BadRequest, Manager};
use crate::profidrive::telegram::{self, Emitter};
use crate::profidrive::user_parameters::{self, UserParameters};
use alloc::format;
use alloc::vec::Vec;
use core::time::Duration;
use station::{StandAction, Time};
use wire::http::{Request, Response};

/// Record of the user parameters.
const USER_PARAMETERS: u16 = 0xBF00;
/// How long the encoder is silent after power-up; the manual does not say.
const BOOT: Duration = Duration::from_secs(2);
/// How long it takes from the end of the parameters to the first good data; the manual does not say.
const READY: Duration = Duration::from_millis(5);
/// Later than anybody waits for good data.
const NEVER: Duration = Duration::from_secs(3600);

/// A reference XAC77 behind its PROFINET stack.
pub struct Xac77 {
    variant: Variant,
    behaviour: Behaviour,
    identity: Identity,
    plugs: Vec<Plug>,
    shaft: Shaft,
    faults: Faults,
    store: Store,
    ram: Ram,
    /// The name and the addresses that come back with the next power-up.
    returns: Option<StationData>,
    manager: Manager<ArKey>,
    powered: bool,
}

impl Xac77 {
    /// An encoder fresh from the factory but for its station, with power from the start of the run on.
    ///
    /// `shaft` is where its shaft stands, in hardware steps; the serial number is made of `mac`.
    pub fn new(variant: Variant, behaviour: Behaviour, mac: [u8; 6], shaft: u64, station: StationData) -> Xac77 {
        let hardware = variant.hardware;
        let shaft = Shaft::new(hardware.steps_per_revolution, (shaft % hardware.range()) as i64);
        let faults = Faults::default();
        let store = Store { offset: Cell::new(0), preset_value: Cell::new(0), station: Cell::new(station) };
        let ram = Ram::new(Time::ZERO, hardware, &behaviour, &shaft, &store, faults);
        Xac77 {
            variant,
            behaviour,
            identity: identity(&variant, mac),
            plugs: super::plugs(&variant, &behaviour.telegram),
            shaft,
            faults,
            store,
            ram,
            returns: None,
            manager: Manager::new(behaviour.parameters),
            powered: true,
        }
    }

    fn live(&mut self, now: Time) -> Live<'_> {
        Live {
            now,
            hardware: self.variant.hardware,
            behaviour: &self.behaviour,
            shaft: &self.shaft,
            faults: self.faults,
            store: &mut self.store,
            ram: &mut self.ram,
        }
    }

    fn access(&self, access: Access) -> Result<(), RecordRefusal> {
        let asked = (access.api, access.slot, access.subslot);
        match (self.behaviour.records.answer_at)(asked, (ENCODER_API, ENCODER_SLOT, ACCESS_POINT_SUBSLOT)) {
            true => Ok(()),
            false => Err(RecordRefusal::InvalidIndex),
        }
    }

    fn write_user_parameters(&mut self, now: Time, access: Access, data: &[u8]) -> Result<(), RecordRefusal> {
        let rules = self.behaviour.user_parameters;
        if rules.checks_length && data.len() != user_parameters::OCTETS {
            return Err(RecordRefusal::WriteLength);
        }
        let mut octets = [0; user_parameters::OCTETS];
        octets.iter_mut().zip(data).for_each(|(octet, sent)| *octet = *sent);
        (rules.octets)(&mut octets);
        let parameters = UserParameters::parse(&octets).ok_or(RecordRefusal::WriteLength)?;
        if !(self.behaviour.records.go_with)(self.ram.telegram, parameters.class_4) {
            return Err(RecordRefusal::InvalidParameter);
        }
        if self.ram.phase != access.ar.map_or(Phase::Alone, Phase::Parameters) || access.ar.is_none() {
            if rules.measures_by_refused {
                self.ram.measuring.settings = parameters.settings(&self.variant.hardware, &rules);
            }
            return Err(RecordRefusal::StateConflict);
        }
        if rules.takes_every_record || !self.ram.was_parametrized {
            self.ram.staged = parameters;
        }
        self.ram.was_parametrized = true;
        if let Some(value) = (rules.preset_value)(&octets) {
            self.live(now).set_preset_value(value);
        }
        Ok(())
    }

    fn request_parameters(&mut self, now: Time, access: Access, data: &[u8]) -> Result<(), RecordRefusal> {
        let key = access.ar.ok_or(RecordRefusal::StateConflict)?;
        self.ram.held_up_until = now + self.behaviour.records.hold_up;
        let mut live = Live {
            now,
            hardware: self.variant.hardware,
            behaviour: &self.behaviour,
            shaft: &self.shaft,
            faults: self.faults,
            store: &mut self.store,
            ram: &mut self.ram,
        };
        self.manager.take(key, data, &mut live).map_err(|bad| match bad {
            BadRequest::TooShort => RecordRefusal::WriteLength,
            BadRequest::Count => RecordRefusal::InvalidRange,
        })
    }

    fn reset_application(&mut self, now: Time) {
        let rules = self.behaviour.reset;
        let offset = (rules.offset)(*self.store.offset.stored());
        self.store.offset.replace(offset);
        self.ram.measuring.offset = (rules.offset)(self.ram.measuring.offset);
        let preset_value = (rules.preset_value)(*self.store.preset_value.stored());
        self.store.preset_value.replace(preset_value);
        self.ram.preset_value = (rules.preset_value)(self.ram.preset_value);
        (rules.identity)(&mut self.identity);
        self.ram.staged = (self.behaviour.user_parameters.default)(&self.variant.hardware);
        let mut live = self.live(now);
        live.parametrize();
        live.look_for_errors();
    }

    fn reset_station(&mut self) {
        let rules = &self.behaviour.reset;
        let before = self.store.station.stored().clone();
        let station = (rules.station)(&before);
        self.returns = (!rules.lasts).then_some(before);
        self.ram.address = station.ip;
        self.store.station.replace(station);
    }
}

fn identity(variant: &Variant, mac: [u8; 6]) -> Identity {
    let [.., a, b, c] = mac;
    Identity {
        vendor_id: VENDOR_ID,
        // Not printed in the manual: invented for our reference device.
        device_id: 1,
        station_type: "LIKA ROTACOD",
        order_id: variant.order_id,
        serial_number: format!("{a:02X}{b:02X}{c:02X}"),
        ports: 1,
        hardware_revision: 1,
        software_revision: [b'V', 1, 1, 0],
        revision_counter: 0,
        profile_id: ENCODER_API as u16,
        profile_specific_type: 0,
        im_version: [1, 1],
        im_supported: 0,
        boot_time: BOOT,
    }
}

impl Application for Xac77 {
    fn identity(&self) -> &Identity {
        &self.identity
    }

    fn plugs(&self) -> &[Plug] {
        &self.plugs
    }

    fn stored_station(&self) -> StationData {
        self.store.station.stored().clone()
    }

    fn set_station(&mut self, now: Time, current: &StationData, stored: &StationData) {
        self.advance(now);
        if current.ip != self.ram.address {
            self.ram.address_before = core::mem::replace(&mut self.ram.address, current.ip);
        }
        let stored = (self.behaviour.memory.stores_station)(stored.clone());
        if *self.store.station.stored() != stored {
            self.store.station.replace(stored);
        }
    }

    fn accepts_name(&self, name: &[u8]) -> bool {
        names::accepts(name, &self.behaviour.names)
    }

    fn factory_reset(&mut self, now: Time, scope: ResetScope) -> bool {
        self.advance(now);
        if (self.behaviour.reset.is_refused)(self.ram.phase != Phase::Alone) {
            return false;
        }
        match scope {
            ResetScope::Factory | ResetScope::AllData | ResetScope::Device => {
                self.reset_application(now);
                self.reset_station();
                true
            }
            ResetScope::ApplicationData => {
                self.reset_application(now);
                true
            }
            ResetScope::Communication => {
                self.reset_station();
                true
            }
            ResetScope::Engineering | ResetScope::FactoryImage | ResetScope::Other(_) => false,
        }
    }

    fn power_up(&mut self, now: Time) {
        let hardware = self.variant.hardware;
        if let Some(station) = self.returns.take() {
            self.store.station.replace(station);
        }
        let ram = Ram::new(now, hardware, &self.behaviour, &self.shaft, &self.store, self.faults);
        let before = core::mem::replace(&mut self.ram, ram);
        self.ram.sensor.power_up(&before.sensor);
        let keeps = self.behaviour.memory;
        if keeps.keeps_user_parameters {
            (self.ram.staged, self.ram.was_parametrized) = (before.staged, before.was_parametrized);
        }
        let ram = &mut self.ram;
        let stored_offset = *self.store.offset.stored();
        let mut begin = PowerUp {
            was_saved: self.store.preset_value.writes() > 0,
            was_parked: before.sensor.is_parked(),
            offset_as_before: ram.measuring.preset(PresetMode::Absolute, before.measuring.shifted()),
            offset_of_preset_value: ram.measuring.preset(PresetMode::Absolute, ram.preset_value.into()),
            stored_offset,
            offset: ram.measuring.offset,
            is_saving: false,
            is_parked: false,
        };
        (keeps.at_power_up)(&mut begin);
        (ram.measuring.offset, ram.is_saving, ram.stays_parked) = (begin.offset, begin.is_saving, begin.is_parked);
        if begin.stored_offset != stored_offset {
            self.store.offset.replace(begin.stored_offset);
        }
        self.manager = Manager::new(self.behaviour.parameters);
        self.powered = true;
        self.advance(now);
    }

    fn power_down(&mut self, now: Time) {
        self.advance(now);
        self.store.offset.power_down();
        self.store.preset_value.power_down();
        self.powered = false;
    }

    fn started(&mut self, now: Time, ar: ArKey, plugged: &[Plug]) {
        self.advance(now);
        let ident = plugged.iter().find(|plug| (plug.slot, plug.subslot) == (ENCODER_SLOT, TELEGRAM_SUBSLOT));
        let in_use = |telegram: &&telegram::Telegram| {
            ident.is_some_and(|plug| plug.submodule_ident == u32::from(telegram.number))
        };
        let ram = &mut self.ram;
        ram.telegram = telegram::STANDARD.iter().find(in_use).unwrap_or(&telegram::STANDARD[0]);
        if self.behaviour.user_parameters.takes_every_record || !ram.was_parametrized {
            ram.staged = (self.behaviour.user_parameters.default)(&self.variant.hardware);
        }
        ram.phase = Phase::Parameters(ar);
        ram.web.was_connected = true;
        ram.outputs = None;
        ram.emitter = Emitter::new(self.behaviour.telegram);
        ram.watch = Watch::default();
        ram.wrong_parameters = false;
        let mut live = self.live(now);
        let causes = live.causes();
        live.ram.sensor.restart(&causes);
        live.look_for_errors();
    }

    fn parameter_end(&mut self, now: Time, ar: ArKey) -> Time {
        self.advance(now);
        if self.ram.phase != Phase::Parameters(ar) {
            return now;
        }
        self.ram.phase = Phase::Data(ar);
        let mut live = self.live(now);
        live.parametrize();
        live.look_for_errors();
        let starts = (live.behaviour.user_parameters.starts)(&live.ram.user);
        now + if starts { READY } else { NEVER }
    }

    fn ended(&mut self, now: Time, ar: ArKey) {
        self.advance(now);
        self.manager.forget(ar);
        if self.ram.phase == Phase::Parameters(ar) || self.ram.phase == Phase::Data(ar) {
            self.ram.phase = Phase::Alone;
            self.ram.outputs = None;
            self.ram.watch = Watch::default();
            let mut live = self.live(now);
            live.ram.sensor.cycle(Default::default(), false);
            live.look_for_errors();
        }
    }

    fn write_record(&mut self, now: Time, access: Access, data: &[u8]) -> Result<(), RecordRefusal> {
        self.advance(now);
        self.access(access)?;
        match access.index {
            USER_PARAMETERS => self.write_user_parameters(now, access, data),
            index if index == self.behaviour.records.parameter_access => self.request_parameters(now, access, data),
            _ => Err(RecordRefusal::InvalidIndex),
        }
    }

    fn read_record(&mut self, now: Time, access: Access, out: &mut Vec<u8>) -> Result<(), RecordRefusal> {
        self.advance(now);
        self.access(access)?;
        match access.index {
            USER_PARAMETERS => Err(RecordRefusal::AccessDenied),
            index if index == self.behaviour.records.parameter_access => {
                let response = access.ar.and_then(|key| self.manager.fetch(key));
                out.extend(response.ok_or(RecordRefusal::StateConflict)?);
                Ok(())
            }
            _ => Err(RecordRefusal::InvalidIndex),
        }
    }

    fn outputs(&mut self, now: Time, slot: u16, subslot: u16, data: Option<&[u8]>) {
        self.advance(now);
        if (slot, subslot) == (ENCODER_SLOT, TELEGRAM_SUBSLOT) {
            self.live(now).take(data);
        }
    }

    fn inputs(&mut self, now: Time, slot: u16, subslot: u16, data: &mut [u8]) -> bool {
        if (slot, subslot) != (ENCODER_SLOT, TELEGRAM_SUBSLOT) {
            return true;
        }
        self.advance(now);
        self.live(now).cycle(data)
    }

    fn next_diagnosis(&mut self) -> Option<DiagnosisChange> {
        self.ram.changes.pop_front()
    }

    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Option<Time> {
        self.advance(now);
        let done = match *action {
            StandAction::ShaftSpeed(rpm) => {
                self.shaft.turn(now, rpm);
                now
            }
            StandAction::ShaftRamp { rpm, acceleration } => {
                self.shaft.ramp(now, rpm, acceleration);
                now
            }
            StandAction::ShaftCounts(counts) => {
                // The shaft is put there and does not turn: neither velocity nor passage through the places between.
                let place = counts % self.variant.hardware.range();
                self.shaft.put(now, place as i64);
                self.ram.velocity.restart(now, &self.shaft);
                self.ram.measuring.put(place);
                now
            }
            StandAction::Turn { steps, rpm } => self.shaft.turn_by(now, steps, rpm),
            StandAction::TurnRevolutions { revolutions, rpm } => self.shaft.turn_revolutions(now, revolutions, rpm),
            StandAction::Fault("memory", present) => {
                self.faults.memory = present;
                now
            }
            StandAction::Fault("sensor", present) => {
                self.faults.sensor = present;
                now
            }
            StandAction::Fault("commissioning", present) => {
                self.faults.commissioning = present;
                now
            }
            _ => return None,
        };
        self.advance(now);
        Some(done)
    }

    fn led(&mut self, _: Time, _: &str, _: &Seen) -> Option<&'static str> {
        None
    }

    fn counter(&mut self, now: Time, name: &str) -> Option<u64> {
        self.advance(now);
        let store = &self.store;
        (name == "nvm_writes").then(|| store.offset.writes() + store.preset_value.writes() + store.station.writes())
    }

    fn serves_pages(&self) -> bool {
        self.ram.web.serves(&self.behaviour.web)
    }

    fn page(&mut self, now: Time, request: &Request) -> Response {
        self.advance(now);
        self.live(now).page(request)
    }

    fn deadline(&self) -> Option<Time> {
        [self.store.offset.deadline(), self.store.preset_value.deadline()].into_iter().flatten().min()
    }

    fn advance(&mut self, now: Time) {
        if self.powered {
            self.live(now).advance();
        }
    }
}
