//! The encoder object as a PROFINET device stack sees it.

use super::names;
use super::places::{self, ENCODER_API, ENCODER_SLOT};
use super::{Faults, Live, Model, Phase, Ram, Store};
use crate::behaviour::{Behaviour, PowerUp};
use crate::encoder::{Cell, PresetMode, Shaft};
use crate::facts::{Cause, Facts, Reset, Variant};
use crate::hooks::{Lit, SubmoduleInputs};
use crate::profidrive::parameters::Responses;
use crate::profidrive::telegram::Outputs;
use alloc::format;
use alloc::vec::Vec;
use device_stack::profinet::{
    Access, Application, ArKey, DiagnosisChange, Identity, Plug, RecordRefusal, ResetScope, Seen, StationData,
};
use station::{StandAction, Time};
use wire::http::{Request, Response};

/// What one piece of a variant has of its own.
#[derive(Clone, Debug, Default)]
pub struct Piece {
    /// Its MAC address, of which the serial number is made.
    pub mac: [u8; 6],
    /// Where its shaft stands, in hardware steps.
    pub shaft: u64,
    /// The name and the addresses that it has stored.
    pub station: StationData,
}

/// An encoder of the encoder profile behind its PROFINET stack.
pub struct EncoderObject<M: Model> {
    pub(super) facts: &'static Facts,
    pub(super) model: M,
    pub(super) variant: &'static Variant,
    pub(super) behaviour: Behaviour,
    rules: M::Rules,
    identity: Identity,
    plugs: Vec<Plug>,
    pub(super) shaft: Shaft,
    pub(super) faults: Faults,
    pub(super) store: Store,
    pub(super) ram: Ram,
    /// The name and the addresses that come back with the next power-up.
    returns: Option<StationData>,
    /// The responses to parameter requests that wait to be fetched.
    pub(super) responses: Responses<ArKey>,
    powered: bool,
}

impl<M: Model> EncoderObject<M> {
    /// An encoder fresh from the factory but for its station, with power from the start of the run on.
    pub fn new(
        facts: &'static Facts,
        model: M,
        variant: &'static Variant,
        behaviour: Behaviour,
        rules: M::Rules,
        piece: Piece,
    ) -> EncoderObject<M> {
        let Piece { mac, shaft, station } = piece;
        let hardware = variant.hardware;
        let shaft = Shaft::new(hardware.steps_per_revolution, (shaft % hardware.range()) as i64);
        let faults = Faults::default();
        let store = Store { offset: Cell::new(0), preset_value: Cell::new(0), station: Cell::new(station) };
        let ram = Ram::new(Time::ZERO, facts, variant, &behaviour, &shaft, &store, &faults);
        EncoderObject {
            facts,
            model,
            variant,
            rules,
            identity: identity(facts, variant, mac),
            plugs: places::plugs(facts, variant, &behaviour.hooks),
            responses: Responses::default(),
            behaviour,
            shaft,
            faults,
            store,
            ram,
            returns: None,
            powered: true,
        }
    }

    /// What is the model's own.
    pub fn model(&self) -> &M {
        &self.model
    }

    /// The encoder at one instant.
    pub fn live(&mut self, now: Time) -> Live<'_, M> {
        Live {
            now,
            facts: self.facts,
            variant: self.variant,
            hardware: self.variant.hardware,
            behaviour: &self.behaviour,
            rules: &self.rules,
            shaft: &self.shaft,
            faults: &self.faults,
            store: &mut self.store,
            ram: &mut self.ram,
            model: &mut self.model,
        }
    }

    fn reset(&mut self, now: Time, reset: Reset) {
        if reset.application {
            self.reset_application(now);
        }
        if reset.station {
            self.reset_station();
        }
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
        self.ram.staged = self.delivered();
        let mut live = self.live(now);
        M::reset(&mut live);
        live.parametrize();
        live.look_for_errors();
    }

    fn reset_station(&mut self) {
        let rules = &self.behaviour.reset;
        let before = self.store.station.stored().clone();
        let station = (rules.station)(&before);
        self.returns = (!rules.lasts).then_some(before);
        self.ram.address = station.ip;
        self.ram.station.clone_from(&station);
        self.store.station.replace(station);
    }

    /// Brings a fault about (`present`) or takes it away; `false` if the encoder has none of this name.
    fn fault(&mut self, name: &str, present: bool) -> bool {
        let errors = self.facts.errors.iter().flat_map(|error| error.causes);
        let of_errors = errors.filter_map(|cause| match cause {
            Cause::Stand(known) => Some(*known),
            Cause::LifeSign | Cause::WrongParameters | Cause::Model => None,
        });
        let of_warnings = self.facts.warnings.iter().filter_map(|warning| warning.cause);
        let Some(known) = of_errors.chain(of_warnings).find(|known| *known == name) else { return false };
        self.faults.set(known, present);
        true
    }
}

fn identity(facts: &Facts, variant: &Variant, mac: [u8; 6]) -> Identity {
    let [.., a, b, c] = mac;
    Identity {
        vendor_id: facts.identity.vendor_id,
        device_id: facts.identity.device_id,
        station_type: variant.station_type,
        order_id: variant.order_id,
        serial_number: format!("{a:02X}{b:02X}{c:02X}"),
        ports: facts.identity.ports,
        hardware_revision: facts.identity.hardware_revision,
        software_revision: facts.identity.software_revision,
        revision_counter: 0,
        profile_id: ENCODER_API as u16,
        profile_specific_type: 0,
        im_version: [1, 1],
        im_supported: facts.identity.im_supported,
        boot_time: facts.timing.boot,
    }
}

impl<M: Model> Application for EncoderObject<M> {
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
        self.ram.station.clone_from(current);
        if current.ip != self.ram.address {
            self.ram.address_before = core::mem::replace(&mut self.ram.address, current.ip);
        }
        let stored = (self.behaviour.memory.stores_station)(stored.clone());
        if *self.store.station.stored() != stored {
            self.store.station.replace(stored);
        }
    }

    fn accepts_name(&self, name: &[u8]) -> bool {
        names::accepts(name)
    }

    fn factory_reset(&mut self, now: Time, scope: ResetScope) -> bool {
        self.advance(now);
        if (self.behaviour.reset.is_refused)(self.ram.phase != Phase::Alone) {
            return false;
        }
        let Some(reset) = (self.facts.resets)(scope) else { return false };
        self.reset(now, (self.behaviour.reset.clears)(reset));
        true
    }

    fn power_up(&mut self, now: Time) {
        if let Some(reset) = self.model.reset_at_power_up() {
            self.reset(now, reset);
        }
        if let Some(station) = self.returns.take() {
            self.store.station.replace(station);
        }
        let ram = Ram::new(now, self.facts, self.variant, &self.behaviour, &self.shaft, &self.store, &self.faults);
        let before = core::mem::replace(&mut self.ram, ram);
        let keeps = self.behaviour.memory;
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
        self.responses = Responses::default();
        self.powered = true;
        M::power_up(&mut self.live(now));
        self.behaviour.hooks.notify(|hooks| hooks.powered_up());
        self.advance(now);
    }

    fn power_down(&mut self, now: Time) {
        self.advance(now);
        M::power_down(&mut self.live(now));
        self.store.offset.power_down();
        self.store.preset_value.power_down();
        self.powered = false;
    }

    fn started(&mut self, now: Time, ar: ArKey, plugged: &[Plug]) {
        self.advance(now);
        self.start(now, ar, plugged);
    }

    fn parameter_end(&mut self, now: Time, ar: ArKey) -> Time {
        self.advance(now);
        self.end_parameters(now, ar)
    }

    fn ended(&mut self, now: Time, ar: ArKey) {
        self.advance(now);
        self.end(now, ar);
    }

    fn write_record(&mut self, now: Time, access: Access, data: &[u8]) -> Result<(), RecordRefusal> {
        self.advance(now);
        self.write(now, access, data)
    }

    fn read_record(&mut self, now: Time, access: Access, out: &mut Vec<u8>) -> Result<(), RecordRefusal> {
        self.advance(now);
        self.read(now, access, out)
    }

    fn outputs(&mut self, now: Time, slot: u16, subslot: u16, data: Option<&[u8]>) {
        self.advance(now);
        if slot == ENCODER_SLOT {
            self.live(now).take(subslot, data);
        }
    }

    fn frame(&mut self, now: Time) {
        self.advance(now);
        self.live(now).cycle();
    }

    fn inputs(&mut self, now: Time, slot: u16, subslot: u16, data: &mut [u8]) -> bool {
        let submodule = self.ram.submodules.iter().find(|one| (ENCODER_SLOT, one.subslot) == (slot, subslot));
        let Some(submodule) = submodule.copied() else { return true };
        let live = self.live(now);
        let image = &live.ram.before.sent;
        submodule.telegram.write(image, data);
        live.behaviour.hooks.apply(image.good, |hooks, are_good| {
            let right = SubmoduleInputs { octets: submodule.telegram.octets(image), are_good };
            let SubmoduleInputs { mut octets, are_good } = hooks.inputs(&live.view(), submodule, image, right);
            octets.resize(data.len(), 0);
            data.copy_from_slice(&octets);
            are_good
        })
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
                M::placed(&mut self.live(now));
                now
            }
            StandAction::Turn { steps, rpm } => self.shaft.turn_by(now, steps, rpm),
            StandAction::TurnRevolutions { revolutions, rpm } => self.shaft.turn_revolutions(now, revolutions, rpm),
            StandAction::Fault(name, present) if self.fault(name, present) => now,
            _ => M::act(&mut self.live(now), action)?,
        };
        self.advance(now);
        Some(done)
    }

    fn is_alive(&self) -> bool {
        self.model.is_alive()
    }

    fn led(&mut self, now: Time, name: &str, seen: &Seen) -> Option<&'static str> {
        let live = self.live(now);
        let right = M::led(&live, name, seen)?;
        let faults = live.fault_bits();
        let (has_wrong_parameters, has_record) = (live.ram.wrong_parameters, live.ram.has_record);
        let exchanged_for = live.ram.data_since.map(|since| now.since(since));
        let lit = Lit {
            name,
            seen,
            faults,
            has_wrong_parameters,
            has_record,
            had_warning: live.ram.had_warning,
            exchanged_for,
            has_outputs: live.ram.outputs != Outputs::default(),
        };
        Some(live.behaviour.hooks.apply(right, |hooks, right| hooks.led(&lit, right)))
    }

    fn counter(&mut self, now: Time, name: &str) -> Option<u64> {
        self.advance(now);
        let live = self.live(now);
        let store = &*live.store;
        match name {
            "nvm_writes" => Some(store.offset.writes() + store.preset_value.writes() + store.station.writes()),
            _ => M::counter(&live, name),
        }
    }

    fn serves_pages(&self) -> bool {
        self.model.serves_pages(&self.rules)
    }

    fn page(&mut self, now: Time, request: &Request) -> Response {
        self.advance(now);
        M::page(&mut self.live(now), request)
    }

    fn deadline(&self) -> Option<Time> {
        [self.store.offset.deadline(), self.store.preset_value.deadline(), self.model.deadline()]
            .into_iter()
            .flatten()
            .min()
    }

    fn advance(&mut self, now: Time) {
        if self.powered {
            self.live(now).advance();
        }
    }
}
