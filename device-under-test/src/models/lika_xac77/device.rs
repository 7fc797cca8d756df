//! The XAC77 as a PROFINET device stack sees it.

use super::live::{Faults, Live, Phase, Ram, Store};
use super::parameters::VENDOR_ID;
use super::{ACCESS_POINT_SUBSLOT, ENCODER_API, ENCODER_SLOT, TELEGRAM_SUBSLOT, Variant, names};
use crate::application::{
    Access, Application, ArKey, DiagnosisChange, Identity, Plug, RecordRefusal, ResetScope, StationData,
};
use crate::behaviour::Behaviour;
use crate::encoder::{Cell, PresetMode, Shaft};
use crate::profidrive::life_sign::Watch;
use crate::profidrive::parameters::{BadRequest, Manager};
use crate::profidrive::telegram::{self, Emitter};
use crate::profidrive::user_parameters::{self, UserParameters};
use alloc::format;
use alloc::vec::Vec;
use core::time::Duration;
use station::{StandAction, Time};

/// Record of the user parameters.
const USER_PARAMETERS: u16 = 0xBF00;
/// Record of the parameter access.
const PARAMETER_ACCESS: u16 = 0xB02E;
/// How long the encoder is silent after power-up; the manual does not say.
const BOOT: Duration = Duration::from_secs(2);
/// How long it takes from the end of the parameters to the first good data; the manual does not say.
const READY: Duration = Duration::from_millis(5);

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
            plugs: super::plugs(),
            shaft,
            faults,
            store,
            ram,
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
        match (access.api, access.slot, access.subslot) {
            (ENCODER_API, ENCODER_SLOT, ACCESS_POINT_SUBSLOT) => Ok(()),
            _ => Err(RecordRefusal::InvalidIndex),
        }
    }

    fn write_user_parameters(&mut self, access: Access, data: &[u8]) -> Result<(), RecordRefusal> {
        let rules = &self.behaviour.user_parameters;
        if self.ram.phase != access.ar.map_or(Phase::Alone, Phase::Parameters) || access.ar.is_none() {
            return Err(RecordRefusal::StateConflict);
        }
        if rules.checks_length && data.len() != user_parameters::OCTETS {
            return Err(RecordRefusal::WriteLength);
        }
        let mut octets = data.to_vec();
        octets.resize(user_parameters::OCTETS, 0);
        let parameters = UserParameters::parse(&octets).ok_or(RecordRefusal::WriteLength)?;
        if rules.takes_every_record || !self.ram.was_parametrized {
            self.ram.staged = parameters;
        }
        self.ram.was_parametrized = true;
        Ok(())
    }

    fn request_parameters(&mut self, now: Time, access: Access, data: &[u8]) -> Result<(), RecordRefusal> {
        let key = access.ar.ok_or(RecordRefusal::StateConflict)?;
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
        let keeps = self.behaviour.reset;
        if !keeps.keeps_offset {
            self.store.offset.replace(0);
            self.ram.measuring.offset = 0;
        }
        if !keeps.keeps_preset_value {
            self.store.preset_value.replace(0);
            self.ram.preset_value = 0;
        }
        self.ram.staged = (self.behaviour.user_parameters.default)(&self.variant.hardware);
        let mut live = self.live(now);
        live.parametrize();
        live.look_for_errors();
    }

    fn reset_station(&mut self) {
        let keeps = self.behaviour.reset;
        let before = self.store.station.stored().clone();
        let station = StationData {
            name: if keeps.keeps_name { before.name } else { Vec::new() },
            gateway: if keeps.keeps_gateway { before.gateway } else { [0; 4] },
            ..StationData::default()
        };
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
        self.ram.address = current.ip;
        let mut stored = stored.clone();
        if !self.behaviour.memory.stores_name {
            stored.name.clear();
        }
        if *self.store.station.stored() != stored {
            self.store.station.replace(stored);
        }
    }

    fn accepts_name(&self, name: &[u8]) -> bool {
        names::accepts(name, &self.behaviour.names)
    }

    fn factory_reset(&mut self, now: Time, scope: ResetScope) -> bool {
        self.advance(now);
        if self.behaviour.reset.refused_while_connected && self.ram.phase != Phase::Alone {
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
        let ram = Ram::new(now, hardware, &self.behaviour, &self.shaft, &self.store, self.faults);
        let before = core::mem::replace(&mut self.ram, ram);
        let keeps = self.behaviour.memory;
        if keeps.keeps_user_parameters {
            (self.ram.staged, self.ram.was_parametrized) = (before.staged, before.was_parametrized);
        }
        if keeps.keeps_position {
            let measuring = &mut self.ram.measuring;
            measuring.offset = measuring.preset(PresetMode::Absolute, before.measuring.shifted());
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
        now + READY
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
            USER_PARAMETERS => self.write_user_parameters(access, data),
            PARAMETER_ACCESS => self.request_parameters(now, access, data),
            _ => Err(RecordRefusal::InvalidIndex),
        }
    }

    fn read_record(&mut self, now: Time, access: Access, out: &mut Vec<u8>) -> Result<(), RecordRefusal> {
        self.advance(now);
        self.access(access)?;
        match access.index {
            USER_PARAMETERS => Err(RecordRefusal::AccessDenied),
            PARAMETER_ACCESS => {
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
            StandAction::Fault("commissioning", present) => {
                self.faults.commissioning = present;
                now
            }
            _ => return None,
        };
        self.advance(now);
        Some(done)
    }

    fn led(&mut self, _: Time, _: &str) -> Option<&'static str> {
        None
    }

    fn counter(&mut self, now: Time, name: &str) -> Option<u64> {
        self.advance(now);
        let store = &self.store;
        (name == "nvm_writes").then(|| store.offset.writes() + store.preset_value.writes() + store.station.writes())
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
